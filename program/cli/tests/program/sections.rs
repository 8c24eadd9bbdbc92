//! Where an orbit crosses a section, in runs that go on, are killed or are paced.

use crate::events::{KEPLER, OSCILLATOR, rows, run};
use crate::support::{BODY, Place, wait_for};
use std::f64::consts::PI;

/// H = p²/2, q = t − 1 in steps that are exact in binary.
const FREE: &str = r#"[system]
variables   = ["q", "p"]
bracket     = { "q,p" = "1" }
convention  = "{x,H}"
hamiltonian = "p^2/2"
[method]
dynamics    = { name = "hamilton-jacobi", order = 2 }
time-step   = 0.25
[run]
initial = [-1, 1]
steps   = 40
section = { at = "q = 0" }
record  = { every = 1 }
"#;

/// Hénon and Heiles, energy 1/12 and some.
const HENON_HEILES: &str = r#"[system]
variables   = ["q1", "q2", "p1", "p2"]
bracket     = { "q1,p1" = "1", "q2,p2" = "1" }
convention  = "{x,H}"
hamiltonian = "(p1^2 + p2^2)/2 + (q1^2 + q2^2)/2 + q1^2*q2 - q2^3/3"
[method]
realization = "auto"
dynamics    = { name = "hamilton-jacobi", order = 8 }
time-step   = 0.1
[run]
initial = [0, 0.1, 0.3872983346207417, 0.1]
steps   = 4000
section = { at = "q1 = 0", direction = "up" }
record  = { every = 100, observables = ["energy"] }
"#;

/// The rows of `section.csv` of a run with this section.
fn crossings(scene: &str, section: &str) -> Vec<Vec<f64>> {
    let here = Place::with(scene);
    let said = run(&here, "run", &[&format!("run.section={section}")]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let rows = rows(&here.read("run/section.csv"));
    assert_eq!(said.json()["crossings"], rows.len());
    rows
}

#[test]
fn crossings_of_an_oscillator_come_at_their_times_with_the_methods_order() {
    let at = |order: u32, step: f64| -> Vec<Vec<f64>> {
        let scene = OSCILLATOR
            .replace("stop    = \"q < -0.5\"\n", "")
            .replace("order = 8", &format!("order = {order}"))
            .replace("= 0.1\n", &format!("= {step}\n"))
            .replace("= 400", &format!("= {}", (40.0 / step) as u64));
        crossings(&scene, "{ at = \"q = 0\" }")
    };
    // q = sin t begins on the section, and leaves it: not a crossing.
    for order in [2, 4, 6, 8] {
        let error = |step: f64| -> f64 {
            let rows = at(order, step);
            assert_eq!(rows.len(), 12);
            let errors = rows.iter().zip(1..).map(|(row, k)| {
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                assert!(
                    row[1].abs() < 1e-14 && (row[2] - sign).abs() < 1e-11,
                    "{row:?}"
                );
                (row[0] - PI * f64::from(k)).abs()
            });
            errors.fold(0.0, f64::max)
        };
        let (long, short) = (error(0.4), error(0.2));
        let slope = libm::log2(long / short);
        assert!(
            (slope - f64::from(order)).abs() < 0.3,
            "order {order}: {long:e}, {short:e}"
        );
    }
    for (row, k) in at(8, 0.1).iter().zip(1..) {
        assert!((row[0] - PI * f64::from(k)).abs() < 1e-10, "{row:?}");
    }
}

#[test]
fn a_rigid_body_crosses_the_middle_axis_at_equal_times() {
    let body = BODY
        .replace("{ name = \"karasev-truncated\", order = 4 }", "\"auto\"")
        .replace("order = 2", "order = 8")
        .replace("0.1", "0.02")
        .replace("steps   = 40", "steps   = 1000");
    let rows = crossings(&body, "{ at = \"x1 = 0\" }");
    // Landau and Lifshitz, Mechanics, section 37, with x1 the middle axis and rotation about x2: half a period is
    // 2 K(k)/rate, and K = π/(2 agm(1, k')).
    let (energy, square): (f64, f64) = (20.2, 19.0);
    let rate = libm::sqrt((0.75 - 1.0) * (square - energy * 1.25) / 0.9375);
    let modulus =
        (1.0 - 1.25) * (energy * 0.75 - square) / ((0.75 - 1.0) * (square - energy * 1.25));
    let (mut a, mut b) = (1.0, libm::sqrt(1.0 - modulus));
    while f64::abs(a - b) > 1e-15 {
        (a, b) = (f64::midpoint(a, b), libm::sqrt(a * b));
    }
    let half = PI / a / rate;
    assert_eq!(
        rows.len(),
        libm::floor((20.0 - rows[0][0]) / half) as usize + 1
    );
    for (row, k) in rows.iter().zip(0..) {
        assert!(
            (row[0] - rows[0][0] - f64::from(k) * half).abs() < 1e-10,
            "{k}: {row:?}"
        );
        assert!(
            row[1].abs() < 1e-14 && (row[5] - square).abs() < 1e-12,
            "{row:?}"
        );
    }
}

#[test]
fn a_section_of_henon_heiles_lies_on_it_with_the_energy() {
    let up = crossings(HENON_HEILES, "{ at = \"q1 = 0\", direction = \"up\" }");
    assert!(up.len() > 50, "{}", up.len());
    for row in &up {
        assert!(row[1].abs() < 1e-15 && row[3] > 0.0, "{row:?}");
        assert!((row[5] - up[0][5]).abs() < 1e-11, "{row:?}");
    }
    let down = crossings(HENON_HEILES, "{ at = \"q1 = 0\", direction = \"down\" }");
    assert!(down.iter().all(|row| row[3] < 0.0));
    // Each way to write the surface and its direction gives the same rows.
    let turned = crossings(HENON_HEILES, "{ at = \"0 = q1\", direction = \"up\" }");
    assert_eq!(turned, down);
    let mut both = [up, down].concat();
    both.sort_by(|a, b| a[0].total_cmp(&b[0]));
    assert_eq!(crossings(HENON_HEILES, "{ at = \"q1 = 0\" }"), both);
}

#[test]
fn what_touches_or_jumps_crosses_nothing() {
    let times = |at: &str| -> Vec<f64> {
        let rows = crossings(FREE, &format!("{{ at = \"{at}\" }}"));
        rows.iter().map(|row| row[0]).collect()
    };
    // A step that ends on the section: the crossing is there.
    assert_eq!(times("q = 0"), [1.0]);
    assert_eq!(times("q^3 = 0"), [1.0]);
    // A contact at a step's end, and one between: neither is a crossing.
    assert_eq!(times("q^2 = 0"), [0.0; 0]);
    assert_eq!(times("(q - 0.3)^2 = 0"), [0.0; 0]);
    // Two crossings in one step, and three.
    let near = |found: &[f64], exact: &[f64]| {
        assert_eq!(found.len(), exact.len(), "{found:?}");
        for (found, exact) in found.iter().zip(exact) {
            assert!((found - exact).abs() < 1e-13, "{found} {exact}");
        }
    };
    near(&times("(q - 0.3)*(q - 0.4) = 0"), &[1.3, 1.4]);
    near(
        &times("(q - 0.3)*(q - 0.4)*(q - 0.45) = 0"),
        &[1.3, 1.4, 1.45],
    );
    // A turn that comes up to zero but for 10⁻⁶, and one that comes past it by as much.
    assert_eq!(times("(q - 0.3)^2 + 1e-6 = 0"), [0.0; 0]);
    near(&times("(q - 0.3)^2 - 1e-6 = 0"), &[1.299, 1.301]);
    // Poles change the sign too.
    assert_eq!(times("1/(q - 0.3) = 0"), [0.0; 0]);
    let zeros = times("tan(q) = 0");
    assert_eq!(zeros.len(), 3, "{zeros:?}");
    for (zero, k) in zeros.iter().zip([0.0, 1.0, 2.0]) {
        assert!((zero - 1.0 - k * PI).abs() < 1e-14);
    }
}

/// q = sin t, by steps that turn by the whole angle: q is at c at t = arcsin c and π − arcsin c, and every 2π behind.
#[test]
fn crossings_within_one_step_come_at_their_times() {
    let scene = OSCILLATOR.replace("stop    = \"q < -0.5\"\n", "").replace(
        "dynamics    = { name = \"hamilton-jacobi\", order = 8 }",
        "stepper     = \"splitting\"",
    );
    for step in [0.1, 0.37, 0.9, 1.6] {
        let scene = scene
            .replace("= 0.1\n", &format!("= {step}\n"))
            .replace("= 400", &format!("= {}", (60.0 / step) as u64));
        let end = libm::floor(60.0 / step) * step;
        for level in [0.9999, 0.97, 0.2] {
            let (up, down) = (libm::asin(level), PI - libm::asin(level));
            for (direction, first) in [
                ("up", vec![up]),
                ("down", vec![down]),
                ("both", vec![up, down]),
            ] {
                let turns =
                    (0..20).flat_map(|k| first.iter().map(move |t| t + 2.0 * PI * f64::from(k)));
                let exact: Vec<f64> = turns.filter(|t| *t < end).collect();
                let section = format!("{{ at = \"q = {level}\", direction = \"{direction}\" }}");
                let found = crossings(&scene, &section);
                assert_eq!(found.len(), exact.len(), "{step} {level} {direction}");
                // The slope of q there is √(1 − c²), 0.014 at the least.
                for (row, exact) in found.iter().zip(exact) {
                    assert!(
                        (row[0] - exact).abs() < 1e-11,
                        "{step} {level}: {row:?} {exact}"
                    );
                }
            }
        }
    }
}

/// H = p²/2 + q²/2 − q³/10 near its right turning point: as many crossings by long steps as by short ones, at the same times.
#[test]
fn long_steps_find_the_crossings_that_short_ones_do() {
    let scene = OSCILLATOR
        .replace("stop    = \"q < -0.5\"\n", "")
        .replace("q^2/2\"", "q^2/2 - 0.1*q^3\"")
        .replace("[0, 1]", "[0, 1.5]");
    let at = |step: f64| -> Vec<Vec<f64>> {
        let scene = scene
            .replace("= 0.1\n", &format!("= {step}\n"))
            .replace("= 400", &format!("= {}", (100.8 / step).round()));
        crossings(&scene, "{ at = \"q = 1.9\", direction = \"up\" }")
    };
    let fine = at(0.05);
    assert_eq!(fine.len(), 14);
    let coarse = at(0.35);
    assert_eq!(coarse.len(), 14);
    for (one, other) in coarse.iter().zip(&fine) {
        // An energy error of 2e-7 moves the time of a crossing by much less than this, every turn anew.
        assert!((one[0] - other[0]).abs() < 1e-3, "{one:?} {other:?}");
    }
}

/// Whether runs end before, within or behind a step that crosses the section twice, they go on to the same bytes.
#[test]
fn crossings_within_one_step_are_taken_in_once() {
    let scene = OSCILLATOR
        .replace(
            "stop    = \"q < -0.5\"\n",
            "section = { at = \"q = 0.97\" }\n",
        )
        .replace("= 0.1\n", "= 0.9\n")
        .replace("= 400", "= 16");
    let here = Place::with(&scene);
    run(&here, "whole", &[]);
    let whole = here.read("whole/section.csv");
    assert_eq!(rows(&whole).len(), 6, "{whole}");
    for steps in 0..16 {
        let out = format!("after-{steps}");
        run(&here, &out, &[&format!("run.steps={steps}")]);
        run(&here, &out, &[]);
        assert_eq!(here.read(&format!("{out}/section.csv")), whole, "{steps}");
    }
}

/// q = t − 1: it is at c at t = 1 + c, where the run ends or stops there too.
#[test]
fn a_run_that_ends_on_the_section_crosses_it_there() {
    let here = Place::with(FREE);
    let rows_of = |set: &[&str]| {
        let said = run(&here, "run", set);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let rows = rows(&here.read("run/section.csv"));
        assert_eq!(said.json()["crossings"], rows.len());
        std::fs::remove_dir_all(here.path("run")).expect("a directory");
        rows
    };
    for k in 0..24_u32 {
        let c = f64::from(k) * 0.125 - 0.9 * f64::from(k % 3 == 2);
        let at = format!("run.section={{ at = \"q = {c}\" }}");
        let counts = |direction: &str| {
            let at = at.replace(" }", &format!(", direction = \"{direction}\" }}"));
            rows_of(&[&at, &format!("run.stop=\"q >= {c}\"")]).len()
        };
        for set in [
            vec![at.clone(), format!("run.stop=\"q >= {c}\"")],
            vec![at.clone(), format!("run.stop=\"q > {c}\"")],
            vec![
                at.clone(),
                format!("run.steps={}", ((1.0 + c) / 0.25).ceil()),
            ],
        ] {
            let set: Vec<&str> = set.iter().map(String::as_str).collect();
            let found = rows_of(&set);
            assert_eq!(found.len(), 1, "{set:?}");
            assert!(
                (found[0][0] - 1.0 - c).abs() <= 8.0 * f64::EPSILON,
                "{found:?}"
            );
        }
        assert_eq!((counts("up"), counts("down")), (1, 0), "q = {c}");
    }
    // It begins there and stays, or comes away: nothing is crossed.
    assert_eq!(rows_of(&["run.section={ at = \"p = 1\" }"]).len(), 0);
    assert_eq!(rows_of(&["run.section={ at = \"q = -1\" }"]).len(), 0);
}

/// The row at the end is none of those that a longer run has before its end.
#[test]
fn a_run_that_ended_on_the_section_and_goes_on_has_the_same_bytes() {
    let here = Place::with(FREE);
    let table = |steps: &str, out: &str| {
        let said = run(&here, out, &[steps]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        (here.read(&format!("{out}/section.csv")), said)
    };
    let (short, _) = table("run.steps=4", "run");
    assert_eq!(short.lines().count(), 2);
    let (again, said) = table("run.steps=4", "run");
    assert_eq!(
        (again, said.json()["crossings"].as_u64()),
        (short.clone(), Some(1))
    );
    let long = table("run.steps=9", "run").0;
    assert_eq!(long, table("run.steps=9", "whole").0);
    assert_eq!(long, short);
}

/// A driven system once a period, by steps of a part of the period that ends on the section or not, of the whole period too.
#[test]
fn steps_of_a_period_and_of_its_parts_cross_the_section_once_a_period() {
    const DRIVEN: &str = r#"[system]
variables   = ["q", "p"]
parameters  = { T = 1.3 }
bracket     = { "q,p" = "1" }
convention  = "{x,H}"
hamiltonian = "p^2/2 + 0.01*q*cos(2*pi*t/T)"
[method]
stepper     = "splitting"
time-step   = 1.3
[run]
initial = [0, 1]
steps   = 40
section = { at = "sin(pi*t/T) = 0" }
"#;
    let here = Place::with(DRIVEN);
    for parts in [1, 2, 3, 4, 5, 7, 20] {
        let step = format!("method.time-step={:?}", 1.3 / f64::from(parts));
        let steps = format!("run.steps={}", 40 * parts);
        for (direction, first, apart) in [("both", 1, 1), ("down", 1, 2), ("up", 2, 2)] {
            let out = format!("{parts}-{direction}");
            let section = format!("run.section.direction=\"{direction}\"");
            let said = run(&here, &out, &[&step, &steps, &section]);
            assert_eq!(said.code, Some(0), "{}", said.err);
            let found = rows(&here.read(&format!("{out}/section.csv")));
            // It begins on the section, where it crosses nothing; it ends there.
            let expected: Vec<f64> = (first..=40)
                .step_by(apart)
                .map(|k| 1.3 * f64::from(k))
                .collect();
            assert_eq!(found.len(), expected.len(), "{parts} {direction}");
            for (row, time) in found.iter().zip(expected) {
                // Where a step ends on the section to round-off the time is that of the step, known to so much of a step.
                let room = 160.0 * f64::from(parts) * f64::EPSILON * 1.3;
                assert!(
                    (row[0] - time).abs() <= room,
                    "{parts} {direction}: {row:?} {time}"
                );
            }
        }
    }
}

#[test]
fn a_section_of_a_run_that_goes_on_has_the_same_bytes() {
    let here = Place::with(HENON_HEILES);
    run(&here, "whole", &[]);
    // At a crossing, around it, and in between.
    let whole = here.read("whole/section.csv");
    let first = rows(&whole)[0][0];
    let step = libm::ceil(first / 0.1) as u64;
    for steps in [0, step - 1, step, step + 1, 1234] {
        let out = format!("after-{steps}");
        run(&here, &out, &[&format!("run.steps={steps}")]);
        run(&here, &out, &[]);
        for file in ["section.csv", "samples.csv", "windows.csv"] {
            let (a, b) = (format!("{out}/{file}"), format!("whole/{file}"));
            assert_eq!(here.read(&a), here.read(&b), "{a}");
        }
    }
    let again = run(&here, "whole", &[]);
    assert!(
        again.err.contains("nothing was computed or written"),
        "{}",
        again.err
    );
    // A row more or less is not the run's.
    here.write("whole/section.csv", &format!("{whole}0,0,0,0,0,0\n"));
    let refused = run(&here, "whole", &[]);
    assert!(
        refused.err.contains("section.csv cannot be resumed from"),
        "{}",
        refused.err
    );
}

#[test]
fn a_section_of_a_killed_run_has_the_same_bytes() {
    let scene = HENON_HEILES.replace("steps   = 4000", "steps   = 120000");
    let (whole, killed) = (Place::with(&scene), Place::with(&scene));
    run(&whole, "run", &[]);
    let arguments = [
        "run",
        "scene.toml",
        "--out",
        "run",
        "--checkpoint-every",
        "0.001",
        "--quiet",
    ];
    let mut child = killed
        .command(&arguments)
        .spawn()
        .expect("the program starts");
    let rows =
        || std::fs::read_to_string(killed.path("run/section.csv")).map_or(0, |t| t.lines().count());
    wait_for(&mut child, || rows() > 100, "a section of 100 rows");
    child.kill().expect("a child");
    child.wait().expect("a child");
    let said = run(&killed, "run", &[]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(whole.read("run/section.csv") == killed.read("run/section.csv"));
    assert_eq!(
        said.json()["crossings"],
        whole.read("run/section.csv").lines().count() - 1
    );
}

#[test]
fn a_paced_run_records_crossings_up_to_its_end() {
    // q2 = 0 at the pericentres t = 0, 2π, … and the apocentres π, 3π, …
    let section = "section = { at = \"q2 = 0\", direction = \"down\" }";
    let scene = KEPLER.replace("stop    = \"q1^2 + q2^2 >= 1\"", section);
    let here = Place::with(&scene);
    run(&here, "run", &[]);
    let whole = here.read("run/section.csv");
    let times: Vec<f64> = rows(&whole).iter().map(|row| row[0]).collect();
    assert_eq!(times.len(), 3);
    for (time, k) in times.iter().zip([1.0, 3.0, 5.0]) {
        assert!((time - k * PI).abs() < 1e-10, "{times:?}");
    }
    // An end shortly before a crossing and shortly behind it, within one step.
    for (until, count) in [("run.until=3.1415", 0), ("run.until=3.1416", 1)] {
        assert_eq!(run(&here, until, &[until]).json()["crossings"], count);
        run(&here, until, &[]);
        assert_eq!(here.read(&format!("{until}/section.csv")), whole, "{until}");
    }
    // A condition that stops it shortly before and behind.
    for (stop, count) in [("t > 3.1415", 0), ("t > 3.1416", 1)] {
        let told = run(&here, stop, &[&format!("run.stop=\"{stop}\"")]).json();
        assert_eq!(
            (&told["outcome"], &told["crossings"]),
            (&"stopped".into(), &count.into())
        );
    }
}

#[test]
fn a_section_is_told_and_drawn() {
    let here = Place::with(HENON_HEILES);
    let said = run(&here, "run", &[]);
    let count = rows(&here.read("run/section.csv")).len();
    let line = format!("section  {count} crossings of q1 = 0, upwards, in section.csv");
    assert!(said.err.contains(&line), "{}", said.err);
    let manifest: serde_json::Value =
        serde_json::from_str(&here.read("run/manifest.json")).expect("JSON");
    assert_eq!(manifest["crossings"], count);
    let page = here.read("run/report.html");
    assert!(page.contains("Section q1 = 0, upwards in (q2, p1)"));
    assert!(page.contains(&format!("{count} crossings of q1 = 0, upwards")));
    run(&here, "named", &["run.section.axes=[\"q2\", \"p2\"]"]);
    assert!(
        here.read("named/report.html")
            .contains("Section q1 = 0, upwards in (q2, p2)")
    );
    let header = here.read("run/section.csv");
    assert_eq!(header.lines().next(), Some("t,q1,q2,p1,p2,energy"));
}

#[test]
fn what_is_no_section_is_refused_where_it_stands() {
    let here = Place::with(FREE);
    for (section, said) in [
        ("{ at = \"q\" }", "`q` compares nothing: it has no ="),
        ("{ at = \"q > 0\" }", "two formulas with = between them"),
        ("{ at = \"q = p = 1\" }", "two formulas with = between them"),
        ("{ at = \"q == 1\" }", "two formulas with = between them"),
        ("{ at = \"q = z\" }", "unknown name `z`"),
        (
            "{ at = \"sqrt(q) = 1\" }",
            "`sqrt(q) = 1` has no value at the initial state",
        ),
        (
            "{ at = \"q = 0\", direction = \"upp\" }",
            "unknown direction `upp`",
        ),
        (
            "{ at = \"q = 0\", axes = [\"q\"] }",
            "axes has 1 entries, expected two names",
        ),
        (
            "{ at = \"q = 0\", axes = [\"q\", \"r\"] }",
            "`r` is not a column of section.csv",
        ),
        ("{ direction = \"up\" }", "section needs `at`"),
        (
            "{ at = \"q = 0\", axis = [] }",
            "unknown key `axis` in section",
        ),
        (
            "\"q = 0\"",
            "`section` must be a table such as { at = \"q1 = 0\", direction = \"up\" }",
        ),
    ] {
        let refused = run(&here, "run", &[&format!("run.section={section}")]);
        assert_eq!(refused.code, Some(3), "{section}: {}", refused.err);
        assert!(refused.err.contains(said), "{section}: {}", refused.err);
        assert!(
            refused.err.contains("scene.toml"),
            "{section}: {}",
            refused.err
        );
    }
    assert!(here.is_untouched());
}

//! What happens between two steps: where a run stops, and where it crosses a section.

use crate::support::{Place, Said};
use std::f64::consts::{FRAC_PI_2, PI};

/// q = sin t.
pub(crate) const OSCILLATOR: &str = r#"[system]
variables   = ["q", "p"]
bracket     = { "q,p" = "1" }
convention  = "{x,H}"
hamiltonian = "p^2/2 + q^2/2"
[method]
dynamics    = { name = "hamilton-jacobi", order = 8 }
time-step   = 0.1
[run]
initial = [0, 1]
steps   = 400
stop    = "q < -0.5"
record  = { every = 1 }
"#;

/// Enright and Pryce's D5, which comes to r = 1 where E = π/2 in t = E − 0.9 sin E.
pub(crate) const KEPLER: &str = r#"[system]
library = "kepler"
[method]
realization = "auto"
dynamics    = { name = "hamilton-jacobi", order = 8 }
pace        = "(q1^2 + q2^2)^0.75"
time-step   = 0.03
[run]
initial = [0.1, 0, 0, 4.358898943540674]
until   = 20
stop    = "q1^2 + q2^2 >= 1"
record  = { interval = 0.25, observables = ["energy"] }
"#;

pub(crate) fn run(here: &Place, out: &str, set: &[&str]) -> Said {
    let mut arguments = vec!["run", "scene.toml", "--out", out, "--json"];
    set.iter().for_each(|set| arguments.extend(["--set", set]));
    here.leafwise(&arguments)
}

/// The rows of a table of numbers behind its headings.
pub(crate) fn rows(text: &str) -> Vec<Vec<f64>> {
    let row = |line: &str| {
        let cells = line.split(',');
        cells.map(|cell| cell.parse().expect("a number")).collect()
    };
    text.lines().skip(1).map(row).collect()
}

fn time(told: &serde_json::Value) -> f64 {
    told["time"].as_f64().expect("a time")
}

#[test]
fn a_run_stops_where_its_method_comes_to_the_condition() {
    let here = Place::with(OSCILLATOR);
    // Order 2 turns by 2 atan(h/2) each step, a part s of a step by 2 atan(s h/2).
    let h = 0.1;
    let turn = |h: f64| 2.0 * libm::atan(h / 2.0);
    let angle = 7.0 * PI / 6.0;
    let whole = libm::floor(angle / turn(h));
    let expected = whole * h + 2.0 * libm::tan((angle - whole * turn(h)) / 2.0);
    let second = run(&here, "second", &["method.dynamics.order=2"]).json();
    assert!(
        (time(&second) - expected).abs() < 1e-13,
        "{}",
        time(&second)
    );
    // Higher orders come to the flow's own time as they should.
    for order in [4, 6, 8] {
        let error = |step: f64| {
            let order = format!("method.dynamics.order={order}");
            let step = format!("method.time-step={step}");
            let told = run(&here, &format!("{order}-{step}"), &[&order, &step]).json();
            assert_eq!(told["outcome"], "stopped");
            (time(&told) - angle).abs()
        };
        let (long, short) = (error(0.4), error(0.2));
        let slope = libm::log2(long / short);
        assert!(
            (slope - f64::from(order)).abs() < 0.3,
            "order {order}: {long:e}, {short:e}"
        );
    }
    let eighth = run(&here, "eighth", &[]).json();
    assert!((time(&eighth) - angle).abs() < 1e-10);
}

/// q = sin t comes past 0.9999 for 0.028 of the time, within one step, and to −0.9999 after another half turn.
#[test]
fn a_condition_that_holds_for_a_part_of_a_step_ends_the_run() {
    let scene = OSCILLATOR.replace(
        "dynamics    = { name = \"hamilton-jacobi\", order = 8 }",
        "stepper     = \"splitting\"",
    );
    let here = Place::with(&scene);
    let first = libm::asin(0.9999);
    let cases = [
        ("q > 0.9999", first),
        ("q < -0.9999", PI + first),
        ("q > 0.9999 or p < -0.99", first),
        ("q < -0.9999 and q > -2", PI + first),
    ];
    for step in [0.9, 1.5] {
        for (at, (stop, exact)) in cases.iter().enumerate() {
            let [stop, length] = [
                format!("run.stop=\"{stop}\""),
                format!("method.time-step={step}"),
            ];
            let out = format!("{at}-{step}");
            let said = run(&here, &out, &[&stop, &length]);
            assert_eq!(said.code, Some(0), "{}", said.err);
            let told = said.json();
            assert_eq!(told["outcome"], "stopped", "{stop} {step}");
            assert!((time(&told) - exact).abs() < 1e-11, "{stop} {step}: {told}");
            // Made longer at any step before, it stops with the same bytes.
            for steps in 1..=(exact / step) as u64 + 1 {
                let again = format!("{out}-{steps}");
                run(
                    &here,
                    &again,
                    &[&stop, &length, &format!("run.steps={steps}")],
                );
                run(&here, &again, &[&stop, &length]);
                let [one, other] =
                    [&out, &again].map(|out| here.read(&format!("{out}/samples.csv")));
                assert_eq!(one, other, "{stop} {step} {steps}");
            }
        }
    }
}

#[test]
fn the_last_sample_is_the_first_state_where_it_holds() {
    let here = Place::with(OSCILLATOR);
    let said = run(&here, "run", &[]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let told = said.json();
    assert_eq!(told["outcome"], "stopped");
    assert_eq!(told["stopped_by"], "q < -0.5");
    assert_eq!(told["steps"], 37);
    let rows = rows(&here.read("run/samples.csv"));
    // The initial state, 36 steps, and the state between this step and the next.
    assert_eq!(rows.len(), 38);
    let last = &rows[37];
    assert_eq!(last[0], time(&told));
    assert_eq!(told["final_state"], serde_json::json!([last[1], last[2]]));
    // It holds, and not by more than the round-off of a state.
    assert!(last[1] < -0.5 && last[1] > -0.5 - 4e-16, "{last:?}");
    assert!(rows[..37].iter().all(|row| row[1] >= -0.5));
    let manifest: serde_json::Value =
        serde_json::from_str(&here.read("run/manifest.json")).expect("JSON");
    assert_eq!(manifest["outcome"], "stopped");
    assert_eq!(manifest["stopped_by"], "q < -0.5");
    let page = here.read("run/report.html");
    assert!(page.contains("stopped at t = 3.66519142919: q &lt; -0.5, after 37 steps"));
    assert!(
        said.err.contains("stopped at t = 3.665191429: q < -0.5"),
        "{}",
        said.err
    );
}

#[test]
fn the_sequence_of_steps_does_not_know_of_the_condition() {
    let here = Place::with(OSCILLATOR);
    run(&here, "stopped", &[]);
    here.write(
        "scene.toml",
        &OSCILLATOR.replace("stop    = \"q < -0.5\"\n", ""),
    );
    run(&here, "free", &["run.steps=36"]);
    let stopped = here.read("stopped/samples.csv");
    assert!(stopped.starts_with(&here.read("free/samples.csv")));
}

#[test]
fn a_run_that_goes_on_stops_with_the_same_bytes_and_stays_so() {
    let here = Place::with(OSCILLATOR);
    run(&here, "whole", &[]);
    let said = run(&here, "longer", &["run.steps=20"]);
    assert_eq!(said.json()["outcome"], "done");
    run(&here, "longer", &[]);
    for file in ["samples.csv", "windows.csv"] {
        let (whole, longer) = (format!("whole/{file}"), format!("longer/{file}"));
        assert_eq!(here.read(&whole), here.read(&longer), "{file}");
    }
    // Neither the same scene nor one with more steps goes beyond.
    let before = here.read("whole/samples.csv");
    for steps in ["run.steps=400", "run.steps=4000"] {
        let again = run(&here, "whole", &[steps]);
        assert_eq!(again.code, Some(0), "{}", again.err);
        assert!(
            again.err.contains("it had already stopped there"),
            "{}",
            again.err
        );
        assert_eq!(again.json()["outcome"], "stopped");
        assert_eq!(here.read("whole/samples.csv"), before);
    }
    let fewer = run(&here, "whole", &["run.steps=10"]);
    assert!(fewer.err.contains("of 37 steps"), "{}", fewer.err);
}

#[test]
fn a_paced_run_stops_at_its_time_and_records_no_time_behind_it() {
    let here = Place::with(KEPLER);
    let told = run(&here, "run", &[]).json();
    assert_eq!(told["outcome"], "stopped");
    let expected = FRAC_PI_2 - 0.9;
    assert!((time(&told) - expected).abs() < 1e-10, "{}", time(&told));
    let whole = here.read("run/samples.csv");
    let times: Vec<f64> = rows(&whole).iter().map(|row| row[0]).collect();
    assert_eq!(times, [0.0, 0.25, 0.5, time(&told)]);
    // An end that lies before it, in the same step or in an earlier one, and then one behind it.
    for until in ["run.until=0.3", "run.until=0.6707963", "run.until=0.67"] {
        assert_eq!(run(&here, until, &[until]).json()["outcome"], "done");
        assert_eq!(run(&here, until, &[]).json()["outcome"], "stopped");
        assert_eq!(here.read(&format!("{until}/samples.csv")), whole, "{until}");
    }
    let less = run(&here, "run", &["run.until=0.5"]);
    assert_eq!(less.code, Some(2), "{}", less.err);
}

#[test]
fn a_condition_on_the_time_stops_at_that_time() {
    let driven = OSCILLATOR
        .replace("+ q^2/2\"", "+ q^2/2 + 0.1*q*cos(t)\"")
        .replace("q < -0.5", "1.05 <= t");
    let told = run(&Place::with(&driven), "run", &[]).json();
    assert_eq!(told["outcome"], "stopped");
    assert!((time(&told) - 1.05).abs() < 1e-15, "{}", time(&told));
    // Backwards in time too.
    let back = OSCILLATOR.replace("time-step   = 0.1", "time-step   = -0.1");
    let told = run(&Place::with(&back), "run", &[]).json();
    assert!((time(&told) + PI / 6.0).abs() < 1e-10, "{}", time(&told));
}

/// Conditions are those of `if`, here of sine and cosine.
#[test]
fn conditions_are_joined_as_in_choices() {
    for (stop, end) in [
        ("q < -0.5 and p < 0", 7.0 * PI / 6.0),
        ("q < -0.5 and p > 0.5", 5.0 * PI / 3.0),
        ("q < -2 or (p < -0.5)", 2.0 * PI / 3.0),
        ("not (q >= -0.5 and p >= -0.5)", 2.0 * PI / 3.0),
        ("-5 < p < 0", FRAC_PI_2),
        ("max(p, q - 1, -3) < -0.5", 5.0 * PI / 6.0),
    ] {
        let scene = OSCILLATOR.replace("q < -0.5", stop);
        let told = run(&Place::with(&scene), "run", &[]).json();
        assert_eq!(told["outcome"], "stopped", "{stop}");
        assert!((time(&told) - end).abs() < 1e-10, "{stop}: {}", time(&told));
    }
}

#[test]
fn what_is_no_condition_is_refused_where_it_stands() {
    let here = Place::with(OSCILLATOR);
    for (stop, said) in [
        ("q", "`q` compares nothing: it has no <, <=, >, >="),
        (
            "q = 1",
            "two formulas with one of <, <=, >, >= between them",
        ),
        (
            "q == 1",
            "`q == 1` holds only at single points, which steps pass over",
        ),
        ("q < -1 or not", "the formula ends where"),
        ("(q < -1", "the formula ends where"),
        (
            "q => 1",
            "two formulas with one of <, <=, >, >= between them",
        ),
        ("q > radius", "unknown name `radius`"),
        ("q >", "the formula ends where"),
        ("> 1", "expected a number, a name or `(`, found `>`"),
        (
            "q < 5",
            "`q < 5` holds at the initial state: the run would make no step",
        ),
        ("ln(q - 1) > 2", "has no value at the initial state"),
        (
            "t > 1",
            "t is the time where the Hamiltonian, a one-form, a force or a pace names it",
        ),
    ] {
        let refused = run(&here, "run", &[&format!("run.stop=\"{stop}\"")]);
        assert_eq!(refused.code, Some(3), "{stop}: {}", refused.err);
        assert!(refused.err.contains(said), "{stop}: {}", refused.err);
        assert!(
            refused.err.contains(&format!("stop    = \"{stop}\"")),
            "{}",
            refused.err
        );
    }
    let refused = run(&here, "run", &["run.stop=1"]);
    assert!(refused.err.contains("must be a string"), "{}", refused.err);
    assert!(here.is_untouched());
    // Of a name, the place in the whole text.
    let refused = run(&here, "run", &["run.stop=\"q > radius\""]);
    assert!(refused.err.contains("scene.toml:12:16"), "{}", refused.err);
}

#[test]
fn a_condition_that_loses_its_value_ends_the_run_with_its_name() {
    let here = Place::with(&OSCILLATOR.replace("q < -0.5", "sqrt(q + 0.5) < 0.01"));
    let said = run(&here, "run", &[]);
    assert_eq!(said.code, Some(1));
    let message = "`sqrt(q + 0.5) < 0.01` has no finite value at this state";
    assert!(said.err.contains(message), "{}", said.err);
}

#[test]
fn where_no_single_run_stops_a_condition_is_refused() {
    let here = Place::with(OSCILLATOR);
    for (command, said) in [
        ("compare", "methods are not compared with a `stop`"),
        ("tune", "methods are not compared with a `stop`"),
    ] {
        let mut arguments = vec![command, "scene.toml"];
        if command == "tune" {
            arguments.extend(["--error", "1e-6"]);
        }
        let refused = here.leafwise(&arguments);
        assert_ne!(refused.code, Some(0), "{command}");
        assert!(refused.err.contains(said), "{command}: {}", refused.err);
        assert!(
            refused.err.contains("scene.toml:12"),
            "{command}: {}",
            refused.err
        );
    }
}

/// A chain of a thousand oscillators in one mode: q_i = sin(2πi/N) cos(ωt)/10 with ω = 2 sin(π/N).
const CHAIN: &str = r#"[system]
families    = { q = 1000, p = 1000 }
bracket     = { "q[i],p[i]" = "-1" }
hamiltonian = "sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2)"
[method]
stepper     = "splitting"
composition = "blanes-moan-6"
time-step   = 0.5
[run]
initial = { "q[i]" = "0.1*sin(2*pi*i/N)", "p[i]" = "0" }
steps   = 1700
record  = { every = 100, states = ["q[250]", "p[250]"] }
"#;

/// A long lattice is watched as a short one is: conditions and sections that name sites or sum over them, samples at any times.
#[test]
fn a_long_lattice_stops_crosses_and_is_sampled_between_its_steps() {
    let w = 2.0 * libm::sin(PI / 1000.0);
    let third = std::f64::consts::FRAC_PI_3;
    // Σ p² = N/2 (ω sin ωt/10)².
    let half = 0.5 * 1000.0 * 0.01 * w * w * 0.5;
    let whole = format!("run.stop=\"sum(i, p[i]^2) > {half:?}\"");
    let stops = [
        ("run.stop=\"q[250] < 0.05\"", third / w),
        (whole.as_str(), std::f64::consts::FRAC_PI_4 / w),
    ];
    for (stop, exact) in stops {
        let here = Place::with(CHAIN);
        let said = run(&here, "stopped", &[stop]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let told = said.json();
        assert_eq!(told["outcome"], "stopped");
        // A method of order 6, whose error in this slow mode is far below round-off of the time.
        assert!((time(&told) - exact).abs() < 1e-9, "{stop}: {told}");
    }
    let here = Place::with(CHAIN);
    let set = [
        "run.section={ at = \"q[250] = 0\" }",
        "run.record={ times = [33.3, 100.1, 500], states = [\"q[250]\", \"p[250]\"] }",
    ];
    let said = run(&here, "watched", &set);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let crossed = rows(&here.read("watched/section.csv"));
    let quarter = FRAC_PI_2 / w;
    assert_eq!(crossed.len(), 2, "{crossed:?}");
    for (row, exact) in crossed.iter().zip([quarter, 3.0 * quarter]) {
        assert!((row[0] - exact).abs() < 1e-8, "{row:?}, {exact}");
    }
    let samples = rows(&here.read("watched/samples.csv"));
    let times: Vec<f64> = samples.iter().map(|row| row[0]).collect();
    assert_eq!(times, [0.0, 33.3, 100.1, 500.0, 850.0]);
    for row in samples {
        let exact = 0.1 * libm::cos(w * row[0]);
        assert!((row[1] - exact).abs() < 1e-12, "{row:?}");
    }
    // A fast mode, q = ±cos(2t)/10, in steps of half a radian, which pass over its turning points.
    let set = [
        "run.initial={ \"q[i]\" = \"0.1*cos(pi*i)\", \"p[i]\" = \"0\" }",
        "run.section={ at = \"q[250] = 0.099\" }",
        "run.steps=40",
        "run.record={ every = 40, states = [\"q[250]\"] }",
        "method.time-step=0.25",
    ];
    let said = run(&here, "turned", &set);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let crossed = rows(&here.read("turned/section.csv"));
    let angle = libm::acos(0.99);
    let turns = (0..4).flat_map(|k| {
        [
            PI * f64::from(k) - 0.5 * angle,
            PI * f64::from(k) + 0.5 * angle,
        ]
    });
    let exact: Vec<f64> = turns.filter(|t| *t > 0.0 && *t < 10.0).collect();
    assert_eq!(crossed.len(), exact.len(), "{crossed:?}");
    for (row, exact) in crossed.iter().zip(exact) {
        // Order 6 at half a radian a step.
        assert!((row[0] - exact).abs() < 1e-3, "{row:?}, {exact}");
    }
    // What to write in its place is said where it stands, and serves.
    let refused = run(&here, "timed", &["run.stop=\"t > 5\""]);
    assert_eq!(refused.code, Some(3), "{}", refused.err);
    let said = "leave t out of `stop`: a run ends at a time by `until` in the place of `steps`";
    assert!(refused.err.contains(said), "{}", refused.err);
    let absent = run(&here, "absent", &["run.stop=\"q[1000] > 1\""]);
    assert_eq!(absent.code, Some(3), "{}", absent.err);
    assert!(absent.err.contains("q[0] to q[999]"), "{}", absent.err);
}

/// q = sin(t + φ): a member that begins at q₀ is lost at t = asin 0.9 − asin q₀.
#[test]
fn an_ensemble_tells_its_losses_and_draws_its_section() {
    let scene = OSCILLATOR
        .replace("q < -0.5", "q > 0.9")
        .replace("[0, 1]", "[0, 0.95]")
        .replace(
            "record  = { every = 1 }\n",
            "section = { at = \"p = 0.7\", direction = \"down\" }\n",
        );
    let ensemble = "[ensemble]\nmembers = 40\ninitial = { box = [0, 0.15] }\nfinal-states = \"csv\"\n\
                    record = { every = 100 }\n";
    let here = Place::with(&format!("{scene}{ensemble}"));
    let said = here.leafwise(&["ensemble", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let told = said.json();
    let states = here.read("runs/scene-ensemble/final_states.csv");
    assert!(states.starts_with("member,outcome,t,q,p,"), "{states}");
    let mut stopped = 0;
    for line in states.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |at: usize| cells[at].parse::<f64>().expect("a number");
        // Behind the state stand the energy and the initial state, q = 0 and p.
        let (t, p) = (number(2), number(7));
        if p > 0.9 {
            stopped += 1;
            assert_eq!(cells[1], "stopped", "{line}");
            // Order 8: an error far below h⁸ after a quarter of a turn.
            assert!((t - libm::asin(0.9 / p)).abs() < 1e-10, "{line}");
        } else {
            assert_eq!((cells[1], t), ("done", 40.0), "{line}");
        }
    }
    assert!(stopped > 5 && stopped < 35, "{stopped}");
    assert_eq!(told["stopped"], stopped);
    assert_eq!(told["stopped_by"], "q > 0.9");
    let losses = told["losses"].as_array().expect("a list");
    assert_eq!(losses.last().expect("the end")["stopped"], stopped);
    said.says(&[
        &format!("{stopped} of 40 members by q > 0.9"),
        "with 95 % confidence, in losses.csv",
        "crossings of p = 0.7, downwards, in section.csv",
    ]);
    let count = here.read("runs/scene-ensemble/section.csv").lines().count() - 1;
    assert_eq!(told["crossings"], count);
    // Steps of 0.9, in which many members are beyond 0.9 for less than a step, lose and find the same ones.
    let long = [
        "--set",
        "method.time-step=0.9",
        "--set",
        "run.steps=44",
        "--out",
        "long",
    ];
    let said = here.leafwise(&[&["ensemble", "scene.toml", "--json"][..], &long].concat());
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert_eq!(said.json()["stopped"], stopped);
    let page = here.read("runs/scene-ensemble/report.html");
    for heading in ["Stopped by q &gt; 0.9", "Section p = 0.7, downwards in"] {
        assert!(page.contains(heading), "{heading}");
    }
}

#[test]
fn a_condition_may_hold_a_double_sum() {
    // q = (t, 2 t, 3 t): the sum over pairs is 11 t², which comes to 2 at t = sqrt(2/11).
    let here = Place::with(
        r#"[system]
families    = { q = 3, p = 3 }
bracket     = { "q[i],p[i]" = "1" }
convention  = "{x,H}"
hamiltonian = "p[0] + 2*p[1] + 3*p[2]"
[method]
dynamics    = "hamilton-jacobi"
time-step   = 0.1
[run]
initial = [0, 0, 0, 0, 0, 0]
steps   = 20
stop    = "sum(i<j, q[i]*q[j]) >= 2"
record  = { every = 1 }
"#,
    );
    let stopped = run(&here, "stopped", &[]).json();
    let expected = libm::sqrt(2.0 / 11.0);
    let told = time(&stopped);
    assert!((told - expected).abs() < 1e-13, "{told} {expected}");
}

/// A run that a condition has ended behind an event, or before one in the same step, is the same run when it is asked for again.
#[test]
fn a_stopped_run_with_events_that_act_stays_as_it_is() {
    for stop in ["p^2/2 + q < 1e-3", "p > 0", "q < 0.005", "q < 0.5"] {
        let scene = format!(
            r#"[system]
variables   = ["q", "p"]
bracket     = "canonical"
hamiltonian = "p^2/2 + q"
[method]
stepper   = "splitting"
time-step = 0.05
[run]
initial = [1, 0]
steps   = 600
section = {{ at = "q = 0", direction = "down", set = {{ p = "-0.9*p" }} }}
stop    = "{stop}"
"#
        );
        let here = Place::with(&scene);
        let told = |run: &str| {
            let said = here.leafwise(&["run", "scene.toml", "--json", "--out", run]);
            assert_eq!(said.code, Some(0), "{stop}: {}", said.err);
            let said = said.json();
            (
                said["outcome"].clone(),
                said["time"].clone(),
                said["final_state"].clone(),
            )
        };
        let first = told("run");
        assert_eq!(first.0, "stopped", "{stop}");
        let samples = here.read("run/samples.csv");
        assert_eq!(told("run"), first, "{stop}");
        assert_eq!(here.read("run/samples.csv"), samples, "{stop}");
        // With more steps it is stopped where it was.
        here.write(
            "scene.toml",
            &scene.replace("steps   = 600", "steps   = 700"),
        );
        assert_eq!(told("run"), first, "{stop}");
        assert_eq!(here.read("run/samples.csv"), samples, "{stop}");
    }
}

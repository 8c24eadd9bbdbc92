//! Scenes whose Hamiltonian names the time: nothing outside shows the coordinates behind it.

use crate::support::Place;

/// x'' = -x - 0.1 cos t.
const DRIVEN: &str = r#"[system]
variables   = ["q", "p"]
bracket     = { "q,p" = "1" }
convention  = "{x,H}"
hamiltonian = "p^2/2 + q^2/2 + 0.1*q*cos(t)"
[method]
dynamics    = { name = "hamilton-jacobi", order = 4 }
time-step   = 0.1
[run]
initial = [1, 0.5]
steps   = 40
record  = { every = 4, observables = ["energy", "q - t"] }
"#;

/// The rows of a table of numbers behind its headings.
fn rows(text: &str) -> Vec<Vec<f64>> {
    let row = |line: &str| {
        let cells = line.split(',');
        cells.map(|cell| cell.parse().expect("a number")).collect()
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn a_run_shows_the_scenes_own_coordinates_alone() {
    let here = Place::with(DRIVEN);
    let told = here
        .leafwise(&["run", "scene.toml", "--out", "run", "--json"])
        .json();
    assert_eq!(told["outcome"], "done");
    assert_eq!(told["final_state"].as_array().map(Vec::len), Some(2));
    let samples = here.read("run/samples.csv");
    assert_eq!(samples.lines().next(), Some("t,q,p,energy,q - t"));
    let rows = rows(&samples);
    assert_eq!(rows.len(), 11);
    for row in &rows {
        assert_eq!(row[4], row[1] - row[0], "an observable has the time");
        // The balance: order 4 at steps of 0.1 keeps it to 1e-6.
        assert!((row[3] - 0.725).abs() < 1e-6, "{row:?}");
    }
    assert!(!here.path("run/final_state.bin").exists());
    let manifest: serde_json::Value =
        serde_json::from_str(&here.read("run/manifest.json")).expect("JSON");
    assert_eq!(manifest["dimension"], 2);
    assert_eq!(manifest["variables"], serde_json::json!(["q", "p"]));
    assert_eq!(manifest["initial"], serde_json::json!([1.0, 0.5]));
    assert_eq!(manifest["tensor"], "constant");
    let motion = here.leafwise(&["check", "scene.toml", "--json"]).json();
    let formulas = motion["motion"].as_object().expect("formulas");
    assert_eq!(formulas.keys().collect::<Vec<_>>(), ["q", "p"]);
}

#[test]
fn a_run_that_goes_on_has_the_same_bytes() {
    let here = Place::with(DRIVEN);
    let run = |steps: &str, out: &str| {
        let steps = format!("run.steps={steps}");
        let said = here.leafwise(&["run", "scene.toml", "--set", &steps, "--out", out]);
        assert_eq!(said.code, Some(0), "{}", said.err);
    };
    run("40", "longer");
    run("90", "longer");
    run("90", "whole");
    assert_eq!(
        here.read("longer/samples.csv"),
        here.read("whole/samples.csv")
    );
}

#[test]
fn a_member_of_an_ensemble_is_its_run_to_the_bit() {
    for initial in ["ball = 0.1", "box = [0.1, 0.2]", "file = \"states.csv\""] {
        let members = if initial.starts_with("file") { 2 } else { 5 };
        let here = Place::with(&format!(
            "{DRIVEN}[ensemble]\nmembers = {members}\ninitial = {{ {initial} }}\nfinal-states = \"csv\"\n"
        ));
        here.write("states.csv", "p,q\n0.5,1\n0.25,-1\n");
        let said = here.leafwise(&["ensemble", "scene.toml", "--out", "all"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let table = here.read("all/final_states.csv");
        let headings = "member,outcome,q,p,energy,q_initial,p_initial,energy_drift";
        assert_eq!(table.lines().next(), Some(headings));
        let member = table.lines().nth(2).expect("a member");
        let last: Vec<&str> = member.split(',').collect();
        let said = here.leafwise(&["ensemble", "scene.toml", "--member", "1", "--out", "one"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let samples = here.read("one/samples.csv");
        let end: Vec<&str> = samples.lines().last().expect("a row").split(',').collect();
        assert_eq!(end[1..3], last[2..4], "{initial}");
    }
}

#[test]
fn methods_are_compared_by_the_scenes_own_coordinates() {
    let here = Place::with(DRIVEN);
    let only = "splitting,auto+hamilton-jacobi:4";
    let compared = [
        "compare",
        "scene.toml",
        "--steps",
        "40,80",
        "--only",
        only,
        "--json",
    ];
    let told = here.leafwise(&compared).json();
    let state = told["reference"]["state"].as_array().expect("a state");
    // x(4) = cos 4 + 0.5 sin 4 − 0.2 sin 4.
    let exact = libm::cos(4.0) + 0.3 * libm::sin(4.0);
    let found = state[0].as_f64().expect("a number");
    assert_eq!(state.len(), 2);
    assert!((found - exact).abs() < 1e-12, "{found}");
    let tune = here.leafwise(&["tune", "scene.toml", "--error", "1e-6", "--json"]);
    assert_eq!(tune.code, Some(0), "{}", tune.err);
}

/// Runs the driven scene with one text changed, which must be refused at `place` with every piece said.
fn refused(from: &str, to: &str, place: &str, pieces: &[&str]) {
    refused_of(DRIVEN, from, to, place, pieces);
}

fn refused_of(scene: &str, from: &str, to: &str, place: &str, pieces: &[&str]) {
    assert!(scene.contains(from), "{from}");
    let here = Place::with(&scene.replacen(from, to, 1));
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&[&format!("scene.toml:{place}")]);
    said.says(pieces);
    assert!(here.is_untouched(), "something was written");
}

#[test]
fn the_time_stands_where_it_has_a_meaning() {
    let bracket = [
        "the bracket cannot name the time t",
        "belongs in the Hamiltonian",
    ];
    refused("\"1\" }", "\"1 + t\" }", "3:30", &bracket);
    refused(
        "[method]",
        "casimirs = { c = \"t\" }\n[method]",
        "6:19",
        &["a Casimir cannot name the time t"],
    );
    refused(
        "[1, 0.5]",
        "{ q = \"t\", p = 1 }",
        "10:18",
        &["every run begins at t = 0", "phase"],
    );
    // Later they are smooth.
    for rough in ["0.1*q*sqrt(t)", "0.1*q*t*ln(t)", "0.1*q*ln(t)"] {
        let begin = ["no value or no derivative at t = 0,", "write t0 into [run]"];
        refused("0.1*q*cos(t)", rough, "5:16", &begin);
    }
    // As is advised.
    let later = DRIVEN.replace("0.1*q*cos(t)", "0.1*q*sqrt(t)");
    let here = Place::with(&later.replace("[run]", "[run]\nt0 = 0.25"));
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let unnamed = ["t is the time where the Hamiltonian, a one-form, a force or a pace names it"];
    refused("0.1*q*cos(t)", "0.1*q", "12:54", &unnamed);
    // A coordinate, or a parameter, of this name is no time.
    let own = DRIVEN.replace("[method]", "parameters = { t = 0.5 }\n[method]");
    let here = Place::with(&own);
    let said = here.leafwise(&["evaluate", "scene.toml", "--x", "1,0"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
}

#[test]
fn what_is_not_offered_with_the_time_says_so() {
    let lattice = DRIVEN
        .replace(
            "variables   = [\"q\", \"p\"]",
            "families = { q = 640, p = 640 }",
        )
        .replace("\"q,p\"", "\"q[i],p[i]\"")
        .replace(
            "p^2/2 + q^2/2 + 0.1*q*cos(t)",
            "sum(i, p[i]^2/2 + q[i]^2*cos(t))",
        )
        .replace("[1, 0.5]", "{ \"q[i]\" = 1, \"p[i]\" = 0 }")
        .replace(", \"q - t\"", "");
    let here = Place::with(&lattice);
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&[
        "not offered on a lattice of more than 1024 coordinates",
        "this one has 1280",
    ]);
    let here = Place::with(DRIVEN);
    let said = here.leafwise(&["evaluate", "scene.toml", "--x", "1,0"]);
    assert_eq!(said.code, Some(2), "{}", said.err);
    said.says(&["name the time t, or that has a pace, cannot be evaluated at a point"]);
}

/// Kepler's problem by steps that shorten towards the centre.
pub const PACED: &str = r#"[system]
library = "kepler"
[method]
dynamics  = { name = "hamilton-jacobi", order = 4 }
pace      = "(q1^2 + q2^2)^0.75"
time-step = 0.1
[run]
initial = [0.5, 0, 0, 1.7]
until   = 6
record  = { interval = 0.5 }
"#;

#[test]
fn a_paced_run_records_at_the_times_it_is_asked_for() {
    let here = Place::with(PACED);
    let told = here
        .leafwise(&["run", "scene.toml", "--out", "run", "--json"])
        .json();
    assert_eq!(told["time"], 6.0);
    let [least, most] = [0, 1].map(|at| told["step_times"][at].as_f64().expect("a number"));
    assert!(0.0 < least && least < most);
    let rows = rows(&here.read("run/samples.csv"));
    let times: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    let expected: Vec<f64> = (0..=12).map(|k| 0.5 * f64::from(k)).collect();
    assert_eq!(times, expected);
    let page = here.read("run/report.html");
    for piece in [
        "dt/dτ = (q1^2 + q2^2)^0.75",
        "τ advances by 0.1",
        "every 0.5 of time",
    ] {
        assert!(page.contains(piece), "{piece}");
    }
    let motion = here.leafwise(&["check", "scene.toml"]);
    assert!(motion.out.contains("q1'  = p1\n"), "{}", motion.out);
}

#[test]
fn a_paced_run_that_goes_on_has_the_same_bytes() {
    for record in ["{ interval = 0.5 }", "{ interval = 0.01 }", "{ every = 3 }"] {
        let here = Place::with(&PACED.replace("{ interval = 0.5 }", record));
        let run = |until: &str, out: &str| {
            let until = format!("run.until={until}");
            here.leafwise(&["run", "scene.toml", "--set", &until, "--out", out])
        };
        for until in ["2.3", "4", "9"] {
            let said = run(until, "longer");
            assert_eq!(said.code, Some(0), "{}", said.err);
        }
        assert_eq!(run("9", "whole").code, Some(0));
        for file in ["samples.csv", "windows.csv"] {
            let (longer, whole) = (format!("longer/{file}"), format!("whole/{file}"));
            assert_eq!(here.read(&longer), here.read(&whole), "{record} {file}");
        }
        let again = run("9", "whole");
        assert_eq!(again.code, Some(0), "{}", again.err);
        again.says(&["it was already complete"]);
        let shorter = run("3", "whole");
        assert_eq!(shorter.code, Some(2), "{}", shorter.err);
        shorter.says(&["has reached t = 9.", "beyond the requested t = 3.0"]);
    }
}

/// Runs the paced scene with one text changed, which must be refused at `place` with every piece said.
fn refused_pace(from: &str, to: &str, place: &str, pieces: &[&str]) {
    refused_of(PACED, from, to, place, pieces);
}

#[test]
fn a_pace_is_positive_where_the_run_begins() {
    let pace = "(q1^2 + q2^2)^0.75";
    let positive = ["and must be positive", "positive along the motion"];
    refused_pace(pace, "-q1", "5:14", &positive);
    refused_pace(pace, "q2", "5:14", &["the pace is 0.0"]);
    refused_pace(pace, "ln(q2)", "5:14", &["the pace is -inf"]);
    refused_pace(pace, "sqrt(q2 - 1)", "5:14", &["the pace is NaN"]);
    refused_pace(
        pace,
        "auto",
        "5:14",
        &[
            "a pace is never chosen automatically",
            "write a positive formula",
        ],
    );
    refused_pace(pace, "r^2", "5:14", &["unknown name `r`"]);
    // At the centre the energy has no value.
    let here = Place::with(&PACED.replace("[0.5, 0, 0, 1.7]", "[0, 0, 0, 1.7]"));
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&["the energy is -inf at the initial state"]);
}

#[test]
fn ends_and_intervals_are_times_of_a_pace() {
    refused_pace("= 6", "= -6", "9:11", &["never comes to t = -6"]);
    refused_pace("0.1", "-0.1", "9:11", &["never comes to t = 6"]);
    refused_pace("0.5 }", "0 }", "10:24", &["must be positive"]);
    refused_pace(
        "0.5 }",
        "0.5, every = 2 }",
        "10:29",
        &["`every` cannot be combined with `interval`"],
    );
    refused_pace(
        "until   = 6",
        "until = 6\nsteps = 4",
        "10:1",
        &["`steps` cannot be combined with `until`"],
    );
    refused_pace("until   = 6", "", "", &["needs `steps`"]);
    let pace = "pace      = \"(q1^2 + q2^2)^0.75\"\n";
    refused_pace(
        pace,
        "",
        "9:24",
        &["steps are all alike without a pace", "write `every`"],
    );
    let counted = PACED.replace("until   = 6", "steps = 6").replace(pace, "");
    let here = Place::with(&counted);
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&["`interval` is a time", "write `every`"]);
}

/// 1 − t/3 falls to 0 with e^{−τ/3}: t comes to 3 and never goes on.
#[test]
fn a_pace_that_falls_to_0_ends_the_run_with_its_value_and_place() {
    let here = Place::with(&PACED.replace("(q1^2 + q2^2)^0.75", "1 - t/3"));
    let said = here.leafwise(&["run", "scene.toml", "--out", "run"]);
    assert_eq!(said.code, Some(1), "{}", said.err);
    said.says(&[
        "the pace 1 - t/3",
        "state before it: q1 = ",
        "write a pace that is positive along the motion",
    ]);
    // What was recorded is of the motion before.
    let rows = rows(&here.read("run/samples.csv"));
    let times: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    assert_eq!(times[..6], [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
    assert!(times.iter().all(|t| *t <= 3.0), "{times:?}");
}

#[test]
fn what_is_not_offered_with_a_pace_says_so() {
    let here = Place::with(PACED);
    let said = here.leafwise(&["evaluate", "scene.toml"]);
    assert_eq!(said.code, Some(2), "{}", said.err);
    let splitting = PACED.replace(
        "dynamics  = { name = \"hamilton-jacobi\", order = 4 }",
        "stepper = \"splitting\"",
    );
    let said = Place::with(&splitting).leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&[
        "splitting does not fit this system",
        "with a pace the Hamiltonian is (H + e)*((q1^2 + q2^2)^0.75)",
        "remove the pace",
    ]);
}

/// A pace that comes to 0: the exact motion never gets there, a computed one would turn back into another orbit.
#[test]
fn a_run_ends_where_its_pace_vanishes() {
    for (pace, order) in [("q", 4), ("q", 8), ("p + 1", 4), ("p + 1", 8)] {
        let scene = format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"p^2/2 + q^2/2\"\n[method]\ndynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\n\
             pace = \"{pace}\"\ntime-step = 0.05\n[run]\ninitial = [1, 0.5]\nuntil = 4\nrecord = {{ every = 100 }}\n"
        );
        let here = Place::with(&scene);
        let said = here.leafwise(&["run", "scene.toml"]);
        assert_eq!(said.code, Some(1), "{pace}, {order}: {}", said.err);
        said.says(&["pace"]);
    }
    // Slower than any run: 10¹² steps and more.
    let slow = PACED.replace("(q1^2 + q2^2)^0.75", "1e-13");
    let here = Place::with(&slow);
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(1), "{}", said.err);
    said.says(&["stalls"]);
    // ∫ exp(t²) dt: the time grows as √ln τ, to 6 in more than 10¹⁵ steps.
    let never = PACED.replace("(q1^2 + q2^2)^0.75", "exp(-t^2)");
    let here = Place::with(&never);
    let said = here.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(1), "{}", said.err);
    said.says(&[
        "the pace exp(-t^2) becomes too small to come to the end",
        "at t = ",
    ]);
    let steps = said.json()["steps"].as_u64().expect("a number");
    assert!(steps < 1 << 22, "{steps}");
}

/// q'' = -q by steps of 0.1, with samples where the test says.
const AT_TIMES: &str = r#"[system]
variables   = ["q", "p"]
bracket     = { "q,p" = "1" }
convention  = "{x,H}"
hamiltonian = "p^2/2 + q^2/2"
[method]
realization = "auto"
dynamics    = { name = "hamilton-jacobi", order = 8 }
time-step   = 0.1
[run]
initial = [1, 0]
steps   = 40
record  = { times = [0, 0.25, 0.3, 0.8, 0.81, 0.82, 3.99] }
"#;

#[test]
fn samples_lie_at_given_times() {
    let here = Place::with(AT_TIMES);
    here.leafwise(&["run", "scene.toml", "--out", "run"]);
    let at_times = rows(&here.read("run/samples.csv"));
    let times: Vec<f64> = at_times.iter().map(|row| row[0]).collect();
    assert_eq!(times, [0.0, 0.25, 0.3, 0.8, 0.81, 0.82, 3.99, 4.0]);
    for row in &at_times {
        // Forty steps of order 8 err by less than h^9 each.
        assert!((row[1] - libm::cos(row[0])).abs() < 4e-8, "{row:?}");
        assert!((row[2] + libm::sin(row[0])).abs() < 4e-8, "{row:?}");
    }
    let page = here.read("run/report.html");
    assert!(page.contains("8, at given times"));
    // The steps know nothing of it, and a time at the end of one is that step's.
    let every = "run.record.every=1";
    here.leafwise(&["run", "scene.toml", "--out", "steps", "--set", every]);
    let steps = rows(&here.read("steps/samples.csv"));
    assert_eq!(at_times[2][1..], steps[3][1..]);
    assert_eq!(at_times[3], steps[8]);
    assert_eq!(at_times[7], steps[40]);
}

#[test]
fn samples_at_given_times_have_the_same_bytes_however_the_run_came_there() {
    let dense: Vec<String> = (1..200)
        .map(|k| format!("{:?}", 0.017 * f64::from(k)))
        .collect();
    let dense = format!("times = [{}]", dense.join(", "));
    for times in ["times = [0.05, 2, 3.04]", &dense] {
        let here =
            Place::with(&AT_TIMES.replace("times = [0, 0.25, 0.3, 0.8, 0.81, 0.82, 3.99]", times));
        let run = |steps: &str, out: &str| {
            let steps = format!("run.steps={steps}");
            here.leafwise(&["run", "scene.toml", "--set", &steps, "--out", out])
        };
        for steps in ["34", "35", "120"] {
            let said = run(steps, "longer");
            assert_eq!(said.code, Some(0), "{}", said.err);
        }
        assert_eq!(run("120", "whole").code, Some(0));
        for file in ["samples.csv", "windows.csv"] {
            let (longer, whole) = (format!("longer/{file}"), format!("whole/{file}"));
            assert_eq!(here.read(&longer), here.read(&whole), "{times} {file}");
        }
        run("120", "whole").says(&["it was already complete"]);
    }
}

#[test]
fn given_times_go_the_way_of_the_run() {
    let backwards = AT_TIMES
        .replace("time-step   = 0.1", "time-step   = -0.1")
        .replace("[0, 0.25, 0.3, 0.8, 0.81, 0.82, 3.99]", "[-0.25, -4]");
    let here = Place::with(&backwards);
    let said = here.leafwise(&["run", "scene.toml", "--out", "run"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let at_times = rows(&here.read("run/samples.csv"));
    let times: Vec<f64> = at_times.iter().map(|row| row[0]).collect();
    assert_eq!(times, [0.0, -0.25, -4.0]);
    let refused = |to: &str, place: &str, pieces: &[&str]| {
        refused_of(
            AT_TIMES,
            "[0, 0.25, 0.3, 0.8, 0.81, 0.82, 3.99]",
            to,
            place,
            pieces,
        );
    };
    refused(
        "[1, 0.5]",
        "13:25",
        &["does not come to t = 0.5 after t = 1", "from 0 on"],
    );
    refused("[1, 1]", "13:25", &["does not come to t = 1 after t = 1"]);
    refused("[-1]", "13:22", &["does not come to t = -1 after t = 0"]);
    // What is named as the cure is one: sorted, or with steps of the other sign.
    refused("[3, 2, 1]", "13:25", &["times = [1, 2, 3]"]);
    refused("[-1, -2, -3]", "13:22", &["write time-step = -0.1"]);
    for (step, times) in [("0.1", "[1, 2, 3]"), ("-0.1", "[-1, -2, -3]")] {
        let cured = AT_TIMES
            .replace("time-step   = 0.1", &format!("time-step   = {step}"))
            .replace("[0, 0.25, 0.3, 0.8, 0.81, 0.82, 3.99]", times);
        let here = Place::with(&cured);
        let said = here.leafwise(&["check", "scene.toml"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
    }
    refused(
        "[1, 4.5]",
        "13:25",
        &["the run ends at t = 4.0, before t = 4.5"],
    );
    refused("[1, nan]", "13:25", &["finite"]);
    refused("3", "13:21", &["a list of times"]);
    let beside = "[1], every = 2";
    refused(
        beside,
        "13:26",
        &["`every` cannot be combined with `times`"],
    );
    let paced = PACED.replace("until   = 6", "steps = 6");
    refused_of(
        &paced,
        "interval = 0.5",
        "times = [1]",
        "10:21",
        &[
            "with a pace the times after a number of steps are not known",
            "write `until`",
        ],
    );
}

#[test]
fn a_paced_run_records_at_given_times() {
    let here = Place::with(&PACED.replace("interval = 0.5", "times = [0.5, 1.5, 6]"));
    here.leafwise(&["run", "scene.toml", "--out", "run"]);
    let given = rows(&here.read("run/samples.csv"));
    let interval = "run.record.interval=0.5";
    here.leafwise(&["run", "scene.toml", "--out", "grid", "--set", interval]);
    let grid = rows(&here.read("grid/samples.csv"));
    assert_eq!(
        given,
        [&grid[0], &grid[1], &grid[3], &grid[12]].map(Clone::clone)
    );
}

/// The last step holds a sample between its ends, and the run's last state is another.
#[test]
fn a_run_of_steps_keeps_its_last_state_behind_the_last_time() {
    let here = Place::with(&PACED.replace("until   = 6", "steps = 7"));
    let said = here
        .leafwise(&["run", "scene.toml", "--out", "run", "--json"])
        .json();
    let given = rows(&here.read("run/samples.csv"));
    assert_eq!(given.last().map(|row| row[0]), said["time"].as_f64());
}

/// H(q, p, t0 + t) begun at t0 is the same motion as one begun at 0 whose phase is shifted by hand.
#[test]
fn a_run_may_begin_at_any_time() {
    let rows = |text: &str| {
        let here = Place::with(text);
        let said = here.leafwise(&["run", "scene.toml", "--out", "run"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        here.read("run/samples.csv")
    };
    let late = DRIVEN.replace("[run]", "[run]\nt0 = 2.5");
    let by_hand = DRIVEN.replace("cos(t)", "cos(t + 2.5)");
    let shifted = rows(&late);
    assert_ne!(shifted, rows(DRIVEN));
    assert_eq!(states(&shifted), states(&rows(&by_hand)));
}

/// The columns t, q, p.
fn states(table: &str) -> Vec<String> {
    let cells = |row: &str| row.split(',').take(3).collect::<Vec<_>>().join(",");
    table.lines().map(cells).collect()
}

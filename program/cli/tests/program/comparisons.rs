//! `compare`: the table, the object, the files, and what is refused.

use crate::support::{BODY, Place, catches, wait_for};

const FEW: &str = "splitting,dop853,so3-exponential+hamilton-jacobi:6";

#[test]
fn a_comparison_prints_its_front_and_says_how_good_the_reference_is() {
    let here = Place::with(BODY);
    let said = here.leafwise(&["compare", "scene.toml", "--only", FEW, "--repeat", "0"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    for piece in [
        "to t = 4",
        "own error is",
        "so3-exponential + hamilton-jacobi 6",
        "dop853",
    ] {
        assert!(said.out.contains(piece), "{piece}: {}", said.out);
    }
    let lines = said.out.lines().count();
    let all = here.leafwise(&[
        "compare",
        "scene.toml",
        "--only",
        FEW,
        "--repeat",
        "0",
        "--all",
    ]);
    assert!(all.out.lines().count() > lines + 10, "{}", all.out);
    assert!(here.is_untouched());
}

#[test]
fn most_failures_come_with_their_reason() {
    let here = Place::with(BODY);
    let method = "so3-exponential+hamilton-jacobi:6";
    let (time, steps) = ("40", "1,2,3,4,400");
    let given = [
        "--only", method, "--time", time, "--steps", steps, "--repeat", "0",
    ];
    let said = here.leafwise(&[&["compare", "scene.toml"][..], &given].concat());
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(said.out.contains("5 points of 1 method: "), "{}", said.out);
    let reason = "failed most often, 4 of them: step 0: the solution of the step's equation";
    assert!(said.out.contains(reason), "{}", said.out);
}

#[test]
fn the_object_and_the_files_hold_every_point() {
    let here = Place::with(BODY);
    let said = here.leafwise(&[
        "compare",
        "scene.toml",
        "--only",
        FEW,
        "--steps",
        "20,40,80",
        "--repeat",
        "1",
        "--json",
        "--csv",
        "points.csv",
        "--out",
        "results",
    ]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let object = said.json();
    assert_eq!(object["time"], 4.0);
    assert!(object["reference"]["error"].as_f64().expect("a number") < 1e-11);
    let points = object["points"].as_array().expect("a list");
    let of = |name: &'static str| points.iter().filter(move |p| p["method"] == name);
    assert_eq!(of("splitting").count(), 3);
    assert!(of("dop853").all(|p| p["tolerance"].is_number()));
    for point in points {
        assert!(
            point["operations"].as_u64().is_some_and(|count| count > 0),
            "{point}"
        );
        assert!(point["wall_seconds"]["median"].is_number(), "{point}");
        assert!(point["front"]["poisson"].is_boolean(), "{point}");
    }
    let errors: Vec<f64> = of("splitting")
        .filter_map(|p| p["error"].as_f64())
        .collect();
    assert!(errors[1] < errors[0] && errors[2] < errors[1], "{errors:?}");
    let csv = here.read("points.csv");
    assert_eq!(csv.lines().count(), points.len() + 1);
    let columns = |line: &str| line.matches(',').count();
    let heading = csv.lines().next().map(columns);
    assert!(
        csv.lines().all(|line| Some(columns(line)) == heading),
        "{csv}"
    );
    assert_eq!(here.read("results/compare.csv"), csv);
    let stored: serde_json::Value =
        serde_json::from_str(&here.read("results/compare.json")).expect("an object");
    assert_eq!(stored["points"], object["points"]);
    assert!(here.read("results/compare.html").contains("</html>"));
    for name in [
        "error-against-counted-operations",
        "error-against-time",
        "error-against-evaluations",
        "energy",
        "casimirs",
        "tensor-defect",
        "orders",
    ] {
        let figure = here.read(&format!("results/{name}.svg"));
        assert!(
            figure.starts_with("<svg") && figure.ends_with("</svg>\n"),
            "{name}"
        );
        // Each number of a curve is explained in the file itself, and the reference's error is drawn.
        assert!(
            figure.contains("sofroniou") || figure.contains("splitting"),
            "{name}"
        );
        assert!(!figure.contains("NaN"), "{name}");
    }
    assert!(here.read("results/energy.svg").contains("width=\"960\""));
    let errors = here.read("results/error-against-counted-operations.svg");
    assert!(
        errors.contains("so3-exponential + hamilton-jacobi 6"),
        "{errors}"
    );
}

#[test]
fn a_comparison_that_cannot_be_made_says_why() {
    let here = Place::with(BODY);
    let refused = |arguments: &[&str], code: i32, pieces: &[&str]| {
        let mut command = vec!["compare", "scene.toml"];
        command.extend_from_slice(arguments);
        let said = here.leafwise(&command);
        assert_eq!(said.code, Some(code), "{}", said.err);
        said.says(pieces);
    };
    refused(&["--with", "rk5"], 2, &["no stepper is called `rk5`"]);
    refused(&["--steps", "9..3"], 2, &["`9..3` is not a list of steps"]);
    refused(&["--time", "0"], 2, &["compared over a time"]);
    refused(&["--budget", "0"], 2, &["positive number"]);
    refused(
        &["--only", "rk4", "--with", "rk4"],
        2,
        &["cannot be used with"],
    );
    refused(&["--set", "method.dynamics.order=3"], 3, &["order"]);
    refused(&["--time", "1e300"], 2, &["too many to try"]);
    refused(&["--time", "nan"], 2, &["compared over a time"]);
    refused(&["--budget", "-1"], 2, &["positive number"]);
    refused(&["--repeat", "-1"], 2, &["--repeat"]);
    refused(&["--steps", "-3"], 2, &["`-3` is not a list of steps"]);
    refused(&["--orders", "3"], 2, &["none that fits", "order 3"]);
    refused(
        &["--only", "log-canonical+hamilton-jacobi:2"],
        2,
        &["does not fit"],
    );
    refused(
        &["--only", "rk4", "--orders", "4"],
        2,
        &["cannot be used with"],
    );
    // What cannot be written is reported before anything is measured.
    refused(&["--out", "scene.toml"], 1, &["cannot write scene.toml"]);
    refused(
        &["--csv", "none/points.csv"],
        1,
        &["cannot write none/points.csv"],
    );
    refused(&["--csv", "."], 1, &["cannot write ."]);
    let bracket =
        "system.bracket={ \"x1,x2\" = \"-x3\", \"x2,x3\" = \"-x1*x2\", \"x3,x1\" = \"-x2\" }";
    refused(&["--set", bracket, "--only", "rk4"], 3, &["not Poisson"]);
    assert!(here.is_untouched());
}

#[test]
fn a_method_that_was_asked_for_and_does_not_fit_is_named() {
    let here = Place::with(BODY);
    let only = "splitting,log-canonical+hamilton-jacobi:2";
    let said = here.leafwise(&["compare", "scene.toml", "--only", only, "--repeat", "0"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&[
        "log-canonical + hamilton-jacobi 2 is left out",
        "does not fit",
    ]);
    // An empty table says why it is.
    let coarse = ["--only", "splitting", "--steps", "1", "--repeat", "0"];
    let said = here.leafwise(&[&["compare", "scene.toml"][..], &coarse].concat());
    assert!(
        said.out.contains("no run's error is below a tenth"),
        "{}",
        said.out
    );
}

#[test]
fn tune_refuses_what_it_cannot_do_before_it_searches() {
    let here = Place::with(BODY);
    let refused = |arguments: &[&str], code: i32, pieces: &[&str]| {
        let said = here.leafwise(&[&["tune", "scene.toml"][..], arguments].concat());
        assert_eq!(said.code, Some(code), "{}{}", said.out, said.err);
        assert_eq!(said.out, "");
        said.says(pieces);
    };
    for value in ["0", "-1", "-1e-8", "nan", "inf", "small"] {
        for option in ["--error", "--energy", "--casimir", "--budget"] {
            refused(&[option, value], 2, &["positive number", option]);
        }
    }
    refused(
        &["--error", "1e-4", "--time", "0"],
        2,
        &["compared over a time"],
    );
    refused(
        &["--error", "1e-4", "--time", "inf"],
        2,
        &["compared over a time"],
    );
    refused(
        &["--error", "1e-4", "--only", "rk5"],
        2,
        &["no stepper is called `rk5`"],
    );
    let misfit = "log-canonical+hamilton-jacobi:2";
    refused(
        &["--error", "1e-4", "--only", misfit],
        2,
        &["no method is left", "does not fit"],
    );
    let casimirs = "casimirs    = { spin = \"x1^2 + x2^2 + x3^2\" }\n";
    let without = BODY.replace(casimirs, "").replace(", \"spin\"", "");
    here.write("scene.toml", &without);
    let casimir = ["--error", "1e-4", "--casimir", "1e-12"];
    refused(&casimir, 2, &["names no Casimir", "leave out --casimir"]);
    // A read-only scene is not replaced, whoever runs the program.
    let file = here.path("scene.toml");
    let mut permissions = std::fs::metadata(&file).expect("a file").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&file, permissions).expect("its owner");
    refused(
        &["--error", "1e-4", "--write"],
        1,
        &["cannot write scene.toml", "read-only"],
    );
    assert!(here.is_untouched());
}

#[test]
fn tune_says_how_long_a_motion_can_be_followed_where_it_cannot() {
    let scene = include_str!("../../../../scenes/magnetic.toml");
    let here = Place::with(scene);
    let tune = [
        "tune",
        "scene.toml",
        "--error",
        "1e-8",
        "--only",
        "splitting",
    ];
    let said = here.leafwise(&tune);
    assert_eq!(said.code, Some(5), "{}{}", said.out, said.err);
    for piece in [
        "it is undecided whether a Poisson map meets the bound",
        "grows by a factor of",
        "until t = 1000",
        "take --time",
    ] {
        assert!(said.out.contains(piece), "{piece}: {}", said.out);
    }
    let object = here.leafwise(&[&tune[..], &["--json"]].concat()).json();
    assert_eq!(object["limit"], "reference");
    assert!(
        object["horizon"]["growth"]
            .as_f64()
            .is_some_and(|growth| growth > 1e8)
    );
    let known = object["horizon"]["known"]["time"]
        .as_f64()
        .expect("a shorter time");
    assert!(
        said.out.contains(&format!("--time {known}")),
        "{}",
        said.out
    );
    let compare = [
        "compare",
        "scene.toml",
        "--only",
        "splitting",
        "--steps",
        "10000",
        "--repeat",
        "0",
    ];
    let said = here.leafwise(&compare);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&[
        "warning",
        "is known to",
        "grows by a factor of",
        "take --time",
    ]);
}

#[test]
fn tune_writes_a_scene_that_runs_within_what_was_asked() {
    let scene = include_str!("../../../../scenes/rigid_body.toml");
    let here = Place::with(&scene.replace("steps   = 1000", "steps   = 100"));
    let said = here.leafwise(&["tune", "scene.toml", "--error", "1e-8", "--write", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let found = said.json();
    assert_eq!(found["outcome"], "found");
    let recommended = &found["recommended"];
    assert_eq!(recommended["measured"]["poisson"], true);
    let written = here.read("scene.toml");
    for comment in scene.lines().filter(|line| line.starts_with('#')) {
        assert!(written.contains(comment), "{comment}\n{written}");
    }
    let run = here.leafwise(&["run", "scene.toml", "--json", "--quiet"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let run = run.json();
    let list = |value: &serde_json::Value| -> Vec<f64> {
        let list = value.as_array().expect("a list").iter();
        list.map(|x| x.as_f64().expect("a number")).collect()
    };
    let error = leafwise::trade::distance(
        &list(&run["final_state"]),
        &list(&found["reference"]["state"]),
    );
    assert!(error <= 1e-8, "{error:e}");
    let said = recommended["measured"]["end_error"]
        .as_f64()
        .expect("a number");
    assert!(
        (error - said).abs() <= 1e-3 * said,
        "{error:e}, said {said:e}"
    );
    let operations = run["solver"]["operations_per_step"]
        .as_f64()
        .expect("counted");
    let steps = run["steps"].as_f64().expect("a number");
    let counted = recommended["measured"]["operations"]
        .as_f64()
        .expect("counted");
    assert!(
        (operations * steps / counted - 1.0).abs() < 1e-9,
        "{operations}"
    );
}

#[test]
fn tune_says_what_it_found_beside_and_what_keeps_it() {
    let here = Place::with(BODY);
    let only = "so3-exponential+hamilton-jacobi:6,dop853";
    let tune = |arguments: &[&str], code: i32| {
        let mut command = vec!["tune", "scene.toml", "--only", only];
        command.extend_from_slice(arguments);
        let said = here.leafwise(&command);
        assert_eq!(said.code, Some(code), "{}{}", said.out, said.err);
        said
    };
    let said = tune(&["--error", "1e-7"], 0);
    for piece in [
        "the cheapest Poisson map: so3-exponential + hamilton-jacobi 6",
        "the cheapest of all, not a Poisson map: dop853",
        "predicted  measured",
        "[method]\nrealization = \"so3-exponential\"",
        "--write puts it into the scene",
    ] {
        assert!(said.out.contains(piece), "{piece}: {}", said.out);
    }
    let said = tune(&["--error", "1e-7", "--any"], 0);
    for piece in [
        "the cheapest method, not a Poisson map: dop853",
        "stepper     = { name = \"dop853\"",
    ] {
        assert!(said.out.contains(piece), "{piece}: {}", said.out);
    }
    let said = tune(&["--error", "1e-18"], 5);
    assert!(said.out.contains("raise the bound"), "{}", said.out);
    let said = tune(&["--error", "1e-7", "--budget", "3e4", "--json"], 5);
    assert_eq!(said.json()["outcome"], "not found");
    assert_eq!(said.json()["nearest"]["limit"], "budget");
    tune(&[], 2).says(&["no bound is given"]);
    tune(&["--error", "1e-7", "--write", "--set", "run.steps=3"], 2).says(&["cannot be used"]);
    assert!(here.is_untouched());
}

/// The scene ends at t = 4; the search goes to t = 2.
#[test]
fn tune_prints_the_steps_that_it_writes_and_where_errors_are_judged() {
    let only = ["--only", "kahan-li-6/splitting", "--error", "1e-6"];
    let tune = |more: &[&str]| {
        let here = Place::with(BODY);
        let said = here.leafwise(&[&["tune", "scene.toml"], &only[..], more].concat());
        assert_eq!(said.code, Some(0), "{}", said.err);
        (said, here)
    };
    let (said, here) = tune(&["--time", "2", "--write"]);
    let written = here.read("scene.toml");
    let steps = written.lines().find(|line| line.starts_with("steps"));
    let steps = steps.expect("a number of steps");
    let number = |line: &str| line.rsplit(' ').next().map(str::to_owned);
    let printed = said.out.lines().find(|line| line.starts_with("steps"));
    assert_eq!(printed.and_then(number), number(steps), "{}", said.out);
    for piece in ["error at every step 1e-6", "  at the end", "written into"] {
        assert!(said.out.contains(piece), "{piece}: {}", said.out);
    }
    let (said, _) = tune(&["--at-end", "--json"]);
    assert_eq!(said.json()["reference"]["errors"], "at the end");
    let (said, _) = tune(&["--json"]);
    assert_eq!(said.json()["reference"]["errors"], "at every step");
    let measured = &said.json()["recommended"]["measured"];
    assert!(measured["error"].as_f64() >= measured["end_error"].as_f64());
}

/// The search has nothing to save: a signal ends it, whatever it is at.
#[cfg(target_os = "linux")]
#[test]
fn a_search_that_is_terminated_ends_where_it_is() {
    use std::io::Read as _;
    use std::process::{Command, Stdio};

    // A reference over 10⁵ revolutions takes minutes.
    let here = Place::with(&BODY.replace("steps   = 40", "steps   = 10000000"));
    let mut child = here
        .command(&["tune", "scene.toml", "--error", "1e-6", "--write"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    // From the moment on at which the program takes SIGTERM itself.
    let id = child.id();
    wait_for(&mut child, || catches(id, 15), "a handler of signals");
    let sent = Command::new("kill")
        .args(["-TERM", &child.id().to_string()])
        .status()
        .expect("kill runs");
    assert!(sent.success(), "the search has ended by itself");
    let mut said = String::new();
    let mut err = child.stderr.take().expect("a pipe");
    err.read_to_string(&mut said).expect("UTF-8");
    assert_eq!(child.wait().expect("an end").code(), Some(130), "{said}");
    assert!(said.contains("interrupted"), "{said}");
    assert!(here.is_untouched());
    assert!(here.read("scene.toml").contains("steps   = 10000000"));
}

const PENDULUM: &str = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = 1 }\nconvention = \"{x,H}\"\n\
                        hamiltonian = \"p^2/2 - cos(q)\"\n[method]\nstepper = \"splitting\"\ntime-step = 0.001\n\
                        [run]\ninitial = [1.0, 0.0]\nsteps = 10000\n";

/// A hundredth of a radian takes fifty steps, and the grid begins at a sixteenth of ten thousand.
#[test]
fn tune_goes_on_below_the_first_of_its_steps() {
    let here = Place::with(PENDULUM);
    let tune = [
        "tune",
        "scene.toml",
        "--error",
        "1e-2",
        "--only",
        "splitting",
        "--json",
    ];
    let found = here.leafwise(&tune).json();
    let recommended = &found["recommended"];
    let steps = recommended["steps"].as_u64().expect("a number");
    let error = recommended["measured"]["error"].as_f64().expect("a number");
    // Strang's error falls by the square of the step: no fewer than half as many steps would do.
    assert!((2.5e-3..=1e-2).contains(&error), "{steps}: {error}");
    assert!(steps < 625 / 4, "{steps}");
}

/// Where nothing was judged, nothing is known to hold or not.
#[test]
fn a_search_without_time_says_that_nothing_is_known() {
    let here = Place::with(PENDULUM);
    let said = here.leafwise(&["tune", "scene.toml", "--error", "1e-8", "--within", "1e-9"]);
    assert_eq!(said.code, Some(5), "{}{}", said.out, said.err);
    let known = "no run was judged: it is not known whether a Poisson map meets the bound";
    assert!(said.out.contains(known), "{}", said.out);
    assert!(
        !said.out.contains("no Poisson map meets the bound"),
        "{}",
        said.out
    );
    said.says(&["is interrupted", "--within"]);
}

/// A truncated realization is a Poisson map where its defect is round-off, and Casimirs say otherwise.
#[test]
fn tune_says_to_which_order_a_poisson_map_is_one() {
    let scene = include_str!("../../../../scenes/heavy_top.toml");
    let here = Place::with(scene);
    let only = "karasev-truncated:8+hamilton-jacobi:8";
    let tune = [
        "tune",
        "scene.toml",
        "--time",
        "2",
        "--error",
        "1e-9",
        "--only",
        only,
    ];
    let said = here.leafwise(&tune);
    assert_eq!(said.code, Some(0), "{}{}", said.out, said.err);
    for piece in [
        "a Poisson map to order 8",
        "its tensor defect is",
        "Casimirs are kept to the same order",
    ] {
        assert!(said.out.contains(piece), "{piece}: {}", said.out);
    }
}

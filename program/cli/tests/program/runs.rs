//! Runs from the command line: objects, directories, overrides.

use crate::support::{BODY, Place};

#[test]
fn a_run_prints_the_fixed_names_and_a_table() {
    let here = Place::with(BODY);
    let said = here.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    let names: Vec<&str> = json
        .as_object()
        .expect("an object")
        .keys()
        .map(String::as_str)
        .collect();
    for name in [
        "final_state",
        "time",
        "steps",
        "wall_seconds",
        "drift",
        "solver",
        "run_directory",
    ] {
        assert!(names.contains(&name), "{name} is missing from {names:?}");
    }
    assert_eq!(json["steps"], 40);
    assert_eq!(json["time"], 40.0 * 0.1);
    assert_eq!(json["final_state"].as_array().map(Vec::len), Some(3));
    // Quadratic Casimirs of a linear tensor are kept to round-off.
    assert!(
        json["drift"]["spin"]
            .as_f64()
            .is_some_and(|drift| drift < 19.0 * 1e-14)
    );
    assert!(
        json["drift"]["energy"]
            .as_f64()
            .is_some_and(|drift| drift > 0.0)
    );
    assert!(
        json["solver"]["evaluations_per_step"]
            .as_f64()
            .is_some_and(|mean| mean >= 1.0)
    );
    assert_eq!(json["solver"]["failures"], 0);
    said.says(&[
        "largest drift",
        "energy",
        "spin",
        "report   runs/scene/report.html",
    ]);
    let directory = json["run_directory"].as_str().expect("a path");
    for file in [
        "scene.toml",
        "manifest.json",
        "samples.csv",
        "windows.csv",
        "checkpoint.bin",
        "report.html",
    ] {
        assert!(here.path(directory).join(file).is_file(), "{file}");
    }
    // Steps 0, 3, …, 39 and the last one.
    assert_eq!(
        here.read("runs/scene/samples.csv").lines().count(),
        1 + 14 + 1
    );
    assert_eq!(here.read("runs/scene/scene.toml"), BODY);
}

#[test]
fn overrides_are_run_and_stored() {
    let here = Place::with(BODY);
    let said = here.leafwise(&[
        "run",
        "scene.toml",
        "--set",
        "run.steps=7",
        "--set",
        "method.dynamics.order=4",
        "--out",
        "elsewhere",
        "--quiet",
    ]);
    assert_eq!(
        (said.code, said.err.as_str(), said.out.as_str()),
        (Some(0), "", "")
    );
    let stored = here.read("elsewhere/scene.toml");
    assert!(
        stored.contains("steps   = 7") && stored.contains("order = 4 }\ntime-step"),
        "{stored}"
    );
    let said = here.leafwise(&["run", "scene.toml", "--set", "method.epsilonn=1"]);
    assert_eq!(said.code, Some(3));
    said.says(&["did you mean `epsilon`?"]);
    let said = here.leafwise(&["run", "scene.toml", "--set", "system.parameters.I22=1"]);
    assert_eq!(said.code, Some(3));
    said.says(&["unknown parameter `I22`", "did you mean `I2`?"]);
    let said = here.leafwise(&["run", "scene.toml", "--set", "run.steps"]);
    assert_eq!(said.code, Some(2));
}

#[test]
fn a_finished_run_is_reported_again_or_continued_and_another_is_refused() {
    let here = Place::with(BODY);
    let first = here.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(first.code, Some(0));
    let before = here.read("runs/scene/manifest.json");
    let again = here.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(again.code, Some(0), "{}", again.err);
    again.says(&["was already complete", "largest drift", "--force"]);
    assert_eq!(again.json(), first.json());
    assert_eq!(here.read("runs/scene/manifest.json"), before);
    let other = ["run", "scene.toml", "--set", "method.time-step=0.2"];
    let said = here.leafwise(&other);
    assert_eq!(said.code, Some(2));
    said.says(&[
        "has finished",
        "method.time-step: 0.1 → 0.2",
        "--force",
        "--out",
    ]);
    assert_eq!(here.read("runs/scene/manifest.json"), before);
    let longer = here.leafwise(&["run", "scene.toml", "--set", "run.steps=50", "--json"]);
    assert_eq!(longer.code, Some(0), "{}", longer.err);
    longer.says(&["resumed at step 40"]);
    assert_eq!(longer.json()["steps"], 50);
    let shorter = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(shorter.code, Some(2));
    shorter.says(&[
        "of 50 steps, more than the 40 requested",
        "--force",
        "--out",
    ]);
    let said = here.leafwise(&[&other[..], &["--force"]].concat());
    assert_eq!(said.code, Some(0), "{}", said.err);
}

/// The folder where the program runs is a folder as any other.
#[test]
fn an_empty_path_does_not_take_a_folder_with_files() {
    let here = Place::with(&BODY.replace("[run]\n", "[run]\nout = \"\"\n"));
    for name in ["samples.csv", "report.html"] {
        here.write(name, "mine");
    }
    let scene = here.read("scene.toml");
    for arguments in [
        &["run", "scene.toml"][..],
        &["run", "scene.toml", "--force"],
    ] {
        let said = here.leafwise(arguments);
        assert_eq!(said.code, Some(2), "{}", said.err);
        said.says(&["is not a run directory", "--out"]);
        assert_eq!(here.read("scene.toml"), scene);
        assert_eq!(
            here.read("samples.csv") + &here.read("report.html"),
            "minemine"
        );
        assert!(!here.path(".lock").exists());
    }
}

#[test]
fn a_scene_whose_name_is_a_dot_has_a_folder_of_its_own() {
    let here = Place::new();
    here.write("..toml", BODY);
    let said = here.leafwise(&["run", "..toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert_eq!(said.json()["run_directory"], "runs/scene");
}

/// A whole number that TOML does not hold is no text.
#[test]
fn an_override_beyond_the_whole_numbers_says_so() {
    let here = Place::with(BODY);
    let said = here.leafwise(&[
        "run",
        "scene.toml",
        "--set",
        "run.steps=18446744073709551615",
    ]);
    assert_eq!(said.code, Some(3));
    said.says(&["larger than any whole number", "9223372036854775807"]);
    assert!(here.is_untouched());
}

#[test]
fn explain_counts_the_operations_of_every_kernel() {
    let here = Place::with(&BODY.replace("order = 2", "order = 8"));
    let said = here.leafwise(&["run", "scene.toml", "--explain"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&[
        "linear (Lie-Poisson)",
        "S_7",
        "Step kernel of dS",
        "Newton iteration",
        "to first step",
    ]);
    let line = said
        .err
        .lines()
        .find(|line| line.contains("Step kernel of dS"))
        .expect("a line");
    let count: usize = line
        .split_whitespace()
        .find_map(|word| word.parse().ok())
        .expect("a number of operations");
    assert!(count <= 200, "{line}");
}

/// Recorded formulas are drawn under their names; of several bodies, the orbit of the first.
#[test]
fn recorded_formulas_and_all_bodies_are_drawn() {
    let here = Place::new();
    let vortices = include_str!("../../../../scenes/point_vortices.toml");
    let (before, _) = vortices.split_once("record").expect("a record");
    let record =
        "record = { every = 10, observables = [\"energy\", { radius = \"x1^2 + y1^2\" }] }\n";
    here.write("scene.toml", &format!("{before}{record}"));
    let said = here.leafwise(&["run", "scene.toml", "--set", "run.steps=200"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let page = here.read("runs/scene/report.html");
    assert!(page.contains("radius at the recorded states."));
    assert!(page.contains("Trajectories in (x, y)") && page.contains("body 4"));
    let samples = here.read("runs/scene/samples.csv");
    assert!(
        samples
            .lines()
            .next()
            .is_some_and(|header| header.ends_with(",energy,radius"))
    );
}

/// Names may hold what a terminal obeys; neither the object nor the words hand it on.
#[test]
fn what_steers_a_terminal_is_not_printed_and_means_the_same() {
    let name = "sp\u{1b}[2Jin\u{9b}\u{202e}";
    let here = Place::with(
        &BODY
            .replace("spin", r#""sp\u001b[2Jin\u009b\u202e""#)
            .replace(r#", ""sp\u001b[2Jin\u009b\u202e"""#, ""),
    );
    let said = here.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    for text in [&said.out, &said.err] {
        let steers = |c: char| c.is_control() && !matches!(c, '\n' | '\t') || c == '\u{202e}';
        assert!(!text.contains(steers), "{text:?}");
    }
    fn holds(value: &serde_json::Value, name: &str) -> bool {
        match value {
            serde_json::Value::String(own) => own == name,
            serde_json::Value::Array(list) => list.iter().any(|value| holds(value, name)),
            serde_json::Value::Object(map) => map
                .iter()
                .any(|(key, value)| key == name || holds(value, name)),
            _ => false,
        }
    }
    assert!(holds(&said.json(), name), "{}", said.out);
}

/// A flow over 10³ radians is formed by no series: the message says whose, and what to try.
#[test]
fn a_body_taken_whole_over_too_long_a_step_says_so() {
    let here = Place::with(
        "[system]\nlibrary = \"rigid-body\"\n[method]\nstepper = { name = \"splitting\", bodies = \"whole\" }\n\
         time-step = 1000\n[run]\ninitial = [1, 3, 3]\nsteps = 10\n",
    );
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(1), "{}", said.err);
    said.says(&[
        "a whole body moves beyond the range of its flow",
        "bodies = \"axes\"",
    ]);
}

/// What rounding adds to the spin is taken off by `clebsch`, and told; other methods hold nothing.
#[test]
fn how_much_a_casimir_is_held_by_is_told() {
    let here = Place::with(BODY);
    let said = here.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(said.json()["solver"]["held"], 0.0, "{}", said.err);
    assert!(!said.err.contains("Casimirs held"), "{}", said.err);
    let here = Place::with_body(
        "{ name = \"karasev-truncated\", order = 4 }\ndynamics    = { name = \"hamilton-jacobi\", order = 2 }",
        "\"clebsch\"\ndynamics = { name = \"collective\", stages = 4 }",
    );
    let said = here.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let held = said.json()["solver"]["held"].as_f64().expect("a number");
    // Three squares, each of two factors with eight roundings.
    assert!(held > 0.0 && held <= 24.0 * f64::EPSILON, "{held:e}");
    said.says(&[&format!("Casimirs held within {held:.1e} of their size")]);
    let manifest: serde_json::Value =
        serde_json::from_str(&here.read("runs/scene/manifest.json")).expect("JSON");
    assert_eq!(manifest["solver"]["held"], held);
}

/// A harmonic oscillator by the implicit midpoint rule: q = cos t. The estimate leaves the terms of t⁴ out, a part of t²/4 of the error and of
/// the next order again; where the step is a tenth, a hundredth of it at most. A method that a tolerance sets has none.
#[test]
fn the_error_of_the_states_is_estimated() {
    let scene = "[system]\nvariables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 + q^2/2\"\n\
                 [method]\nstepper = \"implicit-midpoint\"\ntime-step = 0.1\n[run]\ninitial = [1, 0]\nsteps = 400\n";
    let here = Place::with(scene);
    let said = here.leafwise(&["run", "scene.toml", "--error", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let (q, p) = (
        number(&json["final_state"][0]),
        number(&json["final_state"][1]),
    );
    // cos 40 and −sin 40.
    let exact = (-0.666_938_061_652_261_8, -0.745_113_160_479_348_8);
    let error = (q - exact.0).abs().max((p - exact.1).abs());
    let estimate = &json["state_error"];
    assert!(
        (number(&estimate["at_end"]) / error - 1.0).abs() < 0.01,
        "{estimate} {error}"
    );
    assert!(number(&estimate["largest"]) >= number(&estimate["at_end"]));
    assert_eq!(estimate["is_large"], false);
    // Said of what was already complete, too.
    here.leafwise(&["run", "scene.toml", "--error"])
        .says(&["by a pass with half the step"]);
    let long = here.leafwise(&[
        "run",
        "scene.toml",
        "--error",
        "--force",
        "--set",
        "method.time-step=1.5",
    ]);
    assert_eq!(long.code, Some(0), "{}", long.err);
    long.says(&["error    large"]);
    for stepper in [
        "{ name = \"taylor\", tolerance = 1e-9 }",
        "\"dop853\"",
        "\"dormand-prince45\"",
    ] {
        let adaptive = format!("method={{ stepper = {stepper}, time-step = 0.1 }}");
        let none = here.leafwise(&[
            "run",
            "scene.toml",
            "--error",
            "--force",
            "--set",
            &adaptive,
        ]);
        assert_eq!(none.code, Some(0), "{}", none.err);
        none.says(&["not estimated: a tolerance sets this method's error"]);
    }
    let pieces = "system.hamiltonian=p^2/2 + max(0, abs(q) - 1)";
    let pieces = ["--set", pieces, "--set", "method.stepper=splitting"];
    let none = here.leafwise(&[&["run", "scene.toml", "--error", "--force"], &pieces[..]].concat());
    assert_eq!(none.code, Some(0), "{}", none.err);
    none.says(&["not estimated: steps across the seams"]);
}

/// Not from a checkpoint that was copied from another run, nor under a scene that was edited in the run's folder, nor where
/// another time at the end asks for steps of another length.
#[test]
fn a_run_is_not_continued_as_another() {
    let here = Place::with(&BODY.replace("every = 3", "every = 1000"));
    let run = |out: &str, set: &[&str]| {
        let set = set.iter().flat_map(|value| ["--set", value]);
        let arguments: Vec<&str> = ["run", "scene.toml", "--out", out]
            .into_iter()
            .chain(set)
            .collect();
        here.leafwise(&arguments)
    };
    let half = "method.time-step=0.05";
    for (out, set) in [("whole", &[][..]), ("half", &[half])] {
        let said = run(out, set);
        assert_eq!(said.code, Some(0), "{}", said.err);
    }
    let [whole, other] = ["whole", "half"].map(|of| here.path(&format!("{of}/checkpoint.bin")));
    std::fs::copy(&whole, &other).expect("copied");
    let refused = run("half", &[half, "run.steps=80"]);
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    refused.says(&["it is of another scene", "--force"]);
    let edited = here
        .read("whole/scene.toml")
        .replace("I2 = 0.75", "I2 = 0.8");
    here.write("whole/scene.toml", &edited);
    let refused = run("whole", &["system.parameters.I2=0.8", "run.steps=80"]);
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    refused.says(&["it is of another scene"]);
    // Steps of 0.1 come to 2 and to 4, and those that come to 2.05 are shorter.
    here.write("scene.toml", &BODY.replace("steps   = 40", "until = 2"));
    let until = |time: &str| run("until", &[&format!("run.until={time}")]);
    assert_eq!(until("2").code, Some(0));
    assert_eq!(until("4").code, Some(0));
    let refused = until("5.05");
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    refused.says(&["steps of another length"]);
}

/// `error = "estimate"` in a scene is `--error`, and another word is refused.
#[test]
fn a_scene_asks_for_the_error_of_its_states() {
    let here = Place::new();
    let scene = "[system]\nlibrary = \"rigid-body\"\n[method]\nrealization = \"auto\"\ntime-step = 0.1\n[run]\ninitial = [1, 3, 3]\nsteps = 50\n";
    here.write("asked.toml", &format!("{scene}error = \"estimate\"\n"));
    here.write("plain.toml", scene);
    let by_key = here.leafwise(&["run", "asked.toml", "--json"]).json();
    let by_flag = here
        .leafwise(&["run", "plain.toml", "--json", "--error"])
        .json();
    assert!(
        by_key["state_error"]["largest"].as_f64().is_some(),
        "{by_key}"
    );
    assert_eq!(by_key["state_error"], by_flag["state_error"]);
    let without = here
        .leafwise(&["run", "plain.toml", "--json", "--out", "other"])
        .json();
    assert!(without["state_error"].is_null());
    let said = here.leafwise(&["run", "asked.toml", "--set", "run.error=guess"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&["estimate"]);
}

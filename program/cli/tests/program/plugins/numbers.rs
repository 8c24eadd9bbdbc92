//! Runs, comparisons and measurements on parts of plugins.

use std::fs;

use super::build::{Workshop, rust_example};
use super::{command, leafwise, scene};
use crate::support::Place;

/// A system in C, a realization in Rust, the program's own dynamics: they run, and do what they declare.
#[test]
fn parts_of_two_libraries_run_and_pass_verify() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let system = workshop.compile("../../../examples/c/gyrostat");
    let realization = rust_example();
    let of_others = workshop.compile("motions");
    let text = scene(
        &[&system, &realization, &of_others],
        "library = \"example-c/gyrostat\"\nparameters = { rotor = 0.25 }",
        "realization = { name = \"example/so3-rodrigues\", path = \"numbers\" }\n\
         dynamics = { name = \"hamilton-jacobi\", order = 2 }",
        "[0.3, 1.0, -0.7]",
    );
    here.write(
        "scene.toml",
        &text.replace("time-step = 0.05", "time-step = 0.1"),
    );
    let said = leafwise(&here, &["run", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let spin = said.json()["drift"]["spin"].as_f64().expect("the Casimir");
    assert!(spin <= 200.0 * f64::EPSILON, "{spin:e}");
    let manifest = here.read("runs/scene/manifest.json");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    let plugins = manifest["plugins"].as_array().expect("the libraries");
    assert_eq!(plugins.len(), 2);
    for plugin in plugins {
        assert_eq!(plugin["sha256"].as_str().map(str::len), Some(64));
        assert_eq!(plugin["abi"], "1.0");
    }
    assert_eq!(manifest["system"]["path"], "numbers");
    assert_eq!(manifest["parts"][0]["path"], "numbers");
    assert_eq!(manifest["path"], "numbers, by calls; evaluators");
    let said = leafwise(&here, &["check", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert_eq!(said.json()["jacobi"]["verdict"], "numerically zero");
    let verify = ["verify", "scene.toml", "--json", "--html", "page.html"];
    let said = leafwise(&here, &verify);
    let json = said.json();
    let rows = json["rows"].as_array().expect("rows");
    let broken: Vec<_> = rows.iter().filter(|row| row["met"] != true).collect();
    assert_eq!(said.code, Some(0), "{broken:#?}");
    let own = rows.iter().filter(|row| {
        let map = row["map"].as_str().unwrap_or_default();
        map.contains("example/so3-rodrigues") && map.contains("hamilton-jacobi")
    });
    let own: Vec<_> = own.collect();
    assert!(!own.is_empty(), "{rows:#?}");
    for row in own {
        assert_eq!(row["declared"]["structure"], "exact");
        assert_eq!(row["measured"]["judgements"]["structure"], "met", "{row:#}");
        assert_eq!(row["measured"]["judgements"]["order"], "met", "{row:#}");
    }
    // Formulas of another tensor or motion do not fit, and break no declaration.
    let fits_not = |part: &str, reason: &str| {
        json["refused"]
            .as_array()
            .expect("combinations")
            .iter()
            .any(|entry| {
                entry["combination"]
                    .as_str()
                    .is_some_and(|name| name.contains(part))
                    && entry["reason"]
                        .as_str()
                        .is_some_and(|why| why.contains(reason))
            })
    };
    assert!(fits_not(
        "motions/log-canonical",
        "it realizes another tensor"
    ));
    assert!(fits_not("motions/turn", "it follows another motion"));
    // What does not fit is reported in full here, and a reason at a time to a reader.
    let refused = json["refused"].as_array().expect("combinations");
    let lacking = |entry: &&serde_json::Value| {
        let reason = entry["reason"].as_str().unwrap_or_default();
        reason.contains("needs formulas of the system")
    };
    assert!(refused.iter().filter(lacking).count() > 10, "{refused:#?}");
    let page = here.read("page.html");
    let reason = "formulas of the system are needed, and example-c/gyrostat offers only numbers";
    assert_eq!(page.matches(reason).count(), 1);
    assert!(
        page.contains("<b>clebsch, constant, darboux-magnetic, "),
        "{page}"
    );
}

/// What a call costs is not counted: methods are compared by time, where that was measured.
#[test]
fn methods_on_a_system_of_numbers_are_compared_by_time() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let system = workshop.compile("../../../examples/c/gyrostat");
    let method = "realization = \"karasev-collocated\"\n\
                  dynamics = { name = \"hamilton-jacobi\", order = 2 }";
    let of_library = "library = \"example-c/gyrostat\"";
    here.write(
        "scene.toml",
        &scene(&[&system], of_library, method, "[0.3, 1.0, -0.7]"),
    );
    let only = "karasev-collocated+hamilton-jacobi:2,gauss:2,rk4";
    let compare = |more: &[&str]| {
        let common = [
            "compare",
            "scene.toml",
            "--only",
            only,
            "--steps",
            "100,200",
        ];
        let said = leafwise(&here, &[&common, more].concat());
        assert_eq!(said.code, Some(0), "{}", said.err);
        said
    };
    let json = compare(&["--json"]).json();
    assert_eq!(json["fronts_by"], "time");
    let points = json["points"].as_array().expect("points");
    assert_eq!(points.len(), 6, "{points:#?}");
    let is_of = |point: &serde_json::Value, front: &str| point["front"][front] == true;
    assert!(
        points.iter().any(|point| is_of(point, "all")),
        "{points:#?}"
    );
    assert!(
        points.iter().any(|point| is_of(point, "poisson")),
        "{points:#?}"
    );
    for point in points {
        assert_eq!(point["front"]["all"], point["front"]["wall"], "{point:#}");
    }
    let said = compare(&[]);
    assert!(
        said.out
            .contains("the operations of this system's functions are not known"),
        "{}",
        said.out
    );
    assert!(said.out.contains("karasev-collocated"), "{}", said.out);
    let said = compare(&["--repeat", "0"]);
    assert!(
        said.out.contains("--repeat 3 measures times"),
        "{}",
        said.out
    );
    // A search needs a cost without noise; it says what it took.
    let tune = ["tune", "scene.toml", "--error", "1e-3", "--only", only];
    let said = leafwise(&here, &tune);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let text = format!("{}{}", said.out, said.err);
    assert!(text.contains("costs are compared in evaluations"), "{text}");
    assert!(!said.out.contains("operations"), "{}", said.out);
    let json = leafwise(&here, &[&tune[..], &["--json"]].concat()).json();
    assert_eq!(json["costs_in"], "evaluations");
    assert!(json["recommended"]["predicted"]["operations"].is_null());
}

/// Which parts computed by formulas and which by calls is read off the manifest.
#[test]
fn a_manifest_tells_the_path_that_was_taken() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let gyrostat = workshop.compile("../../../examples/c/gyrostat");
    let steps = workshop.compile("steps");
    let rust = rust_example();
    let rodrigues = |path: &str| {
        format!(
            "realization = {{ name = \"example/so3-rodrigues\", path = \"{path}\" }}\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}"
        )
    };
    let collocated = "realization = \"karasev-collocated\"\n\
                      dynamics = { name = \"hamilton-jacobi\", order = 2 }";
    let composed = format!("{collocated}\ncomposition = \"suzuki-4\"");
    let (body, own) = ("rigid-body", "example-c/gyrostat");
    let compiled = "expressions, compiled to straight-line code";
    for (system, method, path, parts) in [
        (
            body,
            rodrigues("expressions"),
            format!("{compiled}; one kernel; "),
            &["expressions"; 2][..],
        ),
        (
            body,
            rodrigues("numbers"),
            format!(
                "numbers, by calls: realization; {compiled}: system, dynamic approximation; evaluators; "
            ),
            &["numbers", "expressions"],
        ),
        (
            own,
            rodrigues("expressions"),
            format!(
                "numbers, by calls: system, dynamic approximation; {compiled}: realization; evaluators; "
            ),
            &["expressions", "numbers"],
        ),
        (
            own,
            collocated.to_owned(),
            "numbers, by calls; fused".to_owned(),
            &["numbers"; 2],
        ),
        (
            own,
            composed,
            "numbers, by calls; fused".to_owned(),
            &["numbers"; 2],
        ),
        (
            own,
            "stepper = \"rk4\"".to_owned(),
            "numbers, by calls; a step map of its own".to_owned(),
            &["numbers"],
        ),
        (
            body,
            "stepper = \"steps/heun\"".to_owned(),
            format!("numbers, by calls: stepper; {compiled}: system; a step map of its own; "),
            &["numbers"],
        ),
    ] {
        let libraries = [&gyrostat, &steps, &rust].map(|library| library.as_path());
        let system = format!("library = \"{system}\"");
        here.write(
            "scene.toml",
            &scene(&libraries, &system, &method, "[0.3, 1, -0.7]"),
        );
        let said = leafwise(&here, &["run", "scene.toml", "--force"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let manifest = here.read("runs/scene/manifest.json");
        let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
        let said = manifest["path"].as_str().expect("a path");
        assert!(said.starts_with(&path), "{said}\nand not\n{path}");
        assert!(said == path || path.ends_with("; "), "{said}");
        for (part, path) in manifest["parts"]
            .as_array()
            .expect("parts")
            .iter()
            .zip(parts)
        {
            assert_eq!(part["path"], *path, "{part:#}");
        }
    }
}

/// What was begun with one file of a plugin is not continued with another.
#[test]
fn a_run_is_not_continued_with_another_file_of_a_plugin() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("formulas");
    let system = "library = \"formulas/pendulum\"";
    let method = "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }";
    let text = scene(&[&library], system, method, "[1, 0]");
    here.write("scene.toml", &text);
    let said = leafwise(&here, &["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    // What a kill behind the last checkpoint leaves.
    let manifest = here.read("runs/scene/manifest.json");
    assert!(manifest.contains("\"outcome\": \"done\""));
    let running = manifest.replace("\"outcome\": \"done\"", "\"outcome\": \"running\"");
    here.write("runs/scene/manifest.json", &running);
    let first = fs::read(&library).expect("the library");
    let other = workshop.compile_with("formulas", &["-O1"]);
    assert_ne!(fs::read(other).expect("the library"), first);
    let said = leafwise(&here, &["run", "scene.toml"]);
    assert_eq!(said.code, Some(2), "{}", said.err);
    said.says(&[
        "holds a run begun with another",
        "libformulas.so",
        "--force",
    ]);
    fs::remove_file(&library).expect("our own file");
    fs::write(&library, first).expect("a writable folder");
    let said = leafwise(&here, &["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["resumed at step"]);
}

/// Making an instance may take a second: a run asks for evaluators again and again, and makes an instance for as many as there are at once.
#[test]
fn a_run_makes_few_instances() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let system = workshop.compile("counts_instances");
    let text = scene(
        &[&system],
        "library = \"gallery/counts-instances\"",
        "stepper = \"rk4\"",
        "[0.3, 1.0, -0.7]",
    );
    here.write("scene.toml", &text);
    let made = |arguments: &[&str]| {
        let file = here.path("instances");
        fs::write(&file, "").expect("writable");
        let run = command(&here, arguments).env("INSTANCES", &file).output();
        let run = run.expect("a run");
        assert!(
            run.status.success(),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        fs::read(&file).expect("a file").len()
    };
    // What the library is tried by, in another process.
    let tried = made(&["check", "scene.toml"]);
    let all = made(&["run", "scene.toml"]);
    assert!(tried > 0 && all <= tried + 12, "{tried} {all}");
}

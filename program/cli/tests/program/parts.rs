//! Parts by name: `verify`, `auto`, steppers and compositions in a scene.

#[cfg(target_os = "linux")]
use crate::support::refusing_threads;
use crate::support::{BODY, Place, Said};

#[test]
fn every_declaration_of_every_part_is_met() {
    let here = Place::new();
    let said = here.leafwise(&["verify", "--json", "--html", "verify.html"]);
    let json = said.json();
    let failing: Vec<_> = json["rows"]
        .as_array()
        .expect("rows")
        .iter()
        .filter(|row| row["met"] != true)
        .map(|row| format!("{} on {}: {}", row["map"], row["problem"], row["measured"]))
        .collect();
    assert!(failing.is_empty(), "{}", failing.join("\n"));
    assert_eq!(said.code, Some(0));
    assert_eq!(json["outcome"], "met");
    let rows = json["rows"].as_array().expect("rows");
    assert!(rows.len() >= 50, "{} step maps", rows.len());
    for row in rows {
        let measured = &row["measured"];
        assert!(measured["evaluations_per_step"].is_number(), "{row}");
        assert!(measured["casimir_drift"].is_number(), "{row}");
    }
    assert!(
        json["refused"]
            .as_array()
            .is_some_and(|refused| !refused.is_empty())
    );
    let undecided = rows
        .iter()
        .filter(|row| row["measured"]["judgements"]["order"] == "undecided");
    assert!(10 * undecided.count() < rows.len(), "most orders are seen");
    let page = here.read("verify.html");
    assert!(page.contains("<h2>rigid-body</h2>") && !page.contains("http"));
    assert_eq!(page.matches("<svg").count(), 3);
    assert_eq!(page.matches("<polyline").count(), rows.len());
}

#[test]
fn verify_measures_on_a_scene() {
    let here = Place::with(BODY);
    let said = here.leafwise(&["verify", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(said.err.contains("combinations on"), "{}", said.err);
    let json = said.json();
    let rows = json["rows"].as_array().expect("rows").len();
    assert!(rows >= 20);
    // For a reader: a row a map, its name last, then the verdict.
    let said = here.leafwise(&["verify", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let met = said
        .out
        .lines()
        .filter(|line| line.starts_with("  ok") || line.starts_with("  ?"));
    assert_eq!(met.count(), rows, "{}", said.out);
    assert!(said.out.contains("no declaration of"), "{}", said.out);
}

/// Everything is measured one after the other where the machine grants no thread.
#[cfg(target_os = "linux")]
#[test]
fn verify_does_without_threads_that_are_not_granted() {
    let here = Place::with(BODY);
    let output = here
        .command(&["verify", "scene.toml", "--json"])
        .env("LD_PRELOAD", refusing_threads(&here))
        .output();
    let said = Said::from(output.expect("the program starts"));
    assert_eq!(said.code, Some(0), "{}", said.err);
    let rows = said.json()["rows"].as_array().map_or(0, Vec::len);
    assert!(rows >= 20, "{rows} maps");
}

#[test]
fn auto_takes_a_closed_form_and_says_why() {
    let here = Place::with(BODY);
    let said = here.leafwise(&[
        "run",
        "scene.toml",
        "--set",
        "method.realization=auto",
        "--explain",
    ]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["so3-exponential", "since the tensor is that of so(3)*"]);
}

#[test]
fn a_composition_raises_the_order_of_a_scene() {
    let here = Place::with(BODY);
    let drift = |composition: &str| {
        let set = format!("method.composition={composition}");
        let said = here.leafwise(&[
            "run",
            "scene.toml",
            "--set",
            "method.realization=auto",
            "--set",
            "method.dynamics.order=2",
            "--set",
            &set,
            "--force",
            "--json",
        ]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        said.json()["drift"]["energy"].as_f64().expect("a number")
    };
    assert!(drift("suzuki-umeno-8") < 1e-3 * drift("none"));
}

#[test]
fn a_stepper_stands_in_place_of_realization_and_dynamics() {
    let here = Place::with(BODY);
    // An override replaces what it cannot be combined with; a scene that names both is refused.
    let said = here.leafwise(&[
        "run",
        "scene.toml",
        "--set",
        "method.stepper=splitting",
        "--json",
    ]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert_eq!(said.json()["solver"]["evaluations_per_step"], 1.0);
    here.write(
        "scene.toml",
        &BODY.replace("[run]", "stepper = \"splitting\"\n[run]"),
    );
    let said = here.leafwise(&["run", "scene.toml", "--force"]);
    assert_eq!(said.code, Some(3), "{}", said.out);
    said.says(&[
        "`realization` cannot be combined with `stepper`",
        "scene.toml:8:1",
    ]);
    let said = here.leafwise(&["run", "scene.toml", "--set", "method.stepper=splittin"]);
    assert_eq!(said.code, Some(3));
    said.says(&["did you mean `splitting`?"]);
}

#[test]
fn a_map_that_is_not_self_adjoint_is_not_composed() {
    let here = Place::with(BODY);
    let said = here.leafwise(&[
        "run",
        "scene.toml",
        "--set",
        "method.dynamics=collective",
        "--set",
        "method.composition=suzuki-4",
    ]);
    assert_eq!(said.code, Some(3), "{}", said.out);
    said.says(&["self-adjoint"]);
}

#[test]
fn a_pair_that_cannot_be_combined_is_refused_with_what_fits() {
    let here = Place::with(BODY);
    let refused = |sets: &[&str], pieces: &[&str]| {
        let mut arguments = vec!["check", "scene.toml"];
        for set in sets {
            arguments.extend(["--set", *set]);
        }
        let said = here.leafwise(&arguments);
        assert_eq!(said.code, Some(3), "{}", said.out);
        said.says(pieces);
    };
    refused(
        &["method.realization=log-canonical"],
        &[
            "log-canonical does not fit",
            "these fit: ",
            "so3-exponential",
            "karasev-collocated",
        ],
    );
    let magnetic = "[system]\nlibrary = \"magnetic\"\n[method]\n\
                    realization = \"darboux-magnetic\"\ntime-step = 0.1\n\
                    [run]\ninitial = [1, 0, 0, 0, 1, 0]\nsteps = 1\n";
    here.write("scene.toml", magnetic);
    refused(&[], &["potential"]);
}

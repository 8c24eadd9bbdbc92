//! `list`, `describe`, `evaluate`, `new`, and how the program treats its own command line.

use crate::support::{BODY, Place};

#[test]
fn every_listed_name_is_described() {
    let here = Place::new();
    let said = here.leafwise(&["list", "--json"]);
    assert_eq!(said.code, Some(0));
    let lists = said.json();
    let mut count = 0;
    for list in lists.as_object().expect("an object").values() {
        for entry in list.as_array().expect("a list") {
            let name = entry["name"].as_str().expect("a name");
            assert!(
                !entry["summary"].as_str().expect("a summary").is_empty(),
                "{name}"
            );
            let said = here.leafwise(&["describe", name]);
            assert_eq!(said.code, Some(0), "{name}");
            assert!(said.out.starts_with(name), "{}", said.out);
            assert_eq!(
                here.leafwise(&["describe", name, "--json"]).json()["name"],
                name
            );
            count += 1;
        }
    }
    assert!(count >= 20, "{count} names");
    let both = here.leafwise(&["describe", "so4", "--json"]).json();
    assert_eq!(both["kind"], "system");
    assert_eq!(both["lie_algebra"]["kind"], "lie-algebra");
    let one = here.leafwise(&["list", "dynamics"]);
    assert!(
        one.out.contains("hamilton-jacobi") && !one.out.contains("karasev"),
        "{}",
        one.out
    );
}

#[test]
fn an_unknown_name_is_a_usage_error_with_its_neighbour() {
    let here = Place::new();
    let said = here.leafwise(&["describe", "karasev-trunkated"]);
    assert_eq!(said.code, Some(2));
    said.says(&["did you mean `karasev-truncated`?"]);
    let said = here.leafwise(&["new", "--library", "rigid-bodi"]);
    assert_eq!(said.code, Some(2));
    said.says(&["did you mean `rigid-body`?"]);
    let said = here.leafwise(&["run", "missing.toml"]);
    assert_eq!(said.code, Some(2));
    said.says(&["there is no file missing.toml", "leafwise new"]);
    let said = here.leafwise(&["run", "."]);
    assert_eq!(said.code, Some(2));
    said.says(&[". is a folder", "the folder holds none"]);
    assert_eq!(here.leafwise(&["walk"]).code, Some(2));
    assert_eq!(here.leafwise(&["run"]).code, Some(2));
    assert_eq!(here.leafwise(&["--help"]).code, Some(0));
    assert!(here.is_untouched());
    here.write("body.toml", BODY);
    let said = here.leafwise(&["check", "."]);
    said.says(&["name one scene in it, as ./body.toml; it holds 1 file *.toml"]);
}

#[test]
fn evaluate_gives_karasevs_coefficients_and_the_hamilton_jacobi_terms() {
    let scene = BODY
        .replace("order = 4", "order = 6")
        .replace("order = 2", "order = 8")
        .replace("time-step   = 0.1", "epsilon = 0.5\nh = 0.2");
    let here = Place::with(&scene);
    let at = [
        "evaluate",
        "scene.toml",
        "--x",
        "2,3,3",
        "--p",
        "1,2,3",
        "--json",
    ];
    let json = here.leafwise(&at).json();
    let list = |value: &serde_json::Value| -> Vec<f64> {
        let numbers = value.as_array().expect("a list");
        numbers
            .iter()
            .map(|number| number.as_f64().expect("a number"))
            .collect()
    };
    let coefficients: Vec<Vec<f64>> = json["alpha_coefficients"]
        .as_array()
        .expect("a list")
        .iter()
        .map(list)
        .collect();
    assert_eq!(coefficients.len(), 7);
    // The series of so(3)* in the weights of the paper: -x cross p / 2, B_2/2! (x cross p) cross p.
    assert_eq!(coefficients[0], [2.0, 3.0, 3.0]);
    assert_eq!(coefficients[1], [-1.5, 1.5, -0.5]);
    let expected = [-11.0 / 12.0, -2.0 / 3.0, 0.75];
    for (value, expected) in coefficients[2].iter().zip(expected) {
        assert!((value - expected).abs() <= 1e-14, "{value}");
    }
    assert_eq!(coefficients[3], [0.0; 3]);
    // alpha and beta are the sums at the scene's epsilon, with p and -p.
    for (name, sign) in [("alpha", 1.0), ("beta", -1.0)] {
        for (i, value) in list(&json[name]).into_iter().enumerate() {
            let sum: f64 = (0..7)
                .map(|k| coefficients[k][i] * (0..k).fold(1.0, |power, _| power * 0.5 * sign))
                .sum();
            assert!(
                (value - sum).abs() <= 4e-15 * sum.abs().max(1.0),
                "{name}[{i}]"
            );
        }
    }
    // The scene's epsilon does not enter the coefficients.
    let other = here
        .leafwise(&[&at[..], &["--set", "method.epsilon=0.25"]].concat())
        .json();
    assert_eq!(other["alpha_coefficients"], json["alpha_coefficients"]);

    let json = here
        .leafwise(&["evaluate", "scene.toml", "--x", "1,3,3", "--json"])
        .json();
    let terms = json["hamilton_jacobi"].as_object().expect("an object");
    assert_eq!(terms.keys().collect::<Vec<_>>(), ["1", "3", "5", "7"]);
    // S_7 from three independent derivations, at epsilon = 1/2: times 2^-6.
    let s7 = terms["7"]["S"].as_f64().expect("a number");
    let expected = 69_204_901.0 / 265_781_250.0 / 64.0;
    assert!((s7 / expected - 1.0).abs() <= 1e-13, "{s7}");
    assert_eq!(terms["7"]["dS"].as_array().map(Vec::len), Some(3));
}

#[test]
fn evaluate_takes_decimals_exactly() {
    // The ninth coefficient of the paper's Lotka-Volterra system at decimals that are no doubles:
    // rounding the point alone would cost five digits here. Value from the reference derivation.
    let here = Place::new();
    assert_eq!(
        here.leafwise(&["new", "--library", "lotka-volterra"]).code,
        Some(0)
    );
    let json = here
        .leafwise(&[
            "evaluate",
            "lotka_volterra.toml",
            "--set",
            "method.realization.order=8",
            "--x",
            "0.5,1.5,0.25",
            "--p",
            "-0.3,0.2,0.7",
            "--json",
        ])
        .json();
    let value = json["alpha_coefficients"][8][0].as_f64().expect("a number");
    assert!(
        (value / 6.842424503709904e-10 - 1.0).abs() <= 1e-15,
        "{value:e}"
    );
}

/// Realizations of numbers have the values of those of code: α̂ and β̂ do not depend on how they are
/// computed, but for round-off.
#[test]
fn evaluate_prints_the_ends_of_realizations_of_numbers() {
    let here = Place::with(BODY);
    let ends = |realization: &str| -> Vec<f64> {
        let set = format!("method.realization={realization}");
        let p = ["--p", "1,-0.5,2", "--x", "1,3,3", "--json"];
        let said = here.leafwise(&[&["evaluate", "scene.toml", "--set", &set][..], &p].concat());
        assert_eq!(said.code, Some(0), "{realization}: {}", said.err);
        let json = said.json();
        let lists = ["alpha", "beta"].map(|name| json[name].as_array().expect("a list").clone());
        let numbers = lists.concat();
        numbers
            .iter()
            .filter_map(serde_json::Value::as_f64)
            .collect()
    };
    let expected = ends("so3-exponential");
    assert_eq!(expected.len(), 6);
    for realization in [
        "karasev-collocated",
        "lie-poisson",
        "{name=\"so3-group\",chart=\"exponential\"}",
    ] {
        let values = ends(realization);
        assert_eq!(values.len(), 6, "{realization}");
        for (value, expected) in values.iter().zip(&expected) {
            // The state's size is 4, each end some dozen operations or a solve to round-off.
            assert!(
                (value - expected).abs() < 1e-14,
                "{realization}: {value} {expected}"
            );
        }
    }
    // Not even the algebra of a realization of numbers needs a closed form.
    let solvable = "[system]\nvariables = [\"a\", \"b\", \"c\", \"d\"]\n\
                    bracket = { \"a,b\" = \"b\", \"a,c\" = \"c + b\", \"a,d\" = \"2*d\" }\n\
                    hamiltonian = \"a^2/2 + b + c*d\"\n[method]\nrealization = \"lie-poisson\"\n\
                    dynamics = { name = \"hamilton-jacobi\", order = 2 }\ntime-step = 0.1\n[run]\n\
                    initial = [1, 2, 3, 4]\nsteps = 1\n";
    let here = Place::with(solvable);
    let json = here.leafwise(&["evaluate", "scene.toml", "--json"]).json();
    assert_eq!(json["alpha"], serde_json::json!([1.0, 2.0, 3.0, 4.0]));
    assert_eq!(json["beta"], json["alpha"]);
}

#[test]
fn evaluate_prints_no_values_where_there_are_none() {
    let here = Place::with(BODY);
    // epsilon is 1: a rotation by 7 is beyond 2 pi.
    for realization in [
        "so3-exponential",
        "lie-poisson",
        "{name=\"so3-group\",chart=\"exponential\"}",
    ] {
        for p in ["7,0,0", "0,300,0"] {
            let set = format!("method.realization={realization}");
            let set = [
                "--set",
                &set,
                "--set",
                "method.epsilon=1",
                "--set",
                "method.h=0.1",
            ];
            let scene = BODY.replace("time-step   = 0.1", "epsilon = 1\nh = 0.1");
            let here = Place::with(&scene);
            let said = here.leafwise(&[&["evaluate", "scene.toml", "--p", p][..], &set].concat());
            assert_eq!(
                said.code,
                Some(2),
                "{realization} at {p}: {}{}",
                said.out,
                said.err
            );
            said.says(&["outside the realization's chart", "leafwise describe"]);
            assert_eq!(said.out, "");
        }
    }
    let said = here.leafwise(&["evaluate", "scene.toml", "--x", "1e200,1e200,1"]);
    assert_eq!(said.code, Some(2), "{}", said.out);
    said.says(&["S_1 is not finite there (inf)"]);
    assert_eq!(said.out, "");
}

#[test]
fn evaluate_refuses_points_of_another_dimension() {
    let here = Place::with(BODY);
    let said = here.leafwise(&["evaluate", "scene.toml", "--x", "1,2"]);
    assert_eq!(said.code, Some(2));
    said.says(&["--x has 2 numbers"]);
    let said = here.leafwise(&["evaluate", "scene.toml", "--p", "-1,two,3"]);
    assert_eq!(said.code, Some(2));
    said.says(&["`two` is not a decimal number"]);
}

#[test]
fn a_new_scene_checks_and_runs_and_is_never_overwritten() {
    let here = Place::new();
    assert_eq!(here.leafwise(&["new"]).code, Some(0));
    assert_eq!(here.leafwise(&["check", "scene.toml"]).code, Some(0));
    // It is a body as it turns: Euler's equations, m' = m × ω, whose first component is m2 m3 (1/I3 - 1/I2).
    let motion = here.leafwise(&["check", "scene.toml", "--json"]).json()["motion"].clone();
    assert_eq!(motion["x1"], "(-1/I2 + 1/I3)*x2*x3");
    let said = here.leafwise(&["check", "scene.toml"]);
    assert!(
        said.out.contains("turns as a body, m' = m × ω"),
        "{}",
        said.out
    );
    let turned = here.leafwise(&["check", "scene.toml", "--set", "system.convention={H,x}"]);
    assert!(
        turned.out.contains("turns as a spin, s' = s × (-∂H/∂s)"),
        "{}",
        turned.out
    );
    let said = here.leafwise(&["run", "scene.toml", "--set", "run.steps=3"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    here.write("scene.toml", "mine");
    let said = here.leafwise(&["new"]);
    assert_eq!(said.code, Some(2));
    said.says(&["scene.toml exists"]);
    assert_eq!(here.read("scene.toml"), "mine");
    for system in ["heavy-top", "lotka-volterra", "toda"] {
        assert_eq!(here.leafwise(&["new", "--library", system]).code, Some(0));
        let file = format!("{}.toml", system.replace('-', "_"));
        let said = here.leafwise(&["run", &file, "--set", "run.steps=3"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
    }
}

#[test]
fn a_command_line_that_is_none_gives_json_too_where_asked() {
    let here = Place::with(BODY);
    for arguments in [
        &["run", "--json"][..],
        &["list", "gadgets", "--json"],
        &["evaluate", "scene.toml", "--y", "1", "--json"],
    ] {
        let said = here.leafwise(arguments);
        assert_eq!(said.code, Some(2), "{}", said.err);
        let json = said.json();
        assert_eq!(json["outcome"], "refused");
        assert!(json["error"]["message"].is_string(), "{json}");
    }
    let said = here.leafwise(&["run"]);
    assert_eq!((said.code, said.out.as_str()), (Some(2), ""));
}

#[test]
fn auto_is_described() {
    let said = Place::new().leafwise(&["describe", "auto"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    for piece in [
        "auto (in place of a part's name)",
        "closed form",
        "hamilton-jacobi of order 4",
    ] {
        assert!(said.out.contains(piece), "{piece}: {}", said.out);
    }
}

/// The page that an error names is there, and a warning's word is explained.
#[test]
fn errors_and_warnings_name_what_explains_them() {
    for (from, to, page) in [
        ("x1^2/(2*I1)", "x1^2/(2*I9)", "formulas"),
        ("\"x1,x2\" = \"-x3\"", "\"x1\" = \"-x3\"", "define-a-system"),
        ("karasev-truncated", "karasev", "choose"),
        ("every = 3", "evry = 3", "keys"),
    ] {
        let here = Place::with_body(from, to);
        let refused = here.leafwise(&["run", "scene.toml"]);
        assert_eq!(refused.code, Some(3), "{}", refused.err);
        refused.says(&[&format!("leafwise explain {page}")]);
        let explained = here.leafwise(&["explain", page]);
        assert_eq!(explained.code, Some(0), "{}", explained.err);
        assert!(explained.out.starts_with("# "), "{}", explained.out);
    }
    let here = Place::with_body("order = 4", "order = 14");
    let set = ["--set", "method.time-step=0.01"];
    let said = here.leafwise(&[&["run", "scene.toml"][..], &set[..]].concat());
    said.says(&["leafwise explain truncation-order"]);
    let explained = here.leafwise(&["explain", "truncation-order"]);
    assert!(explained.out.contains("a smaller n"), "{}", explained.out);
    let none = here.leafwise(&["explain", "formulaz"]);
    assert_eq!(none.code, Some(2));
    none.says(&["did you mean `formulas`?"]);
    // A library system leads to what `describe` prints, and everyday words to what the guide calls otherwise.
    for name in ["kepler", "lotka-volterra", "Point Vortices"] {
        let id = name.to_lowercase().replace(' ', "-");
        let (said, described) = (
            here.leafwise(&["explain", name]),
            here.leafwise(&["describe", &id]),
        );
        assert_eq!(said.code, Some(0), "{}", said.err);
        assert!(said.out.contains(&described.out), "{}", said.out);
    }
    let said = here.leafwise(&["explain", "exit", "codes"]);
    assert!(
        said.out.contains("interrupted, with a checkpoint"),
        "{}",
        said.out
    );
    let pages = here.leafwise(&["explain"]);
    assert!(pages.out.contains("read-the-report"), "{}", pages.out);
}

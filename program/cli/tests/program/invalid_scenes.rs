//! An invalid scene: exit code 3, the column in the file, the nearest valid name, and nothing
//! written.

use crate::support::{BODY, Place};

/// Runs a changed rigid body, which must be refused at `place` with every piece said.
fn refused(from: &str, to: &str, place: &str, pieces: &[&str]) {
    let here = Place::with_body(from, to);
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&[&format!("scene.toml:{place}")]);
    said.says(pieces);
    assert!(said.err.starts_with("error:"), "{}", said.err);
    assert!(here.is_untouched(), "something was written");
    let json = here.leafwise(&["run", "scene.toml", "--json"]).json();
    assert_eq!(json["outcome"], "refused");
    let problem = &json["error"]["problems"][0];
    assert_eq!(format!("{}:{}", problem["line"], problem["column"]), place);
}

#[test]
fn an_unknown_variable_is_named_with_its_neighbour() {
    refused(
        "x1^2/(2*I1)",
        "x7^2/(2*I1)",
        "5:16",
        &["unknown name `x7`", "did you mean `x1`?"],
    );
    refused(
        "\"x2,x3\"",
        "\"x2,y3\"",
        "4:38",
        &["unknown name `y3`", "did you mean `x3`?"],
    );
    refused(
        "\"-x3\"",
        "\"-z\"",
        "4:29",
        &["unknown name `z`", "x1, x2, x3, I1, I2, I3"],
    );
}

#[test]
fn an_unknown_parameter_is_named_with_its_neighbour() {
    refused(
        "2*I2",
        "2*I22",
        "5:38",
        &["unknown name `I22`", "did you mean `I2`?"],
    );
}

#[test]
fn an_unknown_function_is_named_with_its_neighbour() {
    refused(
        "x1^2/(2*I1)",
        "sine(x1)",
        "5:16",
        &["unknown function `sine`", "did you mean `sin`?"],
    );
    refused(
        "x1^2/(2*I1)",
        "log(x1)",
        "5:16",
        &["unknown function `log`", "did you mean `ln`?"],
    );
}

#[test]
fn a_formula_that_is_none_is_underlined_where_it_breaks() {
    refused("x1^2/(2*I1) +", "x1^2/(2*I1", "5:27", &[]);
    refused("x1^2 + x2^2 + x3^2", "x1^2 + * x2", "6:32", &["found `*`"]);
}

#[test]
fn an_unknown_method_or_parameter_of_one_is_named_with_its_neighbour() {
    let pieces = [
        "no realization is called `karasev-truncate`",
        "did you mean `karasev-truncated`?",
    ];
    refused(
        "\"karasev-truncated\"",
        "\"karasev-truncate\"",
        "8:25",
        &pieces,
    );
    let pieces = [
        "no dynamic approximation is called `hamilton_jacobi`",
        "`hamilton-jacobi`?",
    ];
    refused(
        "\"hamilton-jacobi\"",
        "\"hamilton_jacobi\"",
        "9:25",
        &pieces,
    );
    refused(
        "order = 4",
        "ordr = 4",
        "8:45",
        &[
            "`karasev-truncated` has no parameter `ordr`",
            "did you mean `order`?",
        ],
    );
    refused(
        "time-step   = 0.1",
        "time-stepp   = 0.1",
        "10:1",
        &["did you mean `time-step`?"],
    );
    let stepper = "time-step   = 0.1\ncomposition = \"suzuki\"";
    refused(
        "time-step   = 0.1",
        stepper,
        "11:16",
        &["no composition is called `suzuki`"],
    );
    let parts = "realization = { name = \"karasev-truncated\", order = 4 }\n\
                 dynamics    = { name = \"hamilton-jacobi\", order = 2 }";
    refused(
        parts,
        "stepper = { name = \"splitting\", composition = \"suzuki-4\" }",
        "8:33",
        &[
            "`splitting` has no parameter `composition`",
            "it is written next to the stepper: composition = \"suzuki-4\"",
        ],
    );
    refused(
        parts,
        "stepper = { name = \"rk4\", pieces = 2 }",
        "8:27",
        &["`rk4` has no parameter `pieces`", "it takes none"],
    );
}

#[test]
fn contradictory_entries_are_both_named() {
    refused(
        "\"x2,x3\" = \"-x1\"",
        "\"x2,x1\" = \"-x3\", \"x2,x3\" = \"-x1\"",
        "4:35",
        &[
            "`x1,x2` and `x2,x1` contradict each other",
            "antisymmetry fills in the other",
        ],
    );
    refused(
        "\"x2,x3\" = \"-x1\"",
        "\"x2,x2\" = \"-x1\"",
        "4:35",
        &["{x2, x2} is not zero"],
    );
}

#[test]
fn an_initial_state_of_the_wrong_dimension_is_refused() {
    refused("[1, 3, 3]", "[1, 3]", "12:11", &["2 entries", "expected 3"]);
    refused(
        "[1, 3, 3]",
        "[1, 3, nan]",
        "12:18",
        &["must be a finite number"],
    );
    refused(
        "[1, 3, 3]",
        "{ x1 = 1, x2 = 3 }",
        "12:11",
        &["no value for x3"],
    );
    let field = "{ x1 = 1, x2 = 3, x3 = \"ln(-1)\" }";
    refused(
        "[1, 3, 3]",
        field,
        "12:35",
        &["initial value of x3 is not a number"],
    );
}

#[test]
fn orders_outside_their_range_are_refused_with_what_is_allowed() {
    refused(
        "order = 4",
        "order = 0",
        "8:53",
        &["order = 0 is not allowed", "1 to 40"],
    );
    refused(
        "order = 4",
        "order = -3",
        "8:53",
        &["order = -3 is not allowed"],
    );
    refused(
        "order = 4",
        "order = 2.5",
        "8:53",
        &["must be a whole number"],
    );
    refused(
        "order = 2",
        "order = 0",
        "9:51",
        &["order = 0 is not allowed", "at least 2"],
    );
    refused(
        "order = 2",
        "order = -2",
        "9:51",
        &["order = -2 is not allowed"],
    );
    refused(
        "order = 2",
        "order = 5",
        "9:51",
        &["order = 5 is not allowed", "take 4 or 6"],
    );
}

#[test]
fn a_division_by_what_is_identically_zero_is_refused() {
    refused(
        "x1^2/(2*I1)",
        "x1^2/(x2 - x2)",
        "5:16",
        &["identically zero"],
    );
    refused(
        "x1^2/(2*I1)",
        "ln(-1)",
        "5:16",
        &["`ln` of -1 has no finite value"],
    );
    refused("x1^2/(2*I1)", "x1^x2", "5:16", &["write exp(b*ln(a))"]);
}

#[test]
fn an_unknown_observable_is_named_with_its_neighbour() {
    refused(
        "[\"energy\", \"spin\"]",
        "[\"energy\", \"spinn\"]",
        "14:50",
        &["did you mean `spin`?"],
    );
}

/// se(3)* with one structure constant changed: there every change breaks the Jacobi identity.
fn broken() -> String {
    let constants = [
        ("l1,l2", "-2*l3"),
        ("l2,l3", "-l1"),
        ("l3,l1", "-l2"),
        ("l1,p2", "-p3"),
        ("l2,p3", "-p1"),
        ("l3,p1", "-p2"),
        ("l1,p3", "p2"),
        ("l2,p1", "p3"),
        ("l3,p2", "p1"),
    ];
    let entries: Vec<String> = constants
        .iter()
        .map(|(pair, value)| format!("\"{pair}\" = \"{value}\""))
        .collect();
    BODY.replace(
        "\"x1\", \"x2\", \"x3\"",
        "\"l1\", \"l2\", \"l3\", \"p1\", \"p2\", \"p3\"",
    )
    .replace(
        "\"x1,x2\" = \"-x3\", \"x2,x3\" = \"-x1\", \"x3,x1\" = \"-x2\"",
        &entries.join(", "),
    )
    .replace(
        "x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)",
        "l1^2/I1 + p2^2/I2 + p3*l2/I3",
    )
    .replace("{ spin = \"x1^2 + x2^2 + x3^2\" }", "{}")
    .replace("[1, 3, 3]", "[1, 0.5, 0.3, 0.2, 0.7, 0.1]")
    .replace(", \"spin\"", "")
}

#[test]
fn a_tensor_that_violates_jacobi_fails_its_check_and_does_not_run_unless_told() {
    let here = Place::with(&broken());
    let said = here.leafwise(&["check", "scene.toml"]);
    assert_eq!(said.code, Some(5), "{}", said.err);
    assert!(
        said.out.contains("Jacobi identity  violated"),
        "{}",
        said.out
    );
    said.says(&[
        "scene.toml:4:15",
        "the Jacobi identity fails for",
        "--allow-non-poisson",
    ]);
    let json = here.leafwise(&["check", "scene.toml", "--json"]).json();
    assert_eq!(json["outcome"], "violated");
    assert_eq!(json["jacobi"]["verdict"], "violated");
    assert_eq!(json["jacobi"]["worst"].as_array().map(Vec::len), Some(3));
    assert!(
        json["jacobi"]["residual"]
            .as_f64()
            .is_some_and(|residual| residual > 1e-3)
    );

    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&["scene.toml:4:15", "the Jacobi identity fails for"]);
    assert!(here.is_untouched(), "something was written");

    // What is about Poisson systems alone refuses it too, without a flag that these commands do not have.
    for command in [
        &["shadow"] as &[&str],
        &["compare"],
        &["tune", "--error", "1e-3"],
    ] {
        let said = here.leafwise(&[command, &["scene.toml"]].concat());
        assert_eq!(said.code, Some(3), "{}", said.err);
        said.says(&["the Jacobi identity fails for", "correct the bracket"]);
        assert!(!said.err.contains("--allow"), "{}", said.err);
    }

    // Told to, it runs, whatever the Casimirs are then.
    let scene = broken().replace(
        "casimirs    = {}",
        "casimirs    = { square = \"p1^2 + l2\" }",
    );
    here.write("scene.toml", &scene);
    let said = here.leafwise(&["run", "scene.toml", "--allow-non-poisson"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["square"]);
}

#[test]
fn a_casimir_that_is_not_one_is_refused() {
    refused(
        "spin = \"x1^2 + x2^2 + x3^2\"",
        "spin = \"x1^2 + x2^2 + 2*x3^2\"",
        "6:25",
        &[
            "`spin` is not a Casimir",
            "of the size of its terms is left",
            "run.record.observables",
        ],
    );
    // A slip of a sign in the bracket: the entry is named, and with its other sign the scene is one.
    for entry in ["x1,x2", "x2,x3", "x3,x1"] {
        let own = BODY
            .lines()
            .find(|line| line.contains(entry))
            .expect("a bracket");
        let part = own.split(&format!("\"{entry}\"")).nth(1).expect("an entry");
        let value = part.split('"').nth(1).expect("a formula");
        let (from, to) = (
            format!("\"{entry}\" = \"{value}\""),
            format!("\"{entry}\" = \"{}\"", value.trim_start_matches('-')),
        );
        assert!(value.starts_with('-') && BODY.contains(&from), "{from}");
        let said = Place::with(&BODY.replace(&from, &to)).leafwise(&["check", "scene.toml"]);
        assert_eq!(said.code, Some(5), "{}", said.err);
        let [one, other] = [&entry[..2], &entry[3..]];
        let names = [format!("{{{one}, {other}}}"), format!("{{{other}, {one}}}")];
        let is_named = |name: &String| said.err.contains(&format!("change the sign of {name}"));
        assert!(names.iter().any(is_named), "{}", said.err);
    }
    let here = Place::with_body("x2^2 + x3^2\" }", "x2^2 + 2*x3^2\" }");
    let said = here.leafwise(&["check", "scene.toml"]);
    assert_eq!(said.code, Some(5), "{}", said.err);
    assert!(
        said.out.contains("Casimir spin     violated"),
        "{}",
        said.out
    );
}

#[test]
fn a_scene_in_another_encoding_is_refused_at_its_first_odd_byte() {
    let here = Place::new();
    let mut latin: Vec<u8> = b"[system]\n# vitesse ".to_vec();
    latin.extend_from_slice(b"\xe9lev\xe9e\n");
    std::fs::write(here.path("scene.toml"), latin).expect("a writable directory");
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&["not UTF-8", "scene.toml:2:11"]);
    assert!(here.is_untouched());
}

#[test]
fn a_lattice_longer_than_any_memory_is_refused() {
    let here = Place::with(
        r#"[system]
families    = { x = 1_000_000_000_000 }
bracket     = { "x[i],x[i+1]" = "x[i]*x[i+1]" }
hamiltonian = "sum(i, x[i])"
[method]
time-step = 0.1
[run]
initial = { "x[i]" = "1" }
steps   = 1
"#,
    );
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&["scene.toml:2:21", "a whole number of at most 100000000"]);
    assert!(here.is_untouched());
}

/// What other programs call a step and an end of time is answered with this one's words.
#[test]
fn the_usual_words_for_steps_and_ends_are_understood() {
    for (from, to, pieces) in [
        (
            "time-step   = 0.1",
            "dt = 0.1",
            &[
                "unknown key `dt`",
                "did you mean `time-step`?",
                "[method] needs `time-step`",
            ][..],
        ),
        (
            "steps   = 40",
            "steps = 40\nt-end = 10",
            &["unknown key `t-end`", "a run ends after `steps`"],
        ),
    ] {
        let here = Place::with_body(from, to);
        let said = here.leafwise(&["check", "scene.toml"]);
        assert_eq!(said.code, Some(3), "{}", said.err);
        said.says(pieces);
    }
}

#[test]
fn a_bad_override_is_not_shown_as_a_line_of_the_file() {
    let here = Place::with(BODY);
    let said = here.leafwise(&["check", "scene.toml", "--set", "run.steps=-5"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&["scene.toml with --set"]);
    // Beyond the integers of TOML's writer a number would become a word.
    let largest = format!("run.steps={}", u64::MAX);
    let said = here.leafwise(&["check", "scene.toml", "--set", &largest]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&["larger than any whole number of TOML"]);
    assert!(!said.err.contains("the string"), "{}", said.err);
}

//! Claims about reading scenes.

use super::*;
use crate::diagnostic::SceneDiagnostic;

const RIGID_BODY: &str = r#"# a rigid body
plugins = ["libextra.so"]

[system]
variables   = ["x1", "x2", "x3"]
parameters  = { I1 = 1.0, I2 = 0.75, I3 = 1_000.5 }
bracket     = { "x1,x2" = "-x3", "x2,x3" = "-x1", "x3,x1" = "-x2" }
hamiltonian = "x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)"
casimirs    = { spin = "x1^2 + x2^2 + x3^2" }

[method]
realization = { name = "karasev-truncated", order = 6 }
dynamics    = { name = "hamilton-jacobi", order = 2 }   # even
composition = "none"
epsilon = 0.1
h       = 2.0

[run]
initial = [1, 3, 3.5e0]
steps   = 1000
record  = { every = 10 }
"#;

const FRAGMENT: &str = r#"
[about]
reference = "somewhere"
[system]
families    = { x = 8 }
parameters  = { rate = 1.5 }
bracket     = { "x[i],x[i+1]" = "x[i]*x[i+1]" }
boundary    = "periodic"
convention  = "{x, H}"
hamiltonian = "rate*sum(i, x[i])"
"#;

const LIBRARY: [(&str, &str); 2] = [("volterra-lattice", FRAGMENT), ("broken", "[system\n")];

fn parse(text: &str) -> Result<SceneDocument, SceneErrors> {
    SceneDocument::parse("scene.toml", text, &LIBRARY)
}

fn with(overrides: &[(&str, &str)]) -> Result<SceneDocument, SceneErrors> {
    let owned: Vec<_> = overrides
        .iter()
        .map(|(path, value)| (path.to_string(), value.to_string()))
        .collect();
    SceneDocument::parse_with("scene.toml", RIGID_BODY, &owned, &LIBRARY)
}

/// The first diagnostic of the rigid body's scene with one piece replaced.
fn broken(from: &str, to: &str) -> SceneDiagnostic {
    assert!(RIGID_BODY.contains(from), "the scene has no {from}");
    let errors = parse(&RIGID_BODY.replace(from, to)).expect_err("the scene is wrong");
    errors.diagnostics().remove(0)
}

/// Line, column, underlined text, message and help of a diagnostic.
fn seen(diagnostic: &SceneDiagnostic) -> (usize, usize, &str, &str, &str) {
    let (line, column) = diagnostic.line_column();
    (
        line,
        column,
        &diagnostic.source_text[diagnostic.span.clone()],
        &diagnostic.message,
        diagnostic.help.as_deref().unwrap_or(""),
    )
}

#[test]
fn a_scene_reads_as_written_and_keeps_the_order_of_its_text() {
    let scene = parse(RIGID_BODY).expect("a valid scene");
    let names: Vec<_> = scene
        .system
        .parameters
        .iter()
        .map(|(n, _)| n.value.as_str())
        .collect();
    assert_eq!(names, ["I1", "I2", "I3"]);
    assert_eq!(scene.system.parameters[2].1.value.literal, "1000.5");
    let BracketSpec::Entries(entries) = &scene.system.bracket.value else {
        panic!("entries expected");
    };
    let keys: Vec<_> = entries.iter().map(|(key, _)| key.value.as_str()).collect();
    assert_eq!(keys, ["x1,x2", "x2,x3", "x3,x1"]);
    assert_eq!(scene.system.convention, Convention::HamiltonFirst);
    assert_eq!(scene.method.composition, None);
    let realization = scene.method.realization.as_ref().expect("a realization");
    assert_eq!(realization.name.value, "karasev-truncated");
    let (key, value) = &realization.parameters[0];
    assert_eq!(key.value, "order");
    let six = Number {
        literal: "6".to_owned(),
        value: 6.0,
    };
    assert_eq!(value.value, ParameterValue::Number(six));
    assert_eq!(&scene.text[value.span.clone()], "6");
    assert_eq!(
        (scene.method.step.epsilon(), scene.method.step.h()),
        (0.1, 2.0)
    );
    assert_eq!(scene.run.record.every, 10);
    let observables: Vec<_> = scene
        .run
        .record
        .observables
        .iter()
        .map(|name| name.value.as_str())
        .collect();
    assert_eq!(observables, ["energy", "spin"]);
    assert_eq!(scene.plugins[0].value, "libextra.so");
}

#[test]
fn places_inside_formulas_and_bracket_keys_are_exact() {
    let scene = parse(RIGID_BODY).expect("a valid scene");
    let formula = &scene.system.hamiltonian;
    let start = formula.value.find("I2").expect("I2 occurs");
    let place = scene.place_in_formula(formula, start..start + 2);
    let diagnostic = scene.diagnostic(&place, "unknown", "here", None);
    assert_eq!(diagnostic.line_column(), (8, 38));
    assert_eq!(&scene.text[diagnostic.span], "I2");
    let BracketSpec::Entries(entries) = &scene.system.bracket.value else {
        panic!("entries expected");
    };
    let place = scene.place_in_formula(&entries[1].0, 3..5);
    assert_eq!(&scene.text[place.span], "x3");
}

#[test]
fn every_unknown_key_is_underlined_and_its_nearest_key_named() {
    assert_eq!(
        seen(&broken("epsilon = 0.1", "epsillon = 0.1")),
        (
            15,
            1,
            "epsillon",
            "unknown key `epsillon` in [method]",
            "did you mean `epsilon`?"
        )
    );
    assert_eq!(
        seen(&broken("hamiltonian =", "hamiltonain =")),
        (
            8,
            1,
            "hamiltonain",
            "unknown key `hamiltonain` in [system]",
            "did you mean `hamiltonian`?"
        )
    );
    assert_eq!(
        seen(&broken("every = 10", "evry = 10")),
        (
            21,
            13,
            "evry",
            "unknown key `evry` in record",
            "did you mean `every`?"
        )
    );
    assert_eq!(
        seen(&broken("[run]", "[rn]")),
        (
            18,
            2,
            "rn",
            "unknown key `rn` in the scene",
            "did you mean `run`?"
        )
    );
    let stranger = broken("steps   = 1000", "steps = 1\nzzzz = 2");
    assert_eq!(
        stranger.help.as_deref(),
        Some("valid here: initial, steps, record, out")
    );
}

#[test]
fn wrong_types_say_what_was_expected_and_what_was_found() {
    assert_eq!(
        seen(&broken("epsilon = 0.1", "epsilon = \"fast\"")),
        (
            15,
            11,
            "\"fast\"",
            "`epsilon` must be a number, found the string \"fast\"",
            ""
        )
    );
    assert_eq!(
        seen(&broken("steps   = 1000", "steps = 1.5")).3,
        "`steps` must be a whole number, found 1.5"
    );
    assert_eq!(
        seen(&broken("steps   = 1000", "steps = -3")),
        (
            20,
            9,
            "-3",
            "`steps` must be a whole number of at least 0, found -3",
            ""
        )
    );
    assert_eq!(
        seen(&broken("every = 10", "every = 0")).3,
        "`every` must be a whole number of at least 1, found 0"
    );
    assert_eq!(
        seen(&broken(
            "variables   = [\"x1\", \"x2\", \"x3\"]",
            "variables = [\"x1\", 2]"
        )),
        (5, 20, "2", "`variables[1]` must be a string, found 2", "")
    );
    assert_eq!(
        seen(&broken("I2 = 0.75", "I2 = \"1/2\"")).3,
        "`I2` must be a number, found the string \"1/2\""
    );
}

#[test]
fn numbers_that_are_not_finite_are_refused_where_they_stand() {
    for literal in ["nan", "inf", "-inf", "+nan", "1e400"] {
        let diagnostic = broken("I2 = 0.75", &format!("I2 = {literal}"));
        let (line, column, text, message, _) = seen(&diagnostic);
        assert_eq!((line, column, text), (6, 32, literal));
        assert_eq!(
            message,
            format!("`I2` must be a finite number, found {literal}")
        );
        assert_eq!(
            seen(&broken("[1, 3, 3.5e0]", &format!("[1, 3, {literal}]"))).2,
            literal
        );
        assert_eq!(
            seen(&broken("epsilon = 0.1", &format!("epsilon = {literal}"))).2,
            literal
        );
    }
}

#[test]
fn a_step_is_two_factors_or_their_product_and_never_zero() {
    assert_eq!(
        seen(&broken("epsilon = 0.1", "epsilon = 0.0")),
        (
            15,
            11,
            "0.0",
            "`epsilon` must be different from zero, found 0.0",
            ""
        )
    );
    assert_eq!(
        seen(&broken("h       = 2.0", "time-step = 0.2")),
        (
            15,
            1,
            "epsilon",
            "`epsilon` cannot stand beside `time-step`",
            "give `epsilon` and `h`, or `time-step` alone: one step advances t by epsilon*h"
        )
    );
    let lone = broken("h       = 2.0\n", "");
    assert_eq!(
        seen(&lone),
        (
            11,
            2,
            "method",
            "[method] needs `h`",
            "for example: h = 2.0"
        )
    );
    let tiny = broken(
        "epsilon = 0.1\nh       = 2.0",
        "epsilon = 1e-200\nh = 1e-200",
    );
    assert_eq!(
        seen(&tiny).3,
        "`epsilon*h` must be finite and not zero, found 0"
    );
    let backward = parse(&RIGID_BODY.replace("h       = 2.0", "h = -2.0")).expect("backward runs");
    assert_eq!(backward.method.step.time_step(), -0.2);
    let alone = parse(&RIGID_BODY.replace("epsilon = 0.1\nh       = 2.0", "time-step = 0.2"));
    assert_eq!(
        alone.expect("a time step alone").method.step.time_step(),
        0.2
    );
}

#[test]
fn a_missing_table_or_key_comes_with_an_example() {
    assert_eq!(
        seen(&broken(
            "hamiltonian = \"x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)\"\n",
            ""
        )),
        (
            4,
            2,
            "system",
            "[system] needs `hamiltonian`",
            "for example: hamiltonian = \"x1^2/2 + x2^2/2\""
        )
    );
    let empty = parse("").expect_err("an empty scene");
    let messages: Vec<_> = empty.problems.iter().map(ToString::to_string).collect();
    assert_eq!(
        messages,
        [
            "the scene needs `system`",
            "the scene needs `method`",
            "the scene needs `run`"
        ]
    );
    let part = broken("{ name = \"hamilton-jacobi\", order = 2 }", "{ order = 2 }");
    assert_eq!(
        seen(&part),
        (
            13,
            15,
            "{ order = 2 }",
            "dynamics needs `name`",
            "for example: dynamics = { name = \"hamilton-jacobi\" }"
        )
    );
}

#[test]
fn several_problems_are_reported_in_the_order_of_the_text() {
    let text = RIGID_BODY
        .replace("I2 = 0.75", "I2 = nan")
        .replace("steps ", "stops ");
    let errors = parse(&text).expect_err("two problems");
    let messages: Vec<_> = errors.problems.iter().map(ToString::to_string).collect();
    assert_eq!(
        messages,
        [
            "`I2` must be a finite number, found nan",
            "unknown key `stops` in [run]",
        ]
    );
    assert_eq!(errors.to_string(), messages[0]);
}

#[test]
fn shapes_are_checked_against_the_dimension() {
    assert_eq!(
        seen(&broken("[1, 3, 3.5e0]", "[1, 3]")),
        (
            19,
            11,
            "[1, 3]",
            "initial has 2 entries, expected 3, one for each variable",
            ""
        )
    );
    let entries = "{ \"x1,x2\" = \"-x3\", \"x2,x3\" = \"-x1\", \"x3,x1\" = \"-x2\" }";
    let ragged = broken(entries, "{ log-canonical = [[0, 2], [1]] }");
    assert_eq!(seen(&ragged).2, "[1]");
    let small = broken(entries, "{ log-canonical = [[0, 2], [-2, 0]] }");
    assert_eq!(
        seen(&small).3,
        "log-canonical has 2 rows, expected one for each of the 3 variables"
    );
    let both = broken(entries, "{ lie-algebra = \"so3\", \"x1,x2\" = \"x3\" }");
    assert_eq!(seen(&both).3, "`x1,x2` cannot stand beside `lie-algebra`");
    let kind = broken(entries, "{ lie_algebra = \"so3\" }");
    assert_eq!(
        seen(&kind),
        (
            7,
            17,
            "lie_algebra",
            "`lie_algebra` is not a pair of variables",
            "did you mean `lie-algebra`?"
        )
    );
}

#[test]
fn names_are_valid_and_declared_once() {
    let twice = broken("\"x2\", \"x3\"]", "\"x1\", \"x3\"]");
    assert_eq!(
        seen(&twice),
        (5, 22, "\"x1\"", "`x1` is declared twice", "")
    );
    assert_eq!(
        seen(&broken("\"x2\", \"x3\"]", "\"2x\", \"x3\"]")).2,
        "\"2x\""
    );
    let convention = broken("casimirs    =", "convention = \"{x,h}\"\ncasimirs =");
    assert_eq!(seen(&convention).3, "unknown convention `{x,h}`");
    assert_eq!(convention.help.as_deref(), Some("did you mean `{x,H}`?"));
}

fn lattice(system: &str) -> String {
    format!(
        "[system]\n{system}\n[method]\nstepper = \"implicit-midpoint\"\ntime-step = 0.1\n\
         [run]\ninitial = {{ \"x[i]\" = \"1 + 0.1*sin(2*pi*i/N)\" }}\nsteps = 3\n"
    )
}

#[test]
fn a_library_system_takes_parameters_and_lengths_and_nothing_else() {
    let text = lattice(
        "library = \"volterra-lattice\"\nparameters = { rate = 2 }\nfamilies = { x = 1024 }",
    );
    let scene = parse(&text).expect("a library scene");
    assert_eq!(scene.system.dimension(), 1024);
    assert_eq!(scene.system.parameters[0].1.value.value, 2.0);
    assert_eq!(scene.system.parameters[0].1.source, Source::Scene);
    assert_eq!(scene.system.convention, Convention::HamiltonSecond);
    assert_eq!(
        scene.system.boundary.as_ref().map(|b| b.value),
        Some(Boundary::Periodic)
    );
    let hamiltonian = scene.system.hamiltonian.place();
    let diagnostic = scene.diagnostic(&hamiltonian, "m", "l", None);
    assert_eq!(diagnostic.source_name, "library system volterra-lattice");
    assert_eq!(diagnostic.line_column(), (10, 15));

    let first = |system: &str| {
        let errors = parse(&lattice(system)).expect_err("a wrong scene");
        errors.diagnostics().remove(0)
    };
    assert_eq!(
        seen(&first("library = \"volterra-latice\"")),
        (
            2,
            11,
            "\"volterra-latice\"",
            "unknown library system `volterra-latice`",
            "did you mean `volterra-lattice`?"
        )
    );
    let parameter = first("library = \"volterra-lattice\"\nparameters = { rat = 2 }");
    assert_eq!(
        seen(&parameter),
        (
            3,
            16,
            "rat",
            "unknown parameter of this system `rat`",
            "did you mean `rate`?"
        )
    );
    let beside = first("library = \"volterra-lattice\"\nhamiltonian = \"x\"");
    assert_eq!(
        seen(&beside).3,
        "`hamiltonian` cannot stand beside `library`"
    );
    let fragment = first("library = \"broken\"");
    assert_eq!(fragment.source_name, "library system broken");
}

#[test]
fn overrides_rewrite_the_text_and_keep_its_comments() {
    let scene = with(&[
        ("method.epsilon", "0.05"),
        ("method.dynamics.order", "4"),
        ("run.record.observables", "[\"energy\"]"),
        ("run.out", "elsewhere/dir"),
        ("system.parameters.I2", "2"),
    ])
    .expect("valid overrides");
    assert_eq!(scene.method.step.epsilon(), 0.05);
    assert!(scene.text.contains("epsilon = 0.05\n"));
    assert!(scene.text.contains("order = 4 }   # even"));
    assert_eq!(scene.run.record.observables.len(), 1);
    assert_eq!(
        scene.run.out.as_ref().map(|out| out.value.as_str()),
        Some("elsewhere/dir")
    );
    assert_eq!(scene.system.parameters[1].1.value.value, 2.0);
    let again = parse(&scene.text).expect("the effective text is a scene");
    assert_eq!(again, scene);
}

#[test]
fn overriding_one_alternative_removes_the_others() {
    let scene = with(&[("method.time-step", "0.01")]).expect("a time step alone");
    assert_eq!(scene.method.step.time_step(), 0.01);
    let scene = with(&[("method.stepper", "rk4")]).expect("a stepper alone");
    assert_eq!(scene.method.realization, None);
    let scene = with(&[("method.composition.order", "4")]).expect("a word becomes a table");
    assert!(
        scene
            .text
            .contains("composition = { name = \"none\", order = 4 }"),
        "{}",
        scene.text
    );
}

#[test]
fn an_override_outside_the_format_is_underlined_in_the_argument() {
    let errors = with(&[("method.epsillon", "0.05")]).expect_err("no such key");
    let diagnostic = errors.diagnostics().remove(0);
    assert_eq!(diagnostic.source_name, "--set");
    assert_eq!(
        seen(&diagnostic),
        (
            1,
            8,
            "epsillon",
            "unknown key `epsillon` in [method]",
            "did you mean `epsilon`?"
        )
    );
    assert_eq!(diagnostic.source_text, "method.epsillon=0.05");
    for path in [
        "",
        "method..h",
        "method",
        "method.epsilon.deep",
        "plugins.a",
    ] {
        assert!(with(&[(path, "1")]).is_err(), "{path} was accepted");
    }
    let value = with(&[("method.epsilon", "quick")]).expect_err("not a number");
    assert_eq!(seen(&value.diagnostics()[0]).2, "\"quick\"");
}

#[test]
fn text_that_is_not_toml_is_reported_where_it_breaks() {
    let diagnostic = broken("epsilon = 0.1", "epsilon = = 0.1");
    assert_eq!(diagnostic.line_column().0, 15);
    assert!(diagnostic.message.starts_with("not valid TOML"));
    let twice = broken("epsilon = 0.1", "h = 0.1");
    assert_eq!(twice.line_column(), (16, 1));
    assert!(twice.message.contains("duplicate key"), "{}", twice.message);
}

#[test]
fn no_truncation_of_a_scene_panics() {
    for end in 0..RIGID_BODY.len() {
        if let Err(errors) = parse(&RIGID_BODY[..end]) {
            for diagnostic in errors.diagnostics() {
                assert!(!diagnostic.render(false).is_empty());
            }
        }
    }
}

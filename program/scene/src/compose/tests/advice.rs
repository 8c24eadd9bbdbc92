//! What is said of slips, and that what is advised cures them.

use leafwise_core::{Origin, Registry};
use leafwise_reference as _;
use leafwise_splitting as _;

use super::compose;
use crate::diagnostic::SceneDiagnostic;
use crate::document::SceneDocument;

const SCENE: &str = r#"[system]
variables   = ["q", "p"]
parameters  = { k = 1.0 }
bracket     = { "q,p" = "1" }
convention  = "{x,H}"
hamiltonian = "p^2/2 + k*q^2/2"
[method]
stepper     = "splitting"
time-step   = 0.1
[run]
initial     = [1, 0]
steps       = 10
record      = { observables = ["energy"] }
"#;

fn composed(text: &str) -> Result<super::super::ComposedRun, Vec<SceneDiagnostic>> {
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("scene.toml", text, &registry);
    let document = document.map_err(|errors| errors.diagnostics())?;
    compose(&document, &registry).map_err(|refusal| vec![*refusal])
}

fn changed(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(SCENE.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

/// What is said of a scene, message and help together.
fn said(changes: &[(&str, &str)]) -> String {
    let diagnostics = composed(&changed(changes))
        .err()
        .unwrap_or_else(|| panic!("{changes:?} is taken"));
    let texts = diagnostics.iter().map(|of| {
        format!(
            "{} = help: {}",
            of.message,
            of.help.as_deref().unwrap_or("")
        )
    });
    texts.collect::<Vec<_>>().join("\n")
}

fn check(change: (&str, &str), pieces: &[&str]) {
    let said = said(&[change]);
    for piece in pieces {
        assert!(said.contains(piece), "{change:?}: {said}");
    }
}

const ENERGY: &str = "k*q^2/2";

#[test]
fn a_function_that_is_not_there_is_told_what_there_is() {
    for unknown in ["nosuch(q)", "besselj(q)", "trunc(q)", "blob(q)"] {
        check(
            (ENERGY, unknown),
            &["unknown function", "functions: exp, ln, sqrt, sin"],
        );
    }
    for (unknown, near) in [
        ("log(q)", "ln"),
        ("arctan(q)", "atan"),
        ("fabs(q)", "abs"),
        ("pow(q, 2)", "x^y"),
        ("theta(q)", "heaviside"),
        ("piecewise(q)", "if"),
        ("diff(q^2, q)", "D"),
    ] {
        let said = format!("did you mean `{near}`? functions: exp, ln,");
        check((ENERGY, unknown), &["unknown function", &said]);
    }
}

/// What is written for it gives the same numbers as mathematics.
#[test]
fn functions_of_other_languages_are_written_out() {
    let x = 0.7_f64;
    for (unknown, written, value) in [
        ("coth", "1/tanh(x)", 1.0 / libm::tanh(x)),
        ("frac", "x - floor(x)", x),
        ("cbrt", "x^(1/3)", libm::cbrt(x)),
        ("expm1", "exp(x) - 1", libm::expm1(x)),
        ("log1p", "ln(1 + x)", libm::log1p(x)),
        ("sinc", "sin(x)/x", libm::sin(x) / x),
    ] {
        if leafwise_expression::Function::from_name(unknown).is_none() {
            check(
                (ENERGY, &format!("{unknown}(q)")),
                &["unknown function", &format!("`{written}`")],
            );
        }
        let text = written
            .replace("exp(x)", "exp(q)")
            .replace("(x", "(q")
            .replace("+ x", "+ q")
            .replace("x)", "q)");
        let text = if text.starts_with('x') {
            text.replacen('x', "q", 1)
        } else {
            text
        };
        let text = text.replace("/x", "/q");
        let run = composed(&changed(&[(ENERGY, &text), ("[1, 0]", "[0.7, 0]")]));
        let run = run.unwrap_or_else(|said| panic!("{text}: {said:?}"));
        let energy = run
            .system
            .expressions()
            .expect("formulas")
            .hamiltonian()
            .evaluate(&[x, 0.0], &[1.0]);
        assert!(
            (energy - value).abs() <= 4.0 * f64::EPSILON * value.abs(),
            "{written}"
        );
    }
    check((ENERGY, "pow(q, 2)"), &["`x^y`"]);
}

#[test]
fn names_and_signs_of_other_notations_are_told() {
    check(
        (ENERGY, "e^(-q)"),
        &["unknown name `e`", "exp(x)", "exp(1)"],
    );
    assert!(composed(&changed(&[(ENERGY, "exp(-q)")])).is_ok());
    check((ENERGY, "π*q"), &["unknown name `π`", "`pi`"]);
    check(
        ("\"p^2/2", "\"H = p^2/2"),
        &["unexpected character `=`", "right"],
    );
    check(
        (ENERGY, "1e400*q^2"),
        &["`1e400` is beyond the largest double"],
    );
    for (observable, piece) in [
        ("2q", "a product is written with `*`"),
        ("1e", "a product is written with `*`"),
        ("2e3q", "a product is written with `*`"),
        ("q²", "`^2`"),
        ("π", "`pi`"),
        ("e", "exp(1)"),
        ("", "the formula ends"),
        ("enrgy", "did you mean `energy`"),
    ] {
        check(("\"energy\"", &format!("\"{observable}\"")), &[piece]);
    }
}

#[test]
fn keys_and_values_of_other_kinds_are_told() {
    check(
        ("{ \"q,p\" = \"1\" }", "\"kanonical\""),
        &["unknown kind of bracket", "did you mean `canonical`"],
    );
    check(
        ("{ \"q,p\" = \"1\" }", "1"),
        &[
            "`bracket` must be a table",
            "bracket = \"canonical\" pairs q with p",
        ],
    );
    check(
        ("[1, 0]", "{ q = [1, 2], p = 0 }"),
        &[
            "`q` takes one formula or number, found a list",
            "\"q[i]\" = [1, 2, 3]",
        ],
    );
    check(("k = 1.0", "kα = 1.0"), &["needs quotes"]);
    assert!(composed(&changed(&[("k = 1.0", "k = 1.0, \"kα\" = 1.0")])).is_ok());
    for unknown in ["verlet", "Velocity-Verlet", "leapfrog", "Störmer-Verlet"] {
        check(
            ("\"splitting\"", &format!("{unknown:?}")),
            &["no stepper is called", "stepper = \"splitting\""],
        );
    }
    check(
        ("steps       = 10", "t_end = 100"),
        &["[run] needs `steps`", "until = 100", "unknown key `t_end`"],
    );
}

#[test]
fn a_parameter_may_be_a_formula_of_numbers_and_of_other_parameters() {
    for (text, value) in [
        ("3/4", 0.75),
        ("sqrt(3)/2", libm::sqrt(3.0) / 2.0),
        ("2*pi", 2.0 * std::f64::consts::PI),
        ("-1e-3", -1e-3),
    ] {
        let run = composed(&changed(&[("k = 1.0", &format!("k = \"{text}\""))])).expect(text);
        assert_eq!(run.system.parameter_values(), [value]);
    }
    // 1/m and m follow another parameter, whatever their order and values.
    for derived in ["m = 2.0, k = \"1/m\"", "k = \"mu/2\", mu = \"2/m\", m = 2"] {
        let run = composed(&changed(&[("k = 1.0", derived)])).expect(derived);
        assert_eq!(run.system.parameter_values(), [2.0]);
        let energy = run.system.expressions().expect("formulas").hamiltonian();
        assert_eq!(energy.evaluate(&[1.0, 0.0], &[2.0]), 0.25);
        assert_eq!(energy.evaluate(&[1.0, 0.0], &[4.0]), 0.125);
    }
    // A number in its place is one.
    let registry = Registry::with_builtin();
    let text = changed(&[("k = 1.0", "m = 2.0, k = \"1/m\"")]);
    let set = [("system.parameters.k".to_owned(), "3".to_owned())];
    let number = SceneDocument::parse_with("scene.toml", &text, &set, &registry).expect("a scene");
    assert_eq!(number.system.parameters.len(), 2);
    assert!(number.system.define.is_empty());
    for (wrong, pieces) in [
        (
            "k = \"1/m\"",
            &[
                "`k` is neither a number nor a formula of numbers and other parameters: unknown name `m`",
            ] as &[&str],
        ),
        (
            "k = \"1/mass\", mas = 1",
            &["unknown name `mass`; did you mean `mas`?"],
        ),
        (
            "k = \"q^2\"",
            &[
                "`q` depends on the state",
                "define = { k = \"q^2\" } in [system]",
            ],
        ),
        ("k = \"2*k\"", &["`k` uses itself"]),
        (
            "k = \"1/m\", m = \"2*k\"",
            &["`k` is defined by itself, through `m`"],
        ),
        ("k = \"1 +\"", &["`k` is neither a number nor a formula"]),
        ("k = \"1/0\"", &["`k` must be a finite number"]),
    ] {
        check(("k = 1.0", wrong), pieces);
    }
}

#[test]
fn entries_of_structure_are_counted_from_one_and_may_be_formulas() {
    let algebra = |c: &str| {
        changed(&[
            ("[\"q\", \"p\"]", "[\"q\", \"p\", \"r\"]"),
            (
                "{ \"q,p\" = \"1\" }",
                &format!(
                    "{{ lie-algebra = {{ structure = [[1, 2, 3, \"3/4\"], [2, 3, 1, {c}], [3, 1, 2, 1]] }} }}"
                ),
            ),
            ("[1, 0]", "[1, 0, 0]"),
        ])
    };
    assert!(composed(&algebra("\"sqrt(9)/4\"")).is_ok());
    let refused = composed(&algebra("\"k\""))
        .err()
        .expect("a parameter is no number");
    assert!(
        refused[0].message.contains("`c in entry 2 of structure`"),
        "{refused:?}"
    );
    let refused = composed(&algebra("1, 5")).err().expect("five entries");
    assert!(
        refused[0]
            .message
            .contains("entry 2 of structure has 5 entries"),
        "{refused:?}"
    );
}

/// A time at the end is a number of steps, where it is one, and the two scenes are one method.
#[test]
fn a_time_at_the_end_is_a_number_of_equal_steps() {
    let steps = |step: &str, until: &str| {
        let text = changed(&[
            ("steps       = 10", &format!("until = {until}")),
            ("= 0.1", &format!("= {step}")),
        ]);
        composed(&text).map(|run| (run.plan.steps, run.plan.until))
    };
    for (step, until, count) in [
        ("0.1", "1", 10),
        ("0.1", "1e3", 10_000),
        ("0.3", "99.9", 333),
        ("1e-3", "0.123", 123),
        ("-0.1", "-12.3", 123),
        ("7", "7", 1),
    ] {
        assert_eq!(steps(step, until), Ok((count, None)), "{step} {until}");
    }
    // Steps that do not come to it are made shorter, as little as there is a whole number of them.
    for (step, until, count) in [
        ("0.3", "100", 334),
        ("-0.3", "-100", 334),
        ("0.1", "0.04", 1),
        ("0.1", "1.0000001", 11),
    ] {
        let text = changed(&[
            ("steps       = 10", &format!("until = {until}")),
            ("= 0.1", &format!("= {step}")),
        ]);
        let run = composed(&text).expect(until);
        let until: f64 = until.parse().expect("a number");
        assert_eq!((run.plan.steps, run.plan.until), (count, None), "{step}");
        assert_eq!(run.plan.epsilon * run.plan.h, until / count as f64);
    }
    let factors = changed(&[
        ("steps       = 10", "until = 1"),
        ("time-step   = 0.1", "epsilon = 0.5\nh = 0.3"),
    ]);
    let factors = composed(&factors).expect("seven steps of a seventh");
    assert_eq!((factors.plan.steps, factors.plan.epsilon), (7, 0.5));
    assert!((factors.plan.h - 2.0 / 7.0).abs() <= f64::EPSILON);
    let far = steps("1e-9", "1e300").expect_err("too many");
    assert_eq!(
        far[0].message,
        "`until` = 1e300 is more than 9e15 steps of 0.000000001"
    );
    for never in ["-1", "0"] {
        assert!(
            steps("0.1", never).expect_err("never")[0]
                .message
                .contains("never comes to")
        );
    }
    // A sweep's other step is another number of steps.
    let registry = Registry::with_builtin();
    let text = changed(&[("steps       = 10", "until = 1")]);
    let mut document = SceneDocument::parse("scene.toml", &text, &registry).expect("a scene");
    assert!(!document.assign("method.time-step", "0.05"));
    let finer = [("method.time-step".to_owned(), "0.05".to_owned())];
    let finer = SceneDocument::parse_with("scene.toml", &text, &finer, &registry).expect("a scene");
    assert_eq!(finer.run.steps.value, 20);
}

#[test]
fn whole_numbers_may_be_written_as_decimals() {
    for (written, value) in [
        ("1e3", 1000),
        ("1000.0", 1000),
        ("1_0e1", 100),
        ("0.0", 0),
        ("2.5e1", 25),
    ] {
        let run = composed(&changed(&[(
            "steps       = 10",
            &format!("steps = {written}"),
        )]))
        .expect(written);
        assert_eq!(run.plan.steps, value);
    }
    for wrong in ["1.5", "1e30", "nan", "inf"] {
        check(
            ("steps       = 10", &format!("steps = {wrong}")),
            &["`steps` must be a whole number, found"],
        );
    }
    check(
        ("steps       = 10", "steps = -1e3"),
        &["a whole number of at least 0"],
    );
}

#[test]
fn events_that_never_happen_are_told() {
    for (event, why) in [
        ("section = { at = \"q = q\" }", "both sides are the same"),
        (
            "section = { at = \"2*q = q + q\" }",
            "both sides are the same",
        ),
        (
            "section = { at = \"0 = 0\" }",
            "neither a coordinate nor the time",
        ),
        ("stop = \"0 > 1\"", "neither a coordinate nor the time"),
        ("stop = \"k > 2\"", "neither a coordinate nor the time"),
        ("stop = \"q > q\"", "both sides are the same"),
    ] {
        check(
            ("steps       = 10", &format!("steps = 10\n{event}")),
            &["never changes", why],
        );
    }
    for event in [
        "section = { at = \"q = 0\" }",
        "section = { at = \"q^2 = 0\" }",
        "stop = \"q > k + 1\"",
    ] {
        let scene = changed(&[("steps       = 10", &format!("steps = 10\n{event}"))]);
        assert!(composed(&scene).is_ok(), "{event}");
    }
}

#[test]
fn a_magnetic_field_with_a_divergence_is_told_so() {
    let field = |field: &str| {
        changed(&[
            (
                "[\"q\", \"p\"]",
                "[\"x\", \"y\", \"z\", \"vx\", \"vy\", \"vz\"]",
            ),
            (
                "{ \"q,p\" = \"1\" }",
                &format!("{{ magnetic-field = {field} }}"),
            ),
            ("p^2/2 + k*q^2/2", "(vx^2 + vy^2 + vz^2)/2 + k*x"),
            ("[1, 0]", "[1, 0.5, 0.25, 0, 1, 2]"),
            ("\"splitting\"", "\"rk4\""),
        ])
    };
    let refusal = |text: &str| {
        let registry = Registry::with_builtin();
        let document = SceneDocument::parse("scene.toml", text, &registry).expect("a scene");
        let run = super::super::compose_system(&document).expect("a system");
        let checks = super::super::SceneChecks::of(&run.system, &run.near).expect("checks");
        checks.refusal(&document, (&run.system, &run.near), false)
    };
    let refused = refusal(&field("[\"x\", \"0\", \"1\"]")).expect("div B = 1");
    assert!(
        refused.message.contains("divergence of the magnetic field"),
        "{}",
        refused.message
    );
    assert!(refusal(&field("[\"x\", \"-y\", \"1\"]")).is_none());
}

#[test]
fn a_site_is_named_once() {
    let lattice = changed(&[
        (
            "variables   = [\"q\", \"p\"]",
            "families = { q = 5, p = 5 }",
        ),
        (
            "{ k = 1.0 }",
            "{ \"b[i]\" = 1, \"b[2]\" = 3, \"b[02]\" = 4 }",
        ),
        ("\"q,p\"", "\"q[i],p[i]\""),
        ("p^2/2 + k*q^2/2", "sum(i, p[i]^2/2 + b[i]*q[i]^2/2)"),
        (
            "[1, 0]",
            "{ \"q[i]\" = 1, \"p[i]\" = 0, \"q[1]\" = 2, \"q[ 01 ]\" = 3 }",
        ),
    ]);
    let refused = composed(&lattice).err().expect("twice");
    let messages: Vec<&str> = refused.iter().map(|of| of.message.as_str()).collect();
    assert_eq!(
        messages,
        ["`b[2]` is declared twice", "`q[1]` is declared twice"]
    );
}

#[test]
fn values_beyond_doubles_are_no_texts() {
    let registry = Registry::with_builtin();
    for value in ["1e400", "-1e999", "1_0e400"] {
        let given = [("system.parameters.k".to_owned(), value.to_owned())];
        let refused =
            SceneDocument::parse_with("scene.toml", SCENE, &given, &registry).expect_err(value);
        assert!(
            refused.to_string().contains("beyond the largest double"),
            "{refused}"
        );
    }
}

/// A crate that is linked adds no word of its own: the registry in use does.
#[test]
fn a_refusal_names_parts_of_the_registry_alone() {
    let all = Registry::with_builtin();
    let mut few = Registry::empty();
    for name in ["splitting", "rk4"] {
        let part = all.stepper(name).expect("a built-in stepper");
        let origin = Origin::built_in("acme", "0.1.0");
        few.register(part.into(), origin).expect("a fresh name");
    }
    let forced = changed(&[("[method]", "forces = [\"0.1*p\", \"0\"]\n[method]")]);
    let message = |registry: &Registry| {
        let document = SceneDocument::parse("scene.toml", &forced, registry).expect("a scene");
        let refused = compose(&document, registry);
        refused
            .map(drop)
            .expect_err("splitting takes no forces")
            .message
    };
    let refusal = "splitting integrates only x' = {H, x}, and this system has forces; what serves it: the steppers ";
    assert_eq!(message(&few), format!("{refusal}rk4"));
    let told = message(&all);
    assert!(
        told.starts_with(refusal) && told.contains("dop853"),
        "{told}"
    );
}

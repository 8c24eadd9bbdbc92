//! Direct sums against the same entries written by hand, and what is no sum, underlined.

use leafwise_core::diagnostics::Verdict;

use super::{compose_system, document, entries, refusal};
use crate::compose::SceneChecks;
use crate::document::SceneDocument;

const SIX: &str = "variables = [\"x\", \"y\", \"q\", \"z\", \"p\", \"c\"]\nparameters = { a = 2 }\nhamiltonian = \"x*q + z*p\"\n";
const POINT: [f64; 6] = [0.5, 0.25, -0.7, 1.3, 0.4, 2.0];

fn sum(summands: &str) -> String {
    format!("{SIX}bracket = {{ sum = [{summands}] }}")
}

/// Summands take their variables in their own order, wherever they stand in the state.
#[test]
fn summands_are_the_entries_of_their_variables() {
    let by_hand = format!(
        "{SIX}bracket = {{ \"z,x\" = \"-y\", \"x,y\" = \"-z\", \"y,z\" = \"-x\", \"q,p\" = \"a*q*p\" }}"
    );
    let expected = entries(&by_hand, &POINT);
    for summands in [
        "{ variables = [\"x\", \"y\", \"z\"], bracket = { lie-algebra = \"so3\" } }, \
         { variables = [\"q\", \"p\"], bracket = { \"q,p\" = \"a*q*p\" } }, { variables = [\"c\"], bracket = {} }",
        "{ variables = [\"c\"], bracket = {} }, \
         { variables = [\"p\", \"q\"], bracket = { log-canonical = [[0, -2], [2, 0]] } }, \
         { variables = [\"y\", \"z\", \"x\"], bracket = { lie-algebra = \"so3\" } }",
    ] {
        assert_eq!(entries(&sum(summands), &POINT), expected, "{summands}");
    }
}

/// The name of a vector stands for its components.
#[test]
fn vectors_are_named_in_summands() {
    let system = |spin: &str, mode: &str| {
        format!(
            "variables = {{ s = 3, r = 2, p = 2 }}\nhamiltonian = \"s.z*r.x\"\nbracket = {{ sum = [\
             {{ variables = [{spin}], bracket = {{ lie-algebra = \"so3\" }} }}, \
             {{ variables = [{mode}], bracket = \"canonical\" }}] }}"
        )
    };
    let written = system(
        "\"s.x\", \"s.y\", \"s.z\"",
        "\"r.x\", \"r.y\", \"p.x\", \"p.y\"",
    );
    let point = [0.5, 0.25, -0.7, 1.3, 0.4, 2.0, 0.1];
    let expected = entries(&written, &point);
    assert_eq!(expected.len(), 5);
    assert_eq!(entries(&system("\"s\"", "\"r\", \"p\""), &point), expected);
}

/// A form, a constraint and entries beside each other; p dq is {q, p} = −1.
#[test]
fn summands_may_be_forms_and_have_constraints() {
    let summands = "{ variables = [\"q\", \"p\"], bracket = { one-form = [\"p\", 0] } }, \
                    { variables = [\"x\", \"y\", \"z\", \"c\"], bracket = { \"x,z\" = -1, \"y,c\" = -1 }, \
                      constraints = [\"x^2 + y^2 - 1\", \"x*z + y*c\"] }";
    let initial = format!("initial = {POINT:?}");
    let composed = compose_system(&document(&sum(summands), &initial)).expect("a system");
    let formulas = composed.system.expressions().expect("formulas");
    let names: Vec<&str> = formulas
        .casimirs()
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    assert_eq!(names, ["x^2 + y^2 - 1", "x*z + y*c"]);
    let value = |at| formulas.tensor()[&at].evaluate(&POINT, &[2.0]);
    assert_eq!(value((2, 4)), -1.0);
    // Dirac's {x, z} = −(1 − x²/r²) with r² = x² + y².
    let [x, y] = [POINT[0], POINT[1]];
    let expected = -(1.0 - x * x / (x * x + y * y));
    assert!((value((0, 3)) - expected).abs() < 1e-15);
    let checks = SceneChecks::of(&composed.system, &POINT).expect("derivatives");
    assert_eq!(checks.jacobi.verdict, Verdict::ByConstruction);
    for casimir in &checks.casimirs {
        assert_ne!(casimir.check.verdict, Verdict::Violated, "{}", casimir.name);
    }
}

/// Jacobi's identity is proved of a sum of entries, and fails where a summand's does.
#[test]
fn a_sum_is_poisson_where_every_summand_is() {
    let with = |entry: &str, other: &str| {
        let summands = format!(
            "{{ variables = [\"x\", \"y\", \"z\"], bracket = {{ \"x,y\" = \"{entry}\", \"y,z\" = \"x\" }} }}, \
             {{ variables = [\"q\", \"p\", \"c\"], bracket = {{ \"q,p\" = 1 }} }}"
        );
        let summands = summands.replace("bracket = { \"q,p\" = 1 }", other);
        let initial = format!("initial = {POINT:?}");
        let composed = compose_system(&document(&sum(&summands), &initial)).expect("a system");
        let checks = SceneChecks::of(&composed.system, &POINT).expect("derivatives");
        (checks.jacobi.verdict, checks.jacobi.worst)
    };
    let entries = "bracket = { \"q,p\" = 1 }";
    assert_eq!(with("z", entries).0, Verdict::Proved);
    assert_eq!(with("y*z", entries), (Verdict::Violated, vec![0, 1, 3]));
    let dirac = "bracket = { \"q,p\" = 1 }, constraints = [\"q\", \"p\"]";
    assert_eq!(with("z", dirac).0, Verdict::ByConstruction);
    assert_eq!(with("y*z", dirac), (Verdict::Violated, vec![0, 1, 3]));
}

/// The piece of the scene that is underlined, and the message.
fn refused(summands: &str) -> (String, String) {
    let diagnostic = refusal(&sum(summands), &format!("initial = {POINT:?}"));
    let piece = &diagnostic.source_text[diagnostic.span.clone()];
    (piece.to_owned(), diagnostic.message)
}

#[test]
fn what_couples_summands_is_refused_where_it_stands() {
    let body = "{ variables = [\"x\", \"y\", \"z\"], bracket = { lie-algebra = \"so3\" } }";
    for (summand, piece, named) in [
        ("\"q,p\" = \"x + 1\"", "x + 1", "`x`"),
        ("\"q,x\" = 1", "\"q,x\"", "`x`"),
        ("one-form = [\"z*p\", 0, 0]", "z*p", "`z`"),
        ("two-form = { \"q,p\" = \"y\" }", "y", "`y`"),
    ] {
        let summands =
            format!("{body}, {{ variables = [\"q\", \"p\", \"c\"], bracket = {{ {summand} }} }}");
        let (found, message) = refused(&summands);
        assert_eq!(found, piece, "{message}");
        assert!(
            message.contains("of the summand of q, p, c names"),
            "{message}"
        );
        assert!(message.contains(named), "{message}");
    }
    // A definition that leads there.
    let scene = format!(
        "define = {{ f = \"1 + g\", g = \"x^2\" }}\n{}",
        sum(&format!(
            "{body}, {{ variables = [\"q\", \"p\", \"c\"], bracket = {{ \"q,p\" = \"f\" }} }}"
        ))
    );
    let diagnostic = refusal(&scene, &format!("initial = {POINT:?}"));
    assert!(
        diagnostic.message.contains("names `f`"),
        "{}",
        diagnostic.message
    );
    // Sizes are those of the summand.
    let (piece, message) = refused(
        "{ variables = [\"x\", \"y\"], bracket = { lie-algebra = \"so3\" } }, \
         { variables = [\"q\", \"z\", \"p\", \"c\"], bracket = {} }",
    );
    assert_eq!(piece, "so3");
    assert!(message.contains("this scene has 2 variables"), "{message}");
}

/// What the reader finds in a scene.
fn problems(summands: &str) -> Vec<(String, String)> {
    let text = format!(
        "[system]\n{}\n[method]\ntime-step = 0.1\n[run]\nsteps = 1\ninitial = {POINT:?}\n",
        sum(summands)
    );
    let registry = leafwise_core::Registry::empty();
    let errors = SceneDocument::parse("scene.toml", &text, &registry).expect_err("a problem");
    let found = errors.diagnostics().into_iter();
    found
        .map(|found| (text[found.span.clone()].to_owned(), found.message))
        .collect()
}

#[test]
fn every_variable_is_in_one_summand() {
    let rest = "{ variables = [\"y\", \"z\", \"c\"], bracket = {} }";
    for (summand, piece, message) in [
        (
            "{ variables = [\"x\", \"q\", \"p\", \"y\"], bracket = {} }",
            "\"y\"",
            "`y` is in two summands of the bracket",
        ),
        (
            "{ variables = [\"x\", \"q\"], bracket = {} }",
            "\"p\"",
            "`p` is in no summand of the bracket",
        ),
        (
            "{ variables = [\"x\", \"q\", \"p\", \"w\"], bracket = {} }",
            "\"w\"",
            "unknown variable or family of this system `w`",
        ),
        (
            "{ variables = [\"x\", \"q\", \"p\"], bracket = { sum = [] } }",
            "{ sum = [] }",
            "`sum` cannot be combined with `sum`",
        ),
        (
            "{ variables = [\"x\", \"q\", \"p\"] }",
            "{ variables = [\"x\", \"q\", \"p\"] }",
            "sum[1] needs `bracket`",
        ),
    ] {
        let found = problems(&format!("{rest}, {summand}"));
        assert!(
            found.iter().any(|(p, m)| p == piece && m == message),
            "{summand}: {found:?}"
        );
    }
}

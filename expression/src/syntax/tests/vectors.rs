//! Vectors: what they are in components, and where they are none.

use proptest::prelude::*;

use crate::syntax::{Formula, Scope, SyntaxErrorKind, Vector};

fn vectors() -> Vec<Vector> {
    let of = |name: &str, letters: &[&str]| Vector {
        name: name.to_owned(),
        components: letters.iter().map(|c| format!("{name}.{c}")).collect(),
    };
    vec![
        of("a", &["x", "y", "z"]),
        of("b", &["x", "y", "z"]),
        of("u", &["x", "y"]),
        of("s", &["x", "y", "z"]),
    ]
}

/// a, b, u and one number, then three families with four sites.
fn scope() -> Scope {
    let names = ["a.x", "a.y", "a.z", "b.x", "b.y", "b.z", "u.x", "u.y", "c"];
    let mut scope = Scope::new();
    for (at, name) in names.into_iter().enumerate() {
        scope = scope.with_variable(name, at);
    }
    for (at, name) in ["s.x", "s.y", "s.z"].into_iter().enumerate() {
        scope = scope.with_family(name, 9 + 4 * at, 4);
    }
    scope
}

fn value(text: &str, x: &[f64]) -> f64 {
    let formula = Formula::parse(text).and_then(|formula| formula.in_components(&vectors()));
    let formula = formula.unwrap_or_else(|error| panic!("{text}: {error}"));
    let expression = formula
        .resolve(&scope(), None)
        .expect("a formula of the scope");
    expression.expect("inside").evaluate(x, &[])
}

fn refused(text: &str) -> SyntaxErrorKind {
    let formula = Formula::parse(text).expect("a formula");
    let refused = formula.in_components(&vectors()).map(|_| ());
    refused.expect_err(text).kind
}

proptest! {
    /// Identities of vectors, to the round-off of their terms: a·(b×a) = 0, and Lagrange's |a×b|² = |a|²|b|² − (a·b)².
    #[test]
    fn dot_cross_and_norm_obey_their_identities(x in prop::collection::vec(-2.0..2.0_f64, 21)) {
        let near = |p: f64, q: f64, size: f64| (p - q).abs() <= 64.0 * f64::EPSILON * size;
        let (a, b) = (value("dot(a, a)", &x), value("dot(b, b)", &x));
        let ab = value("dot(a, b)", &x);
        prop_assert_eq!(ab, x[0] * x[3] + x[1] * x[4] + x[2] * x[5]);
        let size = a * b + a + b;
        prop_assert!(near(value("dot(a, cross(b, a))", &x), 0.0, size));
        prop_assert!(near(value("norm(cross(a, b))^2", &x), a * b - ab * ab, 4.0 * size));
        let scaled = value("dot(a, (2*a - c*b)/4 + -b)", &x);
        prop_assert!(near(scaled, (2.0 * a - x[8] * ab) / 4.0 - ab, 4.0 * size));
        prop_assert!(near(value("norm(u)", &x), libm::hypot(x[6], x[7]), 4.0));
    }

    /// Sums over sites are summed in each component.
    #[test]
    fn sums_of_vectors_are_vectors(x in prop::collection::vec(-2.0..2.0_f64, 21)) {
        let sum = |k: usize| (0..4).fold(0.0, |sum, i| sum + x[9 + 4 * k + i]);
        let expected = libm::sqrt((0..3).map(|k| sum(k) * sum(k)).sum());
        let magnetization = value("norm(sum(i, s[i]))", &x);
        prop_assert!((magnetization - expected).abs() <= 64.0 * f64::EPSILON * 16.0);
        let written = "sum(i, s.x[i]*s.x[i+1] + s.y[i]*s.y[i+1] + s.z[i]*s.z[i+1])";
        prop_assert_eq!(value("sum(i, dot(s[i], s[i+1]))", &x), value(written, &x));
    }
}

#[test]
fn vectors_and_numbers_are_not_taken_for_each_other() {
    use SyntaxErrorKind as Kind;
    assert!(matches!(refused("a"), Kind::VectorAsNumber { .. }));
    assert!(matches!(refused("c + a"), Kind::VectorAsNumber { .. }));
    assert!(matches!(refused("norm(a + c)"), Kind::NoVector { .. }));
    assert!(matches!(refused("dot(a, c)"), Kind::NoVector { .. }));
    assert!(matches!(refused("a^2"), Kind::VectorAsNumber { .. }));
    assert!(matches!(refused("a*b"), Kind::TwoVectors));
    assert!(matches!(refused("norm(a*b)"), Kind::TwoVectors));
    assert!(matches!(
        refused("dot(a, u)"),
        Kind::UnlikeVectors {
            first: 3,
            second: 2
        }
    ));
    assert!(matches!(refused("norm(a + u)"), Kind::UnlikeVectors { .. }));
    assert!(matches!(
        refused("norm(cross(u, u))"),
        Kind::NoCrossProduct { found: 2 }
    ));
    assert!(matches!(
        refused("cross(a, b)"),
        Kind::VectorAsNumber { .. }
    ));
    assert!(matches!(
        refused("dot(a)"),
        Kind::VectorArguments { count: 2, .. }
    ));
    assert!(matches!(
        refused("norm(a, b)"),
        Kind::VectorArguments { count: 1, .. }
    ));
    assert!(matches!(refused("sin(s[0])"), Kind::VectorAsNumber { .. }));
}

/// Errors stand where the vector is written, not behind the text.
#[test]
fn errors_of_components_stand_at_their_vector() {
    let text = "1 + dot(s[i], a)";
    let formula = Formula::parse(text).and_then(|formula| formula.in_components(&vectors()));
    let formula = formula.expect("a formula");
    assert_eq!(formula.text(), text);
    let error = formula
        .resolve(&scope(), None)
        .expect_err("an index without a site");
    assert!(error.span.end <= text.len(), "{:?}", error.span);
    let text = "norm(s)";
    let formula = Formula::parse(text).and_then(|formula| formula.in_components(&vectors()));
    let error = formula
        .expect("a formula")
        .resolve(&scope(), None)
        .expect_err("no site");
    assert_eq!(&text[error.span.clone()], "s");
}

/// Each level repeats the one below: 2^150 parts are refused before they are made, a few levels are not.
#[test]
fn vectors_that_repeat_each_other_have_a_limit() {
    let nested = |open: &str, close: &str, levels: usize| {
        let text = format!("norm({}a{})", open.repeat(levels), close.repeat(levels));
        Formula::parse(&text).and_then(|formula| formula.in_components(&vectors()))
    };
    for (open, close, most) in [
        ("cross(b, ", ")", 10),
        ("norm(", ")*a", 4),
        ("a/norm(", ")", 4),
    ] {
        let few = nested(open, close, most);
        assert!(few.is_ok(), "{open}: {few:?}");
        let error = nested(open, close, 40).expect_err(open);
        assert!(
            matches!(error.kind, SyntaxErrorKind::TooManyParts { .. }),
            "{error}"
        );
    }
}

/// The place of an unknown component is that of its vector, inside of the text.
#[test]
fn a_component_without_a_name_in_the_scope_is_told_where_its_vector_stands() {
    let text = "1 + norm(a)";
    let formula = Formula::parse(text).and_then(|formula| formula.in_components(&vectors()));
    let formula = formula.expect("a formula");
    let resolved = formula.resolve(&Scope::new(), None);
    let valued = formula.value(&Scope::new(), &[], None);
    for error in [resolved.map(drop), valued.map(drop)] {
        let error = error.expect_err("no a.x");
        assert_eq!(text.get(error.span.clone()), Some("a"), "{error}");
    }
}

#[test]
fn components_of_a_vector_are_formulas() {
    let of = |text: &str| {
        let formula = Formula::parse(text).expect("a formula");
        let components = formula.components(&vectors()).expect("components");
        components.map(|all| all.iter().map(ToString::to_string).collect::<Vec<_>>())
    };
    assert_eq!(
        of("2*a + b/c").map(|all| all[1].clone()),
        Some("2*a.y + b.y/c".to_owned())
    );
    assert_eq!(
        of("cross(a, b)").map(|all| all[2].clone()),
        Some("a.x*b.y - a.y*b.x".to_owned())
    );
    assert_eq!(of("norm(a)"), None);
    assert_eq!(of("dot(a, b)*c"), None);
    let formula = Formula::parse("a + dot(a, b)").expect("a formula");
    assert!(formula.components(&vectors()).is_err());
}

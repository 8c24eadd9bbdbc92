//! What does not fit is refused when it is built, with the entry that differs.

use crate::common::{body, bracket, constant, part, product, system};
use leafwise_core::part::PartParameters;
use leafwise_core::{BuildError, Convention};
use leafwise_expression::{Expression, Function};

const PARTS: [&str; 3] = ["so3-exponential", "so3-cayley", "so3-group"];

/// The reason every part gives for refusing these entries.
fn reason(dimension: usize, entries: Vec<((usize, usize), Expression)>) -> String {
    let system = system(dimension, entries, Convention::HamiltonianFirst).expect("a system");
    let reasons = PARTS.map(|name| match part(&system, name, &PartParameters::new()) {
        Err(BuildError::DoesNotFit { part, reason }) if part == name => reason,
        other => panic!("{name}: {other:?}"),
    });
    assert_eq!(reasons[0], reasons[1]);
    assert_eq!(reasons[0], reasons[2]);
    reasons[0].clone()
}

#[test]
fn every_other_tensor_is_refused_with_its_entry() {
    let x = Expression::Variable;
    let one = bracket(&constant(1, 1));
    let with = |at: usize, entry: Expression| {
        let mut entries = one.clone();
        entries[at].1 = entry;
        entries
    };
    for (entries, entry) in [
        (vec![one[1].clone(), one[2].clone()], "{x1, x2}"),
        (vec![one[0].clone(), one[2].clone()], "{x2, x3}"),
        (vec![one[0].clone(), one[1].clone()], "{x1, x3}"),
        (with(0, x(1)), "{x1, x2}"),
        (with(0, product(vec![x(2), x(2)])), "{x1, x2}"),
        (with(0, constant(1, 1)), "{x1, x2}"),
        // One sign changed: so(2,1)*.
        (with(1, x(0)), "{x2, x3}"),
        (with(2, product(vec![constant(2, 1), x(1)])), "{x1, x3}"),
        (
            with(
                2,
                product(vec![constant(10_000_000_001, 10_000_000_000), x(1)]),
            ),
            "{x1, x3}",
        ),
        (
            with(1, Expression::Apply(Function::Sin, Box::new(x(0)))),
            "{x2, x3}",
        ),
        (
            with(2, product(vec![Expression::Parameter(0), x(1)])),
            "{x1, x3}",
        ),
    ] {
        let reason = reason(3, entries);
        assert!(reason.contains(entry), "{entry}: {reason}");
    }
    assert!(reason(4, one.clone()).contains("4 variables"));
    assert!(reason(3, Vec::new()).contains("{x1, x2}"));
    assert!(reason(3, bracket(&x(0))).contains("{x1, x2}"));
}

#[test]
fn what_is_so3_in_other_words_is_accepted() {
    let x = Expression::Variable;
    // −x3 (sin² x1 + cos² x1) + x1 − x1.
    let square = |function| {
        let value = Expression::Apply(function, Box::new(x(0)));
        product(vec![value.clone(), value])
    };
    let one = Expression::Sum(vec![square(Function::Sin), square(Function::Cos)]);
    let mut entries = bracket(&constant(1, 1));
    entries[0].1 = Expression::Sum(vec![
        product(vec![constant(-1, 1), x(2), one]),
        x(0),
        Expression::Negate(Box::new(x(0))),
    ]);
    let same = system(3, entries, Convention::HamiltonianFirst).expect("a system");
    let root = Expression::Apply(Function::Sqrt, Box::new(Expression::Parameter(0)));
    let scaled = system(3, bracket(&root), Convention::HamiltonianSecond).expect("a system");
    for name in PARTS {
        for system in [&same, &scaled] {
            part(system, name, &PartParameters::new()).expect("so(3)* up to a constant");
        }
    }
}

#[test]
fn parameters_are_checked() {
    let body = body();
    let order = PartParameters::new().with("order", 4);
    for name in PARTS {
        assert!(matches!(
            part(&body, name, &order),
            Err(BuildError::UnknownParameter { .. })
        ));
    }
    for (setting, fits) in [("cayley", true), ("exponential", true), ("euler", false)] {
        let parameters = PartParameters::new().with("chart", setting);
        match part(&body, "so3-group", &parameters) {
            Ok(realization) => assert!(fits && realization.describe().contains(setting)),
            Err(BuildError::Parameter { expected, .. }) => {
                assert!(!fits && expected.contains("cayley, exponential"));
            }
            Err(other) => panic!("{other}"),
        }
    }
    let default = part(&body, "so3-group", &PartParameters::new()).expect("a default chart");
    assert_eq!(default.describe(), "so3-group chart = cayley");
}

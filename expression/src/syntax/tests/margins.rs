//! Conditions as one number, whose sign tells whether they hold.

use crate::syntax::{EQUAL_MARGIN, Formula, Scope};

fn margin(text: &str, x: [f64; 2]) -> f64 {
    let scope = Scope::new().with_variable("x", 0).with_variable("t", 1);
    let condition =
        Formula::parse_condition(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let margin = condition.margin(&scope).expect("a condition of the scope");
    margin.evaluate(&x, &[])
}

/// Parts of which one holds where both sides are equal and another does not: each keeps its own.
#[test]
fn a_margin_has_the_sign_of_its_condition_where_sides_are_equal() {
    for (text, x, holds) in [
        ("x > 1", [1.0, 0.0], false),
        ("x >= 1", [1.0, 0.0], true),
        ("not x > 1", [1.0, 0.0], true),
        ("x > 1 or t >= 10", [1.0, 0.0], false),
        ("x > 1 or t >= 10", [1.0, 10.0], true),
        ("x > 1 and t >= 10", [1.0, 10.0], false),
        ("sign(x) >= 1 and t < 2", [3.0, 1.0], true),
        ("sign(x) >= 1 and t < 2", [3.0, 2.0], false),
        ("not (sign(x) < 1 or t > 2)", [3.0, 2.0], true),
        ("0 <= x < 1", [0.0, 0.0], true),
        ("x != 1", [1.0, 0.0], false),
    ] {
        let found = margin(text, x);
        assert!(
            found != 0.0 && (found > 0.0) == holds,
            "{text} at {x:?}: {found}"
        );
    }
    assert_eq!(margin("x > 1", [1.5, 0.0]), 0.5);
    assert_eq!(margin("x >= 1", [1.0, 0.0]), EQUAL_MARGIN);
    assert!(margin("ln(x) >= 1", [-1.0, 0.0]).is_nan());
}

/// A part by `==` never ends a run, and the other parts do not excuse it.
#[test]
fn a_condition_with_a_part_of_points_is_of_points() {
    let of_points = |text: &str| Formula::parse_condition(text).expect(text).is_of_points();
    for text in [
        "x == 1",
        "x == 1 or t > 2",
        "x == 1 and t > 2",
        "not (x != 1 and t > 2)",
    ] {
        assert!(of_points(text), "{text}");
    }
    for text in ["x > 1", "x != 1 or t > 2", "not (x == 1 or t > 2)"] {
        assert!(!of_points(text), "{text}");
    }
}

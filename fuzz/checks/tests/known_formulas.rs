//! Formulas that exact algebra had wrong once, and hard ones.

use leafwise::expression::Function;
use leafwise_fuzz_checks::Reached;
use leafwise_fuzz_checks::formulas::compare;
use leafwise_fuzz_checks::tree::Tree;

fn x() -> Tree {
    Tree::Variable(0)
}

fn over(above: f64, below: Tree) -> Tree {
    Tree::Quotient(Tree::Number(above).into(), below.into())
}

/// The derivative is a product of three powers far from 1.
#[test]
fn a_derivative_through_nested_powers_is_right() {
    let inner = Tree::Sum(vec![(false, Tree::Number(2.74)), (true, x().times(-1.06))]);
    let power = Tree::Power(inner.into(), 7, 3).shifted(26.8).to(-3);
    let tree = power.under(Function::Atan);
    assert_eq!(compare(&tree, &[1.24, 0.0, 0.0]), Ok(Reached::Comparison));
}

#[test]
fn reciprocals_of_sums_with_negative_powers_are_right() {
    for below in [
        over(-2.0, x()).shifted(1.0),
        over(-1.0, x()).shifted(2.0),
        over(2.0, x()).shifted(1.0),
        over(-1.0, x().to(2)).shifted(1.0),
        x().times(-1.0).under(Function::Exp).shifted(2.0),
        x().plus(Tree::Quotient(
            Tree::Variable(1).times(-2.0).into(),
            x().into(),
        )),
    ] {
        let roots = [2, 3].map(|d| Tree::Power(below.clone().into(), 1, d));
        for tree in roots.into_iter().chain([below.inverse()]) {
            let found = compare(&tree, &[4.0, 0.5, 0.0]);
            assert_eq!(found, Ok(Reached::Comparison), "{tree}");
        }
    }
    for function in [
        Function::Asin,
        Function::Acos,
        Function::Atanh,
        Function::Ln,
    ] {
        let tree = over(1.0, x()).under(function);
        let found = compare(&tree, &[4.0, 0.5, 0.0]);
        assert_eq!(found, Ok(Reached::Comparison), "{tree}");
    }
}

#[test]
fn powers_about_a_distant_point_and_high_ones_are_right() {
    for tree in [
        x().shifted(-10.0).to(12),
        x().shifted(-1000.0).to(5),
        x().to(400).to(2),
    ] {
        let found = compare(&tree, &[1.02, 0.0, 0.0]);
        assert_eq!(found, Ok(Reached::Comparison), "{tree}");
    }
}

use super::super::{DEPTH_LIMIT, SyntaxErrorKind};
use super::*;
use crate::expression::Function;
use crate::rational::Rational;

const POINT: [f64; 3] = [2.0, 3.0, 5.0];

#[test]
fn operators_bind_as_in_mathematics() {
    for (text, value) in [
        ("-x^2", -4.0),
        ("(-x)^2", 4.0),
        ("x^y^x", 512.0),
        ("x**y", 8.0),
        ("2^-1", 0.5),
        ("2^-x^2", 1.0 / 16.0),
        ("x - y - z", -6.0),
        ("x/y*y", 2.0),
        ("x*y/z*10", 12.0),
        ("30/x/y", 5.0),
        ("x - -y", 5.0),
        ("--x", 2.0),
        ("2*-x", -4.0),
        ("+x", 2.0),
        ("-x*y + z", -1.0),
        (" ( x ) ", 2.0),
        (".5e1 + 1.", 6.0),
        ("1e1*x", 20.0),
    ] {
        let expression = resolve(text);
        assert_eq!(
            expression.evaluate(&POINT, &[0.0, 0.0]),
            value,
            "{text} = {expression:?}"
        );
    }
}

#[test]
fn decimals_are_exact_and_quotients_of_numbers_are_carried_out() {
    assert_eq!(resolve("0.1"), Expression::Constant(Rational::new(1, 10)));
    assert_eq!(resolve("-1/3"), Expression::Constant(Rational::new(-1, 3)));
    let half = Box::new(Expression::Constant(Rational::new(1, 2)));
    let root = Expression::Power(Box::new(Expression::Variable(0)), half);
    assert_eq!(resolve("x^(1/2)"), root);
    let zero = || Box::new(Expression::Constant(Rational::zero()));
    assert_eq!(resolve("0/0"), Expression::Quotient(zero(), zero()));
}

#[test]
fn every_function_is_called_by_its_name() {
    for function in Function::ALL {
        let argument = Box::new(Expression::Variable(1));
        assert_eq!(
            resolve(&format!("{function} (y)")),
            Expression::Apply(function, argument)
        );
    }
    assert_eq!(resolve("pi"), Expression::Pi);
}

#[test]
fn names_may_have_letters_of_any_script() {
    let scope = Scope::new()
        .with_variables(&["γ_1", "x₁", "e"])
        .with_parameters(&["ω"]);
    let formula = parse("γ_1*ω + 2*e - x₁");
    let expression = formula
        .resolve(&scope, None)
        .expect("names")
        .expect("no boundary");
    assert_eq!(expression.evaluate(&[3.0, 1.0, 10.0], &[7.0]), 40.0);
    assert_eq!(
        formula.references().into_iter().collect::<Vec<_>>(),
        ["e", "x₁", "γ_1", "ω"]
    );
}

#[test]
fn sums_and_products_of_any_length_are_flat() {
    let count = 100_000;
    let sum = vec!["x"; count].join(" - ");
    assert_eq!(
        resolve(&sum).evaluate(&POINT, &[]),
        2.0 * (2.0 - count as f64)
    );
    let product = vec!["1"; count].join("*");
    assert_eq!(resolve(&product).evaluate(&POINT, &[]), 1.0);
}

/// Parsed, printed, resolved, evaluated and dropped on the stack of a test's thread.
#[test]
fn formulas_nest_to_the_limit_and_no_deeper() {
    let forms = [
        ("(", "x", ")"),
        ("-", "x", ""),
        ("x^", "x", ""),
        ("sin(", "x", ")"),
    ];
    for (open, middle, close) in forms {
        let text = |depth| [open.repeat(depth), middle.to_owned(), close.repeat(depth)].concat();
        let deepest = text(DEPTH_LIMIT);
        let (expression, printed) = (resolve(&deepest), resolve(&parse(&deepest).to_string()));
        assert_eq!(expression, printed);
        let values = [&expression, &printed].map(|tree| tree.evaluate(&POINT, &[]).to_bits());
        assert_eq!(values[0], values[1]);
        for depth in [DEPTH_LIMIT + 1, 100_000] {
            let error = Formula::parse(&text(depth)).expect_err("too deep");
            assert_eq!(error.kind, SyntaxErrorKind::TooDeep { limit: DEPTH_LIMIT });
        }
    }
    for (open, close) in [("x-y*sin(", ")/z"), ("(x+y*", ")^2"), ("(x/y*-", ")")] {
        let text = |depth| [open.repeat(depth), "x".to_owned(), close.repeat(depth)].concat();
        resolve(&parse(&text(DEPTH_LIMIT / 5)).to_string());
        for depth in [DEPTH_LIMIT, DEPTH_LIMIT + 1] {
            let error = Formula::parse(&text(depth)).expect_err("too deep");
            assert_eq!(error.kind, SyntaxErrorKind::TooDeep { limit: DEPTH_LIMIT });
        }
    }
    let chain = |divisions| vec!["x"; divisions + 1].join("/");
    assert_eq!(resolve(&chain(DEPTH_LIMIT)).evaluate(&[1.0], &[]), 1.0);
    let error = Formula::parse(&chain(100_000)).expect_err("too deep");
    assert_eq!(error.kind, SyntaxErrorKind::TooDeep { limit: DEPTH_LIMIT });
}

#[test]
fn a_formula_prints_with_the_parentheses_it_needs() {
    for (text, printed) in [
        ("((x))+((y*z))", "x + y*z"),
        ("(x+y)-(z-1)", "(x + y) - (z - 1)"),
        ("-(x*y)", "-(x*y)"),
        ("-x*y", "-x*y"),
        ("(x*y)*z", "(x*y)*z"),
        ("x/(y*z)", "x/(y*z)"),
        ("(x^y)^2.50", "(x^y)^2.50"),
        ("x**(-y)", "x^-y"),
        ("sum(i,u[ i + 1 ]*u[0-1+N])", "sum(i, u[i+1]*u[N-1])"),
        ("sqrt(x) + +pi*N", "sqrt(x) + pi*N"),
    ] {
        let first = parse(text).to_string();
        assert_eq!(first, printed, "{text}");
        assert_eq!(parse(&first).to_string(), printed);
    }
}

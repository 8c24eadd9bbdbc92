//! Powers of even powers: (xⁿ)ᵃ = |x|ⁿᵃ for an even n, written as xⁿᵃ where na is even too, as (x²)^(na/2) elsewhere.
//!
//! This is how |x| is written, as (x^2)^0.5 or sqrt(x^4). Slopes of the form chosen here have values at x = 0 wherever
//! the function has a slope there. Thus sqrt(x⁴) is x², and |x| x² is (x²)^(3/2), whose two derivatives hold no
//! negative power of x. The second derivative of |x|ᵃ has none by code at 0 where 2 < a < 3, as 0·∞.

use crate::expression::{Expression, Function};
use crate::rational::Rational;

/// a^b.
pub(crate) fn power(base: Expression, exponent: Expression) -> Expression {
    if let Expression::Constant(b) = &exponent
        && !b.is_integer()
        && let Some((x, n)) = as_even(&base)
    {
        return even(x.clone(), &n * b);
    }
    Expression::Power(Box::new(base), Box::new(exponent))
}

/// f(a).
pub(crate) fn apply(function: Function, argument: Expression) -> Expression {
    if function == Function::Sqrt
        && let Some((x, n)) = as_even(&argument)
        && n != two()
    {
        return even(x.clone(), &n * &Rational::new(1, 2));
    }
    Expression::Apply(function, Box::new(argument))
}

/// The product, in which |x|ᵃ and even powers of x are one factor.
pub(crate) fn product(factors: Vec<Expression>) -> Expression {
    let is_plain = |n: &Rational| (n * &Rational::new(1, 2)).is_integer();
    let first = factors
        .iter()
        .find_map(|factor| as_even(factor).filter(|(_, n)| !is_plain(n)));
    let Some(x) = first.map(|(x, _)| x.clone()) else {
        return Expression::Product(factors);
    };
    let (mut total, mut rest, mut place, mut count) = (Rational::zero(), Vec::new(), 0, 0);
    for factor in &factors {
        match as_even(factor).filter(|(other, _)| **other == x) {
            Some((_, n)) => {
                place = if count == 0 { rest.len() } else { place };
                count += 1;
                total += &n;
            }
            None => rest.push(factor.clone()),
        }
    }
    if count < 2 {
        return Expression::Product(factors);
    }
    rest.insert(place, even(x, total));
    Expression::Product(rest)
}

/// x and a of |x|ᵃ, where an expression is written as a power of an even power of x.
fn as_even(expression: &Expression) -> Option<(&Expression, Rational)> {
    match expression {
        Expression::Power(base, exponent) => {
            let Expression::Constant(b) = &**exponent else {
                return None;
            };
            if (b * &Rational::new(1, 2)).is_integer() {
                return Some((base, b.clone()));
            }
            let (x, n) = as_even(base)?;
            Some((x, &n * b))
        }
        Expression::Apply(Function::Sqrt, argument) => {
            let (x, n) = as_even(argument)?;
            Some((x, &n * &Rational::new(1, 2)))
        }
        Expression::Shared(shared) => as_even(shared),
        _ => None,
    }
}

/// |x|ᵃ.
fn even(x: Expression, a: Rational) -> Expression {
    let constant = |value| Box::new(Expression::Constant(value));
    let half = &a * &Rational::new(1, 2);
    if half.is_integer() {
        return Expression::Power(Box::new(x), constant(a));
    }
    let square = Expression::Power(Box::new(x), constant(two()));
    Expression::Power(Box::new(square), constant(half))
}

fn two() -> Rational {
    Rational::from_integer(2)
}

#[cfg(test)]
mod tests {
    use crate::arithmetic::Arithmetic;
    use crate::graph::Graph;
    use crate::kernel::Kernel;
    use crate::syntax::{Formula, Scope};

    /// The value and so many derivatives of a formula at x, by code.
    fn derivatives(text: &str, count: usize, x: f64) -> Vec<f64> {
        let scope = Scope::new().with_variables(&["x"]);
        let formula = Formula::parse(text).expect(text);
        let formula = formula.resolve(&scope, None).expect(text).expect(text);
        let mut graph = Graph::new();
        let code =
            formula.evaluate_in(&mut graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)));
        let mut outputs = vec![code.expect(text)];
        for _ in 0..count {
            let last = outputs.last().expect("the value").clone();
            outputs.push(graph.derivative(&last, 0).expect(text));
        }
        assert_eq!(graph.refusal(), None);
        let kernel = Kernel::compile(&graph, &outputs, 0, 1);
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
        let mut values = vec![0.0; outputs.len()];
        kernel.evaluate(&mut workspace, &[x], &mut values);
        values
    }

    /// c |x|ᵃ in many spellings has the derivatives c a (a − 1) … |x|^(a−k) sign(x)ᵏ, those below the a-th at 0 too.
    #[test]
    fn powers_of_even_powers_have_the_derivatives_that_exist() {
        let spellings = [
            ("sqrt(x^4)", 1.0, 2.0),
            ("(x^2)^0.9375", 1.0, 1.875),
            ("(x^2)^0.5*x^2", 1.0, 3.0),
            ("x^2*sqrt(x^2)", 1.0, 3.0),
            ("3*x^2*(x^2)^(1/4)*2", 6.0, 2.5),
            ("(x^2)^1.5", 1.0, 3.0),
            ("sqrt(x^6)", 1.0, 3.0),
            ("(x^4)^0.7", 1.0, 2.8),
            ("(4*x^2)^0.75", libm::pow(4.0, 0.75), 1.5),
            ("sqrt(sqrt(x^8))", 1.0, 2.0),
            ("((x^2)^0.5)^3.5", 1.0, 3.5),
            ("(x^2)^(5/3)*x^4", 1.0, 22.0 / 3.0),
        ];
        for (text, c, a) in spellings {
            for x in [0.0_f64, 1e-200, -1e-90, 0.3, -1.7] {
                // The second derivative by code holds (x²)^(a/2−2) x²; x² has no value below 1e-162.
                let is_plain = a >= 3.0 || text == "sqrt(x^4)" || text == "sqrt(sqrt(x^8))";
                let orders = if x.abs() < 1e-150 && !is_plain { 1 } else { 2 };
                let found = derivatives(text, orders, x);
                for (k, found) in found.into_iter().enumerate() {
                    let (mut factor, mut exponent) = (c, a);
                    for _ in 0..k {
                        factor *= exponent;
                        exponent -= 1.0;
                    }
                    let sign = if k == 1 && x < 0.0 { -1.0 } else { 1.0 };
                    let expected = sign * factor * libm::pow(x.abs(), exponent);
                    // A power rounds its exponent times the logarithm.
                    let logarithm = if x == 0.0 {
                        0.0
                    } else {
                        libm::log(x.abs()).abs()
                    };
                    let noise = (64.0 + 8.0 * logarithm) * f64::EPSILON * expected.abs();
                    // x² has few digits below 1e-154, and none below 1e-162.
                    let hidden = if x.abs() < 1e-100 && x != 0.0 {
                        f64::INFINITY
                    } else {
                        0.0
                    };
                    assert!(
                        found.is_finite() && (found - expected).abs() <= noise.max(hidden),
                        "{text}, derivative {k} at {x}: {found} for {expected}"
                    );
                }
            }
        }
    }

    /// A product of powers of a radius has its limit at 0, a root of a coordinate has an infinite slope there.
    #[test]
    fn slopes_that_do_not_exist_are_not_finite() {
        for text in ["sqrt(x)", "x^0.75", "(x^2)^0.25"] {
            let found = derivatives(text, 1, 0.0);
            assert!(!found[1].is_finite(), "{text}: {found:?}");
        }
        let at_rest = derivatives("(x^2 + (2*x)^2)^0.75", 1, 0.0);
        assert_eq!(at_rest, [0.0, 0.0]);
    }
}

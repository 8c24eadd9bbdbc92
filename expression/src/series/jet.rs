//! The jet of a field's solutions as code.

use super::tape::{Tape, TaylorState};
use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::expression::{Binary, Function, Side};
use crate::graph::{Graph, StepSize, Term};
use crate::rational::Rational;
use crate::table::Lookup;

/// x_1, …, x_p of the solution x(t) = Σ x_k (t/h)ᵏ of ẋ = f(x) through the first inputs x_0 of `graph`, as code. The
/// recursion is x_{k+1} = h f_k/(k + 1), where `field` is f at x_0 (Jorba, Zou, Experimental Mathematics 14 (2005),
/// section 2).
///
/// The unit of time h is the kernel's step size: coefficients of a motion that takes 10⁻¹⁷ units of time stay within
/// doubles. A power of 2 changes no digit.
///
/// # Errors
/// [`AlgebraError`] for a field that has no series or whose jet grows past the graph's limit.
pub fn jet(
    graph: &mut Graph,
    field: &[Term],
    order: usize,
) -> Result<Vec<Vec<Term>>, AlgebraError> {
    let mut tape = Tape::new();
    let x: Vec<_> = (0..field.len()).map(|i| tape.variable(i)).collect();
    let field = graph.evaluate_in(&mut tape, field, &x)?;
    let mut coefficients = vec![(0..x.len()).map(|i| graph.input(i)).collect::<Vec<Term>>()];
    let mut state = TaylorState::new(&tape);
    let unit = graph.step_size(StepSize::H);
    let mut code = Code { graph };
    for k in 0..order {
        state.extend(&tape, &mut code, |_, i| coefficients[k][i].clone())?;
        let share = code.graph.scale(&Rational::new(1, k as i64 + 1), &unit);
        let next = field
            .iter()
            .map(|f| code.share(&share, state.coefficient(*f, k)))
            .collect();
        coefficients.push(next);
    }
    code.graph.unless_refused(())?;
    coefficients.remove(0);
    Ok(coefficients)
}

/// The coefficients of order 0, 1, … of the code `terms` of another graph along the curve x(t) = Σ x_k tᵏ. Here
/// `curve[k]` has the coefficient x_k of each of its inputs, as code of `graph`.
///
/// # Errors
/// As [`jet`].
pub fn along_curve(
    graph: &mut Graph,
    (code, terms): (&Graph, &[Term]),
    curve: &[Vec<Term>],
) -> Result<Vec<Vec<Term>>, AlgebraError> {
    let mut tape = Tape::new();
    let inputs = curve.first().map_or(0, Vec::len);
    let x: Vec<_> = (0..inputs).map(|i| tape.variable(i)).collect();
    let nodes = code.evaluate_in(&mut tape, terms, &x)?;
    let mut state = TaylorState::new(&tape);
    let mut code = Code { graph };
    let mut coefficients = Vec::with_capacity(curve.len());
    for (k, _) in curve.iter().enumerate() {
        state.extend(&tape, &mut code, |_, i| curve[k][i].clone())?;
        let own = nodes.iter().map(|node| state.coefficient(*node, k).clone());
        coefficients.push(own.collect());
    }
    code.graph.unless_refused(())?;
    Ok(coefficients)
}

/// The code of a graph, where what is multiplied is one number, its rational and constant factors included: in
/// products of series each coefficient enters many products.
struct Code<'a> {
    graph: &'a mut Graph,
}

impl Code<'_> {
    /// c·f as one number.
    fn share(&mut self, c: &Term, f: &Term) -> Term {
        let term = self.graph.multiply(c, f);
        self.graph.whole(&term)
    }
}

impl Arithmetic for Code<'_> {
    type Element = Term;

    fn constant(&mut self, value: &Rational) -> Term {
        self.graph.constant(value)
    }
    fn pi(&mut self) -> Term {
        self.graph.pi()
    }
    fn parameter(&mut self, index: usize) -> Term {
        self.graph.parameter(index)
    }
    fn is_zero(&self, element: &Term) -> bool {
        self.graph.is_zero(element)
    }
    fn refusal(&self) -> Option<&AlgebraError> {
        self.graph.refusal()
    }
    fn as_rational(&self, element: &Term) -> Option<Rational> {
        self.graph.as_rational(element)
    }
    fn combine(&mut self, terms: &[(Rational, Term)]) -> Term {
        self.graph.combine(terms)
    }
    fn multiply(&mut self, a: &Term, b: &Term) -> Term {
        let (a, b) = (self.graph.whole(a), self.graph.whole(b));
        self.graph.multiply(&a, &b)
    }
    /// The sum begins with the products that are known first: the newest coefficients end it.
    fn combine_products(
        &mut self,
        terms: &[(Rational, Term)],
        products: &[(Rational, &Term, &Term)],
    ) -> Term {
        let mut products: Vec<_> = products.iter().collect();
        products.retain(|(_, a, b)| !self.is_zero(a) && !self.is_zero(b));
        products.sort_by_key(|(_, a, b)| a.node.max(b.node));
        // Factors beside the smallest go into a_j, which the next orders multiply by the same.
        let factor = products.iter().map(|(c, ..)| c.abs()).min();
        let factor = factor.unwrap_or_else(Rational::one);
        let inverse = factor.recip();
        let mut sum: Vec<(Rational, Term)> = Vec::with_capacity(products.len());
        for (c, a, b) in products {
            let scaled = self.graph.scale(&(c * &inverse), a);
            sum.push((Rational::one(), self.multiply(&scaled, b)));
        }
        let sum = self.graph.combine(&sum);
        let all: Vec<_> = terms.iter().cloned().chain([(factor, sum)]).collect();
        self.graph.combine(&all)
    }
    fn divide(&mut self, a: &Term, b: &Term) -> Result<Term, AlgebraError> {
        self.graph.divide(a, b)
    }
    fn power(&mut self, a: &Term, b: &Term) -> Result<Term, AlgebraError> {
        self.graph.power(a, b)
    }
    fn look_up(&mut self, lookup: Lookup, point: &[Term]) -> Result<Term, AlgebraError> {
        self.graph.look_up(lookup, point)
    }
    fn kept(&mut self, side: Side, c: &Term, v: &Term) -> Result<Term, AlgebraError> {
        self.graph.kept(side, c, v)
    }
    fn apply_two(&mut self, function: Binary, a: &Term, b: &Term) -> Result<Term, AlgebraError> {
        self.graph.apply_two(function, a, b)
    }
    fn apply(&mut self, function: Function, a: &Term) -> Result<Term, AlgebraError> {
        self.graph.apply(function, a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Kernel;
    use crate::syntax::{Formula, Scope};

    /// The jet of ẋ = f(x), `order` coefficients a variable, at a state.
    fn jet_of(field: &[&str], at: &[f64], order: usize) -> (Vec<f64>, u64) {
        let names = ["x", "y"];
        let scope = Scope::new().with_variables(&names[..field.len()]);
        let mut graph = Graph::new();
        let field: Vec<Term> = field
            .iter()
            .map(|text| {
                let formula = Formula::parse(text).expect(text).resolve(&scope, None);
                let formula = formula.expect(text).expect(text);
                let code = formula.evaluate_in(&mut graph, &mut |g: &mut Graph, i| Ok(g.input(i)));
                code.expect(text)
            })
            .collect();
        let jet = jet(&mut graph, &field, order).expect("a jet").concat();
        let kernel = Kernel::compile(&graph, &jet, 0, at.len());
        let mut workspace = kernel.workspace(1);
        let mut values = vec![0.0; jet.len()];
        let mut in_units_of = |h: f64| {
            kernel.prepare(&mut workspace, &[], &[1.0], &[h]);
            kernel.evaluate(&mut workspace, at, &mut values);
            values.clone()
        };
        let (scaled, values) = (in_units_of(0.125), in_units_of(1.0));
        // h = 2⁻³ scales x_k by h^k and changes no digit of it.
        for (at, (scaled, value)) in scaled.iter().zip(&values).enumerate() {
            let k = at / field.len() + 1;
            assert_eq!(*scaled, value * libm::pow(0.125, k as f64), "{at}");
        }
        (values, kernel.step_operations().work())
    }

    fn assert_close(found: &[f64], expected: impl Fn(usize) -> f64, what: &str) {
        for (k, found) in (1..).zip(found) {
            let expected = expected(k);
            let allowed = 64.0 * f64::EPSILON * expected.abs().max(1e-12);
            assert!(
                (found - expected).abs() <= allowed,
                "{what}: x_{k} = {found}, {expected}"
            );
        }
    }

    /// Solutions in closed form: each rule of the tape.
    #[test]
    fn jets_are_those_of_closed_forms() {
        let factorial = |k: usize| (1..=k).map(|j| j as f64).product::<f64>();
        let binomial = |a: f64, k: usize| {
            (0..k)
                .map(|j| (a - j as f64) / (j + 1) as f64)
                .product::<f64>()
        };
        // 1/(1 − t), e^t, √(1 + 2t), ln(1 + t), (1 + t/2)², and 1 − ln(1 − t).
        assert_close(&jet_of(&["x^2"], &[1.0], 18).0, |_| 1.0, "x²");
        assert_close(&jet_of(&["x"], &[1.0], 18).0, |k| factorial(k).recip(), "x");
        let root = |k: usize| binomial(0.5, k) * libm::pow(2.0, k as f64);
        assert_close(&jet_of(&["1/x"], &[1.0], 18).0, root, "1/x");
        let logarithm = |k: usize| -libm::pow(-1.0, k as f64) / k as f64;
        assert_close(&jet_of(&["exp(-x)"], &[0.0], 18).0, logarithm, "exp");
        let square = |k: usize| binomial(2.0, k) * libm::pow(0.5, k as f64);
        assert_close(&jet_of(&["sqrt(x)"], &[1.0], 2).0, square, "sqrt");
        let power = |k: usize| binomial(0.4, k) * libm::pow(2.5, k as f64);
        assert_close(&jet_of(&["x^(-3/2)"], &[1.0], 18).0, power, "power");
        assert_close(
            &jet_of(&["exp(x - 1)"], &[1.0], 18).0,
            |k| 1.0 / k as f64,
            "exp of a sum",
        );
    }

    /// ẋ = y, ẏ = −x: every coefficient is a product with h/k, and one of both has a sign.
    #[test]
    fn linear_fields_take_no_convolutions() {
        let (values, operations) = jet_of(&["y", "-x"], &[0.25, 0.75], 20);
        assert_eq!(operations, 2 * 20 + 20);
        let mut expected = [0.25, 0.75];
        for (k, found) in (1..).zip(values.chunks_exact(2)) {
            expected = [expected[1] / k as f64, -expected[0] / k as f64];
            assert_close(&[found[0]], |_| expected[0], "x");
            assert_close(&[found[1]], |_| expected[1], "y");
        }
    }

    /// x² of p coefficients is p²/4 products.
    #[test]
    fn squares_are_symmetric() {
        let (_, operations) = jet_of(&["x^2"], &[0.5], 20);
        assert!(operations < 2 * 110 + 40, "{operations}");
    }
}

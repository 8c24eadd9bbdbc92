//! The normal form of sums and products: rational factors outside, coefficients beside the state.

use rustc_hash::FxHashMap;

use super::node::{Graph, Node, Operation, Term, Tier};
use crate::analytic::AnalyticFunction;
use crate::arithmetic::{AlgebraError, Arithmetic, simple_value, simple_value_of_two};
use crate::expression::{Binary, Function, Side};
use crate::rational::Rational;
use crate::table::Lookup;

/// The largest ratio of two factors of a sum of which one is pulled out: 2²⁵⁵, whose fourth power is a double.
const LARGEST_RATIO: f64 = f64::from_bits((1023 + 255) << 52);

impl Graph {
    /// f⁽ᵏ⁾(a) for k = `order`.
    pub fn apply_analytic(&mut self, function: AnalyticFunction, order: u32, a: &Term) -> Term {
        let argument = self.unscaled(a);
        let tier = self.tier(argument).max(Tier::Coefficient);
        self.unit(Operation::Analytic(function, order, argument), tier)
    }

    /// A node that holds the whole term: an argument of a function carries its scale inside.
    fn unscaled(&mut self, term: &Term) -> Node {
        if term.scale.is_one() {
            return term.node;
        }
        let tier = self.tier(term.node).max(Tier::Coefficient);
        self.intern(Operation::Scale(term.scale.clone(), term.node), tier)
    }

    /// The term as one node, or its opposite: products with it multiply once, whatever factors it has.
    pub fn whole(&mut self, term: &Term) -> Term {
        if self.tier(term.node) != Tier::Step {
            return term.clone();
        }
        // The rational factor goes into the one of the coefficient tier.
        let term = self.combine(&[(Rational::one(), term.clone())]);
        let is_split = self.split_coefficient(term.node).0.is_some();
        if term.scale.abs().is_one() && !is_split {
            return term;
        }
        let sign = Rational::from_integer(term.scale.signum().into());
        let node = self.intern(Operation::Scale(term.scale.abs(), term.node), Tier::Step);
        Term { scale: sign, node }
    }

    /// A node of the coefficient tier that holds the whole term, its scale included.
    fn coefficient_node(&mut self, term: &Term) -> Node {
        debug_assert!(self.tier(term.node) != Tier::Step);
        if term.scale.is_one() {
            return term.node;
        }
        if let Operation::Scale(inner, node) = self.operation(term.node).clone() {
            return self.coefficient_node(&Term {
                scale: &inner * &term.scale,
                node,
            });
        }
        self.intern(
            Operation::Scale(term.scale.clone(), term.node),
            Tier::Coefficient,
        )
    }

    /// The factor of the coefficient tier in front of a state-dependent node, and the rest.
    fn split_coefficient(&self, node: Node) -> (Option<Node>, Node) {
        match *self.operation(node) {
            Operation::Product(a, b)
                if self.tier(a) == Tier::Coefficient && self.tier(b) == Tier::Step =>
            {
                (Some(a), b)
            }
            Operation::Product(a, b)
                if self.tier(b) == Tier::Coefficient && self.tier(a) == Tier::Step =>
            {
                (Some(b), a)
            }
            _ => (None, node),
        }
    }

    fn product_node(&mut self, a: Node, b: Node) -> Node {
        let tier = self.tier(a).max(self.tier(b));
        self.intern(Operation::Product(a.min(b), a.max(b)), tier)
    }

    /// coefficient · node, the coefficient's sign left outside where it is a plain number.
    fn attach(&mut self, coefficient: &Term, node: Node) -> Term {
        if coefficient.scale.is_zero() {
            return Self::number(Rational::zero());
        }
        if coefficient.node == Self::ONE {
            return Term {
                scale: coefficient.scale.clone(),
                node,
            };
        }
        let sign = coefficient.scale.signum();
        let magnitude = Term {
            scale: coefficient.scale.abs(),
            node: coefficient.node,
        };
        let factor = self.coefficient_node(&magnitude);
        Term {
            scale: Rational::from_integer(sign.into()),
            node: self.product_node(factor, node),
        }
    }

    /// Σ cᵢ nᵢ over constant and coefficient tiers.
    fn sum_coefficients(&mut self, terms: &[(Rational, Node)]) -> Term {
        let mut sums: Vec<(Rational, Node)> = Vec::with_capacity(terms.len());
        let mut sorted = terms.to_vec();
        sorted.sort_by_key(|t| t.1);
        for (scale, node) in sorted {
            match sums.last_mut() {
                Some(last) if last.1 == node => last.0 += &scale,
                _ => sums.push((scale, node)),
            }
        }
        sums.retain(|t| !t.0.is_zero());
        self.normal_sum(sums, Tier::Coefficient)
    }

    /// A sum of distinct sorted nodes with its scale pulled out: the scale that most terms share,
    /// the smallest of those, with the first term positive. Proportional sums become one node.
    fn normal_sum(&mut self, mut sums: Vec<(Rational, Node)>, tier: Tier) -> Term {
        match sums.as_slice() {
            [] => return Self::number(Rational::zero()),
            [(scale, node)] => {
                return Term {
                    scale: scale.clone(),
                    node: *node,
                };
            }
            _ => {}
        }
        let mut sizes: Vec<Rational> = sums.iter().map(|t| t.0.abs()).collect();
        sizes.sort();
        let mut best = (0, &sizes[0]);
        let mut start = 0;
        for at in 0..sizes.len() {
            if sizes[at] != sizes[start] {
                start = at;
            }
            if at + 1 - start > best.0 {
                best = (at + 1 - start, &sizes[at]);
            }
        }
        let mut scale = best.1.clone();
        if sums[0].0.is_negative() {
            scale = -scale;
        }
        if !scale.is_one() {
            let inverse = scale.recip();
            let ratios: Vec<Rational> = sums.iter().map(|t| &t.0 * &inverse).collect();
            // Larger ratios would lose what the factors themselves say: derivatives of a root or of a quotient raise them to powers.
            let holds = |ratio: &Rational| {
                let size = ratio.to_f64().abs();
                (1.0 / LARGEST_RATIO..=LARGEST_RATIO).contains(&size)
            };
            if ratios.iter().all(holds) {
                for (term, ratio) in sums.iter_mut().zip(ratios) {
                    term.0 = ratio;
                }
            } else {
                scale = Rational::one();
            }
        }
        Term {
            scale,
            node: self.intern(Operation::Sum(sums.into_boxed_slice()), tier),
        }
    }
}

impl Arithmetic for Graph {
    type Element = Term;

    fn constant(&mut self, value: &Rational) -> Term {
        Self::number(value.clone())
    }
    fn pi(&mut self) -> Term {
        self.unit(Operation::Pi, Tier::Coefficient)
    }
    fn parameter(&mut self, index: usize) -> Term {
        let index = u32::try_from(index).expect("fewer than 2^32 parameters");
        self.unit(Operation::Parameter(index), Tier::Coefficient)
    }
    fn is_zero(&self, element: &Term) -> bool {
        element.scale.is_zero()
    }
    fn refusal(&self) -> Option<&AlgebraError> {
        self.refusal.as_ref()
    }
    fn as_rational(&self, element: &Term) -> Option<Rational> {
        (element.node == Self::ONE || element.scale.is_zero()).then(|| element.scale.clone())
    }

    fn combine(&mut self, terms: &[(Rational, Term)]) -> Term {
        // Per state-dependent node: its rational factor and its factors of the coefficient tier.
        let mut coefficients: Vec<(Rational, Node)> = Vec::new();
        let mut order: Vec<Node> = Vec::new();
        let mut parts: FxHashMap<Node, Vec<(Rational, Node)>> = FxHashMap::default();
        for (factor, term) in terms {
            let scale = factor * &term.scale;
            if scale.is_zero() {
                continue;
            }
            if self.tier(term.node) != Tier::Step {
                coefficients.push((scale, term.node));
                continue;
            }
            let (coefficient, rest) = self.split_coefficient(term.node);
            parts
                .entry(rest)
                .or_insert_with(|| {
                    order.push(rest);
                    Vec::new()
                })
                .push((scale, coefficient.unwrap_or(Self::ONE)));
        }
        let mut sums: Vec<(Rational, Node)> = Vec::with_capacity(order.len() + 1);
        for node in order {
            let coefficient = self.sum_coefficients(&parts[&node]);
            let term = self.attach(&coefficient, node);
            if !term.scale.is_zero() {
                sums.push((term.scale, term.node));
            }
        }
        let constant = self.sum_coefficients(&coefficients);
        if sums.is_empty() {
            return constant;
        }
        if constant.node == Self::ONE {
            if !constant.scale.is_zero() {
                sums.push((constant.scale, Self::ONE));
            }
        } else {
            let sign = Rational::from_integer(constant.scale.signum().into());
            let magnitude = Term {
                scale: constant.scale.abs(),
                node: constant.node,
            };
            sums.push((sign, self.coefficient_node(&magnitude)));
        }
        sums.sort_by_key(|t| t.1);
        self.normal_sum(sums, Tier::Step)
    }

    fn multiply(&mut self, a: &Term, b: &Term) -> Term {
        let scale = &a.scale * &b.scale;
        if scale.is_zero() {
            return Self::number(Rational::zero());
        }
        if a.node == Self::ONE || b.node == Self::ONE {
            return Term {
                scale,
                node: a.node.max(b.node),
            };
        }
        match (self.tier(a.node), self.tier(b.node)) {
            (Tier::Step, Tier::Step) => Term {
                scale,
                node: self.product_node(a.node, b.node),
            },
            (Tier::Step, _) | (_, Tier::Step) => {
                let (step, outer) = if self.tier(a.node) == Tier::Step {
                    (a, b)
                } else {
                    (b, a)
                };
                let (inner, rest) = self.split_coefficient(step.node);
                let coefficient = match inner {
                    None => outer.node,
                    Some(inner) => self.product_node(inner, outer.node),
                };
                self.attach(
                    &Term {
                        scale,
                        node: coefficient,
                    },
                    rest,
                )
            }
            _ => Term {
                scale,
                node: self.product_node(a.node, b.node),
            },
        }
    }

    fn multiply_reduced(&mut self, a: &Term, b: &Term) -> Term {
        let reduced = self.reduced_product(a, b);
        reduced.unwrap_or_else(|| self.multiply(a, b))
    }

    fn divide(&mut self, a: &Term, b: &Term) -> Result<Term, AlgebraError> {
        if b.scale.is_zero() {
            return Err(AlgebraError::DivisionByZero);
        }
        if b.node == Self::ONE {
            return Ok(Term {
                scale: &a.scale * &b.scale.recip(),
                node: a.node,
            });
        }
        if a.node == b.node {
            return Ok(Self::number(&a.scale * &b.scale.recip()));
        }
        let tier = self.tier(b.node);
        let reciprocal = match *self.operation(b.node) {
            Operation::Reciprocal(inner) => inner,
            _ => self.intern(Operation::Reciprocal(b.node), tier),
        };
        let below = Term {
            scale: b.scale.recip(),
            node: reciprocal,
        };
        Ok(self.multiply(a, &below))
    }

    fn power(&mut self, a: &Term, b: &Term) -> Result<Term, AlgebraError> {
        if self.tier(b.node) == Tier::Step {
            return Err(AlgebraError::VariableExponent);
        }
        let half = self.as_rational(b).filter(|r| *r == Rational::new(1, 2));
        if half.is_some() {
            return self.apply(Function::Sqrt, a);
        }
        let base = self.unscaled(a);
        let exponent = self.unscaled(b);
        let tier = self.tier(base).max(Tier::Coefficient);
        Ok(self.unit(Operation::Power(base, exponent), tier))
    }

    fn apply_two(&mut self, function: Binary, a: &Term, b: &Term) -> Result<Term, AlgebraError> {
        if let (Some(x), Some(y)) = (self.as_rational(a), self.as_rational(b))
            && let Some(simple) = simple_value_of_two(function, &x, &y)?
        {
            return Ok(Self::number(simple));
        }
        let [a, b] = [a, b].map(|term| self.unscaled(term));
        let tier = self.tier(a).max(self.tier(b)).max(Tier::Coefficient);
        Ok(self.unit(Operation::Binary(function, a, b), tier))
    }
    fn look_up(&mut self, lookup: Lookup, point: &[Term]) -> Result<Term, AlgebraError> {
        let point: Box<[Node]> = point.iter().map(|at| self.unscaled(at)).collect();
        let tiers = point.iter().map(|at| self.tier(*at));
        let tier = tiers.fold(Tier::Coefficient, Tier::max);
        Ok(self.unit(Operation::Lookup(lookup, point), tier))
    }

    fn kept(&mut self, side: Side, c: &Term, v: &Term) -> Result<Term, AlgebraError> {
        if let Some(number) = self.as_rational(c) {
            return Ok(match side.has(&number) {
                true => v.clone(),
                false => self.zero(),
            });
        }
        if self.is_zero(v) {
            return Ok(v.clone());
        }
        // A factor of c is left out but for its sign.
        let sign = Term {
            scale: Rational::from_integer(c.scale.signum().into()),
            node: c.node,
        };
        let condition = self.unscaled(&sign);
        let tier = self.tier(condition).max(self.tier(v.node));
        let tier = tier.max(Tier::Coefficient);
        let node = self.intern(Operation::Kept(side, condition, v.node), tier);
        Ok(Term {
            scale: v.scale.clone(),
            node,
        })
    }

    fn apply(&mut self, function: Function, a: &Term) -> Result<Term, AlgebraError> {
        if let Some(value) = self.as_rational(a)
            && let Some(simple) = simple_value(function, &value)?
        {
            return Ok(Self::number(simple));
        }
        let argument = self.unscaled(a);
        let tier = self.tier(argument).max(Tier::Coefficient);
        Ok(self.unit(Operation::Function(function, argument), tier))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Kernel;
    use crate::syntax::{Formula, Scope};

    fn value(text: &str, x: f64) -> f64 {
        let scope = Scope::new().with_variables(&["x"]);
        let parsed = Formula::parse(text).expect(text);
        let formula = parsed.resolve(&scope, None).expect(text).expect(text);
        let mut graph = Graph::new();
        let code = formula.evaluate_in(&mut graph, &mut |graph: &mut Graph, i| Ok(graph.input(i)));
        let kernel = Kernel::compile(&graph, &[code.expect(text)], 0, 1);
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
        let mut values = [0.0];
        kernel.evaluate(&mut workspace, &[x], &mut values);
        values[0]
    }

    /// d/dx 1/(a x² + s) = −2 a x/(a x² + s)², also where s is there for x = 0 alone and would be taken out of the sum, and raised to powers.
    #[test]
    fn sums_with_a_tiny_summand_have_their_derivatives() {
        let (tiny, x, a) = (Rational::from_f64(f64::MIN_POSITIVE), 0.1, 3.0);
        let mut graph = Graph::new();
        let input = graph.input(0);
        let square = graph.multiply(&input, &input);
        let factor = graph.constant(&Rational::from_f64(a).expect("finite"));
        let square = graph.multiply(&factor, &square);
        let tiny = graph.constant(&tiny.expect("finite"));
        let below = graph.add(&square, &tiny);
        let one = graph.one();
        let quotient = graph.divide(&one, &below).expect("not zero");
        let root = graph.apply(Function::Sqrt, &below).expect("a root");
        let slopes = [&quotient, &root].map(|term| graph.derivative(term, 0).expect("smooth"));
        let kernel = Kernel::compile(&graph, &slopes, 0, 1);
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
        let mut values = [0.0; 2];
        kernel.evaluate(&mut workspace, &[x], &mut values);
        let square = a * x * x;
        let expected = [-2.0 * a * x / (square * square), a * x / libm::sqrt(square)];
        for (value, expected) in values.iter().zip(expected) {
            // A dozen operations.
            assert!(
                (value - expected).abs() < 8.0 * f64::EPSILON * expected.abs(),
                "{value} for {expected}"
            );
        }
    }

    /// A factor that all terms share is not taken out where that leaves a double's range.
    #[test]
    fn sums_with_factors_of_extreme_sizes_keep_their_values() {
        assert_eq!(value("x + x + x + 1e-320", 2.0), 6.0);
        assert_eq!(value("1e-320*x + 3", 1.0), 3.0);
        assert_eq!(value("1e300*x + 1e-300", 1.0), 1e300);
        assert_eq!(value("1 - x^(-81.4) - 1/256", 1.0), -1.0 / 256.0);
    }

    #[test]
    fn a_graph_refuses_to_grow_past_its_limit() {
        let mut graph = Graph::limited(4);
        let x = graph.input(0);
        let square = graph.multiply(&x, &x);
        assert_eq!(graph.refusal(), None);
        let cube = graph.multiply(&square, &x);
        assert_eq!(graph.refusal(), None);
        graph.multiply(&cube, &x);
        assert_eq!(
            graph.refusal(),
            Some(&AlgebraError::CodeTooLong { most: 4 })
        );
    }

    #[test]
    #[cfg(debug_assertions)]
    #[should_panic(expected = "two functions are called")]
    fn two_functions_of_one_name_are_reported() {
        let mut graph = Graph::new();
        let x = graph.input(0);
        for function in [|_, s| s, |_, s: f64| s + 1.0] as [fn(u32, f64) -> f64; 2] {
            graph.apply_analytic(AnalyticFunction::new("one name", function), 0, &x);
        }
    }
}

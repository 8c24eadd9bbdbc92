//! Where straight-line code may have poles.

use std::collections::BTreeSet;

use super::node::{Graph, Node, Operation, Term, Tier};
use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::expression::{Binary, Function};

impl Graph {
    /// State-dependent factors of denominators, and of arguments of ln, in these terms that are not of one sign by
    /// their form. A pole of the terms or their derivatives lies where one of them changes its sign. The denominator
    /// of tan is cos. Factors such as q₁² + q₂² are left out, for they vanish without a change of sign. So is x in √x,
    /// x^(1/3) or ln x, for behind its zero there is no value.
    ///
    /// # Errors
    /// [`AlgebraError`] where the code grows beyond the graph's limit.
    pub fn denominators(&mut self, terms: &[Term]) -> Result<Vec<Term>, AlgebraError> {
        let mut open = Vec::new();
        let (mut angles, mut inner) = (Vec::new(), Vec::new());
        let mut parts: Vec<Node> = terms.iter().map(|term| term.node).collect();
        let mut met: BTreeSet<Node> = parts.iter().copied().collect();
        while let Some(node) = parts.pop() {
            match *self.operation(node) {
                Operation::Reciprocal(a) => open.push(a),
                Operation::Power(a, _)
                | Operation::Function(Function::Ln | Function::Log10 | Function::Log2, a) => {
                    inner.push(a);
                }
                Operation::Function(Function::Tan, a) => angles.push(a),
                Operation::Binary(Binary::Mod, _, b) => open.push(b),
                _ => {}
            }
            let operands = self.operands(node).into_iter();
            parts.extend(operands.filter(|operand| met.insert(*operand)));
        }
        for angle in angles {
            open.push(self.apply(Function::Cos, &Term::of(angle))?.node);
        }
        let never_negative = self.never_negative();
        open.extend(inner.iter().filter(|a| never_negative[a.index()]));
        let mut seen = BTreeSet::new();
        let mut factors = BTreeSet::new();
        while let Some(node) = open.pop() {
            if self.tier(node) != Tier::Step || !seen.insert(node) {
                continue;
            }
            match *self.operation(node) {
                Operation::Product(a, b) => open.extend([a, b]),
                Operation::Scale(_, a)
                | Operation::Reciprocal(a)
                | Operation::Function(Function::Abs, a) => open.push(a),
                Operation::Power(a, _) | Operation::Function(Function::Sqrt, a) => {
                    open.extend(never_negative[a.index()].then_some(a));
                }
                _ if never_negative[node.index()] => {}
                _ => {
                    factors.insert(node);
                }
            }
        }
        let mut denominators: Vec<Term> = factors.iter().copied().map(Term::of).collect();
        for factor in &factors {
            denominators.extend(self.without_own_poles(*factor));
        }
        self.unless_refused(denominators)
    }

    /// A denominator times its own denominators. For 1 + a/x, which changes its sign at x = −a and at x = 0, that is
    /// x + a. This changes its sign only where 1/(1 + a/x) has a pole.
    fn without_own_poles(&mut self, denominator: Node) -> Option<Term> {
        let mut own = BTreeSet::new();
        let (mut parts, mut met) = (vec![denominator], BTreeSet::from([denominator]));
        while let Some(node) = parts.pop() {
            if let Operation::Reciprocal(a) = *self.operation(node)
                && self.tier(a) == Tier::Step
            {
                own.insert(a);
            }
            let operands = self.operands(node).into_iter();
            parts.extend(operands.filter(|operand| met.insert(*operand)));
        }
        let product = own.iter().fold(Term::of(denominator), |product, a| {
            self.multiply(&product, &Term::of(*a))
        });
        (!own.is_empty()).then_some(product)
    }

    /// Whether the form of each of these terms says that it is affine in the state.
    pub fn is_affine(&self, terms: &[Term]) -> bool {
        let rests = |node: &Node| self.tier(*node) != Tier::Step;
        let mut known: Vec<bool> = Vec::with_capacity(self.len());
        for node in self.nodes() {
            let is = |a: &Node| known[a.index()];
            let affine = match self.operation(node) {
                Operation::Input(_) => true,
                Operation::Sum(terms) => terms.iter().all(|(_, a)| is(a)),
                Operation::Scale(_, a) => is(a),
                Operation::Product(a, b) => (rests(a) && is(b)) || (is(a) && rests(b)),
                _ => false,
            };
            known.push(affine || rests(&node));
        }
        terms.iter().all(|term| known[term.node.index()])
    }

    fn nodes(&self) -> impl Iterator<Item = Node> + use<> {
        (0..self.len()).map(|at| Node(u32::try_from(at).expect("fewer than 2^32 nodes")))
    }

    /// Whether the form of each node says that it is never negative where it has a value.
    fn never_negative(&self) -> Vec<bool> {
        let mut known: Vec<bool> = Vec::with_capacity(self.len());
        for node in self.nodes() {
            let is = |a: &Node| known[a.index()];
            known.push(match self.operation(node) {
                Operation::One | Operation::Pi | Operation::Power(..) => true,
                Operation::Function(function, _) => {
                    matches!(
                        function,
                        Function::Exp
                            | Function::Cosh
                            | Function::Sqrt
                            | Function::Abs
                            | Function::Erfc
                    )
                }
                Operation::Sum(terms) => terms.iter().all(|(c, a)| !c.is_negative() && is(a)),
                Operation::Scale(c, a) => !c.is_negative() && is(a),
                Operation::Product(a, b) => a == b || (is(a) && is(b)),
                Operation::Reciprocal(a) | Operation::Kept(_, _, a) => is(a),
                Operation::Parameter(_)
                | Operation::StepSize(_)
                | Operation::Input(_)
                | Operation::Analytic(..)
                | Operation::Binary(..)
                | Operation::Lookup(..) => false,
            });
        }
        known
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::{Formula, Scope};

    fn names() -> ([String; 3], [String; 1]) {
        (["x", "y", "z"].map(str::to_owned), ["a".to_owned()])
    }

    fn code(formula: &str) -> (Graph, Term) {
        let (names, parameters) = names();
        let scope = Scope::new()
            .with_variables(&names)
            .with_parameters(&parameters);
        let formula = Formula::parse(formula).unwrap();
        let expression = formula.resolve(&scope, None).unwrap().unwrap();
        let mut graph = Graph::new();
        let inputs: Vec<Term> = (0..3).map(|at| graph.input(at)).collect();
        let term = expression
            .evaluate_in(&mut graph, &mut |_, at| Ok(inputs[at].clone()))
            .unwrap();
        (graph, term)
    }

    fn of(formula: &str) -> Vec<String> {
        let (names, parameters) = names();
        let (mut graph, term) = code(formula);
        let denominators = graph.denominators(&[term]).unwrap();
        let written = |term: &Term| {
            graph
                .formula(term, 100)
                .unwrap()
                .written(&names, &parameters)
        };
        denominators.iter().map(written).collect()
    }

    #[test]
    fn factors_that_change_their_sign_are_named() {
        assert_eq!(of("1/(x - a)"), ["x - a"]);
        assert_eq!(of("y/(x*(y - 2)^3)"), ["x", "2 - y"]);
        assert_eq!(of("1/sqrt((x - y)^2)"), ["x - y"]);
        assert_eq!(of("tan(3*x)"), ["cos(3*x)"]);
        assert_eq!(
            of("x^(-12) + 1/(1 + 1/z)"),
            ["x", "z", "1 + 1/z", "z*(1 + 1/z)"]
        );
        assert_eq!(of("ln((x - y)^2) + (z^2)^(-1.25)"), ["z", "x - y"]);
    }

    #[test]
    fn what_is_of_one_sign_is_left_out() {
        for formula in [
            "1/sqrt(x^2 + y^2)",
            "1/(1 + exp(x))",
            "x/(2 + cosh(y)*z^4)",
            "ln(x)/a",
            "1/sqrt(x) + (y - 1)^(-1.5)",
            "x^2 + y",
        ] {
            assert!(of(formula).is_empty(), "{formula}: {:?}", of(formula));
        }
    }

    #[test]
    fn affine_functions_change_their_sign_once_on_a_line() {
        let affine = |formula: &str| {
            let (graph, term) = code(formula);
            graph.is_affine(&[term])
        };
        assert!(affine("2*x - a^2*(y - 3) + sin(a)"));
        assert!(!affine("x*y - 1"));
        assert!(!affine("cos(x)"));
    }
}

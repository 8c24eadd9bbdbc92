//! The solution of β̂(L(y)) = x over the graph of dŜ, as a series in the time step.
//!
//! With t = εh let α(y, dŜ_t(y)) = y + Σ_k tᵏ α_k(y). Then X_t(y) = β(y, dŜ_t(y)) = y + Σ_k (−t)ᵏ α_k(y), since Ŝ is
//! odd in t and β(y, p) = α(y, −p). A step solves for the inverse Y_t of X_t. As X_{−t} = α ∘ dŜ_t, the solution of the
//! step that led to x is Y_{−t}(x). Hence the even part of Y_t is known from it: Y_t(x) = Y_{−t}(x) + 2 Σ_{k odd} tᵏ
//! Y_k(x).

use leafwise_expression::graph::lift;
use leafwise_expression::{
    AlgebraError, Arithmetic, Graph, Polynomial, Rational, Ring, StepSize, Term,
};

use crate::bisection::LagrangianBisection;
use crate::error::BuildError;
use crate::generating_function::{Generating, GeneratingFunction};
use crate::realization::{Accuracy, RealizationData, SourceRecursion};
use crate::solver::StartCode;

/// Products of terms that may be spent on one order of the series: milliseconds.
const PRODUCTS: u64 = 1 << 14;

/// The shortest series that extrapolation of earlier solutions does not surpass at small steps: Y_1, Y_3 and Y_5. On
/// the rigid body the start is then off by 2e-9 at t = 0.1, where extrapolation is by 2e-6.
const FEWEST: usize = 3;

/// The longest: with Y_7 a step of the rigid body at t = 0.1 takes one evaluation. A further term would save an eighth
/// of one at t = 0.4.
const MOST: usize = 4;

/// Start of a method's solves over code, as [`SolutionSeries::code`]: the longest sum of at most so many `operations`.
/// It is `None` where the shortest takes more or Ŝ is not expanded. The same holds where the realization offers no
/// series as far.
///
/// # Errors
/// [`BuildError::Algebra`] where an adjoined function has no code.
pub(crate) fn start_of_solves(
    realization: &dyn RealizationData,
    bisection: &LagrangianBisection,
    parameters: usize,
    operations: u64,
) -> Result<Option<StartCode>, BuildError> {
    let (Some(Generating::Polynomials(generating)), Some(series)) = (
        bisection.generating_function(),
        realization.abilities().series,
    ) else {
        return Ok(None);
    };
    let known = match realization.accuracy() {
        Accuracy::Exact => usize::MAX,
        Accuracy::Order(n) => n.div_ceil(2),
    };
    if known < FEWEST {
        return Ok(None);
    }
    let mut solution = SolutionSeries::new(generating);
    let coordinates: Vec<usize> = (0..realization.dimension()).collect();
    let Ok(mut source) = (series.in_ring)(&mut solution.ring, &coordinates) else {
        return Ok(None);
    };
    let mut start = None;
    for terms in 1..=MOST.min(known) {
        if !solution.extend(generating, &mut source) {
            break;
        }
        // Every further term makes the sum longer.
        let code = solution.code()?;
        let kernel = code.kernel(parameters);
        if kernel.step_operations().work() > operations {
            break;
        }
        start = (terms >= FEWEST).then_some(code);
    }
    Ok(start)
}

/// 2 Y_1, 2 Y_3, …, d components each, at ε = 1, as far as they are known.
///
/// X_t is followed by its velocity W_t, ∂_t X_t = W_t ∘ X_t. Then ∂_t (f ∘ Y_t) = −W_t (f ∘ Y_t) for every function f,
/// W_t as a derivation (Deprit, Canonical transformations depending on a small parameter, 1969). With W = Σ t^{n−1} W_n
/// and ∂_t X = Σ t^{k−1} g_k, W_n = Σ_{k≤n} [t^{n−k}] g_k ∘ Y.
struct SolutionSeries {
    ring: Ring,
    odd: Vec<Vec<Polynomial>>,
    solution: Pulled,
    velocity: Vec<Vec<Polynomial>>,
    derivatives: Vec<Pulled>,
}

impl SolutionSeries {
    /// No term yet.
    fn new(generating: &GeneratingFunction) -> Self {
        let ring = generating.ring.clone();
        let coordinates = (0..ring.variables()).map(|i| ring.variable(i)).collect();
        Self {
            ring,
            odd: Vec::new(),
            solution: Pulled::new(coordinates),
            velocity: Vec::new(),
            derivatives: Vec::new(),
        }
    }

    /// Forms the next term, two orders or the first. Returns `false` where the term takes more than a few products of
    /// terms, or a derivative does not exist. Such a failure is no error, as a start is not needed.
    fn extend(
        &mut self,
        generating: &GeneratingFunction,
        source: &mut SourceRecursion<Ring>,
    ) -> bool {
        let last = 2 * self.odd.len() + 1;
        while self.velocity.len() < last {
            self.ring.allow(PRODUCTS);
            let n = self.velocity.len() + 1;
            let gradient = match generating.gradients.get(n / 2) {
                Some(gradient) if n % 2 == 1 => gradient.clone(),
                _ => vec![self.ring.zero(); self.ring.variables()],
            };
            let alpha = source(&mut self.ring, gradient);
            let formed = alpha.is_ok_and(|alpha| self.extend_by(&alpha).is_ok());
            if !formed || self.ring.refusal().is_some() {
                return false;
            }
        }
        let two = Rational::from_integer(2);
        let term = self.solution.last().iter().map(|y| y.scaled(&two));
        self.odd.push(term.collect());
        true
    }

    /// The next order, from its α_n.
    fn extend_by(&mut self, alpha: &[Polynomial]) -> Result<(), AlgebraError> {
        let ring = &mut self.ring;
        let n = self.velocity.len() as i64 + 1;
        // (−t)ⁿ α_n, differentiated.
        let factor = Rational::from_integer(if n % 2 == 1 { -n } else { n });
        let derivative = alpha.iter().map(|a| ring.scale(&factor, a)).collect();
        for g in &mut self.derivatives {
            g.extend(ring, &self.velocity)?;
        }
        self.derivatives.push(Pulled::new(derivative));
        let components = (0..alpha.len()).map(|i| {
            let terms = self.derivatives.iter();
            let terms: Vec<_> = terms
                .map(|g| (Rational::one(), g.last()[i].clone()))
                .collect();
            ring.combine(&terms)
        });
        self.velocity.push(components.collect());
        self.solution.extend(ring, &self.velocity)
    }

    /// The sum of the terms, d outputs of the state.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where an adjoined function has no code.
    fn code(&self) -> Result<StartCode, BuildError> {
        let d = self.ring.variables();
        let mut graph = Graph::new();
        let x: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let (epsilon, h) = (
            graph.step_size(StepSize::Epsilon),
            graph.step_size(StepSize::H),
        );
        let mut power = graph.multiply(&epsilon, &h);
        let square = graph.multiply(&power, &power);
        let mut outputs: Vec<Vec<(Term, Polynomial)>> = vec![Vec::new(); d];
        for term in &self.odd {
            for (output, component) in outputs.iter_mut().zip(term) {
                output.push((power.clone(), component.clone()));
            }
            power = graph.multiply(&power, &square);
        }
        let sums = lift(&mut graph, &self.ring, &outputs, &x)?;
        Ok(StartCode { graph, sums })
    }
}

/// Functions g of the state, carried along Y_t: the coefficients of g ∘ Y_t, and their gradients.
struct Pulled {
    /// One function's coefficients after the other's, by order.
    orders: Vec<Vec<Polynomial>>,
    gradients: Vec<Vec<Vec<Polynomial>>>,
}

impl Pulled {
    fn new(functions: Vec<Polynomial>) -> Self {
        Self {
            orders: vec![functions],
            gradients: Vec::new(),
        }
    }

    /// The coefficients of the highest known order.
    fn last(&self) -> &[Polynomial] {
        &self.orders[self.orders.len() - 1]
    }

    /// The next order r: r g_r = −Σ_{j≤r} W_j g_{r−j}.
    fn extend(
        &mut self,
        ring: &mut Ring,
        velocity: &[Vec<Polynomial>],
    ) -> Result<(), AlgebraError> {
        let gradients = self.orders[self.gradients.len()..].iter();
        let gradients = gradients.map(|order| order.iter().map(|g| ring.gradient(g)).collect());
        let gradients: Vec<Vec<Vec<Polynomial>>> = gradients.collect::<Result<_, _>>()?;
        self.gradients.extend(gradients);
        let r = self.orders.len();
        let factor = Rational::new(-1, r as i64);
        let functions = self.orders[0].len();
        let next = (0..functions).map(|at| {
            let slopes = (1..=r).map(|j| &self.gradients[r - j][at]);
            let pairs = velocity.iter().zip(slopes);
            let terms: Vec<_> = pairs
                .flat_map(|(w, slope)| w.iter().zip(slope))
                .map(|(w, slope)| (factor.clone(), w, slope))
                .collect();
            ring.sum_of_products(&terms)
        });
        self.orders.push(next.collect());
        Ok(())
    }
}

//! Functions of sums over sites and pairs.

use std::collections::BTreeSet;

use leafwise_expression::operators::Quantity;
use leafwise_expression::syntax::PairSums;
use leafwise_expression::{Arithmetic, Expression, Graph, Ring, Term};

use super::BodyShape;
use crate::error::BuildError;

/// f = F(S_1, …, S_m), S_k = Σ_i s_k(x_i) + Σ_{i<j} p_k(x_i, x_j).
#[derive(Clone, Debug, PartialEq)]
pub struct BodyFunction {
    /// F in the variables S_1, …, S_m from 0 on.
    pub outer: Expression,
    /// The sums.
    pub sums: Vec<BodySum>,
}

/// S = Σ_i s(x_i) + Σ_{i<j} p(x_i, x_j).
#[derive(Clone, Debug, PartialEq)]
pub struct BodySum {
    /// s in the coordinates of a site, and J_ii.
    pub site: Expression,
    /// p in the variables of a pair.
    pub pair: Expression,
}

impl BodyFunction {
    /// A formula of a chain that is taken apart into sums.
    pub fn of(formula: &PairSums, shape: &BodyShape) -> Self {
        let (families, sites, first) = (shape.families, shape.sites, formula.first);
        let entries = shape.variables() - 2 * families;
        let coordinates = (0..first).map(|at| at / sites + families * (at % sites).min(1));
        let variables = coordinates.chain((0..entries).map(|at| 2 * families + at));
        let variables: Vec<usize> = variables.collect();
        let sums = 0..formula.sums.len();
        let of_sums: Vec<usize> = (0..first).map(|_| 0).chain(sums).collect();
        let sums = formula.sums.iter().map(|sum| BodySum {
            site: sum.site.with_variables(&variables),
            pair: sum.pair.with_variables(&variables),
        });
        Self {
            outer: formula.outer.with_variables(&of_sums),
            sums: sums.collect(),
        }
    }

    /// The same of sites that have so many families more, behind those of `shape`.
    #[must_use]
    pub fn with_families(&self, shape: &BodyShape, further: usize) -> Self {
        let places = shape.places_beside(further);
        let sums = self.sums.iter().map(|sum| BodySum {
            site: sum.site.with_variables(&places),
            pair: sum.pair.with_variables(&places),
        });
        Self {
            outer: self.outer.clone(),
            sums: sums.collect(),
        }
    }
}

/// Σ_k ∂F/∂S_k s_k and the same of p: functions whose gradients add up to that of f.
///
/// Where F is linear in S_k, ∂F/∂S_k is code of the parameters. Elsewhere it is a *weight*: an input behind the
/// coordinates, that of the w-th such sum.
pub(super) struct Weighted<'a> {
    function: &'a BodyFunction,
    /// ∂F/∂S_k.
    slopes: Vec<Expression>,
    /// The place of each sum's weight, where it has one.
    weights: Vec<Option<usize>>,
}

impl<'a> Weighted<'a> {
    /// # Errors
    /// [`BuildError::Algebra`] where F has no derivative.
    pub(super) fn of(function: &'a BodyFunction) -> Result<Self, BuildError> {
        let sums = 0..function.sums.len();
        let slopes = sums.map(|k| function.outer.derivative(Quantity::Variable(k)));
        let slopes: Vec<Expression> = slopes.collect::<Result<_, _>>()?;
        let mut count = 0;
        let weights = slopes.iter().map(|slope| {
            let is_weight = !slope.variables().is_empty();
            count += usize::from(is_weight);
            is_weight.then(|| count - 1)
        });
        Ok(Self {
            weights: weights.collect(),
            function,
            slopes,
        })
    }

    /// The slopes of F that are weights, functions of the sums.
    pub(super) fn of_sums(&self) -> Vec<&Expression> {
        let pairs = self.slopes.iter().zip(&self.weights);
        pairs
            .filter_map(|(slope, weight)| weight.map(|_| slope))
            .collect()
    }

    /// Σ_k ∂F/∂S_k `part`(S_k) as a formula, of sums without weights.
    pub(super) fn sum(&self, part: impl Fn(&BodySum) -> &Expression) -> Expression {
        let terms = self.function.sums.iter().zip(&self.slopes);
        let terms =
            terms.map(|(sum, slope)| Expression::Product(vec![slope.clone(), part(sum).clone()]));
        Expression::Sum(terms.collect())
    }

    /// Σ_k ∂F/∂S_k `part`(S_k) as code, of coordinates and weights.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub(super) fn total(
        &self,
        graph: &mut Graph,
        part: impl Fn(&BodySum) -> &Expression,
        coordinates: &[Term],
        weights: &[Term],
    ) -> Result<Term, BuildError> {
        let mut total = graph.zero();
        for ((sum, slope), weight) in
            (self.function.sums.iter().zip(&self.slopes)).zip(&self.weights)
        {
            let value = part(sum).evaluate_in(graph, &mut |_, at| Ok(coordinates[at].clone()))?;
            let factor = match weight {
                Some(weight) => weights[*weight].clone(),
                None => slope.evaluate_in(graph, &mut |graph, _| Ok(graph.zero()))?,
            };
            let product = graph.multiply(&factor, &value);
            total = graph.add(&total, &product);
        }
        Ok(total)
    }
}

/// Whether p(x_i, x_j) = p(x_j, x_i), by exact algebra; `false` where there is no normal form.
pub(super) fn is_symmetric(pair: &Expression, shape: &BodyShape) -> bool {
    let mut ring = Ring::new(shape.variables());
    let mut value = |is_swapped: bool| {
        pair.evaluate_in(&mut ring, &mut |ring, at| {
            let own = match is_swapped {
                true => shape.swapped(at),
                false => at,
            };
            Ok(ring.variable(shape.first_equal(own)))
        })
    };
    match (value(false), value(true)) {
        (Ok(as_it_is), Ok(swapped)) => as_it_is == swapped,
        _ => false,
    }
}

/// The coordinates of a site that formulas of pairs depend on.
pub(super) fn families_of<'a>(
    pairs: impl Iterator<Item = &'a Expression>,
    shape: &BodyShape,
) -> BTreeSet<usize> {
    let variables = pairs.flat_map(Expression::variables);
    let coordinates = variables.filter(|variable| *variable < 2 * shape.families);
    coordinates
        .map(|variable| variable % shape.families)
        .collect()
}

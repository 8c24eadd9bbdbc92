//! Bounds on the rounding errors of a field, by the formulas of every pair.

use leafwise_expression::bounded::{Bounded, BoundedNumbers};
use leafwise_expression::{AlgebraError, Arithmetic, Expression, Graph, Term};

use super::BodyShape;
use super::function::{BodySum, Weighted};
use super::matrix::PairEntry;
use super::pair_code::slopes_of_a_pair;
use super::system::BodySystem;
use super::values::at_a_site;
use crate::error::BuildError;
use crate::system::FieldRounding;

/// Code of a field that is evaluated with bounds.
struct BoundedField {
    shape: BodyShape,
    sums: Vec<BodySum>,
    /// Weights as functions of the sums.
    weights: Vec<Expression>,
    /// Terms of a pair in the gradient, and the field at a site with the family of each result.
    pair: (Graph, Vec<Term>),
    site: (Graph, Vec<Term>),
    families: Vec<usize>,
}

impl BodySystem {
    /// Bounds on the rounding errors of the field. They take N² evaluations by interpreted code, and are asked for where a step meets round-off.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or derivative has no code.
    pub(super) fn bounds(&self) -> Result<FieldRounding, BuildError> {
        let (shape, moving) = (&self.shape, self.moving());
        let weighted = Weighted::of(&self.hamiltonian)?;
        let weights: Vec<Expression> = weighted.of_sums().into_iter().cloned().collect();
        let inputs = |graph: &mut Graph, count: usize| -> Vec<Term> {
            (0..count).map(|at| graph.input(at)).collect()
        };
        let mut pair = Graph::compilable();
        let of_pair = inputs(&mut pair, shape.variables() + weights.len());
        let slopes = slopes_of_a_pair(&weighted, shape, &mut pair, &of_pair, None)?;
        let mut site = Graph::compilable();
        let count = 2 * shape.families + weights.len() + shape.matrices.len();
        let of_site = inputs(&mut site, count);
        let write =
            |graph: &mut Graph, x: &[Term], gradient: &[Term]| self.velocities(graph, x, gradient);
        let results = at_a_site(&weighted, shape, &moving, &mut site, &of_site, write)?;
        let (families, terms) = results.into_iter().unzip();
        let field = BoundedField {
            shape: shape.clone(),
            sums: self.hamiltonian.sums.clone(),
            weights,
            pair: (pair, slopes),
            site: (site, terms),
            families,
        };
        Ok(FieldRounding::new(move |parameters, x, errors, out| {
            field.write(parameters, x, errors, out)
        }))
    }
}

impl BoundedField {
    fn write(
        &self,
        parameters: &[f64],
        x: &[f64],
        errors: &[f64],
        out: &mut [f64],
    ) -> Result<(), AlgebraError> {
        let (families, sites) = (self.shape.families, self.shape.sites);
        let numbers = &mut BoundedNumbers {
            parameters: parameters.to_vec(),
        };
        let of_site = |i: usize| -> Vec<Bounded> {
            let own = (0..families).map(|family| family * sites + i);
            let bounded = own.map(|at| Bounded {
                value: x[at],
                error: errors[at],
            });
            bounded.collect()
        };
        let points: Vec<Vec<Bounded>> = (0..sites).map(of_site).collect();
        let weights = self.weights_at(numbers, &points)?;
        let mut gradient = vec![Bounded::exact(0.0); families * sites];
        for (i, j) in pairs(sites) {
            let mut inputs = self.variables(&points, [i, j]);
            inputs.extend_from_slice(&weights);
            let slopes = numbers.values_at(&self.pair.0, &self.pair.1, &inputs)?;
            for (at, slope) in slopes.iter().enumerate() {
                let site = if at < families { i } else { j };
                let sum = &mut gradient[at % families * sites + site];
                *sum = numbers.add(sum, slope);
            }
        }
        out.fill(0.0);
        for (i, point) in points.iter().enumerate() {
            let mut inputs = point.clone();
            inputs.extend((0..families).map(|family| gradient[family * sites + i]));
            inputs.extend_from_slice(&weights);
            let diagonals = self.shape.matrices.iter();
            inputs.extend(diagonals.map(|matrix| Bounded::exact(matrix.entry(i, i))));
            let results = numbers.values_at(&self.site.0, &self.site.1, &inputs)?;
            for (family, result) in self.families.iter().zip(results) {
                out[family * sites + i] = result.error;
            }
        }
        Ok(())
    }

    /// The variables of a pair's formula.
    fn variables(&self, points: &[Vec<Bounded>], pair: [usize; 2]) -> Vec<Bounded> {
        let mut variables = [&points[pair[0]][..], &points[pair[1]][..]].concat();
        for matrix in &self.shape.matrices {
            let entries = (0..PairEntry::COUNT).map(PairEntry::numbered);
            variables.extend(entries.map(|entry| Bounded::exact(entry.of(matrix, pair))));
        }
        variables
    }

    fn weights_at(
        &self,
        numbers: &mut BoundedNumbers,
        points: &[Vec<Bounded>],
    ) -> Result<Vec<Bounded>, AlgebraError> {
        if self.weights.is_empty() {
            return Ok(Vec::new());
        }
        let mut totals = vec![Bounded::exact(0.0); self.sums.len()];
        let sites = (0..points.len()).map(|i| (i, i));
        for (i, j) in sites.chain(pairs(points.len())) {
            let variables = self.variables(points, [i, j]);
            for (total, sum) in totals.iter_mut().zip(&self.sums) {
                let formula = if i == j { &sum.site } else { &sum.pair };
                let share = formula.evaluate_in(numbers, &mut |_, at| Ok(variables[at]))?;
                *total = numbers.add(total, &share);
            }
        }
        let weights = self.weights.iter();
        let weights =
            weights.map(|weight| weight.evaluate_in(numbers, &mut |_, at| Ok(totals[at])));
        weights.collect()
    }
}

/// All i < j.
fn pairs(sites: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..sites).flat_map(move |i| (i + 1..sites).map(move |j| (i, j)))
}

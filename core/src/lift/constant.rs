//! Coordinates whose tensor is constant already.

use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Graph, Polynomial, Rational, Ring, Term};

use super::{End, Lift, LiftShape};
use crate::error::{BuildError, StepError};
use crate::system::SystemFormulas;

/// z = x − x⁰, of a tensor of numbers and parameters.
#[derive(Clone, Debug)]
pub struct ConstantLift {
    dimension: usize,
    ring: Ring,
    entries: Vec<((usize, usize), Polynomial)>,
}

impl ConstantLift {
    /// The coordinates themselves; `None` where an entry of the tensor depends on them.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where an entry has no normal form.
    pub fn of(system: &SystemFormulas) -> Result<Option<Self>, BuildError> {
        let dimension = system.dimension();
        let mut ring = Ring::new(dimension);
        let mut entries = Vec::with_capacity(system.tensor().len());
        for (at, entry) in system.tensor() {
            let entry = entry.evaluate_in(&mut ring, &mut |ring, at| Ok(ring.variable(at)))?;
            if entry.as_constant().is_none() {
                return Ok(None);
            }
            entries.push((*at, entry));
        }
        Ok(Some(Self {
            dimension,
            ring,
            entries,
        }))
    }
}

impl Lift for ConstantLift {
    fn shape(&self) -> LiftShape {
        LiftShape {
            coordinates: self.dimension,
            base: self.dimension,
            follows: false,
        }
    }

    fn place(
        &self,
        x: &[f64],
        _low: &[f64],
        _before: Option<End<'_>>,
        base: &mut [f64],
    ) -> Result<(), StepError> {
        base.copy_from_slice(x);
        Ok(())
    }

    fn sizes(&self, base: &[f64], sizes: &mut [f64]) {
        for (size, x) in sizes.iter_mut().zip(base) {
            *size = x.abs();
        }
    }

    fn image(&self, graph: &mut Graph, z: &[Term], base: &[Term]) -> Result<Vec<Term>, BuildError> {
        let pairs = base.iter().zip(z);
        Ok(pairs.map(|(x, z)| graph.add(x, z)).collect())
    }

    /// ż_i = −Σ_j Π_ij ∂_j H.
    fn field(
        &self,
        graph: &mut Graph,
        _z: &[Term],
        _base: &[Term],
        covector: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let one = graph.one();
        let outputs = self.entries.iter();
        let outputs: Vec<_> = outputs
            .map(|(_, entry)| vec![(one.clone(), entry.clone())])
            .collect();
        let entries = lift(graph, &self.ring, &outputs, &[])?;
        let mut rows = vec![Vec::new(); self.dimension];
        for (((i, j), _), entry) in self.entries.iter().zip(&entries) {
            rows[*i].push((-Rational::one(), graph.multiply(entry, &covector[*j])));
            rows[*j].push((Rational::one(), graph.multiply(entry, &covector[*i])));
        }
        Ok(rows.iter().map(|row| graph.combine(row)).collect())
    }

    fn increment(
        &self,
        _graph: &mut Graph,
        z: &[Term],
        _base: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        Ok(z.to_vec())
    }

    fn slopes_of_base(&self, base: &[f64], slopes: &mut [f64]) {
        slopes.fill(0.0);
        let diagonal = slopes.iter_mut().step_by(base.len() + 1);
        diagonal.for_each(|slope| *slope = 1.0);
    }
}

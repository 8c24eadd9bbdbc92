//! α along p(h), coefficient by coefficient.

use leafwise_core::BuildError;
use leafwise_core::realization::{SourceRecursion, SourceSeriesIn};
use leafwise_expression::series::{Tape, TapeIndex, TaylorState};
use leafwise_expression::{Arithmetic, DifferentialAlgebra, Expression, Rational};

use crate::chart::MagneticChart;

/// With δ_i(h) = ½ s_i b_i(h): α_x = x − δ and
/// α_p = p + ½ s_i a_i + Σ_j s_i s_j ∂_i A_j δ_j + A_i(x − δ) − A_i(x).
#[derive(Clone, Debug)]
pub struct MagneticSeries {
    dimension: usize,
    chart: MagneticChart,
}

impl MagneticSeries {
    /// The series of a chart on a system of this dimension.
    pub(crate) fn new(dimension: usize, chart: MagneticChart) -> Self {
        Self { dimension, chart }
    }
}

impl<A: DifferentialAlgebra> SourceSeriesIn<A> for MagneticSeries {
    fn start(&self, algebra: &mut A) -> Result<Box<dyn SourceRecursion<A>>, BuildError> {
        let d = self.dimension;
        let mut tape = Tape::new();
        let mut potentials = Vec::with_capacity(self.chart.pairs.len());
        for pair in &self.chart.pairs {
            potentials.push(pair.potential.evaluate_in(&mut tape, &mut |tape, at| {
                let x = tape.record(&Expression::Variable(at))?;
                let delta = tape.record(&Expression::Variable(d + at))?;
                Ok(tape.subtract(&x, &delta))
            })?);
        }
        let mut state = TaylorState::new(&tape);
        state.extend(&tape, algebra, |algebra, at| {
            if at < d {
                algebra.coordinate(at)
            } else {
                algebra.zero()
            }
        })?;
        let mut slopes = Vec::with_capacity(potentials.len());
        for a in &self.chart.pairs {
            let mut row = Vec::with_capacity(potentials.len());
            for (b, potential) in self.chart.pairs.iter().zip(&potentials) {
                let slope = algebra.partial(state.coefficient(*potential, 0), a.position)?;
                row.push(algebra.scale(&(&a.sign * &b.sign), &slope));
            }
            slopes.push(row);
        }
        Ok(Box::new(Recursion {
            dimension: d,
            chart: self.chart.clone(),
            tape,
            potentials,
            state,
            slopes,
            order: 0,
        }))
    }
}

struct Recursion<E> {
    dimension: usize,
    chart: MagneticChart,
    tape: Tape,
    /// A_i(x − δ) on the tape.
    potentials: Vec<TapeIndex>,
    state: TaylorState<E>,
    /// s_i s_j ∂_i A_j.
    slopes: Vec<Vec<E>>,
    order: usize,
}

impl<A: DifferentialAlgebra> SourceRecursion<A> for Recursion<A::Element> {
    fn push(&mut self, algebra: &mut A, p: Vec<A::Element>) -> Result<Vec<A::Element>, BuildError> {
        let d = self.dimension;
        let half = Rational::new(1, 2);
        let pairs = &self.chart.pairs;
        let mut deltas = vec![algebra.zero(); d];
        for pair in pairs {
            deltas[pair.position] = algebra.scale(&(&half * &pair.sign), &p[pair.momentum]);
        }
        self.state.extend(&self.tape, algebra, |algebra, at| {
            if at < d {
                algebra.zero()
            } else {
                deltas[at - d].clone()
            }
        })?;
        self.order += 1;
        let mut source = vec![algebra.zero(); d];
        for (i, pair) in pairs.iter().enumerate() {
            source[pair.position] = algebra.negate(&deltas[pair.position]);
            let moved = self.state.coefficient(self.potentials[i], self.order);
            let mut terms = vec![
                (&half * &pair.sign, p[pair.position].clone()),
                (Rational::one(), moved.clone()),
            ];
            for (slope, other) in self.slopes[i].iter().zip(pairs) {
                let product = algebra.multiply(slope, &deltas[other.position]);
                terms.push((Rational::one(), product));
            }
            source[pair.momentum] = algebra.combine(&terms);
        }
        Ok(source)
    }
}

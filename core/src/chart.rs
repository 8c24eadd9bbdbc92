//! Charts χ of a realization's space about its section, as numbers.

use leafwise_expression::{Graph, StepSize, Term};

use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::realization::{RealizationData, Space, SpaceChart};
use crate::runge_kutta::SmoothMap;

/// The chart of a realization, compiled where it is code.
#[derive(Clone, Debug)]
pub enum ChartMaps {
    /// z = (x, p) itself, each of so many coordinates: χ is the identity.
    Pairs(usize),
    /// Any other.
    Map(SmoothMap),
}

impl ChartMaps {
    /// The chart of `realization`, `None` where it has none; `parameters` is the number of the
    /// system's parameters.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the chart's code has no derivative.
    pub fn of(
        realization: &dyn RealizationData,
        parameters: usize,
    ) -> Result<Option<Self>, BuildError> {
        let d = realization.dimension();
        let chart = match realization.abilities().space {
            Space::Pairs => return Ok(Some(Self::Pairs(d))),
            Space::Points { chart, .. } => chart,
        };
        Ok(match chart {
            None => None,
            Some(SpaceChart::Numbers(map)) => Some(Self::Map(map)),
            Some(SpaceChart::Code(chart)) => {
                let mut graph = Graph::new();
                let xp: Vec<Term> = (0..2 * d).map(|i| graph.input(i)).collect();
                let epsilon = graph.step_size(StepSize::Epsilon);
                let z = chart(&mut graph, &epsilon, &xp[..d], &xp[d..])?;
                let map = SmoothMap::compile(graph, &z, parameters, 2 * d)?;
                Some(Self::Map(map))
            }
        })
    }

    /// Whether points of S are pairs (x, p) themselves.
    pub fn has_pairs(&self) -> bool {
        matches!(self, Self::Pairs(_))
    }

    /// Whether Dχ is offered.
    pub fn has_jacobian(&self) -> bool {
        match self {
            Self::Pairs(_) => true,
            Self::Map(map) => map.has_jacobian(),
        }
    }

    /// Whether trajectories may share an evaluator.
    pub fn is_pointwise(&self) -> bool {
        match self {
            Self::Pairs(_) => true,
            Self::Map(map) => map.is_pointwise(),
        }
    }

    /// An evaluator of (x, p) ↦ χ(x, p) for fixed parameters and ε.
    pub fn evaluator(&self, parameters: &[f64], epsilon: f64) -> Box<dyn Evaluator> {
        match self {
            Self::Pairs(dimension) => Box::new(Pairs(*dimension)),
            Self::Map(map) => Box::new(map.evaluator(parameters, epsilon, 1.0)),
        }
    }
}

/// The identity of pairs (x, p), each of so many coordinates.
struct Pairs(usize);

impl Evaluator for Pairs {
    fn values(&mut self, pairs: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        z.copy_from_slice(pairs);
        Ok(())
    }

    fn jacobians(&mut self, _: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        let n = 2 * self.0;
        tangents.fill(0.0);
        for unit in tangents.chunks_exact_mut(n * n) {
            unit.iter_mut().step_by(n + 1).for_each(|one| *one = 1.0);
        }
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        Some(0)
    }
}

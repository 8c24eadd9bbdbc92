//! Charts χ of a realization's space about its section, as numbers.

use std::sync::Arc;

use leafwise_expression::{Graph, StepSize, Term};

use crate::error::{BuildError, StepError};
use crate::realization::RealizationData;
use crate::runge_kutta::{SmoothMap, SmoothMapEvaluator};

/// One thread's evaluator of a symplectic chart χ(x, p) ↦ z with χ(x, 0) = σ(x), for fixed parameters
/// and ε.
pub trait ChartWorker: Send {
    /// χ(x, p), d_S numbers.
    ///
    /// # Errors
    /// [`StepError::LeftChart`] and the like, with `z` unspecified.
    fn point(&mut self, x: &[f64], p: &[f64], z: &mut [f64]) -> Result<(), StepError>;
    /// Dχ at the point of the last call, row-major d_S × 2d, the columns of x first.
    ///
    /// # Errors
    /// [`StepError::NoTangent`] where it is not offered.
    fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), StepError>;
    /// Whether [`tangent`](Self::tangent) is offered.
    fn has_tangent(&self) -> bool {
        true
    }
    /// Operations so far, as [`SolverStatistics::operations`] counts them; `None` for a part that
    /// does not count.
    ///
    /// [`SolverStatistics::operations`]: crate::SolverStatistics::operations
    fn operations(&self) -> Option<u64> {
        None
    }
}

/// The chart of a realization, compiled where it is code.
#[derive(Clone, Debug)]
pub struct ChartMaps {
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    /// z = (x, p) itself.
    Pairs,
    Code(SmoothMap),
    Numbers(Arc<dyn RealizationData>),
}

impl ChartMaps {
    /// The chart of `realization`, `None` where it has none; `parameters` is the number of the
    /// system's parameters.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the chart's code has no derivative.
    pub fn of(
        realization: &Arc<dyn RealizationData>,
        parameters: usize,
    ) -> Result<Option<Self>, BuildError> {
        if realization.points_are_pairs() {
            return Ok(Some(Self { kind: Kind::Pairs }));
        }
        let d = realization.dimension();
        if let Some(chart) = realization.chart() {
            let mut graph = Graph::new();
            let xp: Vec<Term> = (0..2 * d).map(|i| graph.input(i)).collect();
            let epsilon = graph.step_size(StepSize::Epsilon);
            let z = chart.point(&mut graph, &epsilon, &xp[..d], &xp[d..])?;
            let map = SmoothMap::compile(&mut graph, &z, parameters, 2 * d)?;
            let kind = Kind::Code(map);
            return Ok(Some(Self { kind }));
        }
        let is_offered = realization
            .chart_worker(&vec![1.0; parameters], 1.0)
            .is_some();
        Ok(is_offered.then(|| Self {
            kind: Kind::Numbers(Arc::clone(realization)),
        }))
    }

    /// Whether points of S are pairs (x, p) themselves: χ is the identity.
    pub fn has_pairs(&self) -> bool {
        matches!(self.kind, Kind::Pairs)
    }

    /// An evaluator for fixed parameters and ε.
    ///
    /// # Panics
    /// When a realization that offered a chart as numbers offers none for these parameters.
    pub fn worker(&self, parameters: &[f64], epsilon: f64) -> Box<dyn ChartWorker> {
        match &self.kind {
            Kind::Pairs => Box::new(Pairs),
            Kind::Code(map) => Box::new(CodeChart {
                point: vec![0.0; map.inputs()],
                map: map.evaluator(parameters, epsilon, 1.0),
            }),
            Kind::Numbers(realization) => realization
                .chart_worker(parameters, epsilon)
                .expect("a chart was offered when the method was composed"),
        }
    }
}

struct Pairs;

impl ChartWorker for Pairs {
    fn point(&mut self, x: &[f64], p: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        let (first, second) = z.split_at_mut(x.len());
        first.copy_from_slice(x);
        second.copy_from_slice(p);
        Ok(())
    }

    fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), StepError> {
        let columns = libm::sqrt(tangent.len() as f64) as usize;
        tangent.fill(0.0);
        tangent
            .iter_mut()
            .step_by(columns + 1)
            .for_each(|one| *one = 1.0);
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        Some(0)
    }
}

struct CodeChart {
    map: SmoothMapEvaluator,
    point: Vec<f64>,
}

impl ChartWorker for CodeChart {
    fn point(&mut self, x: &[f64], p: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        let (first, second) = self.point.split_at_mut(x.len());
        first.copy_from_slice(x);
        second.copy_from_slice(p);
        self.map.value(&self.point, z)
    }

    fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), StepError> {
        self.map.jacobian(&self.point, tangent)
    }

    fn operations(&self) -> Option<u64> {
        self.map.operations()
    }
}

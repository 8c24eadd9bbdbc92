//! Charts χ of a realization's space about its section, as numbers.

use std::sync::Arc;

use leafwise_expression::{Graph, StepSize, Term};

use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::realization::RealizationData;
use crate::runge_kutta::SmoothMap;

/// The chart of a realization, compiled where it is code.
#[derive(Clone, Debug)]
pub struct ChartMaps {
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    /// z = (x, p) itself, each of so many coordinates.
    Pairs(usize),
    Code(SmoothMap),
    Numbers {
        realization: Arc<dyn RealizationData>,
        has_jacobian: bool,
    },
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
            let kind = Kind::Pairs(realization.dimension());
            return Ok(Some(Self { kind }));
        }
        let d = realization.dimension();
        if let Some(chart) = realization.chart() {
            let mut graph = Graph::new();
            let xp: Vec<Term> = (0..2 * d).map(|i| graph.input(i)).collect();
            let epsilon = graph.step_size(StepSize::Epsilon);
            let z = chart(&mut graph, &epsilon, &xp[..d], &xp[d..])?;
            let map = SmoothMap::compile(graph, &z, parameters, 2 * d)?;
            let kind = Kind::Code(map);
            return Ok(Some(Self { kind }));
        }
        let chart = realization.chart_evaluator(&vec![1.0; parameters], 1.0);
        Ok(chart.map(|chart| Self {
            kind: Kind::Numbers {
                realization: Arc::clone(realization),
                has_jacobian: chart.has_jacobian(),
            },
        }))
    }

    /// Whether points of S are pairs (x, p) themselves: χ is the identity.
    pub fn has_pairs(&self) -> bool {
        matches!(self.kind, Kind::Pairs(_))
    }

    /// Whether Dχ is offered.
    pub fn has_jacobian(&self) -> bool {
        match &self.kind {
            Kind::Pairs(_) | Kind::Code(_) => true,
            Kind::Numbers { has_jacobian, .. } => *has_jacobian,
        }
    }

    /// An evaluator of (x, p) ↦ χ(x, p) for fixed parameters and ε.
    ///
    /// # Panics
    /// When a realization that offered a chart as numbers offers none for these parameters.
    pub fn evaluator(&self, parameters: &[f64], epsilon: f64) -> Box<dyn Evaluator> {
        match &self.kind {
            Kind::Pairs(dimension) => Box::new(Pairs(*dimension)),
            Kind::Code(map) => Box::new(map.evaluator(parameters, epsilon, 1.0)),
            Kind::Numbers { realization, .. } => realization
                .chart_evaluator(parameters, epsilon)
                .expect("a chart was offered when the method was composed"),
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

    fn has_jacobian(&self) -> bool {
        true
    }

    fn operations(&self) -> Option<u64> {
        Some(0)
    }
}

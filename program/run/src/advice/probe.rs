//! A run's method at its own states.

use std::sync::Arc;

use leafwise_core::diagnostics::{RealizationInstrument, StepEquation, StepSolution};
use leafwise_core::part::PartKind;
use leafwise_core::{
    Accuracy, BuildError, DynamicApproximation, Method, PartParameters, PoissonSystem,
    RealizationData, Registry,
};

use leafwise_scene::compose::{ComposedRun, PartChoice};

/// The method of a run, at states where its step has a solution.
pub(super) struct Probe<'a> {
    pub run: &'a ComposedRun,
    pub registry: &'a Registry,
    pub method: &'a Method,
    pub realization: &'a PartChoice,
    pub dynamics: &'a PartChoice,
    pub parameters: Vec<f64>,
    pub equation: StepEquation,
    pub places: Vec<Place>,
}

/// One state x with the step from it.
pub(super) struct Place {
    pub x: Vec<f64>,
    pub solution: StepSolution,
}

impl<'a> Probe<'a> {
    /// `None` where there is no method to judge, or no step from any of the states.
    pub fn new(run: &'a ComposedRun, registry: &'a Registry, states: &[Vec<f64>]) -> Option<Self> {
        let method = run.method.written()?;
        let part = |kind| run.plan.parts.iter().find(|part| part.kind == kind);
        let (realization, dynamics) = (part(PartKind::Realization)?, part(PartKind::Dynamics)?);
        let parameters = run.system.parameter_values();
        let (epsilon, h) = (run.plan.epsilon, run.plan.h);
        let mut equation = StepEquation::new(method, &parameters, epsilon, h).ok()?;
        let places: Vec<Place> = states
            .iter()
            .filter_map(|x| {
                let solution = equation.solve(x, x).ok()?;
                Some(Place {
                    x: x.clone(),
                    solution,
                })
            })
            .collect();
        (!places.is_empty()).then_some(Self {
            run,
            registry,
            method,
            realization,
            dynamics,
            parameters,
            equation,
            places,
        })
    }

    pub fn system(&self) -> &'a PoissonSystem {
        &self.run.system
    }

    /// n, for a truncated realization that takes an order.
    pub fn truncation_order(&self) -> Option<usize> {
        let takes_order = self
            .realization
            .parameters
            .iter()
            .any(|(name, _)| *name == "order");
        match self.method.realization().accuracy() {
            Accuracy::Order(n) if takes_order => Some(n),
            _ => None,
        }
    }

    /// The same realization of another order.
    pub fn truncated(&self, order: usize) -> Result<Arc<dyn RealizationData>, BuildError> {
        let given = with_order(self.realization, order);
        self.registry
            .realization(self.realization.name)?
            .build(self.system(), &given)
    }

    /// The same dynamic approximation, built again.
    pub fn dynamics_again(&self) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
        let part = self.registry.dynamics(self.dynamics.name)?;
        part.build(&given(self.dynamics))
    }

    /// The same dynamic approximation of another order.
    pub fn of_order(&self, order: usize) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
        let given = with_order(self.dynamics, order);
        self.registry.dynamics(self.dynamics.name)?.build(&given)
    }

    /// The largest error of the realization's bracket {α̂, α̂} = ε Π(α̂) over the run's points, relative
    /// to the brackets: what keeps it from being a Poisson map.
    pub fn defect(&self, realization: &Arc<dyn RealizationData>) -> Option<f64> {
        let mut instrument =
            RealizationInstrument::new(self.system(), realization, &self.parameters).ok()?;
        let epsilon = self.run.plan.epsilon;
        let mut largest = 0.0_f64;
        for place in &self.places {
            let (x, p) = place.solution.point.split_at(place.x.len());
            let error = instrument.measure(epsilon, x, p).ok()?;
            largest = largest.max(error.source / error.scale);
        }
        Some(largest)
    }
}

pub(super) fn given(choice: &PartChoice) -> PartParameters {
    choice
        .parameters
        .iter()
        .fold(PartParameters::new(), |given, (name, value)| {
            given.with(*name, value.clone())
        })
}

fn with_order(choice: &PartChoice, order: usize) -> PartParameters {
    given(choice).with("order", i64::try_from(order).unwrap_or(i64::MAX))
}

/// max |v_i|.
pub(super) fn size(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |largest, v| v.abs().max(largest))
}

/// max |a_i − b_i|.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .fold(0.0, |largest, (a, b)| (a - b).abs().max(largest))
}

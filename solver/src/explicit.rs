//! Explicit maps as code: one evaluation a step.

use std::sync::{Arc, OnceLock};

use leafwise_expression::{Graph, Kernel, OperationCount, Term, Workspace};

use super::{ByTangents, Differential, Explicit, Inverse, in_reverse};
use super::{Setting, SolverStatistics, StepCheck, StepRecord, Stepper, add};
use crate::error::{BuildError, StepError};

/// x ↦ x + f_{ε,h}(x), f given by code.
#[derive(Clone, Debug)]
pub struct ExplicitMap {
    shared: Arc<Shared>,
    /// Number of evaluations that a step counts as.
    evaluations: u64,
}

#[derive(Debug)]
struct Shared {
    graph: Graph,
    increment: Vec<Term>,
    parameters: usize,
    step: Kernel,
    /// Df, compiled when the first tangent is asked for.
    tangent: OnceLock<Option<Kernel>>,
    /// The gradient of w·f, compiled when the first differential is asked for.
    reverse: OnceLock<Option<Arc<Kernel>>>,
}

impl ExplicitMap {
    /// Compiles the map of an increment over the graph's first inputs, as many as it has components;
    /// `parameters` is the number of the system's parameters.
    pub fn compile(graph: Graph, increment: Vec<Term>, parameters: usize) -> Self {
        Self {
            shared: Arc::new(Shared {
                step: Kernel::compile(&graph, &increment, parameters, increment.len()),
                graph,
                increment,
                parameters,
                tangent: OnceLock::new(),
                reverse: OnceLock::new(),
            }),
            evaluations: 1,
        }
    }

    /// The same map, a product of `evaluations` factors, whose steps count as so many evaluations.
    pub fn counting(self, evaluations: u64) -> Self {
        Self {
            evaluations,
            ..self
        }
    }

    /// d.
    pub fn dimension(&self) -> usize {
        self.shared.increment.len()
    }

    /// Operations of one step.
    pub fn operations(&self) -> OperationCount {
        self.shared.step.step_operations()
    }

    /// The code of one step.
    pub fn kernel(&self) -> &Kernel {
        &self.shared.step
    }

    /// A stepper of `lanes` trajectories at once, as that of a step map.
    pub fn stepper(
        &self,
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Stepper> {
        let mut workspace = self.shared.step.workspace(lanes);
        let sizes = (vec![epsilon; lanes], vec![h; lanes]);
        self.shared
            .step
            .prepare(&mut workspace, parameters, &sizes.0, &sizes.1);
        Box::new(ExplicitStepper {
            shared: Arc::clone(&self.shared),
            workspace,
            parameters: parameters.to_vec(),
            step_sizes: sizes,
            last: vec![f64::NAN; self.dimension() * lanes],
            lanes,
            work: self.operations().work(),
            evaluations: self.evaluations,
            statistics: SolverStatistics::default(),
        })
    }
}

impl ExplicitMap {
    /// One trajectory's steps with their derivatives.
    pub fn differential(
        &self,
        parameters: &[f64],
        (epsilon, h): (f64, f64),
        inverse: Inverse,
    ) -> Box<dyn Differential> {
        let stepper = self.stepper(1, parameters, epsilon, h);
        let Shared {
            graph, increment, ..
        } = self.shared.as_ref();
        let compile = || {
            in_reverse(graph, increment, self.shared.parameters)
                .ok()
                .map(Arc::new)
        };
        match self.shared.reverse.get_or_init(compile) {
            None => Box::new(ByTangents::new(stepper, self.dimension())),
            Some(kernel) => Box::new(Explicit::new(
                stepper,
                Arc::clone(kernel),
                parameters,
                (epsilon, h),
                inverse,
            )),
        }
    }
}

impl Shared {
    fn tangent(&self) -> Option<&Kernel> {
        let compile = || -> Result<Kernel, BuildError> {
            let d = self.increment.len();
            let mut graph = self.graph.clone();
            let mut outputs = Vec::with_capacity(d * d);
            for component in &self.increment {
                for j in 0..d {
                    outputs.push(graph.derivative(component, j)?);
                }
            }
            Ok(Kernel::compile(&graph, &outputs, self.parameters, d))
        };
        self.tangent.get_or_init(|| compile().ok()).as_ref()
    }
}

/// Evaluates the step kernel once a step.
///
/// The low part of the compensated state, beyond a double, enters the sum, not the evaluation. The increment's own
/// rounding, an ulp of the size of the step, is as large as its influence.
struct ExplicitStepper {
    shared: Arc<Shared>,
    workspace: Workspace,
    parameters: Vec<f64>,
    /// ε and h of each lane.
    step_sizes: (Vec<f64>, Vec<f64>),
    last: Vec<f64>,
    lanes: usize,
    /// Operations of one step.
    work: u64,
    /// Number of evaluations that a step counts as.
    evaluations: u64,
    statistics: SolverStatistics,
}

impl ExplicitStepper {
    fn prepare(&mut self) {
        let (epsilon, h) = &self.step_sizes;
        let kernel = &self.shared.step;
        kernel.prepare(&mut self.workspace, &self.parameters, epsilon, h);
    }
}

impl Stepper for ExplicitStepper {
    fn increment(
        &mut self,
        x: &[f64],
        _low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        self.last.copy_from_slice(x);
        self.shared.step.evaluate(&mut self.workspace, x, increment);
        let values = x.iter().chain(&*increment);
        if values.fold(true, |all, value| all & value.is_finite()) {
            outcome.fill(Ok(()));
            self.statistics
                .count_all(self.lanes as u64, self.evaluations);
            return;
        }
        let d = self.shared.increment.len();
        for (lane, outcome) in outcome.iter_mut().enumerate() {
            let places = || (0..d).map(|i| i * self.lanes + lane);
            // An increment may be finite at a state that is not: where its coordinate rests.
            *outcome = if places().all(|at| x[at].is_finite() && increment[at].is_finite()) {
                Ok(())
            } else {
                places().for_each(|at| increment[at] = 0.0);
                Err(StepError::OF_INCREMENT)
            };
            self.statistics.count(self.evaluations, outcome.is_ok());
        }
    }

    /// The kernel's memory holds the state and the increment: nothing is copied but what the step itself moves.
    fn advance(
        &mut self,
        steps: u64,
        state: &mut [f64],
        low: &mut [f64],
        increment: &mut [f64],
        mut check: Option<&mut dyn StepCheck>,
        mut record: Option<&mut StepRecord<'_>>,
    ) -> (u64, Result<(), StepError>) {
        let kernel = &self.shared.step;
        let before = self.statistics.evaluations;
        for made in 0..steps {
            let changes = kernel.evaluate_rows::<1>(&mut self.workspace, state.as_chunks().0);
            let changes = changes.as_flattened();
            self.last.copy_from_slice(state);
            if let Some(check) = &mut check
                && changes.iter().all(|change| change.is_finite())
            {
                let mut outcome = [Ok(())];
                check.check(state, changes, &mut outcome);
                let [outcome] = outcome;
                if outcome.is_err() {
                    self.statistics.count_all(made + 1, self.evaluations);
                    return (made, outcome);
                }
            }
            if add(state, low, changes).is_err() {
                self.statistics.count_all(made, self.evaluations);
                let mut outcome = [Ok(())];
                self.increment(state, low, increment, &mut outcome);
                let [outcome] = outcome;
                return (made, outcome.and_then(|()| add(state, low, increment)));
            }
            if let Some(record) = &mut record {
                record.take(state, before + (made + 1) * self.evaluations);
            }
        }
        self.statistics.count_all(steps, self.evaluations);
        (steps, Ok(()))
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let kernel = self.shared.tangent()?;
        let d = self.shared.increment.len();
        let own = |values: &[f64]| -> Vec<f64> {
            values
                .iter()
                .skip(lane)
                .step_by(self.lanes)
                .copied()
                .collect()
        };
        let mut workspace = kernel.workspace(1);
        let (epsilon, h) = &self.step_sizes;
        let (epsilon, h) = (&epsilon[..1], &h[..1]);
        kernel.prepare(&mut workspace, &own(&self.parameters), epsilon, h);
        let mut tangent = vec![0.0; d * d];
        kernel.evaluate(&mut workspace, &own(&self.last), &mut tangent);
        (0..d).for_each(|i| tangent[i * d + i] += 1.0);
        Some(tangent)
    }

    fn restart(&mut self) {}

    fn set(&mut self, setting: Setting<'_>) -> bool {
        match setting {
            Setting::StepSize(h) => {
                self.step_sizes.1.fill(h);
                self.statistics = SolverStatistics::default();
            }
            Setting::Parameters(parameters) => self.parameters.copy_from_slice(parameters),
            Setting::Members(_) => return false,
        }
        self.prepare();
        true
    }

    fn statistics(&self) -> SolverStatistics {
        SolverStatistics {
            operations: Some(self.statistics.steps * self.work),
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        if memory.is_empty() { Ok(()) } else { Err(0) }
    }
}

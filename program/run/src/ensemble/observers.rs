//! Invariants and formulas of many states at once.

use leafwise_core::system::SystemInvariants;
use leafwise_core::{BuildError, Observe, PoissonSystem};
use leafwise_expression::{Expression, Graph, Kernel, Term, Workspace};
use leafwise_scene::compose::{ComposedRun, Section, Stop};

use crate::paced::Paced;

/// Functions of the state, compiled once for all blocks of members.
pub(super) enum Functions {
    Code(Kernel),
    /// Energy and Casimirs of a system of numbers.
    Numbers(PoissonSystem, usize),
}

impl Functions {
    /// Energy, then each Casimir; H + e for the energy where there is a pace.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where one has no code.
    pub fn invariants(run: &ComposedRun) -> Result<Self, BuildError> {
        let system = &run.system;
        let Some(formulas) = system.expressions() else {
            let count = system.casimir_names().len() + 1;
            return Ok(Self::Numbers(system.clone(), count));
        };
        let casimirs = formulas
            .casimirs()
            .iter()
            .map(|casimir| &casimir.expression);
        let energy = match Paced::watched(run) {
            Some([_, energy]) => energy,
            None => formulas.hamiltonian(),
        };
        let all: Vec<_> = std::iter::once(energy).chain(casimirs).collect();
        Self::formulas(system, &all)
    }

    /// Formulas in the system's variables and parameters.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where one has no code.
    pub fn formulas(system: &PoissonSystem, formulas: &[&Expression]) -> Result<Self, BuildError> {
        let d = system.dimension();
        let mut graph = Graph::new();
        let x: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let mut outputs = Vec::with_capacity(formulas.len());
        for formula in formulas {
            outputs.push(formula.evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone()))?);
        }
        let parameters = system.parameters().len();
        Ok(Self::Code(Kernel::compile(&graph, &outputs, parameters, d)))
    }

    /// How many.
    pub fn count(&self) -> usize {
        match self {
            Self::Code(kernel) => kernel.outputs(),
            Self::Numbers(_, count) => *count,
        }
    }

    /// An evaluator for lanes with their parameters, a structure of arrays.
    ///
    /// # Errors
    /// [`BuildError`] where a system of numbers has no evaluator.
    pub fn evaluator(
        &self,
        lanes: usize,
        parameters: &[f64],
    ) -> Result<ObservableEvaluator<'_>, BuildError> {
        let evaluator = match self {
            Self::Code(kernel) => {
                let mut workspace = kernel.workspace(lanes);
                let ones = vec![1.0; lanes];
                kernel.prepare(&mut workspace, parameters, &ones, &ones);
                Evaluator::Code(kernel, workspace)
            }
            Self::Numbers(system, count) => {
                let own = |lane: usize| -> Vec<f64> {
                    parameters
                        .iter()
                        .skip(lane)
                        .step_by(lanes)
                        .copied()
                        .collect()
                };
                let observers = (0..lanes).map(|lane| SystemInvariants::new(system, &own(lane)));
                Evaluator::Numbers {
                    observers: observers.collect::<Result<_, _>>()?,
                    state: vec![0.0; system.dimension()],
                    values: vec![0.0; *count],
                }
            }
        };
        Ok(ObservableEvaluator {
            evaluator,
            values: vec![0.0; self.count() * lanes],
            origin: Vec::new(),
        })
    }
}

/// The differences of both sides, of the condition and of the section, and what a pace watches, as code.
pub(super) struct Watched {
    pub pace: Option<Functions>,
    pub stop: Option<(Stop, Functions)>,
    pub section: Option<(Section, Functions)>,
}

impl Watched {
    /// Of a scene.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn of(run: &ComposedRun) -> Result<Self, BuildError> {
        let events = &run.plan.events;
        let code = |formula: &Expression| Functions::formulas(&run.system, &[formula]);
        let stop = events.stop.clone().map(|stop| {
            let code = code(&stop.difference)?;
            Ok::<_, BuildError>((stop, code))
        });
        let section = events.section.clone().map(|section| {
            let code = code(&section.difference)?;
            Ok::<_, BuildError>((section, code))
        });
        let pace = Paced::watched(run).map(|watched| Functions::formulas(&run.system, &watched));
        Ok(Self {
            pace: pace.transpose()?,
            stop: stop.transpose()?,
            section: section.transpose()?,
        })
    }
}

/// Values of functions in all lanes.
pub(super) struct ObservableEvaluator<'a> {
    evaluator: Evaluator<'a>,
    values: Vec<f64>,
    /// Of the first function, for each lane; zeros where none are given.
    origin: Vec<f64>,
}

enum Evaluator<'a> {
    Code(&'a Kernel, Workspace),
    Numbers {
        observers: Vec<SystemInvariants>,
        state: Vec<f64>,
        values: Vec<f64>,
    },
}

impl ObservableEvaluator<'_> {
    /// Takes a number for each lane from the first function: e_0 from H + e, as a run's balance does.
    pub fn measure_from(&mut self, origin: &[f64]) {
        self.origin.clear();
        self.origin.extend_from_slice(origin);
    }

    /// The values at states, both structures of arrays.
    pub fn at(&mut self, states: &[f64]) -> &[f64] {
        match &mut self.evaluator {
            Evaluator::Code(kernel, workspace) => {
                if !self.values.is_empty() {
                    kernel.evaluate(workspace, states, &mut self.values);
                }
            }
            Evaluator::Numbers {
                observers,
                state,
                values,
            } => {
                let lanes = observers.len();
                for (lane, observer) in observers.iter_mut().enumerate() {
                    let column = states.iter().skip(lane).step_by(lanes);
                    state.iter_mut().zip(column).for_each(|(own, x)| *own = *x);
                    observer.evaluate(state, values);
                    let places = self.values.iter_mut().skip(lane).step_by(lanes);
                    places
                        .zip(&*values)
                        .for_each(|(place, value)| *place = *value);
                }
            }
        }
        let first = self.values.iter_mut().zip(&self.origin);
        first.for_each(|(value, origin)| *value -= origin);
        &self.values
    }
}

impl Observe for ObservableEvaluator<'_> {
    fn observables(&self) -> usize {
        self.values.len()
    }

    fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        values.copy_from_slice(self.at(state));
    }
}

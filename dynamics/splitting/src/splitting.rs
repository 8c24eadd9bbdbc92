//! Strang's product as a step map.

use std::sync::{Arc, OnceLock};

use leafwise_core::solver::{MapProperties, SolverStatistics, StepMap, Stepper, Structure};
use leafwise_core::{BuildError, PoissonSystem, StepError, SystemFormulas};
use leafwise_expression::{
    Arithmetic, Graph, Kernel, OperationCount, Ring, StepSize, Term, Workspace,
};

use crate::code::strang_increment;
use crate::display::Names;
use crate::piece::Piece;
use crate::pieces::find_pieces;
use crate::register::INFO;

/// φ¹_{t/2} ∘ … ∘ φʳ_t ∘ … ∘ φ¹_{t/2}, t = εh, over exact flows of the pieces of H: explicit, of order
/// 2, self-adjoint, a Poisson map that keeps every Casimir (G. Strang, SIAM Journal on Numerical
/// Analysis 5, 506–517 (1968)).
#[derive(Clone, Debug)]
pub struct Splitting {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    system: SystemFormulas,
    ring: Ring,
    pieces: Vec<Piece>,
    step: Kernel,
    /// D(Φ − id), compiled when the first tangent is asked for.
    tangent: OnceLock<Option<Kernel>>,
}

impl Splitting {
    /// Splits the system's Hamiltonian and compiles the step.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] with the term of H that has no exact flow,
    /// [`BuildError::Algebra`] where a formula is outside the algebra.
    pub fn new(system: &PoissonSystem) -> Result<Self, BuildError> {
        let system = system.formulas(INFO.name)?;
        let mut ring = Ring::new(system.dimension());
        let mut pieces = find_pieces(system, &mut ring)?;
        costliest_last(system, &ring, &mut pieces)?;
        let mut graph = Graph::new();
        let increment = increment_code(&mut graph, system, &ring, &pieces)?;
        let parameters = system.parameters().len();
        let step = Kernel::compile(&graph, &increment, parameters, system.dimension());
        Ok(Self {
            shared: Arc::new(Shared {
                system: system.clone(),
                ring,
                pieces,
                step,
                tangent: OnceLock::new(),
            }),
        })
    }

    /// The pieces, in the order of the first half of a step.
    pub fn pieces(&self) -> &[Piece] {
        &self.shared.pieces
    }

    /// The pieces' Hamiltonians as formulas.
    pub fn formulas(&self) -> Vec<String> {
        let Shared {
            system,
            ring,
            pieces,
            ..
        } = self.shared.as_ref();
        let names = Names { system, ring };
        let formulas = pieces
            .iter()
            .map(|piece| names.polynomial(piece.hamiltonian()));
        formulas.collect()
    }

    /// Operations of one step.
    pub fn operations(&self) -> OperationCount {
        self.shared.step.step_operations()
    }
}

/// Moves the piece with the costliest flow to the end: the middle of a step, taken once.
fn costliest_last(
    system: &SystemFormulas,
    ring: &Ring,
    pieces: &mut Vec<Piece>,
) -> Result<(), BuildError> {
    let (parameters, d) = (system.parameters().len(), system.dimension());
    let mut costliest = (0, 0);
    for (at, piece) in pieces.iter().enumerate() {
        let mut graph = Graph::new();
        let flow = increment_code(&mut graph, system, ring, std::slice::from_ref(piece))?;
        let flow = Kernel::compile(&graph, &flow, parameters, d);
        let cost = flow.step_operations().work();
        if cost >= costliest.0 {
            costliest = (cost, at);
        }
    }
    if !pieces.is_empty() {
        let piece = pieces.remove(costliest.1);
        pieces.push(piece);
    }
    Ok(())
}

fn increment_code(
    graph: &mut Graph,
    system: &SystemFormulas,
    ring: &Ring,
    pieces: &[Piece],
) -> Result<Vec<Term>, BuildError> {
    let x: Vec<Term> = (0..system.dimension()).map(|i| graph.input(i)).collect();
    let (epsilon, h) = (
        graph.step_size(StepSize::Epsilon),
        graph.step_size(StepSize::H),
    );
    let time = graph.multiply(&epsilon, &h);
    Ok(strang_increment(graph, ring, pieces, &time, &x)?)
}

impl Shared {
    fn tangent(&self) -> Option<&Kernel> {
        let compile = || {
            let d = self.system.dimension();
            let mut graph = Graph::new();
            let increment =
                increment_code(&mut graph, &self.system, &self.ring, &self.pieces).ok()?;
            let mut outputs = Vec::with_capacity(d * d);
            for component in &increment {
                for j in 0..d {
                    outputs.push(graph.derivative(component, j).ok()?);
                }
            }
            Some(Kernel::compile(
                &graph,
                &outputs,
                self.system.parameters().len(),
                d,
            ))
        };
        self.tangent.get_or_init(compile).as_ref()
    }
}

impl StepMap for Splitting {
    fn dimension(&self) -> usize {
        self.shared.system.dimension()
    }

    fn properties(&self) -> MapProperties {
        MapProperties {
            order: 2,
            structure: Structure::Exact,
            self_adjoint: Some(true),
        }
    }

    fn describe(&self) -> String {
        let pieces = self.shared.pieces.len();
        format!("{} into {pieces} pieces", INFO.name)
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let mut workspace = self.shared.step.workspace(lanes);
        let sizes = (vec![epsilon; lanes], vec![h; lanes]);
        self.shared
            .step
            .prepare(&mut workspace, parameters, &sizes.0, &sizes.1);
        Box::new(SplittingStepper {
            shared: Arc::clone(&self.shared),
            workspace,
            parameters: parameters.to_vec(),
            step_sizes: (epsilon, h),
            last: vec![f64::NAN; self.dimension() * lanes],
            lanes,
            work: self.operations().work(),
            statistics: SolverStatistics::default(),
        })
    }
}

/// Evaluates the step kernel once a step.
///
/// What the compensated state holds beyond a double enters the sum, not the evaluation: the
/// increment's own rounding, an ulp of the size of the step, is as large as its influence.
struct SplittingStepper {
    shared: Arc<Shared>,
    workspace: Workspace,
    parameters: Vec<f64>,
    step_sizes: (f64, f64),
    last: Vec<f64>,
    lanes: usize,
    /// Operations of one step.
    work: u64,
    statistics: SolverStatistics,
}

impl Stepper for SplittingStepper {
    fn increment(
        &mut self,
        x: &[f64],
        _low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        self.last.copy_from_slice(x);
        self.shared.step.evaluate(&mut self.workspace, x, increment);
        let d = self.shared.system.dimension();
        for (lane, outcome) in outcome.iter_mut().enumerate() {
            let places = || (0..d).map(|i| i * self.lanes + lane);
            self.statistics.steps += 1;
            self.statistics.evaluations += 1;
            self.statistics.most_evaluations = 1;
            // An increment may be finite at a state that is not: where its coordinate rests.
            *outcome = if places().all(|at| x[at].is_finite() && increment[at].is_finite()) {
                Ok(())
            } else {
                self.statistics.failures += 1;
                places().for_each(|at| increment[at] = 0.0);
                Err(StepError::NonFinite {
                    what: "the increment",
                })
            };
        }
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let kernel = self.shared.tangent()?;
        let d = self.shared.system.dimension();
        let own = |values: &[f64]| -> Vec<f64> {
            values
                .iter()
                .skip(lane)
                .step_by(self.lanes)
                .copied()
                .collect()
        };
        let mut workspace = kernel.workspace(1);
        let (epsilon, h) = self.step_sizes;
        kernel.prepare(&mut workspace, &own(&self.parameters), &[epsilon], &[h]);
        let mut tangent = vec![0.0; d * d];
        kernel.evaluate(&mut workspace, &own(&self.last), &mut tangent);
        (0..d).for_each(|i| tangent[i * d + i] += 1.0);
        Some(tangent)
    }

    fn restart(&mut self) {}

    fn statistics(&self) -> SolverStatistics {
        SolverStatistics {
            operations: Some(self.statistics.evaluations * self.work),
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

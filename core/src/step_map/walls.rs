//! Tables of a system, which no step leaves.
//!
//! A step that ends where an argument of a table lies outside has no next one: it is refused, unless the formulas have values there,
//! as behind a condition. A step that fails on the way is told apart from others by where it was going.

use std::sync::Arc;

use leafwise_expression::table::{Outside, TableFunction};
use leafwise_expression::{Graph, Kernel, Term, Workspace};

use leafwise_solver::StepCheck;

use super::MakeCheck;
use crate::error::{BuildError, StepError};
use crate::system::PoissonSystem;

/// A step that fails is looked at so much farther than the one before it went.
const AHEAD: [f64; 4] = [0.0, 0.5, 1.0, 2.0];

/// The tables of a system with their arguments.
#[derive(Debug)]
pub struct Walls {
    tables: Vec<TableFunction>,
    /// The arguments of all tables.
    arguments: Kernel,
    /// Hamiltonian, tensor and forces.
    functions: Kernel,
    /// The coordinates in the arguments.
    reads: Vec<usize>,
    dimension: usize,
}

impl Walls {
    /// Those of a system of formulas; `None` where they call no table.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn of(system: &PoissonSystem) -> Result<Option<Self>, BuildError> {
        let Some(formulas) = system.expressions() else {
            return Ok(None);
        };
        let mut graph = Graph::compilable();
        let functions = std::iter::once(formulas.hamiltonian()).chain(formulas.tensor().values());
        let mut terms = Vec::with_capacity(1 + formulas.tensor().len());
        for function in functions.chain(formulas.forces().formulas()) {
            let code = function.evaluate_in(&mut graph, &mut |graph, at| Ok(graph.input(at)))?;
            terms.push(code);
        }
        graph.unless_refused(())?;
        let lookups = graph.lookups(&terms);
        if lookups.is_empty() {
            return Ok(None);
        }
        let (d, parameters) = (system.dimension(), system.parameters().len());
        let arguments: Vec<Term> = lookups
            .iter()
            .flat_map(|(_, point)| point.clone())
            .collect();
        Ok(Some(Self {
            tables: lookups.into_iter().map(|(table, _)| table).collect(),
            arguments: Kernel::compile(&graph, &arguments, parameters, d),
            functions: Kernel::compile(&graph, &terms, parameters, d),
            reads: graph.inputs_read(&arguments),
            dimension: d,
        }))
    }
}

impl MakeCheck for Walls {
    fn make(self: Arc<Self>, lanes: usize, parameters: &[f64]) -> Box<dyn StepCheck> {
        let mut look = AtWalls {
            arguments: self.arguments.workspace(lanes),
            functions: self.functions.workspace(1),
            values: vec![0.0; self.arguments.outputs() * lanes],
            parameters: parameters.to_vec(),
            place: vec![0.0; self.dimension * lanes],
            last: vec![0.0; self.dimension * lanes],
            lanes,
            walls: self,
        };
        look.set_parameters(parameters);
        Box::new(look)
    }
}

/// The tables at the ends of steps.
struct AtWalls {
    walls: Arc<Walls>,
    arguments: Workspace,
    functions: Workspace,
    values: Vec<f64>,
    parameters: Vec<f64>,
    place: Vec<f64>,
    /// The increments of the step before.
    last: Vec<f64>,
    lanes: usize,
}

impl AtWalls {
    /// The arguments at x + Δ.
    fn evaluate(&mut self, x: &[f64], increment: &[f64]) {
        for ((place, x), change) in self.place.iter_mut().zip(x).zip(increment) {
            *place = x + change;
        }
        let arguments = &self.walls.arguments;
        arguments.evaluate(&mut self.arguments, &self.place, &mut self.values);
    }

    /// The first table whose point lies outside in one lane.
    fn outside(&self, lane: usize) -> Option<Outside> {
        let mut first = 0;
        self.walls.tables.iter().find_map(|table| {
            let point: Vec<f64> = (first..first + table.axes().len())
                .map(|at| self.values[at * self.lanes + lane])
                .collect();
            first += point.len();
            // A point that is none has another reason.
            let is_known = point.iter().all(|x| x.is_finite());
            table.outside(&point).filter(|_| is_known)
        })
    }

    /// Whether a formula has no value at a lane's place.
    fn is_needed(&mut self, lane: usize) -> bool {
        let of_lane = |all: &[f64]| -> Vec<f64> {
            let own = all.iter().skip(lane);
            own.step_by(self.lanes).copied().collect()
        };
        let (place, parameters) = (of_lane(&self.place), of_lane(&self.parameters));
        let functions = &self.walls.functions;
        functions.prepare(&mut self.functions, &parameters, &[1.0], &[1.0]);
        let mut values = vec![0.0; functions.outputs()];
        functions.evaluate(&mut self.functions, &place, &mut values);
        values.iter().any(|value| value.is_nan())
    }
}

impl StepCheck for AtWalls {
    fn reads(&self, coordinate: usize) -> bool {
        self.walls.reads.contains(&coordinate)
    }

    fn set_parameters(&mut self, parameters: &[f64]) {
        self.parameters.copy_from_slice(parameters);
        let ones = vec![1.0; self.lanes];
        let arguments = &self.walls.arguments;
        arguments.prepare(&mut self.arguments, parameters, &ones, &ones);
    }

    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]) {
        self.evaluate(x, increment);
        for (lane, outcome) in outcome.iter_mut().enumerate() {
            if outcome.is_ok()
                && let Some(outside) = self.outside(lane)
                && self.is_needed(lane)
            {
                *outcome = Err(StepError::OutsideTable(outside));
            }
        }
        // Series beyond a table look as if they had no radius.
        let is_lost = |outcome: &Result<(), StepError>| match outcome {
            Ok(()) => false,
            Err(error) => error.is_of_a_solve() || matches!(error, StepError::Singularity { .. }),
        };
        if outcome.iter().any(is_lost) {
            let last = self.last.clone();
            for part in AHEAD {
                let ahead: Vec<f64> = last.iter().map(|change| part * change).collect();
                self.evaluate(x, &ahead);
                for (lane, outcome) in outcome.iter_mut().enumerate() {
                    if is_lost(outcome)
                        && let Some(outside) = self.outside(lane)
                        && self.is_needed(lane)
                    {
                        *outcome = Err(StepError::OutsideTable(outside));
                    }
                }
            }
        }
        for (at, (last, change)) in self.last.iter_mut().zip(increment).enumerate() {
            if outcome[at % self.lanes].is_ok() {
                *last = *change;
            }
        }
    }
}

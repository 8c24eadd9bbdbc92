//! Poles of the equations of motion, which no step crosses.
//!
//! Where a denominator of H or Π changes its sign between x and x + Δ, `Crossing` tells whether the field
//! has a pole there. Denominators that are not affine in x may change their sign twice: they are looked
//! at within the step too, eight times.

use std::sync::Arc;

use leafwise_expression::{Graph, Kernel, Term, Workspace};

use leafwise_solver::{Checked, Crossing, Differential, MapProperties, StepCheck, Stepper, looks};

use super::walls::Walls;
use super::{Factored, MakeCheck, MapAbilities, StepMap};
use crate::error::{BuildError, StepError};
use crate::system::{MakePoles, PoissonSystem};

/// Longest text of a denominator in a message.
const MOST_PARTS: usize = 60;

/// The denominators of a system whose signs can change.
#[derive(Debug)]
pub struct Poles {
    graph: Graph,
    field: Vec<Term>,
    denominators: Vec<Term>,
    kernel: Kernel,
    /// The coordinates in them.
    reads: Vec<usize>,
    looks: &'static [f64],
    written: Vec<String>,
}

impl Poles {
    /// Those of a system of formulas; `None` where all denominators are of one sign, and for a system
    /// of numbers.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the field has no code.
    pub fn of(system: &PoissonSystem) -> Result<Option<Self>, BuildError> {
        let Some(formulas) = system.expressions() else {
            return Ok(None);
        };
        let (d, parameters) = (system.dimension(), system.parameters().len());
        let mut graph = Graph::compilable();
        let x: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let functions = std::iter::once(formulas.hamiltonian()).chain(formulas.tensor().values());
        let mut terms = Vec::with_capacity(1 + formulas.tensor().len());
        for function in functions.chain(formulas.forces().formulas()) {
            terms.push(function.evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone()))?);
        }
        let denominators = graph.denominators(&terms)?;
        if denominators.is_empty() {
            return Ok(None);
        }
        let field = formulas.vector_field(&mut graph, &x)?;
        graph.unless_refused(())?;
        let mut named = Vec::with_capacity(formulas.names().len());
        for (name, formula) in formulas.names() {
            let term = formula.evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone()))?;
            named.push((term.node, name));
        }
        graph.unless_refused(())?;
        let names = system.parameters().iter().map(|p| p.name.clone());
        let names: Vec<String> = names.collect();
        let written = |term: &Term| {
            let name = named.iter().find(|(node, _)| *node == term.node);
            match (name, graph.formula(term, MOST_PARTS)) {
                (Some((_, name)), _) => (*name).clone(),
                (None, Some(formula)) => formula.written(system.variables(), &names),
                (None, None) => "a long denominator".to_owned(),
            }
        };
        Ok(Some(Self {
            written: denominators.iter().map(written).collect(),
            kernel: Kernel::compile(&graph, &denominators, parameters, d),
            reads: graph.inputs_read(&denominators),
            looks: looks(&graph, &denominators),
            graph,
            field,
            denominators,
        }))
    }
}

impl MakeCheck for Poles {
    fn make(self: Arc<Self>, lanes: usize, parameters: &[f64]) -> Box<dyn StepCheck> {
        let mut workspace = self.kernel.workspace(lanes);
        let ones = vec![1.0; lanes];
        self.kernel
            .prepare(&mut workspace, parameters, &ones, &ones);
        let values = vec![0.0; self.written.len() * lanes];
        Box::new(Crossings {
            workspace,
            parameters: parameters.to_vec(),
            before: values.clone(),
            after: values,
            place: vec![0.0; self.field.len() * lanes],
            ones,
            poles: self,
        })
    }
}

/// The denominators at two parts of a step, one after the other.
struct Crossings {
    poles: Arc<Poles>,
    workspace: Workspace,
    parameters: Vec<f64>,
    before: Vec<f64>,
    after: Vec<f64>,
    place: Vec<f64>,
    /// A step size that no denominator depends on, for each lane.
    ones: Vec<f64>,
}

impl Crossings {
    fn look(&mut self, x: &[f64], increment: &[f64], part: f64) {
        std::mem::swap(&mut self.before, &mut self.after);
        for ((place, x), increment) in self.place.iter_mut().zip(x).zip(increment) {
            *place = x + part * increment;
        }
        let kernel = &self.poles.kernel;
        kernel.evaluate(&mut self.workspace, &self.place, &mut self.after);
    }
}

impl StepCheck for Crossings {
    fn reads(&self, coordinate: usize) -> bool {
        self.poles.reads.contains(&coordinate)
    }

    fn set_parameters(&mut self, parameters: &[f64]) {
        self.parameters.copy_from_slice(parameters);
        let ones = &self.ones;
        let kernel = &self.poles.kernel;
        kernel.prepare(&mut self.workspace, parameters, ones, ones);
    }

    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]) {
        let lanes = outcome.len();
        let looks = self.poles.looks;
        self.look(x, increment, looks[0]);
        for parts in looks.windows(2) {
            self.look(x, increment, parts[1]);
            for at in 0..self.before.len() {
                let (which, lane) = (at / lanes, at % lanes);
                let keeps = self.before[at].signum() == self.after[at].signum();
                if keeps || outcome[lane].is_err() {
                    continue;
                }
                let of_lane = |values: &[f64]| -> Vec<f64> {
                    values.iter().skip(lane).step_by(lanes).copied().collect()
                };
                let crossing = Crossing {
                    graph: &self.poles.graph,
                    field: &self.poles.field,
                    denominator: &self.poles.denominators[which],
                    parameters: of_lane(&self.parameters),
                    start: of_lane(x),
                    increment: of_lane(increment),
                };
                if crossing.is_pole((parts[0], parts[1])) {
                    outcome[lane] = Err(StepError::Pole {
                        denominator: self.poles.written[which].clone(),
                        before: self.before[at],
                        after: self.after[at],
                    });
                }
            }
        }
    }
}

/// The poles that a system of numbers tells.
struct PolesOfNumbers(Arc<MakePoles>);

impl MakeCheck for PolesOfNumbers {
    fn make(self: Arc<Self>, lanes: usize, parameters: &[f64]) -> Box<dyn StepCheck> {
        (self.0)(lanes, parameters)
    }
}

/// A step map whose steps do not cross the poles of a system, nor leave its tables.
pub struct WithoutPoles {
    map: Arc<dyn StepMap>,
    poles: Arc<dyn MakeCheck>,
}

impl WithoutPoles {
    /// `map` for `system`; the map itself where the system has no poles to cross and no tables to leave.
    ///
    /// # Errors
    /// Those of [`Poles::of`] and [`Walls::of`].
    pub fn of(
        system: &PoissonSystem,
        map: Arc<dyn StepMap>,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        let map = match Poles::of(system)? {
            None => map,
            Some(poles) => Self::checked(map, Arc::new(poles)),
        };
        let map = match system.opaque().and_then(|system| system.numbers.poles()) {
            None => map,
            Some(poles) => Self::checked(map, Arc::new(PolesOfNumbers(poles))),
        };
        Ok(match Walls::of(system)? {
            None => map,
            Some(walls) => Self::checked(map, Arc::new(walls)),
        })
    }

    pub(crate) fn checked(map: Arc<dyn StepMap>, poles: Arc<dyn MakeCheck>) -> Arc<dyn StepMap> {
        Arc::new(Self { map, poles })
    }
}

impl StepMap for WithoutPoles {
    fn dimension(&self) -> usize {
        self.map.dimension()
    }

    fn properties(&self) -> MapProperties {
        self.map.properties()
    }

    fn describe(&self) -> String {
        self.map.describe()
    }

    fn abilities(&self) -> MapAbilities<'_> {
        let checked = |map| Self::checked(map, Arc::clone(&self.poles));
        let own = self.map.abilities();
        MapAbilities {
            factored: own.factored.map(|own| Factored {
                factors: own.factors.map(checked),
                pieces: own.pieces,
                arranged: None,
                // Factors go one after the other, each checked: a pole that one crosses and another crosses back is
                // seen.
                product: Box::new(|_| None),
            }),
            ..own
        }
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let stepper = self.map.stepper(lanes, parameters, epsilon, h);
        Checked::boxed(stepper, Arc::clone(&self.poles).make(lanes, parameters))
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        self.map.differential(parameters, epsilon, h)
    }
}

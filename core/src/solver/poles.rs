//! Poles of the equations of motion, which no step crosses.
//!
//! Where a denominator of H or Π changes its sign between x and x + Δ, the straight way from one to the
//! other is cut at the zero. Let F(δ) be the largest component of the field at a distance δ|Δ| from
//! there, less its rounding error, in units of the largest on the longer side, at its end and its middle.
//! A pole of the field of order p ≥ 1 has F ~ δ^(−p); q/√(q²), sin(q)/q or (1 − cos q)/q², which the flow does
//! cross, keep F bounded, and |q|^(1/2) has F ~ δ^(−1/2). A step with F(δ) > δ^(−2/3) at δ = 2⁻¹⁰, 2⁻²⁰ or
//! 2⁻³⁰ has crossed a pole.

use std::sync::Arc;

use leafwise_expression::bounded::{Bounded, BoundedNumbers};
use leafwise_expression::{Graph, Kernel, Term, Workspace};

use super::checked::{Checked, MakeCheck, StepCheck};
use super::{MapProperties, StepMap, Stepper};
use crate::error::{BuildError, StepError};
use crate::system::PoissonSystem;

/// δ, and the F above which there is a pole.
pub(crate) const LOOKS: [(f64, f64); 3] = [
    (1.0 / (1 << 10) as f64, 101.6),
    (1.0 / (1 << 20) as f64, 10_321.0),
    (1.0 / (1 << 30) as f64, (1 << 20) as f64),
];

/// Halvings that bring the zero below 2⁻⁴⁰ of the way.
const HALVINGS: usize = 44;

/// Longest text of a denominator in a message.
const MOST_PARTS: usize = 60;

/// The denominators of a system whose signs can change.
#[derive(Debug)]
pub struct Poles {
    denominators: Kernel,
    graph: Graph,
    field: Vec<Term>,
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
        for function in functions {
            terms.push(function.evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone()))?);
        }
        let denominators = graph.denominators(&terms)?;
        if denominators.is_empty() {
            return Ok(None);
        }
        let field = formulas.vector_field(&mut graph, &x)?;
        graph.unless_refused(())?;
        let names = system.parameters().iter().map(|p| p.name.clone());
        let names: Vec<String> = names.collect();
        let written = |term: &Term| match graph.formula(term, MOST_PARTS) {
            Some(formula) => formula.written(system.variables(), &names),
            None => "a long denominator".to_owned(),
        };
        Ok(Some(Self {
            written: denominators.iter().map(written).collect(),
            denominators: Kernel::compile(&graph, &denominators, parameters, d),
            graph,
            field,
        }))
    }
}

impl MakeCheck for Poles {
    fn make(self: Arc<Self>, lanes: usize, parameters: &[f64]) -> Box<dyn StepCheck> {
        let mut workspace = self.denominators.workspace(lanes);
        let ones = vec![1.0; lanes];
        self.denominators
            .prepare(&mut workspace, parameters, &ones, &ones);
        let values = vec![0.0; self.written.len() * lanes];
        Box::new(Crossings {
            workspace,
            parameters: parameters.to_vec(),
            before: values.clone(),
            after: values,
            next: vec![0.0; self.field.len() * lanes],
            poles: self,
        })
    }
}

/// The denominators before and after a step.
struct Crossings {
    poles: Arc<Poles>,
    workspace: Workspace,
    parameters: Vec<f64>,
    before: Vec<f64>,
    after: Vec<f64>,
    next: Vec<f64>,
}

impl StepCheck for Crossings {
    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]) {
        let lanes = outcome.len();
        for ((next, x), increment) in self.next.iter_mut().zip(x).zip(increment) {
            *next = x + increment;
        }
        let kernel = &self.poles.denominators;
        kernel.evaluate(&mut self.workspace, x, &mut self.before);
        kernel.evaluate(&mut self.workspace, &self.next, &mut self.after);
        for at in 0..self.before.len() {
            let (which, lane) = (at / lanes, at % lanes);
            let keeps = self.before[at].signum() == self.after[at].signum();
            if keeps || outcome[lane].is_err() {
                continue;
            }
            let of_lane = |values: &[f64]| -> Vec<f64> {
                values.iter().skip(lane).step_by(lanes).copied().collect()
            };
            let way = Way {
                poles: &self.poles,
                parameters: of_lane(&self.parameters),
                start: of_lane(x),
                increment: of_lane(increment),
            };
            if way.crosses(which) {
                let denominator = self.poles.written[which].clone();
                outcome[lane] = Err(StepError::Pole { denominator });
            }
        }
    }
}

/// The straight way of one step.
struct Way<'a> {
    poles: &'a Poles,
    parameters: Vec<f64>,
    start: Vec<f64>,
    increment: Vec<f64>,
}

impl Way<'_> {
    /// Whether the field has a pole where this denominator changes its sign.
    fn crosses(&self, which: usize) -> bool {
        let kernel = &self.poles.denominators;
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &self.parameters, &[1.0], &[1.0]);
        let mut values = vec![0.0; kernel.outputs()];
        let mut numbers = BoundedNumbers {
            parameters: self.parameters.clone(),
        };
        is_pole(&LOOKS, |part| {
            let way = self.start.iter().zip(&self.increment);
            let x: Vec<f64> = way.map(|(x, change)| x + part * change).collect();
            kernel.evaluate(&mut workspace, &x, &mut values);
            let field = numbers.values(&self.poles.graph, &self.poles.field, &x);
            (values[which], field.map_or(0.0, |field| largest(&field)))
        })
    }
}

/// The largest component, less its rounding error, of those that are finite.
fn largest(field: &[Bounded]) -> f64 {
    let sizes = field.iter().map(|f| f.value.abs() - f.error);
    sizes.filter(|size| size.is_finite()).fold(0.0, f64::max)
}

/// Whether a field has a pole where a denominator changes its sign, from the denominator and the field's
/// size at parts of the way.
pub(crate) fn is_pole(looks: &[(f64, f64)], mut look: impl FnMut(f64) -> (f64, f64)) -> bool {
    let is_negative = look(0.0).0 < 0.0;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        match (look(middle).0 < 0.0) == is_negative {
            true => low = middle,
            false => high = middle,
        }
    }
    let mut size = |part: f64| {
        Some(look(part).1)
            .filter(|size| size.is_finite())
            .unwrap_or(0.0)
    };
    let zero = 0.5 * (low + high);
    let far = if zero < 0.5 { 1.0 } else { 0.0 };
    let measure = size(far).max(size(0.5 * (zero + far)));
    looks.iter().any(|(distance, most)| {
        let beside = [zero - distance, zero + distance];
        beside.iter().any(|part| size(*part) > most * measure)
    })
}

/// A step map whose steps do not cross the poles of a system.
pub struct WithoutPoles {
    map: Arc<dyn StepMap>,
    poles: Arc<dyn MakeCheck>,
}

impl WithoutPoles {
    /// `map` for `system`; the map itself where the system has no poles to cross.
    ///
    /// # Errors
    /// Those of [`Poles::of`].
    pub fn of(
        system: &PoissonSystem,
        map: Arc<dyn StepMap>,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        Ok(match Poles::of(system)? {
            None => map,
            Some(poles) => Self::checked(map, Arc::new(poles)),
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

    fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        self.map.kernels()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let stepper = self.map.stepper(lanes, parameters, epsilon, h);
        Checked::boxed(stepper, Arc::clone(&self.poles).make(lanes, parameters))
    }
}

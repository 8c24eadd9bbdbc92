//! What round-off decides: a step that leads elsewhere from the neighbouring double, and an energy whose
//! changes are below its own round-off.

use leafwise_core::Evaluator;

use super::walk::{difference, increment};
use super::{Advice, AdviceKind, number};
use leafwise_scene::compose::ComposedRun;

/// The part of a step's motion that one unit of round-off in the state may change: of sixteen digits that a
/// double has, three are left.
const DECIDED: f64 = 1e-3;

/// The part of an energy's scale Σ_i |x_i ∂H/∂x_i| that its round-off may be.
const UNRESOLVED: f64 = 0.01;

pub(super) fn advice(run: &ComposedRun, states: &[Vec<f64>]) -> Option<Advice> {
    of_the_step(run, states).or_else(|| of_the_energy(run))
}

/// At the first of the run's states where a step from there and one from its neighbour differ by more.
fn of_the_step(run: &ComposedRun, states: &[Vec<f64>]) -> Option<Advice> {
    let message = states.iter().find_map(|x| {
        let map = run.method.map();
        let neighbour: Vec<f64> = x.iter().map(|x| x + x * f64::EPSILON).collect();
        let (here, there) = (increment(run, map, x), increment(run, map, &neighbour));
        let part = difference(x, &here.ok()?, &there.ok()?);
        (part > DECIDED).then(|| {
            format!(
                "the state's round-off decides where a step leads: one unit of it changes a coordinate's motion \
                 by {} of it",
                number(part)
            )
        })
    })?;
    Some(Advice {
        kind: AdviceKind::RoundOff,
        message,
        change: "[system] in other units, or about another origin: sums and arguments of functions of at most 1e8"
            .to_owned(),
    })
}

/// H of −3.5e299 beside terms of 1: its drift is 0 in doubles, whatever the step.
fn of_the_energy(run: &ComposedRun) -> Option<Advice> {
    let (parameters, x) = (run.system.parameter_values(), &run.plan.initial);
    // Of a long lattice only the formulas of its cells are there.
    let system = run
        .system
        .expressions()
        .filter(|_| run.system.dimension() == x.len())?;
    let round_off = f64::EPSILON * system.hamiltonian().evaluate(x, &parameters).abs();
    let gradient = run.system.gradient_values().ok()?;
    let mut slopes = vec![0.0; x.len()];
    let mut gradient = gradient.evaluator(&parameters, 1.0, 1.0);
    gradient.values(x, &mut slopes).ok()?;
    let scale: f64 = x
        .iter()
        .zip(&slopes)
        .map(|(x, slope)| (x * slope).abs())
        .sum();
    (scale > 0.0 && round_off > UNRESOLVED * scale).then(|| Advice {
        kind: AdviceKind::RoundOff,
        message: format!(
            "the energy is known to {} only, its round-off, and the coordinates make {} of it: that its drift is \
             small says nothing",
            number(round_off),
            number(scale)
        ),
        change: "hamiltonian: without its large constant".to_owned(),
    })
}

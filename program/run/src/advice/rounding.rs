//! Limits of doubles: a step that leads elsewhere from the neighbouring one, an energy whose changes are below its own
//! round-off, slopes of an energy that leave their range.

use leafwise_core::Evaluator;
use leafwise_expression::Expression;

use super::motion::increment;
use super::sizes::Sizes;
use super::{Advice, AdviceKind, number};
use leafwise_scene::compose::ComposedRun;

/// The part of a step's motion that one unit of round-off in the state may change: of sixteen digits that a
/// double has, three are left.
const DECIDED: f64 = 1e-3;

/// The part of an energy's scale Σ_i max(|x_i ∂H/∂x_i|, |H(x) − H(x without x_i)|) that its round-off may be.
const UNRESOLVED: f64 = 0.01;

pub(super) fn advice(run: &ComposedRun, states: &[Vec<f64>]) -> Option<Advice> {
    of_the_step(run, states)
        .or_else(|| of_the_energy(run))
        .or_else(|| of_the_slopes(run))
}

/// At the first of the run's states where a step from there and one from its neighbour differ by more.
fn of_the_step(run: &ComposedRun, states: &[Vec<f64>]) -> Option<Advice> {
    let sizes = Sizes::of(run, states);
    let message = states.iter().find_map(|x| {
        let map = run.method.map();
        let neighbour: Vec<f64> = x.iter().map(|x| x + x * f64::EPSILON).collect();
        let (here, there) = (increment(run, map, x), increment(run, map, &neighbour));
        let part = sizes.difference(x, &here.ok()?, &there.ok()?);
        (part > DECIDED).then(|| {
            format!(
                "the state's round-off dominates a step: one unit of it changes a coordinate's motion by {} of it",
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

/// H as a formula, and ∂H/∂x_i at the initial state as steps take it; nothing of a long lattice, of which only the
/// formulas of its cells are there.
fn energy(run: &ComposedRun) -> Option<(&Expression, Vec<f64>)> {
    let (parameters, x) = (run.system.parameter_values(), &run.plan.initial);
    let is_whole = run.system.dimension() == x.len();
    let system = run.system.expressions().filter(|_| is_whole)?;
    let gradient = run.system.gradient_values().ok()?;
    let mut slopes = vec![0.0; x.len()];
    let mut gradient = gradient.evaluator(&parameters, 1.0, 1.0);
    gradient.values(x, &mut slopes).ok()?;
    Some((system.hamiltonian(), slopes))
}

/// H of −3.5e299 beside terms of 1: its drift is 0 in doubles, whatever the step.
fn of_the_energy(run: &ComposedRun) -> Option<Advice> {
    let (parameters, x) = (run.system.parameter_values(), &run.plan.initial);
    let (hamiltonian, slopes) = energy(run)?;
    let energy = hamiltonian.evaluate(x, &parameters);
    let round_off = f64::EPSILON * energy.abs();
    // Where the state is an equilibrium the slopes are 0: there it is the change from x_i to 0.
    let without = |at: usize| {
        let mut moved = x.clone();
        moved[at] = 0.0;
        let change = (hamiltonian.evaluate(&moved, &parameters) - energy).abs();
        if change.is_finite() { change } else { 0.0 }
    };
    let sizes = x.iter().zip(&slopes).enumerate();
    let scale: f64 = sizes
        .map(|(at, (x, slope))| (x * slope).abs().max(without(at)))
        .sum();
    (scale > 0.0 && round_off > UNRESOLVED * scale).then(|| Advice {
        kind: AdviceKind::RoundOff,
        message: format!(
            "the energy has a round-off of {}, and the coordinates contribute only {} to it: a small drift says \
             nothing",
            number(round_off),
            number(scale)
        ),
        change: "hamiltonian: without its large constant".to_owned(),
    })
}

/// Relative deviation up to which slopes of H, by differences over several distances, agree.
const AGREES: f64 = 1e-3;

/// The part of the larger one that a slope and differences may differ by.
const APART: f64 = 0.1;

/// The part of all slopes, times the coordinates, below which one does not matter.
const MATTERS: f64 = 1e-6;

/// Warning where a derivative of H leaves the range of doubles: differences of H over three distances agree, and the
/// derivative that steps are made with is another. An example is ∂H/∂x_i of `asinh(1e300*x)`: it is 1e300/√(1 +
/// 1e600x²), 0 in doubles and 1/x in truth.
fn of_the_slopes(run: &ComposedRun) -> Option<Advice> {
    let (parameters, x) = (run.system.parameter_values(), &run.plan.initial);
    let (hamiltonian, slopes) = energy(run)?;
    let all: f64 = (x.iter().zip(&slopes))
        .map(|(x, slope)| (x * slope).abs())
        .sum();
    let mut at = x.clone();
    (0..x.len()).find_map(|i| {
        let mut energy = |moved: f64| {
            at[i] = moved;
            let energy = hamiltonian.evaluate(&at, &parameters);
            at[i] = x[i];
            energy
        };
        let differences = [10, 14, 18, 22, 26, 30].map(|k| {
            let (from, to) = (x[i] - libm::ldexp(x[i], -k), x[i] + libm::ldexp(x[i], -k));
            (energy(to) - energy(from)) / (to - from)
        });
        let slope = of_agreeing(&differences)?;
        let size = slope.abs().max(slopes[i].abs());
        let is_apart = (slope - slopes[i]).abs() > APART * size;
        let matters = (x[i] * size).abs() > MATTERS * all;
        (is_apart && matters).then(|| Advice {
            kind: AdviceKind::RoundOff,
            message: format!(
                "a derivative of the energy leaves the range of doubles: by {} it is {}, by differences {}",
                run.system.variables()[i],
                number(slopes[i]),
                number(slope)
            ),
            change: "hamiltonian: without numbers beyond 1e150 within functions".to_owned(),
        })
    })
}

/// The middle one of the last three neighbours that agree. Differences that are 0 are below the round-off of H.
fn of_agreeing(differences: &[f64]) -> Option<f64> {
    let near = |a: f64, b: f64| b != 0.0 && (a - b).abs() <= AGREES * b.abs();
    let mut triples = differences.windows(3).rev();
    triples.find_map(|of| (near(of[0], of[1]) && near(of[2], of[1])).then_some(of[1]))
}

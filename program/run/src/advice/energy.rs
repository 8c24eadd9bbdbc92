//! An energy that is kept badly.
//!
//! Let E be the mean of Σ_i |∂H/∂x_i(x)| · (max x_i − min x_i)/2 over states along an orbit. H changes by as much when
//! the coordinates change by half of what they do on the orbit. E depends neither on units nor on a constant in H, and
//! one state at rest does not make it small. The time is not among the coordinates. Of a long lattice, whose
//! derivatives are those of its cells, E is the mean of Σ_f |H(x_0 with the family f of x) − H(x_0)|.
//!
//! The energy's scale is |H(x_0)|, but not above E, which a constant would reach, and not below E/10, should H(x_0) be
//! near 0. Where states are few, or families are compared, E may be too small, and the scale is the larger one of both.
//! An error of the energy above [`LARGEST`] of its scale is worth a warning. Forces change the energy by themselves,
//! and nothing is said of it.

use leafwise_core::Evaluator;

use super::step::{half_the_step, tighten};
use super::{Advice, AdviceKind, number};
use leafwise_scene::compose::ComposedRun;

/// The largest error of the energy, relative to its scale, that nothing is said of.
const LARGEST: f64 = 0.01;

/// Errors below this part of |H(x_0)| are not looked at.
const NEGLIGIBLE: f64 = 1e-6;

/// The part of E that the energy's scale is at least.
const LEAST_PART: f64 = 0.1;

/// From this number of states on they tell how far an orbit reaches.
const MANY_STATES: usize = 8;

/// Error of the energy along an orbit, with the initial energy and the parameters' values.
pub(crate) struct EnergyError<'a> {
    /// The parameters' values.
    pub parameters: &'a [f64],
    /// H(x_0).
    pub initial: f64,
    /// max |H(x_k) − H(x_0)|.
    pub largest: f64,
    /// Whose energy: nothing, or a member of an ensemble.
    pub whose: &'a str,
}

impl EnergyError<'_> {
    /// Whether states are worth a look.
    pub fn is_notable(&self) -> bool {
        self.largest > NEGLIGIBLE * self.initial.abs()
    }

    /// A warning where the error is a large part of the energy's scale along `states`.
    pub fn advice(&self, run: &ComposedRun, states: &[Vec<f64>]) -> Option<Advice> {
        // Events change it by what they are.
        if run.work_of_forces().is_some() || run.plan.events.act.is_some() {
            return None;
        }
        let size = self.initial.abs();
        let scale = match along(run, self.parameters, states) {
            Some(along) if states.len() >= MANY_STATES && run.method.lattice().is_none() => {
                size.clamp(LEAST_PART * along, along)
            }
            along => size.max(along.unwrap_or(0.0)),
        };
        if !(self.largest > LARGEST * scale && scale > 0.0) {
            return None;
        }
        if let Some(jump) = largest_jump(run, states).filter(|jump| *jump > LARGEST * scale) {
            return Some(Advice {
                kind: AdviceKind::EnergyError,
                message: format!(
                    "the energy{} is off by {}, {} % of its scale along the orbit, because H itself jumps on the way, by {}: the \
                     motion has the derivatives of H's pieces and ignores jumps, so that the energy does not measure its \
                     error",
                    self.whose,
                    number(self.largest),
                    number(100.0 * self.largest / scale),
                    number(jump)
                ),
                change: "a smooth Hamiltonian, such as one of tanh, if the motion should follow the jump; otherwise \
                         half the time-step, to see the error"
                    .to_owned(),
            });
        }
        let change = tighten(run).unwrap_or_else(|| half_the_step(run));
        Some(Advice {
            kind: AdviceKind::EnergyError,
            message: format!(
                "the energy{} is off by {}, {} % of its scale along the orbit, {}: the motion is not reliable",
                self.whose,
                number(self.largest),
                number(100.0 * self.largest / scale),
                number(scale)
            ),
            change,
        })
    }
}

/// So many halvings of the way between two states leave nothing of a smooth change of H.
const HALVINGS: u32 = 48;

/// The largest jump of H on the straight ways between the states, found by halving where H changes most; `None` of a smooth
/// H.
fn largest_jump(run: &ComposedRun, states: &[Vec<f64>]) -> Option<f64> {
    let may_jump = run.in_time().ok()?.expressions()?.hamiltonian().may_jump();
    if !may_jump {
        return None;
    }
    let mut observer = run.invariants().ok()?;
    let mut values = vec![0.0; observer.observables()];
    let mut energy = |x: &[f64]| {
        observer.evaluate(x, &mut values);
        values[0]
    };
    let jumps = states.windows(2).map(|ends| {
        let [mut low, mut high] = [ends[0].clone(), ends[1].clone()];
        let mut at = [energy(&low), energy(&high)];
        for _ in 0..HALVINGS {
            let pairs = low.iter().zip(&high);
            let middle: Vec<f64> = pairs.map(|(a, b)| 0.5 * (a + b)).collect();
            let value = energy(&middle);
            if (value - at[0]).abs() > (at[1] - value).abs() {
                (high, at[1]) = (middle, value);
            } else {
                (low, at[0]) = (middle, value);
            }
        }
        (at[1] - at[0]).abs()
    });
    let finite = jumps.filter(|jump| jump.is_finite());
    finite.max_by(f64::total_cmp)
}

/// E along an orbit, `None` where there are no gradients.
fn along(run: &ComposedRun, parameters: &[f64], states: &[Vec<f64>]) -> Option<f64> {
    let sums = match run.method.lattice() {
        Some(geometry) => of_families(run, &geometry.offsets(), states)?,
        None => of_coordinates(run, parameters, states)?,
    };
    let finite: Vec<f64> = sums.into_iter().filter(|sum| sum.is_finite()).collect();
    let mean = finite.iter().sum::<f64>() / finite.len() as f64;
    (mean > 0.0).then_some(mean)
}

/// Σ_i |∂H/∂x_i| (max x_i − min x_i)/2 at each state.
fn of_coordinates(run: &ComposedRun, parameters: &[f64], states: &[Vec<f64>]) -> Option<Vec<f64>> {
    let system = run.in_time().ok()?;
    let d = system.dimension();
    if states.iter().any(|x| x.len() != d) {
        return None;
    }
    let time = run.plan.layout.clock().map(|clock| clock.time);
    let half = |i: usize| {
        let values = states.iter().map(|x| x[i]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        if Some(i) == time {
            0.0
        } else {
            (high - low) / 2.0
        }
    };
    let halves: Vec<f64> = (0..d).map(half).collect();
    let gradient = system.gradient_values().ok()?;
    let mut gradient = gradient.evaluator(parameters, 1.0, 1.0);
    let mut slopes = vec![0.0; d];
    let sums = states.iter().filter_map(|x| {
        gradient.values(x, &mut slopes).ok()?;
        let products = slopes.iter().zip(&halves);
        Some(products.map(|(slope, half)| slope.abs() * half).sum())
    });
    Some(sums.collect())
}

/// Σ_f |H(x_0 with the family f of x) − H(x_0)| at each state x.
fn of_families(run: &ComposedRun, offsets: &[usize], states: &[Vec<f64>]) -> Option<Vec<f64>> {
    let initial = &run.plan.initial;
    let mut observer = run.invariants().ok()?;
    let mut values = vec![0.0; observer.observables()];
    let mut energy = |x: &[f64]| {
        observer.evaluate(x, &mut values);
        values[0]
    };
    let at_first = energy(initial);
    let mut moved = initial.clone();
    let ends = offsets.iter().skip(1).copied().chain([initial.len()]);
    let families: Vec<_> = offsets.iter().zip(ends).collect();
    let sum = |x: &Vec<f64>| {
        let changes = families.iter().map(|(start, end)| {
            let family = **start..*end;
            moved[family.clone()].copy_from_slice(&x[family.clone()]);
            let change = energy(&moved) - at_first;
            moved[family.clone()].copy_from_slice(&initial[family]);
            change.abs()
        });
        changes.sum()
    };
    Some(states.iter().map(sum).collect())
}

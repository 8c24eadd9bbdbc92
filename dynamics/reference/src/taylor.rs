//! The Taylor series of the motion, of order and step from a tolerance: the part `taylor`.
//!
//! ẋ = f(x) gives x(t) = Σ x_k tᵏ about a state, x_{k+1} = f_k/(k + 1), by one kernel. With tolerance δ the order is
//! p = ⌈1 − ln(δ)/2⌉ and a substep ρ e⁻² exp(−0.7/(p − 1)), ρ the radius of convergence that x_{p−1} and x_p show:
//! the terms left out are then below δ e⁻² of the state.
//!
//! Substeps take no notice of the steps of εh: a step ends on the polynomial of the substep that it falls into.

use std::sync::Arc;

use leafwise_core::part::{
    Compared, Family, ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters,
};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::solver::judge::larger;
use leafwise_core::solver::{StepReport, Trajectories};
use leafwise_core::{
    BuildError, Evaluator, MapProperties, PoissonSystem, StepError, StepMap, Structure, two_sum,
};
use leafwise_expression::AlgebraError;

use crate::adaptive::{MOST_SUBSTEPS, tolerance_of};
use crate::reference_map::ReferenceMap;

static INFO: PartInfo = PartInfo {
    name: "taylor",
    summary: "the motion's Taylor series, of order and substeps from the tolerance",
    declares: "no order in the step: the tolerance sets the error, by substeps of order 1 - ln(tolerance)/2, rounded \
               up; not a Poisson map; not self-adjoint",
    domain: "any system of formulas",
    literature: "Jorba, Zou, A software package for the numerical integration of ODEs by means of high-order Taylor \
                 methods, Experimental Mathematics 14 (2005); Biscani, Izzo, Revisiting high-order Taylor methods for \
                 astrodynamics and celestial mechanics, MNRAS 504 (2021)",
    parameters: &[TOLERANCE],
    family: Some(Family::Series),
    takes_forces: true,
    compared: Some(Compared::at(1)),
    reference: Some(&[]),
    ..PartInfo::of(PartKind::Stepper)
};

const TOLERANCE: ParameterInfo = ParameterInfo {
    name: "tolerance",
    summary: "the error of a substep relative to each component or its change, 1e-16 to 0.1",
    default: ParameterDefault::Real(1e-15),
};

/// A substep is at most so many times the last: coefficients that vanish by chance show no radius.
const GROW: f64 = 8.0;

/// Trajectories that ask for jets together.
const TOGETHER: usize = 16;

/// p.
fn order(tolerance: f64) -> usize {
    libm::ceil(1.0 - 0.5 * libm::log(tolerance)) as usize
}

/// The jet of order p as one map x ↦ (x_1, …, x_p).
fn jet_map(system: &PoissonSystem, order: usize) -> Result<SmoothMap, BuildError> {
    let formulas = system.formulas(INFO.name)?;
    formulas.jet_map(order).map_err(|error| match error {
        BuildError::Algebra(reason @ AlgebraError::CodeTooLong { .. }) => BuildError::NotMade {
            part: INFO.name,
            reason: format!(
                "the jet of order {order} grows too long ({reason}): take a larger tolerance, or dop853, which only \
                 evaluates the field"
            ),
        },
        other => other,
    })
}

/// One trajectory: the polynomial about `base`, along which it is followed to `reached`.
#[derive(Clone)]
struct Path {
    base: Vec<f64>,
    /// What the base holds beyond doubles.
    low: Vec<f64>,
    /// x_k[i] at (k − 1)d + i.
    jet: Vec<f64>,
    /// The length of the substep from the base; 0 before its jet is known.
    length: f64,
    /// That of the substep before, 0 before there is any.
    before: f64,
    /// The time since the base, as a sum of two doubles.
    reached: [f64; 2],
    /// The state that was handed out there; none before the first step.
    state: Vec<f64>,
    begun: bool,
}

impl Path {
    fn new(dimension: usize, order: usize) -> Self {
        Self {
            base: vec![0.0; dimension],
            low: vec![0.0; dimension],
            jet: vec![0.0; order * dimension],
            length: 0.0,
            before: 0.0,
            reached: [0.0; 2],
            state: vec![0.0; dimension],
            begun: false,
        }
    }

    /// Goes on from x, on the same polynomial where that is the state it was left at.
    fn begin(&mut self, x: &[f64], low: &[f64]) {
        if self.begun && self.state == x {
            return;
        }
        self.base.copy_from_slice(x);
        self.low.copy_from_slice(low);
        self.reached = [0.0; 2];
        self.length = 0.0;
        self.before = 0.0;
        self.begun = true;
    }

    /// Moves the base to the end of its substep; `change` is room for the difference.
    fn advance(&mut self, change: &mut [f64]) {
        let length = self.length;
        polynomial(&self.jet, length, change);
        for ((base, low), change) in self.base.iter_mut().zip(&mut self.low).zip(change) {
            (*base, *low) = two_sum(*base, *change + *low);
        }
        // The length has half of a double's digits: the difference is exact.
        self.reached[0] -= length;
        self.before = length.abs();
        self.length = 0.0;
    }

    /// The length of the substep from the base, in the direction of `direction`.
    ///
    /// # Errors
    /// [`StepError::NonFinite`] where a coefficient is not finite.
    fn choose(&mut self, direction: f64, safety: f64) -> Result<(), StepError> {
        let d = self.base.len();
        let order = self.jet.len() / d;
        let row = |k: usize| &self.jet[(k - 1) * d..][..d];
        let (first, second, earlier, last) = (row(1), row(2), row(order - 1), row(order));
        // Before the first substep, its length by the field alone.
        let before = match self.before > 0.0 {
            true => self.before,
            false => length(size(last) / size(first), order - 1),
        };
        // The largest x_k[i] over component i, or over its change where that is larger; what is 0 up to the second
        // order counts as round-off of the others, or of their change where all are 0.
        let whole = match size(&self.base) {
            0.0 => before * (size(first) + before * size(second)),
            base => base,
        };
        let floor = f64::EPSILON * whole + f64::MIN_POSITIVE;
        let (mut of_earlier, mut of_last) = (0.0_f64, 0.0_f64);
        for i in 0..d {
            let change = before * (first[i].abs() + before * second[i].abs());
            let scale = 1.0 / self.base[i].abs().max(change).max(floor);
            of_earlier = larger(of_earlier, earlier[i].abs() * scale);
            of_last = larger(of_last, last[i].abs() * scale);
        }
        if !(of_earlier + of_last).is_finite() {
            return Err(StepError::NonFinite {
                what: "the Taylor series of the motion",
            });
        }
        let most = match self.before > 0.0 {
            true => GROW * self.before,
            false if of_last + of_earlier == 0.0 => direction.abs(),
            false => f64::INFINITY,
        };
        let chosen = length(of_earlier, order - 1).min(length(of_last, order));
        self.length = short((safety * chosen).min(most)).copysign(direction);
        Ok(())
    }
}

/// max |v_i|.
fn size(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, v| v.abs().max(most))
}

/// ρ e⁻² for ρ = q^(−1/n), the radius of convergence of Σ q_k tᵏ by its term n, to a few thousandths: logarithm and
/// power by parabolas between powers of 2.
fn length(q: f64, n: usize) -> f64 {
    // NaN, of a field that is 0, and 0 itself are below all others.
    let bits = q.max(0.0).to_bits();
    let mantissa = f64::from_bits(bits & ((1 << 52) - 1) | 1.0_f64.to_bits());
    let fraction = (2.024_658 - 0.344_845 * mantissa) * mantissa - 1.674_873;
    let logarithm = (bits >> 52) as f64 - 1023.0 + fraction;
    let power = -logarithm / n as f64 - 2.0 * std::f64::consts::LOG2_E;
    let whole = libm::floor(power);
    let rest = power - whole;
    let fraction = (0.337_189 * rest + 0.657_636) * rest + 1.001_725;
    fraction * f64::from_bits(((whole.clamp(-1022.0, 1023.0) + 1023.0) as u64) << 52)
}

/// The upper half of a double's digits.
fn short(value: f64) -> f64 {
    f64::from_bits(value.to_bits() & !((1 << 29) - 1))
}

/// Σ_{k≥1} x_k tᵏ.
fn polynomial(jet: &[f64], t: f64, change: &mut [f64]) {
    change.fill(0.0);
    for row in jet.chunks_exact(change.len()).rev() {
        for (sum, coefficient) in change.iter_mut().zip(row) {
            *sum = *sum * t + coefficient;
        }
    }
    change.iter_mut().for_each(|sum| *sum *= t);
}

/// Several trajectories in lockstep.
struct Taylor {
    field: SmoothMapEvaluator,
    time_step: f64,
    /// exp(−0.7/(p − 1)).
    safety: f64,
    paths: Vec<Path>,
    /// Those that need a jet, and room for their states and jets.
    open: Vec<usize>,
    states: Vec<f64>,
    jets: Vec<f64>,
    change: Vec<f64>,
    linear: u64,
}

impl Taylor {
    fn new(field: &SmoothMap, parameters: &[f64], time_step: f64, count: usize) -> Self {
        let d = field.inputs();
        let order = field.outputs() / d;
        Self {
            field: field.evaluator(parameters, 1.0, 1.0),
            time_step,
            safety: libm::exp(-0.7 / (order - 1) as f64),
            paths: vec![Path::new(d, order); count],
            open: Vec::with_capacity(count),
            states: vec![0.0; count * d],
            jets: vec![0.0; count * order * d],
            change: vec![0.0; d],
            linear: 0,
        }
    }

    /// Jets and lengths of all that are open; those without drop out.
    fn evaluate(&mut self, taken: &mut [StepReport]) {
        let d = self.change.len();
        let count = self.open.len();
        if let [at] = self.open[..] {
            let path = &mut self.paths[at];
            if let Err(error) = self.field.values(&path.base, &mut path.jet) {
                taken[at].fail(error);
            }
        } else {
            let size = self.field.map().outputs();
            for (state, &at) in self.states.chunks_exact_mut(d).zip(&self.open) {
                state.copy_from_slice(&self.paths[at].base);
            }
            let open = &self.open;
            let (states, jets) = (&self.states[..count * d], &mut self.jets[..count * size]);
            self.field
                .each_value(states, jets, |at, error| taken[open[at]].fail(error));
            for (jet, &at) in self.jets.chunks_exact(size).zip(&self.open) {
                self.paths[at].jet.copy_from_slice(jet);
            }
        }
        for &at in &self.open {
            taken[at].evaluations += 1;
            if let Err(error) = self.paths[at].choose(self.time_step, self.safety) {
                taken[at].fail(error);
            }
        }
        // What the choice of a length takes.
        self.linear += count as u64 * (16 * d as u64 + 30);
    }
}

impl Trajectories for Taylor {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let d = self.change.len();
        let whole = self.time_step.abs();
        let work = 2 * self.field.map().outputs() as u64;
        for (at, path) in self.paths.iter_mut().enumerate() {
            let own = at * d..(at + 1) * d;
            path.begin(&x[own.clone()], &low[own]);
            let [time, low] = path.reached;
            let (time, low) = two_sum(time, self.time_step + low);
            path.reached = [time, low];
        }
        for substep in 0.. {
            self.open.clear();
            for (at, path) in self.paths.iter_mut().enumerate() {
                if taken[at].outcome.is_err() {
                    continue;
                }
                if path.length == 0.0 {
                    self.open.push(at);
                } else if path.reached[0].abs() > path.length.abs() {
                    let short = path.length.abs() <= 16.0 * f64::EPSILON * whole;
                    if short || substep > MOST_SUBSTEPS {
                        taken[at].fail(StepError::Singularity {
                            percent: 100.0 * (1.0 - path.reached[0].abs() / whole).max(0.0),
                        });
                        continue;
                    }
                    path.advance(&mut self.change);
                    self.linear += work;
                    self.open.push(at);
                }
            }
            if self.open.is_empty() {
                break;
            }
            self.evaluate(taken);
        }
        for (at, path) in self.paths.iter_mut().enumerate() {
            if taken[at].outcome.is_err() {
                continue;
            }
            let own = at * d..(at + 1) * d;
            polynomial(
                &path.jet,
                path.reached[0] + path.reached[1],
                &mut self.change,
            );
            self.linear += work;
            for (i, (at, change)) in own.zip(&self.change).enumerate() {
                let apart = path.low[i] - low[at];
                increment[at] = (path.base[i] - x[at]) + (apart + change);
                path.state[i] = two_sum(x[at], increment[at] + low[at]).0;
            }
        }
    }

    fn operations(&self) -> Option<u64> {
        Some(self.field.operations()? + self.linear)
    }

    fn restart(&mut self, at: usize) {
        self.paths[at].begun = false;
    }

    fn memory(&self, at: usize) -> Vec<f64> {
        let path = &self.paths[at];
        let [time, low] = path.reached;
        let begun = f64::from(u8::from(path.begun));
        let mut memory = vec![begun, path.before, time, low];
        for values in [&path.base, &path.low, &path.state] {
            memory.extend_from_slice(values);
        }
        memory
    }

    fn restore(&mut self, at: usize, memory: &[f64]) {
        let path = &mut self.paths[at];
        let d = path.base.len();
        path.begun = memory[0] != 0.0;
        path.before = memory[1];
        path.reached = [memory[2], memory[3]];
        for (values, kept) in [&mut path.base, &mut path.low, &mut path.state]
            .into_iter()
            .zip(memory[4..].chunks_exact(d))
        {
            values.copy_from_slice(kept);
        }
        // The jet is that of the base again.
        path.length = 0.0;
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    let tolerance = tolerance_of(&INFO, parameters, 1e-16)?;
    let order = order(tolerance);
    let field = jet_map(system, order)?;
    Ok(Arc::new(ReferenceMap {
        dimension: system.dimension(),
        properties: MapProperties {
            // A step ends on the polynomial it falls into: its error is that of the tolerance, whatever its size.
            order: 0,
            structure: Structure::None,
            self_adjoint: Some(false),
        },
        description: format!("{} tolerance = {tolerance:e}, order {order}", INFO.name),
        together: TOGETHER,
        make: Box::new(move |parameters, time_step, count| {
            Box::new(Taylor::new(&field, parameters, time_step, count))
        }),
    }))
}

leafwise_core::built_in!(StepperPart::new(&INFO, build));

#[cfg(test)]
mod tests {
    use super::{length, short};

    /// Parabolas that err by 0.005 in log₂ q and by 0.2 % in 2ʸ: together 0.2 % and 0.35 %/n.
    #[test]
    fn lengths_are_those_of_the_formula() {
        for n in [2, 3, 7, 20] {
            for k in -900..900 {
                let q = libm::exp2(0.37 * f64::from(k));
                let exact = libm::pow(q, -1.0 / n as f64) * libm::exp(-2.0);
                let off = (length(q, n) / exact - 1.0).abs();
                assert!(off < 0.002 + 0.0036 / n as f64, "{q:e}, {n}: {off:e}");
            }
        }
        assert!(length(0.0, 20) > 1e12 && length(f64::NAN, 2) > 1e12);
    }

    /// Differences of a time and a length are exact as long as it is over 2⁻²⁸ of it.
    #[test]
    fn short_lengths_are_subtracted_exactly() {
        for k in 1..1000 {
            let (time, own) = (
                200.0 + libm::sin(f64::from(k)),
                short(libm::exp(-f64::from(k % 13))),
            );
            let rest = time - own;
            assert_eq!((time - rest).to_bits(), own.to_bits());
        }
    }
}

//! The Taylor series of the motion, of order and step from a tolerance: the part `taylor`.
//!
//! The solution of ẋ = f(x) is x(t) = Σ x_k tᵏ about a state, with x_{k+1} = f_k/(k + 1), by one kernel. With
//! tolerance δ the order is p = ⌈1 − ln(δ)/2⌉. A substep is ρ e⁻² exp(−0.7/(p − 1)), with ρ the radius of convergence
//! that x_{p−1} and x_p show. The terms left out are then below δ e⁻² of the state.
//!
//! Substeps take no notice of the steps of εh: a step ends on the polynomial of the substep that it falls into.
//!
//! A series about one point does not know what is still small there: a pulse to come, a hill, a wall. So the
//! polynomial P is looked at at the end of each step and of each substep. Where the residual |P′ − f(P)| t/(p + 1) is
//! more than the tolerance allows, the substep ends before. Nothing that lasts as long as a step is stepped over.
//!
//! - `path`: one trajectory, its polynomial and what a look at it says.
//! - `polynomial`: values, slopes and lengths.

mod path;
mod polynomial;

use std::sync::Arc;

use leafwise_core::part::{
    Compared, Family, ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters,
};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::SmoothMapEvaluator;
use leafwise_core::solver::{StepReport, Trajectories};
use leafwise_core::system::MotionSeries;
use leafwise_core::{
    BuildError, Evaluator, MapProperties, MotionClass, PoissonSystem, StepError, StepMap,
    Structure, two_sum,
};
use leafwise_expression::AlgebraError;

use crate::adaptive::{CROSSING, MOST_SUBSTEPS, tolerance_of};
use crate::allowed::Allowed;
use crate::reference_map::ReferenceMap;
use path::Path;
use polynomial::unit;

static INFO: PartInfo = PartInfo {
    name: "taylor",
    summary: "the motion's Taylor series, of order and substeps from the tolerance",
    declares: "no order in the step: the tolerance sets the error, by substeps of order 1 - ln(tolerance)/2, rounded \
               up; not a Poisson map; not self-adjoint",
    domain: "any system of formulas, and sums over pairs in loops",
    literature: "Jorba, Zou, A software package for the numerical integration of ODEs by means of high-order Taylor \
                 methods, Experimental Mathematics 14 (2005); Biscani, Izzo, Revisiting high-order Taylor methods for \
                 astrodynamics and celestial mechanics, MNRAS 504 (2021)",
    parameters: &[TOLERANCE],
    family: Some(Family::Series),
    takes: MotionClass::OffLeaves,
    compared: Some(Compared::at(1)),
    reference: Some(&[]),
    ..PartInfo::of(PartKind::Stepper)
};

const TOLERANCE: ParameterInfo = ParameterInfo {
    name: "tolerance",
    summary: "the error of a substep relative to each component or its change, 1e-16 to 0.1",
    default: ParameterDefault::Real(1e-15),
};

/// The least error of a look that counts, relative: some roundings of the state.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;

/// Trajectories that ask for jets together.
const TOGETHER: usize = 16;

/// p.
fn order(tolerance: f64) -> usize {
    libm::ceil(1.0 - 0.5 * libm::log(tolerance)) as usize
}

/// The motion's series to order p.
fn series(system: &PoissonSystem, order: usize) -> Result<MotionSeries, BuildError> {
    let series = system.motion_series(INFO.name, order);
    series.map_err(|error| match error {
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

/// Several trajectories in lockstep.
struct Taylor {
    series: Arc<MotionSeries>,
    parameters: Vec<f64>,
    jet: SmoothMapEvaluator,
    field: SmoothMapEvaluator,
    /// The unit of time that series are written in, and the step in it.
    unit: f64,
    time_step: f64,
    /// exp(−0.7/(p − 1)).
    safety: f64,
    allowed: Allowed,
    paths: Vec<Path>,
    /// Those that need a jet, then those that are looked at.
    open: Vec<usize>,
    /// Room for their states, jets and slopes, and for the rounding errors of one.
    states: Vec<f64>,
    jets: Vec<f64>,
    slopes: Vec<f64>,
    roundings: [Vec<f64>; 2],
    linear: u64,
}

impl Taylor {
    fn new(
        series: &Arc<MotionSeries>,
        allowed: &Allowed,
        parameters: &[f64],
        time_step: f64,
        count: usize,
    ) -> Self {
        let d = series.jet.inputs();
        let order = series.jet.outputs() / d;
        let unit = unit(time_step);
        Self {
            series: Arc::clone(series),
            parameters: parameters.to_vec(),
            jet: series.jet.evaluator(parameters, 1.0, unit),
            field: series.field.evaluator(parameters, 1.0, 1.0),
            unit,
            time_step: time_step / unit,
            safety: libm::exp(-0.7 / (order - 1) as f64),
            allowed: allowed.clone(),
            paths: vec![Path::new(d, order); count],
            open: Vec::with_capacity(count),
            states: vec![0.0; count * d],
            jets: vec![0.0; count * order * d],
            slopes: vec![0.0; count * d],
            roundings: [vec![0.0; d], vec![0.0; d]],
            linear: 0,
        }
    }

    fn dimension(&self) -> usize {
        self.jet.map().inputs()
    }

    /// Jets and lengths of all that have none; those that have none drop out.
    fn expand(&mut self, taken: &mut [StepReport]) {
        let d = self.dimension();
        let (paths, open) = (&mut self.paths, &mut self.open);
        open.clear();
        open.extend((0..paths.len()).filter(|&at| !paths[at].has_jet && taken[at].outcome.is_ok()));
        let count = open.len();
        if let [at] = open[..] {
            let path = &mut paths[at];
            if let Err(error) = self.jet.values(&path.base, &mut path.jet) {
                taken[at].fail(error);
            }
        } else if count > 0 {
            let size = self.jet.map().outputs();
            for (state, &at) in self.states.chunks_exact_mut(d).zip(&*open) {
                state.copy_from_slice(&paths[at].base);
            }
            let (states, jets) = (&self.states[..count * d], &mut self.jets[..count * size]);
            self.jet
                .each_value(states, jets, |at, error| taken[open[at]].fail(error));
            for (jet, &at) in self.jets.chunks_exact(size).zip(&*open) {
                paths[at].jet.copy_from_slice(jet);
            }
        }
        for &at in &*open {
            let path = &mut paths[at];
            path.has_jet = true;
            taken[at].evaluations += 1;
            // Nor are the floors of a restored path kept, but what they are formed for.
            if path.floors.time > 0.0 {
                let field = (&self.series.rounding, &self.parameters[..], self.unit);
                path.form_floors(field, path.floors.time);
            }
            // A restored path knows its length.
            if path.length == 0.0
                && let Err(error) = path.choose(self.time_step, self.safety, &self.allowed)
            {
                taken[at].fail(error);
            }
        }
        // What the choice of a length takes.
        self.linear += count as u64 * (16 * d as u64 + 30);
    }

    /// Looks at all whose step has not ended, and goes on from what it sees; `false` where there are none.
    fn look(&mut self, taken: &mut [StepReport]) -> bool {
        let d = self.dimension();
        self.open.clear();
        let paths = &self.paths;
        let is_open = |&at: &usize| !paths[at].is_done && taken[at].outcome.is_ok();
        self.open.extend((0..paths.len()).filter(is_open));
        let count = self.open.len();
        if count == 0 {
            return false;
        }
        for (state, &at) in self.states.chunks_exact_mut(d).zip(&self.open) {
            self.paths[at].look(state);
        }
        let (states, slopes) = (&self.states[..count * d], &mut self.slopes[..count * d]);
        let undefined = |slope: &mut [f64]| slope.fill(f64::NAN);
        if count == 1 {
            if self.field.values(states, slopes).is_err() {
                undefined(slopes);
            }
        } else {
            let mut without = Vec::new();
            self.field
                .each_value(states, slopes, |at, _| without.push(at));
            without
                .into_iter()
                .for_each(|at| undefined(&mut slopes[at * d..][..d]));
        }
        slopes.iter_mut().for_each(|slope| *slope *= self.unit);
        for place in 0..count {
            let at = self.open[place];
            let slope = &self.slopes[place * d..][..d];
            let mut excess = self.paths[at].excess(slope, &self.allowed);
            if self.allowed.has_floors() && excess.is_finite() {
                let path = &mut self.paths[at];
                let is_formed = path.floors.time > 0.0;
                if excess > 1.0 && !is_formed {
                    let field = (&self.series.rounding, &self.parameters[..], self.unit);
                    path.form_floors(field, path.looked_at());
                    excess = path.excess(slope, &self.allowed);
                }
                path.needs_floors |= path.floors.time > 0.0
                    && (!is_formed || path.exceeds_itself(slope, &self.allowed));
            }
            let passes = excess <= 1.0
                || excess.is_finite() && (self.paths[at].crosses() || self.is_round_off(place));
            match passes {
                true => self.paths[at].pass(),
                false => self.paths[at].shorten(excess),
            }
        }
        self.linear += count as u64 * (4 * self.jet.map().outputs() as u64 + 12 * d as u64);
        true
    }

    /// Whether what one of those that are looked at has too much of is round-off of the field.
    fn is_round_off(&mut self, place: usize) -> bool {
        let d = self.dimension();
        let own = place * d..(place + 1) * d;
        let path = &self.paths[self.open[place]];
        let [errors, bounds] = &mut self.roundings;
        path.roundings(errors);
        let state = &self.states[own.clone()];
        self.series
            .rounding
            .bounds(&self.parameters, state, errors, bounds);
        bounds.iter_mut().for_each(|bound| *bound *= self.unit);
        path.is_round_off(&self.slopes[own], bounds, &self.allowed)
    }
}

impl Trajectories for Taylor {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let d = self.dimension();
        let whole = self.time_step.abs();
        for (at, path) in self.paths.iter_mut().enumerate() {
            let own = at * d..(at + 1) * d;
            path.begin(&x[own.clone()], &low[own], self.time_step);
        }
        for looks in 0.. {
            self.expand(taken);
            for (path, taken) in self.paths.iter_mut().zip(&mut *taken) {
                // A series knows its own side of a jump alone: one substep of the size of round-off crosses it.
                if self.series.has_seams && path.length.abs() <= CROSSING * whole {
                    path.cross(CROSSING * self.time_step);
                }
                let is_short = path.length.abs() <= 16.0 * f64::EPSILON * whole;
                if path.goes_on() && (is_short || looks > MOST_SUBSTEPS) {
                    taken.fail(StepError::Singularity {
                        percent: 100.0 * (1.0 - path.reached[0].abs() / whole).max(0.0),
                    });
                }
            }
            if !self.look(taken) {
                break;
            }
        }
        for (at, path) in self.paths.iter_mut().enumerate() {
            if taken[at].outcome.is_err() {
                continue;
            }
            let own = at * d..(at + 1) * d;
            for (i, (at, change)) in own.zip(&path.change).enumerate() {
                let apart = path.low[i] - low[at];
                increment[at] = (path.base[i] - x[at]) + (apart + change);
                path.state[i] = two_sum(x[at], increment[at] + low[at]).0;
            }
        }
    }

    fn operations(&self) -> Option<u64> {
        Some(self.jet.operations()? + self.field.operations()? + self.linear)
    }

    fn restart(&mut self, at: usize) {
        self.paths[at].begun = false;
    }

    fn memory(&self, at: usize) -> Vec<f64> {
        let path = &self.paths[at];
        let [time, low] = path.reached;
        let begun = f64::from(u8::from(path.begun));
        let needs_floors = f64::from(u8::from(path.needs_floors));
        let floors = [path.floors.time, needs_floors];
        let mut memory = vec![begun, path.before, path.length, time, low];
        memory.extend_from_slice(&floors);
        for values in [&path.base, &path.low, &path.state] {
            memory.extend_from_slice(values);
        }
        memory
    }

    fn restore(&mut self, at: usize, memory: &[f64]) {
        let path = &mut self.paths[at];
        let d = path.base.len();
        path.begun = memory[0] != 0.0;
        [path.before, path.length] = [memory[1], memory[2]];
        path.reached = [memory[3], memory[4]];
        path.floors.clear();
        path.floors.time = memory[5];
        path.needs_floors = memory[6] != 0.0;
        path.passed = path.reached[0] + path.reached[1];
        for (values, kept) in [&mut path.base, &mut path.low, &mut path.state]
            .into_iter()
            .zip(memory[7..].chunks_exact(d))
        {
            values.copy_from_slice(kept);
        }
        // The jet is that of the base again.
        path.has_jet = false;
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    let tolerance = tolerance_of(&INFO, parameters, 1e-16)?;
    let order = order(tolerance);
    let series = Arc::new(series(system, order)?);
    let allowed = Allowed::new(system, tolerance.max(ROUND_OFF), true);
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
        kept_signs: allowed.kept(),
        make: Box::new(move |parameters, time_step, count| {
            Box::new(Taylor::new(&series, &allowed, parameters, time_step, count))
        }),
    }))
}

leafwise_core::built_in!(StepperPart::new(&INFO, build));

//! Embedded explicit Runge–Kutta pairs, adaptive inside a step.

use std::cmp::Ordering;
use std::sync::Arc;

use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo, PartParameters};
use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::solver::{StepReport, Trajectories};
use leafwise_core::system::FieldRounding;
use leafwise_core::{
    BuildError, Evaluator, MapProperties, PoissonSystem, StepError, StepMap, Structure,
    SystemFormulas,
};

use crate::allowed::Allowed;
use crate::floors::Floors;
use crate::reference_map::ReferenceMap;

/// A row of coefficients: (stage, value).
pub(crate) type Row = &'static [(usize, f64)];

/// The coefficients of a pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    /// a_ij, the stages one after the other.
    pub matrix: &'static [Row],
    /// b_i.
    pub weights: Row,
    /// b_i − b̂_i of the embedded methods; of two, the estimate of the second damps the first.
    pub errors: &'static [Row],
    /// The order of the method.
    pub order: usize,
    /// q + 1, where the estimated error of a substep is O(τ^{q+1}).
    pub exponent: f64,
    /// Whether the last stage is evaluated at the new state.
    pub first_same_as_last: bool,
}

/// Budget of one step.
pub(crate) const MOST_SUBSTEPS: usize = 100_000;
/// Substeps are multiplied by a number between these, after a safety factor.
const SHRINK: f64 = 1.0 / 3.0;
const GROW: f64 = 6.0;
const SAFETY: f64 = 0.9;

/// First substep: a hundredth of the time in which a coordinate changes by its own size, as geometric mean over
/// coordinates. A coordinate counts for no less than `LEAST_FIRST` of the step, for it may be small by chance, and for
/// no more than all of it.
const FIRST: f64 = 0.01;
const LEAST_FIRST: f64 = 1e-4;

/// A jump of the field is crossed by a substep of this part of the step, whatever its error seems: it is of the size of
/// round-off.
pub(crate) const CROSSING: f64 = 1.0 / (1_u64 << 44) as f64;

/// Such a substep moves no coordinate by more than this part of the largest: next to a pole it would.
pub(crate) const STILL: f64 = 1e-6;

/// After so many refusals, before the time of the first has passed, it is asked whether the error is the field's round-off, or
/// that of coordinates at rest.
const STUBBORN: u32 = 4;
/// Sweeps that bounds on rounding errors take at most, where they do not settle.
const FEW: usize = 2;
/// Bounds of a coordinate that are doubled more often grow on and on.
const MOST_DOUBLINGS: u32 = 6;
/// Errors of so many times the bound on the field's rounding errors are round-off: weights of both signs come to some units.
const WITHIN: f64 = 4.0;

/// A pair for one trajectory.
struct AdaptivePair {
    pair: &'static Pair,
    field: SmoothMapEvaluator,
    /// Why the field had no value at the last place without one.
    refusal: Option<StepError>,
    time_step: f64,
    tolerance: f64,
    allowed: Allowed,
    rounding: Option<Arc<FieldRounding>>,
    /// Whether the field may jump.
    has_seams: bool,
    parameters: Vec<f64>,
    /// Bounds on the rounding errors of the field at the state, once substeps are refused again and again.
    bounds: Option<Vec<f64>>,
    /// Errors of coordinates below which nothing is looked at. They are formed after stubborn refusals, and stand
    /// until the end of a step that did not need them.
    floors: Floors,
    /// Whether a coordinate's error in the last substep was allowed for its floor alone.
    needs_floors: bool,
    /// The size of the next substep, 0 when not known.
    proposed: f64,
    state: Vec<f64>,
    stage: Vec<f64>,
    change: Vec<f64>,
    slopes: Vec<Vec<f64>>,
    /// Operations of a substep's sums a coordinate, and of all sums so far.
    sums: u64,
    linear: u64,
}

/// Σ_j a_j k_j[c].
fn combine(row: Row, slopes: &[Vec<f64>], c: usize) -> f64 {
    row.iter().map(|&(j, a)| a * slopes[j][c]).sum()
}

impl AdaptivePair {
    fn new(
        pair: &'static Pair,
        field: &SmoothMap,
        parameters: &[f64],
        time_step: f64,
        tolerance: f64,
        (allowed, rounding, has_seams): (&Allowed, Option<&Arc<FieldRounding>>, bool),
    ) -> Self {
        let d = field.inputs();
        let rows = pair.matrix.iter().chain([&pair.weights]).chain(pair.errors);
        Self {
            pair,
            field: field.evaluator(parameters, 1.0, 1.0),
            refusal: None,
            time_step,
            tolerance,
            allowed: allowed.clone(),
            rounding: rounding.cloned(),
            has_seams,
            parameters: parameters.to_vec(),
            bounds: None,
            floors: Floors::new(d),
            needs_floors: false,
            proposed: 0.0,
            state: vec![0.0; d],
            stage: vec![0.0; d],
            change: vec![0.0; d],
            slopes: vec![vec![0.0; d]; pair.matrix.len()],
            sums: rows.map(|row| 2 * row.len() as u64).sum(),
            linear: 0,
        }
    }

    /// The field at a stage; NaN where it has no value, so that the substep is taken shorter.
    fn slope_at(&mut self, stage: usize) {
        let at = if stage == 0 { &self.state } else { &self.stage };
        let slope = &mut self.slopes[stage];
        if let Err(error) = self.field.values(at, slope) {
            slope.fill(f64::NAN);
            self.refusal = Some(error);
        }
    }

    /// The size of component c, or of its change in a substep of size `tau` where that is larger.
    fn size(&self, c: usize, tau: f64) -> f64 {
        let (x, slope) = (self.state[c], self.slopes[0][c]);
        let end = (x + self.change[c]).abs();
        x.abs().max(end).max((tau * slope).abs())
    }

    /// Whether the substep moves nothing by much.
    fn is_still(&self) -> bool {
        let size = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        size(&self.change) <= STILL * size(&self.state)
    }

    /// The first substep.
    fn first(&self) -> f64 {
        let whole = self.time_step.abs();
        let pairs = self.state.iter().zip(&self.slopes[0]);
        // A coordinate at 0 tells no time, nor does one at rest: x/0 is infinite.
        let moves = pairs.filter(|(x, slope)| **x != 0.0 && **slope != 0.0);
        let logarithm = |(x, slope): (&f64, &f64)| {
            let part = FIRST * (x / slope).abs() / whole;
            libm::log(part.clamp(LEAST_FIRST, 1.0))
        };
        let (sum, count) = moves.fold((0.0, 0.0), |(sum, count), pair| {
            (sum + logarithm(pair), count + 1.0)
        });
        if count > 0.0 {
            whole * libm::exp(sum / count)
        } else {
            whole
        }
    }

    /// One substep from `state`, its slope in `slopes[0]`: writes `change`, returns the error
    /// relative to the tolerance.
    fn substep(&mut self, tau: f64) -> f64 {
        let pair = self.pair;
        for i in 1..pair.matrix.len() {
            for c in 0..self.state.len() {
                self.stage[c] = self.state[c] + tau * combine(pair.matrix[i], &self.slopes, c);
            }
            self.slope_at(i);
        }
        self.linear += self.sums * self.state.len() as u64;
        let mut largest = 0.0_f64;
        for c in 0..self.state.len() {
            self.change[c] = tau * combine(pair.weights, &self.slopes, c);
            largest = largest.max(self.size(c, tau));
        }
        // Σ (error / scale)² of each embedded method.
        let mut squares = [0.0; 2];
        self.needs_floors = false;
        // One error alone may be so many times what is allowed: they count by their mean square.
        let most = libm::sqrt(self.state.len() as f64);
        for c in 0..self.state.len() {
            let size = self.size(c, tau);
            let scale = self.allowed.error(c, size, largest, &self.floors);
            let rounded = self.bounds.as_ref().map_or(0.0, |bounds| bounds[c]);
            let scale = scale.max(WITHIN * rounded * tau.abs());
            if self.floors.time > 0.0 {
                let own = self.allowed.of_itself(size);
                let own = most * own.max(WITHIN * rounded * tau.abs());
                let mut errors = pair.errors.iter().map(|row| combine(row, &self.slopes, c));
                self.needs_floors |= errors.any(|error| (tau * error).abs() > own);
            }
            for (square, row) in squares.iter_mut().zip(pair.errors) {
                let error = combine(row, &self.slopes, c);
                *square += if error == 0.0 {
                    0.0
                } else {
                    error / scale * (error / scale)
                };
            }
        }
        let [first, second] = squares;
        if first == 0.0 {
            return 0.0;
        }
        let count = self.state.len() as f64;
        if pair.errors.len() < 2 {
            return tau.abs() * libm::sqrt(first / count);
        }
        // Hairer's estimate err₁²/√(err₁² + 0.01 err₂²).
        tau.abs() * first / libm::sqrt((first + 0.01 * second) * count)
    }

    /// Forms bounds on the field's rounding errors at the state and at the stages of a substep of size `tau`. The
    /// stages are moved by the errors of slopes: bounds grow, sweep by sweep, from each coordinate to those that read
    /// it.
    fn bound(&mut self, tau: f64) {
        let most = match self.allowed.has_floors() {
            true => self.state.len(),
            false => FEW,
        };
        self.bounds = match self.bounds_after(most, tau) {
            // Where they double on and on the substep is long, and what comes of a few sweeps has to do.
            (bounds, false) if most > FEW => self.bounds_after(FEW, tau).0.or(bounds),
            (bounds, _) => bounds,
        };
    }

    /// The bounds after so many sweeps, or fewer once none is doubled, and whether none is.
    fn bounds_after(&self, most: usize, tau: f64) -> (Option<Vec<f64>>, bool) {
        let Some(rounding) = &self.rounding else {
            return (None, true);
        };
        let own: Vec<f64> = self.state.iter().map(|x| f64::EPSILON * x.abs()).collect();
        let mut errors = own.clone();
        let mut bounds = vec![0.0; own.len()];
        let mut before = bounds.clone();
        let mut doublings = vec![0; own.len()];
        for _ in 0..=most {
            before.copy_from_slice(&bounds);
            rounding.bounds(&self.parameters, &self.state, &errors, &mut bounds);
            let mut grows = false;
            for ((bound, before), doublings) in bounds.iter().zip(&before).zip(&mut doublings) {
                // Also where one of them is no number.
                if bound
                    .partial_cmp(&(2.0 * before))
                    .is_none_or(Ordering::is_gt)
                {
                    grows = true;
                    *doublings += 1;
                }
            }
            if !grows {
                return (Some(bounds), true);
            }
            if doublings.iter().any(|times| *times > MOST_DOUBLINGS) {
                break;
            }
            for ((error, own), bound) in errors.iter_mut().zip(&own).zip(&bounds) {
                *error = own + tau * bound;
            }
        }
        (Some(bounds), false)
    }

    /// Forms the floors at the state.
    fn form_floors(&mut self, time: f64) {
        let Some(rounding) = &self.rounding else {
            return;
        };
        if self.allowed.has_floors() {
            let field = (&**rounding, &self.parameters[..], 1.0);
            let time = time.copysign(self.time_step);
            self.floors.form(field, &self.state, &self.slopes[0], time);
        }
    }

    /// The slope at the state that a substep has reached.
    fn slope_at_new_state(&mut self) {
        if self.pair.first_same_as_last {
            let last = self.slopes.len() - 1;
            self.slopes.swap(0, last);
        } else {
            self.slope_at(0);
        }
    }
}

impl AdaptivePair {
    fn advance(&mut self, x: &[f64], increment: &mut [f64]) -> Result<usize, StepError> {
        self.state.copy_from_slice(x);
        increment.fill(0.0);
        self.refusal = None;
        self.bounds = None;
        self.change.fill(0.0);
        self.slope_at(0);
        let whole = self.time_step.abs();
        let mut tau = if self.proposed > 0.0 {
            self.proposed
        } else {
            self.first()
        };
        if self.floors.time > 0.0 {
            self.form_floors(self.floors.time);
        }
        let mut done = 0.0;
        let mut rejected = 0;
        // Refusals, when they began and with which substep: what is not looked at does not shrink with those that follow.
        let mut refusals = 0;
        let mut began = [0.0_f64; 2];
        let mut needs_floors = false;
        for count in 1..=MOST_SUBSTEPS {
            let rest = whole - done;
            // Of a rest of less than two substeps the half is taken: no sliver is left over.
            let last = tau >= rest;
            let size = if last { rest } else { tau.min(0.5 * rest) };
            let error = self.substep(size.copysign(self.time_step));
            // The estimate of an error does not shrink with the substep where the field jumps and a coordinate is 0.
            let crosses =
                self.has_seams && error.is_finite() && size <= CROSSING * whole && self.is_still();
            let factor = if error > 0.0 && !crosses {
                (SAFETY / libm::pow(error, 1.0 / self.pair.exponent)).clamp(SHRINK, GROW)
            } else if error == 0.0 || crosses {
                GROW
            } else {
                // Not a number: the substep left the formulas' domain.
                SHRINK
            };
            if error <= 1.0 || crosses {
                for c in 0..x.len() {
                    increment[c] += self.change[c];
                    self.state[c] = x[c] + increment[c];
                }
                done += size;
                let [since, longest] = began;
                if done >= since + longest {
                    refusals = 0;
                }
                let growth = if rejected > 0 && !crosses {
                    factor.min(1.0)
                } else {
                    factor
                };
                tau = if last {
                    tau.max(size * growth)
                } else {
                    size * growth
                };
                rejected = 0;
                needs_floors |= self.needs_floors;
                if last {
                    self.proposed = tau;
                    if !needs_floors {
                        self.floors.clear();
                    }
                    return Ok(count);
                }
                self.slope_at_new_state();
                if self.bounds.is_some() {
                    self.bound(tau);
                }
            } else {
                if refusals == 0 {
                    began = [done, size];
                }
                refusals += 1;
                rejected += 1;
                tau = size * factor;
                if refusals == STUBBORN {
                    self.bound(tau);
                    self.form_floors(self.floors.time.max(began[1]));
                }
                if tau <= 16.0 * f64::EPSILON * whole {
                    return Err(if error.is_finite() {
                        StepError::NoConvergence {
                            evaluations: count,
                            correction: error * self.tolerance,
                        }
                    } else {
                        self.refusal.take().unwrap_or(StepError::NonFinite {
                            what: "the field in a substep",
                        })
                    });
                }
            }
        }
        Err(StepError::NoConvergence {
            evaluations: MOST_SUBSTEPS,
            correction: self.tolerance,
        })
    }
}

impl Trajectories for AdaptivePair {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let step = self.advance(x, increment);
        taken[0].take(step, false);
    }

    fn operations(&self) -> Option<u64> {
        Some(self.field.operations()? + self.linear)
    }

    fn restart(&mut self, _: usize) {
        self.proposed = 0.0;
        self.floors.clear();
    }

    fn memory(&self, _: usize) -> Vec<f64> {
        vec![self.proposed, self.floors.time]
    }

    fn restore(&mut self, _: usize, memory: &[f64]) {
        self.floors.clear();
        [self.proposed, self.floors.time] = [memory[0], memory[1]];
    }
}

/// The parameter `tolerance`.
pub(crate) const TOLERANCE: ParameterInfo = ParameterInfo {
    name: "tolerance",
    summary: "the error of a substep relative to each component or its change, 1e-14 to 0.1",
    default: ParameterDefault::Real(1e-12),
};

/// The tolerance that is asked for.
///
/// # Errors
/// [`BuildError::Parameter`] outside `least` to 0.1.
pub(crate) fn tolerance_of(
    info: &'static PartInfo,
    parameters: &PartParameters,
    least: f64,
) -> Result<f64, BuildError> {
    let tolerance = parameters.real(info, TOLERANCE.name)?;
    if !(least..=0.1).contains(&tolerance) {
        return Err(BuildError::Parameter {
            part: info.name,
            parameter: TOLERANCE.name.to_owned(),
            value: tolerance.to_string(),
            expected: format!("the tolerance lies in {least:e} to 0.1"),
        });
    }
    Ok(tolerance)
}

/// The part `info` over a pair.
///
/// # Errors
/// [`BuildError::Parameter`] for a tolerance outside 1e-14 to 0.1.
pub(crate) fn adaptive_map(
    info: &'static PartInfo,
    pair: &'static Pair,
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    let tolerance = tolerance_of(info, parameters, 1e-14)?;
    let (field, rounding) = system.field_and_rounding()?;
    let rounding = rounding.map(Arc::new);
    let allowed = Allowed::new(system, tolerance, rounding.is_some());
    let has_seams = system.expressions().is_some_and(SystemFormulas::has_seams);
    Ok(Arc::new(ReferenceMap {
        dimension: system.dimension(),
        properties: MapProperties {
            order: pair.order,
            structure: Structure::None,
            self_adjoint: Some(false),
        },
        description: format!("{} tolerance = {tolerance:e}", info.name),
        together: 1,
        kept_signs: allowed.kept(),
        make: Box::new(move |parameters, time_step, _| {
            Box::new(AdaptivePair::new(
                pair,
                &field,
                parameters,
                time_step,
                tolerance,
                (&allowed, rounding.as_ref(), has_seams),
            ))
        }),
    }))
}

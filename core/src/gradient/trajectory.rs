//! Derivatives of a whole trajectory.
//!
//! Tangents run forwards beside the state. Covectors run backwards. A self-adjoint map is stepped back,
//! Φ_{−h} = Φ_h⁻¹, and nothing is kept of the run but 64 of its states. Other maps are stepped again from checkpoints,
//! four times the binary logarithm of the steps. Both are the derivatives of the map that is stepped, not approximations of
//! the flow's.

use super::checkpoints::{checkpoints, visit_in_reverse};
use super::error::GradientError;
use super::growth::Growth;
use crate::error::StepError;
use crate::solver::{Differential, StepMap, add};
use crate::walk::Walk;

/// Steps between two looks at whether to go on, and at whether covectors are finite.
const LOOK_EVERY: u64 = 1024;

/// How far, in parts of it, a run back may come from a kept state before covectors are taken along the run itself.
const LARGEST_MISS: f64 = 1e-7;

/// Number of states that a run keeps for the way back. Round-off moves a state by n^{3/2} after n steps along regular
/// motion, and by e^{λt} along chaotic motion. From one kept state to the one before it, that is 64^{3/2} = 512 times
/// less than over the whole run, or its 64th root.
const KEPT: u64 = 64;

/// A map with its parameters and step sizes.
#[derive(Clone, Copy)]
pub struct Trajectory<'a> {
    /// Φ.
    pub map: &'a dyn StepMap,
    /// λ.
    pub parameters: &'a [f64],
    /// ε.
    pub epsilon: f64,
    /// h.
    pub h: f64,
    /// Asked every thousand steps: whether to go on.
    pub goes_on: &'a (dyn Fn() -> bool + Sync),
}

/// How far a run goes, and which states are its samples: x_0, x_e, x_{2e}, ….
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The number of steps.
    pub steps: u64,
    /// e, at least 1.
    pub every: u64,
}

impl Plan {
    /// The number of samples.
    pub fn samples(&self) -> usize {
        (self.steps / self.every) as usize + 1
    }

    /// The number of pieces that a run has, each with its end kept.
    pub fn pieces(&self) -> usize {
        self.steps.clamp(1, KEPT) as usize
    }

    /// After how many steps a piece ends; the one before the first ends at 0.
    fn end_of(&self, piece: usize) -> u64 {
        (u128::from(self.steps) * piece as u128 / self.pieces() as u128) as u64
    }

    /// Which sample is the state after so many steps.
    fn sample_at(&self, step: u64) -> Option<usize> {
        step.is_multiple_of(self.every)
            .then_some((step / self.every) as usize)
    }
}

/// Where a run came.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached {
    /// Samples, d numbers each.
    pub samples: Vec<f64>,
    /// The state at the end of each [piece](Plan::pieces), and what it holds beyond a double, d numbers each: at most 64.
    pub kept: Vec<f64>,
}

impl Reached {
    /// The last state, and what it holds beyond a double.
    pub fn end(&self, d: usize) -> (&[f64], &[f64]) {
        self.kept[self.kept.len() - 2 * d..].split_at(d)
    }
}

/// Samples and their tangents.
#[derive(Clone, Debug, PartialEq)]
pub struct Pushed {
    /// Samples, d numbers each.
    pub samples: Vec<f64>,
    /// The tangents of each sample, d numbers each.
    pub tangents: Vec<f64>,
    /// How the tangents grew: their largest norm over the norms of v and μ.
    pub growth: Growth,
}

/// How covectors find the states of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// By steps back, of self-adjoint maps.
    Back,
    /// By steps taken again from checkpoints.
    Checkpoints,
}

/// The gradient of a function of the samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// By x_0.
    pub initial: Vec<f64>,
    /// By λ; empty where it was not asked for.
    pub parameters: Vec<f64>,
    /// How the covectors grew on their way: the largest norm of their sum over the sum of their norms.
    pub growth: Growth,
    /// How far the run back came from x_0 and the other kept states at most, in parts of them; 0 by checkpoints.
    pub miss: f64,
    /// How it was found.
    pub way: Way,
    /// Operations of the way back; `None` when a part does not count its own.
    pub operations: Option<u64>,
}

impl Trajectory<'_> {
    /// The run from `initial`: the states of an [`Walk`], to the bit.
    ///
    /// # Errors
    /// [`GradientError::Step`] with the step that failed.
    pub fn run(&self, initial: &[f64], plan: Plan) -> Result<Reached, GradientError> {
        let mut walk = self.walk(initial);
        let mut samples = Vec::with_capacity(plan.samples() * initial.len());
        samples.extend_from_slice(initial);
        let mut kept = Vec::with_capacity(2 * plan.pieces() * initial.len());
        for piece in 1..=plan.pieces() {
            let end = plan.end_of(piece);
            while walk.steps() < end {
                self.look()?;
                let to_sample = plan.every - walk.steps() % plan.every;
                let to_end = end - walk.steps();
                let advanced = walk.advance(to_sample.min(to_end).min(LOOK_EVERY));
                advanced.map_err(|error| failed(walk.steps(), error))?;
                if plan.sample_at(walk.steps()).is_some() {
                    samples.extend_from_slice(walk.state());
                }
            }
            kept.extend_from_slice(walk.state());
            kept.extend_from_slice(walk.compensation());
        }
        Ok(Reached { samples, kept })
    }

    /// Samples and their tangents dx = DΦᵏ v + ∂_λΦᵏ μ at every sample, tangent by tangent. Each v of x_0 in
    /// `tangents` has d numbers; its μ of the parameters is in `by_parameters`, which may be empty.
    ///
    /// # Errors
    /// [`GradientError`].
    pub fn push(
        &self,
        initial: &[f64],
        (tangents, by_parameters): (&[f64], &[f64]),
        plan: Plan,
    ) -> Result<Pushed, GradientError> {
        let d = initial.len();
        let mut differential = self.differential(self.h, !by_parameters.is_empty())?;
        let (mut state, mut low) = (initial.to_vec(), vec![0.0; d]);
        let (mut increment, mut moved) = (vec![0.0; d], tangents.to_vec());
        let (mut samples, mut pushed) = (initial.to_vec(), tangents.to_vec());
        let given = norm(&[tangents, by_parameters].concat());
        let mut largest = norm(tangents);
        for step in 1..=plan.steps {
            let stepped = differential.step(&state, &low, &mut increment);
            let stepped = stepped.and_then(|()| differential.push(&mut moved, by_parameters));
            stepped
                .and_then(|()| add(&mut state, &mut low, &increment))
                .map_err(|error| self.refused(step - 1, error))?;
            let sample = plan.sample_at(step);
            if sample.is_some() || step.is_multiple_of(LOOK_EVERY) {
                self.look()?;
                if !moved.iter().all(|value| value.is_finite()) {
                    return Err(self.overflow(step, step));
                }
                largest = largest.max(norm(&moved));
            }
            if sample.is_some() {
                samples.extend_from_slice(&state);
                pushed.extend_from_slice(&moved);
            }
        }
        Ok(Pushed {
            samples,
            tangents: pushed,
            growth: self.growth(largest, given, plan.steps),
        })
    }

    /// The gradient by x_0, and by λ where it is `by_parameters`, of a function of the samples whose derivatives by
    /// them are `cotangents`, for a run that [`run`](Self::run) made. The way is chosen where none is named.
    ///
    /// # Errors
    /// [`GradientError`].
    ///
    /// # Panics
    /// When there is not a covector for each sample.
    pub fn pull(
        &self,
        initial: &[f64],
        reached: &Reached,
        cotangents: &[f64],
        plan: Plan,
        (by_parameters, way): (bool, Option<Way>),
    ) -> Result<Gradient, GradientError> {
        assert_eq!(
            cotangents.len(),
            plan.samples() * initial.len(),
            "a covector for each sample"
        );
        let is_self_adjoint = self.map.properties().self_adjoint == Some(true);
        match way {
            Some(Way::Back) if !is_self_adjoint => {
                return Err(GradientError::NotSelfAdjoint {
                    map: self.map.describe(),
                });
            }
            Some(Way::Back) => {
                return self.pull_back(initial, reached, cotangents, plan, by_parameters);
            }
            None if is_self_adjoint => {
                match self.pull_back(initial, reached, cotangents, plan, by_parameters) {
                    Ok(gradient) if gradient.miss <= LARGEST_MISS => return Ok(gradient),
                    // The way back lost the run: its own states are stepped again.
                    Ok(_) | Err(GradientError::Step { .. } | GradientError::Overflow { .. }) => {}
                    Err(other) => return Err(other),
                }
            }
            _ => {}
        }
        self.pull_from_checkpoints(initial, cotangents, plan, by_parameters)
    }

    fn pull_back(
        &self,
        initial: &[f64],
        reached: &Reached,
        cotangents: &[f64],
        plan: Plan,
        by_parameters: bool,
    ) -> Result<Gradient, GradientError> {
        let d = initial.len();
        let mut differential = self.differential(-self.h, by_parameters)?;
        let mut covectors = Covectors::new(self, cotangents, plan, by_parameters, d);
        let (mut state, mut low) = (vec![0.0; d], vec![0.0; d]);
        let (mut increment, mut miss) = (vec![0.0; d], 0.0_f64);
        for piece in (0..plan.pieces()).rev() {
            let (begin, beyond) = reached.kept[2 * piece * d..][..2 * d].split_at(d);
            state.copy_from_slice(begin);
            low.copy_from_slice(beyond);
            for step in (plan.end_of(piece)..plan.end_of(piece + 1)).rev() {
                let from = [&state[..], &low[..]];
                let pulled = covectors.take(step, |covector, gradient| {
                    differential.step_and_pull_inverse(from, &mut increment, covector, gradient)
                });
                pulled
                    .and_then(|()| add(&mut state, &mut low, &increment))
                    .map_err(|error| self.refused(step, error))?;
                covectors.look(step)?;
            }
            let from = match piece {
                0 => initial,
                _ => &reached.kept[2 * (piece - 1) * d..][..d],
            };
            miss = miss.max(missed(&state, from));
        }
        Ok(covectors.gradient(Way::Back, miss, differential.operations()))
    }

    fn pull_from_checkpoints(
        &self,
        initial: &[f64],
        cotangents: &[f64],
        plan: Plan,
        by_parameters: bool,
    ) -> Result<Gradient, GradientError> {
        let mut differential = self.differential(self.h, by_parameters)?;
        let mut covectors = Covectors::new(self, cotangents, plan, by_parameters, initial.len());
        let mut increment = vec![0.0; initial.len()];
        let mut walk = self.walk(initial);
        let begin = walk.checkpoint();
        let slots = checkpoints(plan.steps);
        visit_in_reverse(&mut walk, &begin, plan.steps, slots, &mut |at| {
            let stepped = differential.step(&at.state, &at.compensation, &mut increment);
            stepped
                .and_then(|()| {
                    covectors.take(at.steps, |covector, gradient| {
                        differential.pull(covector, gradient)
                    })
                })
                .map_err(|error| self.refused(at.steps, error))?;
            covectors.look(at.steps)
        })?;
        let stepped = walk.statistics().operations;
        let operations = differential.operations().zip(stepped);
        let operations = operations.map(|(own, again)| own + again);
        Ok(covectors.gradient(Way::Checkpoints, 0.0, operations))
    }

    fn walk(&self, initial: &[f64]) -> Walk {
        Walk::new(self.map, self.parameters, self.epsilon, self.h, initial)
    }

    fn differential(
        &self,
        h: f64,
        by_parameters: bool,
    ) -> Result<Box<dyn Differential>, GradientError> {
        let differential = self.map.differential(self.parameters, self.epsilon, h);
        if by_parameters && !differential.knows_parameters() {
            return Err(GradientError::NoParameters {
                map: self.map.describe(),
            });
        }
        Ok(differential)
    }

    fn look(&self) -> Result<(), GradientError> {
        if (self.goes_on)() {
            Ok(())
        } else {
            Err(GradientError::Interrupted)
        }
    }

    fn refused(&self, step: u64, error: StepError) -> GradientError {
        match error {
            StepError::NoTangent => GradientError::NoTangent {
                map: self.map.describe(),
            },
            error => failed(step, error),
        }
    }

    /// That of vectors from the norm `given` to `largest`.
    fn growth(&self, largest: f64, given: f64, steps: u64) -> Growth {
        let grew = largest > 0.0 && given > 0.0;
        Growth {
            logarithm: if grew {
                libm::log(largest / given)
            } else {
                0.0
            },
            time: (steps as f64 * self.epsilon * self.h).abs(),
        }
    }

    fn overflow(&self, step: u64, steps: u64) -> GradientError {
        GradientError::Overflow {
            step,
            growth: self.growth(f64::MAX, 1.0, steps),
        }
    }
}

/// How far a state came from another, in parts of that.
fn missed(state: &[f64], from: &[f64]) -> f64 {
    let size = |x: &[f64]| x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let away: Vec<f64> = state.iter().zip(from).map(|(a, b)| a - b).collect();
    size(&away) / size(from).max(f64::MIN_POSITIVE)
}

fn failed(step: u64, error: StepError) -> GradientError {
    GradientError::Step { step, error }
}

/// Covectors on their way to the initial state.
struct Covectors<'a> {
    trajectory: &'a Trajectory<'a>,
    cotangents: &'a [f64],
    plan: Plan,
    covector: Vec<f64>,
    gradient: Vec<f64>,
    /// Σ ‖w‖ of the samples' covectors so far.
    given: f64,
    /// The largest ‖Σ w‖/Σ ‖w‖ seen.
    largest: f64,
}

impl<'a> Covectors<'a> {
    fn new(
        trajectory: &'a Trajectory<'a>,
        cotangents: &'a [f64],
        plan: Plan,
        by_parameters: bool,
        d: usize,
    ) -> Self {
        let parameters = if by_parameters {
            trajectory.parameters.len()
        } else {
            0
        };
        let mut new = Self {
            trajectory,
            cotangents,
            plan,
            covector: vec![0.0; d],
            gradient: vec![0.0; parameters],
            given: 0.0,
            largest: 0.0,
        };
        new.inject(plan.steps);
        new
    }

    /// Adds what the function has of the sample after so many steps.
    fn inject(&mut self, step: u64) {
        let Some(at) = self.plan.sample_at(step) else {
            return;
        };
        let d = self.covector.len();
        let own = &self.cotangents[at * d..][..d];
        self.given += norm(own);
        for (w, cotangent) in self.covector.iter_mut().zip(own) {
            *w += cotangent;
        }
    }

    /// Pulls back through the step from x_k, k = `step`.
    fn take(
        &mut self,
        step: u64,
        mut pull: impl FnMut(&mut [f64], &mut [f64]) -> Result<(), StepError>,
    ) -> Result<(), StepError> {
        pull(&mut self.covector, &mut self.gradient)?;
        self.inject(step);
        Ok(())
    }

    fn look(&mut self, step: u64) -> Result<(), GradientError> {
        if !step.is_multiple_of(LOOK_EVERY) {
            return Ok(());
        }
        self.trajectory.look()?;
        let mut values = self.covector.iter().chain(&self.gradient);
        if !values.all(|value| value.is_finite()) {
            return Err(self.trajectory.overflow(step, self.plan.steps - step));
        }
        if self.given > 0.0 {
            self.largest = self.largest.max(norm(&self.covector) / self.given);
        }
        Ok(())
    }

    fn gradient(self, way: Way, miss: f64, operations: Option<u64>) -> Gradient {
        Gradient {
            growth: self.trajectory.growth(self.largest, 1.0, self.plan.steps),
            initial: self.covector,
            parameters: self.gradient,
            miss,
            way,
            operations,
        }
    }
}

/// ‖v‖, of any size.
fn norm(vector: &[f64]) -> f64 {
    let size = vector.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    if size == 0.0 {
        return 0.0;
    }
    let squares = vector.iter().map(|v| (v / size) * (v / size));
    size * libm::sqrt(squares.sum())
}

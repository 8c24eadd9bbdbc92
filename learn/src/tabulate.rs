//! Many steps of a method as one map that has a generating function.
//!
//! Pairs (x, Φᴺ(x)) of N steps of any map over a tensor give Ŝ of the map of N steps, as those of one step do. Over a constant tensor Ŝ stands in
//! the middle of both states. It exists where 1 + DΦᴺ has an inverse: about an elliptic point it ends at half a turn, S = tan(T/2)(q² + p²). Over a
//! log-canonical tensor the same holds in ln x.

use std::sync::Arc;
use std::time::{Duration, Instant};

use leafwise_core::walk::side_by_side;
use leafwise_core::{PoissonSystem, RealizationData, StepMap, Walk};
use nalgebra::DMatrix;

use crate::basis::{Basis, FunctionFamily};
use crate::error::LearnError;
use crate::geometry::Geometry;
use crate::learn::{LearnOptions, TRIED_FUNCTIONS, checked, learn};
use crate::learned::Learned;
use crate::motion::walked;
use crate::pairs::StatePairs;

/// Equations for each coefficient, where no number of pairs is given.
const EQUATIONS: usize = 8;

/// The fewest pairs then.
const LEAST_PAIRS: usize = 100;

/// The most pairs.
const MOST_PAIRS: usize = 100_000;

/// States that no pair has, at which the table is measured.
const UNSEEN: usize = 200;

/// Of given states every fifth is measured at.
const HELD_OUT: usize = 5;

/// States that are stepped side by side where the time is measured, and how long at least.
const LANES: usize = 64;
const MEASURED: Duration = Duration::from_millis(40);

/// States at which the chart is looked at.
const MOST_CHECKED: usize = 64;

/// The chart ends where det(1 + DΦ) is this part of its value for no motion.
const SINGULAR: f64 = 1e-3;

/// Tensors that are constant to this part, in x or in ln x.
const SAME: f64 = 1e-12;

/// A table leaves at most this part of the motion.
const MOST_LEFT: f64 = 0.1;

/// States of a region.
type States = Vec<Vec<f64>>;

/// N steps of a method from some time on.
#[derive(Clone, Copy)]
pub struct ManySteps<'a> {
    /// One step.
    pub map: &'a dyn StepMap,
    /// Parameters of the map.
    pub parameters: &'a [f64],
    /// ε and h of one step.
    pub step: (f64, f64),
    /// N.
    pub count: u64,
    /// Coordinates that stand behind those of the table at the beginning of each: a time and its energy.
    pub beside: &'a [f64],
}

impl ManySteps<'_> {
    /// ε N h, the time of all.
    pub fn duration(&self) -> f64 {
        self.count as f64 * self.step.0 * self.step.1
    }

    /// The states N steps after these; `None` where a step fails.
    pub fn after(&self, states: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
        let extended: Vec<Vec<f64>> = states
            .iter()
            .map(|x| x.iter().chain(self.beside).copied().collect())
            .collect();
        let extended: Vec<&[f64]> = extended.iter().map(Vec::as_slice).collect();
        let found = walked(
            self.map,
            self.parameters,
            &extended,
            self.step,
            (1, self.count),
        );
        let own = found.into_iter().zip(states);
        own.map(|(orbit, x)| orbit.first().map(|end| end[..x.len()].to_vec()))
            .collect()
    }

    /// The seconds that all steps take for each state, side by side: the least of several.
    pub fn seconds(&self, states: &[Vec<f64>]) -> f64 {
        let states: Vec<Vec<f64>> = (states.iter().take(LANES))
            .map(|x| x.iter().chain(self.beside).copied().collect())
            .collect();
        if states.is_empty() {
            return 0.0;
        }
        let lanes = states.len();
        let values = vec![self.parameters.to_vec(); lanes];
        let (values, states) = (side_by_side(&values), side_by_side(&states));
        let (epsilon, h) = self.step;
        let mut walk = Walk::side_by_side(self.map, lanes, (&values, &states), epsilon, h);
        let begin = Instant::now();
        let mut least = f64::INFINITY;
        while begin.elapsed() < MEASURED || least.is_infinite() {
            walk.start_again(self.map, (&values, &states));
            let at = Instant::now();
            for _ in 0..self.count {
                // A lane that fails rests.
                let _ = walk.step();
            }
            least = least.min(at.elapsed().as_secs_f64() / lanes as f64);
        }
        least
    }

    /// The same time in other steps.
    pub fn in_steps(&self, count: u64) -> Self {
        let (epsilon, h) = self.step;
        Self {
            step: (epsilon, h * self.count as f64 / count as f64),
            count,
            ..*self
        }
    }
}

/// Where a table holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// All states between these bounds, least and largest of each variable.
    Box(Vec<(f64, f64)>),
    /// These states. Every fifth is no pair, and measures the table.
    States(Vec<Vec<f64>>),
}

/// A table of N steps, and how well it meets them.
pub struct Tabulated {
    /// Ŝ of N steps.
    pub learned: Learned,
    /// States that no pair has, and those N steps after them.
    pub unseen: Vec<(Vec<f64>, Vec<f64>)>,
    /// Root mean square of a coordinate of the table's step less the N steps, from these states.
    pub error: f64,
    /// The largest one.
    pub largest_error: f64,
    /// Of how many of these states the table has no step.
    pub failed: usize,
    /// States of the region from which the N steps fail: they are left out.
    pub without_steps: usize,
    /// The least |det(1 + DΦ)| in units of its value for no motion, where the tensor is constant or log-canonical.
    pub determinant: Option<f64>,
}

/// The map of many steps as one step with a generating function, over a region.
///
/// The Hamiltonian of the system is not looked at. No other is found, and Ŝ over the time of N steps stands in its place. The table has ε = 1.
///
/// # Errors
/// [`LearnError`] of [`learn`](fn@crate::learn), of a region that holds nothing, and where the chart ends within it.
pub fn tabulate(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    steps: &ManySteps<'_>,
    region: &Region,
    pairs: Option<usize>,
    options: &LearnOptions,
) -> Result<Tabulated, LearnError> {
    let d = system.dimension();
    if let Some(degree) = &options.degree {
        checked(degree, d)?;
    }
    let (states, unseen) = sampled(region, pairs, d, system.variables(), options)?;
    let (before, after) = walked_pairs(steps, &states);
    let unseen_pairs = walked_pairs(steps, &unseen);
    let without_steps = states.len() + unseen.len() - before.len() - unseen_pairs.0.len();
    if before.len() < states.len().div_ceil(2) || unseen_pairs.0.is_empty() {
        return Err(LearnError::NoSteps {
            failed: without_steps,
            states: states.len() + unseen.len(),
            steps: steps.count,
        });
    }
    let mut geometry = Geometry::new(system, realization.as_ref(), 1.0)?;
    let determinant = chart(&mut geometry, steps, &before)?;
    let table = StatePairs::new(d, &before.concat(), &after.concat(), None)?;
    let options = LearnOptions {
        finds_hamiltonian: false,
        ..options.clone()
    };
    let duration = steps.duration();
    let learned = learn(system, realization, (1.0, duration), &table, &options)?;
    let mut tabulated = Tabulated {
        learned,
        unseen: unseen_pairs.0.into_iter().zip(unseen_pairs.1).collect(),
        error: 0.0,
        largest_error: 0.0,
        failed: 0,
        without_steps,
        determinant,
    };
    let (mut sum, mut made) = (0.0, 0);
    let found = tabulated.steps();
    for (end, (_, exact)) in found.iter().zip(&tabulated.unseen) {
        let Some(end) = end else {
            tabulated.failed += 1;
            continue;
        };
        made += d;
        for (a, b) in end.iter().zip(exact) {
            sum += (a - b) * (a - b);
            tabulated.largest_error = tabulated.largest_error.max((a - b).abs());
        }
    }
    tabulated.error = libm::sqrt(sum / f64::from(made.max(1) as u32));
    let motion = tabulated.learned.motion;
    let is_bad = tabulated.error > MOST_LEFT * motion || tabulated.error.is_nan();
    if is_bad || tabulated.failed * HELD_OUT > tabulated.unseen.len() {
        return Err(LearnError::NoTable {
            steps: steps.count,
            degree: tabulated.learned.degree,
            part: tabulated.error / motion,
            failed: tabulated.failed,
            states: tabulated.unseen.len(),
        });
    }
    Ok(tabulated)
}

impl Tabulated {
    /// The table's steps from the unseen states.
    fn steps(&self) -> Vec<Option<Vec<f64>>> {
        let states: Vec<&[f64]> = self.unseen.iter().map(|(x, _)| x.as_slice()).collect();
        let own = &self.learned;
        let found = walked(
            own.method(),
            &own.parameters,
            &states,
            (own.epsilon, own.h),
            (1, 1),
        );
        let ends = found.into_iter().map(|orbit| orbit.into_iter().next());
        ends.collect()
    }
}

/// States with steps, and the states after these.
fn walked_pairs(steps: &ManySteps<'_>, states: &[Vec<f64>]) -> (States, States) {
    let ends = steps.after(states).into_iter().zip(states);
    ends.filter_map(|(end, x)| Some((x.clone(), end.filter(|end| is_finite(end))?)))
        .unzip()
}

fn is_finite(state: &[f64]) -> bool {
    state.iter().all(|x| x.is_finite())
}

/// States of pairs, and others between them.
fn sampled(
    region: &Region,
    pairs: Option<usize>,
    d: usize,
    names: &[String],
    options: &LearnOptions,
) -> Result<(States, States), LearnError> {
    let bounds = match region {
        Region::States(states) if states.len() < HELD_OUT => {
            return Err(LearnError::FewStates {
                states: states.len(),
                least: HELD_OUT,
            });
        }
        Region::States(states) => {
            let (unseen, seen): (Vec<_>, Vec<_>) = states
                .iter()
                .cloned()
                .enumerate()
                .partition(|(at, _)| at % HELD_OUT == HELD_OUT - 1);
            let of = |own: Vec<(usize, Vec<f64>)>| own.into_iter().map(|(_, x)| x).collect();
            return Ok((of(seen), of(unseen)));
        }
        Region::Box(bounds) => bounds,
    };
    for (i, &(least, largest)) in bounds.iter().enumerate() {
        if !(least.is_finite() && largest.is_finite() && least <= largest) {
            return Err(LearnError::Bounds {
                variable: names.get(i).cloned().unwrap_or_default(),
                least,
                largest,
            });
        }
    }
    if bounds.len() != d {
        return Err(LearnError::Degrees {
            found: bounds.len(),
            variables: d,
        });
    }
    let functions = match &options.degree {
        Some(degree) => Basis::new(&options.axes, bounds, degree)?.len(),
        None => TRIED_FUNCTIONS,
    };
    if pairs == Some(0) {
        return Err(LearnError::NoPairs);
    }
    let count = pairs.unwrap_or((EQUATIONS * functions).div_ceil(d).max(LEAST_PAIRS));
    if count > MOST_PAIRS {
        return Err(LearnError::TooManyPairs {
            pairs: count,
            most: MOST_PAIRS,
        });
    }
    let point = |at: usize, is_pair: bool| -> Vec<f64> {
        let parts = even(at, d).into_iter().zip(bounds).zip(&options.axes);
        parts
            .map(|((part, (least, largest)), axis)| {
                // Polynomials are least certain at both ends, so that more pairs stand there.
                let is_periodic = matches!(axis.family, FunctionFamily::Fourier { .. });
                let part = match is_pair && !is_periodic {
                    true => 0.5 - 0.5 * libm::cos(std::f64::consts::PI * part),
                    false => part,
                };
                least + (largest - least) * part
            })
            .collect()
    };
    Ok((
        (0..count).map(|at| point(at, true)).collect(),
        (count..count + UNSEEN).map(|at| point(at, false)).collect(),
    ))
}

/// The point k of an even sequence in the unit cube: multiples of φ⁻¹, …, φ⁻ᵈ with φᵈ⁺¹ = φ + 1.
fn even(k: usize, d: usize) -> Vec<f64> {
    let mut phi = 1.5_f64;
    for _ in 0..60 {
        phi = libm::pow(1.0 + phi, 1.0 / (d as f64 + 1.0));
    }
    (1..=d)
        .map(|i| (0.5 + (k + 1) as f64 * libm::pow(phi, -(i as f64))) % 1.0)
        .collect()
}

/// The least |det(1 + DΦ)|/2ᵈ over the states where the middle of both states is the chart.
fn chart(
    geometry: &mut Geometry,
    steps: &ManySteps<'_>,
    states: &[Vec<f64>],
) -> Result<Option<f64>, LearnError> {
    let Some(is_logarithmic) = straight(geometry, states) else {
        return Ok(None);
    };
    let every = states.len().div_ceil(MOST_CHECKED);
    let checked: Vec<&Vec<f64>> = states.iter().step_by(every).collect();
    let d = states[0].len();
    let width: Vec<f64> = (0..d)
        .map(|i| states.iter().fold(0.0_f64, |most, x| most.max(x[i].abs())))
        .collect();
    // Central differences: their error of 1e-10 is far below what is looked for.
    let by = |x: &[f64], i: usize| {
        1e-5 * if is_logarithmic {
            x[i]
        } else {
            width[i].max(1e-3)
        }
    };
    let mut moved = Vec::with_capacity(2 * d * checked.len());
    for x in &checked {
        for i in 0..d {
            for sign in [1.0, -1.0] {
                let mut other = x.to_vec();
                other[i] += sign * by(x, i);
                moved.push(other);
            }
        }
    }
    let ends = steps.after(&moved);
    let own = steps.after(&checked.iter().map(|x| x.to_vec()).collect::<Vec<_>>());
    let mut found: Vec<(f64, &Vec<f64>)> = Vec::new();
    for (at, x) in checked.iter().enumerate() {
        let mut slope = DMatrix::<f64>::identity(d, d);
        let mut is_known = true;
        for i in 0..d {
            let place = 2 * (at * d + i);
            let (Some(up), Some(down), Some(end)) = (&ends[place], &ends[place + 1], &own[at])
            else {
                is_known = false;
                continue;
            };
            for j in 0..d {
                let scale = if is_logarithmic { x[i] / end[j] } else { 1.0 };
                slope[(j, i)] += scale * (up[j] - down[j]) / (2.0 * by(x, i));
            }
        }
        if is_known {
            let value = slope.determinant() / libm::exp2(d as f64);
            found.push((value, x));
        }
    }
    let Some(&(least, x)) = found.iter().min_by(|a, b| a.0.abs().total_cmp(&b.0.abs())) else {
        return Ok(None);
    };
    let has_both = found.iter().any(|own| own.0 > 0.0) && found.iter().any(|own| own.0 < 0.0);
    match has_both || least.abs() < SINGULAR || least.is_nan() {
        true => Err(LearnError::ChartEnds {
            steps: steps.count,
            state: x.clone(),
            determinant: least,
        }),
        false => Ok(Some(least.abs())),
    }
}

/// Whether the tensor is constant in ln x; `None` where it is so in neither coordinates.
fn straight(geometry: &mut Geometry, states: &[Vec<f64>]) -> Option<bool> {
    let every = states.len().div_ceil(MOST_CHECKED);
    let mut is = [true, states.iter().flatten().all(|x| *x > 0.0)];
    let mut first: Option<[DMatrix<f64>; 2]> = None;
    for x in states.iter().step_by(every) {
        let own = geometry.tensor(x).ok()?.matrix;
        let relative = DMatrix::from_fn(x.len(), x.len(), |i, j| own[(i, j)] / (x[i] * x[j]));
        let own = [own, relative];
        let first = first.get_or_insert_with(|| own.clone());
        for (is, (own, first)) in is.iter_mut().zip(own.iter().zip(&*first)) {
            let largest = first.amax();
            *is &= (own - first).amax() <= SAME * largest;
        }
    }
    match is {
        [true, _] => Some(false),
        [_, true] => Some(true),
        _ => None,
    }
}

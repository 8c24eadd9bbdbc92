//! Sizes of coordinates, which their changes are measured by.

use leafwise_core::diagnostics::TensorDefect;
use leafwise_scene::compose::ComposedRun;
use nalgebra::DMatrix;

use super::motion::Motion;

/// The part of its natural size up to which a coordinate of no sign is round-off of 0.
const ZERO: f64 = 1e-9;

/// The part of the largest size from which a coordinate's own size is a measure of others.
const KNOWN: f64 = 1e-6;

/// The part of its neighbours' motion below which a state is at rest.
const AT_REST: f64 = 0.03;

/// The least size of each coordinate along a run.
///
/// The sites of a family have the largest size of all of them. A site at rest, far from a wave, moves by 1e-30 in a
/// step: no method has a digit of that, and no step is short enough. Variables whose names differ by a number alone, q1
/// and q2, share their largest size too, where they are 0 or of both signs along the run. What keeps one sign, such as
/// a population, has its own size at each state, however small that is.
///
/// A coordinate that is 0 along the run, as the radial momentum of a circular orbit is, has a natural size. It is the
/// least that moves another coordinate by its own size in one step, min_j s_j/|∂Φ_j/∂x_i|. Else its round-off would be
/// all of its motion.
pub(super) struct Sizes(Vec<f64>);

impl Sizes {
    /// Those along `states` of a run.
    pub fn of(run: &ComposedRun, states: &[Vec<f64>]) -> Self {
        let names = names(run);
        let has_a_sign =
            |at: usize| states.iter().all(|x| x[at] > 0.0) || states.iter().all(|x| x[at] < 0.0);
        let kinds: Vec<Option<&str>> = (names.iter().enumerate())
            .map(|(at, name)| match name.split_once('[') {
                Some((family, _)) => Some(family),
                None if has_a_sign(at) => None,
                None => Some(name.trim_end_matches(|c: char| c.is_ascii_digit())),
            })
            .collect();
        let largest_of = |at: usize| states.iter().map(|x| x[at].abs()).fold(0.0, f64::max);
        let largest = |kind: Option<&str>| {
            let alike = (0..kinds.len()).filter(|at| kinds[*at] == kind);
            kind.map_or(0.0, |_| alike.map(largest_of).fold(0.0, f64::max))
        };
        let least: Vec<f64> = kinds.iter().map(|kind| largest(*kind)).collect();
        let Some(tangent) = states.first().and_then(|x| tangent(run, x)) else {
            return Self(least);
        };
        // Where a sign is kept the size at each state counts, and that along the run is the measure of others.
        let along = (0..least.len()).map(|at| least[at].max(largest_of(at)));
        let natural = natural(&tangent, along.collect());
        let sizes = (least.iter().zip(natural).enumerate()).map(|(at, (least, natural))| {
            let is_zero = kinds[at].is_some() && *least <= ZERO * natural;
            if is_zero { natural } else { *least }
        });
        Self(sizes.collect())
    }

    /// Relative difference of two increments from x, a = `whole` and b = `finer`: (max_i |a_i − b_i|/s_i) / (max_i
    /// |b_i|/s_i). Here s_i is the largest of the least size of coordinate i, |x_i|, |x_i + a_i| and |x_i + b_i|. A
    /// numerator of 64 ε or less, round-off of a state, counts as 0.
    pub fn difference(&self, x: &[f64], whole: &[f64], finer: &[f64]) -> f64 {
        let sizes = self.at(x, whole, finer);
        let largest = |change: &dyn Fn(usize) -> f64| {
            let moving = (0..sizes.len()).filter(|at| sizes[*at] > 0.0);
            moving
                .map(|at| change(at).abs() / sizes[at])
                .fold(0.0, f64::max)
        };
        let apart = largest(&|at| whole[at] - finer[at]);
        // Round-off of a state is no motion.
        if apart > f64::EPSILON * 64.0 {
            apart / largest(&|at| finer[at])
        } else {
            0.0
        }
    }

    /// The same of the neighbours of x, by the tangents A and B of both motions: (max |A − B|_ij s_j/s_i) / (max |B −
    /// 1|_ij s_j/s_i). Returns `None` unless x itself is nearly at rest, where its motion tells nothing but an error.
    pub fn at_rest(
        &self,
        x: &[f64],
        [whole, finer]: [&[f64]; 2],
        [of_whole, of_finer]: [&DMatrix<f64>; 2],
    ) -> Option<f64> {
        let sizes = self.at(x, whole, finer);
        let largest = |matrix: &DMatrix<f64>| {
            let mut largest = 0.0_f64;
            for (i, row) in sizes.iter().enumerate().filter(|(_, size)| **size > 0.0) {
                for (j, column) in sizes.iter().enumerate() {
                    largest = largest.max(matrix[(i, j)].abs() * column / row);
                }
            }
            largest
        };
        let around = largest(&(of_finer - DMatrix::identity(sizes.len(), sizes.len())));
        let moving = finer.iter().zip(&sizes).filter(|(_, size)| **size > 0.0);
        let motion = moving.map(|(b, size)| b.abs() / size).fold(0.0, f64::max);
        (motion < AT_REST * around).then(|| largest(&(of_whole - of_finer)) / around)
    }

    /// s_i of two increments from x.
    fn at(&self, x: &[f64], whole: &[f64], finer: &[f64]) -> Vec<f64> {
        let increments = whole.iter().zip(finer);
        let states = self.0.iter().zip(x).zip(increments);
        states
            .map(|((least, x), (a, b))| least.max(x.abs()).max((x + a).abs()).max((x + b).abs()))
            .collect()
    }
}

/// D of one step from x, by differences where the map offers none.
fn tangent(run: &ComposedRun, x: &[f64]) -> Option<DMatrix<f64>> {
    let (map, plan) = (run.method.map(), &run.plan);
    let mut motion = Motion::new(run, map, x, 1);
    motion.advance().ok()?;
    // Of a long lattice the system is that of a short one.
    let is_whole = run.system.dimension() == x.len();
    motion.tangent(run, map).or_else(|| {
        if !is_whole {
            return None;
        }
        let parameters = run.system.parameter_values();
        let instrument = TensorDefect::new(&run.system, map, &parameters, plan.epsilon, plan.h);
        let defect = instrument.ok()?.measure_by_differences(x).ok()?;
        Some(DMatrix::from_row_slice(x.len(), x.len(), &defect.tangent))
    })
}

/// min_j s_j/|D_ji| for coordinates i too small to be a measure, from those j that are one, and then from these.
fn natural(tangent: &DMatrix<f64>, mut sizes: Vec<f64>) -> Vec<f64> {
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let mut known: Vec<bool> = sizes.iter().map(|size| *size > KNOWN * largest).collect();
    loop {
        let found: Vec<(usize, f64)> = (0..sizes.len())
            .filter(|i| !known[*i])
            .filter_map(|i| {
                let measures = (0..sizes.len()).filter(|j| known[*j] && tangent[(*j, i)] != 0.0);
                let natural = measures.map(|j| sizes[j] / tangent[(j, i)].abs());
                Some((i, natural.reduce(f64::min)?))
            })
            .collect();
        if found.is_empty() {
            return sizes;
        }
        for (i, natural) in found {
            known[i] = true;
            sizes[i] = sizes[i].max(natural);
        }
    }
}

/// The names of all coordinates that are stepped.
fn names(run: &ComposedRun) -> Vec<String> {
    match run.method.lattice() {
        Some(geometry) => (0..run.dimension()).map(|at| geometry.name(at)).collect(),
        None => run.system.variables().to_vec(),
    }
}

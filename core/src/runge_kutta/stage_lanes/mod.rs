//! Stage equations by fixed-point iteration, the stages side by side in the lanes of vectors.

use std::sync::Arc;

use leafwise_expression::vector::{Register, RegisterWork, run_on_registers};
use leafwise_expression::{Kernel, Workspace};

use super::smooth_map::SmoothMapEvaluator;
use super::tableau::Tableau;

#[cfg(test)]
mod tests;

/// Budget of one solve.
const MOST_EVALUATIONS: u64 = 60;

/// A stage is known where its correction is below this part of its coordinate.
const SETTLED: f64 = f64::EPSILON;

/// Corrections below this part that fall by less than [`SLOW`] twice are round-off.
const ROUND_OFF: f64 = 64.0 * SETTLED;

/// Corrections that fall by less on the average, from the first on, do not certify the solution. A map that contracts by 1/2
/// about z, where the step begins, has one fixed point near, and so has each that takes a part of the step: it is the one that
/// is connected with z.
const SLOW: f64 = 0.5;

/// Corrections sway by so much about their average fall.
const SWAY: f64 = 8.0;

/// A start that is off by more than this part of the way from z may lead to another solution.
const FAR: f64 = 0.5;

/// What a first correction from z may leave of the way to the stages: all of it where the iteration just contracts. For a
/// turn by an angle θ a step it is about θ/2.
const APART: f64 = 1.0;

/// Stages from which on they show how smooth the motion is over a step. Those of fewer say nothing of it: a step of theirs is
/// followed by parts, or left to another solver.
const SMOOTH: usize = 3;

/// Parts of a step that is followed from z are no shorter.
const LEAST_PART: f64 = 1.0 / 64.0;

/// What later corrections would add is forgotten below this part of a coordinate: 1/64 of a unit roundoff.
const NEGLIGIBLE: f64 = f64::EPSILON / 128.0;

/// A solve that ended.
pub(crate) struct FixedPoint {
    /// Evaluations of all stages.
    pub evaluations: u64,
    /// Whether corrections stopped to fall before they were negligible.
    pub is_rounded: bool,
}

/// A solve whose corrections did not fall by [`SLOW`].
pub(crate) struct Unsettled {
    /// Evaluations of all stages.
    pub evaluations: u64,
    /// The last correction, in units of the coordinates.
    pub correction: f64,
}

/// Where the stages of a solve begin.
#[derive(Clone, Copy, PartialEq)]
enum From {
    /// On the polynomial of the last step.
    Polynomial,
    /// At z.
    State,
    /// Where they stand.
    Standing,
}

/// Where a step begins.
#[derive(Clone, Copy)]
pub(crate) struct Start<'a> {
    /// z.
    pub point: &'a [f64],
    /// What corrections are measured against beside |Z_i − z|.
    pub sizes: &'a [f64],
    /// What F reads beside Z.
    pub beside: &'a [f64],
}

/// Solves Z_i = z + τ Σ_j a_ij F(Z_j) by Z_i ← z + τ Σ_j a_ij F(Z_j) for several trajectories, each by itself.
pub(crate) trait StageLanes: Send {
    /// Writes τ Σ_j b_j F(Z_j) for a trajectory's step from z. The stages start from the polynomial of its last step; where
    /// that does not lead to the solution that is connected with z, from z; and then by parts.
    ///
    /// # Errors
    /// [`Unsettled`] where there is none.
    fn solve(
        &mut self,
        at: usize,
        start: Start<'_>,
        change: &mut [f64],
    ) -> Result<FixedPoint, Unsettled>;
    /// Z_i − z of a trajectory's last solve, one stage after the other.
    fn displacements(&self, at: usize, out: &mut [f64]);
    /// Forgets a trajectory's earlier solves.
    fn clear(&mut self, at: usize);
    /// What a trajectory's next solve depends on; always of the same length.
    fn memory(&self, at: usize) -> Vec<f64>;
    /// Restores [`memory`](Self::memory).
    fn restore(&mut self, at: usize, memory: &[f64]);
    /// Operations of all solves so far.
    fn operations(&self) -> u64;
}

/// Solves of `count` trajectories with a Gauss method; none where F has no kernel. F reads Z, then what it reads beside. Where a
/// solution is not found at once it `follows` the step from z by parts, or leaves it to another solver.
pub(crate) fn stage_lanes(
    field: &SmoothMapEvaluator,
    tableau: &Tableau,
    time_step: f64,
    count: usize,
    follows: bool,
) -> Option<Box<dyn StageLanes>> {
    if tableau.stages() < SMOOTH && !follows {
        return None;
    }
    let shape = (field, tableau, time_step, count, follows);
    Some(match tableau.stages() {
        1 => Box::new(Lanes::<1>::new(shape)?),
        2 => Box::new(Lanes::<2>::new(shape)?),
        3..=4 => Box::new(Lanes::<4>::new(shape)?),
        5..=8 => Box::new(Lanes::<8>::new(shape)?),
        9..=16 => Box::new(Lanes::<16>::new(shape)?),
        _ => return None,
    })
}

/// W lanes, the first s of which are stages; the others stay at z.
struct Lanes<const W: usize> {
    kernel: Arc<Kernel>,
    workspace: Workspace,
    /// s.
    stages: usize,
    /// Column j over lanes i: τ a_ij, and τ ∫₁^{1+c_i} ℓ_j; 0 beyond s.
    matrix: Box<[[f64; W]; W]>,
    onward: Box<[[f64; W]; W]>,
    /// τ b_j.
    weights: [f64; W],
    /// F(Z_j) of each trajectory's last solve, a row a coordinate, and whether there was one.
    slopes: Vec<[f64; W]>,
    is_known: Vec<bool>,
    /// 1/(|z_c| + max_i |Z_i − z|_c), of the solve at hand.
    inverse_sizes: Vec<f64>,
    /// Whether a step is followed from z by parts where it is not found at once; A of the whole step then, and Z_i − z of a
    /// part, a row a coordinate.
    follows: bool,
    full: Box<[[f64; W]; W]>,
    ways: Vec<[f64; W]>,
    evaluations: u64,
    /// Operations of one evaluation and its sums.
    work: u64,
}

impl<const W: usize> Lanes<W> {
    fn new(
        (field, tableau, time_step, count, follows): (
            &SmoothMapEvaluator,
            &Tableau,
            f64,
            usize,
            bool,
        ),
    ) -> Option<Self> {
        let (s, n) = (tableau.stages(), field.map().outputs());
        let (kernel, workspace) = field.side_by_side(W)?;
        let columns = |matrix: &[f64]| -> Box<[[f64; W]; W]> {
            let mut columns = Box::new([[0.0; W]; W]);
            for (i, row) in matrix.chunks_exact(s).enumerate() {
                for (column, entry) in columns.iter_mut().zip(row) {
                    column[i] = time_step * entry;
                }
            }
            columns
        };
        let mut weights = [0.0; W];
        for (weight, b) in weights.iter_mut().zip(&tableau.weights) {
            *weight = time_step * b;
        }
        Some(Self {
            stages: s,
            matrix: columns(&tableau.matrix),
            full: columns(&tableau.matrix),
            ways: vec![[0.0; W]; if follows { n } else { 0 }],
            onward: columns(&Tableau::gauss_onward(s)),
            weights,
            slopes: vec![[0.0; W]; count * n],
            is_known: vec![false; count],
            inverse_sizes: vec![0.0; n],
            follows,
            evaluations: 0,
            work: s as u64 * kernel.step_operations().work() + (2 * s * s * n + 6 * s * n) as u64,
            kernel,
            workspace,
        })
    }
}

/// z + Σ_j m_j f_j over a register of lanes from the first on, in two sums that do not wait for one another.
///
/// Loops alone here and below: closures and iterators are compiled for the baseline where they are not inlined.
#[inline(always)]
fn add_sums<R: Register, const W: usize>(
    z: f64,
    columns: &[[f64; W]; W],
    slopes: &[f64; W],
    first: usize,
) -> R {
    let (mut even, mut odd) = (R::splat(0.0), R::splat(0.0));
    for j in 0..W {
        let (column, slope) = (R::load(&columns[j][first..]), R::splat(slopes[j]));
        match j % 2 {
            0 => even = column.times_plus(slope, even),
            _ => odd = column.times_plus(slope, odd),
        }
    }
    R::splat(z) + (even + odd)
}

/// The larger of two; a where one is no number.
#[inline(always)]
fn larger<R: Register>(a: R, b: R) -> R {
    R::select(a.less(b), b, a)
}

/// max over the lanes of what is a number.
#[inline(always)]
fn largest<const W: usize>(lanes: &[f64; W]) -> f64 {
    let mut most = *lanes;
    let mut count = W;
    while count > 1 {
        count /= 2;
        for lane in 0..count {
            let other = most[lane + count];
            most[lane] = if other > most[lane] {
                other
            } else {
                most[lane]
            };
        }
    }
    most[0]
}

/// The sum over the lanes, of halves first.
#[inline(always)]
fn sum<const W: usize>(lanes: &[f64; W]) -> f64 {
    let mut sums = *lanes;
    let mut count = W;
    while count > 1 {
        count /= 2;
        for lane in 0..count {
            sums[lane] += sums[lane + count];
        }
    }
    sums[0]
}

struct Solve<'own, const W: usize> {
    lanes: &'own mut Lanes<W>,
    at: usize,
    from: From,
    start: Start<'own>,
    change: &'own mut [f64],
    outcome: &'own mut Result<FixedPoint, Unsettled>,
}

impl<const W: usize> RegisterWork for Solve<'_, W> {
    #[inline(always)]
    fn run<R: Register>(self) {
        let Self {
            lanes,
            at,
            from,
            start,
            change,
            outcome,
        } = self;
        lanes.begin::<R>(at, from, start);
        let is_cold = from == From::State;
        // The last two corrections, how many as small as round-off did not fall, and what the next one may be.
        let [mut before, mut last] = [f64::NAN; 2];
        let mut stalled = 0;
        let mut most = f64::INFINITY;
        let mut evaluations = 0;
        let is_rounded = loop {
            evaluations += 1;
            lanes.kernel.evaluate_own_rows::<W>(&mut lanes.workspace);
            let is_measured = match evaluations {
                1 | 4 | 16 => true,
                2 | 3 => is_cold,
                _ => false,
            };
            let mut way = 0.0;
            let size = match is_measured {
                true => lanes.correct_measuring::<R>(start, &mut way),
                false => lanes.correct::<R>(start.point),
            };
            // With δ_k = r δ_{k−1} and r ≤ 1/2 the rest is δ_k r/(1 − r) ≤ 2 δ_k²/δ_{k−1}. Rates alternate where
            // eigenvalues are pairs.
            let is_negligible =
                size * size <= 0.5 * NEGLIGIBLE * last && size * last <= 0.5 * NEGLIGIBLE * before;
            if size <= SETTLED || is_negligible {
                break false;
            }
            // Round-off goes up and down.
            stalled += u32::from(size <= ROUND_OFF && size > SLOW * last);
            if stalled >= 2 || stalled == 1 && size <= 4.0 * SETTLED {
                break true;
            }
            let is_far = evaluations == 1 && !is_cold && size > FAR * way;
            if is_far || size > most || !size.is_finite() || evaluations == MOST_EVALUATIONS {
                *outcome = Err(Unsettled {
                    evaluations,
                    correction: size,
                });
                return;
            }
            most = match evaluations {
                1 => SWAY * SLOW * size,
                _ => SLOW * most,
            };
            [before, last] = [last, size];
        };
        evaluations += 1;
        let is_finite = lanes.end(at, change);
        let is_judged = from != From::Standing;
        let mut is_near = is_finite;
        if is_finite && is_judged {
            evaluations += 1;
            is_near = lanes.contracts::<R>(at, start);
        }
        *outcome = match is_near {
            true => Ok(FixedPoint {
                evaluations,
                is_rounded,
            }),
            false => Err(Unsettled {
                evaluations,
                correction: if is_finite { last } else { f64::NAN },
            }),
        };
    }
}

impl<const W: usize> Lanes<W> {
    /// Writes the stages that a solve begins at.
    #[inline(always)]
    fn begin<R: Register>(&mut self, at: usize, from: From, start: Start<'_>) {
        let (z, n) = (start.point, start.point.len());
        let slopes = &self.slopes[at * n..][..n];
        let (rows, _) = self.kernel.rows_mut::<W>(&mut self.workspace);
        let (stages, beside) = rows.split_at_mut(n);
        for c in 0..n {
            match from {
                From::Standing => continue,
                From::State => {
                    stages[c] = [z[c]; W];
                    continue;
                }
                From::Polynomial => {}
            }
            for first in (0..W).step_by(R::LANES) {
                let stage: R = add_sums(z[c], &self.onward, &slopes[c], first);
                stage.store(&mut stages[c][first..]);
            }
        }
        for c in 0..beside.len() {
            beside[c] = [start.beside[c]; W];
        }
    }

    /// Evaluates the slopes once more, keeps them and writes their sum; whether it is finite.
    #[inline(always)]
    fn end(&mut self, at: usize, change: &mut [f64]) -> bool {
        let n = change.len();
        let slopes = self.kernel.evaluate_own_rows::<W>(&mut self.workspace);
        let (slopes, own) = (&slopes[..n], &mut self.slopes[at * n..][..n]);
        let mut zero = 0.0;
        for c in 0..n {
            own[c] = slopes[c];
            let mut products = self.weights;
            for lane in 0..W {
                products[lane] *= slopes[c][lane];
            }
            change[c] = sum(&products);
            // 0·v is 0 where v is finite, and no number elsewhere.
            zero += 0.0 * change[c];
        }
        zero == 0.0
    }

    /// Whether a first correction from z would come some of the way to the stages that were found, as it does where the
    /// iteration contracts in between: |Σ_j a_ij (F(Z_j) − F(z))| is at most [`APART`] of |Z_i − z|.
    #[inline(always)]
    fn contracts<R: Register>(&mut self, at: usize, start: Start<'_>) -> bool {
        let n = start.point.len();
        let (rows, _) = self.kernel.rows_mut::<W>(&mut self.workspace);
        for c in 0..n {
            rows[c] = [start.point[c]; W];
        }
        let slopes = self.kernel.evaluate_own_rows::<W>(&mut self.workspace);
        let own = &self.slopes[at * n..][..n];
        let (mut way, mut rest) = (0.0, 0.0);
        for c in 0..n {
            // What rests and is driven has no way of its own.
            if start.sizes[c] == 0.0 && slopes[c][0] == 0.0 {
                continue;
            }
            let mut beyond = own[c];
            for lane in 0..W {
                beyond[lane] -= slopes[c][0];
            }
            let (mut ways, mut rests) = ([0.0; W], [0.0; W]);
            for first in (0..W).step_by(R::LANES) {
                let of_all: R = add_sums(0.0, &self.matrix, &own[c], first);
                let of_rest: R = add_sums(0.0, &self.matrix, &beyond, first);
                of_all.abs().store(&mut ways[first..]);
                of_rest.abs().store(&mut rests[first..]);
            }
            let [own_way, own_rest] = [&ways, &rests].map(|v| largest(v) * self.inverse_sizes[c]);
            way = if own_way > way { own_way } else { way };
            rest = if own_rest > rest { own_rest } else { rest };
        }
        rest <= APART * way
    }

    /// One correction; returns its largest component in units of its coordinate.
    #[inline(always)]
    fn correct<R: Register>(&mut self, start: &[f64]) -> f64 {
        let (stages, slopes) = self.kernel.rows_mut::<W>(&mut self.workspace);
        let mut most = [0.0; W];
        let n = start.len();
        let (stages, slopes, inverse) = (&mut stages[..n], &slopes[..n], &self.inverse_sizes[..n]);
        for first in (0..W).step_by(R::LANES) {
            let mut size = R::splat(0.0);
            for c in 0..n {
                let next: R = add_sums(start[c], &self.matrix, &slopes[c], first);
                let correction = next - R::load(&stages[c][first..]);
                size = larger(size, correction.abs() * R::splat(inverse[c]));
                next.store(&mut stages[c][first..]);
            }
            size.store(&mut most[first..]);
        }
        largest(&most)
    }

    /// The same, and measures the coordinates anew; `whole` is the largest way from z, in the same units.
    #[inline(always)]
    fn correct_measuring<R: Register>(&mut self, start: Start<'_>, whole: &mut f64) -> f64 {
        let (stages, slopes) = self.kernel.rows_mut::<W>(&mut self.workspace);
        let mut most = 0.0;
        let n = start.point.len();
        let (stages, slopes) = (&mut stages[..n], &slopes[..n]);
        let inverse = &mut self.inverse_sizes[..n];
        for c in 0..n {
            let (z, before) = (start.point[c], stages[c]);
            let (mut way, mut correction) = ([0.0; W], [0.0; W]);
            for first in (0..W).step_by(R::LANES) {
                let next: R = add_sums(z, &self.matrix, &slopes[c], first);
                (next - R::splat(z)).abs().store(&mut way[first..]);
                (next - R::load(&before[first..]))
                    .abs()
                    .store(&mut correction[first..]);
                next.store(&mut stages[c][first..]);
            }
            let way = largest(&way);
            inverse[c] = 1.0 / (start.sizes[c].abs() + way + f64::MIN_POSITIVE);
            let way = way * inverse[c];
            *whole = if way > *whole { way } else { *whole };
            let correction = largest(&correction) * inverse[c];
            most = if correction > most { correction } else { most };
        }
        most
    }

    /// [`StageLanes::solve`], each attempt by `run`.
    fn solve_by(
        &mut self,
        at: usize,
        start: Start<'_>,
        change: &mut [f64],
        run: impl Fn(Solve<'_, W>),
    ) -> Result<FixedPoint, Unsettled> {
        let mut spent = 0;
        let mut attempt = |lanes: &mut Self, from: From| {
            let mut outcome = Err(Unsettled {
                evaluations: 0,
                correction: f64::NAN,
            });
            run(Solve {
                lanes,
                at,
                from,
                start,
                change,
                outcome: &mut outcome,
            });
            let evaluations = match &mut outcome {
                Ok(solved) => &mut solved.evaluations,
                Err(unsettled) => &mut unsettled.evaluations,
            };
            spent += *evaluations;
            *evaluations = spent;
            outcome
        };
        let mut outcome = Err(Unsettled {
            evaluations: 0,
            correction: f64::NAN,
        });
        if self.is_known[at] && self.stages >= SMOOTH {
            outcome = attempt(self, From::Polynomial);
        }
        if outcome.is_err() && self.stages >= SMOOTH {
            outcome = attempt(self, From::State);
        }
        if outcome.is_err() && self.follows {
            outcome = self.follow(at, start.point, attempt);
        }
        self.is_known[at] = outcome.is_ok();
        self.evaluations += spent;
        outcome
    }

    /// The solutions of parts s of the step from s = 0 to 1, each from the one before: s is at first a quarter, and halved where a
    /// part is too far from the last.
    #[cold]
    fn follow(
        &mut self,
        at: usize,
        z: &[f64],
        mut attempt: impl FnMut(&mut Self, From) -> Result<FixedPoint, Unsettled>,
    ) -> Result<FixedPoint, Unsettled> {
        let (mut done, mut part) = (0.0, 0.25);
        let outcome = loop {
            let to = if done + part > 1.0 { 1.0 } else { done + part };
            for (own, full) in self.matrix.iter_mut().zip(&*self.full) {
                *own = full.map(|entry| to * entry);
            }
            if done > 0.0 {
                // Where the last part has come to, farther in proportion.
                let (stages, _) = self.kernel.rows_mut::<W>(&mut self.workspace);
                for ((stage, kept), z) in stages.iter_mut().zip(&self.ways).zip(z) {
                    *stage = kept.map(|way| z + to / done * way);
                }
            }
            let from = if done > 0.0 {
                From::Standing
            } else {
                From::State
            };
            let outcome = attempt(self, from);
            if outcome.is_ok() {
                if to == 1.0 {
                    break outcome;
                }
                done = to;
                let slopes = &self.slopes[at * z.len()..][..z.len()];
                for (kept, slopes) in self.ways.iter_mut().zip(slopes) {
                    *kept = [0.0; W];
                    for (column, slope) in self.matrix.iter().zip(slopes) {
                        for (way, entry) in kept.iter_mut().zip(column) {
                            *way += entry * slope;
                        }
                    }
                }
                continue;
            }
            part *= 0.5;
            if part < LEAST_PART {
                break outcome;
            }
        };
        self.matrix.copy_from_slice(&*self.full);
        outcome
    }
}

impl<const W: usize> StageLanes for Lanes<W> {
    fn solve(
        &mut self,
        at: usize,
        start: Start<'_>,
        change: &mut [f64],
    ) -> Result<FixedPoint, Unsettled> {
        self.solve_by(at, start, change, |solve| run_on_registers(W, solve))
    }

    fn displacements(&self, at: usize, out: &mut [f64]) {
        let n = self.inverse_sizes.len();
        for (c, slopes) in self.slopes[at * n..][..n].iter().enumerate() {
            for (lane, stage) in out.chunks_exact_mut(n).enumerate() {
                let columns = self.matrix.iter().zip(slopes);
                stage[c] = columns.map(|(column, slope)| column[lane] * slope).sum();
            }
        }
    }

    fn clear(&mut self, at: usize) {
        self.is_known[at] = false;
    }

    fn memory(&self, at: usize) -> Vec<f64> {
        let (n, s) = (self.inverse_sizes.len(), self.stages);
        let is_known = f64::from(u8::from(self.is_known[at]));
        let slopes = self.slopes[at * n..][..n].iter();
        let slopes = slopes.flat_map(|row| row[..s].iter().copied());
        std::iter::once(is_known).chain(slopes).collect()
    }

    fn restore(&mut self, at: usize, memory: &[f64]) {
        let (n, s) = (self.inverse_sizes.len(), self.stages);
        self.is_known[at] = memory[0] != 0.0;
        let rows = self.slopes[at * n..][..n].iter_mut();
        for (row, kept) in rows.zip(memory[1..].chunks_exact(s)) {
            row[..s].copy_from_slice(kept);
        }
    }

    fn operations(&self) -> u64 {
        self.evaluations * self.work
    }
}

//! W trajectories side by side.

mod at_once;
mod lane;
mod masks;
mod repeat;
mod scales;
mod settle;
mod trajectories;

pub(super) use trajectories::{Columns, LaneBlock, lane_block};

use leafwise_expression::{Kernel, Workspace, kernel::apart};

use self::at_once::AtOnce;
use self::lane::Lane;
use self::masks::{
    Row, add_where, any, guard_ratio, is_inside, keep, ratio_in_own_units, select, take_guard,
};
use super::convergence::Next;
use super::kernel::NewtonKernel;
use super::start::Start;
use crate::Branch;
use crate::elimination::{Factors, Rows, dimension};
use crate::error::StepError;
use crate::judge::{WANDERING, at_least, inside_chart, larger, relative};

/// Evaluations of one step. A smooth orbit takes 1 to 4, a cold start at a large step a dozen, one at a
/// thousand times the size of a chart fifty.
const MOST_EVALUATIONS: u32 = 100;

/// Part of its earlier size below which a component makes its Jacobian too old: a new one is taken.
///
/// In a Lotka–Volterra system a row of the Jacobian is proportional to its component. An old row, of a component that was
/// larger, adds the round-off of the other components in proportion to that larger size.
const HALVED: f64 = 0.5;

/// A component that moves by less than this part of its scale is noise, not smaller.
const NOISE: f64 = 1e-6;

/// W trajectories, each with its own history and its own stop; what one computes does not depend on
/// the others. Vectors are rows of W numbers, one row a coordinate.
///
/// D is the dimension, or `ANY`; vectors (`V`, d rows) and matrices (`M`, d² rows) stand in the block
/// itself where it is known, so that they stay in registers.
pub(super) struct Block<const W: usize, const D: usize, V, M> {
    kernel: NewtonKernel,
    parameters: Vec<f64>,
    epsilon: f64,
    h: f64,
    dimension: usize,
    most_chords: u32,
    full: Workspace,
    residual: Workspace,
    /// The full kernel's for half the step, made when a solution is first followed.
    halved: Option<Workspace>,
    x: V,
    low: V,
    increment: V,
    y: V,
    correction: V,
    /// Where the Jacobians were taken; the factors of D(β̂∘L), |D(β̂∘L) − 1| and D((α̂ − β̂)∘L) there.
    anchor: V,
    factors: Factors<W, M>,
    slope: M,
    change: M,
    /// Scale that a correction of each component is judged against.
    scale: V,
    /// How much of each component's change serves as a scale, and the smallest change of an iterate.
    allowed: V,
    smallest: V,
    /// Σ_j |D − 1|_ij |y_j|: the size that the others put into a component.
    reached: V,
    /// The largest entries of the guard's two sides where the maps were last evaluated.
    guard: [Row<W>; 2],
    start: Start<W>,
    /// Of a lane alone.
    at_once: Option<Box<AtOnce>>,
    lanes: [Lane; W],
    outcome: [Result<(), StepError>; W],
    /// Room for the path to a lane's solution, and its start.
    branch: Branch,
    from: Vec<f64>,
    found: Vec<f64>,
}

impl<const W: usize, const D: usize, V: Rows<W>, M: Rows<W>> Block<W, D, V, M> {
    /// `parameters` is a structure of arrays over the W lanes.
    fn new(kernel: &NewtonKernel, parameters: &[f64], epsilon: f64, h: f64) -> Self {
        let d = kernel.dimension;
        let mut own = Self {
            parameters: parameters.to_vec(),
            epsilon,
            h,
            dimension: d,
            most_chords: kernel.most_chords(),
            full: kernel.full.workspace(W),
            residual: kernel.residual.workspace(W),
            halved: None,
            kernel: kernel.clone(),
            x: V::zeros(d),
            low: V::zeros(d),
            increment: V::zeros(d),
            y: V::zeros(d),
            correction: V::zeros(d),
            anchor: V::zeros(d),
            factors: Factors::new(d),
            slope: M::zeros(d * d),
            change: M::zeros(d * d),
            scale: V::zeros(d),
            allowed: V::zeros(d),
            smallest: V::zeros(d),
            reached: V::zeros(d),
            guard: [[0.0; W]; 2],
            start: Start::new(kernel.start.as_ref(), d),
            at_once: (W == 1).then(|| AtOnce::new(kernel)).flatten(),
            lanes: [Lane::NEW; W],
            outcome: [const { Ok(()) }; W],
            branch: Branch::new(d),
            from: vec![0.0; d],
            found: vec![0.0; d],
        };
        own.prepare();
        own
    }

    /// Runs the coefficient kernels; returns whether a coefficient has changed.
    fn prepare(&mut self) -> bool {
        let (parameters, sizes) = (&self.parameters, ([self.epsilon; W], [self.h; W]));
        let prepare = |kernel: &Kernel, workspace: &mut Workspace| {
            kernel.prepare(workspace, parameters, &sizes.0, &sizes.1)
        };
        let NewtonKernel { full, residual, .. } = &self.kernel;
        let mut changes = prepare(full, &mut self.full);
        residual.prepare_from(&mut self.residual, &[(full, &self.full)]);
        if let Some(workspace) = &mut self.halved {
            let half = [0.5 * self.h; W];
            full.prepare(workspace, parameters, &sizes.0, &half);
        }
        if let Start::Series {
            kernel, workspace, ..
        } = &mut self.start
        {
            changes |= prepare(kernel, workspace);
            if let Some(own) = &mut self.at_once {
                own.prepare([
                    (kernel, workspace),
                    (full, &self.full),
                    (residual, &self.residual),
                ]);
            }
        }
        changes
    }

    /// The increments of the step from x + low.
    fn step(&mut self) {
        let mut y = self.y.take();
        self.start(y.as_mut());
        self.iterate(y.as_mut());
        self.y = y;
        self.watch_starts();
        for w in 0..W {
            if self.lanes[w].watch.wanders() || self.outcome[w].is_err() {
                self.settle(w);
            }
        }
        self.finish();
    }

    /// Looks whether the starts foresaw the solutions: plain where they were off by next to nothing.
    #[inline(always)]
    fn watch_starts(&mut self) {
        if (self.lanes.iter()).all(|lane| lane.convergence.first <= WANDERING) {
            return;
        }
        let d = dimension::<D>(self.dimension);
        let (x, y) = (&self.x.as_ref()[..d], &self.y.as_ref()[..d]);
        let scale = &self.scale.as_ref()[..d];
        let mut way = [0.0_f64; W];
        for i in 0..d {
            for w in 0..W {
                way[w] = larger(way[w], relative(y[i][w] - x[i][w], scale[i][w]));
            }
        }
        for (lane, way) in self.lanes.iter_mut().zip(way) {
            lane.watch.take_start(lane.convergence.first, way);
        }
    }

    /// Until every lane is done.
    #[inline(always)]
    fn iterate(&mut self, y: &mut [Row<W>]) {
        loop {
            // Of a lane alone it is known when this is compiled who asks.
            if W == 1 {
                match self.lanes[0].next {
                    Next::Newton => self.approach(y, &[true; W], &[false; W]),
                    Next::Chord => self.approach(y, &[false; W], &[true; W]),
                    Next::Done => break,
                }
                continue;
            }
            let newton = std::array::from_fn(|w| self.lanes[w].next == Next::Newton);
            let chord = std::array::from_fn(|w| self.lanes[w].next == Next::Chord);
            if !any(&newton) && !any(&chord) {
                break;
            }
            self.approach(y, &newton, &chord);
        }
    }

    /// A correction in the lanes of `newton`, with new Jacobians, and of `chord`.
    #[inline(always)]
    fn approach(&mut self, y: &mut [Row<W>], newton: &[bool; W], chord: &[bool; W]) {
        let (mut residual, mut increment) = (self.correction.take(), self.increment.take());
        let ends = [residual.as_mut(), increment.as_mut()];
        if any(newton) {
            self.evaluate_full(y, ends, newton);
        }
        let ends = [residual.as_mut(), increment.as_mut()];
        if any(chord) {
            self.evaluate_residual(y, ends, chord);
        }
        let active = std::array::from_fn(|w| newton[w] || chord[w]);
        let mut correction = residual;
        self.correct(y, correction.as_mut(), increment.as_ref(), &active);
        self.judge(y, correction.as_ref(), increment.as_mut(), newton, &active);
        (self.correction, self.increment) = (correction, increment);
    }

    /// The predicted solutions, and the kernel that each lane evaluates there.
    #[inline(always)]
    fn start(&mut self, y: &mut [Row<W>]) {
        let d = dimension::<D>(self.dimension);
        let (x, y) = (&self.x.as_ref()[..d], &mut y[..d]);
        let mut displacement = self.correction.take();
        let correction = &mut displacement.as_mut()[..d];
        self.start.predict::<D>(x, correction);
        let (anchor, scale) = (&self.anchor.as_ref()[..d], &self.scale.as_ref()[..d]);
        let mut distance = [0.0_f64; W];
        let mut outgrown = [false; W];
        let (allowed, smallest) = (
            &mut self.allowed.as_mut()[..d],
            &mut self.smallest.as_mut()[..d],
        );
        for i in 0..d {
            for w in 0..W {
                y[i][w] = x[i][w] + correction[i][w];
                allowed[i][w] = x[i][w].abs() + correction[i][w].abs();
                smallest[i][w] = f64::INFINITY;
                let (y, anchor, scale) = (y[i][w], anchor[i][w], scale[i][w]);
                let away = (y - anchor).abs();
                distance[w] = larger(distance[w], relative(away, scale));
                outgrown[w] |= y.abs() < HALVED * anchor.abs() && away > NOISE * scale;
            }
        }
        self.correction = displacement;
        for (w, lane) in self.lanes.iter_mut().enumerate() {
            let distance = (lane.anchored && !outgrown[w]).then_some(distance[w]);
            lane.next = lane.convergence.start(distance, self.most_chords);
            lane.jacobians = 0;
            lane.is_astray = false;
            lane.watch.begin();
            lane.watch
                .take(lane.next == Next::Chord && lane.is_anchor_far);
            if self.outcome[w].is_err() {
                self.outcome[w] = Ok(());
            }
        }
    }

    /// Evaluates the residual kernel at y: −(β̂ − x) and the increment in the lanes of `chord`.
    #[inline(always)]
    fn evaluate_residual(&mut self, y: &[Row<W>], ends: [&mut [Row<W>]; 2], chord: &[bool; W]) {
        let d = dimension::<D>(self.dimension);
        let rows = self.kernel.residual.evaluate_rows(&mut self.residual, y);
        let (base, rows) = rows.split_at(self.kernel.bases);
        let base = if base.is_empty() { y } else { base };
        let (own, guard) = rows.split_at(2 * d);
        take_ends::<W, D>(
            [self.x.as_ref(), self.low.as_ref()],
            [base, own],
            ends,
            chord,
        );
        if !guard.is_empty() {
            take_guard(chord, &mut self.guard, guard);
        }
    }

    /// The same of the full kernel in the lanes of `newton`, whose Jacobians are kept.
    #[inline(always)]
    fn evaluate_full(&mut self, y: &[Row<W>], ends: [&mut [Row<W>]; 2], newton: &[bool; W]) {
        let d = dimension::<D>(self.dimension);
        let rows = self.kernel.full.evaluate_rows(&mut self.full, y);
        let (base, rows) = rows.split_at(self.kernel.bases);
        let base = if base.is_empty() { y } else { base };
        let (own, rows) = rows.split_at(2 * d);
        let (target, rows) = rows.split_at(d * d);
        let (change, guard) = rows.split_at(d * d);
        take_ends::<W, D>(
            [self.x.as_ref(), self.low.as_ref()],
            [base, own],
            ends,
            newton,
        );
        keep(newton, &mut self.anchor.as_mut()[..d], y);
        keep(newton, &mut self.change.as_mut()[..d * d], change);
        let slope = &mut self.slope.as_mut()[..d * d];
        for i in 0..d {
            for j in 0..d {
                let unit = if i == j { 1.0 } else { 0.0 };
                let entry = target[i * d + j].map(|entry| (entry - unit).abs());
                select(newton, &mut slope[i * d + j], &entry);
            }
        }
        if !guard.is_empty() {
            take_guard(newton, &mut self.guard, guard);
        }
        let singular = self.factors.factor::<D>(target, y, newton);
        for w in 0..W {
            if newton[w] {
                let lane = &mut self.lanes[w];
                lane.jacobians += 1;
                lane.anchored = !singular[w];
                lane.is_anchor_far = !self.factors.is_near_identity(w);
                lane.watch.take(lane.is_anchor_far);
            }
        }
    }

    /// Decides lane by lane, applies the corrections, and completes the increments that are done.
    #[inline(always)]
    fn judge(
        &mut self,
        y: &mut [Row<W>],
        correction: &[Row<W>],
        increment: &mut [Row<W>],
        newton: &[bool; W],
        active: &[bool; W],
    ) {
        let d = dimension::<D>(self.dimension);
        let (correction, increment) = (&correction[..d], &mut increment[..d]);
        let scale = &self.scale.as_ref()[..d];
        let mut size = [0.0_f64; W];
        // 0·v is 0 where v is finite, and no number elsewhere.
        let mut zero = [0.0_f64; W];
        for i in 0..d {
            for w in 0..W {
                size[w] = at_least(size[w], relative(correction[i][w], scale[i][w]));
                zero[w] += 0.0 * correction[i][w];
            }
        }
        for w in 0..W {
            size[w] += zero[w];
        }
        let (mut done, mut applied) = ([false; W], [false; W]);
        for w in 0..W {
            if active[w] {
                let next = self.judge_lane(w, y, correction, size[w], newton[w]);
                self.lanes[w].next = next.unwrap_or_else(|error| {
                    self.outcome[w] = Err(error);
                    Next::Done
                });
                applied[w] = size[w].is_finite();
                done[w] = self.lanes[w].next == Next::Done;
            }
        }
        add_where(&applied, &mut y[..d], correction);
        if done.contains(&true) {
            // The last correction enters to first order.
            let change = &self.change.as_ref()[..d * d];
            for i in 0..d {
                let mut first_order: Row<W> =
                    std::array::from_fn(|w| change[i * d][w] * correction[0][w]);
                for j in 1..d {
                    for w in 0..W {
                        first_order[w] += change[i * d + j][w] * correction[j][w];
                    }
                }
                for w in 0..W {
                    increment[i][w] += if done[w] { first_order[w] } else { 0.0 };
                }
            }
        }
    }

    /// Judges a lane's correction: returns its next evaluation, or why its solve fails.
    #[inline(always)]
    fn judge_lane(
        &mut self,
        w: usize,
        y: &[Row<W>],
        correction: &[Row<W>],
        size: f64,
        is_newton: bool,
    ) -> Result<Next, StepError> {
        let d = dimension::<D>(self.dimension);
        let (scale, slope) = (&self.scale.as_ref()[..d], &self.slope.as_ref()[..d * d]);
        let rows = [correction, scale, slope];
        let (room, lane) = ([&mut self.from, &mut self.found], &mut self.lanes[w]);
        let [reached, next] = room;
        // One that moves at a high order in the step need not halve beside a whole that hardly moves.
        let as_a_whole = || {
            let largest = |rows: &[Row<W>]| rows.iter().fold(0.0_f64, |m, row| m.max(row[w].abs()));
            largest(correction) / largest(scale)
        };
        if size >= 0.5 * lane.convergence.last && size > WANDERING && as_a_whole() > WANDERING {
            lane.watch.take(true);
        }
        let norm = || Self::size_in_all(rows, w, [reached, next]);
        let next = if size.is_finite() && lane.anchored {
            lane.convergence
                .judge(size, norm, is_newton, self.most_chords)
        } else if is_newton {
            lane.convergence.evaluations += 1;
            // An iterate outside the chart has no value: the guard tells the cause.
            lane.is_astray = true;
            return Err(match guard_ratio(&self.guard, w) {
                ratio if (1.0..f64::INFINITY).contains(&ratio) => StepError::LeftChart { ratio },
                _ => StepError::NonFinite {
                    what: "a Newton correction",
                },
            });
        } else {
            lane.convergence.evaluations += 1;
            Next::Newton
        };
        let evaluations = lane.convergence.evaluations;
        match next {
            Next::Done if is_inside(&self.guard, w) || self.decays_in_own_units(y, w) => {
                Ok(Next::Done)
            }
            Next::Done => inside_chart(guard_ratio(&self.guard, w)).map(|()| Next::Done),
            Next::Newton | Next::Chord if evaluations >= MOST_EVALUATIONS => {
                Err(StepError::NoConvergence {
                    evaluations: MOST_EVALUATIONS as usize,
                    correction: size,
                })
            }
            next => Ok(next),
        }
    }

    /// Whether a lane's guard is of a series that decays at y where each coordinate is compared in units of its own.
    #[cold]
    fn decays_in_own_units(&mut self, y: &[Row<W>], w: usize) -> bool {
        let d = dimension::<D>(self.dimension);
        if !self.kernel.guards_series {
            return false;
        }
        let rows = self.kernel.residual.evaluate_rows(&mut self.residual, y);
        let guard = &rows[self.kernel.bases + 2 * d..];
        guard.len() == 2 * d && ratio_in_own_units(&self.x.as_ref()[..d], guard, w) < 1.0
    }

    /// Records the steps that were taken; a lane that failed forgets its history.
    #[inline(always)]
    fn finish(&mut self) {
        let d = dimension::<D>(self.dimension);
        let increment = &self.increment.as_ref()[..d];
        // 0·v is 0 where v is finite, and no number elsewhere.
        let mut zero = [0.0; W];
        for row in increment {
            for w in 0..W {
                zero[w] += 0.0 * row[w];
            }
        }
        let mut took = [true; W];
        for w in 0..W {
            if self.outcome[w].is_ok() && zero[w].is_nan() {
                self.outcome[w] = Err(StepError::OF_INCREMENT);
            }
            if self.outcome[w].is_err() {
                took[w] = false;
                let increment = self.increment.as_mut().iter_mut();
                increment.for_each(|row| row[w] = 0.0);
                self.forget(w);
            }
        }
        let (x, y) = (&self.x.as_ref()[..d], &self.y.as_ref()[..d]);
        self.start
            .record::<D>(x, y, &mut self.correction.as_mut()[..d], &took);
        if self.kernel.at_once.is_some() {
            // The next step begins with a Jacobian of its own.
            self.lanes.iter_mut().for_each(|lane| lane.anchored = false);
        }
        if let Some(own) = &mut self.at_once {
            own.learn(&self.lanes[0], self.outcome[0].is_ok());
        }
    }
}

/// −(β̂ − x) and the increment from base, or y in its place, and the other ends, in the lanes of `mask`.
#[inline(always)]
fn take_ends<const W: usize, const D: usize>(
    [x, low]: [&[Row<W>]; 2],
    [base, ends]: [&[Row<W>]; 2],
    [residual, increment]: [&mut [Row<W>]; 2],
    mask: &[bool; W],
) {
    let d = dimension::<D>(x.len());
    let (x, low, base) = (&x[..d], &low[..d], &base[..d]);
    let (offset, change) = ends.split_at(d);
    for i in 0..d {
        // (base − x) + (β̂ − base) − low: base and x are close, their difference is exact.
        let own = std::array::from_fn(|w| x[i][w] - base[i][w] - offset[i][w] + low[i][w]);
        select(mask, &mut residual[i], &own);
        select(mask, &mut increment[i], &change[i]);
        apart::<W>();
    }
}

//! The solve for parts that compute numbers: no code, several trajectories in lockstep where both parts
//! serve that.
//!
//! - [`evaluation`]: both maps and their tangents at the points of all that iterate.
//! - [`solve`]: the equation of one trajectory, between the evaluations that it asks for.

mod evaluation;
mod solve;

use evaluation::Evaluation;
use solve::{Means, Progress, Solve};

use super::{Lockstep, Taken};
use crate::dynamics::{BisectionWorker, Correction};
use crate::realization::RealizationWorker;

/// Solves β̂(L(y)) = x with workers of a realization and a bisection.
///
/// Where D(β̂∘L) is near the identity (a collective integrator over a good realization), and where a
/// worker offers no tangents, the correction is the residual itself; elsewhere it is Newton's, with
/// the tangents of both workers. D(β̂∘L) = 1 + O(εh), so that residuals converge for small steps.
pub(crate) struct Workers {
    evaluation: Evaluation,
    correction: Correction,
    means: Means,
    dimension: usize,
    trajectories: Vec<Solve>,
    /// Those that iterate, in the order of the evaluation's points.
    active: Vec<usize>,
    /// D(β̂∘L) and D((α̂−β̂)∘L) of one of them.
    target: Vec<f64>,
    change: Vec<f64>,
}

impl Workers {
    /// For `count` trajectories in M of `dimension` d, by points of S of `space` coordinates: of several
    /// by workers that offer batches.
    pub(crate) fn new(
        (realization, bisection): (Box<dyn RealizationWorker>, Box<dyn BisectionWorker>),
        (dimension, space): (usize, usize),
        correction: Correction,
        count: usize,
    ) -> Self {
        let d = dimension;
        let has_tangents = realization.has_tangents() && bisection.has_tangent();
        let means = match (bisection.is_near_identity(), has_tangents) {
            (true, _) => Means::Residuals,
            (false, true) => Means::Newton,
            (false, false) => Means::Acceleration,
        };
        Self {
            evaluation: Evaluation::new((realization, bisection), (d, space), count),
            correction,
            means,
            dimension,
            trajectories: (0..count).map(|_| Solve::new(d)).collect(),
            active: Vec::with_capacity(count),
            target: vec![0.0; d * d],
            change: vec![0.0; d * d],
        }
    }

    /// One round of evaluations, after which some no longer iterate.
    fn advance(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [Taken]) {
        let d = self.dimension;
        for (place, at) in self.active.iter().enumerate() {
            self.evaluation.place(place, &self.trajectories[*at].y);
            taken[*at].evaluations += u64::from(!self.trajectories[*at].is_last);
        }
        let newton = self.means == Means::Newton;
        self.evaluation.evaluate(&mut self.active, taken, newton);
        let mut place = 0;
        self.active.retain(|&at| {
            let (own, taken) = (&mut self.trajectories[at], &mut taken[at]);
            let (from, to) = (at * d, (at + 1) * d);
            let (x, low, increment) = (&x[from..to], &low[from..to], &mut increment[from..to]);
            let ends = self.evaluation.ends(place);
            if newton {
                let (target, change) = (&mut self.target, &mut self.change);
                own.linear += self.evaluation.tangents(place, target, change);
            }
            place += 1;
            match own.take(self.means, (x, low), ends, &self.target) {
                Ok(Progress::Iterates) => true,
                Ok(Progress::Solved) => {
                    taken.evaluations += u64::from(own.is_last);
                    own.finish(self.means, x, ends, &self.change, increment);
                    false
                }
                Err(error) => {
                    taken.fail(error);
                    false
                }
            }
        });
    }

    /// α̂(L(x)) − x.
    fn uncorrected(&mut self, x: &[f64], increment: &mut [f64], taken: &mut [Taken]) {
        let d = self.dimension;
        for (place, at) in self.active.iter().enumerate() {
            taken[*at].evaluations = 1;
            let own = &mut self.trajectories[*at];
            own.y.copy_from_slice(&x[at * d..][..d]);
            self.evaluation.place(place, &own.y);
        }
        self.evaluation.evaluate(&mut self.active, taken, false);
        for (place, at) in self.active.iter().enumerate() {
            let ends = self.evaluation.ends(place);
            for i in 0..d {
                let place = at * d + i;
                increment[place] = (ends[i] - x[place]) + ends[d + i] + ends[2 * d + i];
            }
        }
    }
}

impl Lockstep for Workers {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [Taken]) {
        self.active.clear();
        self.active.extend(0..self.trajectories.len());
        if self.correction == Correction::None {
            return self.uncorrected(x, increment, taken);
        }
        for (own, x) in self.trajectories.iter_mut().zip(x.chunks(self.dimension)) {
            own.begin(x);
        }
        while !self.active.is_empty() {
            self.advance(x, low, increment, taken);
        }
    }

    fn solution(&self, at: usize) -> Option<&[f64]> {
        Some(&self.trajectories[at].y)
    }

    fn tangent(&mut self, at: usize) -> Option<Vec<f64>> {
        self.evaluation.place(0, &self.trajectories[at].y);
        let (mut active, mut taken) = (vec![0], [Taken::NOTHING]);
        self.evaluation.evaluate(&mut active, &mut taken, true);
        if active.is_empty() {
            return None;
        }
        let (target, change) = (&mut self.target, &mut self.change);
        self.trajectories[at].linear += self.evaluation.tangents(0, target, change);
        if self.correction == Correction::None {
            let sum = self.target.iter().zip(&self.change);
            return Some(sum.map(|(t, c)| t + c).collect());
        }
        super::tangent_of_map(&self.target, &self.change, self.dimension)
    }

    fn operations(&self) -> Option<u64> {
        let own: u64 = self.trajectories.iter().map(Solve::operations).sum();
        Some(self.evaluation.operations()? + own)
    }

    fn restart(&mut self, at: usize) {
        self.trajectories[at].extrapolation.clear(0);
        self.evaluation.restart();
    }

    fn memory(&self, at: usize) -> Vec<f64> {
        let mut memory = Vec::new();
        self.trajectories[at].extrapolation.memory(0, &mut memory);
        memory.extend(self.evaluation.memory());
        memory
    }

    fn restore(&mut self, at: usize, memory: &[f64]) {
        let extrapolation = &mut self.trajectories[at].extrapolation;
        let (history, parts) = memory.split_at(extrapolation.memory_len());
        extrapolation.restore(0, history);
        self.evaluation.restore(parts);
    }
}

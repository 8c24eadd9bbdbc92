//! L, α̂, β̂ and their tangents at the points of all trajectories that iterate.

use crate::batch::batch;
use crate::error::StepError;
use crate::evaluator::Evaluator;
use crate::{StepReport, product};

/// How L is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum By {
    /// By all corrections of a solve behind it.
    Values,
    /// By the first of them, or the next one.
    Approach { begins: bool },
}

/// Two evaluators and room for what they compute, one point behind the other.
pub(super) struct Evaluation {
    realization: Box<dyn Evaluator>,
    bisection: Box<dyn Evaluator>,
    dimension: usize,
    space: usize,
    y: Vec<f64>,
    z: Vec<f64>,
    /// How L is evaluated, and whether it is L.
    pub(super) by: By,
    pub(super) is_exact: bool,
    /// Base, offset and increment; DL; Dβ̂ and D(α̂ − β̂).
    ends: Vec<f64>,
    of_points: Vec<f64>,
    of_ends: Vec<f64>,
}

impl Evaluation {
    /// For at most `count` points: of several by evaluators that are pointwise.
    pub(super) fn new(
        (realization, bisection): (Box<dyn Evaluator>, Box<dyn Evaluator>),
        (dimension, space): (usize, usize),
        count: usize,
    ) -> Self {
        let room = |numbers: usize| vec![0.0; count * numbers];
        Self {
            realization,
            bisection,
            dimension,
            space,
            y: room(dimension),
            z: room(space),
            by: By::Values,
            is_exact: true,
            ends: room(3 * dimension),
            of_points: room(space * dimension),
            of_ends: room(2 * dimension * space),
        }
    }

    /// Sets a point y.
    pub(super) fn place(&mut self, place: usize, y: &[f64]) {
        self.y[place * self.dimension..][..self.dimension].copy_from_slice(y);
    }

    /// Evaluates both maps, and their tangents where these are wanted, at the points of `active`; those
    /// that fail leave it, and the others move up.
    pub(super) fn evaluate(
        &mut self,
        active: &mut Vec<usize>,
        taken: &mut [StepReport],
        wants_tangents: bool,
    ) {
        let each = [Self::points, Self::maps, Self::of_points, Self::of_maps];
        for function in &each[..if wants_tangents { 4 } else { 2 }] {
            if active.is_empty() {
                return;
            }
            let mut fails = false;
            function(self, active.len(), &mut |place, error| {
                taken[active[place]].fail(error);
                fails = true;
            });
            if fails {
                self.leave_out(active, taken);
            }
        }
    }

    fn points(&mut self, count: usize, failed: &mut dyn FnMut(usize, StepError)) {
        let (d, space) = (self.dimension, self.space);
        let (y, z) = (&self.y[..count * d], &mut self.z[..count * space]);
        let (bisection, by, is_exact) = (self.bisection.as_mut(), self.by, &mut self.is_exact);
        *is_exact = true;
        batch((d, space), y, z, failed, |y, z| match by {
            By::Values => bisection.values(y, z),
            By::Approach { begins } => {
                *is_exact &= bisection.approach(begins, y, z)?;
                Ok(())
            }
        });
    }

    fn maps(&mut self, count: usize, failed: &mut dyn FnMut(usize, StepError)) {
        let (d, space) = (self.dimension, self.space);
        let (z, ends) = (&self.z[..count * space], &mut self.ends[..count * 3 * d]);
        let realization = self.realization.as_mut();
        batch((space, 3 * d), z, ends, failed, |z, ends| {
            realization.values(z, ends)
        });
    }

    fn of_points(&mut self, count: usize, failed: &mut dyn FnMut(usize, StepError)) {
        let (d, entries) = (self.dimension, self.space * self.dimension);
        let (y, out) = (&self.y[..count * d], &mut self.of_points[..count * entries]);
        let bisection = self.bisection.as_mut();
        batch((d, entries), y, out, failed, |y, out| {
            bisection.jacobians(y, out)
        });
    }

    fn of_maps(&mut self, count: usize, failed: &mut dyn FnMut(usize, StepError)) {
        let (space, entries) = (self.space, self.dimension * self.space);
        let z = &self.z[..count * space];
        let out = &mut self.of_ends[..count * 2 * entries];
        let realization = self.realization.as_mut();
        batch((space, 2 * entries), z, out, failed, |z, out| {
            realization.jacobians(z, out)
        });
    }

    /// Moves the points of those that did not fail up to the front.
    fn leave_out(&mut self, active: &mut Vec<usize>, taken: &[StepReport]) {
        let (d, space) = (self.dimension, self.space);
        let rows = [
            (&mut self.y, d),
            (&mut self.z, space),
            (&mut self.ends, 3 * d),
            (&mut self.of_points, space * d),
        ];
        for (rows, width) in rows {
            let good = active.iter().enumerate();
            let good = good.filter(|(_, at)| taken[**at].outcome.is_ok());
            for (to, (from, _)) in good.enumerate() {
                rows.copy_within(from * width..(from + 1) * width, to * width);
            }
        }
        active.retain(|at| taken[*at].outcome.is_ok());
    }

    /// Base, offset and increment at a point.
    pub(super) fn ends(&self, place: usize) -> &[f64] {
        &self.ends[place * 3 * self.dimension..][..3 * self.dimension]
    }

    /// Writes D(β̂∘L) and D((α̂ − β̂)∘L) at a point; returns the operations of the products.
    pub(super) fn tangents(&self, place: usize, target: &mut [f64], change: &mut [f64]) -> u64 {
        let (d, entries) = (self.dimension, self.dimension * self.space);
        let of_points = &self.of_points[place * entries..][..entries];
        let of_ends = &self.of_ends[place * 2 * entries..][..2 * entries];
        product(&of_ends[..entries], of_points, d, target);
        product(&of_ends[entries..], of_points, d, change);
        4 * (d * entries) as u64
    }

    pub(super) fn operations(&self) -> Option<u64> {
        Some(self.realization.operations()? + self.bisection.operations()?)
    }

    /// Forgets earlier evaluations of a single trajectory; several have none to forget.
    pub(super) fn restart(&mut self) {
        self.bisection.restart();
        self.realization.restart();
    }

    pub(super) fn memory(&self) -> Vec<f64> {
        [self.bisection.memory(), self.realization.memory()].concat()
    }

    pub(super) fn restore(&mut self, memory: &[f64]) {
        let (bisection, realization) = memory.split_at(self.bisection.memory().len());
        self.bisection.restore(bisection);
        self.realization.restore(realization);
    }
}

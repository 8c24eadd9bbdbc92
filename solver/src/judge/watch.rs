//! Whether it is plain to which solution a solve led.

use super::CorrectionSize;

/// Corrections that do not halve while they are larger than this leave open to which solution they lead.
pub(crate) const WANDERING: f64 = 1e-6;

/// Number of steps after one that was not plain that are not taken as plain either. A solution of another branch may
/// look like that of a small step by itself, but its neighbours hardly do.
const WATCHED: u32 = 64;

/// Watch on a solve: whether it is plain that it is on the branch that begins at the state.
///
/// It is plain where Jacobians are near the identity, corrections halve and the start met the solution up to half of
/// the way from the state. The start is extrapolated from the steps before. This is so in small steps but the first.
/// Elsewhere a [`Branch`](crate::Branch) is to be followed.
#[derive(Clone, Copy, Debug)]
pub struct Watch {
    wanders: bool,
    steps: u32,
    /// The first correction and the last one.
    first: f64,
    last: f64,
}

impl Watch {
    /// Nothing seen.
    pub const NEW: Self = Self {
        wanders: false,
        steps: 0,
        first: f64::INFINITY,
        last: f64::INFINITY,
    };

    /// Begins a step.
    #[inline(always)]
    pub fn begin(&mut self) {
        self.wanders = self.steps > 0;
        self.steps = self.steps.saturating_sub(1);
        self.begin_solve();
    }

    /// Begins a solve within the step: its corrections are not compared with those of another.
    #[inline(always)]
    pub fn begin_solve(&mut self) {
        (self.first, self.last) = (f64::INFINITY, f64::INFINITY);
    }

    /// Takes in whether something is not plain.
    #[inline(always)]
    pub fn take(&mut self, wanders: bool) {
        if wanders {
            self.wanders = true;
            self.steps = WATCHED;
        }
    }

    /// Takes in a correction. One that is no round-off, and whose largest component is more than half of that of the one
    /// before, makes the branch doubtful: it may lead to another solution.
    pub fn take_correction(&mut self, correction: &CorrectionSize) {
        let size = correction.component();
        let falls = size < 0.5 * self.last || size <= WANDERING || correction.norm() <= WANDERING;
        self.take(!falls);
        if self.first.is_infinite() {
            self.first = size;
        }
        self.last = size;
    }

    /// Takes in that a solve is done, by its last correction.
    pub fn take_end(&mut self, correction: &CorrectionSize) {
        self.take_start(self.first, correction.way());
    }

    /// Takes in how far a solve's start was off, and how far from the state its solution is. A start that missed half
    /// of the way may have met a solution by chance. Even y = x may nearly be one where terms of different orders in
    /// the step cancel.
    #[inline(always)]
    pub fn take_start(&mut self, off: f64, way: f64) {
        let is_foreseen = off <= 0.5 * way || off <= WANDERING;
        self.wanders |= !is_foreseen;
    }

    /// Whether the step is not plain.
    #[inline(always)]
    pub fn wanders(&self) -> bool {
        self.wanders
    }

    /// Memory between steps: the number of coming steps that are not taken as plain.
    pub fn memory(&self) -> f64 {
        f64::from(self.steps)
    }

    /// Restores [`memory`](Self::memory).
    pub fn restore(&mut self, memory: f64) {
        self.steps = memory.clamp(0.0, f64::from(WATCHED)) as u32;
    }
}

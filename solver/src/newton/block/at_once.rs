//! The kernels of whole steps.

use std::sync::Arc;

use leafwise_expression::{Kernel, Workspace};

use super::lane::Lane;
use super::masks::is_inside;
use crate::judge::{WANDERING, larger, relative};
use crate::newton::at_once::Corrected;
use crate::newton::convergence::Next;
use crate::newton::kernel::NewtonKernel;

/// The steps of a lane alone as one kernel each.
pub(super) struct AtOnce {
    /// Those of one and of two evaluations.
    pub(super) programs: [Program; 2],
    /// Whether the next step is taken to need two.
    pub(super) needs_two: bool,
    /// Whether the last step was of one or two, with one Jacobian.
    pub(super) is_likely: bool,
}

/// A kernel of whole steps, and the memory it works in.
pub(super) struct Program {
    kernel: Arc<Kernel>,
    workspace: Workspace,
}

impl AtOnce {
    /// `None` where the kernel has no such steps; coefficients are not yet prepared.
    pub(super) fn new(newton: &NewtonKernel) -> Option<Box<Self>> {
        let kernels = newton.at_once.as_ref()?;
        let programs = kernels.each_ref().map(|kernel| Program {
            kernel: Arc::clone(kernel),
            workspace: kernel.workspace(1),
        });
        Some(Box::new(Self {
            programs,
            needs_two: false,
            is_likely: false,
        }))
    }

    /// Takes the coefficients of the kernels that a step evaluates: of its start, of an iteration, and of one without
    /// Jacobians.
    pub(super) fn prepare(&mut self, parts: [(&Kernel, &Workspace); 3]) {
        let [one, two] = &mut self.programs;
        one.kernel.prepare_from(&mut one.workspace, &parts[..2]);
        two.kernel.prepare_from(&mut two.workspace, &parts);
    }

    /// Takes in a step that was made one evaluation after the other.
    pub(super) fn learn(&mut self, lane: &Lane, is_ok: bool) {
        let evaluations = lane.convergence.evaluations;
        self.is_likely = is_ok && lane.jacobians == 1 && evaluations <= 2;
        self.needs_two = evaluations == 2;
    }
}

/// Why steps at once end.
pub(super) enum End {
    /// There were as many as asked for.
    Made,
    /// The next one needs the other kernel.
    Other,
    /// The next one is longer, or not plain.
    Another,
}

/// A step at once: its inputs, the lane behind it, and its last correction.
pub(super) type Step<'own, const W: usize> = (&'own mut [[f64; W]], Lane, Corrected<'own, W>);

impl Program {
    /// The inputs: x, low, and the solution before.
    #[inline(always)]
    pub(super) fn inputs<const W: usize>(&mut self) -> &mut [[f64; W]] {
        self.kernel.rows_mut::<W>(&mut self.workspace).0
    }

    /// Makes a step from the inputs as they stand, judged as those of a lane are.
    #[inline(always)]
    pub(super) fn step<const W: usize>(
        &mut self,
        mut lane: Lane,
        d: usize,
        has_two: bool,
        most_chords: u32,
    ) -> Result<Step<'_, W>, End> {
        self.kernel.evaluate_own_rows::<W>(&mut self.workspace);
        let (inputs, rows) = self.kernel.rows_mut::<W>(&mut self.workspace);
        let inputs = &mut inputs[..3 * d];
        lane.watch.begin();
        lane.convergence.start(None, most_chords);
        let is_near = rows[0][0] > 0.0;
        if lane.watch.wanders() || !is_near {
            return Err(End::Another);
        }
        (lane.next, lane.jacobians, lane.is_anchor_far) = (Next::Done, 1, false);
        let mut corrected = Corrected::of(rows, 0, d);
        let mut next = judge(&mut lane, &corrected, true, most_chords);
        if next == Next::Chord {
            if !has_two {
                return Err(End::Other);
            }
            corrected = Corrected::of(rows, 1, d);
            next = judge(&mut lane, &corrected, false, most_chords);
        }
        if next != Next::Done || !is_inside(&corrected.guard, 0) {
            return Err(End::Another);
        }
        if lane.convergence.first > WANDERING {
            let mut way = 0.0;
            for i in 0..d {
                let (y, scale) = (corrected.solution[i][0], corrected.scale[i][0]);
                way = larger(way, relative(y - inputs[i][0], scale));
            }
            lane.watch.take_start(lane.convergence.first, way);
            if lane.watch.wanders() {
                return Err(End::Another);
            }
        }
        Ok((inputs, lane, corrected))
    }
}

/// Next evaluation after a correction; one with a Jacobian where it is no number, or does not fall.
#[inline(always)]
fn judge<const W: usize>(
    lane: &mut Lane,
    corrected: &Corrected<'_, W>,
    is_newton: bool,
    most_chords: u32,
) -> Next {
    let size = corrected.size[0];
    let falls = size < 0.5 * lane.convergence.last || size <= WANDERING;
    if corrected.finite[0] != 0.0 || !falls {
        return Next::Newton;
    }
    // No correction is the third that does not shrink.
    let norm = || f64::INFINITY;
    lane.convergence.judge(size, norm, is_newton, most_chords)
}

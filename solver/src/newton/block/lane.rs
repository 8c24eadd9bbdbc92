//! One lane of a block.

use crate::judge::Watch;
use crate::newton::convergence::{Convergence, Next};

/// State of a lane's solve: its convergence, its next evaluation, and its Jacobians.
#[derive(Clone, Copy)]
pub(super) struct Lane {
    pub(super) convergence: Convergence,
    /// Next evaluation.
    pub(super) next: Next,
    /// Whether there are Jacobians.
    pub(super) anchored: bool,
    /// Evaluations with Jacobians in this step.
    pub(super) jacobians: u32,
    /// Whether the Jacobian that is there is far from the identity.
    pub(super) is_anchor_far: bool,
    /// Whether an iterate outside the chart has ended the solve.
    pub(super) is_astray: bool,
    pub(super) watch: Watch,
}

impl Lane {
    /// Nothing known.
    pub(super) const NEW: Self = Self {
        convergence: Convergence::new(),
        next: Next::Done,
        anchored: false,
        jacobians: 0,
        is_anchor_far: false,
        is_astray: false,
        watch: Watch::NEW,
    };
}

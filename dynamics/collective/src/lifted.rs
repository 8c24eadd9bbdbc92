//! Gauss methods in coordinates with a constant tensor.

use leafwise_core::LagrangianBisection;

/// The image of the section under a Gauss method of so many stages in the coordinates of a [`Lift`](leafwise_core::Lift), which
/// makes the whole step: nothing is solved for its start.
#[derive(Clone, Copy, Debug)]
pub struct LiftedFlow(pub(crate) usize);

impl LagrangianBisection for LiftedFlow {
    fn lifted_by(&self) -> Option<usize> {
        Some(self.0)
    }
}

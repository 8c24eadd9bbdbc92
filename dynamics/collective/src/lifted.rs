//! Gauss methods in coordinates with a constant tensor.

use leafwise_core::LagrangianBisection;
use leafwise_core::runge_kutta::Tableau;

/// The image of the section under a Gauss method in the coordinates of a [`Lift`](leafwise_core::Lift), which makes the
/// whole step: nothing is solved for its start.
#[derive(Clone, Debug)]
pub struct LiftedFlow(pub(crate) Tableau);

impl LagrangianBisection for LiftedFlow {
    fn lifted_by(&self) -> Option<&Tableau> {
        Some(&self.0)
    }
}

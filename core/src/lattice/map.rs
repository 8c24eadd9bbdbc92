//! Step maps of long lattices.

use super::geometry::LatticeGeometry;
use super::swept::Swept;
use crate::solver::StepMap;
use crate::system::PoissonSystem;

/// A step map of a long lattice, built on a short one that stands for it.
pub trait LatticeMap: StepMap {
    /// The lattice.
    fn geometry(&self) -> &LatticeGeometry;
    /// The system written out on the proxy lattice: what checks and instruments look at.
    fn proxy(&self) -> &PoissonSystem;
    /// The proxy lattice.
    fn proxy_geometry(&self) -> &LatticeGeometry;
    /// Cost of one evaluation: of a solver's iteration, of an explicit step.
    fn cost(&self) -> LatticeCost;
    /// The map as a product of sweeps that others may share fields with, where it is one.
    fn swept(&self) -> Option<Swept>;
}

/// Cost of an evaluation on a lattice, all sites together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LatticeCost {
    /// Operations.
    pub operations: usize,
    /// The same, weighted as [`SolverStatistics::operations`](crate::SolverStatistics) is.
    pub work: u64,
    /// Numbers a coordinate that it keeps.
    pub fields: usize,
}

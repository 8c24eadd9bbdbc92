//! Step maps of long lattices.

use super::geometry::LatticeGeometry;
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
    /// The operations of one evaluation, all sites together: of a solver's iteration, of an explicit
    /// step.
    fn operations(&self) -> usize;
    /// The same, weighted as [`SolverStatistics::operations`](crate::SolverStatistics) is.
    fn work(&self) -> u64;
    /// The numbers a coordinate that an evaluation keeps.
    fn fields(&self) -> usize;
}

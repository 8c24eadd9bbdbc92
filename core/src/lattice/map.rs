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
    /// Operations of all sweeps, each taken once, all sites together.
    fn operations(&self) -> usize;
    /// The numbers a coordinate that an evaluation keeps.
    fn fields(&self) -> usize;
}

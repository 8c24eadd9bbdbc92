//! Step maps of long lattices.

use std::sync::Arc;

use super::geometry::LatticeGeometry;
use super::swept::Swept;
use crate::solver::StepMap;

/// Step map of a long lattice, built on a short one that stands for it.
#[derive(Clone)]
pub struct LatticeMap {
    /// The map.
    pub map: Arc<dyn StepMap>,
    /// The lattice.
    pub geometry: LatticeGeometry,
    /// The short lattice, the proxy, on which the code was written out.
    pub proxy_geometry: LatticeGeometry,
    /// The operations of one evaluation, all sites together: of a solver's iteration, of an explicit
    /// step.
    pub operations: usize,
    /// The same, weighted as [`SolverStatistics::operations`](crate::SolverStatistics) is.
    pub work: u64,
    /// The numbers a coordinate that an evaluation keeps.
    pub fields: usize,
    /// The map as a product of sweeps that others may share fields with, where it is one.
    pub swept: Option<Swept>,
}

impl std::fmt::Debug for LatticeMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.map.describe())
    }
}

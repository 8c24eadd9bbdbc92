//! Lattice systems that can be written out at any length.

use leafwise_expression::Expression;

use super::geometry::LatticeGeometry;
use super::reach::TemplateReach;
use crate::error::BuildError;
use crate::system::PoissonSystem;

/// A lattice system that can be written out at any length.
pub trait LatticeSource {
    /// The true lattice.
    fn geometry(&self) -> &LatticeGeometry;
    /// How far its templates look, as their indices are written.
    ///
    /// # Errors
    /// [`BuildError::Lattice`] where one couples sites however far they are from each other.
    fn reach(&self) -> Result<TemplateReach, BuildError>;
    /// The system written out on a lattice of another length.
    ///
    /// # Errors
    /// [`BuildError`] when a formula does not fit there.
    fn write_out(&self, geometry: &LatticeGeometry) -> Result<PoissonSystem, BuildError>;
    /// The share of one site in the energy, each Casimir and each further observable.
    ///
    /// # Errors
    /// [`BuildError`] when one of them is not a sum over sites.
    fn densities(
        &self,
        geometry: &LatticeGeometry,
        site: usize,
    ) -> Result<Vec<SiteDensity>, BuildError>;
}

/// f = constant + Σ_i site(i): one site's share.
#[derive(Clone, Debug, PartialEq)]
pub struct SiteDensity {
    /// Constant term, which does not depend on the state.
    pub constant: Expression,
    /// The terms at the site asked for.
    pub site: Expression,
}

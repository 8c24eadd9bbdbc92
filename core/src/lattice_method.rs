//! Realization and dynamic approximation combined over a lattice.

use std::sync::Arc;

use crate::dynamics::DynamicApproximation;
use crate::error::BuildError;
use crate::lattice::{ImplicitSweeps, LatticeMap, LatticeSource};
use crate::method::{check_forces, properties_of};
use crate::realization::RealizationData;
use crate::system::PoissonSystem;

/// Builds a realization for the proxy system.
pub type Realize<'a> = dyn Fn(&PoissonSystem) -> Result<Arc<dyn RealizationData>, BuildError> + 'a;

/// φ̂_{ε,h} = α̂_ε ∘ (β̂_ε|_L)⁻¹ on a lattice, in O(N) time and memory a step.
#[derive(Clone, Debug)]
pub struct LatticeMethod {
    lattice: LatticeMap,
    realization: Arc<dyn RealizationData>,
    dynamics: Arc<dyn DynamicApproximation>,
}

impl LatticeMethod {
    /// Builds the method on a proxy lattice just long enough for its templates.
    ///
    /// The closure `realize` builds the realization for the proxy system.
    ///
    /// # Errors
    /// [`BuildError::NotLocal`] when the formulas look too far,
    /// [`BuildError::Incompatible`] when the realization cannot be written as stages,
    /// [`BuildError::Forces`] for forces that the dynamics does not take.
    pub fn compose(
        source: &dyn LatticeSource,
        realize: &Realize<'_>,
        dynamics: Arc<dyn DynamicApproximation>,
    ) -> Result<Self, BuildError> {
        let mut built = None;
        let lattice =
            ImplicitSweeps::compose(source, dynamics.properties().order, |builder, code| {
                let (system, [epsilon, h], y) = (code.system, &code.sizes, &code.y);
                check_forces(system, dynamics.as_ref())?;
                let realization = realize(system)?;
                let bisection = dynamics.bisection(system, &realization)?;
                let missing = |reason: &str| BuildError::Incompatible {
                    dynamics: dynamics.describe(),
                    realization: realization.describe(),
                    reason: reason.to_owned(),
                };
                let no_stages = || missing("its maps cannot be written as sweeps over a lattice");
                let no_points = || missing("the bisection offers no code");
                let points = bisection.code().ok_or_else(no_points)?;
                let z = points(&mut builder.graph, epsilon, h, y)?;
                let p = builder.store(z[system.dimension()..].to_vec());
                builder.finish_stage();
                let ends =
                    realization.abilities().stages.ok_or_else(no_stages)?(builder, epsilon, y, &p)?;
                let properties = properties_of(realization.as_ref(), dynamics.as_ref());
                let described = format!("{} + {}", realization.describe(), dynamics.describe());
                built = Some(realization);
                Ok((ends, properties, described))
            })?;
        Ok(Self {
            lattice,
            realization: built.expect("the code was written with it"),
            dynamics,
        })
    }

    /// The step map.
    pub fn map(&self) -> &LatticeMap {
        &self.lattice
    }

    /// The geometric approximation, built on the proxy.
    pub fn realization(&self) -> &dyn RealizationData {
        self.realization.as_ref()
    }

    /// The dynamic approximation.
    pub fn dynamics(&self) -> &dyn DynamicApproximation {
        self.dynamics.as_ref()
    }
}

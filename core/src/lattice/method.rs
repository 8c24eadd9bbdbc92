//! Realization and dynamic approximation combined over a lattice.

use std::sync::Arc;

use leafwise_expression::{Kernel, StepSize};

use super::geometry::{LatticeGeometry, Proxy};
use super::locality::local_reach;
use super::map::LatticeMap;
use super::program::LatticeProgram;
use super::source::LatticeSource;
use super::stages::{MethodFields, StageBuilder};
use super::stepper::LatticeTrajectory;
use crate::dynamics::DynamicApproximation;
use crate::error::BuildError;
use crate::realization::RealizationData;
use crate::solver::{Lanes, MapProperties, StepMap, Stepper};
use crate::system::PoissonSystem;

/// Builds a realization for the proxy system.
pub type Realize<'a> = dyn Fn(&PoissonSystem) -> Result<Arc<dyn RealizationData>, BuildError> + 'a;

/// φ̂_{ε,h} = α̂_ε ∘ (β̂_ε|_L)⁻¹ on a lattice, in O(N) time and memory a step.
#[derive(Clone, Debug)]
pub struct LatticeMethod {
    geometry: LatticeGeometry,
    proxy: PoissonSystem,
    proxy_geometry: LatticeGeometry,
    program: Arc<LatticeProgram>,
    fields: MethodFields,
    realization: Arc<dyn RealizationData>,
    dynamics: Arc<dyn DynamicApproximation>,
}

impl LatticeMethod {
    /// Builds the method on a proxy lattice just long enough for its templates.
    ///
    /// `realize` builds the realization for the proxy system.
    ///
    /// # Errors
    /// [`BuildError::NotLocal`] when the Hamiltonian couples distant sites,
    /// [`BuildError::Incompatible`] when the realization cannot be written as stages.
    pub fn compose(
        source: &dyn LatticeSource,
        realize: &Realize<'_>,
        dynamics: Arc<dyn DynamicApproximation>,
    ) -> Result<Self, BuildError> {
        let geometry = source.geometry();
        let (proxy, width) = proxy_geometry(source, dynamics.order())?;
        let system = source.write_out(&proxy)?;
        system.without_forces("a long lattice")?;
        let realization = realize(&system)?;
        let bisection = dynamics.bisection(&system, &realization)?;
        let missing = |reason: &str| BuildError::Incompatible {
            dynamics: dynamics.describe(),
            realization: realization.describe(),
            reason: reason.to_owned(),
        };
        let no_stages = || missing("its maps cannot be written as sweeps over a lattice");
        let no_points = || missing("the bisection offers no code");

        let mut builder = StageBuilder::new(system.dimension());
        let epsilon = builder.graph.step_size(StepSize::Epsilon);
        let h = builder.graph.step_size(StepSize::H);
        let (y_field, y) = builder.unwritten();
        let points = bisection.code().ok_or_else(no_points)?;
        let z = points(&mut builder.graph, &epsilon, &h, &y)?;
        let p = builder.store(z[system.dimension()..].to_vec());
        builder.finish_stage();
        let ends = realization.stages().ok_or_else(no_stages)?(&mut builder, &epsilon, &y, &p)?;
        let fields = MethodFields {
            y: y_field,
            offset: builder.output(ends.offset),
            increment: builder.output(ends.increment),
            reach: builder.reach,
        };
        builder.finish_stage();
        let program = LatticeProgram::compile(
            geometry,
            Proxy {
                geometry: &proxy,
                width,
            },
            &builder,
            system.parameters().len(),
        )?;
        Ok(Self {
            geometry: geometry.clone(),
            proxy: system,
            proxy_geometry: proxy,
            program: Arc::new(program),
            fields,
            realization,
            dynamics,
        })
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

impl LatticeMap for LatticeMethod {
    fn geometry(&self) -> &LatticeGeometry {
        &self.geometry
    }

    fn proxy(&self) -> &PoissonSystem {
        &self.proxy
    }

    fn proxy_geometry(&self) -> &LatticeGeometry {
        &self.proxy_geometry
    }

    fn operations(&self) -> usize {
        self.program.operations()
    }

    fn work(&self) -> u64 {
        self.program.work()
    }

    fn fields(&self) -> usize {
        self.program.fields()
    }
}

impl StepMap for LatticeMethod {
    fn dimension(&self) -> usize {
        self.geometry.dimension()
    }

    fn properties(&self) -> MapProperties {
        crate::method::properties_of(self.realization.as_ref(), self.dynamics.as_ref())
    }

    fn describe(&self) -> String {
        format!(
            "{} + {}",
            self.realization.describe(),
            self.dynamics.describe()
        )
    }

    fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        self.program
            .kernels()
            .map(|kernel| ("a site", kernel))
            .collect()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let d = self.geometry.dimension();
        Box::new(Lanes::apart(lanes, d, parameters, |parameters| {
            LatticeTrajectory::new(&self.program, self.fields, parameters, epsilon, h)
        }))
    }
}

/// A proxy lattice on which every site class of a method of order `order` can be told apart, and
/// the number of boundary sites with code of their own; the true lattice itself when that is
/// short.
fn proxy_geometry(
    source: &dyn LatticeSource,
    order: usize,
) -> Result<(LatticeGeometry, usize), BuildError> {
    let geometry = source.geometry();
    let Some(reach) = local_reach(source)? else {
        return Ok((geometry.clone(), 0));
    };
    // S_l takes l − 1 times the reach of the tensor and of dH to either side, and dS_l once more.
    let shorter = geometry
        .families
        .iter()
        .map(|f| geometry.length() - f.1)
        .max()
        .unwrap_or(0);
    let width = (reach * order.saturating_sub(1).max(1)).max(shorter) + shorter;
    let length = 2 * width + 3;
    if geometry.length() <= length {
        return Ok((geometry.clone(), 0));
    }
    Ok((geometry.resized(length), width))
}

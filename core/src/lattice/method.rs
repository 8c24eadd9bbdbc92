//! Realization and dynamic approximation combined over a lattice.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Graph, Kernel, StepSize, Term};

use super::geometry::LatticeGeometry;
use super::observables::SiteDensity;
use super::program::{LatticeProgram, Proxy, shift};
use super::stages::{Field, StageBuilder};
use super::stepper::LatticeTrajectory;
use crate::dynamics::DynamicApproximation;
use crate::error::BuildError;
use crate::realization::RealizationData;
use crate::solver::{LaneByLane, MapProperties, StepMap, Stepper};
use crate::system::{PoissonSystem, SystemFormulas};

/// A lattice system that can be written out at any length.
pub trait LatticeSource {
    /// The true lattice.
    fn geometry(&self) -> &LatticeGeometry;
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

/// Builds a realization for the proxy system.
pub type Realize<'a> = dyn Fn(&PoissonSystem) -> Result<Arc<dyn RealizationData>, BuildError> + 'a;

/// The fields a solver reads and writes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fields {
    pub(super) y: Field,
    pub(super) offset: Field,
    pub(super) increment: Field,
}

/// φ̂_{ε,h} = α̂_ε ∘ (β̂_ε|_L)⁻¹ on a lattice, in O(N) time and memory a step.
#[derive(Clone, Debug)]
pub struct LatticeMethod {
    geometry: LatticeGeometry,
    proxy: PoissonSystem,
    proxy_geometry: LatticeGeometry,
    program: Arc<LatticeProgram>,
    fields: Fields,
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
        let realization = realize(&system)?;
        let bisection = dynamics.bisection(&system, &realization)?;
        let missing = |reason: &str| BuildError::Incompatible {
            dynamics: dynamics.describe(),
            realization: realization.describe(),
            reason: reason.to_owned(),
        };
        let stages = realization
            .stages()
            .ok_or_else(|| missing("its maps cannot be written as sweeps over a lattice"))?;
        let points = bisection
            .code()
            .ok_or_else(|| missing("the bisection offers no code"))?;

        let mut builder = StageBuilder::new(system.dimension());
        let epsilon = builder.graph.step_size(StepSize::Epsilon);
        let h = builder.graph.step_size(StepSize::H);
        let (y_field, y) = builder.unwritten();
        let z = points.point(&mut builder.graph, &epsilon, &h, &y)?;
        let p = builder.store(z[system.dimension()..].to_vec());
        builder.finish_stage();
        let ends = stages.stages(&mut builder, &epsilon, &y, &p)?;
        let fields = Fields {
            y: y_field,
            offset: builder.output(ends.offset),
            increment: builder.output(ends.increment),
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

    /// The lattice.
    pub fn geometry(&self) -> &LatticeGeometry {
        &self.geometry
    }

    /// The system written out on the proxy lattice: what checks and instruments look at.
    pub fn proxy(&self) -> &PoissonSystem {
        &self.proxy
    }

    /// The proxy lattice.
    pub fn proxy_geometry(&self) -> &LatticeGeometry {
        &self.proxy_geometry
    }

    /// The geometric approximation, built on the proxy.
    pub fn realization(&self) -> &dyn RealizationData {
        self.realization.as_ref()
    }

    /// The dynamic approximation.
    pub fn dynamics(&self) -> &dyn DynamicApproximation {
        self.dynamics.as_ref()
    }

    /// The compiled sweeps.
    pub fn program(&self) -> &LatticeProgram {
        &self.program
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
        Box::new(LaneByLane::new(lanes, d, parameters, |parameters| {
            LatticeTrajectory::new(&self.program, self.fields, parameters, epsilon, h)
        }))
    }
}

/// The longest reach of a formula that the search below looks for.
const LONGEST_REACH: usize = 16;

/// A proxy lattice on which every site class of a method of order `order` can be told apart, and
/// the number of boundary sites with code of their own; the true lattice itself when that is
/// short.
fn proxy_geometry(
    source: &dyn LatticeSource,
    order: usize,
) -> Result<(LatticeGeometry, usize), BuildError> {
    let geometry = source.geometry();
    let mut trial = 9;
    let reach = loop {
        if geometry.length() <= trial {
            return Ok((geometry.clone(), 0));
        }
        let proxy = geometry.resized(trial);
        let system = source.write_out(&proxy)?;
        let formulas = system.formulas("a long lattice")?;
        check_homogeneous(formulas, &proxy)?;
        let reach = reach(formulas, &proxy)?;
        if 2 * reach + 1 < trial {
            break reach;
        }
        if reach > LONGEST_REACH {
            return Err(BuildError::NotLocal { reach });
        }
        trial = 2 * trial + 1;
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

/// Refuses a tensor whose entries change from one interior site to the next: one with a fixed site
/// such as `x[0],x[5]`, of which a template would make many.
fn check_homogeneous(
    system: &SystemFormulas,
    geometry: &LatticeGeometry,
) -> Result<(), BuildError> {
    let offsets = geometry.offsets();
    let length = geometry.length();
    let is_interior = |site: usize| geometry.periodic || (2..length - 3).contains(&site);
    let moved = |coordinate: usize| {
        let (family, site) = geometry.locate(coordinate);
        let next = (site + 1) % length;
        (next < geometry.families[family].1).then(|| offsets[family] + next)
    };
    let mut graph = Graph::new();
    for (&(a, b), entry) in system.tensor() {
        if !is_interior(geometry.locate(a).1) || !is_interior(geometry.locate(b).1) {
            continue;
        }
        let not_homogeneous = || BuildError::NotHomogeneous {
            first: geometry.name(a),
            second: geometry.name(b),
        };
        let (Some(c), Some(d)) = (moved(a), moved(b)) else {
            continue;
        };
        let here = entry.evaluate_in(&mut graph, &mut |graph, at| {
            Ok(graph.input(moved(at).unwrap_or(at)))
        })?;
        let there = system
            .tensor()
            .get(&(c.min(d), c.max(d)))
            .ok_or_else(not_homogeneous)?;
        let there = there.evaluate_in(&mut graph, &mut |graph, at| Ok(graph.input(at)))?;
        let there = if c < d { there } else { graph.negate(&there) };
        let difference = graph.subtract(&here, &there);
        if !graph.is_zero(&difference) {
            return Err(not_homogeneous());
        }
    }
    Ok(())
}

/// How far dH and the tensor's rows at the centre of a written-out lattice look.
fn reach(system: &SystemFormulas, geometry: &LatticeGeometry) -> Result<usize, BuildError> {
    let d = system.dimension();
    let centre = geometry.length() / 2;
    let offsets = geometry.offsets();
    let mut graph = Graph::new();
    let x: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
    let v: Vec<Term> = (d..2 * d).map(|i| graph.input(i)).collect();
    let energy = system
        .hamiltonian()
        .evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone()))?;
    let rows = system.apply_tensor(&mut graph, &x, &v)?;
    let mut reach = [0, 0];
    for (family, (_, length)) in geometry.families.iter().enumerate() {
        if centre >= *length {
            continue;
        }
        let coordinate = offsets[family] + centre;
        let slope = graph.derivative(&energy, coordinate)?;
        for (which, term) in [slope, rows[coordinate].clone()].into_iter().enumerate() {
            if graph.is_zero(&term) {
                continue;
            }
            for input in Kernel::compile_used(&graph, &[term], 0).1 {
                let (_, site) = geometry.locate(input % d);
                reach[which] = reach[which].max(shift(geometry, centre, site).unsigned_abs());
            }
        }
    }
    Ok((reach[0] + reach[1]).max(1))
}

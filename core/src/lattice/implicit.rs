//! Step maps whose two ends are given by one unknown point, as sweeps over a lattice.

use std::sync::Arc;

use leafwise_expression::{StepSize, Term};

use super::differential::SolvedSweeps;
use super::geometry::Proxy;
use super::locality::proxy_of;
use super::map::LatticeMap;
use super::program::LatticeProgram;
use super::slopes::LatticeSlopes;
use super::source::LatticeSource;
use super::stages::{MethodFields, StageBuilder, StageEnds};
use super::stepper::LatticeTrajectory;
use crate::error::BuildError;
use crate::solver::{Differential, Lanes, MapAbilities, MapProperties, StepMap, Stepper};
use crate::system::PoissonSystem;

/// x ↦ x₊ with x = y + offset(y), x₊ = x + increment(y), on a lattice. The linear iteration
/// y ← y − (y + offset(y) − x) solves for y, in O(N) time and memory a step.
#[derive(Clone, Debug)]
pub struct ImplicitSweeps {
    dimension: usize,
    program: Arc<LatticeProgram>,
    slopes: Arc<LatticeSlopes>,
    fields: MethodFields,
    properties: MapProperties,
    description: String,
}

/// Inputs of the code of a map: the system on the proxy lattice, ε and h, and y.
#[derive(Debug)]
pub struct ProxyCode<'a> {
    /// The system written out.
    pub system: &'a PoissonSystem,
    /// ε and h.
    pub sizes: [Term; 2],
    /// One term a proxy coordinate.
    pub y: Vec<Term>,
}

impl ImplicitSweeps {
    /// Builds the map on a proxy lattice just long enough for its templates. The closure `write` writes its code,
    /// which looks no further than a Hamilton–Jacobi series of this `order`. It also says what the map declares and
    /// is called.
    ///
    /// # Errors
    /// [`BuildError::NotLocal`] when the formulas look too far; those of `write`.
    pub fn compose(
        source: &dyn LatticeSource,
        order: usize,
        write: impl FnOnce(
            &mut StageBuilder,
            &ProxyCode<'_>,
        ) -> Result<(StageEnds, MapProperties, String), BuildError>,
    ) -> Result<LatticeMap, BuildError> {
        let geometry = source.geometry();
        // S_l takes l − 1 times the reach of the tensor and of dH to either side, and dS_l once more.
        let (proxy, width) = proxy_of(source, order.saturating_sub(1).max(1))?;
        let system = source.write_out(&proxy)?;
        let mut builder = StageBuilder::new(system.dimension());
        let sizes = [StepSize::Epsilon, StepSize::H].map(|size| builder.graph.step_size(size));
        let (y_field, y) = builder.unwritten();
        let code = ProxyCode {
            system: &system,
            sizes,
            y,
        };
        let (ends, properties, description) = write(&mut builder, &code)?;
        let fields = MethodFields {
            y: y_field,
            offset: builder.output(ends.offset),
            increment: builder.output(ends.increment),
            reach: builder.reach,
        };
        builder.finish_stage();
        let (written, parameters) = (
            Proxy {
                geometry: &proxy,
                width,
            },
            system.parameters().len(),
        );
        let program = LatticeProgram::compile(geometry, written, &builder, parameters)?;
        let program = Arc::new(program);
        // No derivative looks at what guards a chart.
        let builder = match fields.reach {
            Some(reach) => builder.without(reach),
            None => builder,
        };
        let slopes = LatticeSlopes::new(&program, written, builder, parameters);
        Ok(LatticeMap {
            swept: None,
            operations: program.operations(),
            work: program.work(),
            fields: program.fields(),
            map: Arc::new(Self {
                dimension: geometry.dimension(),
                program,
                slopes: Arc::new(slopes),
                fields,
                properties,
                description,
            }),
            geometry: geometry.clone(),
            proxy_geometry: proxy,
        })
    }
}

impl StepMap for ImplicitSweeps {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn properties(&self) -> MapProperties {
        self.properties
    }

    fn describe(&self) -> String {
        self.description.clone()
    }

    fn abilities(&self) -> MapAbilities<'_> {
        let kernels = self.program.kernels();
        MapAbilities {
            kernels: kernels.map(|kernel| ("a site", kernel)).collect(),
            ..MapAbilities::default()
        }
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let d = self.dimension;
        Box::new(Lanes::apart(lanes, d, parameters, |parameters| {
            LatticeTrajectory::new(&self.program, self.fields, parameters, epsilon, h)
        }))
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        let stepper = self.stepper(1, parameters, epsilon, h);
        let (slopes, sizes) = (&self.slopes, (epsilon, h));
        Box::new(SolvedSweeps::new(
            stepper,
            slopes,
            self.fields,
            parameters,
            sizes,
        ))
    }
}

//! The classical Runge–Kutta method of order 4: the part `rk4`.

use std::sync::Arc;

use leafwise_core::part::{PartInfo, PartKind, PartParameters};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::{BuildError, MapProperties, PoissonSystem, StepError, StepMap, Structure};
use nalgebra::DMatrix;

use crate::one_step::{OneStep, ReferenceMap};

pub(crate) static INFO: PartInfo = PartInfo {
    name: "rk4",
    kind: PartKind::Stepper,
    summary: "the classical Runge-Kutta method, explicit",
    declares: "order 4; not a Poisson map; not self-adjoint; exact tangent up to 256 variables",
    domain: "any system, of formulas or of numbers",
    literature: "W. Kutta, Z. Math. Phys. 46 (1901); Hairer, Norsett, Wanner, Solving Ordinary \
                 Differential Equations I, table II.1.2",
    parameters: &[],
};

/// Beyond this dimension no tangent is offered: its matrix takes longer to compile than a run.
const LARGEST_TANGENT: usize = 256;

/// RK4 for one trajectory.
pub(crate) struct Rk4 {
    field: SmoothMapEvaluator,
    time_step: f64,
    /// The four stages and the slopes there.
    stages: [Vec<f64>; 4],
    slopes: [Vec<f64>; 4],
    /// Operations of the sums.
    linear: u64,
}

/// c_i = a_{i,i−1}.
const NODES: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
/// 6 b_i.
const WEIGHTS: [f64; 4] = [1.0, 2.0, 2.0, 1.0];

impl Rk4 {
    pub(crate) fn new(field: &SmoothMap, parameters: &[f64], time_step: f64) -> Self {
        let room = || std::array::from_fn(|_| vec![0.0; field.inputs()]);
        Self {
            field: field.evaluator(parameters, 1.0, 1.0),
            time_step,
            stages: room(),
            slopes: room(),
            linear: 0,
        }
    }
}

impl OneStep for Rk4 {
    fn increment(&mut self, x: &[f64], increment: &mut [f64]) -> Result<usize, StepError> {
        for i in 0..4 {
            for c in 0..x.len() {
                let before = if i == 0 { 0.0 } else { self.slopes[i - 1][c] };
                self.stages[i][c] = x[c] + self.time_step * NODES[i] * before;
            }
            self.field.value(&self.stages[i], &mut self.slopes[i])?;
        }
        // Two for each of three stages, eight and a factor for the sum.
        self.linear += 15 * x.len() as u64;
        for (c, increment) in increment.iter_mut().enumerate() {
            let sum: f64 = (0..4).map(|i| WEIGHTS[i] * self.slopes[i][c]).sum();
            *increment = self.time_step / 6.0 * sum;
        }
        Ok(1)
    }

    fn operations(&self) -> Option<u64> {
        Some(self.field.operations()? + self.linear)
    }

    fn tangent(&mut self) -> Option<DMatrix<f64>> {
        let d = self.stages[0].len();
        let mut tangent = DMatrix::identity(d, d);
        let mut before = DMatrix::zeros(d, d);
        let mut entries = vec![0.0; d * d];
        for i in 0..4 {
            self.field.jacobian(&self.stages[i], &mut entries).ok()?;
            let stage = DMatrix::identity(d, d) + before * (self.time_step * NODES[i]);
            before = DMatrix::from_row_slice(d, d, &entries) * stage;
            tangent += &before * (self.time_step * WEIGHTS[i] / 6.0);
        }
        Some(tangent)
    }
}

struct Part;

impl StepperPart for Part {
    fn info(&self) -> &'static PartInfo {
        &INFO
    }

    fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        parameters.refuse_unknown(&INFO)?;
        let field = if system.dimension() <= LARGEST_TANGENT {
            system.field_map()?
        } else {
            system.field_values()?
        };
        Ok(Arc::new(ReferenceMap {
            dimension: system.dimension(),
            properties: MapProperties {
                order: 4,
                structure: Structure::None,
                self_adjoint: Some(false),
            },
            description: INFO.name.to_owned(),
            make: Box::new(move |parameters, time_step| {
                Box::new(Rk4::new(&field, parameters, time_step))
            }),
        }))
    }
}

leafwise_core::built_in!(Stepper, Part);

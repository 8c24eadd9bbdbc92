//! Strang's product of shears, for systems of numbers that name them.

use std::sync::Arc;

use leafwise_core::part::{PartInfo, PartParameters};
use leafwise_core::solver::{
    Factored, Lanes, MapAbilities, MapProperties, Pieces, StepMap, StepReport, Stepper, Structure,
    Trajectories,
};
use leafwise_core::system::{OpaqueSystem, Shear};
use leafwise_core::{BuildError, Evaluator, StepError};

use crate::arrangement::named_order;
use crate::piece::NAME;
use crate::product::{Product, Splits, evaluations};
use crate::schedule::{Flow, STRANG, passes};

/// φ¹_{t/2} ∘ φ²_t ∘ φ¹_{t/2} of H = T + V with the flows x + t X_k(x): Störmer and Verlet's method.
#[derive(Clone)]
pub(crate) struct Shears {
    dimension: usize,
    shears: Vec<Shear>,
}

impl Shears {
    /// # Errors
    /// [`BuildError::DoesNotFit`] for a system that names none.
    pub(crate) fn new(
        info: &'static PartInfo,
        system: &OpaqueSystem,
        parameters: &PartParameters,
    ) -> Result<Self, BuildError> {
        let shears = system.numbers.shears();
        if shears.is_empty() {
            return Err(match system.numbers.has_resting_tensor() {
                false => system.not_offered(NAME, "formulas of the system"),
                true => BuildError::DoesNotFit {
                    part: NAME,
                    reason: "sums over pairs in a loop split into T + V where each part moves coordinates that it does not depend \
                             on, as p and q; take `implicit-midpoint`, `gauss` or `dop853`"
                        .to_owned(),
                },
            });
        }
        let order = named_order(info, parameters, shears.len())?;
        let order = order.unwrap_or_else(|| (0..shears.len()).collect());
        Ok(Self {
            dimension: system.variables.len(),
            shears: order.into_iter().map(|at| shears[at].clone()).collect(),
        })
    }

    /// The same as a composition asks for the parts.
    ///
    /// # Errors
    /// [`BuildError::Pieces`] where they are not of that kind.
    fn arranged(&self, asked: Pieces) -> Result<Self, BuildError> {
        let refused = |reason: &str| BuildError::Pieces {
            asked,
            map: self.describe(),
            reason: reason.to_owned(),
        };
        let mut arranged = self.clone();
        match asked {
            Pieces::Any => {}
            Pieces::Nystrom { kick_first } => {
                let drift = self.shears.iter().position(Shear::is_affine);
                let drift = drift.ok_or_else(|| refused("no part is a square of momenta"))?;
                if (drift == 0) == kick_first {
                    arranged.shears.reverse();
                }
            }
            Pieces::Perturbed => {
                return Err(refused(
                    "which part is small is not known of sums over pairs",
                ));
            }
        }
        Ok(arranged)
    }
}

impl StepMap for Shears {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn properties(&self) -> MapProperties {
        MapProperties {
            order: 2,
            structure: Structure::Exact,
            self_adjoint: Some(true),
        }
    }

    fn describe(&self) -> String {
        format!("{NAME} into {} pieces, pairs in a loop", self.shears.len())
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        self.passes_stepper(&STRANG, lanes, parameters, epsilon, h)
    }

    fn abilities(&self) -> MapAbilities<'_> {
        MapAbilities {
            factored: Some(Factored {
                factors: Product::factors(self),
                pieces: self.shears.len(),
                arranged: Some(Box::new(|asked| Ok(Arc::new(self.arranged(asked)?)))),
                product: Box::new(|parts| Some(Arc::new(Product::new(self, parts)))),
            }),
            ..MapAbilities::default()
        }
    }
}

impl Splits for Shears {
    fn passes_stepper(
        &self,
        parts: &[f64],
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Stepper> {
        let order: Vec<usize> = (0..self.shears.len()).collect();
        let flows = passes(&order, parts);
        let make = |parameters: &[f64]| ShearFlows {
            fields: (self.shears.iter())
                .map(|shear| shear.evaluator(parameters, 1))
                .collect(),
            flows: flows.clone(),
            time: epsilon * h,
            evaluations: evaluations(parts),
            state: vec![0.0; self.dimension],
            field: vec![0.0; self.dimension],
        };
        Box::new(Lanes::apart(lanes, self.dimension, parameters, make))
    }
}

/// Flows of shears one after the other.
///
/// The state between flows is plain doubles; the flows' increments add up apart from it.
struct ShearFlows {
    fields: Vec<Box<dyn Evaluator>>,
    flows: Vec<Flow>,
    time: f64,
    /// The number of evaluations that a step counts as.
    evaluations: u64,
    state: Vec<f64>,
    field: Vec<f64>,
}

impl Trajectories for ShearFlows {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        increment.fill(0.0);
        self.state.copy_from_slice(x);
        for flow in &self.flows {
            let field = &mut self.fields[flow.piece];
            if let Err(error) = field.values(&self.state, &mut self.field) {
                taken.iter_mut().for_each(|taken| taken.fail(error.clone()));
                return;
            }
            let time = flow.part * self.time;
            let changes = increment.iter_mut().zip(&self.field);
            for ((state, x), (change, slope)) in self.state.iter_mut().zip(x).zip(changes) {
                *change += time * slope;
                *state = x + *change;
            }
        }
        for taken in taken {
            taken.evaluations += self.evaluations;
            if !increment.iter().all(|change| change.is_finite()) {
                taken.fail(StepError::OF_INCREMENT);
            }
        }
    }

    fn operations(&self) -> Option<u64> {
        let fields = self.fields.iter();
        Some(fields.filter_map(|field| field.operations()).sum())
    }
}

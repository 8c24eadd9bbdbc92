//! Strang's product of shears, for systems of numbers that name them.

use std::sync::Arc;

use leafwise_core::part::{PartInfo, PartParameters};
use leafwise_core::shadow::{MakeShadowEnergy, shadow_of_shears};
use leafwise_core::solver::{
    Factored, Lanes, MapAbilities, MapProperties, Pieces, StepMap, StepReport, Stepper, Structure,
    Trajectories,
};
use leafwise_core::system::{MakeFieldTangent, OpaqueSystem, Shear};
use leafwise_core::{BuildError, ByTangents, Differential, Evaluator, StepError};

use crate::arrangement::named_order;
use crate::piece::NAME;
use crate::product::{Product, Splits, evaluations};
use crate::schedule::{Flow, STRANG, passes};

/// φ¹_{t/2} ∘ φ²_t ∘ φ¹_{t/2} of H = T + V with the flows x + t X_k(x): Störmer and Verlet's method.
#[derive(Clone)]
pub(crate) struct Shears {
    dimension: usize,
    shears: Vec<Shear>,
    tangent: Option<Arc<MakeFieldTangent>>,
    shadow: Option<Arc<MakeShadowEnergy>>,
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
            tangent: system.numbers.field_tangent(),
            shadow: match order[..] {
                [outer, inner] => shadow_of_shears(system, [outer, inner]),
                _ => None,
            },
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
                    // Of the other order.
                    arranged.shadow = None;
                }
            }
            Pieces::Perturbed => {
                return Err(refused(
                    "for sums over pairs it is not known which part is small",
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
        format!(
            "{NAME} into {} shears as T + V, harmonic parts with V, pairs in a loop",
            self.shears.len()
        )
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        self.passes_stepper(&STRANG, lanes, parameters, epsilon, h)
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        self.passes_differential(&STRANG, parameters, epsilon, h)
    }

    fn abilities(&self) -> MapAbilities<'_> {
        MapAbilities {
            shadow_energy: self.shadow.clone(),
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
        let make = |parameters: &[f64]| self.flows(parts, parameters, epsilon * h);
        Box::new(Lanes::apart(lanes, self.dimension, parameters, make))
    }

    fn passes_differential(
        &self,
        parts: &[f64],
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Differential> {
        let stepper = self.passes_stepper(parts, 1, parameters, epsilon, h);
        let Some(make) = &self.tangent else {
            return Box::new(ByTangents::new(stepper, self.dimension));
        };
        Box::new(ShearTangents {
            flows: self.flows(parts, parameters, epsilon * h),
            moves: self
                .shears
                .iter()
                .map(|shear| shear.moves().to_vec())
                .collect(),
            products: make(parameters),
            point: vec![0.0; 2 * self.dimension],
            from: vec![0.0; self.dimension],
            states: Vec::new(),
            change: vec![0.0; self.dimension],
        })
    }
}

impl Shears {
    /// The flows of a product of χ and χ* over a time.
    fn flows(&self, parts: &[f64], parameters: &[f64], time: f64) -> ShearFlows {
        let order: Vec<usize> = (0..self.shears.len()).collect();
        ShearFlows {
            fields: (self.shears.iter())
                .map(|shear| shear.evaluator(parameters, 1))
                .collect(),
            flows: passes(&order, parts),
            time,
            evaluations: evaluations(parts),
            state: vec![0.0; self.dimension],
            field: vec![0.0; self.dimension],
        }
    }
}

/// Steps of shears with their differentials: flow after flow, x + tX(x) by 1 + tDX. X does not depend on what it moves, so
/// that (DX)² = 0 and the inverse is 1 − tDX at the same state.
struct ShearTangents {
    flows: ShearFlows,
    /// The coordinates that each shear moves.
    moves: Vec<Vec<usize>>,
    /// Of a state with v or w behind it DX v and DXᵀ w.
    products: [Box<dyn Evaluator>; 2],
    /// Where the last step began, and the state before each of its flows where they are known.
    from: Vec<f64>,
    states: Vec<Vec<f64>>,
    point: Vec<f64>,
    change: Vec<f64>,
}

impl ShearTangents {
    fn find(&mut self) -> Result<(), StepError> {
        if self.states.is_empty() {
            let states = &mut self.states;
            let mut increment = vec![0.0; self.from.len()];
            self.flows.run(&self.from, &mut increment, |state| {
                states.push(state.to_vec())
            })?;
        }
        Ok(())
    }

    /// w ← w ± t DXᵀ w by the flow of this number.
    fn pull_through(
        &mut self,
        at: usize,
        sign: f64,
        covector: &mut [f64],
    ) -> Result<(), StepError> {
        let flow = self.flows.flows[at];
        let (state, moved) = self.point.split_at_mut(covector.len());
        state.copy_from_slice(&self.states[at]);
        moved.fill(0.0);
        for own in &self.moves[flow.piece] {
            moved[*own] = covector[*own];
        }
        self.products[1].values(&self.point, &mut self.change)?;
        let time = sign * flow.part * self.flows.time;
        for (w, change) in covector.iter_mut().zip(&self.change) {
            *w += time * change;
        }
        Ok(())
    }
}

impl Differential for ShearTangents {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        self.states.clear();
        self.from.copy_from_slice(x);
        self.flows.run(x, increment, |_| {})?;
        match increment.iter().all(|change| change.is_finite()) {
            true => Ok(()),
            false => Err(StepError::OF_INCREMENT),
        }
    }

    fn push(&mut self, tangents: &mut [f64], parameters: &[f64]) -> Result<(), StepError> {
        if !parameters.is_empty() {
            return Err(StepError::NoTangent);
        }
        self.find()?;
        for tangent in tangents.chunks_exact_mut(self.from.len()) {
            for (flow, state) in self.flows.flows.iter().zip(&self.states) {
                self.point[..state.len()].copy_from_slice(state);
                self.point[state.len()..].copy_from_slice(tangent);
                self.products[0].values(&self.point, &mut self.change)?;
                for moved in &self.moves[flow.piece] {
                    tangent[*moved] += flow.part * self.flows.time * self.change[*moved];
                }
            }
        }
        Ok(())
    }

    fn pull(&mut self, covector: &mut [f64], gradient: &mut [f64]) -> Result<(), StepError> {
        if !gradient.is_empty() {
            return Err(StepError::NoTangent);
        }
        self.find()?;
        for at in (0..self.states.len()).rev() {
            self.pull_through(at, 1.0, covector)?;
        }
        Ok(())
    }

    fn pull_inverse(
        &mut self,
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        if !gradient.is_empty() {
            return Err(StepError::NoTangent);
        }
        self.find()?;
        for at in 0..self.states.len() {
            self.pull_through(at, -1.0, covector)?;
        }
        Ok(())
    }

    fn knows_parameters(&self) -> bool {
        false
    }

    fn operations(&self) -> Option<u64> {
        let of_flows = self.flows.operations()?;
        let products = self.products.iter().filter_map(|own| own.operations());
        Some(of_flows + products.sum::<u64>())
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

impl ShearFlows {
    /// The flows from x; `before` takes the state before each.
    fn run(
        &mut self,
        x: &[f64],
        increment: &mut [f64],
        mut before: impl FnMut(&[f64]),
    ) -> Result<(), StepError> {
        increment.fill(0.0);
        self.state.copy_from_slice(x);
        for flow in &self.flows {
            before(&self.state);
            let field = &mut self.fields[flow.piece];
            field.values(&self.state, &mut self.field)?;
            let time = flow.part * self.time;
            let changes = increment.iter_mut().zip(&self.field);
            for ((state, x), (change, slope)) in self.state.iter_mut().zip(x).zip(changes) {
                *change += time * slope;
                *state = x + *change;
            }
        }
        Ok(())
    }
}

impl Trajectories for ShearFlows {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        if let Err(error) = self.run(x, increment, |_| {}) {
            taken.iter_mut().for_each(|taken| taken.fail(error.clone()));
            return;
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

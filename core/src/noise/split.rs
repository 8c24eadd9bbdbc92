//! Split steps as products of flows.

use std::sync::Arc;

use crate::solver::{MapAbilities, MapProperties, ProductStepper, StepMap, Stepper};

/// The product of flows of a [split](super::Noise::Split) step, as a map of systems that have its
/// [parameters](super::Noise::parameters).
#[derive(Clone)]
pub struct SplitNoise {
    /// Those of H alone.
    described: String,
    properties: MapProperties,
    stages: Vec<(Arc<dyn StepMap>, f64)>,
}

impl SplitNoise {
    /// Φ_{t/2} ∘ φ_1 ∘ … ∘ φ_K ∘ … ∘ φ_1 ∘ Φ_{t/2}: Φ of H alone, and a flow for each parameter w_j, of w_j σ_k H_k.
    /// Of a product of χ and χ* the first stands before and the second behind.
    pub fn new(drift: Arc<dyn StepMap>, flows: Vec<Arc<dyn StepMap>>) -> Self {
        let factors = drift.abilities().factored.map(|own| own.factors);
        let [before, behind] = factors.unwrap_or_else(|| [Arc::clone(&drift), Arc::clone(&drift)]);
        let mut stages = vec![(before, 0.5)];
        stages.extend(flows.into_iter().map(|flow| (flow, 1.0)));
        stages.push((behind, 0.5));
        Self {
            described: drift.describe(),
            properties: drift.properties(),
            stages,
        }
    }
}

impl StepMap for SplitNoise {
    fn dimension(&self) -> usize {
        self.stages[0].0.dimension()
    }

    fn properties(&self) -> MapProperties {
        self.properties
    }

    fn describe(&self) -> String {
        let flows = self.stages.len() - 2;
        let noun = if flows == 1 { "flow" } else { "flows" };
        format!("halves of {} about {flows} {noun} of noise", self.described)
    }

    fn abilities(&self) -> MapAbilities<'_> {
        let maps = self.stages[1..].iter();
        MapAbilities {
            kernels: maps.flat_map(|(map, _)| map.abilities().kernels).collect(),
            ..MapAbilities::default()
        }
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let stages = &self.stages;
        Box::new(ProductStepper::new(stages, lanes, parameters, epsilon, h))
    }
}

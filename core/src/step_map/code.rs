//! Step maps by code.

use super::{MapAbilities, StepMap};
use leafwise_solver::{Differential, ExplicitMap, Inverse, MapProperties, Stepper};

/// An explicit map as a [`StepMap`].
#[derive(Clone, Debug)]
pub struct CodeStepMap {
    description: String,
    properties: MapProperties,
    map: ExplicitMap,
}

impl CodeStepMap {
    /// The map with what it promises.
    pub fn new(description: String, properties: MapProperties, map: ExplicitMap) -> Self {
        Self {
            description,
            properties,
            map,
        }
    }
}

impl StepMap for CodeStepMap {
    fn dimension(&self) -> usize {
        self.map.dimension()
    }

    fn properties(&self) -> MapProperties {
        self.properties
    }

    fn describe(&self) -> String {
        self.description.clone()
    }

    fn abilities(&self) -> MapAbilities<'_> {
        MapAbilities {
            kernels: vec![("step", self.map.kernel())],
            ..MapAbilities::default()
        }
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        self.map.stepper(lanes, parameters, epsilon, h)
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        let inverse = match self.properties.self_adjoint {
            Some(true) => Inverse::Opposite,
            _ => Inverse::Solved,
        };
        self.map.differential(parameters, (epsilon, h), inverse)
    }
}

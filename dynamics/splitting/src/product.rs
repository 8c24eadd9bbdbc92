//! Products of a splitting's flows in one order and in the other.

use std::sync::Arc;

use leafwise_core::solver::{MapAbilities, MapProperties, StepMap, Stepper};
use leafwise_core::{BuildError, ByTangents, Differential, Shadow, SystemFormulas};

/// … ∘ χ*_{α_2 h} ∘ χ_{α_1 h} of a splitting, with χ = φʳ ∘ … ∘ φ¹ and χ* = φ¹ ∘ … ∘ φʳ. Alone, χ and
/// χ* are of order 1, each the other's adjoint.
pub(crate) struct Product<S> {
    splitting: S,
    /// α_1, α_2, ….
    parts: Vec<f64>,
}

impl<S: Splits + Clone + 'static> Product<S> {
    pub(crate) fn new(splitting: &S, parts: &[f64]) -> Self {
        Self {
            splitting: splitting.clone(),
            parts: parts.to_vec(),
        }
    }

    /// χ and χ*.
    pub(crate) fn factors(splitting: &S) -> [Arc<dyn StepMap>; 2] {
        let parts: [&[f64]; 2] = [&[1.0], &[0.0, 1.0]];
        parts.map(|parts| -> Arc<dyn StepMap> { Arc::new(Self::new(splitting, parts)) })
    }
}

/// A splitting that makes steppers of any product of χ and χ*.
pub(crate) trait Splits: StepMap {
    /// The shadow Hamiltonian of … ∘ χ*_{α_2 h} ∘ χ_{α_1 h}, as [`StepMap::shadow`].
    ///
    /// # Errors
    /// Those of [`StepMap::shadow`].
    fn passes_shadow(
        &self,
        parts: &[f64],
        system: &SystemFormulas,
        last: usize,
        products: u64,
    ) -> Result<Option<Shadow>, BuildError> {
        let _ = (parts, system, last, products);
        Ok(None)
    }
    /// A stepper of … ∘ χ*_{α_2 h} ∘ χ_{α_1 h}, of any size.
    fn passes_stepper(
        &self,
        parts: &[f64],
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Stepper>;
    /// The same with its differential.
    fn passes_differential(
        &self,
        parts: &[f64],
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Differential> {
        let stepper = self.passes_stepper(parts, 1, parameters, epsilon, h);
        Box::new(ByTangents::new(stepper, self.dimension()))
    }
}

impl<S: Splits> StepMap for Product<S> {
    fn dimension(&self) -> usize {
        self.splitting.dimension()
    }

    fn properties(&self) -> MapProperties {
        MapProperties {
            order: 1,
            structure: self.splitting.properties().structure,
            self_adjoint: Some(is_symmetric(&self.parts)),
        }
    }

    fn describe(&self) -> String {
        let which = match self.parts.as_slice() {
            [_] => "once forwards",
            [0.0, _] => "once backwards",
            _ => "forwards and backwards",
        };
        format!("{}, {which}", self.splitting.describe())
    }

    fn abilities(&self) -> MapAbilities<'_> {
        MapAbilities {
            shadow: Some(Box::new(|system, last, products| {
                self.splitting
                    .passes_shadow(&self.parts, system, last, products)
            })),
            ..MapAbilities::default()
        }
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let parts = &self.parts;
        self.splitting
            .passes_stepper(parts, lanes, parameters, epsilon, h)
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        let parts = &self.parts;
        self.splitting
            .passes_differential(parts, parameters, epsilon, h)
    }
}

/// Whether χ and χ* stand as in a mirror: the product is then self-adjoint.
pub(crate) fn is_symmetric(parts: &[f64]) -> bool {
    parts.len().is_multiple_of(2) && parts.iter().eq(parts.iter().rev())
}

/// Number of evaluations that a product of so many factors χ and χ* counts as: half of them, rounded up.
pub(crate) fn evaluations(parts: &[f64]) -> u64 {
    parts.len().div_ceil(2) as u64
}

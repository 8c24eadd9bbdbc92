//! The product of a splitting's flows in one order, and its adjoint.

use std::sync::Arc;

use leafwise_core::solver::{MapProperties, StepMap, Stepper, Structure};

/// χ = φʳ ∘ … ∘ φ¹ or χ* = φ¹ ∘ … ∘ φʳ of a splitting: of order 1, exactly Poisson, each the other's
/// adjoint.
pub(crate) struct Factor<S> {
    splitting: S,
    is_adjoint: bool,
}

impl<S: Splits + Clone + 'static> Factor<S> {
    /// χ and χ*.
    pub(crate) fn both(splitting: &S) -> [Arc<dyn StepMap>; 2] {
        [false, true].map(|is_adjoint| -> Arc<dyn StepMap> {
            Arc::new(Self {
                splitting: splitting.clone(),
                is_adjoint,
            })
        })
    }
}

/// A splitting that makes steppers of any product of χ and χ*.
pub(crate) trait Splits: StepMap {
    /// A stepper of … ∘ χ*_{α_2 h} ∘ χ_{α_1 h}, of any size.
    fn passes_stepper(
        &self,
        parts: &[f64],
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Stepper>;
}

impl<S: Splits> StepMap for Factor<S> {
    fn dimension(&self) -> usize {
        self.splitting.dimension()
    }

    fn properties(&self) -> MapProperties {
        MapProperties {
            order: 1,
            structure: Structure::Exact,
            self_adjoint: Some(false),
        }
    }

    fn describe(&self) -> String {
        let which = if self.is_adjoint {
            "backwards"
        } else {
            "forwards"
        };
        format!("{}, once {which}", self.splitting.describe())
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let parts: &[f64] = if self.is_adjoint { &[0.0, 1.0] } else { &[1.0] };
        self.splitting
            .passes_stepper(parts, lanes, parameters, epsilon, h)
    }
}

/// What a product of so many factors counts as.
pub(crate) fn evaluations(parts: &[f64]) -> u64 {
    parts.len().div_ceil(2) as u64
}

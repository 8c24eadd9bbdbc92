//! The composition as a step map.

use std::sync::Arc;

use leafwise_core::solver::{
    Compensated, MapAbilities, MapProperties, ProductStepper, StepMap, Stepper,
};
use leafwise_core::{BuildError, Differential, Pieces, Shadow, StepError, SystemFormulas};

use crate::scheme::Scheme;

/// Ψ_h = Φ_{γ_s h} ∘ … ∘ Φ_{γ_1 h}, or χ*_{α_{2s} h} ∘ χ_{α_{2s−1} h} ∘ … ∘ χ*_{α_2 h} ∘ χ_{α_1 h}. The source is
/// Hairer, Lubich, Wanner, *Geometric Numerical Integration*, sections II.4 and V.3.
#[derive(Clone)]
pub struct Composed {
    base: Arc<dyn StepMap>,
    scheme: Scheme,
}

impl Composed {
    /// The composition of `base`.
    ///
    /// # Errors
    /// Fails with [`BuildError::NotComposable`] when `base` does not declare itself self-adjoint. Fails with
    /// [`BuildError::NoFactors`] when the scheme takes factors and `base` offers none. Fails with
    /// [`BuildError::Pieces`] when the pieces of `base` are not those that the scheme was solved for.
    pub fn new(base: Arc<dyn StepMap>, scheme: Scheme) -> Result<Self, BuildError> {
        let is_self_adjoint = base.properties().self_adjoint == Some(true);
        if scheme.takes_factors() && base.abilities().factored.is_none() {
            return Err(BuildError::NoFactors {
                composition: scheme.info.name,
                map: base.describe(),
                is_self_adjoint,
            });
        }
        if !is_self_adjoint {
            return Err(BuildError::NotComposable {
                composition: scheme.info.name,
                map: base.describe(),
            });
        }
        let base = match scheme.pieces {
            Pieces::Any => base,
            asked => {
                let arranged = base.abilities().factored.and_then(|own| own.arranged);
                let arranged = arranged.ok_or_else(|| BuildError::Pieces {
                    map: base.describe(),
                    asked,
                    reason: "its pieces are not known as formulas".to_owned(),
                })?;
                arranged(asked)?
            }
        };
        Ok(Self { base, scheme })
    }

    /// Φ.
    pub fn base(&self) -> &dyn StepMap {
        self.base.as_ref()
    }

    /// Its order and coefficients.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// The factors χ and χ* that its stages are.
    fn factors(&self) -> Option<[Arc<dyn StepMap>; 2]> {
        let factored = self.base.abilities().factored;
        let factored = factored.filter(|_| self.scheme.takes_factors());
        factored.map(|own| own.factors)
    }

    /// All stages as one map, where that takes less.
    fn product(&self) -> Option<Arc<dyn StepMap>> {
        (self.base.abilities().factored?.product)(&self.scheme.parts())
    }

    /// Stages of a step in order: maps, each with its part of the step. They are Φ with the γ_i, or χ and χ* in turn
    /// with the α_i.
    fn stages(&self) -> Vec<(Arc<dyn StepMap>, f64)> {
        let factors = self.factors();
        let coefficients = self.scheme.coefficients().into_iter().enumerate();
        let stage = |(at, part)| match &factors {
            None => (Arc::clone(&self.base), part),
            Some(factors) => (Arc::clone(&factors[at % 2]), part),
        };
        coefficients.map(stage).collect()
    }
}

impl Composed {
    /// The shadow of the product of its stages.
    fn shadow_terms(
        &self,
        system: &SystemFormulas,
        last: usize,
        products: u64,
    ) -> Result<Option<Shadow>, BuildError> {
        let factors = self.factors();
        let maps = factors.map_or_else(|| vec![Arc::clone(&self.base)], Vec::from);
        let mut shadows = Vec::with_capacity(maps.len());
        for map in &maps {
            let Some(shadow) = map.shadow(system, last, products)? else {
                return Ok(None);
            };
            shadows.push(shadow);
        }
        let coefficients = self.scheme.coefficients().into_iter().enumerate();
        let steps: Vec<_> = coefficients
            .map(|(at, part)| (at % shadows.len(), part))
            .collect();
        let shadow = Shadow::of_product(system, &shadows, &steps, last, products)?;
        // A symmetric composition is self-adjoint.
        let order = self.properties().order;
        Ok(shadow.map(|shadow| shadow.keeping(|k| k == 1 || (k > order && k % 2 == 1))))
    }
}

impl StepMap for Composed {
    fn dimension(&self) -> usize {
        self.base.dimension()
    }

    /// The structure is the base's: a product of Poisson maps is one, and a product of maps that
    /// are Poisson up to O(tⁿ⁺¹) is one up to O(tⁿ⁺¹).
    fn properties(&self) -> MapProperties {
        let base = self.base.properties();
        MapProperties {
            order: self.scheme.order_over(base.order),
            structure: base.structure,
            self_adjoint: Some(true),
        }
    }

    fn describe(&self) -> String {
        format!("{} of {}", self.scheme.info.name, self.base.describe())
    }

    fn abilities(&self) -> MapAbilities<'_> {
        MapAbilities {
            kernels: self.base.abilities().kernels,
            shadow: Some(Box::new(|system, last, products| {
                self.shadow_terms(system, last, products)
            })),
            ..MapAbilities::default()
        }
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        if let Some(product) = self.product() {
            return product.stepper(lanes, parameters, epsilon, h);
        }
        Box::new(ProductStepper::new(
            &self.stages(),
            lanes,
            parameters,
            epsilon,
            h,
        ))
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        if let Some(product) = self.product() {
            return product.differential(parameters, epsilon, h);
        }
        let size = self.dimension();
        let stages = self.stages().into_iter();
        let stages = stages.map(|(map, part)| map.differential(parameters, epsilon, part * h));
        Box::new(ComposedDifferential {
            stages: stages.collect(),
            state: Compensated::new(size),
            sum: Compensated::new(size),
        })
    }
}

/// The differential of a product, stage by stage.
struct ComposedDifferential {
    stages: Vec<Box<dyn Differential>>,
    state: Compensated,
    sum: Compensated,
}

impl ComposedDifferential {
    /// Takes the stages one after the other, each from the state that `take` is given, high and low, and sums their increments.
    fn along(
        &mut self,
        [x, low]: [&[f64]; 2],
        increment: &mut [f64],
        mut take: impl FnMut(&mut dyn Differential, [&[f64]; 2], &mut [f64]) -> Result<(), StepError>,
    ) -> Result<(), StepError> {
        self.state.set(x, low);
        self.sum.clear();
        for stage in &mut self.stages {
            let from = [&self.state.high[..], &self.state.low[..]];
            take(stage.as_mut(), from, increment)?;
            self.state.add(increment);
            self.sum.add(increment);
        }
        for (at, increment) in increment.iter_mut().enumerate() {
            *increment = self.sum.high[at] + self.sum.low[at];
        }
        Ok(())
    }
}

impl Differential for ComposedDifferential {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        self.along([x, low], increment, |stage, [x, low], increment| {
            stage.step(x, low, increment)
        })
    }

    fn step_and_pull_inverse(
        &mut self,
        from: [&[f64]; 2],
        increment: &mut [f64],
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        self.along(from, increment, |stage, from, increment| {
            stage.step_and_pull_inverse(from, increment, covector, gradient)
        })
    }

    fn push(&mut self, tangents: &mut [f64], parameters: &[f64]) -> Result<(), StepError> {
        let mut stages = self.stages.iter_mut();
        stages.try_for_each(|stage| stage.push(tangents, parameters))
    }

    fn pull(&mut self, covector: &mut [f64], gradient: &mut [f64]) -> Result<(), StepError> {
        let mut stages = self.stages.iter_mut().rev();
        stages.try_for_each(|stage| stage.pull(covector, gradient))
    }

    fn pull_inverse(
        &mut self,
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        let mut stages = self.stages.iter_mut();
        stages.try_for_each(|stage| stage.pull_inverse(covector, gradient))
    }

    fn knows_parameters(&self) -> bool {
        self.stages.iter().all(|stage| stage.knows_parameters())
    }

    fn operations(&self) -> Option<u64> {
        self.stages.iter().map(|stage| stage.operations()).sum()
    }
}

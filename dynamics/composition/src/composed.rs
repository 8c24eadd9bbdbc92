//! The composition as a step map.

use std::sync::Arc;

use leafwise_core::solver::{MapProperties, SolverStatistics, StepMap, Stepper};
use leafwise_core::{BuildError, Differential, Pieces, Shadow, StepError, SystemFormulas, two_sum};
use leafwise_expression::Kernel;

use crate::scheme::Scheme;

/// Ψ_h = Φ_{γ_s h} ∘ … ∘ Φ_{γ_1 h}, or χ*_{α_{2s} h} ∘ χ_{α_{2s−1} h} ∘ … ∘ χ*_{α_2 h} ∘ χ_{α_1 h} (Hairer, Lubich, Wanner,
/// *Geometric Numerical Integration*, sections II.4 and V.3).
#[derive(Clone)]
pub struct Composed {
    base: Arc<dyn StepMap>,
    scheme: Scheme,
}

impl Composed {
    /// The composition of `base`.
    ///
    /// # Errors
    /// [`BuildError::NotComposable`] when `base` does not declare itself self-adjoint,
    /// [`BuildError::NoFactors`] when the scheme takes its factors and it offers none,
    /// [`BuildError::Pieces`] when these are not those that the scheme was solved for.
    pub fn new(base: Arc<dyn StepMap>, scheme: Scheme) -> Result<Self, BuildError> {
        if scheme.takes_factors() && base.factors().is_none() {
            return Err(BuildError::NoFactors {
                composition: scheme.info.name,
                map: base.describe(),
            });
        }
        if base.properties().self_adjoint != Some(true) {
            return Err(BuildError::NotComposable {
                composition: scheme.info.name,
                map: base.describe(),
            });
        }
        let base = match scheme.pieces {
            Pieces::Any => base,
            asked => base.arranged(asked)?,
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

    /// What is applied one after the other, each over its part of the step.
    fn stages(&self) -> Vec<(Arc<dyn StepMap>, f64)> {
        let factors = self.base.factors().filter(|_| self.scheme.takes_factors());
        let coefficients = self.scheme.coefficients().into_iter().enumerate();
        let stage = |(at, part)| match &factors {
            None => (Arc::clone(&self.base), part),
            Some(factors) => (Arc::clone(&factors[at % 2]), part),
        };
        coefficients.map(stage).collect()
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

    fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        self.base.kernels()
    }

    fn shadow(
        &self,
        system: &SystemFormulas,
        last: usize,
        products: u64,
    ) -> Result<Option<Shadow>, BuildError> {
        let factors = self.base.factors().filter(|_| self.scheme.takes_factors());
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

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        if let Some(product) = self.base.product(&self.scheme.parts()) {
            return product.stepper(lanes, parameters, epsilon, h);
        }
        let size = self.dimension() * lanes;
        let stages = self.stages().into_iter();
        let stages = stages.map(|(map, part)| map.stepper(lanes, parameters, epsilon, part * h));
        Box::new(ComposedStepper {
            parts: self.scheme.coefficients(),
            stages: stages.collect(),
            state: Compensated::new(size),
            sum: Compensated::new(size),
            increment: vec![0.0; size],
            outcome: vec![Ok(()); lanes],
            dimension: self.dimension(),
            steps: 0,
            failures: 0,
        })
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        if let Some(product) = self.base.product(&self.scheme.parts()) {
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

/// A vector held as unevaluated sums high + low.
struct Compensated {
    high: Vec<f64>,
    low: Vec<f64>,
}

impl Compensated {
    fn new(size: usize) -> Self {
        Self {
            high: vec![0.0; size],
            low: vec![0.0; size],
        }
    }

    fn set(&mut self, high: &[f64], low: &[f64]) {
        self.high.copy_from_slice(high);
        self.low.copy_from_slice(low);
    }

    fn clear(&mut self) {
        self.high.fill(0.0);
        self.low.fill(0.0);
    }

    fn add(&mut self, change: &[f64]) {
        for ((high, low), change) in self.high.iter_mut().zip(&mut self.low).zip(change) {
            let (sum, error) = two_sum(*high, *change);
            (*high, *low) = two_sum(sum, error + *low);
        }
    }
}

/// One stepper a stage, with its own step size and its own history: the i-th stages of successive
/// steps lie on one smooth curve, so that what a stage learned serves the same stage a step later.
///
/// States between stages carry their compensation, and the stages' increments are summed with
/// theirs, so that a composed step rounds no more than its stages do.
struct ComposedStepper {
    /// Each stage's part of the step.
    parts: Vec<f64>,
    stages: Vec<Box<dyn Stepper>>,
    state: Compensated,
    sum: Compensated,
    increment: Vec<f64>,
    outcome: Vec<Result<(), StepError>>,
    dimension: usize,
    steps: u64,
    failures: u64,
}

impl Stepper for ComposedStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let lanes = outcome.len();
        outcome.fill(Ok(()));
        self.state.set(x, low);
        self.sum.clear();
        for stage in &mut self.stages {
            stage.increment(
                &self.state.high,
                &self.state.low,
                &mut self.increment,
                &mut self.outcome,
            );
            self.state.add(&self.increment);
            self.sum.add(&self.increment);
            for lane in 0..lanes {
                if let (Ok(()), Err(error)) = (&outcome[lane], &self.outcome[lane]) {
                    outcome[lane] = Err(error.clone());
                }
                if outcome[lane].is_err() {
                    // The stages after a failed one fail as well and forget, whatever the other
                    // lanes do: a lane's history does not depend on its neighbours.
                    let places = self.state.high.iter_mut().skip(lane).step_by(lanes);
                    places.for_each(|place| *place = f64::NAN);
                }
            }
        }
        self.steps += lanes as u64;
        for lane in 0..lanes {
            let places = (0..self.dimension).map(|i| i * lanes + lane);
            if outcome[lane].is_ok() {
                places.for_each(|at| increment[at] = self.sum.high[at] + self.sum.low[at]);
            } else {
                self.failures += 1;
                places.for_each(|at| increment[at] = 0.0);
            }
        }
    }

    /// DΨ = DΦ_{γ_s h} ⋯ DΦ_{γ_1 h}, each at its own stage.
    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let d = self.dimension;
        let mut product: Option<Vec<f64>> = None;
        for stage in &mut self.stages {
            let factor = stage.tangent(lane)?;
            product = Some(match product {
                None => factor,
                Some(earlier) => multiply(&factor, &earlier, d),
            });
        }
        product
    }

    fn restart(&mut self) {
        self.stages.iter_mut().for_each(|stage| stage.restart());
    }

    fn resize(&mut self, h: f64) -> bool {
        let stages = self.stages.iter_mut().zip(&self.parts);
        // Stages are of one kind: the first says for all whether they can.
        stages.fold(true, |all, (stage, part)| all && stage.resize(part * h))
    }

    /// Steps and failures are those of whole steps; evaluations are summed over the stages, and so
    /// is the largest number, which then bounds that of one step. Rounded steps are those of the stage
    /// that has most.
    fn statistics(&self) -> SolverStatistics {
        let stages = self.stages.iter().map(|stage| stage.statistics());
        stages.fold(
            SolverStatistics {
                steps: self.steps,
                failures: self.failures,
                ..SolverStatistics::default()
            },
            |sum, stage| SolverStatistics {
                operations: sum.operations.zip(stage.operations).map(|(a, b)| a + b),
                evaluations: sum.evaluations + stage.evaluations,
                most_evaluations: sum.most_evaluations + stage.most_evaluations,
                rounded: sum.rounded.max(stage.rounded),
                ..sum
            },
        )
    }

    fn memory(&self) -> Vec<f64> {
        self.stages
            .iter()
            .flat_map(|stage| stage.memory())
            .collect()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let lengths: Vec<usize> = self.stages.iter().map(|s| s.memory().len()).collect();
        let expected = lengths.iter().sum();
        if memory.len() != expected {
            return Err(expected);
        }
        let mut rest = memory;
        for (stage, length) in self.stages.iter_mut().zip(lengths) {
            let (own, others) = rest.split_at(length);
            stage.restore(own)?;
            rest = others;
        }
        Ok(())
    }
}

/// a·b, row-major d × d.
fn multiply(a: &[f64], b: &[f64], d: usize) -> Vec<f64> {
    let entry = |at: usize| (0..d).map(|k| a[at / d * d + k] * b[k * d + at % d]).sum();
    (0..d * d).map(entry).collect()
}

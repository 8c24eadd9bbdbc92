//! Step maps M → M: by code, as products, without crossing poles.

mod code;
mod one_length;
mod poles;
mod product;
mod signs;
mod walls;

pub use code::CodeStepMap;
pub use one_length::of_one_length;
pub use poles::{Poles, WithoutPoles};
pub use product::ProductStepper;
pub use signs::{keeping_signs, kept_signs};
pub use walls::Walls;

use std::sync::Arc;

use leafwise_expression::Kernel;
use leafwise_solver::{ByTangents, Differential, MapProperties, Pieces, StepCheck, Stepper};

use crate::error::BuildError;
use crate::shadow::{MakeShadowEnergy, Shadow};
use crate::system::SystemFormulas;

/// Maker of step checks for so many lanes with these parameters, a structure of arrays.
pub(crate) trait MakeCheck: Send + Sync {
    fn make(self: Arc<Self>, lanes: usize, parameters: &[f64]) -> Box<dyn StepCheck>;
}

/// A step map M → M with a fixed choice of step sizes ready to be made.
pub trait StepMap: Send + Sync {
    /// d.
    fn dimension(&self) -> usize;
    /// Properties that the map promises.
    fn properties(&self) -> MapProperties;
    /// One line for reports: names and orders.
    fn describe(&self) -> String;
    /// A stepper of `lanes` trajectories at once with these parameters (a structure of
    /// arrays over the lanes) and step sizes.
    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper>;
    /// One trajectory's steps with their derivatives by the state, and by the parameters where that is known.
    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        let stepper = self.stepper(1, parameters, epsilon, h);
        Box::new(ByTangents::new(stepper, self.dimension()))
    }
    /// Abilities beside its steps: `MapAbilities { kernels, ..MapAbilities::default() }`.
    fn abilities(&self) -> MapAbilities<'_> {
        MapAbilities::default()
    }
}

/// Abilities of a step map beside its steps. By default nothing is offered.
#[derive(Default)]
pub struct MapAbilities<'a> {
    /// The kernels that its steps evaluate and what each computes, for reports; none where the steps are numbers from
    /// elsewhere.
    pub kernels: Vec<(&'static str, &'a Kernel)>,
    /// Its [`Shadow`] Hamiltonian, where there is a formula of it.
    pub shadow: Option<ShadowTerms<'a>>,
    /// H̃ up to its first term behind H as numbers, where the steps are.
    pub shadow_energy: Option<Arc<MakeShadowEnergy>>,
    /// The map as a product of two factors, where it is one.
    pub factored: Option<Factored<'a>>,
}

impl MapAbilities<'_> {
    /// Those of a map whose steps are made of this one's by other numbers in each: its kernels, and nothing else.
    pub fn kernels_alone(self) -> Self {
        Self {
            kernels: self.kernels,
            ..Self::default()
        }
    }
}

/// Terms F_1 to F_last of the [`Shadow`] Hamiltonian of a map of a system: of the system, last, and the most products of
/// terms that they may take. It returns `None` where they take more.
///
/// It fails with [`BuildError::Algebra`] where the tensor or the Hamiltonian is outside the exact algebra.
pub type ShadowTerms<'a> =
    Box<dyn Fn(&SystemFormulas, usize, u64) -> Result<Option<Shadow>, BuildError> + 'a>;

/// Φ_h = χ*_{h/2} ∘ χ_{h/2} of a map χ of order 1 and its adjoint, χ*_h = χ_{−h}⁻¹.
pub struct Factored<'a> {
    /// χ and χ*.
    pub factors: [Arc<dyn StepMap>; 2],
    /// How many pieces the factors are products of, where the parameter `pieces` of the part names their order.
    pub pieces: usize,
    /// The same map of other factors, where the pieces are known as formulas.
    pub arranged: Option<Arranged<'a>>,
    /// The product … ∘ χ*_{α_4 h} ∘ χ_{α_3 h} ∘ χ*_{α_2 h} ∘ χ_{α_1 h}, where that takes less than one factor after the
    /// other. The composition Φ_{γ_s h} ∘ … ∘ Φ_{γ_1 h} has α_{2i−1} = α_{2i} = γ_i/2. Two factors count as an evaluation.
    pub product: FactorProduct<'a>,
}

/// Of α_1, α_2, …, their product where it is offered.
pub type FactorProduct<'a> = Box<dyn Fn(&[f64]) -> Option<Arc<dyn StepMap>> + 'a>;

/// A map's pieces as a composition asks for them. It fails with [`BuildError::Pieces`] where they are not of that kind, or it
/// cannot be proved.
pub type Arranged<'a> = Box<dyn Fn(Pieces) -> Result<Arc<dyn StepMap>, BuildError> + 'a>;

impl dyn StepMap + '_ {
    /// How many pieces its [factors](MapAbilities::factored) are products of; 0 where it is no product.
    pub fn pieces(&self) -> usize {
        self.abilities().factored.map_or(0, |own| own.pieces)
    }

    /// The [`ShadowTerms`] of this map of a system; `None` where there is no formula of them.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the tensor or the Hamiltonian is outside the exact algebra.
    pub fn shadow(
        &self,
        system: &SystemFormulas,
        last: usize,
        products: u64,
    ) -> Result<Option<Shadow>, BuildError> {
        match self.abilities().shadow {
            Some(terms) => terms(system, last, products),
            None => Ok(None),
        }
    }
}

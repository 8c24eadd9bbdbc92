//! The step solver: β̂(L(y)) = x for y, and the increment α̂ − β̂ there.

mod anderson;
mod branch;
mod checked;
mod columns;
mod crossing;
mod differential;
mod elimination;
mod explicit;
mod extrapolation;
mod iteration;
pub mod judge;
mod lanes;
mod linear;
mod newton;
mod numeric;
pub mod poles;
mod product;
mod properties;
mod signs;
mod statistics;
mod stepper;
mod walls;

pub use crate::compensation::Compensated;
pub use anderson::Anderson;
pub use branch::Branch;
pub(crate) use checked::{Checked, MakeCheck};
pub use columns::product;
pub(crate) use crossing::{Crossing, looks};
pub use differential::{ByTangents, Differential, Inverse};
pub(crate) use differential::{Explicit, Solved, by_parameters, in_reverse, one_step};
pub use explicit::{CodeStepMap, ExplicitMap};
pub use extrapolation::Extrapolation;
pub use iteration::{CorrectionMethod, Iteration};
pub use judge::{CorrectionSize, LinearIteration};
pub use lanes::{Lanes, StepReport, Trajectories};
pub use linear::{
    DenseFactors, MOST_EQUATIONS, MOST_VARIABLES, check_equations, check_variables,
    elimination_operations, substitution_operations,
};
pub use newton::{NewtonKernel, NewtonStepper};
pub(crate) use newton::{StartCode, Uncoupled};
pub(crate) use numeric::NumericSolver;
pub use poles::{Poles, WithoutPoles};
pub use product::ProductStepper;
pub use properties::{MapProperties, Pieces, Structure};
pub use signs::{keeping_signs, kept_signs};
pub use statistics::SolverStatistics;
pub(crate) use stepper::add;
pub use stepper::{StepCheck, Stepper};
use stepper::{one_by_one, restore_each};
pub use walls::Walls;

use std::sync::Arc;

use leafwise_expression::Kernel;

use crate::error::BuildError;
use crate::shadow::Shadow;
use crate::system::SystemFormulas;

/// DΦ = 1 + D((α̂ − β̂)∘L)·D(β̂∘L)⁻¹ from the two tangents at the solution, all row-major d × d.
pub(crate) fn tangent_of_map(target: &[f64], change: &[f64], d: usize) -> Option<Vec<f64>> {
    let target = nalgebra::DMatrix::from_row_slice(d, d, target);
    let change = nalgebra::DMatrix::from_row_slice(d, d, change);
    let tangent = nalgebra::DMatrix::identity(d, d) + change * target.lu().try_inverse()?;
    Some(tangent.transpose().as_slice().to_vec())
}

/// A step map M → M with a fixed choice of step sizes ready to be made.
pub trait StepMap: Send + Sync {
    /// d.
    fn dimension(&self) -> usize;
    /// Properties that the map promises.
    fn properties(&self) -> MapProperties;
    /// One line for reports: names and orders.
    fn describe(&self) -> String;
    /// The kernels that its steps evaluate and what each computes, for reports; none where the
    /// steps are numbers from elsewhere.
    fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        Vec::new()
    }
    /// A stepper of `lanes` trajectories at once with these parameters (a structure of
    /// arrays over the lanes) and step sizes.
    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper>;
    /// One trajectory's steps with their derivatives by the state, and by the parameters where that is known.
    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        let stepper = self.stepper(1, parameters, epsilon, h);
        Box::new(ByTangents::new(stepper, self.dimension()))
    }
    /// [`Shadow`] Hamiltonian of this map of a system, its terms F_1 to F_`last`. Returns `None` where there is no
    /// formula of it. It also does so where that takes more than `products` products of terms.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the tensor or the Hamiltonian is outside the exact algebra.
    fn shadow(
        &self,
        system: &SystemFormulas,
        last: usize,
        products: u64,
    ) -> Result<Option<Shadow>, BuildError> {
        let _ = (system, last, products);
        Ok(None)
    }
    /// The map as a product of two factors, where it is one.
    fn factored(&self) -> Option<Factored<'_>> {
        None
    }
}

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
    /// How many pieces its [factors](StepMap::factored) are products of; 0 where it is no product.
    pub fn pieces(&self) -> usize {
        self.factored().map_or(0, |own| own.pieces)
    }
}

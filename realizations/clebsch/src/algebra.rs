//! Algebras given by quadratic forms of z with their brackets and a section, which takes states to points z.

use std::fmt;
use std::sync::Arc;

use leafwise_core::StepError;
use leafwise_expression::Rational;

use crate::forms::Forms;

/// The name of the part.
pub const NAME: &str = "clebsch";

/// A z over y, all copies one behind the other, and the signs of the copies.
pub type Section =
    Arc<dyn Fn(&[f64], &mut [f64], &mut [f64]) -> Result<(), StepError> + Send + Sync>;

/// y_k = ½ Σ_a σ_a z_aᵀS_k z_a over copies z_a with {z_a, z_a} = σ_a Ω: a momentum map of an algebra whose fibres are orbits
/// of affine symmetries.
#[derive(Clone)]
pub struct Algebra {
    /// Its name in reports.
    pub name: &'static str,
    /// S_k, of one copy.
    pub forms: Forms,
    /// Ω of one copy, row-major.
    pub omega: Vec<Rational>,
    /// How many copies there are.
    pub copies: usize,
    /// Whether signs σ_a = ±1 belong to a point; all are 1 otherwise.
    pub is_signed: bool,
    /// The z over y.
    pub section: Section,
    /// Moves a z back along its fibre, where that has no bounds.
    pub settle: Option<fn(&mut [f64])>,
    /// Where groups of coordinates of a copy end that are of one size each.
    pub groups: &'static [usize],
}

impl fmt::Debug for Algebra {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// {q_a, p_a} = c for the coordinates (q, p) of these pairs.
pub fn canonical(coordinates: usize, pairs: &[(usize, usize)], c: i64) -> Vec<Rational> {
    let mut omega = vec![Rational::from_integer(0); coordinates * coordinates];
    for &(q, p) in pairs {
        omega[q * coordinates + p] = Rational::from_integer(c);
        omega[p * coordinates + q] = Rational::from_integer(-c);
    }
    omega
}

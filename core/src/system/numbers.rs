//! Poisson systems that compute values and offer no formulas.

use std::sync::Arc;

use super::Parameter;
use crate::error::{BuildError, StepError};

/// A Poisson system known by its values: (M ≅ ℝᵈ, π, H) as functions to call.
#[derive(Clone, Debug)]
pub struct OpaqueSystem {
    /// Name in messages: the id of the part that offers it.
    pub name: String,
    /// The variables' names; as many as M has dimensions.
    pub variables: Vec<String>,
    /// The parameters, in the order in which [`SystemNumbers::evaluator`] takes their values.
    pub parameters: Vec<Parameter>,
    /// The Casimirs' names, in the order of [`SystemEvaluator::casimirs`].
    pub casimirs: Vec<String>,
    /// The values.
    pub numbers: Arc<dyn SystemNumbers>,
}

impl OpaqueSystem {
    /// The refusal of a part that needs more than the system has.
    pub fn not_offered(&self, part: &'static str, missing: &'static str) -> BuildError {
        BuildError::NotOffered {
            part,
            system: self.name.clone(),
            missing,
        }
    }
}

/// Values of a Poisson system, in the paper's convention Π_ij = {x_i, x_j}, ẋ = −Π ∇H.
pub trait SystemNumbers: Send + Sync + std::fmt::Debug {
    /// Which derivatives there are beside ∇H.
    fn derivatives(&self) -> Derivatives;
    /// One thread's evaluator for these values of the parameters.
    fn evaluator(&self, parameters: &[f64]) -> Box<dyn SystemEvaluator>;
    /// The same for states that are tried, to which no motion may come: what it refuses is of no account.
    fn evaluator_on_trial(&self, parameters: &[f64]) -> Box<dyn SystemEvaluator> {
        self.evaluator(parameters)
    }
}

/// Derivatives that a system of numbers offers, exact to round-off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Derivatives {
    /// [`SystemEvaluator::tensor_tangent`].
    pub tensor: bool,
    /// [`SystemEvaluator::hessian`].
    pub hamiltonian: bool,
    /// [`SystemEvaluator::casimir_gradients`].
    pub casimirs: bool,
}

impl Derivatives {
    /// Whether X_H = −Π∇H has a Jacobian.
    pub fn of_field(self) -> bool {
        self.tensor && self.hamiltonian
    }
}

/// One thread's evaluator of a system, for fixed parameters.
///
/// Every function takes a batch of contiguous points: d numbers a point, and as many points
/// as `out` holds results. A vector argument holds d numbers for each point, or d numbers that serve
/// all of them; so may the point itself, where vectors differ. What is written for a point depends on that point alone.
pub trait SystemEvaluator: Send {
    /// Π(y)v, (Πv)_i = Σ_j Π_ij(y) v_j: d results a point.
    ///
    /// # Errors
    /// [`StepError`] outside the system's domain, with `out` unspecified; so in every function here.
    fn tensor(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), StepError>;
    /// H(y): one result a point.
    ///
    /// # Errors
    /// As [`tensor`](Self::tensor).
    fn hamiltonian(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError>;
    /// ∇H(y): d results a point.
    ///
    /// # Errors
    /// As [`tensor`](Self::tensor).
    fn gradient(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError>;
    /// Every Casimir at y: as many results a point.
    ///
    /// # Errors
    /// As [`tensor`](Self::tensor).
    fn casimirs(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError>;
    /// The derivative of Π(y)v along y in the direction w, Σ_jk ∂_k Π_ij(y) v_j w_k: d results a point.
    ///
    /// # Errors
    /// As [`tensor`](Self::tensor); [`StepError::NoTangent`] unless [`Derivatives::tensor`].
    fn tensor_tangent(
        &mut self,
        y: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        let _ = (y, v, w, out);
        Err(StepError::NoTangent)
    }
    /// D²H(y)v: d results a point.
    ///
    /// # Errors
    /// As [`tensor`](Self::tensor); [`StepError::NoTangent`] unless [`Derivatives::hamiltonian`].
    fn hessian(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let _ = (y, v, out);
        Err(StepError::NoTangent)
    }
    /// Operations so far, as [`SolverStatistics::operations`] counts them; `None` for a system that
    /// does not count.
    ///
    /// [`SolverStatistics::operations`]: crate::SolverStatistics::operations
    fn operations(&self) -> Option<u64> {
        None
    }
    /// The gradients of the Casimirs, contiguous: d results a Casimir and point.
    ///
    /// # Errors
    /// As [`tensor`](Self::tensor); [`StepError::NoTangent`] unless [`Derivatives::casimirs`].
    fn casimir_gradients(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let _ = (y, out);
        Err(StepError::NoTangent)
    }
}

/// The vector of point `at` of a batch argument of [`SystemEvaluator`]: its own, or the one that serves
/// all points.
pub fn vector(values: &[f64], dimension: usize, at: usize) -> &[f64] {
    if values.len() == dimension {
        values
    } else {
        &values[at * dimension..][..dimension]
    }
}

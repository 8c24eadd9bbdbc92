//! Poisson systems that compute values and offer no formulas.

use std::sync::Arc;

use leafwise_solver::StepCheck;

use super::rounding::FieldRounding;
use super::terms::BodyTerms;
use super::{MotionClass, Parameter};
use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::runge_kutta::SmoothMap;

/// A Poisson system known by its values: (M ≅ ℝᵈ, π, H) as functions to call.
#[derive(Clone, Debug)]
pub struct OpaqueSystem {
    /// Name in messages: the id of the part that offers it.
    pub name: String,
    /// The variables' names; as many as M has dimensions.
    pub variables: Vec<String>,
    /// The parameters, in the order in which [`SystemNumbers::evaluator`] takes their values.
    pub parameters: Vec<Parameter>,
    /// The Casimirs' names, in the order of [`SystemFunction::Casimirs`].
    pub casimirs: Vec<String>,
    /// The values.
    pub numbers: SystemNumbers,
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
#[derive(Clone)]
pub struct SystemNumbers {
    /// The derivatives that there are beside ∇H.
    pub derivatives: Derivatives,
    make: Arc<MakeEvaluator>,
    make_on_trial: Arc<MakeEvaluator>,
    field: Option<Arc<MakeField>>,
    motion: MotionClass,
    has_resting_tensor: bool,
    is_derived: bool,
    shears: Vec<Shear>,
    terms: Option<Arc<BodyTerms>>,
    tangent: Option<Arc<MakeFieldTangent>>,
    jets: Option<Arc<MakeJet>>,
    poles: Option<Arc<MakePoles>>,
    rounding: Option<Arc<MakeRounding>>,
}

/// Maker of bounds on the rounding errors of the field. It fails where a formula has no code.
pub type MakeRounding = dyn Fn() -> Result<FieldRounding, BuildError> + Send + Sync;

/// Maker of the check that steps cross no pole, of a number of lanes and their parameters, a structure of arrays.
pub type MakePoles = dyn Fn(usize, &[f64]) -> Box<dyn StepCheck> + Send + Sync;

/// The Taylor coefficients of the motion of a system of numbers.
pub struct Jet {
    /// x ↦ (x_1, …, x_p) with x(t) = Σ x_k (t/h)ᵏ the motion through x; h is the evaluator's.
    pub map: SmoothMap,
    /// Rounding errors of the field.
    pub rounding: FieldRounding,
    /// Whether the field may jump.
    pub has_seams: bool,
}

/// Maker of the Taylor coefficients of the motion to an order. It fails where a formula has no series.
pub type MakeJet = dyn Fn(usize) -> Result<Jet, BuildError> + Send + Sync;

/// Maker of one thread's products with the Jacobian of X_H = −Π∇H, of parameters.
///
/// The first makes DX(y) v of y with v behind it, the second DX(y)ᵀ w of y with w. They cost a few evaluations each,
/// without the Jacobian itself.
pub type MakeFieldTangent = dyn Fn(&[f64]) -> [Box<dyn Evaluator>; 2] + Send + Sync;

/// A part H_k of H that moves coordinates which its field X does not depend on: its flow is x + t X(x).
#[derive(Clone)]
pub struct Shear {
    make: Arc<MakeField>,
    is_affine: bool,
    moves: Arc<[usize]>,
}

impl Shear {
    /// Evaluators of X, as [`MakeField`] says of X_H; whether X is affine in what moves; the coordinates that it moves. Their
    /// rows of X are those of X_H.
    pub fn new(
        is_affine: bool,
        moves: impl Into<Arc<[usize]>>,
        make: impl Fn(&[f64], usize) -> Box<dyn Evaluator> + Send + Sync + 'static,
    ) -> Self {
        Self {
            make: Arc::new(make),
            is_affine,
            moves: moves.into(),
        }
    }

    /// The coordinates that it moves.
    pub fn moves(&self) -> &[usize] {
        &self.moves
    }

    /// One thread's evaluator of X at so many points side by side.
    pub fn evaluator(&self, parameters: &[f64], points: usize) -> Box<dyn Evaluator> {
        (self.make)(parameters, points)
    }

    /// Whether X is affine in the coordinates that move, as that of p²/2m.
    pub fn is_affine(&self) -> bool {
        self.is_affine
    }
}

type MakeEvaluator = dyn Fn(&[f64]) -> Box<dyn SystemEvaluator> + Send + Sync;
/// Maker of evaluators of X_H = −Π∇H, or of the field with forces, at points side by side, of parameters and of the number of
/// points.
///
/// Such an evaluator is a map of all points at once: coordinate c of point w stands at `[c*points + w]`, and so does its
/// velocity. Where there is none, it is no number. A point's result has the same bits whatever stands beside it.
pub type MakeField = dyn Fn(&[f64], usize) -> Box<dyn Evaluator> + Send + Sync;

impl SystemNumbers {
    /// Values whose evaluators `make` makes, one a thread, of values of the parameters.
    pub fn new(
        derivatives: Derivatives,
        make: impl Fn(&[f64]) -> Box<dyn SystemEvaluator> + Send + Sync + 'static,
    ) -> Self {
        let make: Arc<MakeEvaluator> = Arc::new(make);
        Self {
            derivatives,
            make_on_trial: Arc::clone(&make),
            make,
            field: None,
            motion: MotionClass::default(),
            has_resting_tensor: false,
            is_derived: false,
            shears: Vec::new(),
            terms: None,
            tangent: None,
            jets: None,
            poles: None,
            rounding: None,
        }
    }

    /// The same with bounds on the rounding errors of the field.
    #[must_use]
    pub fn with_rounding(
        mut self,
        make: impl Fn() -> Result<FieldRounding, BuildError> + Send + Sync + 'static,
    ) -> Self {
        self.rounding = Some(Arc::new(make));
        self
    }

    /// Bounds on the rounding errors of the field, where they are known.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub(crate) fn rounding(&self) -> Result<Option<FieldRounding>, BuildError> {
        self.rounding.as_ref().map(|make| make()).transpose()
    }

    /// The same with poles of the equations of motion, which no step crosses.
    #[must_use]
    pub fn with_poles(
        mut self,
        make: impl Fn(usize, &[f64]) -> Box<dyn StepCheck> + Send + Sync + 'static,
    ) -> Self {
        self.poles = Some(Arc::new(make));
        self
    }

    /// Makes the check that steps cross no pole, where there are some.
    pub fn poles(&self) -> Option<Arc<MakePoles>> {
        self.poles.clone()
    }

    /// The same with Taylor coefficients of the motion.
    #[must_use]
    pub fn with_jets(
        mut self,
        make: impl Fn(usize) -> Result<Jet, BuildError> + Send + Sync + 'static,
    ) -> Self {
        self.jets = Some(Arc::new(make));
        self
    }

    /// Makes the Taylor coefficients of the motion, where these are offered.
    pub fn jets(&self) -> Option<&MakeJet> {
        self.jets.as_deref()
    }

    /// The same with products with the Jacobian of X_H.
    #[must_use]
    pub fn with_field_tangent(
        mut self,
        make: impl Fn(&[f64]) -> [Box<dyn Evaluator>; 2] + Send + Sync + 'static,
    ) -> Self {
        self.tangent = Some(Arc::new(make));
        self
    }

    /// Makes products with the Jacobian of X_H, where these are offered.
    pub fn field_tangent(&self) -> Option<Arc<MakeFieldTangent>> {
        self.tangent.clone()
    }

    /// The same with evaluators of X_H at points side by side, as [`MakeField`] says.
    #[must_use]
    pub fn with_field(
        mut self,
        make: impl Fn(&[f64], usize) -> Box<dyn Evaluator> + Send + Sync + 'static,
    ) -> Self {
        self.field = Some(Arc::new(make));
        self
    }

    /// The same with forces in the [field](Self::with_field), which is then not −Π∇H.
    #[must_use]
    pub fn with_motion(mut self, motion: MotionClass) -> Self {
        self.motion = motion;
        self
    }

    /// Whether the field has forces or a friction.
    pub fn motion(&self) -> MotionClass {
        self.motion
    }

    /// The same with a tensor that is constant, or depends on coordinates alone that rest in every motion.
    #[must_use]
    pub fn with_resting_tensor(mut self) -> Self {
        self.has_resting_tensor = true;
        self
    }

    /// The same with ∇H that exact algebra derived from the formula of H: [`find_inconsistency`](crate::diagnostics::find_inconsistency)
    /// has nothing to look for.
    pub fn with_derived_gradient(mut self) -> Self {
        self.is_derived = true;
        self
    }

    /// Whether ∇H was derived from the formula of H.
    pub fn has_derived_gradient(&self) -> bool {
        self.is_derived
    }

    /// The same with H as a sum of parts whose flows are shears.
    #[must_use]
    pub fn with_shears(mut self, shears: Vec<Shear>) -> Self {
        self.shears = shears;
        self
    }

    /// The parts of H whose flows are shears, where H is known to be a sum of such.
    pub fn shears(&self) -> &[Shear] {
        &self.shears
    }

    /// The same with H as a sum of terms of sites and of pairs of sites.
    #[must_use]
    pub fn with_terms(mut self, terms: BodyTerms) -> Self {
        self.terms = Some(Arc::new(terms));
        self
    }

    /// The terms of H of sites and of pairs, where H is known to be a sum of such.
    pub fn terms(&self) -> Option<Arc<BodyTerms>> {
        self.terms.clone()
    }

    /// Whether the tensor is known to be constant, or to depend on coordinates alone that rest.
    pub fn has_resting_tensor(&self) -> bool {
        self.has_resting_tensor
    }

    /// Makes evaluators of X_H at points side by side, where these are offered.
    pub(crate) fn field(&self) -> Option<Arc<MakeField>> {
        self.field.clone()
    }

    /// The same with evaluators of their own for states that are tried.
    #[must_use]
    pub fn with_trials(
        mut self,
        make: impl Fn(&[f64]) -> Box<dyn SystemEvaluator> + Send + Sync + 'static,
    ) -> Self {
        self.make_on_trial = Arc::new(make);
        self
    }

    /// One thread's evaluator for these values of the parameters.
    pub fn evaluator(&self, parameters: &[f64]) -> Box<dyn SystemEvaluator> {
        (self.make)(parameters)
    }

    /// The same for states that are tried, to which no motion may come: what it refuses is of no account.
    pub fn evaluator_on_trial(&self, parameters: &[f64]) -> Box<dyn SystemEvaluator> {
        (self.make_on_trial)(parameters)
    }
}

impl std::fmt::Debug for SystemNumbers {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut text = f.debug_struct("SystemNumbers");
        text.field("derivatives", &self.derivatives)
            .finish_non_exhaustive()
    }
}

/// Derivatives that a system of numbers offers, exact to round-off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Derivatives {
    /// [`SystemFunction::TensorTangent`].
    pub tensor: bool,
    /// [`SystemFunction::Hessian`].
    pub hamiltonian: bool,
    /// [`SystemFunction::CasimirGradients`].
    pub casimirs: bool,
}

impl Derivatives {
    /// Whether X_H = −Π∇H has a Jacobian.
    pub fn of_field(self) -> bool {
        self.tensor && self.hamiltonian
    }
}

/// Functions of a state y that a [`SystemEvaluator`] evaluates, with their vectors.
#[derive(Clone, Copy, Debug)]
pub enum SystemFunction<'a> {
    /// Π(y)v, (Πv)_i = Σ_j Π_ij(y) v_j: d results a point.
    Tensor(&'a [f64]),
    /// H(y): one result a point.
    Hamiltonian,
    /// ∇H(y): d results a point.
    Gradient,
    /// Every Casimir at y: as many results a point.
    Casimirs,
    /// The derivative of Π(y)v along y in the direction w, Σ_jk ∂_k Π_ij(y) v_j w_k: d results a point.
    TensorTangent(&'a [f64], &'a [f64]),
    /// D²H(y)v: d results a point.
    Hessian(&'a [f64]),
    /// The gradients of the Casimirs, contiguous: d results a Casimir and point.
    CasimirGradients,
}

impl<'a> SystemFunction<'a> {
    /// The vectors v and w; empty where there are none.
    pub fn vectors(self) -> [&'a [f64]; 2] {
        match self {
            Self::Tensor(v) | Self::Hessian(v) => [v, &[]],
            Self::TensorTangent(v, w) => [v, w],
            _ => [&[]; 2],
        }
    }
}

/// One thread's evaluator of a system, for fixed parameters.
///
/// Every function takes a batch of contiguous points: d numbers a point, and as many points
/// as `out` holds results. A vector argument holds d numbers for each point, or d numbers that serve
/// all of them; so may the point itself, where vectors differ. What is written for a point depends on that point alone.
pub trait SystemEvaluator: Send {
    /// A function at y.
    ///
    /// # Errors
    /// [`StepError`] outside the system's domain, with `out` unspecified; [`StepError::NoTangent`] for one that the
    /// [`Derivatives`] leave out.
    fn evaluate(
        &mut self,
        function: SystemFunction<'_>,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError>;
    /// Operations so far, as [`SolverStatistics::operations`] counts them; `None` for a system that
    /// does not count.
    ///
    /// [`SolverStatistics::operations`]: crate::SolverStatistics::operations
    fn operations(&self) -> Option<u64>;
}

/// The functions by name; each fails as [`evaluate`](SystemEvaluator::evaluate).
#[allow(clippy::missing_errors_doc, reason = "said above, for all")]
impl dyn SystemEvaluator + '_ {
    /// [`SystemFunction::Tensor`].
    pub fn tensor(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.evaluate(SystemFunction::Tensor(v), y, out)
    }

    /// [`SystemFunction::Hamiltonian`].
    pub fn hamiltonian(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.evaluate(SystemFunction::Hamiltonian, y, out)
    }

    /// [`SystemFunction::Gradient`].
    pub fn gradient(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.evaluate(SystemFunction::Gradient, y, out)
    }

    /// [`SystemFunction::Casimirs`].
    pub fn casimirs(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.evaluate(SystemFunction::Casimirs, y, out)
    }

    /// [`SystemFunction::TensorTangent`].
    pub fn tensor_tangent(
        &mut self,
        y: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        self.evaluate(SystemFunction::TensorTangent(v, w), y, out)
    }

    /// [`SystemFunction::Hessian`].
    pub fn hessian(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.evaluate(SystemFunction::Hessian(v), y, out)
    }

    /// [`SystemFunction::CasimirGradients`].
    pub fn casimir_gradients(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.evaluate(SystemFunction::CasimirGradients, y, out)
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

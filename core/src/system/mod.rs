//! Poisson systems: tensor, Hamiltonian, Casimirs, parameters, sign convention.
//!
//! - [`agreement`]: code that exact algebra made of formulas, against the formulas.
//! - [`builder`]: systems written in Rust.
//! - [`formulas`]: systems given by expressions, from which everything can be derived.
//! - [`numbers`]: systems that only compute values, such as those of a loaded library.
//! - [`forces`]: one-forms beside dH, damping, and friction.
//! - [`forms`]: tensors by one-forms, two-forms and constraints.
//! - [`MotionSeries`]: the Taylor coefficients of a motion.
//! - [`energy_casimir`]: H less multiples of Casimirs, which has the motion of H.
//! - [`compiled`]: the values of a system of formulas, by kernels.
//! - [`spins`]: summands that are so(3)*, and the terms of their temperature.
//! - [`observables`]: energy, Casimirs and other functions of the state.
//! - [`LeafDirections`]: vectors within a symplectic leaf.

pub mod agreement;
pub mod builder;
pub mod compiled;
pub mod energy_casimir;
mod field;
pub mod forces;
pub mod forms;
mod formula_kernel;
pub mod formulas;
mod jet;
mod leaf_directions;
pub mod numbers;
pub mod observables;
mod perturbation;
mod pfaffian;
mod rounding;
mod smoothness;
pub mod spins;
mod summands;
mod tensor_matrix;
mod terms;
mod written;

use leafwise_expression::Expression;

pub use agreement::Agreement;
pub use builder::SystemBuilder;
pub use compiled::CompiledNumbers;
pub use forces::{Damping, Forces, Metric, MotionClass};
pub use forms::FormError;
pub use formulas::{SystemFormulas, TensorSource};
pub use jet::MotionSeries;
pub use leaf_directions::LeafDirections;
pub use numbers::{
    Derivatives, Jet, MakeField, MakeFieldTangent, MakeJet, MakePoles, OpaqueSystem, Shear,
    SystemEvaluator, SystemFunction, SystemNumbers,
};
pub use observables::{SystemInvariants, SystemObservables};
pub use rounding::FieldRounding;
pub use smoothness::TableUse;
pub(crate) use tensor_matrix::{Entries, TensorMatrix};
pub use terms::{BodyPlace, BodyTerms};

use crate::error::BuildError;

/// Which of the two signs a system's author means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Convention {
    /// ẋ = {H, x}, the paper's: ẋ = −Π ∇H with Π_ij = {x_i, x_j}.
    #[default]
    HamiltonianFirst,
    /// ẋ = {x, H}, that of most textbooks: ẋ = +Π ∇H. The same system with −Π in the paper's.
    HamiltonianSecond,
}

/// A named parameter and the value a run starts from.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// The name formulas use.
    pub name: String,
    /// The value.
    pub value: f64,
}

/// A named function that every Hamiltonian flow of the tensor conserves: Π ∇C = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Casimir {
    /// Its name in reports.
    pub name: String,
    /// The function.
    pub expression: Expression,
}

/// A Poisson system (M ≅ ℝᵈ, π, H): the data of ẋ = {H, x}.
///
/// It is given by formulas, or by numbers alone. A part that works on formulas asks for them with
/// [`formulas`](Self::formulas) and is refused where there are none; one that needs only values takes
/// [`numbers`](Self::numbers), which every system has.
#[derive(Clone, Debug)]
pub struct PoissonSystem {
    definition: Definition,
}

#[derive(Clone, Debug)]
enum Definition {
    Formulas(SystemFormulas),
    Numbers(OpaqueSystem),
}

impl From<SystemFormulas> for PoissonSystem {
    fn from(system: SystemFormulas) -> Self {
        Self {
            definition: Definition::Formulas(system),
        }
    }
}

impl From<OpaqueSystem> for PoissonSystem {
    fn from(system: OpaqueSystem) -> Self {
        Self {
            definition: Definition::Numbers(system),
        }
    }
}

impl PoissonSystem {
    /// A system of formulas: [`SystemFormulas::new`].
    ///
    /// # Errors
    /// Those of [`SystemFormulas::new`].
    pub fn new(
        variables: Vec<String>,
        parameters: Vec<Parameter>,
        bracket: impl IntoIterator<Item = ((usize, usize), Expression)>,
        hamiltonian: Expression,
        casimirs: Vec<Casimir>,
        convention: Convention,
    ) -> Result<Self, BuildError> {
        let system = SystemFormulas::new(
            variables,
            parameters,
            bracket,
            hamiltonian,
            casimirs,
            convention,
        )?;
        Ok(system.into())
    }

    /// d, the dimension of M.
    pub fn dimension(&self) -> usize {
        self.variables().len()
    }

    /// The variables' names.
    pub fn variables(&self) -> &[String] {
        match &self.definition {
            Definition::Formulas(system) => system.variables(),
            Definition::Numbers(system) => &system.variables,
        }
    }

    /// The parameters.
    pub fn parameters(&self) -> &[Parameter] {
        match &self.definition {
            Definition::Formulas(system) => system.parameters(),
            Definition::Numbers(system) => &system.parameters,
        }
    }

    /// The parameters' values, in order.
    pub fn parameter_values(&self) -> Vec<f64> {
        self.parameters().iter().map(|p| p.value).collect()
    }

    /// The same system at other values of its parameters, in order.
    ///
    /// # Errors
    /// [`BuildError::Dimension`] unless there is one for each.
    pub fn with_parameter_values(&self, values: &[f64]) -> Result<Self, BuildError> {
        let mut system = self.clone();
        let parameters = match &mut system.definition {
            Definition::Formulas(system) => system.parameters_mut(),
            Definition::Numbers(system) => &mut system.parameters,
        };
        if parameters.len() != values.len() {
            return Err(BuildError::Dimension {
                what: "the parameters' values".to_owned(),
                expected: parameters.len(),
                found: values.len(),
            });
        }
        for (parameter, value) in parameters.iter_mut().zip(values) {
            parameter.value = *value;
        }
        Ok(system)
    }

    /// The Casimirs' names.
    pub fn casimir_names(&self) -> Vec<&str> {
        match &self.definition {
            Definition::Formulas(system) => {
                system.casimirs().iter().map(|c| c.name.as_str()).collect()
            }
            Definition::Numbers(system) => system.casimirs.iter().map(String::as_str).collect(),
        }
    }

    /// The formulas, for a part that needs them.
    ///
    /// # Errors
    /// [`BuildError::NotOffered`] for a system of numbers: it names `part` and what it would need.
    pub fn formulas(&self, part: &'static str) -> Result<&SystemFormulas, BuildError> {
        match &self.definition {
            Definition::Formulas(system) => Ok(system),
            Definition::Numbers(system) => Err(system.not_offered(part, "formulas of the system")),
        }
    }

    /// The formulas, where the system is given by them.
    pub fn expressions(&self) -> Option<&SystemFormulas> {
        match &self.definition {
            Definition::Formulas(system) => Some(system),
            Definition::Numbers(_) => None,
        }
    }

    /// The same system about a state: [`SystemFormulas::with_near`]; systems of numbers need none.
    ///
    /// # Errors
    /// Those of [`SystemFormulas::with_near`].
    pub fn with_near(&self, near: &[f64]) -> Result<Self, BuildError> {
        match &self.definition {
            Definition::Formulas(system) => Ok(system.with_near(near)?.into()),
            Definition::Numbers(_) => Ok(self.clone()),
        }
    }

    /// The system of numbers, where it is given by them.
    pub fn opaque(&self) -> Option<&OpaqueSystem> {
        match &self.definition {
            Definition::Formulas(_) => None,
            Definition::Numbers(system) => Some(system),
        }
    }

    /// Whether there are forces or a friction.
    pub fn motion(&self) -> MotionClass {
        match &self.definition {
            Definition::Formulas(system) => system.forces().motion(),
            Definition::Numbers(system) => system.numbers.motion(),
        }
    }

    /// Whether the motion is not ẋ = {H, x}.
    pub fn has_forces(&self) -> bool {
        self.motion() != MotionClass::Hamiltonian
    }

    /// Refuses a motion that a part does not take.
    ///
    /// # Errors
    /// [`BuildError::Forces`], [`BuildError::Friction`].
    pub fn unless_beyond(&self, takes: MotionClass, part: &str) -> Result<(), BuildError> {
        let part = || part.to_owned();
        match self.motion() {
            motion if motion <= takes => Ok(()),
            MotionClass::OffLeaves => Err(BuildError::Friction { part: part() }),
            _ => Err(BuildError::Forces { part: part() }),
        }
    }

    /// Refuses a system with forces, for a part that integrates ẋ = {H, x} alone.
    ///
    /// # Errors
    /// Those of [`unless_beyond`](Self::unless_beyond).
    pub fn without_forces(&self, part: &str) -> Result<(), BuildError> {
        self.unless_beyond(MotionClass::Hamiltonian, part)
    }

    /// Values of Π, H, ∇H and the Casimirs, forces left out. They are the system's own, or those of kernels compiled
    /// from its formulas.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or its derivative has no code.
    pub fn numbers(&self) -> Result<SystemNumbers, BuildError> {
        match &self.definition {
            Definition::Formulas(system) => Ok(CompiledNumbers::compile(system)?.into()),
            Definition::Numbers(system) => Ok(system.numbers.clone()),
        }
    }

    /// The same system with its formulas forgotten, as a library that computes the same values would offer it.
    ///
    /// # Errors
    /// Those of [`numbers`](Self::numbers). Forces have no numbers and give [`BuildError::Forces`], friction
    /// [`BuildError::Friction`].
    pub fn without_formulas(&self, name: impl Into<String>) -> Result<Self, BuildError> {
        self.without_forces("a system of numbers")?;
        let casimirs = self
            .casimir_names()
            .into_iter()
            .map(str::to_owned)
            .collect();
        Ok(OpaqueSystem {
            name: name.into(),
            variables: self.variables().to_vec(),
            parameters: self.parameters().to_vec(),
            casimirs,
            numbers: self.numbers()?,
        }
        .into())
    }

    /// Where values come from, for manifests: `expressions` or `numbers`.
    pub fn path(&self) -> &'static str {
        match &self.definition {
            Definition::Formulas(_) => "expressions",
            Definition::Numbers(_) => "numbers",
        }
    }
}

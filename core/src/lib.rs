//! The vocabulary of Poisson integration by realizations and Lagrangian bisections.
//!
//! A Poisson system ẋ = {H, x} is stepped by φ̂ = α̂ ∘ (β̂|_L)⁻¹. Here R̂_ε = (S, ω, α̂, β̂, σ) is (approximate)
//! realization data of (M, επ), and L ⊂ S is a Lagrangian bisection. Source: Cabrera, Martín de Diego, Vaquero,
//! *Approximating Symplectic Realizations*, Definitions 2.3–2.4 and Algorithm 1.
//!
//! - [`system`]: the Poisson tensor, the Hamiltonian, Casimirs and parameters.
//! - [`realization`]: [`RealizationData`], the geometric approximation.
//! - [`closed_form`]: realizations whose α is a closed form, written once.
//! - [`formulas`]: realizations and dynamics that are lists of formulas.
//! - [`chart`]: charts about the section, as numbers.
//! - [`dynamics`]: [`DynamicApproximation`], the dynamic one.
//! - [`bisection`]: [`LagrangianBisection`], which it provides.
//! - [`one_form`]: dS and other one-forms, as code and as numbers.
//! - [`method`](mod@method): [`Method`], the two combined into a step map.
//! - [`noise`]: steps with parameters that are drawn anew before each.
//! - [`random`]: random numbers by seed, member and purpose.
//! - [`quadrature`]: Gauss–Legendre rules.
//! - [`runge_kutta`]: tableaux and stage equations.
//! - [`shadow`]: the Hamiltonians whose flows step maps are.
//! - [`solver`]: the step solver, one Newton iteration a lane.
//! - [`walk`]: the compensated step loop, of one lane or many.
//! - [`lift`]: coordinates with a constant tensor, in which collective integrators step.
//! - [`lifted_realization`]: realizations that are such coordinates.
//! - [`lattice`]: long lattices in O(N) time and memory a step.
//! - [`lattice_method`]: [`LatticeMethod`], realization and dynamics combined over a lattice.
//! - [`pairs`]: sums over pairs of sites, in loops.
//! - [`part`], [`part_description`], [`origin`], [`registry`]: parts by name, built in or loaded.
//! - [`automatic`]: the choice of a method where a scene leaves it open.
//! - [`diagnostics`]: realization error, tensor defect, fitted slopes, Jacobi and Casimir checks.
//! - [`gradient`]: derivatives of trajectories, forwards and backwards.
//! - [`error`]: typed failures.

pub mod automatic;
pub mod bisection;
pub mod chart;
pub mod closed_form;
mod code_evaluators;
pub mod contact;
pub mod diagnostics;
mod dimensions;
pub mod dynamics;
pub mod exact_energy;
pub mod formulas;
mod generating_function;
mod generating_shadow;
pub mod gradient;
mod instead;
pub mod lattice;
pub mod lattice_method;
pub mod lift;
pub mod lifted_realization;
pub mod method;
pub mod noise;
mod observer;
pub mod one_form;
pub mod origin;
pub mod pairs;
pub mod part;
pub mod part_description;
mod parts;
mod point_kernel;
pub mod quadrature;
pub mod random;
pub mod realization;
pub mod registry;
pub mod runge_kutta;
pub mod shadow;
mod solution_series;
pub mod solver;
mod step_map;
pub mod system;
pub mod walk;

pub use bisection::{GraphBisection, LagrangianBisection};
pub use chart::ChartMaps;
pub use closed_form::{ChartPoint, ClosedForm, ClosedRealization, FormProperties};
pub use code_evaluators::{ChartRatio, RealizationMaps, realization_evaluator};
pub use dynamics::{Correction, DynamicApproximation, DynamicsProperties};
pub use lattice_method::LatticeMethod;
use leafwise_solver::compensation;
pub use leafwise_solver::{BuildError, Evaluator, Hint, StepError, error, evaluator, two_sum};
pub use lift::Lift;
pub use lifted_realization::LiftedRealization;
pub use method::{Method, MethodEvaluators};
pub use observer::Observer;
pub use one_form::{OneForm, PointCode};
pub use origin::Origin;
pub use part::{PartInfo, PartKind, PartParameters};
pub use realization::{
    Abilities, Accuracy, ChartCode, EndMaps, EndNumbers, Ends, MapCode, RealizationData,
    SourceRecursion, SourceSeries, SourceTarget, Space, SpaceChart,
};
pub use registry::{NumberArray, Part, Registry, RegistryError};
pub use shadow::Shadow;
pub use solver::{
    ByTangents, Differential, Factored, Inverse, MapAbilities, MapProperties, Pieces, Setting,
    SolverStatistics, StepMap, Stepper, Structure, WithoutPoles,
};
pub use system::{
    Convention, MotionClass, PoissonSystem, SystemBuilder, SystemFormulas, SystemNumbers,
};
pub use walk::Walk;

//! From a scene's text to a Poisson system, a method and the plan of a run.
//!
//! - `names`: the names that formulas may refer to, and the errors of formulas placed in the file;
//! - `definitions`: names for formulas, in an order that lets each use the others;
//! - `tensor`, `lie_algebra`: the ways to write a bracket;
//! - `forces`: one-forms beside dH, and damping;
//! - `channels`: Hamiltonians that move the system at random; `noise`: how they enter a step;
//! - `forms`: tensors by one-forms, two-forms and constraints;
//! - `instantiate`: templates over families written out at chosen lengths;
//! - `system`: [`compose_system`], the Poisson system with its initial state;
//! - `time`: where a scene names the time;
//! - `extended`: the phase space with the time as a coordinate;
//! - `events`: the events that a run watches between its steps; `course`: the course of its walks;
//! - `initial`: the initial state;
//! - `observables`: the quantities that a run watches and those that it records;
//! - `parts`: realization and dynamic approximation by name;
//! - `lattice`, `stepping`: families too long to be written out;
//! - `fit`: whether a part of a library fits the system;
//! - `sample_times`: when a run keeps samples;
//! - `domain`: values of parameters under which noise and damping are none;
//! - `functions`: functions of the state that a run and its copies share;
//! - `run`: [`compose`], all of it as a [`ComposedRun`];
//! - `values`: a composed run at other values, with nothing compiled anew;
//! - `motion`: ẋ as formulas to read;
//! - `states`: the coordinates that a run records;
//! - `path`: whether a run's numbers come from formulas or from calls;
//! - `checks`: the Jacobi identity and the Casimirs;
//! - `shape`: constant, linear, log-canonical, polynomial, general.

mod channels;
mod checks;
mod course;
mod definitions;
mod dense;
mod domain;
mod ends;
mod events;
mod extended;
mod fit;
mod forces;
mod forms;
mod fragment;
mod functions;
mod initial;
mod instantiate;
mod lattice;
mod lattice_functions;
mod lie_algebra;
mod motion;
mod names;
mod noise;
mod observables;
mod part_choice;
mod parts;
mod path;
mod request;
mod run;
mod sample_times;
mod shadow;
mod shape;
mod states;
mod stepping;
mod sum;
mod system;
mod tensor;
#[cfg(test)]
mod tests;
mod time;
mod values;

pub use channels::{Channel, RunNoise};
pub use checks::{CasimirCheck, SceneChecks};
pub use dense::DENSE_LIMIT;
pub use domain::{OutOfDomain, ParameterDomain};
pub use ends::{LeftOut, left_out};
pub use events::{Events, section_of};
pub use extended::{Extension, NoStart, PaceFormula};
pub use fit::{check_first_order, check_tensor};
pub use forms::Forms;
pub use fragment::system_of_fragment;
pub use instantiate::{Instantiated, instantiate};
pub use lattice_functions::LatticeFunctions;
pub use lie_algebra::{LIE_ALGEBRAS, LieAlgebra, StructureEntry};
pub use motion::Motion;
pub use noise::refuse_noise;
pub use observables::Observable;
pub use part_choice::PartChoice;
pub use parts::exact_realization;
pub use run::{ComposedRun, RunPlan, compose};
pub use shadow::{NoShadow, RecordedShadow, ShadowEnergy};
pub use shape::{TensorShape, tensor_shape};
pub use states::{RecordedStates, StateSlice, WIDEST_STATE};
pub use stepping::{LatticeBase, LatticeStepping, Stepping};
pub use system::{ComposedSystem, compose_system};

use crate::diagnostic::SceneDiagnostic;

/// A scene that cannot be composed: what is wrong, underlined where it stands.
pub type Refusal = Box<SceneDiagnostic>;

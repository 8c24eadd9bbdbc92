//! A scene file, from its text to a composed run.
//!
//! - [`document`]: the text as typed sections, every value with its place in the text;
//! - [`diagnostic`]: errors of a scene, underlined where they stand;
//! - [`compose`](mod@compose): the text as a Poisson system, a method and the plan of a run;
//! - [`json`]: doubles and named values as JSON;
//! - [`input`]: files that are read whole, within bounds;
//! - `parse`: documents with the Casimirs that a scene asks for;
//! - [`table`]: numbers in them; [`pairs`]: pairs of states.

pub mod compose;
pub mod diagnostic;
pub mod document;
mod grid;
pub mod input;
pub mod json;
mod npy;
pub mod pairs;
mod parse;
pub mod table;

pub use compose::{ComposedRun, ComposedSystem, Refusal, SceneChecks, compose, compose_system};
pub use diagnostic::{SceneDiagnostic, formula_span, string_content};
pub use npy::read_npy;

pub use document::{
    Boundary, BracketSpec, Convention, Distribution, EnsembleSection, FinalStates, InitialDraw,
    InitialSpec, Located, MethodParts, MethodSection, MethodTable, Number, NumbersSystem,
    ParameterDraw, ParameterValue, PartSpec, PartUse, Place, PluginSpec, RecordSpec, RewriteError,
    RunSection, SceneDocument, SceneErrors, SceneProblem, SceneProblemCause, Source, StepSpec,
    SummandSpec, SystemSection, equations_of, with_casimirs, with_hamiltonian, with_plain_run,
    with_system,
};

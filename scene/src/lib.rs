//! A scene file, from its text to the report of its run.
//!
//! - [`document`]: the text as typed sections, every value with its place in the text;
//! - [`diagnostic`]: what is wrong, underlined where it stands;
//! - [`compose`](mod@compose): the text as a Poisson system, a method and the plan of a run;
//! - [`advice`]: what a scene asks for and does not use, or needs and does not ask for;
//! - [`run`](mod@run): the run, into a directory with everything needed to resume and repeat it;
//! - [`ensemble`]: many members at once, reduced into such a directory;
//! - [`report`]: recorded data as one self-contained HTML page;
//! - [`json`]: numbers as JSON;
//! - [`input`]: files that are read whole, within bounds.

pub mod advice;
pub mod compose;
mod csv;
pub mod diagnostic;
pub mod document;
pub mod ensemble;
pub mod input;
pub mod json;
pub mod report;
pub mod run;

pub use advice::{Advice, AdviceKind, advise};
pub use compose::{ComposedRun, ComposedSystem, Refusal, SceneChecks, compose, compose_system};
pub use diagnostic::{SceneDiagnostic, formula_span, string_content};
pub use document::{
    Boundary, BracketSpec, Convention, Distribution, EnsembleSection, FinalStates, InitialDraw,
    InitialSpec, Located, MethodParts, MethodSection, MethodTable, Number, NumbersSystem,
    ParameterDraw, ParameterValue, PartSpec, PartUse, Place, PluginSpec, RecordSpec, RewriteError,
    RunSection, SceneDocument, SceneErrors, SceneProblem, SceneProblemCause, Source, StepSpec,
    SystemSection,
};
pub use report::{ComparisonData, ReportData, ReportError, render_comparison, render_report};
pub use run::{Progress, RunError, RunOptions, RunOutcome, RunReport};

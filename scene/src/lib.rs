//! A scene file, from its text to the report of its run.
//!
//! - [`document`]: the text as typed sections, every value with its place in the text;
//! - [`diagnostic`]: what is wrong, underlined where it stands;
//! - [`report`]: recorded data as one self-contained HTML page.

pub mod diagnostic;
pub mod document;
pub mod report;

pub use diagnostic::{SceneDiagnostic, formula_span, string_content};
pub use document::{
    Boundary, BracketSpec, Convention, InitialSpec, Located, MethodSection, NoLibrary, Number,
    ParameterValue, PartSpec, Place, RecordSpec, RunSection, SceneDocument, SceneErrors,
    SceneLibrary, SceneProblem, SceneProblemCause, Source, StepSpec, SystemSection,
};
pub use report::{ReportData, ReportError, render_report};

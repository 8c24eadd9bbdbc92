//! What every part really does, measured against what it declares.
//!
//! - `problem`: a library system with its initial state and a reference flow.
//! - `measure`: order, tensor defect, self-adjointness, drift and cost of one step map.
//! - `survey`: every pair of realization and dynamics, every stepper and composition.

mod measure;
mod problem;
mod survey;

pub use measure::{Judgement, Measured, measure};
pub use problem::{FlowError, Problem, ProblemError};
pub use survey::{Row, Survey, SurveyOptions, survey};

//! Measurement of every part against what it declares.
//!
//! - `problem`: a library system with its initial state and a reference flow.
//! - `candidates`: every pair of realization and dynamics, every stepper and composition.
//! - `convergence`: global errors and their order.
//! - `defects`: tensor defects of one step and their order.
//! - `drift`: invariants and cost along an orbit.
//! - `floor`: where errors become round-off.
//! - `kept_energy`: the order to which its shadow energy is kept.
//! - `judgement`: what comes of a declaration.
//! - `measure`: all of it for one step map.
//! - `order`: what is known of an order.
//! - `survey`: all of it for every candidate, on several threads.

mod candidates;
mod convergence;
mod defects;
mod drift;
mod floor;
mod judgement;
mod kept_energy;
mod measure;
mod order;
mod problem;
mod survey;

pub use candidates::Candidate;
pub(crate) use floor::Floor;
pub use judgement::Judgement;
pub use kept_energy::KeptEnergy;
pub use measure::{Measured, measure};
pub use order::MeasuredOrder;
pub use problem::{FlowError, Own, Problem, ProblemError};
pub use survey::{Progress, Refused, Row, Sampled, Survey, SurveyOptions, survey};

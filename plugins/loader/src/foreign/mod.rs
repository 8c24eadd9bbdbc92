//! A library's tables of functions as parts.
//!
//! - `batch`: vectors of a batch in any layout;
//! - `part`, `instance`, `callee`: a part, its instances, calls with the host's errors;
//! - `making`: the arguments of `create` and `properties`;
//! - `failure`: the failures that statuses mean;
//! - `function`: a function of points and its derivative as an evaluator;
//! - `system`, `realization`, `dynamics`, `step_map`: one kind each.

mod batch;
mod callee;
mod dynamics;
mod failure;
mod function;
mod instance;
mod making;
mod part;
mod realization;
mod step_map;
mod system;

pub(crate) use batch::{Input, Output, is_unwritten, unwritten};
pub(crate) use dynamics::ForeignDynamicsPart;
pub(crate) use failure::CallFailure;
pub(crate) use instance::{Call, Instance};
pub(crate) use making::{HostObjects, Making};
pub(crate) use part::{ForeignPart, own_settings};
pub(crate) use realization::ForeignRealizationPart;
pub(crate) use step_map::{ForeignStepMapPart, promises};
pub(crate) use system::{ForeignSystemPart, names};

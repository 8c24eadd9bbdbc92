//! Types and functions that most programs need: `use leafwise::prelude::*`.

pub use leafwise_core::{
    Method, PartParameters, PoissonSystem, Registry, SolverStatistics, StepError, StepMap,
    SystemBuilder, Walk,
};
pub use leafwise_expression::{Expression, Quantity};
pub use leafwise_scene::{ComposedRun, SceneDiagnostic, SceneDocument, compose};

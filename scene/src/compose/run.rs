//! All of a scene, ready to step.

use leafwise_core::{BuildError, Method, PoissonSystem, Registry};

use super::Refusal;
use super::observables::Observable;
use super::parts::{PartChoice, parts};
use super::system::compose_system;
use crate::document::{PartSpec, SceneDocument};

/// What a run does.
#[derive(Clone, Debug)]
pub struct RunPlan {
    /// ε.
    pub epsilon: f64,
    /// h.
    pub h: f64,
    /// The number of steps.
    pub steps: u64,
    /// Every how many steps a sample is kept.
    pub every: u64,
    /// x_0.
    pub initial: Vec<f64>,
    /// What a sample holds beside time and state.
    pub observables: Vec<Observable>,
    /// Realization and dynamics as chosen.
    pub parts: Vec<PartChoice>,
    /// The scene's families with their lengths.
    pub families: Vec<(String, usize)>,
}

/// A scene with its system and method built.
#[derive(Clone, Debug)]
pub struct ComposedRun {
    /// (M, π, H).
    pub system: PoissonSystem,
    /// The integrator.
    pub method: Method,
    /// From where, how far, what to keep.
    pub plan: RunPlan,
}

/// Builds the system and the method of a scene.
///
/// # Errors
/// The first thing wrong, underlined in the scene.
pub fn compose(document: &SceneDocument, registry: &Registry) -> Result<ComposedRun, Refusal> {
    let composed = compose_system(document)?;
    let parts = parts(document, &composed.system, registry)?;
    let method = Method::compose(&composed.system, parts.realization, parts.dynamics)
        .map_err(|error| method_refusal(document, &error))?;
    let step = &document.method.step;
    let plan = RunPlan {
        epsilon: step.epsilon(),
        h: step.h(),
        steps: document.run.steps.value,
        every: document.run.record.every,
        initial: composed.initial,
        observables: composed.observables,
        parts: parts.choices,
        families: document
            .system
            .families
            .iter()
            .map(|(name, length)| (name.value.clone(), length.value))
            .collect(),
    };
    Ok(ComposedRun {
        system: composed.system,
        method,
        plan,
    })
}

/// Parts that do not fit each other or the system.
fn method_refusal(document: &SceneDocument, error: &BuildError) -> Refusal {
    let part = |spec: &Option<PartSpec>| spec.as_ref().map(|spec| spec.name.place());
    let place = match error {
        BuildError::Algebra(_) => document.system.hamiltonian.place(),
        _ => part(&document.method.dynamics)
            .or_else(|| part(&document.method.realization))
            .unwrap_or_else(|| document.system.hamiltonian.place()),
    };
    Box::new(document.diagnostic(&place, error.to_string(), "here", None))
}

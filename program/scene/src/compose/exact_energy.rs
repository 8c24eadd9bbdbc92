//! Steps that keep the energy by multiples of Casimirs: `energy = "exact"` in `[method]`.

use std::sync::Arc;

use leafwise_core::exact_energy::{ExactEnergy, with_multiples};
use leafwise_core::{BuildError, PoissonSystem, StepMap};

use super::Refusal;
use super::stepping::{MapStepping, Stepping};
use super::system::ComposedSystem;
use crate::document::{Located, ParameterValue, SceneDocument};

/// The system that the parts are made for: H less multiples of Casimirs, which stand behind its parameters.
pub(super) struct ExactEnergySteps {
    pub stepped: PoissonSystem,
}

impl ExactEnergySteps {
    /// Those of a scene that asks for them.
    ///
    /// # Errors
    /// What does not stand beside them, underlined in the scene.
    pub fn of(
        document: &SceneDocument,
        composed: &ComposedSystem,
        is_long: bool,
    ) -> Result<Option<Self>, Refusal> {
        let Some(asked) = &document.method.exact_energy else {
            return Ok(None);
        };
        let refuse = |message: &str, help: &str| Err(refusal(document, asked, message, help));
        if is_long {
            return refuse(
                "exact energy is not offered on long lattices: one multiple would tie all sites together",
                "leave `energy` out: the energy of a Poisson map does not drift",
            );
        }
        if !document.system.noise.is_empty() {
            return refuse(
                "exact energy is not offered with noise, which changes the energy",
                "leave `energy` out",
            );
        }
        if composed.extension.is_some() {
            return refuse(
                "exact energy is not offered with a pace, nor where H names the time",
                "leave `energy` out",
            );
        }
        if is_shifted(document) {
            return refuse(
                "`hamiltonian = \"energy-casimir\"` removes every multiple again",
                "leave `hamiltonian` out: the multiples begin at those of energy-casimir",
            );
        }
        let Some(formulas) = composed.system.expressions() else {
            return refuse(
                "exact energy takes multiples of Casimirs from H, and this system has no formulas",
                "write its tensor and Hamiltonian as formulas",
            );
        };
        let stepped = with_multiples(formulas);
        let stepped = stepped.map_err(|error| of_error(document, asked, &error))?;
        Ok(Some(Self {
            stepped: stepped.into(),
        }))
    }

    /// Finds the multiples in the steps of `method`.
    ///
    /// # Errors
    /// Steps that are no exact Poisson maps.
    pub fn enter(
        &self,
        document: &SceneDocument,
        system: &PoissonSystem,
        method: Stepping,
    ) -> Result<Stepping, Refusal> {
        let map: Arc<dyn StepMap> = match method {
            Stepping::Written(method) => Arc::new(*method),
            Stepping::Map(stepping) => stepping.map,
            Stepping::Lattice(stepping) => stepping.stepped,
        };
        let map = match (
            &document.method.exact_energy,
            ExactEnergy::new(map, system.clone()),
        ) {
            (_, Ok(map)) => map,
            (Some(asked), Err(error)) => return Err(of_error(document, asked, &error)),
            (None, Err(_)) => unreachable!("the scene asks for it"),
        };
        Ok(Stepping::Map(MapStepping {
            map: Arc::new(map),
            method: None,
            is_composed: false,
            noise: None,
        }))
    }
}

/// Whether the dynamics takes multiples of Casimirs away itself.
fn is_shifted(document: &SceneDocument) -> bool {
    let mut parts = document.method.dynamics.iter();
    parts.any(|part| {
        let mut given = part.parameters.iter();
        given.any(|(name, value)| {
            let word = ParameterValue::Text("energy-casimir".to_owned());
            name.value == "hamiltonian" && value.value == word
        })
    })
}

fn of_error(document: &SceneDocument, asked: &Located<()>, error: &BuildError) -> Refusal {
    let text = match error {
        BuildError::NotMade { reason, .. } => reason.clone(),
        other => other.to_string(),
    };
    let (message, help) = text
        .split_once("; ")
        .unwrap_or((&text, "leave `energy` out"));
    refusal(document, asked, message, help)
}

fn refusal(document: &SceneDocument, asked: &Located<()>, message: &str, help: &str) -> Refusal {
    Box::new(document.diagnostic(&asked.place(), message, "here", Some(help.to_owned())))
}

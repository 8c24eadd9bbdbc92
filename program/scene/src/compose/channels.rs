//! Channels of noise: Hamiltonians that move a system at random, and their strengths.

use leafwise_core::noise::{Noise, Seed};
use leafwise_core::system::{Forces, Parameter};
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::Expression;
use leafwise_expression::syntax::Scope;

use super::Refusal;
use super::names::{self, check_code, function, parse, sites_of};
use crate::document::{Located, NoiseSpec, SceneDocument};

/// The noise of a run: Σ_k σ_k {H_k, x} ∘ dW_k.
#[derive(Clone, Debug, PartialEq)]
pub struct RunNoise {
    /// How it enters a step.
    pub way: Noise,
    /// Seed of its random numbers, and the number that member 0 draws as.
    pub seed: Seed,
    /// H_k and σ_k.
    pub channels: Vec<Channel>,
}

/// σ_k {H_k, x} ∘ dW_k.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// H_k as the scene writes it.
    pub text: String,
    /// H_k.
    pub hamiltonian: Expression,
    /// σ_k, a function of the parameters.
    pub strength: Expression,
}

/// The channels of a scene, a template's one at every site.
///
/// # Errors
/// The first formula that cannot be read, and a strength that depends on the state.
pub(super) fn channels(document: &SceneDocument, scope: &Scope) -> Result<Vec<Channel>, Refusal> {
    let mut channels = Vec::new();
    for spec in &document.system.noise {
        let strength = strength(document, scope, spec)?;
        let parsed = parse(document, &spec.hamiltonian)?;
        let text = spec.hamiltonian.value.trim();
        let names = parsed.free_indices();
        if names.is_empty() {
            channels.push(Channel {
                text: text.to_owned(),
                hamiltonian: function(document, scope, &spec.hamiltonian)?,
                strength,
            });
            continue;
        }
        for site in sites_of(document, scope, &spec.hamiltonian, &names)? {
            let own = parsed
                .resolve_summand(scope, Some((&names, site)))
                .map_err(|error| names::refusal(document, &spec.hamiltonian, &error))?;
            let Some(hamiltonian) = own else { continue };
            check_code(document, &spec.hamiltonian, &hamiltonian)?;
            channels.push(Channel {
                text: format!("{text} at {}", scope.named_site((&names, site))),
                hamiltonian,
                strength: strength.clone(),
            });
        }
    }
    Ok(channels)
}

/// σ of a channel.
///
/// # Errors
/// A formula that cannot be read, or that depends on the state.
pub(super) fn strength(
    document: &SceneDocument,
    scope: &Scope,
    spec: &NoiseSpec,
) -> Result<Expression, Refusal> {
    let strength = function(document, scope, &spec.strength)?;
    if strength.variables().is_empty() {
        return Ok(strength);
    }
    Err(refusal(
        document,
        &spec.strength,
        "the strength of a channel of noise is a formula of the parameters, and this one depends on the state".to_owned(),
        "multiply by it in the channel's hamiltonian",
    ))
}

impl Channel {
    /// w σ_k H_k, w the parameter at `place`.
    pub(super) fn times(&self, place: usize) -> Expression {
        let w = Expression::Parameter(place);
        Expression::Product(vec![w, self.strength.clone(), self.hamiltonian.clone()])
    }

    /// The system that the channel moves by itself, σ_k H_k in place of H.
    ///
    /// # Errors
    /// [`BuildError`] where it has no formulas of that kind.
    pub fn system(&self, system: &SystemFormulas) -> Result<SystemFormulas, BuildError> {
        let factors = vec![self.strength.clone(), self.hamiltonian.clone()];
        let alone = system.with_forces(Forces::default())?;
        alone.with_hamiltonian(Expression::Product(factors))
    }
}

impl RunNoise {
    /// The system that the parts step.
    ///
    /// # Errors
    /// [`BuildError`] where a channel has no derivative beside forces.
    pub(super) fn stepped(&self, system: &SystemFormulas) -> Result<SystemFormulas, BuildError> {
        let own = system.parameters().len();
        let count = self.way.parameters(self.channels.len());
        // Of no special value: what parts are chosen by has to see every channel.
        let further = (0..count).map(|at| Parameter {
            name: format!("dW{}/dt", at + 1),
            value: 1.0 + 0.0625 * at as f64,
        });
        let system = system.with_parameters(further);
        if self.way == Noise::Split {
            return Ok(system);
        }
        let terms = self.channels.iter().enumerate();
        let terms = terms.map(|(at, channel)| channel.times(own + at)).collect();
        system.with_perturbation(Expression::Sum(terms))
    }

    /// One line for reports.
    pub fn describe(&self) -> String {
        let texts: Vec<&str> = self
            .channels
            .iter()
            .map(|channel| channel.text.as_str())
            .collect();
        let way = match self.way {
            Noise::Joint => "with H in one step",
            Noise::Split => "as flows between two half steps of H",
        };
        format!(
            "{}, {way}: weak order {}; Stratonovich, seed {}",
            texts.join("; "),
            self.way.weak_order(),
            self.seed.seed
        )
    }
}

/// Diagnostic of an invalid formula of a channel: the formula underlined in the scene, with `message` and `help`.
pub(super) fn refusal(
    document: &SceneDocument,
    formula: &Located<String>,
    message: String,
    help: &str,
) -> Refusal {
    let place = document.place_in_formula(formula, 0..formula.value.len());
    Box::new(document.diagnostic(&place, message, "here", Some(help.to_owned())))
}

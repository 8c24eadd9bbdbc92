//! Values of parameters under which noise and damping are none.

use leafwise_core::system::Forces;
use leafwise_expression::Expression;
use thiserror::Error;

use super::channels::RunNoise;

/// Strengths of noise and the rate of damping, as functions of the parameters.
#[derive(Clone, Debug, Default)]
pub struct ParameterDomain {
    strengths: Vec<Expression>,
    rate: Option<Expression>,
}

/// A value that such a function must not have.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OutOfDomain {
    /// Of noise.
    #[error("the strength of a channel of noise is {0:?}, and must be positive")]
    Strength(f64),
    /// Of damping.
    #[error("the rate of the damping is {0:?}, and must be finite and not negative")]
    Rate(f64),
}

impl ParameterDomain {
    /// That of forces and noise. A rate that depends on the state may have either sign: it is feedback.
    pub fn of(forces: Option<&Forces>, noise: Option<&RunNoise>) -> Self {
        let channels = noise.into_iter().flat_map(|noise| &noise.channels);
        let damping = forces.and_then(|forces| forces.damping.as_ref());
        let rate = damping.map(|damping| &damping.rate);
        Self {
            strengths: channels.map(|channel| channel.strength.clone()).collect(),
            rate: rate.filter(|rate| rate.variables().is_empty()).cloned(),
        }
    }

    /// Refuses values of the parameters that are outside.
    ///
    /// # Errors
    /// [`OutOfDomain`].
    pub fn check(&self, parameters: &[f64]) -> Result<(), OutOfDomain> {
        for strength in &self.strengths {
            let value = strength.evaluate(&[], parameters);
            if !(value > 0.0 && value.is_finite()) {
                return Err(OutOfDomain::Strength(value));
            }
        }
        if let Some(rate) = &self.rate {
            let value = rate.evaluate(&[], parameters);
            if !(value >= 0.0 && value.is_finite()) {
                return Err(OutOfDomain::Rate(value));
            }
        }
        Ok(())
    }
}

//! The members of a block where they begin.

use leafwise_scene::compose::ParameterDomain;

use super::plan::ComposedEnsemble;
use super::statistics::MemberFailure;

/// The members of a block where they begin.
pub(super) struct Begun {
    /// The number of the first.
    pub first: u64,
    /// Their initial states as drawn.
    pub drawn: Vec<Vec<f64>>,
    /// The same, with the scene's own where a member has none that it can begin at.
    pub states: Vec<Vec<f64>>,
    /// Their parameters.
    pub parameters: Vec<Vec<f64>>,
    /// Why members do not begin.
    pub failures: Vec<Option<MemberFailure>>,
}

impl Begun {
    /// Draws so many members from the `first` on.
    pub fn draw(ensemble: &ComposedEnsemble, first: u64, lanes: usize) -> Self {
        let domain = ParameterDomain::of(&ensemble.run.system, ensemble.run.method.noise());
        let mut begun = Self {
            first,
            drawn: Vec::with_capacity(lanes),
            states: Vec::with_capacity(lanes),
            parameters: Vec::with_capacity(lanes),
            failures: Vec::with_capacity(lanes),
        };
        for member in first..first + lanes as u64 {
            let drawn = ensemble.population.drawn(member);
            let begins = drawn.begins.map_err(|reason| reason.to_string());
            let begins = begins.and_then(|()| {
                let inside = domain.check(&drawn.parameters);
                inside.map_err(|reason| reason.to_string())
            });
            let failure = begins.err().map(|message| MemberFailure {
                member,
                step: 0,
                time: 0.0,
                message,
                state: ensemble.run.own(&drawn.state).to_vec(),
            });
            // A lane that is left out rests where evaluations have values.
            begun.states.push(match failure {
                None => drawn.state.clone(),
                Some(_) => ensemble.run.plan.initial.clone(),
            });
            begun.failures.push(failure);
            begun.drawn.push(drawn.state);
            begun.parameters.push(drawn.parameters);
        }
        begun
    }
}

//! The members of a block where they begin.

use leafwise_scene::compose::ParameterDomain;

use super::plan::ComposedEnsemble;
use super::population::Drawing;
use super::statistics::MemberFailure;

/// The members of a block where they begin. States and parameters are structures of arrays.
pub(super) struct Begun {
    /// Their numbers.
    pub members: Vec<u64>,
    /// Their initial states as drawn.
    pub drawn: Vec<f64>,
    /// The same, with the scene's own where a member has none that it can begin at.
    pub states: Vec<f64>,
    /// Their parameters.
    pub parameters: Vec<f64>,
    /// Why members do not begin.
    pub failures: Vec<Option<MemberFailure>>,
}

/// Tools that members are drawn with, one block after the other.
pub(super) struct Drawer<'a> {
    ensemble: &'a ComposedEnsemble,
    domain: ParameterDomain,
    drawing: Drawing,
}

impl<'a> Drawer<'a> {
    /// Of the members of an ensemble.
    pub fn new(ensemble: &'a ComposedEnsemble) -> Self {
        Self {
            ensemble,
            domain: ParameterDomain::of(ensemble.run.forces(), ensemble.run.method.noise()),
            drawing: Drawing::default(),
        }
    }

    /// Draws so many members from the `first` on.
    pub fn draw(&mut self, first: u64, lanes: usize) -> Begun {
        let (ensemble, drawing) = (self.ensemble, &mut self.drawing);
        let plan = &ensemble.run.plan;
        let count = ensemble.run.system.parameters().len();
        let mut begun = Begun {
            members: (first..first + lanes as u64).collect(),
            drawn: vec![0.0; plan.initial.len() * lanes],
            states: vec![0.0; plan.initial.len() * lanes],
            parameters: vec![0.0; count * lanes],
            failures: vec![None; lanes],
        };
        for (lane, member) in begun.members.iter().enumerate() {
            let begins = ensemble.population.draw_into(*member, drawing);
            let begins = begins.map_err(|reason| reason.to_string());
            let begins = begins.and_then(|()| {
                let inside = self.domain.check(&drawing.parameters);
                inside.map_err(|reason| reason.to_string())
            });
            begun.failures[lane] = begins.err().map(|message| MemberFailure {
                member: *member,
                step: 0,
                time: 0.0,
                message,
                state: ensemble.run.own(&drawing.state).to_vec(),
            });
            // A lane that is left out rests where evaluations have values.
            let state = match begun.failures[lane] {
                None => &drawing.state,
                Some(_) => &plan.initial,
            };
            for (all, own) in [
                (&mut begun.drawn, &drawing.state),
                (&mut begun.states, state),
                (&mut begun.parameters, &drawing.parameters),
            ] {
                let places = all.iter_mut().skip(lane).step_by(lanes);
                places.zip(own).for_each(|(place, value)| *place = *value);
            }
        }
        begun
    }
}

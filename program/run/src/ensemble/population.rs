//! The members: their initial states and parameters.

use std::path::Path;

use leafwise_core::random::Random;
use leafwise_core::runge_kutta::SmoothMap;

use sha2::{Digest, Sha256};
use thiserror::Error;

use super::leaf::leaves;
use super::states::Members;
use crate::level_set::WayOntoLevel;
use leafwise_scene::compose::{ComposedRun, Extension, NoStart, Refusal, state_beside};
use leafwise_scene::document::{
    Distribution, EnsembleSection, InitialDraw, Located, ParameterDraw, SceneDocument,
};
use leafwise_scene::input::read_text;
use leafwise_walk::StateLayout;

/// Members by number: each one's initial state and parameters follow from the scene, the seed and the
/// number alone.
pub struct Population {
    members: u64,
    seed: u64,
    center: Vec<f64>,
    layout: StateLayout,
    start: Start,
    parameters: Vec<f64>,
    /// Parameters that differ, by place, in the order of the scene.
    draws: Vec<(usize, ParameterDraw)>,
    /// Parameters with a value for each row of states, by place.
    given: Vec<(usize, Vec<f64>)>,
    /// Points of the grid; 1 where there is none.
    points: u64,
    /// Rows of states that are no member's.
    left_out: u64,
    /// Energy and Casimirs, for leaves.
    invariants: Option<SmoothMap>,
    /// The time and its energy, where they are coordinates.
    extension: Option<Extension>,
    /// Of members that are given, so that a changed one is not resumed from.
    fingerprint: Option<[u8; 32]>,
}

enum Start {
    Same,
    Drawn(Distribution),
    Rows(Vec<f64>),
}

/// Why a member has no initial state.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NoMember {
    /// A drawn state away from the leaf.
    #[error("no way along the Casimirs' gradients leads from the drawn state to the center's leaf")]
    NoLeaf,
    /// A state where no paced motion begins.
    #[error(transparent)]
    NoStart(#[from] NoStart),
}

/// Initial state and parameters of a member, and what one is drawn with after the other.
#[derive(Default)]
pub(super) struct Drawing {
    pub state: Vec<f64>,
    pub parameters: Vec<f64>,
    way: Option<WayOntoLevel>,
}

impl Population {
    /// The members of a scene; `directory` is where its files are, `given` are members in memory.
    ///
    /// # Errors
    /// What does not fit, underlined in the scene.
    pub(super) fn of(
        document: &SceneDocument,
        ensemble: &EnsembleSection,
        run: &ComposedRun,
        directory: &Path,
        given: Option<&Members>,
    ) -> Result<Self, Refusal> {
        let layout = run.plan.layout;
        let mut center = run.plan.initial.clone();
        let mut invariants = None;
        let mut members = given.cloned().unwrap_or_default();
        let drawn = ensemble.initial.as_ref().map(|initial| &initial.value);
        let drawn = drawn.filter(|_| members.states.is_none());
        let mut start = match drawn {
            None => Start::Same,
            Some(InitialDraw::Drawn {
                distribution,
                center: given,
            }) => {
                if let Some(given) = given {
                    let given = state_beside(document, given, run.own(&center))?;
                    center[layout.own()].copy_from_slice(&given);
                }
                if matches!(distribution, Distribution::Leaf(_)) {
                    invariants = Some(leaves(document, ensemble, run, &center)?);
                }
                Start::Drawn(distribution.clone())
            }
            Some(InitialDraw::File(file)) => {
                let read = read(document, ensemble, &directory.join(file), run)?;
                members.states = read.states;
                members.parameters.extend(read.parameters);
                Start::Same
            }
        };
        let rows = rows(document, ensemble, &members, layout.coordinates())?;
        let fingerprint = rows.map(|_| digest(&members));
        if let Some(states) = members.states.take() {
            start = Start::Rows(states);
        }
        let declared = run.system.parameters();
        let at = |name: &str| declared.iter().position(|p| p.name == name);
        let draws: Vec<_> = ensemble
            .parameters
            .iter()
            .filter_map(|(name, draw)| Some((at(&name.value)?, draw.value.clone())))
            .collect();
        let sizes = draws.iter().map(|(_, draw)| draw.points());
        let points = sizes.fold(1, u64::saturating_mul);
        let mut own_parameters = Vec::with_capacity(members.parameters.len());
        for (name, values) in members.parameters {
            let drawn = ensemble.parameters.iter().find(|(n, _)| n.value == name);
            let is_known = |at: usize| own_parameters.iter().any(|(known, _)| *known == at);
            let place = drawn.map_or(ensemble.place.clone(), |(key, _)| key.place());
            let why = match at(&name) {
                Some(at) if drawn.is_none() && !is_known(at) => {
                    own_parameters.push((at, values));
                    continue;
                }
                Some(_) => "has a value for each member already",
                None => "is not a parameter of the system",
            };
            let message = format!("`{name}` {why}");
            return Err(Box::new(document.diagnostic(&place, message, "here", None)));
        }
        // Those in memory are all members, whatever number a scene has for others.
        let asked = ensemble.members.as_ref().filter(|_| given.is_none());
        let count = member_count(document, ensemble, asked, rows, points)?;
        Ok(Self {
            members: count,
            seed: ensemble.seed,
            center,
            layout,
            start,
            parameters: run.system.parameter_values(),
            draws,
            given: own_parameters,
            points,
            left_out: rows.map_or(0, |rows| rows.saturating_sub(count.div_ceil(points))),
            invariants,
            extension: run.extension.clone(),
            fingerprint,
        })
    }

    /// How many members there are.
    pub fn members(&self) -> u64 {
        self.members
    }

    /// How many rows of states are given beyond those of the members.
    pub(super) fn left_out(&self) -> u64 {
        self.left_out
    }

    /// d.
    pub fn dimension(&self) -> usize {
        self.center.len()
    }

    /// The digest of members that were given.
    pub(super) fn fingerprint(&self) -> Option<[u8; 32]> {
        self.fingerprint
    }

    /// Whether the initial states are given.
    pub(super) fn has_states(&self) -> bool {
        matches!(self.start, Start::Rows(_))
    }

    /// The places of the parameters that differ.
    pub fn varied(&self) -> Vec<usize> {
        let drawn = self.draws.iter().map(|(at, _)| *at);
        drawn.chain(self.given.iter().map(|(at, _)| *at)).collect()
    }

    /// A member's initial state and parameters.
    ///
    /// # Errors
    /// [`NoMember`] where its distribution has no state for it, or no motion begins there.
    pub fn draw(&self, member: u64) -> Result<(Vec<f64>, Vec<f64>), NoMember> {
        let mut drawing = Drawing::default();
        let begins = self.draw_into(member, &mut drawing);
        begins.map(|()| (drawing.state, drawing.parameters))
    }

    /// Draws initial state and parameters of a member, whether a motion begins there or not.
    ///
    /// # Errors
    /// [`NoMember`] where none begins there.
    pub(super) fn draw_into(&self, member: u64, drawing: &mut Drawing) -> Result<(), NoMember> {
        let Drawing {
            state,
            parameters,
            way,
        } = drawing;
        parameters.clone_from(&self.parameters);
        // The last direction of the grid varies first.
        let mut place = member % self.points;
        for (at, draw) in self.draws.iter().rev() {
            let random = || Random::new(self.seed, member, 1 + *at as u32);
            let count = draw.points();
            let point = place % count;
            place /= count;
            parameters[*at] = match draw {
                ParameterDraw::Uniform(from, to) => {
                    let s = random().uniform();
                    from * (1.0 - s) + to * s
                }
                ParameterDraw::Normal(mean, deviation) => mean + deviation * random().normal(),
                ParameterDraw::Values(values) => values[point as usize],
                ParameterDraw::Range(from, to, _) => {
                    let s = point as f64 / (count - 1) as f64;
                    from * (1.0 - s) + to * s
                }
            };
        }
        let row = (member / self.points) as usize;
        for (at, values) in &self.given {
            parameters[*at] = values[row];
        }
        let mut random = Random::new(self.seed, member, 0);
        state.clone_from(&self.center);
        match &self.start {
            Start::Same => {}
            Start::Drawn(distribution) => {
                let own = self.layout.own();
                displace(
                    &self.center[own.clone()],
                    distribution,
                    &mut random,
                    &mut state[own],
                );
            }
            Start::Rows(rows) => {
                let own = self.layout.coordinates();
                state[self.layout.own()].copy_from_slice(&rows[row * own..][..own]);
            }
        }
        if let Some(invariants) = &self.invariants {
            let casimirs = || (1..invariants.outputs()).collect();
            let way =
                way.get_or_insert_with(|| WayOntoLevel::new(invariants, casimirs(), parameters));
            let leaf = way.take_level(parameters, &self.center);
            leaf.and_then(|()| way.go(state)).ok_or(NoMember::NoLeaf)?;
        }
        if let Some(extension) = &self.extension {
            extension.begin(state, parameters)?;
        }
        Ok(())
    }
}

/// Moves a state from the centre, where it is, to where a distribution draws it.
fn displace(center: &[f64], distribution: &Distribution, random: &mut Random, state: &mut [f64]) {
    match distribution {
        Distribution::Box(widths) => {
            for (x, width) in state.iter_mut().zip(widths) {
                *x += width * (2.0 * random.uniform() - 1.0);
            }
        }
        Distribution::Normal(deviations) => {
            for (x, deviation) in state.iter_mut().zip(deviations) {
                *x += deviation * random.normal();
            }
        }
        Distribution::Sphere(radius) => along_sphere(center, *radius, random, state),
        Distribution::Ball(radius) | Distribution::Leaf(radius) => {
            let part = libm::pow(random.uniform(), 1.0 / state.len() as f64);
            along_sphere(center, radius * part, random, state);
        }
    }
}

fn along_sphere(center: &[f64], radius: f64, random: &mut Random, state: &mut [f64]) {
    state.fill_with(|| random.normal());
    let length = libm::sqrt(state.iter().map(|v| v * v).sum());
    for (x, center) in state.iter_mut().zip(center) {
        *x = center + radius * (*x / length);
    }
}

/// How many members are given; `None` where none are.
fn rows(
    document: &SceneDocument,
    ensemble: &EnsembleSection,
    members: &Members,
    own: usize,
) -> Result<Option<u64>, Refusal> {
    let states = members.states.iter().map(|states| states.len() / own);
    let values = members.parameters.iter().map(|(_, values)| values.len());
    let counts: Vec<usize> = states.chain(values).collect();
    let is_whole = members
        .states
        .as_ref()
        .is_none_or(|s| s.len().is_multiple_of(own));
    let all = members
        .states
        .iter()
        .chain(members.parameters.iter().map(|(_, v)| v));
    let refuse = |message: &str| {
        let place = ensemble.initial.as_ref().map(Located::place);
        let place = place.as_ref().unwrap_or(&ensemble.place);
        Err(Box::new(document.diagnostic(place, message, "here", None)))
    };
    if !is_whole || counts.iter().any(|count| *count != counts[0]) || counts.first() == Some(&0) {
        return refuse("every member that is given needs a state and a value of each parameter");
    }
    if all.flatten().any(|value| !value.is_finite()) {
        return refuse("members that are given hold a number that is not finite");
    }
    Ok(counts.first().map(|count| *count as u64))
}

/// The members in a file.
fn read(
    document: &SceneDocument,
    ensemble: &EnsembleSection,
    path: &Path,
    run: &ComposedRun,
) -> Result<Members, Refusal> {
    let refuse = |message: String| {
        let place = ensemble.initial.as_ref().map(Located::place);
        let place = place.as_ref().unwrap_or(&ensemble.place);
        let help = "one row of coordinates for each member: CSV, with the coordinates' names in the first \
                    line or without, and parameters under their names, or a JSON list of lists";
        Box::new(document.diagnostic(place, message, "this file", Some(help.to_owned())))
    };
    let text = read_text(path)
        .map_err(|error| refuse(format!("cannot read {}: {error}", path.display())))?;
    let parameters = run.system.parameters().iter();
    let parameters: Vec<&str> = parameters.map(|p| p.name.as_str()).collect();
    Members::read(&text, &run.names(), &parameters)
        .map_err(|reason| refuse(format!("{}: {reason}", path.display())))
}

/// Members of an ensemble, at most: more than a machine steps in years, so that a slip of the keyboard
/// is reported as one.
const MOST_MEMBERS: u64 = 1_000_000_000_000;

/// The number of members, checked against [`MOST_MEMBERS`].
fn member_count(
    document: &SceneDocument,
    ensemble: &EnsembleSection,
    given: Option<&Located<u64>>,
    rows: Option<u64>,
    points: u64,
) -> Result<u64, Refusal> {
    let members = asked_members(document, ensemble, given, rows, points)?;
    if members <= MOST_MEMBERS {
        return Ok(members);
    }
    let given = given.map(Located::place);
    let place = given.as_ref().unwrap_or(&ensemble.place);
    Err(Box::new(document.diagnostic(
        place,
        format!("{members} members, at most {MOST_MEMBERS} are taken"),
        "here",
        Some("take a coarser grid, or `members` drawn at random".to_owned()),
    )))
}

/// The number of members, checked against the rows of a file and the points of a grid.
fn asked_members(
    document: &SceneDocument,
    ensemble: &EnsembleSection,
    given: Option<&Located<u64>>,
    rows: Option<u64>,
    points: u64,
) -> Result<u64, Refusal> {
    let most = rows.map(|rows| rows.saturating_mul(points));
    let Some(given) = given else {
        if let Some(most) = most {
            return Ok(most);
        }
        if points > 1 {
            return Ok(points);
        }
        let help = Some("for example: members = 10000".to_owned());
        let message = "[ensemble] needs `members`";
        return Err(Box::new(document.diagnostic(
            &ensemble.place,
            message,
            "`members` is missing",
            help,
        )));
    };
    let refuse = |message: String, help: String| {
        Box::new(document.diagnostic(&given.place(), message, "here", Some(help)))
    };
    let wanted = given.value;
    if let Some(most) = most.filter(|most| wanted > *most) {
        let message = format!("{wanted} members, and the file has states for {most}");
        return Err(refuse(
            message,
            "leave `members` out to take all".to_owned(),
        ));
    }
    if !wanted.is_multiple_of(points) {
        let below = wanted / points * points;
        let above = wanted.div_ceil(points).saturating_mul(points);
        let nearest = if below == 0 {
            format!("{above}")
        } else {
            format!("{below} or {above}")
        };
        let message =
            format!("{wanted} members do not fill the grid of {points} parameter sets evenly");
        return Err(refuse(message, format!("take {nearest}")));
    }
    Ok(wanted)
}

/// SHA-256 of the doubles' bytes, and of the parameters' names.
fn digest(members: &Members) -> [u8; 32] {
    let mut digest = Sha256::new();
    for value in members.states.iter().flatten() {
        digest.update(value.to_le_bytes());
    }
    for (name, values) in &members.parameters {
        digest.update(name);
        values
            .iter()
            .for_each(|value| digest.update(value.to_le_bytes()));
    }
    digest.finalize().into()
}

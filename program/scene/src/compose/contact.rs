//! Contact systems, q' = ∂H/∂p, p' = −∂H/∂q − p ∂H/∂s, s' = p·∂H/∂p − H.
//!
//! The canonical system of K = r H(q, P/r, s) over P·dq − r ds has one more coordinate r, behind all others. Steps end at r = 1,
//! where P is p: formulas of the scene stay as they are.

use std::sync::Arc;

use leafwise_core::StepMap;
use leafwise_core::contact::{ContactMap, Homogeneous};
use leafwise_expression::{Arithmetic, Expression};

use super::Refusal;
use super::stepping::{MapStepping, Stepping};
use super::tensor::Entries;
use crate::document::{BracketSpec, Convention, Place, SceneDocument};

/// Name of r in messages: no name of a formula.
pub(super) const SCALE: &str = "(r)";

/// The homogeneous system of a contact system.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// p and r.
    of: Homogeneous,
    /// q of each p.
    positions: Vec<usize>,
    /// s.
    action: usize,
    /// H.
    energy: Expression,
}

impl Contact {
    /// Puts K in the place of H of a scene with a contact bracket, and pairs s with r, the coordinate `scale` behind all others;
    /// `None` for other scenes.
    ///
    /// # Errors
    /// What does not stand beside it, and variables that are not pairs and one more, underlined in the scene.
    pub(super) fn of(
        document: &SceneDocument,
        (names, scale): (&[String], usize),
        bracket: &mut Entries,
        hamiltonian: &mut Expression,
    ) -> Result<Option<Self>, Refusal> {
        if !matches!(document.system.bracket.value, BracketSpec::Contact(_)) {
            return Ok(None);
        }
        check(document)?;
        let own = document.system.coordinates();
        let is_paired = |at: &usize| bracket.keys().any(|(a, b)| a == at || b == at);
        let left: Vec<usize> = (0..own).filter(|at| !is_paired(at)).collect();
        let [last] = left[..] else {
            let left: Vec<&str> = left.iter().map(|at| names[*at].as_str()).collect();
            let message = match left.is_empty() {
                true => {
                    "a contact bracket needs one variable in addition to its pairs, and there is none"
                        .to_owned()
                }
                false => format!(
                    "a contact bracket needs one variable in addition to its pairs, and there are {}",
                    left.join(", ")
                ),
            };
            let help = "write variables = [\"q\", \"p\", \"s\"]";
            return Err(refusal(
                document,
                &document.system.bracket.place(),
                message,
                help,
            ));
        };
        // {q, p} with which q' = ∂H/∂p.
        let sign = match document.system.convention {
            Convention::HamiltonFirst => -1,
            Convention::HamiltonSecond => 1,
        };
        let pairs = bracket.iter().filter(|((a, _), _)| *a < own);
        let (positions, momenta): (Vec<usize>, Vec<usize>) = pairs
            .map(
                |((a, b), entry)| match entry.evaluate(&[], &[]) == f64::from(sign) {
                    true => (*a, *b),
                    false => (*b, *a),
                },
            )
            .unzip();
        // The momentum of s is −r.
        bracket.insert((last, scale), Expression::from(-sign));
        let energy = hamiltonian.clone();
        let r = || Box::new(Expression::Variable(scale));
        let of_ratio = |at: usize| match momenta.contains(&at) {
            true => Expression::Quotient(Box::new(Expression::Variable(at)), r()),
            false => Expression::Variable(at),
        };
        *hamiltonian = Expression::Product(vec![*r(), energy.at_formulas(&of_ratio)]);
        Ok(Some(Self {
            of: Homogeneous { momenta, scale },
            positions,
            action: last,
            energy,
        }))
    }

    /// H, where K stands in its place.
    pub fn energy(&self) -> &Expression {
        &self.energy
    }

    /// The field of contact motions at r = 1 by {H, x} of H in the place of K: there q' = ∂H/∂p, p' = −∂H/∂q and r' = ∂H/∂s.
    pub(super) fn field<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        x: &[A::Element],
        (energy, mut field): (&A::Element, Vec<A::Element>),
    ) -> Vec<A::Element> {
        let by_action = field[self.of.scale].clone();
        let mut action = arithmetic.negate(energy);
        for (position, momentum) in self.positions.iter().zip(&self.of.momenta) {
            let work = arithmetic.multiply(&x[*momentum], &field[*position]);
            action = arithmetic.add(&action, &work);
            let friction = arithmetic.multiply(&x[*momentum], &by_action);
            field[*momentum] = arithmetic.subtract(&field[*momentum], &friction);
        }
        field[self.action] = action;
        field[self.of.scale] = arithmetic.zero();
        field
    }

    /// The map of the homogeneous system, and its steps from r = 1, brought back there.
    pub(super) fn enter(&self, method: Stepping) -> (Arc<dyn StepMap>, Stepping) {
        let map: Arc<dyn StepMap> = match method {
            Stepping::Written(method) => Arc::new(*method),
            Stepping::Map(stepping) => stepping.map,
            Stepping::Lattice(stepping) => stepping.stepped,
        };
        let entered = Stepping::Map(MapStepping {
            map: Arc::new(ContactMap::new(Arc::clone(&map), self.of.clone())),
            method: None,
            is_composed: false,
            noise: None,
        });
        (map, entered)
    }
}

/// Refuses what a contact system does not stand beside.
fn check(document: &SceneDocument) -> Result<(), Refusal> {
    let system = &document.system;
    let forces = &system.forces;
    let force = (forces.one_form.as_ref().map(|own| own.place()))
        .or(forces.torque.as_ref().map(|own| own.place()))
        .or(forces.damping.as_ref().map(|own| own.rate.place()))
        .or(forces.friction.as_ref().map(|own| own.place()));
    if let Some(place) = force {
        let message =
            "a contact bracket does not support forces: their work is not part of ds - p dq";
        let help = "write friction into H: `+ gamma*s` makes p' = ... - gamma*p";
        return Err(refusal(document, &place, message.to_owned(), help));
    }
    let others = [
        (
            system
                .noise
                .first()
                .map(|channel| channel.hamiltonian.place()),
            "noise",
            "remove the noise",
        ),
        (
            document.method.pace.as_ref().map(|pace| pace.place()),
            "a pace",
            "take steps that are short enough everywhere",
        ),
        (
            system.casimirs.first().map(|(name, _)| name.place()),
            "Casimirs",
            "record the function in `observables`: contact motions have no Casimirs",
        ),
        (
            system.constraints.first().map(|own| own.place()),
            "constraints",
            "write the system in coordinates without them",
        ),
    ];
    for (place, noun, help) in others {
        if let Some(place) = place {
            let message = format!("a contact bracket does not support {noun}");
            return Err(refusal(document, &place, message, help));
        }
    }
    Ok(())
}

/// Refuses a contact bracket over a long lattice.
///
/// # Errors
/// The bracket, underlined in the scene.
pub(super) fn check_short(document: &SceneDocument, is_long: bool) -> Result<(), Refusal> {
    let is_contact = matches!(document.system.bracket.value, BracketSpec::Contact(_));
    if is_contact && is_long {
        let message = "a contact bracket is not offered on long lattices: s and its momentum couple to every site";
        let place = document.system.bracket.place();
        return Err(refusal(
            document,
            &place,
            message.to_owned(),
            "shorten the lattice",
        ));
    }
    Ok(())
}

fn refusal(document: &SceneDocument, place: &Place, message: String, help: &str) -> Refusal {
    Box::new(document.diagnostic(place, message, "here", Some(help.to_owned())))
}

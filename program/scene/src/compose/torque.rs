//! `torque = ["…", "…", "…"]`: the one-form of a torque on a body with attitude.
//!
//! The form is η = −(2/|q|²) q∘(0, τ) on the quaternion q, of τ in the body: m′ gains τ, and q′ stays as it is. A torque in space stands on the other side, (0, τ)∘q.

use leafwise_core::PoissonSystem;
use leafwise_expression::Expression;
use leafwise_expression::syntax::Scope;

use super::Refusal;
use super::names::function;
use crate::document::{Located, SceneDocument, TorqueSpec};

/// Names of the angular momentum in the body.
const MOMENTUM: [&str; 3] = ["m1", "m2", "m3"];

/// Names of the attitude's quaternion.
const QUATERNION: [&str; 4] = ["q0", "q1", "q2", "q3"];

/// Bound on round-off of a torque of size one.
const ROUND_OFF: f64 = 1e-12;

/// Help for a system without attitude: forces on m alone move it along its leaf, which keeps |m|.
const NO_ATTITUDE: &str = "write `library = \"attitude\"`, or \"heavy-top-attitude\" with gravity, whose orientation is part of the \
                           state; `forces` cannot express a torque on m alone: they keep its length";

/// Adds the one-form of a torque to that of the other forces.
///
/// # Errors
/// A system without the coordinates of an attitude, and a formula that cannot be read.
pub(super) fn add_torque(
    document: &SceneDocument,
    scope: &Scope,
    torque: &Located<TorqueSpec>,
    moving: &[String],
    one_form: &mut Vec<Expression>,
    dimension: usize,
) -> Result<(), Refusal> {
    let at = |name: &&str| moving.iter().position(|known| known == name);
    let quaternion: Vec<usize> = QUATERNION.iter().filter_map(&at).collect();
    let momentum: Vec<usize> = MOMENTUM.iter().filter_map(at).collect();
    let (&[q0, q1, q2, q3], 3) = (&quaternion[..], momentum.len()) else {
        let message = "a torque acts on the attitude of a body, the quaternion q0, q1, q2, q3 with its momentum m1, m2, m3";
        let help = Some(NO_ATTITUDE.to_owned());
        return Err(Box::new(document.diagnostic(
            &torque.place(),
            message,
            "no attitude here",
            help,
        )));
    };
    one_form.resize(dimension, 0.into());
    let q = [q0, q1, q2, q3].map(Expression::Variable);
    let square: Expression = q.iter().map(|part| part.clone() * part.clone()).sum();
    let factor = Expression::from(-2) / square;
    for (formulas, side) in [(&torque.value.body, 1), (&torque.value.space, -1)] {
        let Some([a, b, c]) = formulas else { continue };
        let [a, b, c] = [a, b, c].map(|formula| function(document, scope, formula));
        let torque = [a?, b?, c?];
        for (at, part) in quaternion.iter().zip(product(&q, &torque, side)) {
            let known = one_form[*at].clone();
            one_form[*at] = known + factor.clone() * part;
        }
    }
    Ok(())
}

/// q∘(0, τ), or (0, τ)∘q where the side is −1.
fn product(q: &[Expression; 4], torque: &[Expression; 3], side: i32) -> [Expression; 4] {
    let [q0, axis @ ..] = q;
    let along: Expression = axis
        .iter()
        .zip(torque)
        .map(|(q, t)| q.clone() * t.clone())
        .sum();
    let across = |k: usize| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let turned = axis[i].clone() * torque[j].clone() - axis[j].clone() * torque[i].clone();
        q0.clone() * torque[k].clone() + Expression::from(side) * turned
    };
    [-along, across(0), across(1), across(2)]
}

/// Refuses a torque where the bracket is not that of an attitude: the one-form of τ = e_k would not be m_k′ = 1 at the initial
/// state.
///
/// # Errors
/// That the bracket is another.
pub(super) fn check_torque(
    document: &SceneDocument,
    system: &PoissonSystem,
    initial: &[f64],
) -> Result<(), Refusal> {
    let (Some(torque), Some(formulas)) = (&document.system.forces.torque, system.expressions())
    else {
        return Ok(());
    };
    let at = |name: &str| formulas.variables().iter().position(|known| known == name);
    let quaternion = QUATERNION.map(at);
    let q = quaternion.map(|at| at.map_or(0.0, |at| initial[at]));
    let square: f64 = q.iter().map(|part| part * part).sum();
    let parameters = system.parameter_values();
    let constant = |value: f64| Expression::from(value);
    let is_attitude = (0..3).all(|k| {
        let mut unit = [0.0; 3].map(constant);
        unit[k] = constant(1.0);
        let parts = product(&q.map(constant), &unit, 1);
        let parts = parts.map(|part| -2.0 / square * part.evaluate(&[], &[]));
        let mut field = vec![0.0; formulas.dimension()];
        for (&(i, j), entry) in formulas.tensor() {
            let value = entry.evaluate(initial, &parameters);
            for (at, part) in quaternion.iter().zip(parts) {
                // ẋ = −Π η.
                if *at == Some(j) {
                    field[i] -= value * part;
                }
                if *at == Some(i) {
                    field[j] += value * part;
                }
            }
        }
        if let Some(momentum) = at(MOMENTUM[k]) {
            field[momentum] -= 1.0;
        }
        field.iter().all(|rate| rate.abs() <= ROUND_OFF)
    });
    if is_attitude {
        return Ok(());
    }
    Err(Box::new(document.diagnostic(
        &torque.place(),
        "a torque needs the bracket of an attitude, under which q turns vectors of the body into those of space, and q ≠ 0 at the initial state",
        "the bracket is another",
        Some(NO_ATTITUDE.to_owned()),
    )))
}

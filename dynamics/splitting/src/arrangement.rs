//! The order in which χ takes the pieces.

use std::collections::BTreeSet;

use leafwise_core::part::{PartInfo, PartParameters};
use leafwise_core::solver::Pieces;
use leafwise_core::system::energy_casimir::coefficient_sum;
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{AlgebraError, Ring};

use crate::display::Names;
use crate::flow::lie_derivative;
use crate::piece::{Piece, Tensor};

/// The parameter that names the order.
pub(crate) const ORDER: &str = "pieces";

/// The order left to the splitting.
pub(crate) const AUTO: &str = "auto";

/// The pieces in the order that a scene names, by their numbers from 1 on: `2 1 3`; `None` where it is left open.
///
/// # Errors
/// [`BuildError::Parameter`] where the numbers are not 1 to `count`, each once.
pub(crate) fn named_order(
    info: &'static PartInfo,
    parameters: &PartParameters,
    count: usize,
) -> Result<Option<Vec<usize>>, BuildError> {
    let value = parameters.setting(info, ORDER)?.to_string();
    if value == AUTO {
        return Ok(None);
    }
    let numbers = value.split_whitespace().map(str::parse);
    let numbers: Result<Vec<usize>, _> = numbers.collect();
    let all: BTreeSet<usize> = (1..=count).collect();
    match numbers {
        Ok(order)
            if order.len() == count && order.iter().copied().collect::<BTreeSet<_>>() == all =>
        {
            Ok(Some(order.into_iter().map(|number| number - 1).collect()))
        }
        _ => Err(BuildError::Parameter {
            part: info.name,
            parameter: ORDER.to_owned(),
            value,
            expected: format!(
                "\"{AUTO}\", or the numbers 1 to {count} of the pieces in any order, such as \"{}\"",
                example(count)
            ),
        }),
    }
}

fn example(count: usize) -> String {
    let numbers: Vec<String> = (1..=count).rev().map(|number| number.to_string()).collect();
    numbers.join(" ")
}

/// The order of pieces for a composition that asks for their kind.
///
/// # Errors
/// [`BuildError::Pieces`] where they are not of that kind.
pub(crate) fn asked_order(
    system: &SystemFormulas,
    ring: &Ring,
    pieces: &[Piece],
    asked: Pieces,
    map: String,
) -> Result<Vec<usize>, BuildError> {
    let refusal = |reason| BuildError::Pieces { map, asked, reason };
    if asked == Pieces::Any {
        return Ok((0..pieces.len()).collect());
    }
    let [one, other] = pieces else {
        return Err(refusal(format!("it has {}", pieces.len())));
    };
    let mut ring = ring.clone();
    match asked {
        Pieces::Any => unreachable!("answered above"),
        Pieces::Nystrom { kick_first } => {
            let kick = if is_kick(system, &mut ring, one, other)? {
                0
            } else if is_kick(system, &mut ring, other, one)? {
                1
            } else {
                let written = |ring: &mut Ring, piece: &Piece| {
                    let hamiltonian = piece.hamiltonian(ring);
                    Names { system, ring }.polynomial(&hamiltonian)
                };
                let pieces = [written(&mut ring, one), written(&mut ring, other)];
                return Err(refusal(format!(
                    "{{V, {{V, {{V, T}}}}}} is not 0 for V = {}, T = {}, nor the other way round",
                    pieces[0], pieces[1]
                )));
            };
            Ok(if kick_first {
                vec![kick, 1 - kick]
            } else {
                vec![1 - kick, kick]
            })
        }
        Pieces::Perturbed => {
            let mut size = |piece: &Piece| {
                let hamiltonian = piece.hamiltonian(&mut ring);
                coefficient_sum(system, &ring, &hamiltonian)
            };
            Ok(if size(one) >= size(other) {
                vec![0, 1]
            } else {
                vec![1, 0]
            })
        }
    }
}

/// Whether the exact algebra proves that {V, {V, {V, T}}} is a Casimir.
fn is_kick(
    system: &SystemFormulas,
    ring: &mut Ring,
    kick: &Piece,
    other: &Piece,
) -> Result<bool, AlgebraError> {
    let tensor = Tensor::new(system, ring)?;
    let hamiltonian = kick.hamiltonian(ring);
    let field = tensor.field(ring, &hamiltonian)?;
    let mut bracket = other.hamiltonian(ring);
    for _ in 0..3 {
        bracket = lie_derivative(ring, &field, &bracket, &mut BTreeSet::new())?;
    }
    Ok(tensor.field(ring, &bracket)?.is_empty())
}

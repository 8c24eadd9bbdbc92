//! The order in which χ takes the pieces.

use std::collections::BTreeSet;

use leafwise_core::part::{PartInfo, PartParameters};
use leafwise_core::solver::Pieces;
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{AlgebraError, Polynomial, Ring};

use crate::display::Names;
use crate::field::Field;
use crate::flow::lie_derivative;
use crate::piece::Piece;
use crate::tensor::Tensor;

/// The parameter that names the order.
pub(crate) const ORDER: &str = "pieces";

/// The order left to the splitting.
pub(crate) const AUTO: &str = "auto";

/// Order of the pieces that a scene names by their numbers from 1 on, such as `2 1 3`. Returns numbers from 0 on, or
/// `None` where the order is left open.
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
    map: &str,
) -> Result<Vec<usize>, BuildError> {
    let refusal = |reason| BuildError::Pieces {
        map: map.to_owned(),
        asked,
        reason,
    };
    let pair = || match pieces {
        [one, other] => Ok([one, other]),
        _ => Err(refusal(format!("it has {}", pieces.len()))),
    };
    let mut ring = ring.clone();
    Ok(match asked {
        Pieces::Any => (0..pieces.len()).collect(),
        Pieces::Nystrom { kick_first } => {
            let pair = pair()?;
            let Some(kick) = kick(system, &mut ring, pair)? else {
                let [one, other] = pair.map(|piece| {
                    let hamiltonian = piece.hamiltonian(&mut ring);
                    let ring = &ring;
                    Names { system, ring }.polynomial(&hamiltonian)
                });
                return Err(refusal(format!(
                    "{{V, {{V, {{V, T}}}}}} is not 0 for V = {one}, T = {other}, nor the other way round"
                )));
            };
            let first = if kick_first { kick } else { 1 - kick };
            vec![first, 1 - first]
        }
        Pieces::Perturbed => {
            let tensor = Tensor::new(system, &mut ring)?;
            let [one, other] = pair()?.map(|piece| {
                let hamiltonian = piece.hamiltonian(&mut ring);
                size(system, &ring, &tensor, &hamiltonian)
            });
            let first = usize::from(one < other);
            vec![first, 1 - first]
        }
    })
}

/// Σ|c| over the terms c·(what moves) of a Hamiltonian, at the parameters' values and the state's coordinates at rest, such as a
/// mass of every site.
fn size(system: &SystemFormulas, ring: &Ring, tensor: &Tensor, f: &Polynomial) -> f64 {
    let values = system.parameter_values();
    let numbers = f.terms().iter().map(|(monomial, coefficient)| {
        let resting = tensor.parted(ring, monomial).0;
        let number = ring.formula(&Polynomial::term(resting, coefficient.clone()));
        number.evaluate(system.near(), &values).abs()
    });
    numbers.sum()
}

/// Number of the piece, of two, that is V, where the exact algebra proves that {V, {V, {V, T}}} is a Casimir. The one
/// with the shorter {V, {V, T}} is tried first, since the brackets of the other may be long.
fn kick(
    system: &SystemFormulas,
    ring: &mut Ring,
    pieces: [&Piece; 2],
) -> Result<Option<usize>, AlgebraError> {
    let tensor = Tensor::new(system, ring)?;
    let hamiltonians = pieces.map(|piece| piece.hamiltonian(ring));
    let mut tried = Vec::with_capacity(2);
    for (at, hamiltonian) in hamiltonians.iter().enumerate() {
        let field = tensor.field(ring, hamiltonian)?;
        let mut bracket = hamiltonians[1 - at].clone();
        for _ in 0..2 {
            bracket = along(ring, &field, &bracket)?;
        }
        tried.push((at, field, bracket));
    }
    tried.sort_by_key(|(_, _, bracket)| bracket.terms().len());
    for (at, field, bracket) in tried {
        let bracket = along(ring, &field, &bracket)?;
        if tensor.field(ring, &bracket)?.is_empty() {
            return Ok(Some(at));
        }
    }
    Ok(None)
}

/// {f, K} for the field of K, up to its sign.
fn along(ring: &mut Ring, field: &Field, f: &Polynomial) -> Result<Polynomial, AlgebraError> {
    lie_derivative(ring, field, f, &mut BTreeSet::new())
}

//! The pieces of a system's Hamiltonian.

use std::collections::BTreeSet;

use leafwise_core::system::energy_casimir::{coefficient_sum, shifted};
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::algebra::Monomial;
use leafwise_expression::{Arithmetic, Expression, Polynomial, Rational, Ring};

use crate::body::FreeBody;
use crate::display::Names;
use crate::flow::crossed_seam;
use crate::kepler;
use crate::piece::{Atom, NAME, Piece, WholeMotion};
use crate::probe::Probe;
use crate::rounds::rounds;
use crate::tensor::Tensor;
use crate::turning::TurningPair;

/// H = Σ H_i (up to Casimirs) with an exact flow of each H_i.
///
/// The summands of H as its author wrote them are added one after the other to the first piece that still has an exact
/// flow with them. Summands that have no exact flow as a whole are added by their monomials. Terms of pairs of sites are
/// taken in rounds of disjoint pairs. The kinetic and the
/// potential part of a Hamiltonian come out, and the even and odd sites of a lattice.
///
/// A difference H − λC, C a Casimir and λ such that a monomial of H is gone, may take fewer pieces. Then it is split
/// in the place of H, whose flow it has: the rigid body turns about two axes, not three. Of several splittings with as
/// few pieces the one with the smallest coefficients is taken, at the parameters' values. The pieces' commutators make
/// the error. With [`Bodies::Whole`] the free rigid bodies in H become pieces first, and the bodies that centres attract one piece.
///
/// # Errors
/// Fails with [`BuildError::DoesNotFit`] with the monomial that has no exact flow. Fails with [`BuildError::Algebra`]
/// where a formula is outside the algebra.
pub fn find_pieces(
    system: &SystemFormulas,
    ring: &mut Ring,
    bodies: Bodies,
) -> Result<Vec<Piece>, BuildError> {
    let (tensor, probe) = (Tensor::new(system, ring)?, Probe::of(system));
    let mut summands_of_h = Vec::new();
    for summand in summands(system.hamiltonian()) {
        summands_of_h.push((polynomial(ring, &summand)?, summand));
    }
    if bodies == Bodies::Whole {
        let bodies = whole_bodies(system, ring, &tensor, &mut summands_of_h)?;
        let rest = split(system, ring, (&probe, &tensor), &summands_of_h, usize::MAX)?;
        return Ok(rest.into_iter().flatten().chain(bodies).collect());
    }
    let pieces = split(system, ring, (&probe, &tensor), &summands_of_h, usize::MAX);
    let pieces = pieces.map(Option::unwrap_or_default);
    let parts: Vec<_> = summands_of_h
        .iter()
        .map(|(f, _)| (Rational::one(), f.clone()))
        .collect();
    let hamiltonian = ring.combine(&parts);
    let mut best: Option<(usize, f64, Vec<Piece>)> = None;
    for casimir in system.casimirs() {
        let casimir = polynomial(ring, &casimir.expression)?;
        if !tensor.field(ring, &casimir)?.is_empty() {
            continue;
        }
        for shifted in shifted(ring, &hamiltonian, &casimir) {
            let whole = [(shifted.clone(), ring.formula(&shifted))];
            let most = match (&best, &pieces) {
                (Some((count, ..)), _) => *count,
                (None, Ok(pieces)) => pieces.len().saturating_sub(1),
                (None, Err(_)) => usize::MAX,
            };
            let Ok(Some(pieces)) = split(system, ring, (&probe, &tensor), &whole, most) else {
                continue;
            };
            let size = coefficient_sum(system, ring, &shifted);
            let better = best.as_ref().is_none_or(|(count, least, _)| {
                pieces.len() < *count || pieces.len() == *count && size < *least
            });
            if better {
                best = Some((pieces.len(), size, pieces));
            }
        }
    }
    match (pieces, best) {
        (Ok(pieces), Some((count, _, fewer))) if count < pieces.len() => Ok(fewer),
        (Err(BuildError::DoesNotFit { .. }), Some((_, _, pieces))) => Ok(pieces),
        (pieces, _) => pieces,
    }
}

/// How free rigid bodies, and bodies that a centre attracts, are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bodies {
    /// About one axis after the other; kinetic energy and attraction apart.
    Axes,
    /// By the exact flow of the whole body: Jacobi's or Kepler's.
    Whole,
}

/// The free rigid bodies in a sum, and those that centres attract. The sum keeps the rest.
fn whole_bodies(
    system: &SystemFormulas,
    ring: &mut Ring,
    tensor: &Tensor,
    sum: &mut Vec<(Polynomial, Expression)>,
) -> Result<Vec<Piece>, BuildError> {
    let mut bodies = Vec::new();
    loop {
        let parts: Vec<_> = sum
            .iter()
            .map(|(f, _)| (Rational::one(), f.clone()))
            .collect();
        let whole = ring.combine(&parts);
        let Some((body, energy)) = FreeBody::find(system, ring, tensor, &whole)? else {
            break;
        };
        for (f, formula) in sum.iter_mut() {
            let is_of_energy =
                |monomial: &Monomial| energy.terms().iter().any(|(m, _)| m == monomial);
            let rest = f.terms().iter().filter(|(m, _)| !is_of_energy(m)).cloned();
            let rest = Polynomial::collect(rest);
            if rest != *f {
                *formula = ring.formula(&rest);
                *f = rest;
            }
        }
        sum.retain(|(f, _)| !f.is_zero());
        let atom = atom_of(ring, tensor, energy)?;
        bodies.push(Piece::of_whole(WholeMotion::Body(body), atom));
    }
    if let Some((motions, energy)) = kepler::find(system, ring, tensor, sum)? {
        sum.retain(|(f, _)| !f.is_zero());
        let atom = atom_of(ring, tensor, energy)?;
        bodies.push(Piece::of_whole(WholeMotion::Kepler(motions), atom));
    }
    if bodies.is_empty() {
        return Err(BuildError::DoesNotFit {
            part: NAME,
            reason: "its Hamiltonian has neither squared momenta of a rigid body, three variables with brackets of so(3) \
                     that also move all others as so(3) does, nor a body about a centre, a*|p|^2 - k/|q - c| in two or three pairs \
                     with constant brackets: leave `bodies` at \"axes\""
                .to_owned(),
        });
    }
    Ok(bodies)
}

fn atom_of(ring: &mut Ring, tensor: &Tensor, energy: Polynomial) -> Result<Atom, BuildError> {
    Ok(Atom {
        field: tensor.field(ring, &energy)?,
        formula: ring.formula(&energy),
        hamiltonian: energy,
        turning: None,
    })
}

fn polynomial(ring: &mut Ring, formula: &Expression) -> Result<Polynomial, BuildError> {
    Ok(formula.evaluate_in(ring, &mut |ring: &mut Ring, at| Ok(ring.variable(at)))?)
}

/// So many atoms that went to the first piece one after the other are followed by as many at once.
const STREAK: usize = 8;

/// The pieces of a sum; `None` where they are more than `most`.
fn split(
    system: &SystemFormulas,
    ring: &mut Ring,
    (probe, tensor): (&Probe, &Tensor),
    sum: &[(Polynomial, Expression)],
    most: usize,
) -> Result<Option<Vec<Piece>>, BuildError> {
    let dimension = system.dimension();
    let mut all = Vec::new();
    for (f, formula) in sum {
        all.extend(atoms(system, ring, probe, tensor, f.clone(), formula)?);
    }
    let rounds = rounds(ring, probe, &all, dimension)?;
    let mut pieces: Vec<Piece> = Vec::new();
    // The round that each piece is of.
    let mut of_pieces: Vec<Option<usize>> = Vec::new();
    // How many of the last atoms one after the other went to the first piece, and before which all are placed.
    let (mut streak, mut placed) = (0_usize, 0);
    for (k, (atom, &round)) in all.iter().zip(&rounds).enumerate() {
        if k < placed {
            continue;
        }
        if streak >= STREAK {
            let end = all.len().min(k + streak);
            let next: Vec<&Atom> = all[k..end].iter().collect();
            let are_free = rounds[k..end].iter().all(Option::is_none);
            if are_free && pieces[0].add_all(ring, probe, &next)?.is_ok() {
                (streak, placed) = (streak + next.len(), end);
                continue;
            }
            streak = 0;
        }
        let own = of_pieces
            .iter()
            .position(|of| round.is_some() && *of == round);
        if let Some(own) = own
            && pieces[own].add(ring, probe, atom)?.is_ok()
        {
            continue;
        }
        let may_be = |at: &usize| round.is_none() || of_pieces[*at].is_none();
        let free: Vec<usize> = (0..pieces.len()).filter(may_be).collect();
        let at = place(ring, probe, &mut pieces, &free, atom, dimension)?;
        of_pieces.resize(pieces.len(), None);
        of_pieces[at] = of_pieces[at].or(round);
        streak = if at == 0 { streak + 1 } else { 0 };
        if pieces.len() > most {
            return Ok(None);
        }
    }
    Ok(Some(pieces))
}

/// A summand as a whole where it has an exact flow, its monomials otherwise; none that is a Casimir.
pub(crate) fn atoms(
    system: &SystemFormulas,
    ring: &mut Ring,
    probe: &Probe,
    tensor: &Tensor,
    summand: Polynomial,
    formula: &Expression,
) -> Result<Vec<Atom>, BuildError> {
    let mut whole = Atom {
        field: tensor.field(ring, &summand)?,
        hamiltonian: summand,
        formula: formula.clone(),
        turning: None,
    };
    if whole.field.is_empty() {
        return Ok(Vec::new());
    }
    if whole.flows(ring, probe)?.is_ok() {
        return Ok(vec![whole]);
    }
    whole.turning = TurningPair::find(ring, tensor, &whole.field)?;
    if whole.turning.is_some() {
        return Ok(vec![whole]);
    }
    let mut atoms = Vec::new();
    for (monomial, coefficient) in whole.hamiltonian.terms() {
        let term = Polynomial::term(monomial.clone(), coefficient.clone());
        let atom = Atom {
            field: tensor.field(ring, &term)?,
            formula: ring.formula(&term),
            hamiltonian: term,
            turning: None,
        };
        if let Err(coordinate) = atom.flows(ring, probe)? {
            return Err(refusal(system, ring, &atom, coordinate)?);
        }
        if !atom.field.is_empty() {
            atoms.push(atom);
        }
    }
    Ok(atoms)
}

fn refusal(
    system: &SystemFormulas,
    ring: &mut Ring,
    atom: &Atom,
    coordinate: usize,
) -> Result<BuildError, BuildError> {
    let velocity = atom.field.get(&coordinate).cloned();
    let velocities: Vec<Polynomial> = velocity.into_iter().collect();
    let seam = crossed_seam(ring, &atom.field, &velocities, &mut BTreeSet::new())?;
    let names = Names { system, ring };
    let (term, variable) = (
        shortened(names.polynomial(&atom.hamiltonian)),
        &system.variables()[coordinate],
    );
    let reason = match seam {
        None => format!(
            "its Hamiltonian does not split: under the term `{term}` alone the motion of {variable} is neither \
             polynomial in time, nor exponential, nor a rotation"
        ),
        Some(seam) => format!(
            "its Hamiltonian does not split: under the term `{term}` alone the motion of {variable} crosses a seam of the \
             term, because `{}` changes along it. Splitting needs conditions that are constant under their own term; \
             gauss, collective and hamilton-jacobi take any",
            names.polynomial(&seam)
        ),
    };
    Ok(BuildError::DoesNotFit { part: NAME, reason })
}

/// The beginning of a long formula.
fn shortened(mut text: String) -> String {
    const LONGEST: usize = 200;
    if let Some((end, _)) = text.char_indices().nth(LONGEST) {
        text.truncate(end);
        text.push('…');
    }
    text
}

/// Adds an atom to the first of these pieces that keeps an exact flow with it, or to a new one; which one it is in.
fn place(
    ring: &mut Ring,
    probe: &Probe,
    pieces: &mut Vec<Piece>,
    tried: &[usize],
    atom: &Atom,
    dimension: usize,
) -> Result<usize, BuildError> {
    for at in tried {
        if pieces[*at].add(ring, probe, atom)?.is_ok() {
            return Ok(*at);
        }
    }
    let mut piece = Piece::empty(dimension);
    let added = piece.add(ring, probe, atom)?;
    debug_assert!(added.is_ok(), "an atom has an exact flow");
    pieces.push(piece);
    Ok(pieces.len() - 1)
}

/// The summands of a formula, through signs and common denominators.
pub(crate) fn summands(formula: &Expression) -> Vec<Expression> {
    match formula {
        Expression::Sum(terms) => terms.iter().flat_map(summands).collect(),
        Expression::Negate(inner) => {
            let negate = |term| Expression::Negate(Box::new(term));
            summands(inner).into_iter().map(negate).collect()
        }
        Expression::Quotient(above, below) => {
            let over = |term| Expression::Quotient(Box::new(term), below.clone());
            summands(above).into_iter().map(over).collect()
        }
        Expression::Shared(shared) => summands(shared),
        other => vec![other.clone()],
    }
}

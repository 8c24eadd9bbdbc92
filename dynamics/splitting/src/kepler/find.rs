//! Kepler's problems among the terms of a Hamiltonian.

use leafwise_core::SystemFormulas;
use leafwise_expression::algebra::{Generator, Monomial};
use leafwise_expression::{AlgebraError, Arithmetic, Expression, Polynomial, Rational, Ring};

use super::{KeplerBody, KeplerMotions};
use crate::field::variables;
use crate::tensor::Tensor;

/// The bodies in a sum of terms that move about fixed centres, and their energy Σ a|p|² − k/|q − c|, which is taken out
/// of the sum. The numbers a, k and c may depend on coordinates at rest, such as a mass of every site.
///
/// A body that several centres attract moves about the strongest one, at the parameters' values. Its squares of momenta
/// are those of terms that mix them with nothing: of |p₁|²/2m₁ + |p₁ + p₂|²/2m₀ the first.
///
/// # Errors
/// [`AlgebraError`] where a derivative does not exist.
pub(crate) fn find(
    system: &SystemFormulas,
    ring: &mut Ring,
    tensor: &Tensor,
    sum: &mut [(Polynomial, Expression)],
) -> Result<Option<(KeplerMotions, Polynomial)>, AlgebraError> {
    let (mut bodies, mut energies) = (Vec::new(), Vec::new());
    for (centre, strength) in centres(system, ring, tensor, sum) {
        let Some(pairs) = pairs(ring, tensor, &centre)? else {
            continue;
        };
        let Some((squares, of_squares)) = squares(ring, tensor, sum, &pairs) else {
            continue;
        };
        let rates = [(&of_squares, 2), (&strength, -1)].map(|(number, factor)| {
            let product = ring.multiply(&pairs.sign, number);
            product.scaled(&Rational::from_integer(factor))
        });
        let momenta: Vec<usize> = pairs.pairs.iter().map(|[_, p]| *p).collect();
        for (f, formula) in sum.iter_mut() {
            let takes_squares = is_apart(ring, tensor, f, &momenta, &squares);
            let is_taken = |m: &Monomial| {
                let moving = tensor.parted(ring, m).1;
                moving == centre || takes_squares && squares.contains(&moving)
            };
            let (taken, rest): (Vec<_>, Vec<_>) =
                f.terms().iter().cloned().partition(|(m, _)| is_taken(m));
            if !taken.is_empty() {
                energies.push((Rational::one(), Polynomial::collect(taken)));
                *f = Polynomial::collect(rest);
                *formula = ring.formula(f);
            }
        }
        bodies.push(KeplerBody {
            pairs: pairs.pairs,
            centre: pairs.centre,
            rates,
        });
    }
    let energy = ring.combine(&energies);
    Ok((!bodies.is_empty()).then_some((KeplerMotions(bodies), energy)))
}

/// The number, which rests, in front of a product that may move.
fn number_of<'a>(
    ring: &Ring,
    tensor: &Tensor,
    terms: impl IntoIterator<Item = &'a Polynomial>,
    of: &Monomial,
) -> Polynomial {
    let terms = terms.into_iter().flat_map(Polynomial::terms);
    Polynomial::collect(terms.filter_map(|(monomial, coefficient)| {
        let (resting, moving) = tensor.parted(ring, monomial);
        (moving == *of).then(|| (resting, coefficient.clone()))
    }))
}

/// The products 1/√u of a sum with their numbers, the largest first.
fn centres(
    system: &SystemFormulas,
    ring: &Ring,
    tensor: &Tensor,
    sum: &[(Polynomial, Expression)],
) -> Vec<(Monomial, Polynomial)> {
    let terms = sum.iter().flat_map(|(f, _)| f.terms());
    let centres = terms.map(|(monomial, _)| tensor.parted(ring, monomial).1);
    let mut unlike: Vec<Monomial> = Vec::new();
    for centre in centres.filter(|centre| square(ring, centre).is_some()) {
        if !unlike.contains(&centre) {
            unlike.push(centre);
        }
    }
    let values = system.parameter_values();
    let with_numbers = unlike.into_iter().map(|centre| {
        let number = number_of(ring, tensor, sum.iter().map(|(f, _)| f), &centre);
        let strength = ring.formula(&number).evaluate(system.near(), &values);
        (strength.abs(), centre, number)
    });
    let mut centres: Vec<_> = with_numbers.collect();
    centres.sort_by(|a, b| b.0.total_cmp(&a.0));
    centres.into_iter().map(|(_, m, c)| (m, c)).collect()
}

/// u of a product u^½/u.
fn square(ring: &Ring, monomial: &Monomial) -> Option<Polynomial> {
    let [(a, 1), (b, 1)] = monomial.factors() else {
        return None;
    };
    match [ring.generator(*a), ring.generator(*b)] {
        [Some(Generator::Root(u, 2)), Some(Generator::Inverse(v))]
        | [Some(Generator::Inverse(v)), Some(Generator::Root(u, 2))]
            if u == v =>
        {
            Some(u.clone())
        }
        _ => None,
    }
}

/// The variables of a body.
struct Centred {
    /// q_i and p_i.
    pairs: Vec<[usize; 2]>,
    /// c.
    centre: Vec<Polynomial>,
    /// q_i′ under the Hamiltonian p_i.
    sign: Polynomial,
}

/// The body of a product 1/|q − c|: two or three q_i with constant brackets {q_i, p_j} = ±δ_ij, {q_i, q_j} = {p_i, p_j} = 0.
fn pairs(
    ring: &mut Ring,
    tensor: &Tensor,
    centre: &Monomial,
) -> Result<Option<Centred>, AlgebraError> {
    let Some(u) = square(ring, centre) else {
        return Ok(None);
    };
    let mut places = variables(ring, &u);
    places.retain(|at| !tensor.rests(*at));
    if !matches!(places.len(), 2 | 3) {
        return Ok(None);
    }
    let mut rest = u.clone();
    let (mut pairs, mut centre) = (Vec::new(), Vec::new());
    let mut sign = None;
    for q in places {
        let linear = Monomial::power(q as u32, 1);
        let twice = number_of(ring, tensor, [&u], &linear);
        let about = twice.scaled(&Rational::new(-1, 2));
        let x = ring.variable(q);
        let x = ring.subtract(&x, &about);
        let square = ring.multiply(&x, &x);
        rest = ring.subtract(&rest, &square);
        let Some((p, _)) = partner(ring, tensor, q)? else {
            return Ok(None);
        };
        let Some((back, own)) = partner(ring, tensor, p)? else {
            return Ok(None);
        };
        if back != q || sign.as_ref().is_some_and(|sign| *sign != own) {
            return Ok(None);
        }
        sign = Some(own);
        pairs.push([q, p]);
        centre.push(about);
    }
    Ok(sign.filter(|_| rest.is_zero()).map(|sign| Centred {
        pairs,
        centre,
        sign,
    }))
}

/// The one coordinate that a coordinate moves, by a constant velocity.
fn partner(
    ring: &mut Ring,
    tensor: &Tensor,
    at: usize,
) -> Result<Option<(usize, Polynomial)>, AlgebraError> {
    let x = ring.variable(at);
    let field = tensor.field(ring, &x)?;
    let mut components = field.into_iter();
    Ok(match (components.next(), components.next()) {
        (Some((other, velocity)), None) if velocity.as_constant().is_some() => {
            Some((other, velocity))
        }
        _ => None,
    })
}

/// The squares of the momenta with their common number.
fn squares(
    ring: &Ring,
    tensor: &Tensor,
    sum: &[(Polynomial, Expression)],
    pairs: &Centred,
) -> Option<(Vec<Monomial>, Polynomial)> {
    let momenta: Vec<usize> = pairs.pairs.iter().map(|[_, p]| *p).collect();
    let squares = momenta.iter().map(|p| Monomial::power(*p as u32, 2));
    let squares: Vec<Monomial> = squares.collect();
    let apart = sum.iter().map(|(f, _)| f);
    let apart = apart.filter(|f| is_apart(ring, tensor, f, &momenta, &squares));
    let apart: Vec<&Polynomial> = apart.collect();
    let number = |square| number_of(ring, tensor, apart.iter().copied(), square);
    let first = number(&squares[0]);
    let all = squares.iter().all(|square| number(square) == first);
    (all && !first.is_zero()).then_some((squares, first))
}

/// Whether a term has the momenta in their squares alone.
fn is_apart(
    ring: &Ring,
    tensor: &Tensor,
    f: &Polynomial,
    momenta: &[usize],
    squares: &[Monomial],
) -> bool {
    f.terms().iter().all(|(monomial, coefficient)| {
        let own = Polynomial::term(monomial.clone(), coefficient.clone());
        let has_momentum = variables(ring, &own).iter().any(|at| momenta.contains(at));
        !has_momentum || squares.contains(&tensor.parted(ring, monomial).1)
    })
}

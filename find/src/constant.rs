//! Tensors that are constant in z = x or in z = ln x.
//!
//! ż = g(z) with g = f, or g_i = f_i/x_i. Where J is constant and invertible, W = J⁻¹ has W g = ∇H, so that W ∂g/∂z is symmetric: linear
//! in W. Where J has the Casimirs c·z, these are integrals, c·g = 0, and the same holds on the leaves c·z = const.

use std::collections::BTreeMap;

use leafwise_expression::algebra::relations;
use leafwise_expression::{AlgebraError, Arithmetic, Polynomial, Rational, Ring};

use crate::error::FindError;
use crate::field::{RingField, dot, over};
use crate::matrix::{Matrix, inverse, product, transposed, zeros};
use crate::potential::potential;
use crate::report::{Attempt, Kind, NoBracket, TensorCandidate};

/// Choices of Casimirs among more linear integrals.
const MOST_CHOICES: usize = 64;

/// The largest dimension: of 48 variables W has 1128 entries.
const MOST_VARIABLES: usize = 48;

/// Members of a family that are tried.
const MOST_MEMBERS: usize = 40;

/// z and g.
struct Rates<'a> {
    field: &'a mut RingField,
    kind: Kind,
    g: Vec<Polynomial>,
}

/// The leaves c·z = const: the coordinates along them, and the directions ∂z/∂(coordinate).
struct Leaves {
    along: Vec<usize>,
    /// `directions[a][j]`.
    directions: Matrix,
}

/// A tensor of this kind, the sparsest of those that are tried.
pub(crate) fn constant(field: &mut RingField, kind: Kind) -> Result<Attempt, FindError> {
    let d = field.dimension();
    if d > MOST_VARIABLES {
        return Ok(Attempt::none(format!(
            "the search takes at most {MOST_VARIABLES} variables"
        )));
    }
    let g = match kind {
        Kind::LogCanonical => match field.rates() {
            Some(rates) => rates,
            None => {
                return Ok(Attempt::none(
                    "the search needs equations that each have their own variable as a factor",
                ));
            }
        },
        _ => field.f.clone(),
    };
    let mut rates = Rates { field, kind, g };
    let slopes = rates.slopes()?;
    let single: Vec<Vec<Polynomial>> = rates.g.iter().map(|g| vec![g.clone()]).collect();
    let integrals = relations(&single, &[]).solutions();
    let integrals = integrals.map_or_else(Vec::new, |solutions| solutions.directions);
    let mut reasons = Vec::new();
    let mut is_proved = rates.field.is_decided();
    let is_regular = |choice: &Vec<usize>| (d - choice.len()).is_multiple_of(2) && choice.len() < d;
    for choice in choices(integrals.len()).into_iter().filter(is_regular) {
        let casimirs: Vec<&Vec<Rational>> = choice.iter().map(|&at| &integrals[at]).collect();
        let leaves = Leaves::of(&casimirs, d);
        match rates.on(&leaves, &slopes)? {
            Ok(found) => return Ok(Attempt::Found(Box::new(found))),
            Err(none) => {
                is_proved &= none.is_proved;
                reasons.push(none);
            }
        }
    }
    // Of several linear integrals every subspace may be that of the Casimirs; bases alone were tried.
    is_proved &= integrals.len() <= 1;
    let z = if kind == Kind::LogCanonical {
        "ln x"
    } else {
        "x"
    };
    let lacks_hamiltonian = |none: &NoBracket| none.lacks_hamiltonian;
    let told = reasons.iter().position(lacks_hamiltonian).unwrap_or(0);
    Ok(match reasons.into_iter().nth(told) {
        Some(none) => Attempt::None(NoBracket { is_proved, ..none }),
        None => {
            let reason = format!(
                "a tensor in an odd number of variables has a Casimir c·{z}, and no c·{z} is an integral"
            );
            match is_proved {
                true => Attempt::proved(reason),
                false => Attempt::none(reason),
            }
        }
    })
}

/// Subsets of 0 … n−1, the small ones first.
fn choices(n: usize) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    let mut last = all.clone();
    while let Some(first) = last.first()
        && first.len() < n
        && all.len() < MOST_CHOICES
    {
        let longer = last.iter().flat_map(|choice| {
            let from = choice.last().map_or(0, |at| at + 1);
            (from..n).map(move |at| choice.iter().copied().chain([at]).collect())
        });
        last = longer.collect();
        all.extend(last.iter().cloned());
    }
    all.truncate(MOST_CHOICES);
    all
}

impl Leaves {
    fn of(casimirs: &[&Vec<Rational>], d: usize) -> Self {
        // The constraints' echelon form: each pivot is a function of the others on a leaf.
        let mut elimination = leafwise_expression::algebra::Elimination::new(d);
        for casimir in casimirs {
            elimination.add(casimir.iter().cloned().enumerate());
        }
        let directions = elimination.solutions().map(|s| s.directions);
        let directions = directions.unwrap_or_default();
        // A direction's free coordinate is the one that the others do not have.
        let along = (0..directions.len()).map(|a| {
            (0..d)
                .find(|&j| {
                    directions[a][j].is_one()
                        && (directions.iter().enumerate())
                            .all(|(b, other)| b == a || other[j].is_zero())
                })
                .unwrap_or(0)
        });
        Self {
            along: along.collect(),
            directions,
        }
    }
}

impl Rates<'_> {
    /// ∂f/∂z_j.
    fn slope(
        ring: &mut Ring,
        kind: Kind,
        f: &Polynomial,
        j: usize,
    ) -> Result<Polynomial, AlgebraError> {
        let slope = ring.derivative(f, j)?;
        Ok(match kind {
            Kind::LogCanonical => {
                let x = ring.variable(j);
                ring.multiply(&x, &slope)
            }
            _ => slope,
        })
    }

    /// ∂g_i/∂z_j.
    fn slopes(&mut self) -> Result<Vec<Vec<Polynomial>>, AlgebraError> {
        let (d, kind) = (self.g.len(), self.kind);
        let ring = &mut self.field.ring;
        let row = |g: &Polynomial| (0..d).map(|j| Self::slope(ring, kind, g, j)).collect();
        self.g.iter().map(row).collect()
    }

    /// A tensor with these leaves, or the reason why there is none.
    fn on(
        &mut self,
        leaves: &Leaves,
        slopes: &[Vec<Polynomial>],
    ) -> Result<Result<TensorCandidate, NoBracket>, FindError> {
        let n = leaves.along.len();
        // G_ba = Σ_j T_aj ∂_j g_b along the leaves.
        let mut along = vec![vec![Polynomial::zero(); n]; n];
        for (b, row) in along.iter_mut().enumerate() {
            for (a, entry) in row.iter_mut().enumerate() {
                let terms: Vec<_> = (leaves.directions[a].iter())
                    .zip(&slopes[leaves.along[b]])
                    .filter(|(factor, _)| !factor.is_zero())
                    .map(|(factor, slope)| (factor.clone(), slope.clone()))
                    .collect();
                *entry = self.field.ring.combine(&terms);
            }
        }
        let pairs: Vec<(usize, usize)> = pairs(n);
        // (W G)_ab − (W G)_ba of W = e_i ∧ e_j.
        let columns: Vec<Vec<Polynomial>> = (pairs.iter())
            .map(|&(i, j)| {
                let one = Rational::one();
                (pairs.iter())
                    .map(|&(a, b)| {
                        let mut terms = Vec::new();
                        for (row, other, sign) in [(a, b, one.clone()), (b, a, -&one)] {
                            if row == i {
                                terms.push((sign.clone(), along[j][other].clone()));
                            }
                            if row == j {
                                terms.push((-&sign, along[i][other].clone()));
                            }
                        }
                        self.field.ring.combine(&terms)
                    })
                    .collect()
            })
            .collect();
        let elimination = relations(&columns, &[]);
        let rank = elimination.rank();
        let family = elimination.solutions().map(|s| s.directions);
        let mut family = family.unwrap_or_default();
        for member in &mut family {
            if sign_of_momentum(member, &pairs, &along) < 0 {
                member.iter_mut().for_each(|entry| *entry = -&*entry);
            }
        }
        if family.is_empty() {
            let z = if self.kind == Kind::LogCanonical {
                "ln x"
            } else {
                "x"
            };
            let space = match leaves.along.len() == self.g.len() {
                true => String::new(),
                false => " on the leaves of linear integrals".to_owned(),
            };
            return Ok(Err(NoBracket {
                reason: format!(
                    "of constant W over {z}, W Dg is symmetric for W = 0 alone{space}: the equations for its {} entries have rank {rank}",
                    pairs.len()
                ),
                is_proved: true,
                lacks_hamiltonian: false,
            }));
        }
        let mut best: Option<TensorCandidate> = None;
        let mut is_singular = true;
        for member in members(&family) {
            let mut w = zeros(n, n);
            for (&(i, j), entry) in pairs.iter().zip(&member) {
                w[i][j] = entry.clone();
                w[j][i] = -entry;
            }
            let Some(inverse) = inverse(&w) else { continue };
            is_singular = false;
            let Some(hamiltonian) = self.hamiltonian(leaves, &w)? else {
                continue;
            };
            let directions = transposed(&leaves.directions);
            let tensor = product(&product(&directions, &inverse), &leaves.directions);
            let candidate = TensorCandidate {
                kind: self.kind,
                tensor: self.entries(&tensor),
                hamiltonian,
                family: family.len(),
                energy: None,
                casimirs: Vec::new(),
            };
            TensorCandidate::keep_smaller(&mut best, Some(candidate), &self.field.ring);
            if family.len() == 1 {
                break;
            }
        }
        Ok(best.ok_or_else(|| {
            let reason = match is_singular {
                true => format!(
                    "W Dg is symmetric for a family of W of dimension {}, and every member that was tried is singular",
                    family.len()
                ),
                false => "one fits, and no formula of its Hamiltonian was found: W Dg is symmetric for an invertible W".to_owned(),
            };
            NoBracket {
                reason,
                is_proved: false,
                lacks_hamiltonian: !is_singular,
            }
        }))
    }

    /// H with ∂H/∂z along the leaves equal to W g.
    fn hamiltonian(
        &mut self,
        leaves: &Leaves,
        w: &Matrix,
    ) -> Result<Option<Polynomial>, AlgebraError> {
        let ring = &mut self.field.ring;
        let mut u = Vec::new();
        for (a, row) in w.iter().enumerate() {
            let terms: Vec<_> = (row.iter().zip(&leaves.along))
                .filter(|(factor, _)| !factor.is_zero())
                .map(|(factor, &b)| (factor.clone(), self.g[b].clone()))
                .collect();
            let sum = ring.combine(&terms);
            u.push(match self.kind {
                Kind::LogCanonical => over(&sum, leaves.along[a]),
                _ => sum,
            });
        }
        let kind = self.kind;
        let derivations = |ring: &mut Ring, f: &Polynomial| {
            let d = ring.variables();
            let gradient = (0..d)
                .map(|j| Self::slope(ring, kind, f, j))
                .collect::<Result<Vec<_>, _>>()?;
            let rows = leaves.directions.iter().zip(&leaves.along);
            let row = |(direction, &along): (&Vec<Rational>, &usize)| {
                let constants: Vec<Polynomial> =
                    direction.iter().map(|c| ring.constant(c)).collect();
                let sum = dot(ring, &constants, &gradient);
                match kind {
                    Kind::LogCanonical => over(&sum, along),
                    _ => sum,
                }
            };
            Ok(rows.map(row).collect())
        };
        potential(ring, &derivations, &leaves.along, &u)
    }

    /// The entries in x.
    fn entries(&mut self, tensor: &Matrix) -> BTreeMap<(usize, usize), Polynomial> {
        let ring = &mut self.field.ring;
        let kind = self.kind;
        let entry = |(i, j): (usize, usize)| {
            let number = &tensor[i][j];
            if number.is_zero() {
                return None;
            }
            let one = ring.constant(number);
            Some((
                (i, j),
                match kind {
                    Kind::LogCanonical => {
                        let (x, y) = (ring.variable(i), ring.variable(j));
                        let both = ring.multiply(&x, &y);
                        ring.multiply(&one, &both)
                    }
                    _ => one,
                },
            ))
        };
        pairs(tensor.len()).into_iter().filter_map(entry).collect()
    }
}

/// The sign of the energies of momenta in H, ∂H/∂z = W g. Terms of ∂_j (W g)_j = Σ_i W_ji ∂_j g_i with constant ∂_j g_i are of a momentum z_j: those
/// with i < j decide before the others. A part of the equations that moves alone has an H of its own, whose sign no other part decides.
fn sign_of_momentum(w: &[Rational], pairs: &[(usize, usize)], slopes: &[Vec<Polynomial>]) -> i32 {
    let sign = |f: &Polynomial| match f.terms() {
        [(m, c)] if m.factors().is_empty() => c.terms().first().map_or(0, |(_, v)| v.signum()),
        _ => 0,
    };
    let of = |at: fn((usize, usize)) -> (usize, usize), order: i32| -> i32 {
        let parts = w.iter().zip(pairs).map(|(entry, &pair)| {
            let (i, j) = at(pair);
            order * entry.signum() * sign(&slopes[i][j])
        });
        parts.sum()
    };
    match of(|pair| pair, -1) {
        0 => of(|(i, j)| (j, i), 1),
        sum => sum,
    }
}

/// (i, j) with i < j < n.
pub(crate) fn pairs(n: usize) -> Vec<(usize, usize)> {
    (0..n)
        .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
        .collect()
}

/// Members of the linear family, the sparse ones first: a basis, its sum, that of members with one entry, sums and differences of two, sums with small
/// integers.
pub(crate) fn members(family: &[Vec<Rational>]) -> Vec<Vec<Rational>> {
    let n = family.len();
    let combined = |factors: &dyn Fn(usize) -> i64| -> Vec<Rational> {
        let mut sum = vec![Rational::zero(); family[0].len()];
        for (k, member) in family.iter().enumerate() {
            let factor = Rational::from_integer(factors(k));
            if factor.is_zero() {
                continue;
            }
            for (entry, part) in sum.iter_mut().zip(member) {
                *entry += &(&factor * part);
            }
        }
        sum
    };
    let mut all: Vec<Vec<Rational>> = family.to_vec();
    if n > 1 {
        all.push(combined(&|_| 1));
        // Of parts that move alone and at one frequency each pair has its own member.
        let is_single = |k: usize| family[k].iter().filter(|entry| !entry.is_zero()).count() == 1;
        all.push(combined(&|k| i64::from(is_single(k))));
        for (a, b) in pairs(n) {
            for sign in [1, -1] {
                all.push(combined(&|k| i64::from(k == a) + sign * i64::from(k == b)));
            }
        }
        all.truncate(MOST_MEMBERS);
        for shift in 1..6 {
            all.push(combined(&|k| {
                ((7 * k as i64 + 3 * shift) * (k as i64 + shift)) % 11 - 5
            }));
        }
    }
    all
}

//! Algebras by matrices that a user gives.

use std::sync::Arc;

use leafwise_core::{BuildError, StepError, SystemFormulas};
use leafwise_expression::Rational;

use crate::algebra::{Algebra, NAME, Section, canonical};
use crate::constants::{LinearTensor, form_bracket};
use crate::forms::{Forms, Product, product, sum};
use crate::orbits::dimensions;
use crate::over::over;
use crate::quadratic::WIDEST;
use crate::relabel::Relabelling;

/// Matrices of a representation, as a scene gives them.
#[derive(Clone, Debug)]
pub struct Matrices {
    /// ρ(e_k), one matrix a variable, in rows.
    pub representation: String,
    /// ω of a symplectic representation, in rows; empty for the cotangent lift of any.
    pub symplectic_form: String,
    /// How many copies there are; 0 for the fewest whose J is onto near a general point and has orbits for fibres.
    pub copies: usize,
}

/// The algebra of the matrices, and how it is the tensor's.
///
/// # Errors
/// Returns [`BuildError::Parameter`] for matrices that are none, [`BuildError::NoRepresentation`] with the first
/// bracket that fails. Returns [`BuildError::DoesNotFit`] where J is not onto or its fibres are not orbits of linear
/// symmetries.
pub fn algebra(
    given: &Matrices,
    system: &SystemFormulas,
    tensor: &LinearTensor,
) -> Result<(Algebra, Relabelling), BuildError> {
    let d = system.dimension();
    let wrong = |parameter: &str, value: &str, expected: String| BuildError::Parameter {
        part: NAME,
        parameter: parameter.to_owned(),
        value: value.to_owned(),
        expected,
    };
    let text = &given.representation;
    let matrices: Option<Vec<Square>> = text.split(';').map(Square::parse).collect();
    let matrices = matrices.filter(|matrices| {
        matrices.len() == d && matrices.iter().all(|m| m.width == matrices[0].width)
    });
    let matrices = matrices.ok_or_else(|| {
        wrong(
            "representation",
            text,
            format!(
                "it is {d} square matrices of one size, one for each variable, as [[0, 1/2], [-1/2, 0]]"
            ),
        )
    })?;
    let width = matrices[0].width;
    let is_cotangent = given.symplectic_form.trim().is_empty();
    let (v, omega, forms) = if is_cotangent {
        let pairs: Vec<_> = (0..width).map(|a| (a, width + a)).collect();
        let forms = matrices.iter().map(paired).collect();
        (2 * width, canonical(2 * width, &pairs, 1), forms)
    } else {
        let text = &given.symplectic_form;
        let form = Square::parse(text).filter(|form| form.width == width && form.is_odd());
        let inverse = form.as_ref().and_then(Square::inverse);
        let (Some(form), Some(omega)) = (form, inverse) else {
            let expected = format!(
                "it is an antisymmetric matrix of {width} rows that has an inverse, or nothing for the cotangent lift"
            );
            return Err(wrong("symplectic-form", text, expected));
        };
        let forms = matrices.iter().enumerate().map(|(k, matrix)| {
            moment(&form, matrix).ok_or_else(|| BuildError::DoesNotFit {
                part: NAME,
                reason: format!(
                    "the matrix of {} does not keep the symplectic form: form times matrix has to be symmetric",
                    system.variables()[k]
                ),
            })
        });
        let forms: Result<Vec<_>, _> = forms.collect();
        (width, omega.entries, forms?)
    };
    let forms = Forms::new(v, forms);
    let unit = check_brackets(system, tensor, &forms, &omega, &matrices)?;
    let copies = match given.copies {
        0 => {
            let most = WIDEST[1] / v;
            let fitting = (1..=most).find(|copies| check_fibres(&forms, &omega, *copies).is_ok());
            fitting.unwrap_or(1)
        }
        copies => copies,
    };
    if d > WIDEST[0] || v * copies > WIDEST[1] {
        return Err(wrong(
            "copies",
            &copies.to_string(),
            format!(
                "a representation has at most {} variables and {} coordinates, and this one has {d} and {}",
                WIDEST[0],
                WIDEST[1],
                v * copies
            ),
        ));
    }
    check_fibres(&forms, &omega, copies)?;
    let is_signed = !is_cotangent;
    let section: Section = {
        let forms = forms.clone();
        Arc::new(move |y, z, signs| match over(&forms, y, z, signs) {
            true => Ok(()),
            false => Err(StepError::OutsideImage {
                part: NAME,
                reason: "no point of the representation's coordinates was found over it",
                hint: "raise `copies`, or take another representation",
            }),
        })
    };
    let picks = (0..d).map(|k| (k, Rational::one()));
    let algebra = Algebra {
        name: "a representation",
        forms,
        omega,
        copies,
        is_signed,
        section,
        settle: None,
        groups: &[],
    };
    let order = Relabelling {
        picks: picks.collect(),
        unit,
    };
    Ok((algebra, order))
}

/// pᵀMq.
fn paired(matrix: &Square) -> Vec<Product> {
    let n = matrix.width;
    let entries = matrix.entries.iter().enumerate();
    let entries = entries.filter(|(_, entry)| !entry.is_zero());
    entries
        .map(|(at, entry)| Product {
            factor: entry.clone(),
            places: [at % n, n + at / n],
        })
        .collect()
}

/// ½ zᵀωMz; `None` where ωM is not symmetric.
fn moment(form: &Square, matrix: &Square) -> Option<Vec<Product>> {
    let n = matrix.width;
    let entries = product(n, &form.entries, &matrix.entries);
    let mut products = Vec::new();
    for a in 0..n {
        for b in a..n {
            if entries[a * n + b] != entries[b * n + a] {
                return None;
            }
            let factor = if a == b { 2 } else { 1 };
            let factor = &entries[a * n + b] * &Rational::new(1, factor);
            if !factor.is_zero() {
                products.push(Product {
                    factor,
                    places: [a, b],
                });
            }
        }
    }
    Some(products)
}

/// t with S_iΩS_j − S_jΩS_i = Σ_k c_ij^k S_k / t for all i and j.
fn check_brackets(
    system: &SystemFormulas,
    tensor: &LinearTensor,
    forms: &Forms,
    omega: &[Rational],
    matrices: &[Square],
) -> Result<Rational, BuildError> {
    let (n, d) = (forms.coordinates(), forms.count());
    let squares: Vec<_> = (0..d).map(|k| forms.matrix(k)).collect();
    let mut unit: Option<Rational> = None;
    for i in 0..d {
        for j in i + 1..d {
            let bracket = form_bracket(n, &squares[i], &squares[j], omega);
            let mut expected = vec![Rational::from_integer(0); n * n];
            for (k, c) in tensor.constants.bracket(i, j) {
                expected = sum(&expected, &squares[*k], c);
            }
            if unit.is_none()
                && let Some(at) = bracket.iter().position(|entry| !entry.is_zero())
            {
                unit = expected[at].checked_div(&bracket[at]);
                unit = unit.filter(|unit| !unit.is_zero());
            }
            let scale = unit.clone().unwrap_or_else(Rational::one);
            let differs = |at: &usize| &bracket[*at] * &scale != expected[*at];
            if (0..n * n).any(|at| differs(&at)) {
                let name = |at: usize| system.variables()[at].clone();
                let (entry, values) = failure(matrices, tensor, (i, j), unit.as_ref());
                return Err(BuildError::NoRepresentation {
                    part: NAME,
                    bracket: Box::new([name(i), name(j)]),
                    entry,
                    values: Box::new(values),
                });
            }
        }
    }
    Ok(unit.unwrap_or_else(Rational::one))
}

/// The entry of [M_i, M_j] that is farthest from what the tensor asks for, as numbers.
fn failure(
    matrices: &[Square],
    tensor: &LinearTensor,
    (i, j): (usize, usize),
    unit: Option<&Rational>,
) -> ([usize; 2], [String; 2]) {
    let n = matrices[0].width;
    let (first, second) = (&matrices[i].entries, &matrices[j].entries);
    let commutator = sum(
        &product(n, first, second),
        &product(n, second, first),
        &-Rational::one(),
    );
    let mut expected = vec![Rational::from_integer(0); n * n];
    for (k, c) in tensor.constants.bracket(i, j) {
        expected = sum(&expected, &matrices[*k].entries, c);
    }
    let one = Rational::one();
    // Commutators have the sign of the forms' brackets or the other one: the nearer one is meant.
    let distance = |scale: &Rational| {
        let pairs = commutator.iter().zip(&expected).enumerate();
        let entries = pairs.map(|(at, (a, b))| (at, (&(a * scale) - b).abs()));
        entries
            .reduce(|most, next| if next.1 > most.1 { next } else { most })
            .expect("matrices have entries")
    };
    let scale = unit.unwrap_or(&one);
    let candidates = [scale.clone(), -scale];
    let (at, scale) = candidates
        .into_iter()
        .map(|scale| (distance(&scale), scale))
        .min_by(|a, b| a.0.1.cmp(&b.0.1))
        .map(|((at, _), scale)| (at, scale))
        .expect("two signs");
    let found = &commutator[at] * &scale;
    let values = [found, expected[at].clone()].map(|value| value.to_string());
    ([at / n, at % n], values)
}

/// Refuses a J that is not onto, and one whose fibres are no orbits.
fn check_fibres(forms: &Forms, omega: &[Rational], copies: usize) -> Result<(), BuildError> {
    let unfit = |reason: String| BuildError::DoesNotFit { part: NAME, reason };
    let d = forms.count();
    let squares: Vec<_> = (0..d).map(|k| forms.matrix(k)).collect();
    let found = dimensions(forms.coordinates(), &squares, omega, copies);
    let found =
        found.ok_or_else(|| unfit("the matrices hold numbers that are too long".to_owned()))?;
    if found.image < d {
        return Err(unfit(format!(
            "{copies} copies of the representation reach {} of {d} dimensions; raise `copies`, or take a faithful one",
            found.image
        )));
    }
    if found.orbits < found.kernel {
        return Err(unfit(format!(
            "fibres of {copies} copies of the representation have {} dimensions, and its linear symmetries move points in {} of \
             them: a step in its coordinates would be no map of the state; take other `copies` or another representation, as \
             that of a dual pair",
            found.kernel, found.orbits
        )));
    }
    Ok(())
}

/// A square matrix, row-major.
#[derive(Clone, Debug)]
struct Square {
    width: usize,
    entries: Vec<Rational>,
}

impl Square {
    /// [[a, b], [c, d]] with numbers as 1, -0.5, 1/2.
    fn parse(text: &str) -> Option<Self> {
        let inner = text.trim().strip_prefix('[')?.strip_suffix(']')?;
        let mut entries = Vec::new();
        let mut rows = 0;
        let mut rest = inner.trim();
        while !rest.is_empty() {
            let end = rest.find(']')?;
            let row = rest.strip_prefix('[')?.get(..end - 1)?;
            for number in row.split(',') {
                entries.push(number_of(number.trim())?);
            }
            rows += 1;
            if entries.len() % rows != 0 {
                return None;
            }
            rest = rest[end + 1..].trim();
            if !rest.is_empty() {
                rest = rest.strip_prefix(',')?.trim();
            }
        }
        (rows > 0 && entries.len() == rows * rows).then_some(Self {
            width: rows,
            entries,
        })
    }

    fn is_odd(&self) -> bool {
        let n = self.width;
        let places = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        places
            .into_iter()
            .all(|(i, j)| self.entries[i * n + j] == -&self.entries[j * n + i])
    }

    fn inverse(&self) -> Option<Self> {
        let n = self.width;
        let zero = Rational::from_integer(0);
        let mut rows: Vec<Vec<Rational>> = (0..n)
            .map(|i| {
                let mut row = self.entries[i * n..][..n].to_vec();
                row.resize(2 * n, zero.clone());
                row[n + i] = Rational::one();
                row
            })
            .collect();
        for k in 0..n {
            let pivot = (k..n).find(|i| !rows[*i][k].is_zero())?;
            rows.swap(k, pivot);
            let scale = rows[k][k].recip();
            rows[k].iter_mut().for_each(|entry| *entry *= &scale);
            let row = rows[k].clone();
            for (_, other) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
                let factor = -&other[k];
                *other = sum(other, &row, &factor);
            }
        }
        let entries = rows.into_iter().flat_map(|row| row.into_iter().skip(n));
        Some(Self {
            width: n,
            entries: entries.collect(),
        })
    }
}

/// 1, -0.5 or 1/2.
fn number_of(text: &str) -> Option<Rational> {
    match text.split_once('/') {
        None => Rational::parse_decimal(text).ok(),
        Some((above, below)) => {
            let above = Rational::parse_decimal(above.trim()).ok()?;
            above.checked_div(&Rational::parse_decimal(below.trim()).ok()?)
        }
    }
}

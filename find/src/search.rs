//! The search, kind by kind, and the proof of what it finds.

use leafwise_core::diagnostics::{Verdict, check_jacobi};
use leafwise_core::system::{Casimir, Convention, Parameter};
use leafwise_core::{PoissonSystem, SystemFormulas};
use leafwise_expression::{Arithmetic, Expression, Polynomial};

use crate::affine::affine;
use crate::casimirs::casimirs_of;
use crate::constant::constant;
use crate::equations::Equations;
use crate::error::FindError;
use crate::field::RingField;
use crate::integrals::integrals;
use crate::low::low;
use crate::never::never;
use crate::report::{Attempt, FoundBracket, Kind, RefusedKind, Report, TensorCandidate};

/// The degree of first integrals where none is asked for: that of f, at least 2 and at most this.
const MOST_DEGREE: usize = 3;

/// The degree of Casimirs where none is asked for.
const CASIMIR_DEGREE: usize = 2;

/// Settings of a search.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// The degree up to which first integrals and Casimirs are looked for; `None` for that of f, 2 or 3.
    pub degree: Option<usize>,
}

/// Looks for brackets and Hamiltonians of equations, kind by kind in the order of [`Kind::ALL`], until one is found.
///
/// Constant and log-canonical brackets are first looked for with the parameters as names, then with numbers in their places. All others are
/// those of the numbers.
///
/// # Errors
/// [`FindError`] for an equation that the exact algebra cannot read, and past limits.
pub fn find(equations: &Equations, options: Options) -> Result<Report, FindError> {
    let mut named = equations.variables().iter().zip(equations.field());
    if let Some((variable, _)) = named.find(|(_, formula)| formula.has_seams()) {
        let variable = variable.clone();
        return Err(FindError::Pieces { variable });
    }
    let mut report = Report {
        bracket: None,
        refused: Vec::new(),
        integrals: Vec::new(),
        degree: 0,
        never: None,
    };
    if !equations.parameters().is_empty() {
        report.bracket = within_limits(for_all_parameters(equations, options))?.flatten();
        if report.bracket.is_some() {
            return Ok(report);
        }
    }
    let numbers = equations.with_numbers();
    let mut field = RingField::of(&numbers)?;
    let degree = options
        .degree
        .unwrap_or_else(|| field.degree().clamp(2, MOST_DEGREE));
    let mut known: Option<Vec<Polynomial>> = None;
    for kind in Kind::ALL {
        if matches!(kind, Kind::Affine | Kind::FirstIntegrals) && known.is_none() {
            let (found, degree) = integrals_within(&mut field, degree, options)?;
            report.integrals = found.iter().map(|f| field.ring.formula(f)).collect();
            report.degree = degree;
            known = Some(found);
        }
        let known = known.as_deref().unwrap_or_default();
        let attempt = match kind {
            Kind::Constant | Kind::LogCanonical => constant(&mut field, kind)?,
            Kind::Affine => affine(&mut field, known)?,
            Kind::FirstIntegrals => low(&mut field, known)?,
        };
        match attempt {
            Attempt::None(none) => report.refused.push(none.of(kind)),
            Attempt::Found(candidate) => {
                let bracket = proved(&numbers, &mut field, &candidate, false, options)?;
                report.bracket = bracket;
                match &report.bracket {
                    Some(_) => return Ok(report),
                    None => report.refused.push(RefusedKind {
                        kind,
                        reason: "a tensor was found that was not proved to be Poisson".to_owned(),
                        is_proved: false,
                        lacks_hamiltonian: false,
                    }),
                }
            }
        }
    }
    report.never = never(&mut field, equations.variables())?;
    Ok(report)
}

/// A constant or log-canonical bracket with the parameters as names.
fn for_all_parameters(
    equations: &Equations,
    options: Options,
) -> Result<Option<FoundBracket>, FindError> {
    let mut field = RingField::of(equations)?;
    for kind in [Kind::Constant, Kind::LogCanonical] {
        if let Attempt::Found(candidate) = constant(&mut field, kind)?
            && let Some(bracket) = proved(equations, &mut field, &candidate, true, options)?
        {
            return Ok(Some(bracket));
        }
    }
    Ok(None)
}

/// A result that the search can do without: `None` where the exact algebra cannot form it.
fn within_limits<T>(result: Result<T, FindError>) -> Result<Option<T>, FindError> {
    match result {
        Err(FindError::Algebra(_) | FindError::Equation { .. }) => Ok(None),
        result => result.map(Some),
    }
}

/// Integrals of this degree. Where none is asked for, of the largest degree up to it that is within the limits.
fn integrals_within(
    field: &mut RingField,
    degree: usize,
    options: Options,
) -> Result<(Vec<Polynomial>, usize), FindError> {
    for degree in (1..=degree).rev() {
        match integrals(field, degree) {
            Err(FindError::TooMany { .. }) if options.degree.is_none() => {}
            result => return result.map(|found| (found, degree)),
        }
    }
    Ok((Vec::new(), 0))
}

/// Casimirs of this degree, by the same rule.
fn casimirs_within(
    system: &SystemFormulas,
    options: Options,
) -> Result<Vec<Expression>, FindError> {
    let degree = options.degree.unwrap_or(CASIMIR_DEGREE);
    for degree in (1..=degree).rev() {
        match casimirs_of(system, degree) {
            Err(FindError::TooMany { .. }) if options.degree.is_none() => {}
            result => return result,
        }
    }
    Ok(Vec::new())
}

/// The candidate as a system, where J ∇H = f and Jacobi's identity hold exactly.
fn proved(
    equations: &Equations,
    field: &mut RingField,
    candidate: &TensorCandidate,
    has_parameters: bool,
    options: Options,
) -> Result<Option<FoundBracket>, FindError> {
    let values: Vec<f64> = (equations.parameters().iter())
        .map(|(_, value)| value.to_f64())
        .collect();
    let candidate = candidate.clone().normalized(field, &values)?;
    let ring = &field.ring;
    let entries = candidate.tensor.iter();
    let entries: std::collections::BTreeMap<(usize, usize), Expression> = entries
        .map(|(pair, entry)| (*pair, ring.formula(entry)))
        .collect();
    let hamiltonian = candidate.written(ring);
    let parameters = equations
        .parameters()
        .iter()
        .map(|(name, value)| Parameter {
            name: name.clone(),
            value: value.to_f64(),
        });
    let system = |casimirs: Vec<Casimir>| {
        SystemFormulas::new(
            equations.variables().to_vec(),
            parameters.clone().collect(),
            entries.clone(),
            hamiltonian.clone(),
            casimirs,
            Convention::HamiltonianSecond,
        )
    };
    let alone = system(Vec::new())?;
    if !moves_by(&alone, equations, candidate.kind)? {
        return Ok(None);
    }
    let values = alone.parameter_values();
    let near = alone.near().to_vec();
    let check = check_jacobi(&PoissonSystem::from(alone.clone()), &values, &near)?;
    let is_poisson = match check.verdict {
        Verdict::Proved | Verdict::ByConstruction => true,
        // φ ∇C is Poisson for all φ and C: the algebra does not reduce fractions.
        Verdict::NumericallyZero => candidate.kind == Kind::FirstIntegrals,
        _ => false,
    };
    if !is_poisson {
        return Ok(None);
    }
    let mut casimirs = candidate.casimirs;
    if casimirs.is_empty() {
        casimirs = within_limits(casimirs_within(&alone, options))?.unwrap_or_default();
    }
    let named = casimirs.iter().enumerate().map(|(at, expression)| Casimir {
        name: casimir_name(at, casimirs.len(), equations),
        expression: expression.clone(),
    });
    let system = system(named.collect())?;
    Ok(Some(FoundBracket {
        kind: candidate.kind,
        entries,
        hamiltonian,
        casimirs,
        family: candidate.family,
        has_parameters,
        system,
    }))
}

/// `C`, or `C1`, `C2`, …, behind as many underscores as make it new.
fn casimir_name(at: usize, count: usize, equations: &Equations) -> String {
    let mut name = match count {
        1 => "C".to_owned(),
        _ => format!("C{}", at + 1),
    };
    let parameters = equations.parameters().iter().map(|(name, _)| name);
    let names: Vec<&String> = equations.variables().iter().chain(parameters).collect();
    while names.contains(&&name) {
        name.push('_');
    }
    name
}

/// Whether {x, H} = f in normal form. Of a bracket by integrals, whose fractions the algebra may not reduce, the identity was proved with
/// denominators multiplied out: there its values are compared.
fn moves_by(system: &SystemFormulas, equations: &Equations, kind: Kind) -> Result<bool, FindError> {
    let mut field = RingField::of(equations)?;
    let ring = &mut field.ring;
    let x: Vec<Polynomial> = (0..system.dimension()).map(|i| ring.variable(i)).collect();
    let energy = system
        .hamiltonian()
        .evaluate_in(ring, &mut |_, at| Ok(x[at].clone()))?;
    let gradient = ring.gradient(&energy)?;
    let rows = system.apply_tensor(ring, &x, &gradient)?;
    let mut holds = true;
    for (row, f) in rows.iter().zip(&field.f) {
        // ẋ = −Π ∇H in the paper's convention.
        let difference = ring.add(row, f);
        if difference.is_zero() {
            continue;
        }
        let values = system.parameter_values();
        let difference = ring.formula(&difference).evaluate(system.near(), &values);
        let size = ring.formula(f).evaluate(system.near(), &values).abs();
        holds &= kind == Kind::FirstIntegrals && difference.abs() <= 1e-9 * (1.0 + size);
    }
    if let Some(refusal) = ring.refusal() {
        return Err(refusal.clone().into());
    }
    Ok(holds)
}

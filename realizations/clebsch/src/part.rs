//! The part `clebsch`.

use std::sync::Arc;

use leafwise_core::lift::{ConstantLift, Lift, LiftSum, Summand};
use leafwise_core::part::{
    ParameterDefault, ParameterInfo, ParameterSetting, PartInfo, PartKind, PartParameters,
};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{
    BuildError, LiftedRealization, PoissonSystem, RealizationData, Registry, SystemFormulas,
};

use crate::algebra::NAME;
use crate::algebras::known;
use crate::constants::LinearTensor;
use crate::quadratic::QuadraticLift;
use crate::relabel::relabelling;
use crate::representation::{self, Matrices};

/// Most copies of a representation.
const MOST_COPIES: i64 = 16;

static INFO: PartInfo = PartInfo {
    name: NAME,
    summary: "quadratic momentum maps as coordinates of constant brackets: so(3), e(3), so(4), sp(2n), representations, and sums",
    declares: "exact; self-adjoint",
    domain: "linear tensors of so(3), e(3) = se(3), so(4), sp(2) to sp(8) with a constant factor, in any order and with any signs of \
             variables, of a given representation, and direct sums of these with constant and log-canonical tensors; with the \
             dynamics `collective`; all points, but of e(3) none where the vector alone is 0",
    literature: "R. McLachlan, K. Modin, O. Verdier, Collective symplectic integrators, Nonlinearity 27 (2014); \
                 J. E. Marsden, A. Weinstein, Coadjoint orbits, vortices, and Clebsch variables for incompressible \
                 fluids, Physica D 7 (1983); R. Howe, Remarks on classical invariant theory, Transactions of the AMS 313 (1989): \
                 dual pairs",
    parameters: &[
        ParameterInfo {
            name: "representation",
            summary: "a matrix for each variable, as [[0, 1], [-1, 0]]: x_k = p.M_k q of the cotangent lift, or half of z.form M_k z",
            default: ParameterDefault::Formulas(&[]),
        },
        ParameterInfo {
            name: "symplectic-form",
            summary: "the antisymmetric matrix that a symplectic representation keeps; none for the cotangent lift",
            default: ParameterDefault::Formulas(&[]),
        },
        ParameterInfo {
            name: "copies",
            summary: "of the representation's coordinates, with signs where it is symplectic: 1 to 16, 0 the fewest that reach every state near a \
                      general one",
            default: ParameterDefault::Integer(0),
        },
    ],
    is_lift: true,
    ..PartInfo::of(PartKind::Realization)
};

/// The realizations of the part.
#[derive(Clone, Copy, Debug)]
pub struct Clebsch;

impl Clebsch {
    /// The coordinates of a system's tensor; of a direct sum, those of every summand. A summand has those of its
    /// algebra, or its own where it is constant. Any other summand takes those of the first part of `registry` that is
    /// a lift and fits.
    ///
    /// # Errors
    /// Returns [`BuildError::DoesNotFit`] with the first summand that none of these serves. Returns
    /// [`BuildError::Algebra`] where an entry has no normal form.
    pub fn realize(
        system: &PoissonSystem,
        registry: &Registry,
    ) -> Result<LiftedRealization, BuildError> {
        let formulas = system.formulas(NAME)?;
        let blocks = formulas.summands();
        let d = formulas.dimension();
        if blocks.len() == 1 {
            return match quadratic(formulas)? {
                Ok((name, lift)) => Ok(LiftedRealization::new(described(&[name]), d, lift)),
                Err(reason) => Err(unfit(reason)),
            };
        }
        let mut names = Vec::new();
        let mut summands = Vec::new();
        for places in blocks {
            let summand = formulas.summand(&places)?;
            let (name, lift) = lift_of(&summand, registry)?;
            names.push(name);
            summands.push(Summand { places, lift });
        }
        let lift = LiftSum::of(summands);
        Ok(LiftedRealization::new(described(&names), d, lift))
    }

    /// The coordinates of a representation of a system's tensor.
    ///
    /// # Errors
    /// Those of [`representation::algebra`], and [`BuildError::DoesNotFit`] for a tensor that is not linear.
    pub fn represent(
        system: &PoissonSystem,
        given: &Matrices,
    ) -> Result<LiftedRealization, BuildError> {
        let formulas = system.formulas(NAME)?;
        let tensor = LinearTensor::of(formulas)?.map_err(unfit)?;
        let (algebra, order) = representation::algebra(given, formulas, &tensor)?;
        let lift = QuadraticLift::new(&algebra, &tensor, &order);
        let name = described(&[algebra.name.to_owned()]);
        Ok(LiftedRealization::new(name, formulas.dimension(), lift))
    }
}

fn unfit(reason: String) -> BuildError {
    BuildError::DoesNotFit { part: NAME, reason }
}

/// The lift of a summand, by its algebra, as it is where it is constant, or by another part.
fn lift_of(
    summand: &PoissonSystem,
    registry: &Registry,
) -> Result<(String, Arc<dyn Lift>), BuildError> {
    let formulas = summand.formulas(NAME)?;
    let reason = match quadratic(formulas)? {
        Ok((name, lift)) => return Ok((name, Arc::new(lift))),
        Err(reason) => reason,
    };
    if let Some(lift) = ConstantLift::of(formulas)? {
        return Ok(("constants".to_owned(), Arc::new(lift)));
    }
    let other = registry.lift(summand, NAME);
    let lift = other.and_then(|other| Some((other.describe(), other.abilities().lift?)));
    lift.ok_or_else(|| {
        let names = formulas.variables().join(", ");
        unfit(format!(
            "its summand of {names} has no coordinates with a constant tensor: {reason}"
        ))
    })
}

/// The lift of an algebra that the tensor is of; why it is of none, in words.
fn quadratic(
    system: &SystemFormulas,
) -> Result<Result<(String, QuadraticLift), String>, BuildError> {
    let tensor = match LinearTensor::of(system)? {
        Ok(tensor) => tensor,
        Err(reason) => return Ok(Err(reason)),
    };
    let d = system.dimension();
    let mut fitting = known()
        .iter()
        .filter(|known| known.algebra.forms.count() == d);
    let found = fitting.find_map(|known| {
        let order = relabelling(&tensor.constants, known.constants())?;
        let lift = QuadraticLift::new(&known.algebra, &tensor, &order);
        Some((known.algebra.name.to_owned(), lift))
    });
    Ok(found.ok_or_else(|| {
        format!(
            "its brackets of {} variables match none of so(3), e(3), so(4), sp(2) to sp(8); give matrices of its algebra as \
             `representation`",
            system.dimension()
        )
    }))
}

/// The part's name, with the algebras where there are others than so(3) alone.
fn described(names: &[String]) -> String {
    if names == ["so(3)"] {
        return NAME.to_owned();
    }
    let mut counted: Vec<(&str, usize)> = Vec::new();
    for name in names {
        match counted.iter_mut().find(|(known, _)| known == name) {
            Some((_, count)) => *count += 1,
            None => counted.push((name, 1)),
        }
    }
    let words = counted.into_iter().map(|(name, count)| match count {
        1 => name.to_owned(),
        count => format!("{count} {name}"),
    });
    let words: Vec<String> = words.collect();
    format!("{NAME} of {}", words.join(" and "))
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    let text = |name: &str| -> Result<String, BuildError> {
        match parameters.setting(&INFO, name)? {
            ParameterSetting::Text(text) => Ok(text),
            other => Err(BuildError::Parameter {
                part: NAME,
                parameter: name.to_owned(),
                value: other.to_string(),
                expected: "it is written as matrices, [[0, 1], [-1, 0]]".to_owned(),
            }),
        }
    };
    let given = Matrices {
        representation: text("representation")?,
        symplectic_form: text("symplectic-form")?,
        copies: copies(parameters)?,
    };
    if !given.representation.trim().is_empty() {
        return Ok(Arc::new(Clebsch::represent(system, &given)?));
    }
    if given.copies != 0 || !given.symplectic_form.is_empty() {
        return Err(BuildError::NotMade {
            part: NAME,
            reason:
                "`copies` and `symplectic-form` belong to a `representation`, and none is given"
                    .to_owned(),
        });
    }
    Ok(Arc::new(Clebsch::realize(
        system,
        &Registry::with_builtin(),
    )?))
}

fn copies(parameters: &PartParameters) -> Result<usize, BuildError> {
    let copies = parameters.get(&INFO, "copies")?;
    let is_allowed = (0..=MOST_COPIES).contains(&copies);
    usize::try_from(copies)
        .ok()
        .filter(|_| is_allowed)
        .ok_or_else(|| BuildError::Parameter {
            part: NAME,
            parameter: "copies".to_owned(),
            value: copies.to_string(),
            expected: format!("it is 1 to {MOST_COPIES}, or 0 for the fewest that serve"),
        })
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));

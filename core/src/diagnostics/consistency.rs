//! Consistency of a system of numbers, sampled near a state: whether its values are those of one Poisson system.
//! Three identities are looked at: p·Π(x)p = 0, Π(x)p linear in p, and ∇H the derivative of H.

use super::differences::jacobian_by_differences;
use super::numeric_identity::covector;
use super::round_off::sizes;
use super::verdict::sample_states;
use crate::error::StepError;
use crate::system::PoissonSystem;
use crate::system::numbers::{OpaqueSystem, SystemEvaluator};

/// Relative differences below this, the cube root of 2⁻⁵², are let pass: what single precision and derivatives by differences leave.
const LET_PASS: f64 = 6.1e-6;

/// The largest dimension in which a false gradient is traced to a coordinate.
const TRACED: usize = 64;

/// Differences that disagree are taken again in steps so much smaller.
const CLOSER: f64 = 1.0 / 1024.0;

/// Coordinates that a message shows.
const SHOWN: usize = 8;

/// Why values are those of no Poisson system.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Inconsistency {
    /// p·Π(x)p ≠ 0.
    Symmetric {
        /// |Σ terms| / Σ |terms|.
        residual: f64,
        /// x.
        at: Vec<f64>,
    },
    /// Π(x)(p + q) ≠ Π(x)p + Π(x)q.
    Nonlinear {
        /// The largest difference over the largest term.
        residual: f64,
        /// x.
        at: Vec<f64>,
    },
    /// ∇H is not the derivative of H.
    Gradient {
        /// By which coordinate, counted from 0; none in many dimensions, where it is looked at along one direction.
        coordinate: Option<usize>,
        /// Derivative of H as the system's `gradient` gives it, by the coordinate or along the direction.
        given: f64,
        /// The same derivative by differences of H.
        found: f64,
        /// x.
        at: Vec<f64>,
    },
}

impl Inconsistency {
    /// Tells what is wrong and at which x, with the coordinates' names.
    pub fn told(&self, variables: &[String]) -> String {
        let (what, at) = match self {
            Self::Symmetric { residual, at } => (
                format!(
                    "`tensor` is not antisymmetric: p·Π(x)p is {residual:.2e} of its terms' size, not 0"
                ),
                at,
            ),
            Self::Nonlinear { residual, at } => (
                format!(
                    "`tensor` is not linear in p: Π(x)(p + q) differs from Π(x)p + Π(x)q by {residual:.2e} of their size"
                ),
                at,
            ),
            Self::Gradient {
                coordinate,
                given,
                found,
                at,
            } => {
                let by = match coordinate {
                    Some(i) => format!("by {}", variables[*i]),
                    None => "along a direction in which all coordinates change".to_owned(),
                };
                (
                    format!(
                        "`gradient` is not that of `hamiltonian`: {by} it is {given:.6}, and differences of `hamiltonian` give \
                         {found:.6}"
                    ),
                    at,
                )
            }
        };
        let place = variables.iter().zip(at).take(SHOWN);
        let place: Vec<String> = place.map(|(name, x)| format!("{name} = {x:?}")).collect();
        format!("{what}, at {}", place.join(", "))
    }

    /// Advice to the user: which function of the system to correct, and how.
    pub fn advice(&self) -> &'static str {
        match self {
            Self::Gradient { .. } => {
                "correct one of the two: `gradient` is the list of the derivatives of `hamiltonian` by each coordinate"
            }
            _ => {
                "correct `tensor`: it is Σ_j Π_ij(x) p_j with Π_ij = {x_i, x_j} = −Π_ji, an antisymmetric matrix at x times p"
            }
        }
    }
}

/// The first inconsistency of a system of numbers near a state; none of a system of formulas, and of numbers that are
/// [derived](crate::system::numbers::SystemNumbers::with_derived_gradient) from them. States at which a value is refused or not
/// finite are left out.
pub fn find_inconsistency(
    system: &PoissonSystem,
    parameters: &[f64],
    near: &[f64],
) -> Option<Inconsistency> {
    let system: &OpaqueSystem = system.opaque()?;
    if system.numbers.has_derived_gradient() {
        return None;
    }
    let mut evaluator = system.numbers.evaluator_on_trial(parameters);
    let evaluator = evaluator.as_mut();
    sample_states(near)
        .iter()
        .enumerate()
        .find_map(|(sample, state)| {
            let [p, q] = [0, 1].map(|which| covector(&sizes(state), 2 * sample + which));
            of_tensor(evaluator, state, &p, &q)
                .ok()
                .flatten()
                .or_else(|| of_gradient(evaluator, state, &p).ok().flatten())
        })
}

fn of_tensor(
    evaluator: &mut dyn SystemEvaluator,
    state: &[f64],
    p: &[f64],
    q: &[f64],
) -> Result<Option<Inconsistency>, StepError> {
    let mut image = |v: &[f64]| {
        let mut image = vec![0.0; state.len()];
        evaluator.tensor(state, v, &mut image).map(|()| image)
    };
    let both: Vec<f64> = p.iter().zip(q).map(|(p, q)| p + q).collect();
    let (of_p, of_q, of_both) = (image(p)?, image(q)?, image(&both)?);
    // Each row in units of its coordinate.
    let sizes = sizes(state);
    let (mut difference, mut size) = (0.0_f64, 0.0_f64);
    for (i, unit) in sizes.iter().enumerate() {
        let sum = of_p[i] + of_q[i];
        let terms = of_p[i].abs() + of_q[i].abs() + of_both[i].abs();
        difference = difference.max((of_both[i] - sum).abs() / unit);
        size = size.max(terms / unit);
    }
    let at = state.to_vec();
    if size.is_finite() && difference > LET_PASS * size {
        let residual = difference / size;
        return Ok(Some(Inconsistency::Nonlinear { residual, at }));
    }
    let terms = p.iter().zip(&of_p).map(|(p, row)| p * row);
    let (sum, size) = terms.fold((0.0, 0.0), |(sum, size), term: f64| {
        (sum + term, size + term.abs())
    });
    let residual = sum.abs() / size;
    Ok((residual > LET_PASS).then_some(Inconsistency::Symmetric { residual, at }))
}

fn of_gradient(
    evaluator: &mut dyn SystemEvaluator,
    state: &[f64],
    covector: &[f64],
) -> Result<Option<Inconsistency>, StepError> {
    let d = state.len();
    let mut gradient = vec![0.0; d];
    evaluator.gradient(state, &mut gradient)?;
    let sizes = sizes(state);
    // A direction in which every coordinate moves by about its own size.
    let along: Vec<f64> = (covector.iter().zip(&sizes))
        .map(|(covector, size)| covector * size * size)
        .collect();
    let is_other = |given: f64, size: f64, (found, error): (f64, f64)| {
        let size = size + found.abs();
        size.is_finite() && (given - found).abs() > f64::max(LET_PASS * size, 4.0 * error)
    };
    // By s at 0, H at state + s·direction, where it differs from a given slope.
    let mut differs = |given: f64, size: f64, direction: &[f64]| {
        let mut point = vec![0.0; d];
        let mut last = None;
        // In wide steps there may be a pole or a kink.
        for reach in [1.0, CLOSER] {
            let found = jacobian_by_differences(&[0.0], 1, |at, out| {
                for (i, place) in point.iter_mut().enumerate() {
                    *place = state[i] + at[0] * reach * direction[i];
                }
                evaluator.hamiltonian(&point, out)
            })?;
            let slope = (found.jacobian[0] / reach, found.error[0] / reach);
            if !is_other(given, size, slope) {
                return Ok::<_, StepError>(None);
            }
            last = Some(slope.0);
        }
        Ok(last)
    };
    let at = state.to_vec();
    let terms = gradient.iter().zip(&along).map(|(g, u)| g * u);
    let (given, size) = terms.fold((0.0, 0.0), |(sum, size), term| {
        (sum + term, size + term.abs())
    });
    let Some(found) = differs(given, size, &along)? else {
        return Ok(None);
    };
    for (i, given) in gradient.iter().enumerate().take(TRACED) {
        let mut unit = vec![0.0; d];
        unit[i] = sizes[i];
        let slope = *given * sizes[i];
        if let Some(found) = differs(slope, slope.abs(), &unit)? {
            let (coordinate, given, found) = (Some(i), *given, found / sizes[i]);
            return Ok(Some(Inconsistency::Gradient {
                coordinate,
                given,
                found,
                at,
            }));
        }
    }
    Ok(Some(Inconsistency::Gradient {
        coordinate: None,
        given,
        found,
        at,
    }))
}

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

/// The first inconsistency of a system of numbers near a state; none of a system of formulas. States at which a value is refused or not
/// finite are left out.
pub fn find_inconsistency(
    system: &PoissonSystem,
    parameters: &[f64],
    near: &[f64],
) -> Option<Inconsistency> {
    let system: &OpaqueSystem = system.opaque()?;
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
    // H at state + s·direction by s.
    let mut slope = |direction: &[f64]| {
        let mut point = vec![0.0; d];
        let found = jacobian_by_differences(&[0.0], 1, |at, out| {
            for (i, place) in point.iter_mut().enumerate() {
                *place = state[i] + at[0] * direction[i];
            }
            evaluator.hamiltonian(&point, out)
        })?;
        Ok::<_, StepError>((found.jacobian[0], found.error[0]))
    };
    let differs = |given: f64, size: f64, (found, error): (f64, f64)| {
        let size = size + found.abs();
        size.is_finite() && (given - found).abs() > f64::max(LET_PASS * size, 4.0 * error)
    };
    let at = state.to_vec();
    let terms = gradient.iter().zip(&along).map(|(g, u)| g * u);
    let (given, size) = terms.fold((0.0, 0.0), |(sum, size), term| {
        (sum + term, size + term.abs())
    });
    let found = slope(&along)?;
    if !differs(given, size, found) {
        return Ok(None);
    }
    for (i, given) in gradient.iter().enumerate().take(TRACED) {
        let mut unit = vec![0.0; d];
        unit[i] = sizes[i];
        let (found, error) = slope(&unit)?;
        let (found, error) = (found / sizes[i], error / sizes[i]);
        if differs(*given, given.abs(), (found, error)) {
            let (coordinate, given) = (Some(i), *given);
            return Ok(Some(Inconsistency::Gradient {
                coordinate,
                given,
                found,
                at,
            }));
        }
    }
    let found = found.0;
    Ok(Some(Inconsistency::Gradient {
        coordinate: None,
        given,
        found,
        at,
    }))
}

//! Equilibria on leaves, Π∇H = 0 with Casimirs held, and their stability by the energy and by the linearized motion.
//!
//! With B an orthonormal basis of the leaf's directions, the image of Π, the linearized motion in the leaf is A = BᵀDf B = P S.
//! P = BᵀΠB is invertible there, and S is the second variation of H − Σ λ_c C_c. Hence S = P⁻¹A, whatever Casimirs are known.
//! S definite keeps neighbours in the leaf near for all times: the energy–Casimir method (V. Arnold 1966; D. Holm, J. Marsden,
//! T. Ratiu, A. Weinstein, Phys. Rep. 123 (1985)).

use std::borrow::Cow;
use std::cell::RefCell;

use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::{BuildError, Evaluator, StepError};
use leafwise_scene::compose::ComposedRun;
use thiserror::Error;

use super::equations::largest;
use super::linear::{Columns, Complex, SingularValues, dot, eigenvalues};
use super::newton::{At, corrected, length};
use super::{NEAR, PART, size_of};

/// Singular values of the tensor that are no zeros, over the largest.
const RANK: f64 = 1e-9;

/// The motion at rest, at most, over the linearized motion of a distance of the state's size.
const RESTS: f64 = 1e-12;

/// Curvatures that are no zeros, over the largest.
const CURVED: f64 = 1e-9;

/// A real part above this, over the largest size of an eigenvalue, is that of an unstable motion. Two eigenvalues that meet on the
/// axis are known to the root of the round-off.
const GROWS: f64 = 1e-7;

/// Eigenvalues of several zeros are known to higher roots of it.
const ZERO: f64 = 1e-3;

/// The verdict on an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Its leaf is a point.
    Alone,
    /// The energy is a strict minimum or maximum in the leaf: neighbours stay near for all times.
    Stable,
    /// No neighbour parts exponentially; the energy is no strict extremum, and does not decide.
    SpectrallyStable,
    /// Neighbours part exponentially.
    Unstable,
    /// Zeros among the eigenvalues hide whether others are none.
    Undecided,
}

/// An equilibrium.
#[derive(Clone, Debug)]
pub struct Rest {
    /// The state.
    pub state: Vec<f64>,
    /// H.
    pub energy: f64,
    /// Casimirs, as they are at the state to begin with.
    pub casimirs: Vec<f64>,
    /// λ with ∇H = Σ λ_c ∇C_c; `None` where ∇H is no such sum: the Casimirs that are declared are not all, or the leaf is singular.
    pub multiples: Option<Vec<f64>>,
    /// max |ẋ_i|.
    pub speed: f64,
    /// Newton steps that were made.
    pub iterations: usize,
    /// The leaf's dimension.
    pub leaf: usize,
    /// Eigenvalues of the linearized motion in the leaf, the largest first.
    pub eigenvalues: Vec<Complex>,
    /// Eigenvalues of the second variation in an orthonormal basis of the leaf's directions, in order.
    pub curvatures: Vec<f64>,
    /// The verdict.
    pub verdict: Verdict,
}

/// Why no equilibrium is found.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RestError {
    /// A scene that has none.
    #[error("{message}")]
    NotOffered {
        /// Reason.
        message: &'static str,
        /// A remedy.
        help: Cow<'static, str>,
    },
    /// Functions without code or derivatives.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// They have no value.
    #[error("the motion has no value near {state:?}: {source}")]
    NoValue {
        /// Where.
        state: Vec<f64>,
        /// Why.
        source: StepError,
    },
    /// Newton's method ends elsewhere.
    #[error(
        "no equilibrium near here: after {iterations} corrections the state moves at {speed:.1e} a unit of time"
    )]
    Moves {
        /// Corrections made.
        iterations: usize,
        /// max |ẋ_i|.
        speed: f64,
    },
    /// A Casimir is another one.
    #[error(
        "no equilibrium near here in the leaf: at the one that is found Casimir {name} is {off:.1e} away"
    )]
    NotHeld {
        /// The invariant.
        name: String,
        /// How far its value is from the one that was to be held, relative.
        off: f64,
    },
    /// Eigenvalues do not converge.
    #[error("the eigenvalues of the linearized motion do not converge")]
    NoEigenvalues,
}

/// Values and derivatives of a map.
struct Differentiable {
    map: SmoothMap,
    evaluator: RefCell<SmoothMapEvaluator>,
}

impl Differentiable {
    fn of(map: SmoothMap, parameters: &[f64]) -> Self {
        let evaluator = RefCell::new(map.evaluator(parameters, 1.0, 1.0));
        Self { map, evaluator }
    }

    fn values(&self, z: &[f64]) -> Result<Vec<f64>, RestError> {
        let mut out = vec![0.0; self.map.outputs()];
        let done = self.evaluator.borrow_mut().values(z, &mut out);
        done.map_err(|source| no_value(z, source))?;
        Ok(out)
    }

    /// Rows of the derivatives.
    fn rows(&self, z: &[f64]) -> Result<Vec<Vec<f64>>, RestError> {
        let mut out = vec![0.0; self.map.outputs() * z.len()];
        let done = self.evaluator.borrow_mut().jacobians(z, &mut out);
        done.map_err(|source| no_value(z, source))?;
        Ok(out.chunks_exact(z.len()).map(<[f64]>::to_vec).collect())
    }
}

fn no_value(z: &[f64], source: StepError) -> RestError {
    RestError::NoValue {
        state: z.to_vec(),
        source,
    }
}

/// Finds an equilibrium near a run's initial state, in its leaf.
///
/// # Errors
/// [`RestError`].
pub fn rest(run: &ComposedRun) -> Result<Rest, RestError> {
    refuse(run)?;
    let system = &run.system;
    let parameters = system.parameter_values();
    let field = Differentiable::of(system.field_map()?, &parameters);
    let tensor = Differentiable::of(system.tensor_map()?, &parameters);
    let invariants = Differentiable::of(system.invariants_map()?, &parameters);
    let initial = &run.plan.initial;
    let (d, held) = (initial.len(), invariants.values(initial)?);
    let found = corrected(
        initial.clone(),
        (PART, NEAR * size_of(initial)),
        |x| {
            let (now, gradients) = (invariants.values(x)?, invariants.rows(x)?);
            let mut right: Vec<f64> = field.values(x)?.iter().map(|f| -f).collect();
            let mut rows = field.rows(x)?;
            for ((row, now), held) in gradients.into_iter().zip(now).zip(&held).skip(1) {
                let size = length(&row);
                let inverse = if size > 0.0 { 1.0 / size } else { 0.0 };
                rows.push(row.iter().map(|entry| entry * inverse).collect());
                right.push((held - now) * inverse);
            }
            Ok(At { found: rows, right })
        },
        |_, at| Ok(transposed(&at.found, d)),
        |_, _| Ok::<(), RestError>(()),
    )?;
    let state = found.unknowns;
    let speed = largest(&found.at.right[..d]);
    let rows = &found.at.found[..d];
    let rate = SingularValues::of(&transposed(rows, d)).values[0];
    let most = RESTS * (rate * size_of(&state)).max(f64::MIN_POSITIVE);
    if speed.is_nan() || speed > most {
        return Err(RestError::Moves {
            iterations: found.corrections,
            speed,
        });
    }
    let now = invariants.values(&state)?;
    for ((name, now), held) in system.casimir_names().iter().zip(&now[1..]).zip(&held[1..]) {
        let off = (now - held).abs() / held.abs().max(1.0);
        if off > super::CLOSED {
            let name = (*name).to_owned();
            return Err(RestError::NotHeld { name, off });
        }
    }
    let first = tensor_columns(&tensor, initial)?;
    let own = tensor_columns(&tensor, &state)?;
    let parts = SingularValues::of(&own);
    let least = RANK * parts.values[0].max(SingularValues::of(&first).values[0]);
    let leaf = parts.values.iter().filter(|value| **value > least).count();
    let basis = &parts.left[..leaf];
    let within = |matrix: &Columns| -> Columns {
        let moved = basis.iter().map(|v| applied(matrix, v));
        moved
            .map(|moved| basis.iter().map(|w| dot(w, &moved)).collect())
            .collect()
    };
    let motion = within(&transposed(rows, d));
    let inverse = SingularValues::of(&within(&own));
    let curvature: Columns = motion
        .iter()
        .map(|column| inverse.solve(column, 0.0))
        .collect();
    let symmetric: Columns = (0..leaf)
        .map(|j| {
            (0..leaf)
                .map(|i| 0.5 * (curvature[j][i] + curvature[i][j]))
                .collect()
        })
        .collect();
    let eigenvalues_of = |matrix: &Columns| eigenvalues(matrix).ok_or(RestError::NoEigenvalues);
    let mut curvatures: Vec<f64> = eigenvalues_of(&symmetric)?.iter().map(|of| of.re).collect();
    curvatures.sort_by(f64::total_cmp);
    let eigenvalues = eigenvalues_of(&motion)?;
    let verdict = verdict(&motion, &eigenvalues, &curvatures);
    let gradients = invariants.rows(&state)?;
    Ok(Rest {
        multiples: multiples(&gradients[0], &gradients[1..]),
        energy: now[0],
        casimirs: now[1..].to_vec(),
        speed,
        iterations: found.corrections,
        leaf,
        eigenvalues,
        curvatures,
        verdict,
        state,
    })
}

fn verdict(motion: &Columns, eigenvalues: &[Complex], curvatures: &[f64]) -> Verdict {
    let (Some(least), Some(most)) = (curvatures.first(), curvatures.last()) else {
        return Verdict::Alone;
    };
    let flat = CURVED * largest(curvatures);
    if *least > flat || *most < -flat {
        return Verdict::Stable;
    }
    let scale = SingularValues::of(motion).values;
    let size = scale[0];
    let is_singular = scale.last().is_some_and(|least| *least <= CURVED * size);
    let mut grows = eigenvalues.iter().filter(|of| of.re > GROWS * size);
    match grows.next() {
        None => Verdict::SpectrallyStable,
        Some(first) if is_singular && first.modulus() <= ZERO * size => Verdict::Undecided,
        Some(_) => Verdict::Unstable,
    }
}

/// λ with ∇H = Σ λ_c ∇C_c.
fn multiples(gradient: &[f64], casimirs: &[Vec<f64>]) -> Option<Vec<f64>> {
    let solved = SingularValues::of(&casimirs.to_vec()).solve(gradient, PART);
    let mut left = gradient.to_vec();
    for (multiple, casimir) in solved.iter().zip(casimirs) {
        left.iter_mut()
            .zip(casimir)
            .for_each(|(l, c)| *l -= multiple * c);
    }
    (length(&left) <= super::CLOSED * length(gradient).max(1.0)).then_some(solved)
}

/// Columns of −Π, with which the motion is −Π∇H.
fn tensor_columns(tensor: &Differentiable, x: &[f64]) -> Result<Columns, RestError> {
    let d = x.len();
    let column = |j: usize| {
        let mut both = [x, &vec![0.0; d]].concat();
        both[d + j] = 1.0;
        tensor.values(&both)
    };
    (0..d).map(column).collect()
}

fn transposed(rows: &[Vec<f64>], columns: usize) -> Columns {
    (0..columns)
        .map(|j| rows.iter().map(|row| row[j]).collect())
        .collect()
}

fn applied(matrix: &Columns, v: &[f64]) -> Vec<f64> {
    let mut moved = vec![0.0; matrix.first().map_or(0, Vec::len)];
    for (part, column) in v.iter().zip(matrix) {
        moved
            .iter_mut()
            .zip(column)
            .for_each(|(m, c)| *m += part * c);
    }
    moved
}

fn refuse(run: &ComposedRun) -> Result<(), RestError> {
    if run.system.has_forces() {
        return Err(RestError::NotOffered {
            message: "with forces or friction the energy is not kept, by which equilibria are judged",
            help: run.without_forces().into(),
        });
    }
    let (message, help) = if run.method.lattice().is_some() {
        (
            "equilibria of long lattices are not looked for",
            "shorten the lattice",
        )
    } else if run.method.noise().is_some() {
        ("a motion with noise does not rest", "take the noise out")
    } else if run.is_extended() {
        (
            "equilibria of systems whose H names the time, with a pace, parameters of sites or a contact bracket are not looked for",
            "look for those of a system without them",
        )
    } else {
        return Ok(());
    };
    Err(RestError::NotOffered {
        message,
        help: help.into(),
    })
}

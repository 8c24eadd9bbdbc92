//! Equilibria on leaves, Π∇H = 0 with Casimirs held, and their stability by the energy and by the linearized motion.
//!
//! With B an orthonormal basis of the leaf's directions, the image of Π, the linearized motion in the leaf is A = BᵀDf B = P S.
//! P = BᵀΠB is invertible there, and S is the second variation of H − Σ λ_c C_c. Hence S = P⁻¹A, whatever Casimirs are known.
//! They are found and judged in [units](super::units) of the motion, and do not depend on the scene's.
//! S definite keeps neighbours in the leaf near for all times: the energy–Casimir method (V. Arnold 1966; D. Holm, J. Marsden,
//! T. Ratiu, A. Weinstein, Phys. Rep. 123 (1985)).

use std::borrow::Cow;
use std::cell::RefCell;

use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::{BuildError, Evaluator, StepError};
use leafwise_scene::compose::ComposedRun;
use thiserror::Error;

use super::equations::largest;
use super::leaf::{Leaf, Linear, NoEigenvalues, Verdict};
use super::linear::{Columns, Complex, SingularValues};
use super::newton::{At, corrected, length};
use super::units::Units;
use super::{NEAR, PART};

/// The motion at rest, at most, over the linearized motion of a distance of the state's size, in units.
const RESTS: f64 = 1e-12;

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
    /// RestFunctions without code or derivatives.
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
    /// Newton's method ends on a leaf of another dimension.
    #[error(
        "no equilibrium near here in the leaf: the one that is found lies on a leaf of dimension {found}, the initial state on one of \
         dimension {leaf}"
    )]
    OtherLeaf {
        /// The dimension of the leaf of the state to begin with.
        leaf: usize,
        /// That of the equilibrium's.
        found: usize,
    },
    /// Eigenvalues do not converge.
    #[error(transparent)]
    NoEigenvalues(#[from] NoEigenvalues),
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

/// The motion, its tensor and what it holds.
struct RestFunctions {
    field: Differentiable,
    tensor: Differentiable,
    /// Energy and Casimirs.
    invariants: Differentiable,
}

impl RestFunctions {
    fn of(run: &ComposedRun) -> Result<Self, RestError> {
        let system = &run.system;
        let parameters = system.parameter_values();
        Ok(Self {
            field: Differentiable::of(system.field_map()?, &parameters),
            tensor: Differentiable::of(system.tensor_map()?, &parameters),
            invariants: Differentiable::of(system.invariants_map()?, &parameters),
        })
    }

    fn linear(&self, x: &[f64]) -> Result<Linear, RestError> {
        let d = x.len();
        let column = |j: usize| {
            let mut both = [x, &vec![0.0; d]].concat();
            both[d + j] = 1.0;
            self.tensor.values(&both)
        };
        let tensor = (0..d).map(column).collect::<Result<Columns, RestError>>()?;
        let motion = transposed(&self.field.rows(x)?, d);
        Ok(Linear { tensor, motion })
    }
}

/// The larger entries of two matrices.
fn larger_of(a: &Columns, b: &Columns) -> Columns {
    let columns = a.iter().zip(b).map(|(a, b)| {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| a.abs().max(b.abs())).collect()
    });
    columns.collect()
}

/// Finds an equilibrium near a run's initial state, in its leaf.
///
/// # Errors
/// [`RestError`].
pub fn rest(run: &ComposedRun) -> Result<Rest, RestError> {
    refuse(run)?;
    let functions = RestFunctions::of(run)?;
    let (initial, d) = (&run.plan.initial, run.plan.initial.len());
    let (held, first) = (
        functions.invariants.values(initial)?,
        functions.linear(initial)?,
    );
    let sizes = |x: &[f64]| -> Vec<f64> {
        let pairs = x.iter().zip(initial);
        pairs.map(|(x, first)| x.abs().max(first.abs())).collect()
    };
    let units = Units::of(&first.tensor, &first.motion, &sizes(initial));
    let found = corrected(
        units.inside(initial),
        (PART, NEAR * extent(&units.inside(initial))),
        |x| {
            let x = units.outside(x);
            let (now, gradients) = (
                functions.invariants.values(&x)?,
                functions.invariants.rows(&x)?,
            );
            let velocity = units.velocity(&functions.field.values(&x)?);
            let mut right: Vec<f64> = velocity.iter().map(|f| -f).collect();
            let mut columns = units.motion(&transposed(&functions.field.rows(&x)?, d));
            for ((gradient, now), held) in gradients.iter().zip(now).zip(&held).skip(1) {
                let row = units.gradient(gradient);
                let size = length(&row);
                let inverse = if size > 0.0 { 1.0 / size } else { 0.0 };
                let entries = columns.iter_mut().zip(row);
                entries.for_each(|(column, entry)| column.push(entry * inverse));
                right.push((held - now) * inverse);
            }
            Ok(At {
                found: columns,
                right,
            })
        },
        |_, at| Ok(at.found.clone()),
        |_, _| Ok::<(), RestError>(()),
    )?;
    let state = units.outside(&found.unknowns);
    let linear = functions.linear(&state)?;
    let sizes = sizes(&state);
    // What is small at the state but was not nearby is no unit.
    let units = Units::of(
        &larger_of(&linear.tensor, &first.tensor),
        &larger_of(&linear.motion, &first.motion),
        &sizes,
    );
    let velocity = functions.field.values(&state)?;
    let speed = largest(&velocity);
    let extent = extent(&units.inside(&sizes));
    let rate = SingularValues::of(&units.motion(&linear.motion)).values[0];
    let moves = largest(&units.velocity(&velocity));
    if moves.is_nan() || moves > RESTS * rate * extent {
        return Err(RestError::Moves {
            iterations: found.corrections,
            speed,
        });
    }
    let (now, gradients) = (
        functions.invariants.values(&state)?,
        functions.invariants.rows(&state)?,
    );
    let names = run.system.casimir_names();
    for (at, name) in names.iter().enumerate().map(|(at, name)| (at + 1, name)) {
        let size = held[at].abs().max(products(&gradients[at], &sizes));
        let off = (now[at] - held[at]).abs();
        if off > super::CLOSED * size {
            return Err(RestError::NotHeld {
                name: (*name).to_owned(),
                off: off / size,
            });
        }
    }
    let leaf = Leaf::of(&units, &linear, &first)?;
    if leaf.basis.len() != leaf.dimension_at_first {
        return Err(RestError::OtherLeaf {
            leaf: leaf.dimension_at_first,
            found: leaf.basis.len(),
        });
    }
    let gradients: Columns = gradients.iter().map(|g| units.gradient(g)).collect();
    // A curvature in units is over the unit of the energy, a gradient is not.
    let least = leaf.steepness() * units.action / units.time;
    // Units of coordinates across the leaf are in no entry of the motion: sizes of the state count there.
    let inside = units.inside(&sizes);
    let across = |gradient: &[f64]| across(gradient, &leaf.basis, &inside);
    Ok(Rest {
        multiples: multiples(&gradients[0], &gradients[1..], across, least),
        energy: now[0],
        casimirs: now[1..].to_vec(),
        speed,
        iterations: found.corrections,
        leaf: leaf.basis.len(),
        eigenvalues: (leaf.eigenvalues.iter())
            .map(|of| of.over(units.time))
            .collect(),
        curvatures: leaf.curvatures_outside(&units)?,
        verdict: leaf.verdict(),
        state,
    })
}

/// The largest size of a coordinate in units; 1 where all are 0, which have none.
fn extent(x: &[f64]) -> f64 {
    let most = largest(x);
    if most > 0.0 { most } else { 1.0 }
}

/// Σ |a_i| b_i.
fn products(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.abs() * b).sum()
}

/// λ with ∇H = Σ λ_c ∇C_c, up to what is far below `least` in the size of a gradient across the leaf: along it none is left.
fn multiples(
    gradient: &[f64],
    casimirs: &[Vec<f64>],
    across: impl Fn(&[f64]) -> f64,
    least: f64,
) -> Option<Vec<f64>> {
    let solved = SingularValues::of(&casimirs.to_vec()).solve(gradient, PART);
    let mut left = gradient.to_vec();
    for (multiple, casimir) in solved.iter().zip(casimirs) {
        left.iter_mut()
            .zip(casimir)
            .for_each(|(l, c)| *l -= multiple * c);
    }
    (across(&left) <= super::CLOSED * across(gradient).max(least)).then_some(solved)
}

/// The size of a covector across the leaf, in an orthonormal basis of the leaf's directions: of coordinates larger than their units that
/// times the coordinate.
fn across(covector: &[f64], basis: &Columns, state: &[f64]) -> f64 {
    let mut rest = covector.to_vec();
    for direction in basis {
        let along: f64 = rest.iter().zip(direction).map(|(g, b)| g * b).sum();
        let pairs = rest.iter_mut().zip(direction);
        pairs.for_each(|(g, b)| *g -= along * b);
    }
    let weighed = rest.iter().zip(state).map(|(g, x)| g * x.abs().max(1.0));
    length(&weighed.collect::<Vec<f64>>())
}

fn transposed(rows: &[Vec<f64>], columns: usize) -> Columns {
    (0..columns)
        .map(|j| rows.iter().map(|row| row[j]).collect())
        .collect()
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
            "the search for equilibria does not support long lattices",
            "shorten the lattice",
        )
    } else if run.method.noise().is_some() {
        ("a motion with noise does not rest", "remove the noise")
    } else if run.is_extended() {
        (
            "the search for equilibria does not support an H that names the time, a pace, parameters of sites or a contact bracket",
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

//! Changes of the state where a run crosses its section, and whether the motion with them is a Poisson map.

use std::collections::BTreeMap;

use leafwise_core::PoissonSystem;
use leafwise_expression::syntax::Scope;
use leafwise_expression::{Expression, Quantity};
use leafwise_walk::{Act, Section};
use nalgebra::{DMatrix, DVector};

use super::Refusal;
use super::forces::for_each_coordinate;
use crate::document::{Located, Place, SceneDocument, SectionSpec};

/// Coordinates at most at which the tensor is looked at: matrices of their squares are multiplied.
const WIDEST: usize = 64;

/// States on the surface that are looked at.
const STATES: u32 = 12;

/// The defect, over the size of what is compared, below which the tensor is kept.
const KEPT: f64 = 1e-9;

/// Effect of events on the Poisson tensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActTensor {
    /// The motion through them is a Poisson map, at all states that were looked at.
    Kept,
    /// It is none: max |S π Sᵀ − π| over the sizes of both.
    Broken(f64),
    /// Nobody can say: the system has no formulas or too many coordinates, or no state on the surface was found.
    Unknown,
}

impl ActTensor {
    /// In words.
    pub fn text(self) -> String {
        match self {
            Self::Kept => "the motion through them is a Poisson map".to_owned(),
            Self::Broken(defect) => {
                format!(
                    "the motion through them is not a Poisson map, with a tensor defect of {defect:.1e}"
                )
            }
            Self::Unknown => {
                "whether the motion through them is a Poisson map is not known".to_owned()
            }
        }
    }
}

/// Reads the `set` of a section.
pub(super) fn act(
    document: &SceneDocument,
    scope: &Scope,
    section: &SectionSpec,
) -> Result<Option<Act>, Refusal> {
    let Some(entries) = &section.set else {
        return Ok(None);
    };
    let coordinates = document.system.coordinates();
    let refuse = |place: &Place, message: &str, help: &str| -> Refusal {
        Box::new(document.diagnostic(place, message, "here", Some(help.to_owned())))
    };
    if entries.value.is_empty() {
        let help = "name a coordinate, as set = { p = \"-p\" }";
        return Err(refuse(&entries.place(), "`set` changes nothing", help));
    }
    let mut set = BTreeMap::new();
    for_each_coordinate(document, scope, &entries.value, |key, place, formula| {
        if place >= coordinates {
            let message = "this is not a coordinate that moves";
            return Err(refuse(
                &key.place(),
                message,
                "set coordinates of the system",
            ));
        }
        set.insert(place, formula);
        Ok(())
    })?;
    let each = |(key, formula): &(Located<String>, Located<String>)| {
        format!("{} = {}", key.value.trim(), formula.value.trim())
    };
    let text: Vec<String> = entries.value.iter().map(each).collect();
    Ok(Some(Act {
        text: text.join(", "),
        set: set.into_iter().collect(),
    }))
}

/// Effect of an act on the tensor of a system's `own` first coordinates. Steps have the sign of `step`, and states are those of
/// the surface about the initial one.
///
/// Let g act on a surface σ = 0. The motion through it has the derivative Dφ S Dφ.
///
///     S = Dg + (X⁺ − Dg X⁻) ⊗ dσ / σ̇ (saltation matrix).
///
/// A Poisson map has S π Sᵀ = π∘g.
pub(super) fn tensor_of(
    system: &PoissonSystem,
    (section, act): (&Section, &Act),
    (initial, parameters): (&[f64], &[f64]),
    (own, step): (usize, f64),
) -> ActTensor {
    let dimension = initial.len();
    let formulas = system.expressions().filter(|formulas| {
        dimension <= WIDEST && formulas.forces().is_empty() && !formulas.tensor().is_empty()
    });
    let Some(formulas) = formulas else {
        return ActTensor::Unknown;
    };
    let derivative = |of: &Expression, by: usize| of.derivative(Quantity::Variable(by)).ok();
    let gradient = |of: &Expression| -> Option<Vec<Expression>> {
        (0..dimension).map(|by| derivative(of, by)).collect()
    };
    let rows = act.set.iter().map(|(_, value)| gradient(value));
    let (Some(energy), Some(normal), Some(rows)) = (
        gradient(formulas.hamiltonian()),
        gradient(&section.difference),
        rows.collect::<Option<Vec<_>>>(),
    ) else {
        return ActTensor::Unknown;
    };
    let at = |of: &[Expression], x: &[f64]| -> DVector<f64> {
        DVector::from_iterator(dimension, of.iter().map(|of| of.evaluate(x, parameters)))
    };
    let tensor = |x: &[f64]| {
        let mut matrix = DMatrix::<f64>::zeros(dimension, dimension);
        for ((i, j), entry) in formulas.tensor() {
            let value = entry.evaluate(x, parameters);
            (matrix[(*i, *j)], matrix[(*j, *i)]) = (value, -value);
        }
        matrix
    };
    let velocity = |x: &[f64]| -(tensor(x) * at(&energy, x));
    let mut worst = None;
    for state in 0..STATES {
        let scale = 0.3 * f64::from(state);
        let moved = initial.iter().zip(1_u32..);
        let start: Vec<f64> = moved
            .map(|(x, at)| x + scale * libm::sin(f64::from(at) + 1.7 * f64::from(state)))
            .collect();
        let Some(x) = on_surface(&section.difference, &start, parameters, |x| at(&normal, x))
        else {
            continue;
        };
        let rate = at(&normal, &x).dot(&velocity(&x));
        let is_counted = section.counts(rate * step);
        if rate == 0.0 || !rate.is_finite() || !is_counted {
            continue;
        }
        let mut behind = x.clone();
        let mut jump = DMatrix::<f64>::identity(dimension, dimension);
        for ((coordinate, value), row) in act.set.iter().zip(&rows) {
            behind[*coordinate] = value.evaluate(&x, parameters);
            jump.set_row(*coordinate, &at(row, &x).transpose());
        }
        let (before, after) = (velocity(&x), velocity(&behind));
        let saltation = &jump + (after - &jump * &before) * at(&normal, &x).transpose() / rate;
        // Of a driven system the tensor of its own coordinates, at one time.
        let kept = (&saltation * tensor(&x) * saltation.transpose())
            .view((0, 0), (own, own))
            .into_owned();
        let expected = tensor(&behind).view((0, 0), (own, own)).into_owned();
        let size = kept.amax().max(expected.amax()).max(f64::MIN_POSITIVE);
        let defect = (kept - expected).amax() / size;
        if defect.is_finite() {
            worst = Some(worst.map_or(defect, |worst: f64| worst.max(defect)));
        }
    }
    match worst {
        None => ActTensor::Unknown,
        Some(defect) if defect <= KEPT => ActTensor::Kept,
        Some(defect) => ActTensor::Broken(defect),
    }
}

/// A state on the surface near another one, by Newton's method along the gradient.
fn on_surface(
    difference: &Expression,
    start: &[f64],
    parameters: &[f64],
    normal: impl Fn(&[f64]) -> DVector<f64>,
) -> Option<Vec<f64>> {
    let mut x = start.to_vec();
    for _ in 0..60 {
        let value = difference.evaluate(&x, parameters);
        let gradient = normal(&x);
        let square = gradient.norm_squared();
        if !value.is_finite() || square <= 0.0 || square.is_nan() {
            return None;
        }
        let step = value / square;
        x.iter_mut()
            .zip(gradient.iter())
            .for_each(|(x, g)| *x -= step * g);
        if libm::sqrt(step * step * square) <= 1e-14 * (1.0 + DVector::from_column_slice(&x).norm())
        {
            return Some(x);
        }
    }
    None
}

//! The shape of a tensor: what its entries are as functions of the state.

use std::fmt;

use leafwise_core::PoissonSystem;
use leafwise_expression::algebra::Monomial;
use leafwise_expression::{Polynomial, Ring};

use super::run::ComposedRun;

/// The shape of a Poisson tensor, by the normal forms of its entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TensorShape {
    /// Every entry vanishes.
    Zero,
    /// Π does not depend on the state.
    Constant,
    /// Every entry is linear: a Lie–Poisson structure.
    Linear,
    /// {x_i, x_j} = a_ij x_i x_j.
    LogCanonical,
    /// Polynomial entries of at most this degree.
    Polynomial(u32),
    /// Quotients, roots or transcendental functions of the state.
    General,
    /// Known by its values alone.
    Opaque,
}

impl fmt::Display for TensorShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Zero => f.write_str("zero"),
            Self::Constant => f.write_str("constant"),
            Self::Linear => f.write_str("linear (Lie-Poisson)"),
            Self::LogCanonical => f.write_str("quadratic, log-canonical"),
            Self::Polynomial(degree) => write!(f, "polynomial of degree {degree}"),
            Self::General => f.write_str("general (not polynomial)"),
            Self::Opaque => f.write_str("not known: numbers only"),
        }
    }
}

/// Classifies the tensor of a system; `General` where the algebra has no normal form.
pub fn tensor_shape(system: &PoissonSystem) -> TensorShape {
    shape_of(system, system.dimension())
}

impl ComposedRun {
    /// The shape of the tensor of the scene's own coordinates.
    pub fn tensor_shape(&self) -> TensorShape {
        let before = self.plan.layout.clock().map(|clock| clock.time);
        shape_of(&self.system, before.unwrap_or(self.system.dimension()))
    }
}

/// The shape of the tensor's entries between the first so many coordinates.
fn shape_of(system: &PoissonSystem, coordinates: usize) -> TensorShape {
    let Some(system) = system.expressions() else {
        return TensorShape::Opaque;
    };
    let mut ring = Ring::new(system.dimension());
    let mut entries: Vec<((usize, usize), Polynomial)> = Vec::new();
    let own = system.tensor().iter();
    for (at, entry) in own.filter(|((_, j), _)| *j < coordinates) {
        let value = entry.evaluate_in(&mut ring, &mut |ring, i| Ok(ring.variable(i)));
        match value {
            Ok(value) if value.is_zero() => {}
            Ok(value) => entries.push((*at, value)),
            Err(_) => return TensorShape::General,
        }
    }
    let degrees = |monomial: &Monomial| degree(&ring, monomial);
    let all: Option<Vec<u32>> = entries
        .iter()
        .flat_map(|(_, entry)| entry.terms())
        .map(|(monomial, _)| degrees(monomial))
        .collect();
    let Some(all) = all else {
        return TensorShape::General;
    };
    let is_log_canonical = entries.iter().all(|((i, j), entry)| match entry.terms() {
        [(monomial, _)] => {
            let variable = |at: usize| ring.variable(at).terms()[0].0.clone();
            *monomial == variable(*i).multiply(&variable(*j))
        }
        _ => false,
    });
    match (all.iter().min(), all.iter().max()) {
        (None, _) | (_, None) => TensorShape::Zero,
        (_, Some(0)) => TensorShape::Constant,
        (Some(1), Some(1)) => TensorShape::Linear,
        _ if is_log_canonical => TensorShape::LogCanonical,
        (_, Some(degree)) => TensorShape::Polynomial(*degree),
    }
}

/// The degree of a monomial in the variables alone; `None` with adjoined functions or negative
/// exponents.
fn degree(ring: &Ring, monomial: &Monomial) -> Option<u32> {
    monomial
        .factors()
        .iter()
        .try_fold(0_u32, |sum, &(symbol, exponent)| {
            let exponent = u32::try_from(exponent).ok()?;
            ring.generator(symbol).is_none().then_some(sum + exponent)
        })
}

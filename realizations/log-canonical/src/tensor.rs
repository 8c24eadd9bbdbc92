//! Log-canonical tensors: {x_i, x_j} = a_ij x_i x_j.

use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{Arithmetic, Polynomial, Ring};

/// The part's name.
pub(crate) const NAME: &str = "log-canonical";

/// a_ij by (i, j) with i < j.
pub(crate) type Coefficients = Vec<((usize, usize), Polynomial)>;

/// The nonzero a_ij = {x_i, x_j}/(x_i x_j), i < j, as constants of `ring`.
pub(crate) fn coefficients(
    system: &SystemFormulas,
    ring: &mut Ring,
) -> Result<Coefficients, BuildError> {
    let mut coefficients = Vec::with_capacity(system.tensor().len());
    for (&(i, j), entry) in system.tensor() {
        let value = entry.evaluate_in(ring, &mut |ring, at| Ok(ring.variable(at)))?;
        let (first, second) = (ring.variable(i), ring.variable(j));
        let product = ring.multiply(&first, &second);
        let a = ring.divide(&value, &product)?;
        if a.as_constant().is_none() {
            let [first, second] = [i, j].map(|at| &system.variables()[at]);
            return Err(BuildError::DoesNotFit {
                part: NAME,
                reason: format!(
                    "{{{first}, {second}}} is not {first}*{second} times a function of the \
                     parameters"
                ),
            });
        }
        if !a.is_zero() {
            coefficients.push(((i, j), a));
        }
    }
    Ok(coefficients)
}

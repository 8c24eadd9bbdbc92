//! Systems, methods and vectors.

use leafwise_core::{Method, PartParameters, PoissonSystem, Registry};
use leafwise_scene::{ComposedRun, SceneDocument, compose};

use super::case::StressError;
use crate::verify::Problem;

/// u, half a unit in the last place of 1.
pub(super) const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// `karasev-truncated` of order n with `hamilton-jacobi` of order m.
pub(super) fn method(system: &PoissonSystem, n: i64, m: i64) -> Result<Method, StressError> {
    let order = |order: i64| PartParameters::new().with("order", order);
    pair(
        system,
        ("karasev-truncated", order(n)),
        ("hamilton-jacobi", order(m)),
    )
}

/// Two parts by name with their parameters.
pub(super) fn pair(
    system: &PoissonSystem,
    (realization, of_realization): (&str, PartParameters),
    (dynamics, of_dynamics): (&str, PartParameters),
) -> Result<Method, StressError> {
    let registry = Registry::with_builtin();
    let realization = registry
        .realization(realization)?
        .build(system, &of_realization)?;
    let dynamics = registry.dynamics(dynamics)?.build(&of_dynamics)?;
    Ok(Method::compose(system, realization, dynamics)?)
}

/// A scene's text, ready to run.
pub(super) fn composed(text: &str) -> Result<ComposedRun, StressError> {
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("case", text, &registry)?;
    compose(&document, &registry).map_err(StressError::Refused)
}

/// A system from the text of its `[system]` table, from `initial`.
pub(super) fn problem(system: &str, initial: &[f64]) -> Result<Problem, StressError> {
    let text = format!(
        "[system]\n{system}\n[method]\ntime-step = 0.1\n[run]\ninitial = {initial:?}\nsteps = 1\n"
    );
    let document = SceneDocument::parse("case", &text, &Registry::with_builtin())?;
    Ok(Problem::of_scene(&document)?)
}

/// The `[system]` table of so(3)* with a Hamiltonian.
pub(super) fn so3_with(hamiltonian: &str) -> String {
    format!(
        "variables = [\"x1\", \"x2\", \"x3\"]\n\
         bracket = {{ \"x1,x2\" = \"-x3\", \"x2,x3\" = \"-x1\", \"x3,x1\" = \"-x2\" }}\n\
         hamiltonian = \"{hamiltonian}\"\n\
         casimirs = {{ spin = \"x1^2 + x2^2 + x3^2\" }}\n"
    )
}

/// The largest absolute value; NaN if one is.
pub(super) fn largest(values: &[f64]) -> f64 {
    let wider = |m: f64, v: &f64| {
        if v.is_nan() || m.is_nan() {
            f64::NAN
        } else {
            m.max(v.abs())
        }
    };
    values.iter().fold(0.0, wider)
}

/// max |a_i − b_i|.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    largest(&differences)
}

/// Whether two vectors have the same bits.
pub(super) fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

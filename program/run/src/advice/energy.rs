//! An energy that is kept badly.
//!
//! Let E be the least of Σ_i |∂H/∂x_i(x)| · (max x_i − min x_i) over the states of an orbit: what H changes by
//! when the coordinates change as they do on it. It depends neither on units nor on a constant in H. The
//! energy's scale is |H(x_0)|, but not above E, which a constant would reach, and not below E/10, should
//! H(x_0) be near 0; where states are not at hand, it is |H(x_0)|. An error of the energy above
//! [`LARGEST`] of its scale is worth a warning. Forces change the energy by themselves, and nothing is said of it.

use leafwise_core::Evaluator;

use super::step::tighten;
use super::{Advice, AdviceKind, number};
use leafwise_scene::compose::ComposedRun;
use leafwise_scene::document::{SceneDocument, StepSpec};

/// The largest error of the energy, relative to its scale, that nothing is said of.
const LARGEST: f64 = 0.01;

/// Errors below this part of |H(x_0)| are not looked at.
const NEGLIGIBLE: f64 = 1e-6;

/// The part of E that the energy's scale is at least.
const LEAST_PART: f64 = 0.1;

/// States that tell how far an orbit reaches, at least.
const LEAST_STATES: usize = 8;

/// What is known of the energy along an orbit.
pub(crate) struct EnergyError<'a> {
    /// The parameters' values.
    pub parameters: &'a [f64],
    /// H(x_0).
    pub initial: f64,
    /// max |H(x_k) − H(x_0)|.
    pub largest: f64,
    /// Whose energy: nothing, or a member of an ensemble.
    pub whose: &'a str,
}

impl EnergyError<'_> {
    /// Whether states are worth a look.
    pub fn is_notable(&self) -> bool {
        self.largest > NEGLIGIBLE * self.initial.abs()
    }

    /// A warning where the error is a large part of the energy's scale along `states`.
    pub fn advice(
        &self,
        document: &SceneDocument,
        run: &ComposedRun,
        states: &[Vec<f64>],
    ) -> Option<Advice> {
        if run.system.has_forces() || run.method.noise().is_some() {
            return None;
        }
        let along = scale(run, self.parameters, states);
        let size = self.initial.abs();
        let scale = along.map_or(size, |along| size.clamp(LEAST_PART * along, along));
        if !(self.largest > LARGEST * scale && scale > 0.0) {
            return None;
        }
        let change = tighten(run).unwrap_or_else(|| match &document.method.step {
            StepSpec::TimeStep(step) => format!("time-step = {:?}", step.value.value / 2.0),
            StepSpec::Factors { h, .. } => format!("h = {:?}", h.value.value / 2.0),
        });
        Some(Advice {
            kind: AdviceKind::EnergyError,
            message: format!(
                "the energy{} is off by {}, {} % of its scale along the orbit, {}: the motion is not to be trusted",
                self.whose,
                number(self.largest),
                number(100.0 * self.largest / scale),
                number(scale)
            ),
            change,
        })
    }
}

/// The energy's scale along an orbit, `None` where there are too few states or no gradients.
fn scale(run: &ComposedRun, parameters: &[f64], states: &[Vec<f64>]) -> Option<f64> {
    let d = run.system.dimension();
    if states.len() < LEAST_STATES || states.iter().any(|x| x.len() != d) {
        return None;
    }
    let range = |i: usize| {
        let values = states.iter().map(|x| x[i]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        high - low
    };
    let ranges: Vec<f64> = (0..d).map(range).collect();
    let gradient = run.system.gradient_values().ok()?;
    let mut gradient = gradient.evaluator(parameters, 1.0, 1.0);
    let mut slopes = vec![0.0; d];
    let mut least = f64::INFINITY;
    for x in states {
        if gradient.values(x, &mut slopes).is_ok() {
            let products = slopes
                .iter()
                .zip(&ranges)
                .map(|(slope, range)| slope.abs() * range);
            least = least.min(products.sum());
        }
    }
    (least.is_finite() && least > 0.0).then_some(least)
}

//! Judgement of a map's step by the energy of its shadow.
//!
//! H̃ = H + t^m F_{m+1} + t^{m+2} F_{m+3} + … is an asymptotic series. Where it is cut at order p, the map keeps it up
//! to O(tᵖ), as long as its terms still fall from one to the next. Over a run H changes by about t^m |F_{m+1}| and H̃
//! by the size of the first term left out. There are (p − m)/2 terms in between, each smaller by t²/t_*² on the
//! average. A step is in the range of the theory where that factor is a quarter or less; the terms behind fall as well
//! then, several of them.

use leafwise_core::StepError;
use leafwise_core::solver::judge::larger;
use leafwise_core::system::SystemObservables;
use leafwise_scene::compose::{ComposedRun, RecordedShadow, ShadowEnergy};
use serde::Serialize;

use crate::error::RunError;

/// Largest ratio of one term to the term before it, for a step in the range of the theory.
const FALLING: f64 = 0.25;

/// Changes below so many roundings of H, and one more for the root of every step, say nothing: round-off of steps walks at random.
const ROUNDINGS: f64 = 256.0;

/// Changes of H and H̃ that a run has shown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Changes {
    /// max |H(x_k) − H(x_0)|.
    pub energy: f64,
    /// max |H̃(x_k) − H̃(x_0)|; not a number where one of them has no value.
    pub shadow: f64,
    /// |H(x_0)|.
    pub size: f64,
    /// k at the end.
    pub steps: u64,
}

/// How a run keeps H and H̃.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ShadowVerdict {
    /// The order m of the map.
    pub order_of_map: usize,
    /// The order p of H̃.
    pub order: usize,
    /// The order that the realization lets H̃ be kept to, where that is below p.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<usize>,
    /// max |H(x_k) − H(x_0)|.
    pub energy: f64,
    /// max |H̃(x_k) − H̃(x_0)|.
    pub shadow: f64,
    /// Whether the step is in the range of the theory.
    pub is_in_range: bool,
    /// A step that would be, with as much to spare: an eighth from one term to the next.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
}

impl ShadowVerdict {
    /// From a shadow of orders m and p, what a run has shown, and the step t.
    pub(crate) fn new(of: RecordedShadow, changes: Changes, t: f64) -> Self {
        let RecordedShadow {
            order_of_map,
            order,
            limit,
            ..
        } = of;
        let Changes {
            energy,
            shadow,
            size,
            steps,
        } = changes;
        let reached = limit.unwrap_or(order);
        let terms = reached.saturating_sub(order_of_map) as f64 / 2.0;
        // Of one term to the next.
        let factor = libm::pow(shadow / energy, 1.0 / terms);
        let roundings = ROUNDINGS + libm::sqrt(steps as f64);
        let is_rounding = shadow <= roundings * f64::EPSILON * size;
        let is_in_range = is_rounding || (terms > 0.0 && factor <= FALLING);
        let shorter = t * libm::sqrt(FALLING / (2.0 * factor));
        Self {
            order_of_map,
            order,
            limit,
            energy,
            shadow,
            is_in_range,
            step: (!is_in_range && shorter.is_finite()).then_some(shorter),
        }
    }

    /// In a sentence.
    pub fn text(&self) -> String {
        let Self {
            order,
            energy,
            shadow,
            ..
        } = self;
        if self.is_in_range {
            return format!(
                "the energy oscillates by {energy:.1e}, the shadow energy of order {order} is constant to {shadow:.1e}: the \
                 step is in the range of the theory"
            );
        }
        if let Some(limit) = self.limit
            && limit <= self.order_of_map
        {
            return format!(
                "the energy changes by {energy:.1e}, the shadow energy of order {order} by {shadow:.1e}: over this realization it is \
                 kept to order {limit} alone, no better than the energy; take a higher order of the realization, or an exact one"
            );
        }
        if shadow.is_nan() {
            return format!(
                "the shadow energy of order {order} has no value at some states: the step cannot be judged"
            );
        }
        let instead = match self.step {
            Some(step) => {
                let short: f64 = format!("{step:.1e}").parse().unwrap_or(step);
                format!("a step of about {short} would be inside it")
            }
            None => "a shorter step would be inside it".to_owned(),
        };
        format!(
            "the energy changes by {energy:.1e} and the shadow energy of order {order} by {shadow:.1e}: the step is outside \
             the range of the theory, {instead}"
        )
    }

    /// Over the first steps of a run, so many at most: with their number, and why they are fewer.
    ///
    /// # Errors
    /// [`RunError::Build`] where a formula has no code.
    pub fn measured(
        run: &ComposedRun,
        shadow: &ShadowEnergy,
        steps: u64,
    ) -> Result<(Self, u64, Option<StepError>), RunError> {
        let parameters = run.system.parameter_values();
        let mut energy = run.invariants()?;
        let mut shadow_energy = SystemObservables::new(&run.system, &[&shadow.value], &parameters)?;
        let mut invariants = vec![0.0; energy.observables()];
        let mut value = [0.0];
        let mut at = |state: &[f64]| {
            energy.evaluate(state, &mut invariants);
            shadow_energy.evaluate(state, &mut value);
            [invariants[0], value[0]]
        };
        let mut walk = run.walk();
        let first = at(walk.state());
        let mut most = [0.0_f64; 2];
        let stepped = walk.watch(steps, |walk| {
            let now = at(walk.state());
            for ((most, now), first) in most.iter_mut().zip(now).zip(first) {
                *most = larger(*most, (now - first).abs());
            }
        });
        let t = run.plan.epsilon * run.plan.h;
        let of = RecordedShadow {
            at: 0,
            order_of_map: shadow.order_of_map,
            order: shadow.order,
            limit: shadow.limit,
        };
        let changes = Changes {
            energy: most[0],
            shadow: most[1],
            size: first[0].abs(),
            steps: walk.steps(),
        };
        let verdict = Self::new(of, changes, t);
        Ok((verdict, walk.steps(), stepped.err()))
    }
}

#[cfg(test)]
mod tests {
    use leafwise_scene::compose::RecordedShadow;

    use super::{Changes, ShadowVerdict};

    fn judged(orders: [usize; 2], energy: f64, shadow: f64, t: f64) -> ShadowVerdict {
        after(1000, orders, [energy, shadow], t)
    }

    fn after(steps: u64, orders: [usize; 2], kept: [f64; 2], t: f64) -> ShadowVerdict {
        let of = RecordedShadow {
            at: 0,
            order_of_map: orders[0],
            order: orders[1],
            limit: None,
        };
        let changes = Changes {
            energy: kept[0],
            shadow: kept[1],
            size: 1.0,
            steps,
        };
        ShadowVerdict::new(of, changes, t)
    }

    #[test]
    fn a_step_is_in_range_where_terms_fall_by_a_quarter() {
        let fine = judged([2, 4], 1e-3, 1e-5, 0.1);
        assert!(fine.is_in_range && fine.step.is_none(), "{fine:?}");
        let coarse = judged([2, 6], 1e-2, 2.5e-3, 0.4);
        assert!(!coarse.is_in_range);
        let step = coarse.step.expect("a shorter one");
        assert!((step - 0.2).abs() < 1e-15, "{step}");
        // Both at round-off: nothing falls, and nothing is wrong.
        assert!(judged([2, 4], 1e-15, 1e-15, 0.1).is_in_range);
        assert!(judged([2, 4], 0.0, 0.0, 0.1).is_in_range);
        // The random walk of 10⁸ steps, and not of a thousand.
        assert!(after(100_000_000, [8, 10], [1e-12, 1e-12], 0.1).is_in_range);
        assert!(!judged([8, 10], 1e-12, 1e-12, 0.1).is_in_range);
        // What has no value is kept by nothing.
        let undefined = judged([2, 4], 1e-3, f64::NAN, 0.1);
        assert!(!undefined.is_in_range && undefined.step.is_none());
    }
}

//! An exact realization that costs no more and was not taken.

use leafwise_core::{Integrator, Method};

use super::probe::Probe;
use super::{Advice, AdviceKind, number};
use crate::compose::exact_realization;

/// A bracket error of this part is round-off: matrices of a few hundred products.
const ROUND_OFF: f64 = 1e-13;

/// What an exact realization may cost of the operations of the one that it replaces.
const AS_DEAR: f64 = 1.1;

/// By how much its energy error may be larger: in another chart the generating function is another,
/// and may be a worse one.
const AS_WRONG: f64 = 2.0;

/// Steps over which operations and energy are measured.
const STEPS: usize = 32;

pub(super) fn advice(probe: &mut Probe<'_>) -> Option<Advice> {
    let n = probe.truncation_order()?;
    let own = probe.truncated(n).ok()?;
    let defect = probe.defect(&own)?;
    if defect <= ROUND_OFF {
        return None;
    }
    let (exact, choice) = exact_realization(probe.system(), probe.registry, false)?;
    let dynamics = probe.dynamics_again().ok()?;
    let method = Method::compose(probe.system(), exact, dynamics).ok()?;
    let (now, then) = (trial(probe, probe.method)?, trial(probe, &method)?);
    let is_worth_it = then.operations <= AS_DEAR * now.operations
        && then.energy <= AS_WRONG * now.energy + ROUND_OFF;
    is_worth_it.then(|| Advice {
        kind: AdviceKind::ExactRealization,
        message: format!(
            "{} realizes this tensor exactly in {:.0} operations a step; {} of order {n} takes \
             {:.0} and keeps the tensor up to {} of its size only",
            choice.name,
            then.operations,
            probe.realization.name,
            now.operations,
            number(defect)
        ),
        change: "realization = \"auto\"".to_owned(),
    })
}

/// What a method does over its first steps.
struct Trial {
    /// Operations a step.
    operations: f64,
    /// The largest deviation of the energy, relative to it.
    energy: f64,
}

fn trial(probe: &Probe<'_>, method: &Method) -> Option<Trial> {
    let plan = &probe.run.plan;
    let x = &probe.places.first()?.x;
    let mut integrator = Integrator::new(method, &probe.parameters, plan.epsilon, plan.h, x);
    let mut observer = probe.run.invariants().ok()?;
    let mut values = vec![0.0; observer.observables()];
    let mut energy_at = |state: &[f64]| {
        observer.evaluate(state, &mut values);
        values[0]
    };
    let initial = energy_at(x);
    let mut largest = 0.0_f64;
    for _ in 0..STEPS {
        integrator.step().ok()?;
        largest = largest.max((energy_at(integrator.state()) - initial).abs());
    }
    let size = if initial == 0.0 { 1.0 } else { initial.abs() };
    Some(Trial {
        operations: integrator.statistics().operations_per_step()?,
        energy: largest / size,
    })
}

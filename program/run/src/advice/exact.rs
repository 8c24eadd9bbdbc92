//! An exact realization that costs no more and was not taken.

use leafwise_core::Method;

use super::probe::Probe;
use super::trial::Trial;
use super::{Advice, AdviceKind, number};
use leafwise_scene::compose::exact_realization;

/// A bracket error of this part is round-off: matrices of a few hundred products.
const ROUND_OFF: f64 = 1e-13;

pub(super) fn advice(probe: &mut Probe<'_>) -> Option<Advice> {
    let n = probe.truncation_order()?;
    let own = probe.truncated(n).ok()?;
    let defect = probe.defect(&own)?;
    if defect <= ROUND_OFF {
        return None;
    }
    let dynamics = probe.dynamics_again().ok()?;
    let (exact, choice) = exact_realization(probe.system(), probe.registry, &dynamics, false)?;
    let method = Method::compose(probe.system(), exact, dynamics).ok()?;
    let states = || probe.places.iter().map(|place| place.x.as_slice());
    let now = Trial::of(probe.run, probe.method, states())?;
    let then = Trial::instead(probe.run, &method, states(), &now)?;
    then.is_worth_it(&now).then(|| Advice {
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

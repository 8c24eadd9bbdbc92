//! Forces over a realization that is not exact: steps leave the symplectic leaves.

use leafwise_core::Accuracy;

use super::probe::Probe;
use super::{Advice, AdviceKind, number};

pub(super) fn advice(probe: &mut Probe<'_>) -> Option<Advice> {
    let accuracy = probe.method.realization().accuracy();
    if !probe.system().has_forces() || accuracy == Accuracy::Exact {
        return None;
    }
    let part = probe.registry.realization(probe.realization.name).ok()?;
    let built = part.build(probe.system(), &super::probe::given(probe.realization));
    let defect = probe.defect(&built.ok()?)?;
    Some(Advice {
        kind: AdviceKind::LeftLeaf,
        message: format!(
            "{} is not exact, its brackets are off by {} of their size: with forces only exact realizations keep to \
             the symplectic leaves, and Casimirs drift",
            probe.realization.name,
            number(defect)
        ),
        change: "realization = \"auto\"".to_owned(),
    })
}

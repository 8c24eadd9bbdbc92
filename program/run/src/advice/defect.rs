//! A truncated realization that hardly keeps the tensor.

use super::probe::Probe;
use super::step::half_the_step;
use super::{Advice, AdviceKind, number};

/// Brackets that are wrong by this part are no approximation of the tensor.
const HARDLY: f64 = 1e-2;

pub(super) fn advice(probe: &mut Probe<'_>) -> Option<Advice> {
    let n = probe.truncation_order()?;
    let defect = probe.defect(&probe.truncated(n).ok()?)?;
    (defect >= HARDLY).then(|| Advice {
        kind: AdviceKind::RealizationDefect,
        message: format!(
            "{} of order {n} keeps the tensor up to {} of its size only: the step is too large for \
             it",
            probe.realization.name,
            number(defect)
        ),
        change: half_the_step(probe.run),
    })
}

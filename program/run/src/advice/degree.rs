//! Tables whose derivatives jump below the order of the method.

use std::collections::BTreeMap;

use leafwise_expression::Expression;
use leafwise_expression::table::HIGHEST_DEGREE;

use super::{Advice, AdviceKind};
use leafwise_scene::compose::ComposedRun;

/// A table of degree k that is differentiated o times has a (k − o)-th derivative that jumps at its knots. Across one, a step
/// is of order k − o where it stands in H, of which the motion takes a derivative, and of order k − o + 1 elsewhere.
pub(super) fn advice(run: &ComposedRun) -> Option<Advice> {
    let system = run.system.expressions()?;
    let order = run.method.declared_order();
    // The derivatives that each table loses to its formulas.
    let mut lost: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    let mut take = |formula: &Expression, taken: usize| {
        for lookup in formula.lookups() {
            let highest = lookup.orders().iter().copied().max().unwrap_or(0);
            let own = (usize::from(highest) + taken).saturating_sub(1);
            let degree = usize::from(lookup.table().degree());
            let entry = lost.entry(lookup.table().name()).or_insert((degree, own));
            entry.1 = entry.1.max(own);
        }
    };
    take(system.hamiltonian(), 1);
    system.tensor().values().for_each(|entry| take(entry, 0));
    system.forces().formulas().for_each(|force| take(force, 0));
    let left = |(degree, lost): &(usize, usize)| degree.saturating_sub(*lost);
    let (name, own) = lost.iter().min_by_key(|(_, own)| left(own))?;
    let left = left(own);
    (left < order).then(|| Advice {
        kind: AdviceKind::TableDegree,
        message: format!(
            "the table `{name}` has polynomials of degree {}, whose derivatives jump at its nodes: of the method's order {order} \
             they leave {left}",
            own.0
        ),
        change: match order + own.1 {
            degree if degree <= usize::from(HIGHEST_DEGREE) => {
                format!("degree = {degree} in [system.tables.{name}], or a smaller time-step")
            }
            _ => format!("a method of order {}, or a smaller time-step", left - left % 2),
        },
    })
}

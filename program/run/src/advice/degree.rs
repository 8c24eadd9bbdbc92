//! Tables whose derivatives jump below the order of the method.

use std::collections::BTreeMap;

use leafwise_expression::Expression;
use leafwise_expression::table::HIGHEST_DEGREE;

use super::{Advice, AdviceKind};
use leafwise_scene::compose::ComposedRun;

/// Warns of tables that cost the method its order.
///
/// A table of degree k that is differentiated o times has a (k − o)-th derivative that jumps at its knots. Across one, a step
/// is of order k − o where it stands in H, of which the motion takes a derivative. Elsewhere it is of order k − o + 1.
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
    lost.retain(|_, (degree, lost)| *degree < order + *lost);
    let names: Vec<String> = lost.keys().map(|name| format!("`{name}`")).collect();
    let left = lost.values().map(|(degree, lost)| degree - lost).min()?;
    let most_lost = lost.values().map(|(_, lost)| *lost).max()?;
    Some(Advice {
        kind: AdviceKind::TableDegree,
        message: format!(
            "{} of polynomials whose derivatives jump between cells: of the method's order {order} they leave {left}",
            match &names[..] {
                [name] => format!("the table {name} is"),
                names => format!("the tables {} are", names.join(", ")),
            }
        ),
        change: match order + most_lost {
            degree if degree <= usize::from(HIGHEST_DEGREE) => {
                format!("degree = {degree} in [system.tables], or a smaller time-step")
            }
            _ => "a method of a lower order, or a smaller time-step".to_owned(),
        },
    })
}

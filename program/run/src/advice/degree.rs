//! Tables whose derivatives jump below the order of the method.

use leafwise_core::system::TableUse;
use leafwise_expression::table::HIGHEST_DEGREE;

use super::{Advice, AdviceKind};
use leafwise_scene::compose::ComposedRun;

/// Warns of tables that cost the method its order.
pub(super) fn advice(run: &ComposedRun) -> Option<Advice> {
    let system = run.system.expressions()?;
    let order = run.method.declared_order();
    let mut uses = system.table_uses();
    uses.retain(|table| table.order() < order);
    let names: Vec<String> = uses
        .iter()
        .map(|table| format!("`{}`", table.name))
        .collect();
    let left = uses.iter().map(TableUse::order).min()?;
    let most_lost = uses.iter().map(|table| table.derivatives).max()?;
    Some(Advice {
        kind: AdviceKind::TableDegree,
        message: format!(
            "{} of polynomials whose derivatives jump between cells: they reduce the method's order {order} to {left}",
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

//! Values of formulas with a bound on what rounding has put into them.

use leafwise_expression::Expression;
use leafwise_expression::bounded::{Bounded, BoundedNumbers};
use leafwise_scene::compose::ComposedRun;

/// A formula's value at a state whose coordinates are rounded by `units` of their last place; `None` where it has none.
pub(crate) fn round_off(
    run: &ComposedRun,
    formula: &Expression,
    x: &[f64],
    units: f64,
) -> Option<Bounded> {
    let parameters = run.system.parameter_values();
    let mut coordinate = |_: &mut BoundedNumbers, at: usize| {
        Ok(Bounded {
            value: x[at],
            error: units * f64::EPSILON * x[at].abs(),
        })
    };
    let value = formula.evaluate_in(&mut BoundedNumbers { parameters }, &mut coordinate);
    value.ok()
}

//! Seams that a step crosses.

use leafwise_core::Evaluator;
use leafwise_expression::Expression;
use leafwise_scene::compose::ComposedRun;

/// Parts of a step after which it is asked in which piece the state is.
const PARTS: [f64; 6] = [0.125, 0.25, 0.5, 0.75, 1.0, 1.5];

/// The formula, as written, that decides of the piece of H, the tensor or the forces. It changes its sign in a step from a state
/// along the field; `None` where none does.
pub(crate) fn crossed(run: &ComposedRun, state: &[f64]) -> Option<String> {
    let system = run.in_time().ok()?;
    let formulas = system.expressions()?;
    if state.len() != system.dimension() || !formulas.has_seams() {
        return None;
    }
    let parameters = formulas.parameter_values();
    let (field, _) = system.field_and_rounding().ok()?;
    let mut slope = vec![0.0; state.len()];
    let mut field = field.evaluator(&parameters, 1.0, 1.0);
    field.values(state, &mut slope).ok()?;
    let step = run.plan.epsilon * run.plan.h;
    let mut seams = formulas.parts().flat_map(Expression::seams);
    let [shown, _] = seams.find(|[_, piece]| {
        let own = piece.evaluate(state, &parameters);
        PARTS.iter().any(|part| {
            let moved = state.iter().zip(&slope);
            let moved: Vec<f64> = moved.map(|(x, v)| x + part * step * v).collect();
            piece.evaluate(&moved, &parameters) != own
        })
    })?;
    let names = formulas.parameters().iter().map(|own| own.name.clone());
    Some(shown.written(formulas.variables(), &names.collect::<Vec<_>>()))
}

//! Hamiltonians and tensors that are smooth in pieces.

use leafwise_core::Evaluator;
use leafwise_expression::Expression;
use leafwise_scene::compose::ComposedRun;

use super::{Advice, AdviceKind};

/// Up to this order a method loses nothing that is told of here.
const ORDER: usize = 2;

/// A method of a higher order than a step across a seam has.
pub(super) fn advice(run: &ComposedRun) -> Option<Advice> {
    let system = run.system.expressions()?;
    let order = run.method.declared_order();
    let subject = match system.hamiltonian().has_seams() {
        true => "Hamiltonian",
        false => "bracket",
    };
    (order > ORDER && system.has_seams()).then(|| Advice {
        kind: AdviceKind::Seams,
        message: format!(
            "the {subject} is smooth in pieces: a step that crosses a seam of its abs, if, min, max, mod or floor is \
             not of the method's order {order}"
        ),
        change: "a smaller time-step, or smooth functions such as tanh in their place".to_owned(),
    })
}

/// Parts of a step after which it is asked in which piece the state is.
const PARTS: [f64; 6] = [0.125, 0.25, 0.5, 0.75, 1.0, 1.5];

/// What decides of the piece of H or the tensor and changes in a step from a state, as it is written. The step is taken
/// along the field.
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
    let parts = formulas.tensor().values().chain([formulas.hamiltonian()]);
    let mut seams = parts.flat_map(Expression::seams);
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

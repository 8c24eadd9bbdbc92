//! Hamiltonians and tensors that are smooth in pieces.

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
        change: "a smaller time-step, or smooth functions such as tanh instead".to_owned(),
    })
}

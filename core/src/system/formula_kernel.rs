//! Formulas of a system's variables as one kernel.

use leafwise_expression::{Expression, Graph, Kernel, Term};

use crate::error::BuildError;

/// The kernel x ↦ (f₁(x), …) of formulas in `dimension` variables.
pub(super) fn kernel(
    formulas: &[&Expression],
    dimension: usize,
    parameters: usize,
) -> Result<Kernel, BuildError> {
    let mut graph = Graph::new();
    let x: Vec<Term> = (0..dimension).map(|i| graph.input(i)).collect();
    let mut outputs = Vec::with_capacity(formulas.len());
    for formula in formulas {
        outputs.push(formula.evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone()))?);
    }
    Ok(Kernel::compile(&graph, &outputs, parameters, dimension))
}

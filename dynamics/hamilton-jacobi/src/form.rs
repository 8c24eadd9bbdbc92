//! Ŝ in the form that makes the shorter kernel: expanded, or as code.
//!
//! Expanded sums cancel, most of all over linear tensors: dŜ of the rigid body at m = 8 has 98
//! operations, and 1869 as code. Products of many generators multiply: dŜ of point vortices at
//! m = 4 has 45 026 operations expanded, and 445 as code. Where expanded sums cancel in numbers, or
//! differ from the formulas, it is code.

use leafwise_core::dynamics::{Generating, GeneratingFunction};
use leafwise_core::realization::SourceSeries;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::{Graph, Kernel, StepSize, Term};

use crate::coefficients::NAME;
use crate::coefficients::{generating_code, within};

/// Expansions of so many products of terms, with so few monomials in dŜ, are taken as they are: the
/// other form would save nothing that building it does not cost.
const FEW_PRODUCTS: u64 = 5_000;
const FEW_MONOMIALS: usize = 256;

/// Products of terms spent on expanding, for each operation of the code that is to be beaten. Where
/// expanding pays it takes 3 to 17.
const PRODUCTS_AN_OPERATION: u64 = 32;

/// Ŝ of even order m in its shorter form.
///
/// # Errors
/// Those of [`generating_code`].
pub(crate) fn shortest(
    system: &PoissonSystem,
    series: &SourceSeries<'_>,
    order: usize,
) -> Result<Generating, BuildError> {
    let formulas = system.formulas(NAME)?;
    let first = within(system, series, order, FEW_PRODUCTS)?;
    let code = generating_code(system, series, order)?;
    if let Some(function) = first.as_ref().filter(|f| monomials(f) <= FEW_MONOMIALS) {
        return Ok(if function.rounds_as(&code, formulas)? {
            Generating::Polynomials(function.clone())
        } else {
            Generating::Code(code)
        });
    }
    let to_beat = operations(&Generating::Code(code.clone()), system)?;
    let expanded = match first {
        Some(function) => Some(function),
        None => {
            let products = FEW_PRODUCTS + PRODUCTS_AN_OPERATION * to_beat;
            within(system, series, order, products)?
        }
    };
    let Some(function) = expanded else {
        return Ok(Generating::Code(code));
    };
    let expanded = Generating::Polynomials(function.clone());
    Ok(
        if operations(&expanded, system)? <= to_beat && function.rounds_as(&code, formulas)? {
            expanded
        } else {
            Generating::Code(code)
        },
    )
}

fn monomials(function: &GeneratingFunction) -> usize {
    let components = function.gradients.iter().flatten();
    components.map(|component| component.terms().len()).sum()
}

/// Operations of one evaluation of dŜ.
fn operations(generating: &Generating, system: &PoissonSystem) -> Result<u64, BuildError> {
    let d = system.dimension();
    let mut graph = Graph::new();
    let y: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
    let epsilon = graph.step_size(StepSize::Epsilon);
    let h = graph.step_size(StepSize::H);
    let p = generating.differential(&mut graph, &epsilon, &h, &y)?;
    let kernel = Kernel::compile(&graph, &p, system.parameters().len(), d);
    Ok(kernel.step_operations().total() as u64)
}

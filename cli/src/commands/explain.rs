//! `run --explain`: what was built for the scene.

use std::time::Instant;

use leafwise::core::{BuildError, Integrator};
use leafwise::expression::{Graph, Kernel, StepSize, Term};
use leafwise::scene::compose::{ComposedRun, tensor_shape};

use crate::table::{duration, words};

/// Lines about the method; takes one step to measure the time since `start`.
///
/// # Errors
/// [`BuildError`] where a formula has no code.
pub fn explain(run: &ComposedRun, start: Instant) -> Result<Vec<String>, BuildError> {
    let plan = &run.plan;
    let method = &run.method;
    let parameters = run.system.parameter_values();
    let mut integrator = Integrator::new(method, &parameters, plan.epsilon, plan.h, &plan.initial);
    let first_step = match integrator.step() {
        Ok(()) => duration(start.elapsed().as_secs_f64()),
        Err(error) => format!("the first step fails: {error}"),
    };
    let mut rows: Vec<(String, String)> = Vec::new();
    let mut line = |label: &str, text: String| rows.push((label.to_owned(), text));
    line("dimension", run.system.dimension().to_string());
    line("tensor", tensor_shape(&run.system).to_string());
    line("realization", method.realization().describe());
    line("dynamics", method.dynamics().describe());
    line(
        "declared order",
        format!("{} in t = epsilon*h", method.declared_order()),
    );
    if let Some(generating) = method.bisection().generating_function() {
        for (at, (s, gradient)) in generating
            .coefficients
            .iter()
            .zip(&generating.gradients)
            .enumerate()
        {
            let of_gradient: usize = gradient
                .iter()
                .map(|component| component.terms().len())
                .sum();
            line(
                &format!("S_{}", 2 * at + 1),
                format!("{} monomials, its gradient {of_gradient}", s.terms().len()),
            );
        }
    }
    if let Some(kernel) = one_form_kernel(run)? {
        line(
            "step kernel: all of dS",
            kernel.step_operations().to_string(),
        );
        line(
            "coefficients of dS",
            kernel.coefficient_operations().to_string(),
        );
    }
    let newton = method.newton();
    line(
        "step kernel: residual",
        newton.residual_operations().to_string(),
    );
    line(
        "step kernel: Newton iteration",
        newton.operations().to_string(),
    );
    line(
        "coefficient kernel",
        newton.coefficient_operations().to_string(),
    );
    line("scene text to first step", first_step);
    let rows: Vec<Vec<String>> = rows
        .into_iter()
        .map(|(label, text)| vec![format!("  {label}"), text])
        .collect();
    Ok(words(&rows))
}

/// y ↦ dŜ(y) alone.
fn one_form_kernel(run: &ComposedRun) -> Result<Option<Kernel>, BuildError> {
    let Some(code) = run.method.bisection().code() else {
        return Ok(None);
    };
    let d = run.system.dimension();
    let mut graph = Graph::new();
    let y: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
    let epsilon = graph.step_size(StepSize::Epsilon);
    let h = graph.step_size(StepSize::H);
    let point = code.point(&mut graph, &epsilon, &h, &y)?;
    Ok(point
        .get(d..)
        .map(|p| Kernel::compile(&graph, p, run.system.parameters().len(), d)))
}

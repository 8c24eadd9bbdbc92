//! `run --explain`: what was built for the scene.

use std::time::Instant;

use leafwise::core::dynamics::Generating;
use leafwise::core::{BuildError, Method, Registry, Walk};
use leafwise::expression::{Execution, Graph, Kernel, StepSize, Term};
use leafwise::run::advice::cheaper_method;
use leafwise::scene::compose::ComposedRun;

use crate::table::{duration, words};

/// Lines about the method, and about a cheaper one; takes one step to measure the time since `start`.
///
/// # Errors
/// [`BuildError`] where a formula has no code.
pub fn explain(
    run: &ComposedRun,
    registry: &Registry,
    start: Instant,
) -> Result<Vec<String>, BuildError> {
    let plan = &run.plan;
    let parameters = run.system.parameter_values();
    let map = run.method.map();
    let mut walk = Walk::new(map, &parameters, plan.epsilon, plan.h, &plan.initial);
    let first_step = match walk.step() {
        Ok(()) => duration(start.elapsed().as_secs_f64()),
        Err(error) => format!("the first step fails: {error}"),
    };
    let mut rows = vec![
        ("Dimension".to_owned(), dimension(run)),
        ("Tensor".to_owned(), run.tensor_shape().to_string()),
        (
            "Declared order".to_owned(),
            match run.method.declared_order() {
                0 => "none in t = εh: its tolerance sets its error".to_owned(),
                order if run.method.noise().is_some() => format!("{order} in t = εh, of means"),
                order => format!("{order} in t = εh"),
            },
        ),
    ];
    rows.extend(
        run.method
            .parts(run.system.motion())
            .into_iter()
            .map(|(label, text)| (label.to_owned(), text)),
    );
    for part in &run.plan.parts {
        if let Some(reason) = &part.reason {
            rows.push((
                "Chosen".to_owned(),
                format!("{}, since {reason}", part.name),
            ));
        }
    }
    for part in plan.system.iter().chain(&plan.parts) {
        if let (Some(path), Some(origin)) = (part.path, &part.origin) {
            rows.push((
                "Loaded".to_owned(),
                format!("{} by {path}, from {origin}", part.name),
            ));
        }
    }
    match (run.method.written(), run.method.lattice()) {
        (Some(method), _) => rows.extend(series(run, method)?),
        (None, None) => {}
        (None, Some(_)) => rows.push((
            "Templates".to_owned(),
            format!("from a lattice of {} coordinates", run.system.dimension()),
        )),
    }
    rows.extend(
        run.method
            .costs()
            .into_iter()
            .map(|(label, cost)| (label.to_owned(), cost)),
    );
    rows.push(("Scene text to first step".to_owned(), first_step));
    rows.extend(machine_code(run));
    let cheaper = cheaper_method(run, registry);
    rows.extend(cheaper.map(|cheaper| ("Cheaper".to_owned(), cheaper.to_string())));
    let rows: Vec<Vec<String>> = rows
        .into_iter()
        .map(|(label, text)| vec![format!("  {label}"), text])
        .collect();
    let motion = super::motion::lines(run);
    Ok([words(&rows), motion].concat())
}

/// d, and the coordinates that a step moves beside.
fn dimension(run: &ComposedRun) -> String {
    let own = run.plan.layout.coordinates();
    match run.plan.layout.clock() {
        None => own.to_string(),
        Some(_) => format!("{own}, and the time with its energy"),
    }
}

/// Machine code of a step's kernels, as labelled rows: how they are executed, then name, size and time of each. Kernels
/// that are to be compiled at all are compiled here.
fn machine_code(run: &ComposedRun) -> Vec<(String, String)> {
    let execution = Execution::default_of_process();
    let mut rows = vec![("Execution".to_owned(), execution.describe().to_owned())];
    if execution == Execution::Interpreted {
        return rows;
    }
    for (name, kernel) in run.method.map().abilities().kernels {
        kernel.workspace_for(1, Execution::Compiled);
        for size in kernel.machine_code() {
            let time = duration(size.seconds);
            rows.push((
                "Machine code".to_owned(),
                format!("{name}: {size}, in {time}"),
            ));
        }
    }
    rows
}

/// Lines about S_1, S_3, … and the kernel of dS.
fn series(run: &ComposedRun, method: &Method) -> Result<Vec<(String, String)>, BuildError> {
    let mut rows = Vec::new();
    match method.bisection().generating_function() {
        Some(Generating::Polynomials(function)) => {
            let terms = function.coefficients.iter().zip(&function.gradients);
            for (at, (s, gradient)) in terms.enumerate() {
                let of_gradient: usize = gradient
                    .iter()
                    .map(|component| component.terms().len())
                    .sum();
                rows.push((
                    format!("S_{}", 2 * at + 1),
                    format!("{} monomials, dS {of_gradient}", s.terms().len()),
                ));
            }
        }
        Some(Generating::Code(code)) => rows.push((
            format!("S_1 to S_{}", 2 * code.coefficients.len() - 1),
            "as code: expanded they would be longer".to_owned(),
        )),
        None => {}
    }
    if let Some(kernel) = one_form_kernel(run, method)? {
        rows.push((
            "Step kernel of dS".to_owned(),
            kernel.step_operations().to_string(),
        ));
        let coefficients = kernel.coefficient_operations().to_string();
        rows.push(("Its coefficients, once".to_owned(), coefficients));
    }
    Ok(rows)
}

/// y ↦ dŜ(y) alone.
fn one_form_kernel(run: &ComposedRun, method: &Method) -> Result<Option<Kernel>, BuildError> {
    let Some(code) = method.bisection().code() else {
        return Ok(None);
    };
    let d = run.system.dimension();
    let mut graph = Graph::new();
    let y: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
    let epsilon = graph.step_size(StepSize::Epsilon);
    let h = graph.step_size(StepSize::H);
    let point = code(&mut graph, &epsilon, &h, &y)?;
    Ok(point
        .get(d..)
        .map(|p| Kernel::compile(&graph, p, run.system.parameters().len(), d)))
}

//! `leafwise evaluate`: the realization and the generating function at a point.

use leafwise::core::part::ParameterSetting;
use leafwise::core::{BuildError, Method};
use leafwise::expression::{Arithmetic, Graph, Kernel, Rational, StepSize, Term};
use leafwise::karasev::TruncatedKarasev;
use leafwise::scene::compose::{ComposedRun, compose};
use leafwise::scene::json::{json_number, json_numbers};
use serde_json::{Map, Value, json};

use crate::arguments::{EvaluateArguments, PluginArguments};
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
use crate::table::words;

/// The values at a point (x, p).
struct Values {
    alpha: Vec<f64>,
    beta: Vec<f64>,
    /// α_(0), …, α_(n) at ε = 1; empty unless the realization is a truncated series.
    coefficients: Vec<Vec<f64>>,
    /// l, S_l(x), dS_l(x) at the scene's ε.
    generating: Vec<(usize, f64, Vec<f64>)>,
}

/// Evaluates at the point of the command line; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid or the point has another dimension.
pub fn execute(
    arguments: &EvaluateArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let run = compose(&document, &parts.registry)?;
    let Some(method) = run.method.written() else {
        if run.method.lattice().is_none() {
            return Err(Failure::usage(
                "a stepper has no realization to evaluate",
                "name a realization and dynamics, with --set method.realization=karasev-truncated",
            ));
        }
        return Err(Failure::usage(
            format!(
                "a lattice of {} coordinates is not evaluated at a point",
                run.dimension()
            ),
            "shorten it with --set system.families.NAME=8",
        ));
    };
    let d = run.system.dimension();
    let x = match &arguments.x {
        Some(text) => numbers(text, "--x", d)?,
        None => run
            .plan
            .initial
            .iter()
            .filter_map(|x| Rational::from_f64(*x))
            .collect(),
    };
    let p = match &arguments.p {
        Some(text) => numbers(text, "--p", d)?,
        None => vec![Rational::zero(); d],
    };
    let values = evaluate(&run, method, &x, &p).map_err(|error| {
        Failure::usage(
            format!("nothing can be evaluated at this point: {error}"),
            "choose --x and --p inside the domain of the scene's formulas",
        )
    })?;
    if arguments.json {
        console.json(&as_json(&values));
    } else {
        for line in words(&rows(&values)) {
            console.result(&line);
        }
    }
    Ok(exit::DONE)
}

/// The decimals of an option, exactly.
fn numbers(text: &str, option: &str, dimension: usize) -> Result<Vec<Rational>, Failure> {
    let mut values = Vec::new();
    for piece in text.split(',') {
        match Rational::parse_decimal(piece.trim()) {
            Ok(value) => values.push(value),
            Err(_) => {
                return Err(Failure::usage(
                    format!("{option}: `{}` is not a decimal number", piece.trim()),
                    format!("write {dimension} numbers with commas between, as in {option} 1,3,3"),
                ));
            }
        }
    }
    if values.len() != dimension {
        return Err(Failure::usage(
            format!(
                "{option} has {} numbers, and the scene {dimension} coordinates",
                values.len()
            ),
            format!("give {dimension} numbers with commas between"),
        ));
    }
    Ok(values)
}

/// Code at one point. The point enters as exact numbers, so that polynomials of it are formed
/// exactly and rounded once.
struct Evaluator<'a> {
    run: &'a ComposedRun,
    graph: Graph,
    epsilon: Term,
    inputs: Vec<Term>,
}

impl<'a> Evaluator<'a> {
    fn new(run: &'a ComposedRun, x: &[Rational], p: &[Rational]) -> Self {
        let mut graph = Graph::new();
        let inputs = x
            .iter()
            .chain(p)
            .map(|value| graph.constant(value))
            .collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        Self {
            run,
            graph,
            epsilon,
            inputs,
        }
    }

    fn values(&self, outputs: &[Term]) -> Vec<f64> {
        let parameters = self.run.system.parameter_values();
        let kernel = Kernel::compile(&self.graph, outputs, parameters.len(), 0);
        let mut workspace = kernel.workspace(1);
        let plan = &self.run.plan;
        kernel.prepare(&mut workspace, &parameters, &[plan.epsilon], &[plan.h]);
        let mut values = vec![0.0; outputs.len()];
        kernel.evaluate(&mut workspace, &[], &mut values);
        values
    }
}

fn evaluate(
    run: &ComposedRun,
    method: &Method,
    x: &[Rational],
    p: &[Rational],
) -> Result<Values, BuildError> {
    let d = x.len();
    let mut at = Evaluator::new(run, x, p);
    let (epsilon, inputs) = (at.epsilon.clone(), at.inputs.clone());
    let realization = method.realization();
    let (mut alpha, mut beta) = (Vec::new(), Vec::new());
    if let Some(code) = realization.code() {
        let ends = code.source_and_target(&mut at.graph, &epsilon, &inputs)?;
        let target: Vec<Term> = (0..d)
            .map(|i| at.graph.add(&ends.base[i], &ends.offset[i]))
            .collect();
        let source: Vec<Term> = (0..d)
            .map(|i| at.graph.add(&target[i], &ends.increment[i]))
            .collect();
        beta = at.values(&target);
        alpha = at.values(&source);
    }
    let order = run
        .plan
        .parts
        .iter()
        .filter(|part| part.name == "karasev-truncated")
        .flat_map(|part| &part.parameters)
        .find(|(name, _)| *name == "order")
        .and_then(|(_, order)| match order {
            ParameterSetting::Integer(order) => usize::try_from(*order).ok(),
            _ => None,
        });
    let mut coefficients = Vec::new();
    if let Some(order) = order {
        let series = TruncatedKarasev::new(&run.system, order)?;
        let (x, p) = inputs.split_at(d);
        for terms in series.coefficients(&mut at.graph, x, p)? {
            coefficients.push(at.values(&terms));
        }
    }
    let mut generating = Vec::new();
    if let Some(function) = method.bisection().generating_function() {
        let square = at.graph.multiply(&epsilon, &epsilon);
        // S_l at ε is ε^{l−1} times S_l at 1.
        let mut power = at.graph.one();
        for k in 0..function.len() {
            let at_one = function.coefficient(&mut at.graph, k, &inputs[..d])?;
            let terms: Vec<Term> = at_one
                .iter()
                .map(|term| at.graph.multiply(&power, term))
                .collect();
            let values = at.values(&terms);
            generating.push((2 * k + 1, values[0], values[1..].to_vec()));
            power = at.graph.multiply(&power, &square);
        }
    }
    Ok(Values {
        alpha,
        beta,
        coefficients,
        generating,
    })
}

fn as_json(values: &Values) -> Value {
    let generating: Map<String, Value> = values
        .generating
        .iter()
        .map(|(l, s, gradient)| {
            (
                l.to_string(),
                json!({ "S": json_number(*s), "dS": json_numbers(gradient) }),
            )
        })
        .collect();
    let mut object = json!({
        "alpha": json_numbers(&values.alpha),
        "beta": json_numbers(&values.beta),
        "hamilton_jacobi": generating,
    });
    if !values.coefficients.is_empty() {
        let lists: Vec<Value> = values
            .coefficients
            .iter()
            .map(|coefficient| json_numbers(coefficient))
            .collect();
        object["alpha_coefficients"] = Value::Array(lists);
    }
    object
}

fn rows(values: &Values) -> Vec<Vec<String>> {
    let list = |numbers: &[f64]| {
        let numbers: Vec<String> = numbers.iter().map(|value| format!("{value:?}")).collect();
        numbers.join(", ")
    };
    let mut rows = vec![
        vec!["alpha".to_owned(), list(&values.alpha)],
        vec!["beta".to_owned(), list(&values.beta)],
    ];
    for (k, coefficient) in values.coefficients.iter().enumerate() {
        rows.push(vec![format!("alpha, epsilon^{k}"), list(coefficient)]);
    }
    for (l, s, gradient) in &values.generating {
        rows.push(vec![format!("S_{l}"), format!("{s:?}")]);
        rows.push(vec![format!("dS_{l}"), list(gradient)]);
    }
    rows
}

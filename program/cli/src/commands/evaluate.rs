//! `leafwise evaluate`: the realization and the generating function at a point.

use leafwise::core::part::ParameterSetting;
use leafwise::core::realization::{Abilities, Accuracy, EndMaps, Ends, RealizationData};
use leafwise::core::{BuildError, ChartMaps, Method, StepError, realization_evaluator};
use leafwise::expression::{Arithmetic, Graph, Kernel, Rational, StepSize, Term};
use leafwise::karasev::TruncatedKarasev;
use leafwise::scene::compose::{ComposedRun, DENSE_LIMIT, ShadowEnergy, compose, refuse_noise};
use leafwise::scene::json::object;
use serde::Serialize;

use crate::arguments::{EvaluateArguments, PluginArguments};
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
use crate::table::words;

/// Why a point has no values.
struct Unevaluated(String);

impl From<BuildError> for Unevaluated {
    fn from(error: BuildError) -> Self {
        Self(error.to_string())
    }
}

impl From<StepError> for Unevaluated {
    fn from(error: StepError) -> Self {
        match error {
            StepError::LeftChart { ratio } => Self::outside(ratio),
            // What to try with a step does not help here.
            other => Self(other.cause().to_string()),
        }
    }
}

impl Unevaluated {
    fn outside(ratio: f64) -> Self {
        Self(format!(
            "it is outside the realization's chart, {ratio:.3} times as far from the section as the chart reaches"
        ))
    }
}

/// The values at a point (x, p).
#[derive(Serialize)]
struct Values {
    alpha: Vec<f64>,
    beta: Vec<f64>,
    /// l with S_l(x) and dS_l(x) at the scene's ε.
    #[serde(rename = "hamilton_jacobi", serialize_with = "object")]
    generating: Vec<(usize, Generating)>,
    /// k with F_k(x) of the shadow Hamiltonian, where that has formulas.
    #[serde(serialize_with = "object", skip_serializing_if = "Vec::is_empty")]
    shadow: Vec<(usize, f64)>,
    /// α_(0), …, α_(n) at ε = 1; empty unless the realization is a truncated series.
    #[serde(rename = "alpha_coefficients", skip_serializing_if = "Vec::is_empty")]
    coefficients: Vec<Vec<f64>>,
}

/// A term of the generating function.
#[derive(Serialize)]
struct Generating {
    #[serde(rename = "S")]
    value: f64,
    #[serde(rename = "dS")]
    gradient: Vec<f64>,
}

impl Values {
    /// The values where every one is finite.
    fn finite(self) -> Result<Self, Unevaluated> {
        let named = |name: &str, values: &[f64]| (name.to_owned(), values.to_vec());
        let mut all = vec![named("alpha", &self.alpha), named("beta", &self.beta)];
        for (k, coefficient) in self.coefficients.iter().enumerate() {
            all.push((
                format!("alpha's coefficient of epsilon^{k}"),
                coefficient.clone(),
            ));
        }
        for (l, term) in &self.generating {
            all.push((format!("S_{l}"), vec![term.value]));
            all.push((format!("dS_{l}"), term.gradient.clone()));
        }
        for (k, value) in &self.shadow {
            all.push((format!("the shadow Hamiltonian's F_{k}"), vec![*value]));
        }
        let wrong = all.iter().find_map(|(name, values)| {
            let value = values.iter().find(|value| !value.is_finite())?;
            Some(Unevaluated(format!("{name} is not finite there ({value})")))
        });
        wrong.map_or(Ok(self), Err)
    }
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
    refuse_noise(
        &document,
        "parts are not evaluated at steps",
        "remove the noise",
    )?;
    let run = while_building(console.shown(false), || compose(&document, &parts.registry))?;
    let Some(method) = run.method.written() else {
        if run.method.lattice().is_none() {
            return Err(Failure::usage(
                "a stepper has no realization to evaluate",
                "name a realization and dynamics, with --set method.realization=karasev-truncated",
            ));
        }
        return Err(Failure::usage(
            format!(
                "a lattice of {} coordinates cannot be evaluated at a point",
                run.plan.layout.coordinates()
            ),
            format!(
                "shorten it with {}",
                document.system.shortening(DENSE_LIMIT)
            ),
        ));
    };
    if method.realization().abilities().lift.is_some() {
        return Err(Failure::usage(
            format!(
                "{} uses coordinates in which the tensor is constant: it has no alpha and beta to evaluate",
                method.realization().describe()
            ),
            "name another realization, with --set method.realization=karasev-collocated",
        ));
    }
    if run.extension.is_some() {
        return Err(Failure::usage(
            "a scene whose Hamiltonian, one-form or forces name the time t, or that has a pace, cannot be evaluated at a point: its realization \
             also has the time and its energy as coordinates",
            "evaluate a copy of the scene with a number in place of t, and without the pace",
        ));
    }
    let d = run.system.dimension();
    // Behind the coordinates stand parameters of sites.
    let own = run.plan.layout.coordinates();
    let behind = |given: Vec<Rational>, rest: &[f64]| -> Vec<Rational> {
        let rest = rest.iter().filter_map(|x| Rational::from_f64(*x));
        given.into_iter().chain(rest).collect()
    };
    let x = match &arguments.x {
        Some(text) => behind(
            numbers(text, "--x", own)?,
            &run.plan.initial[run.plan.layout.beside()],
        ),
        None => run
            .plan
            .initial
            .iter()
            .filter_map(|x| Rational::from_f64(*x))
            .collect(),
    };
    let p = match &arguments.p {
        Some(text) => behind(
            numbers(text, "--p", own)?,
            &vec![0.0; run.plan.layout.beside().len()],
        ),
        None => vec![Rational::zero(); d],
    };
    let values = evaluate(&run, method, &x, &p).and_then(Values::finite);
    let values = values.map_err(|Unevaluated(reason)| {
        Failure::usage(
            format!("nothing can be evaluated at this point: {reason}"),
            "choose --x and --p inside the domain of the scene's formulas and of the realization, which \
             `leafwise describe` shows",
        )
    })?;
    if arguments.json {
        console.json(&values);
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

/// β̂ and α̂ at χ(x, p).
fn ends(
    at: &mut Evaluator<'_>,
    realization: &dyn RealizationData,
    x: &[Rational],
    p: &[Rational],
) -> Result<(Vec<f64>, Vec<f64>), Unevaluated> {
    let d = x.len();
    let (epsilon, inputs) = (at.epsilon.clone(), at.inputs.clone());
    let Abilities { ends, space, .. } = realization.abilities();
    if let Some(EndMaps::Code(code)) = ends
        && space.has_code()
    {
        let z = match space.chart_code() {
            Some(chart) => chart(&mut at.graph, &epsilon, &inputs[..d], &inputs[d..])?,
            None => inputs,
        };
        let ends = code(&mut at.graph, &epsilon, &z)?;
        // A truncated series has its values outside too; what a closed form has there is none.
        if let Some((first, last)) = &ends.guard
            && realization.accuracy() == Accuracy::Exact
        {
            let (first, last) = (largest(&at.values(first)), largest(&at.values(last)));
            // Not a number is outside too.
            let is_inside = last == 0.0 || last < first;
            if !is_inside {
                return Err(Unevaluated::outside(last / first));
            }
        }
        let target: Vec<Term> = (0..d)
            .map(|i| at.graph.add(&ends.base[i], &ends.offset[i]))
            .collect();
        let source: Vec<Term> = (0..d)
            .map(|i| at.graph.add(&target[i], &ends.increment[i]))
            .collect();
        return Ok((at.values(&target), at.values(&source)));
    }
    let parameters = at.run.system.parameter_values();
    let epsilon = at.run.plan.epsilon;
    let point: Vec<f64> = x.iter().chain(p).map(Rational::to_f64).collect();
    let chart = ChartMaps::of(realization, parameters.len())?;
    let chart = chart.ok_or_else(|| {
        Unevaluated(
            "points of this realization are not pairs (x, p), and it has no chart of them"
                .to_owned(),
        )
    })?;
    let mut z = vec![0.0; realization.space_dimension()];
    chart
        .evaluator(&parameters, epsilon)
        .values(&point, &mut z)?;
    let mut evaluator = realization_evaluator(realization, &parameters, epsilon)?;
    let mut values = vec![0.0; 3 * d];
    evaluator.values(&z, &mut values)?;
    let ends = Ends::of(&values);
    Ok((0..d).map(|i| (ends.target(i), ends.source(i))).unzip())
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

fn evaluate(
    run: &ComposedRun,
    method: &Method,
    x: &[Rational],
    p: &[Rational],
) -> Result<Values, Unevaluated> {
    let d = x.len();
    let mut at = Evaluator::new(run, x, p);
    let (beta, alpha) = ends(&mut at, method.realization(), x, p)?;
    let (epsilon, inputs) = (at.epsilon.clone(), at.inputs.clone());
    let order = run
        .plan
        .parts
        .iter()
        .filter(|part| part.name == TruncatedKarasev::NAME)
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
            let term = Generating {
                value: values[0],
                gradient: values[1..].to_vec(),
            };
            generating.push((2 * k + 1, term));
            power = at.graph.multiply(&power, &square);
        }
    }
    Ok(Values {
        alpha,
        beta,
        generating,
        shadow: shadow(run, x),
        coefficients,
    })
}

/// The terms of the shadow Hamiltonian at x, none where it has no formulas.
fn shadow(run: &ComposedRun, x: &[Rational]) -> Vec<(usize, f64)> {
    let t = run.plan.epsilon * run.plan.h;
    let Ok(found) = ShadowEnergy::of(&run.system, run.method.map(), t, None) else {
        return Vec::new();
    };
    let x: Vec<f64> = x.iter().map(Rational::to_f64).collect();
    let parameters = run.system.parameter_values();
    let terms = found.shadow.terms().into_iter();
    let value = |k: usize| {
        let formula = found.shadow.formula(k, usize::MAX)?;
        Some((k, formula.evaluate(&x, &parameters)))
    };
    terms
        .filter(|k| (2..=found.order).contains(k))
        .filter_map(value)
        .collect()
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
    for (l, term) in &values.generating {
        rows.push(vec![format!("S_{l}"), format!("{:?}", term.value)]);
        rows.push(vec![format!("dS_{l}"), list(&term.gradient)]);
    }
    for (k, value) in &values.shadow {
        rows.push(vec![format!("F_{k}"), format!("{value:?}")]);
    }
    rows
}

//! Long lattices: templates with offsets near and far move as they do written out, to the same bits by both kernels.

use leafwise::core::{Observer, Registry, Walk};
use leafwise::scene::compose::{Observable, RecordedFormula, Stepping};
use leafwise::scene::{ComposedRun, SceneDocument, compose};

use crate::Reached;
use crate::method::{compositions, steppers_of_rotations};
use crate::reference::extrapolated;
use crate::scenes::same_bits_of;
use crate::source::Source;

pub mod drawn;

use drawn::RandomLattice;

const STEPS: usize = 2;

/// The highest order of compositions whose errors are seen to fall.
const MOST_ORDER: usize = 6;

/// The product of a step and the rate ẋ/x of a lattice whose motion is compared.
const STEP: f64 = 0.04;

/// The same of the steps that tell the velocities, whose error is of its order at least.
const FINE: f64 = 1e-5;

/// Largest error of a velocity, relative to the largest velocity: of order 1 in [`FINE`], with room for derivatives.
const OF_VELOCITY: f64 = 1e-3;

/// Errors of the state below this part of it are round-off.
const ROUND_OFF: f64 = 1e-11;

/// How often steps are halved.
const HALVINGS: usize = 4;

/// A lattice drawn from bytes, with its method.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The lattice.
    pub lattice: RandomLattice,
    /// The name of its method.
    pub method: &'static str,
    /// The lines of its method.
    lines: String,
    /// Whether its motion is compared, by short steps.
    is_compared: bool,
    coarse: f64,
}

impl Drawn {
    fn text(&self, time_step: f64) -> String {
        let (system, run) = (self.lattice.system(), self.lattice.run(STEPS));
        format!(
            "{system}[method]\n{}time-step = {time_step:?}\n{run}",
            self.lines
        )
    }
}

/// The lattice of these bytes.
pub fn only_drawn(bytes: &[u8]) -> Drawn {
    let mut source = Source::new(bytes);
    let lattice = RandomLattice::drawn(&mut source);
    let (method, lines) = method(&mut source, &lattice);
    Drawn {
        lattice,
        method,
        lines,
        is_compared: source.chance(200),
        coarse: source.pick(&[1e-3, 0.01, 0.05, 0.1, 0.3]),
    }
}

/// One lattice.
///
/// # Errors
/// What is wrong, with the scene.
pub fn check(bytes: &[u8]) -> Result<Reached, String> {
    let drawn = only_drawn(bytes);
    let mut text = drawn.text(drawn.coarse);
    judged(&drawn, &mut text).map_err(|what| format!("{what}\n{text}"))
}

fn judged(drawn: &Drawn, text: &mut String) -> Result<Reached, String> {
    let lattice = &drawn.lattice;
    let registry = Registry::with_builtin();
    let composed = |text: &str| -> Result<Option<ComposedRun>, String> {
        let document = SceneDocument::parse("scene.toml", text, &registry);
        let document = document.map_err(|errors| format!("it is not read: {errors}"))?;
        match compose(&document, &registry) {
            Ok(run) => Ok(Some(run)),
            Err(refusal) if refusal.message.contains("defect") => Err(refusal.message.clone()),
            Err(_) => Ok(None),
        }
    };
    if drawn.is_compared {
        let x = lattice.state();
        let rate = rate(&x, &lattice.field(&x));
        if !(1e-6..1e6).contains(&rate) {
            return Ok(Reached::Refusal);
        }
        *text = drawn.text(format!("{:.2e}", STEP / rate).parse().unwrap_or(0.01));
    }
    let Some(run) = composed(text)? else {
        return Ok(Reached::Refusal);
    };
    let reached = same_bits_of(&run, STEPS)?;
    if reached == Reached::Comparison {
        observes_the_same(lattice, &run)?;
        if drawn.is_compared {
            moves_the_same(lattice, &run)?;
        }
    }
    Ok(reached)
}

/// max |ẋ_i| over max |x_i|.
fn rate(x: &[f64], field: &[f64]) -> f64 {
    largest(field) / largest(x)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, x| {
        if x.abs() > most || x.is_nan() {
            x.abs()
        } else {
            most
        }
    })
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let apart: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    largest(&apart)
}

/// The energy and the observable at the start, up to the round-off of their terms.
fn observes_the_same(lattice: &RandomLattice, run: &ComposedRun) -> Result<(), String> {
    let x = &run.plan.initial;
    let mut energy = run.invariants().map_err(|error| error.to_string())?;
    let mut observed = match &run.method {
        Stepping::Lattice(own) => Observer::from(own.formulas.clone()),
        _ => {
            let formulas = run
                .plan
                .observables
                .iter()
                .filter_map(|observable| match observable {
                    Observable::Formula {
                        formula: RecordedFormula::Written(expression),
                        ..
                    } => Some(expression),
                    _ => None,
                });
            let formulas: Vec<_> = formulas.collect();
            let observables = run.observables(&formulas);
            observables.map_err(|error| error.to_string())?.into()
        }
    };
    let mut own = [0.0; 2];
    energy.evaluate(x, &mut own[..1]);
    observed.evaluate(x, &mut own[1..]);
    let expected = lattice.values(x);
    // Sums of a few hundred terms.
    match distance(&own, &expected) <= 1e-13 * (1.0 + lattice.size(x)) {
        true => Ok(()),
        false => Err(format!(
            "energy and observable are {own:?}, and written out {expected:?}"
        )),
    }
}

/// The velocities, and the motion over two steps: its error falls as the method's order says.
fn moves_the_same(lattice: &RandomLattice, run: &ComposedRun) -> Result<(), String> {
    let x = &run.plan.initial;
    let field = lattice.field(x);
    let (speed, size) = (largest(&field), largest(x));
    let end = |steps: usize, time: f64| {
        let values = run.system.parameter_values();
        let h = time / run.plan.epsilon / steps as f64;
        let mut walk = Walk::new(run.method.map(), &values, run.plan.epsilon, h, x);
        for _ in 0..steps {
            walk.step().ok()?;
        }
        Some(walk.state().to_vec())
    };
    let fine = FINE * size / speed;
    if let (Some(after), Some(before)) = (end(1, fine), end(1, -fine)) {
        for (at, expected) in field.iter().enumerate() {
            let velocity = (after[at] - before[at]) / (2.0 * fine);
            let is_right = (velocity - expected).abs() <= OF_VELOCITY * speed;
            if !is_right {
                return Err(format!(
                    "coordinate {at} begins to move by {velocity}, and written out by {expected}"
                ));
            }
        }
    }
    let time = STEPS as f64 * run.plan.epsilon * run.plan.h;
    let (exact, _) = extrapolated(&|x: &[f64]| lattice.field(x), x, time);
    let order = run.method.declared_order();
    let falls = libm::pow(2.0, 1.0 - 2.0 * order as f64);
    let mut errors: Vec<f64> = Vec::new();
    for halving in 0..=HALVINGS {
        let Some(end) = end(STEPS << halving, time) else {
            return Ok(());
        };
        let error = distance(&end, &exact);
        errors.push(error);
        let is_fallen = |pair: &[f64]| pair[2] <= falls * pair[0];
        if error <= ROUND_OFF * size || errors.windows(3).any(is_fallen) {
            return Ok(());
        }
    }
    Err(format!(
        "of order {order} by its method, it is off by {errors:?} as steps are halved"
    ))
}

/// The name of a method that serves lattices, and its lines.
fn method(source: &mut Source<'_>, lattice: &RandomLattice) -> (&'static str, String) {
    let (name, mut text) = match source.below(8) {
        0..=2 => ("splitting", "stepper = \"splitting\"\n".to_owned()),
        3 => (
            "karasev-truncated",
            format!(
                "realization = {{ name = \"karasev-truncated\", order = {} }}\n\
                 dynamics = {{ name = \"hamilton-jacobi\", order = {} }}\n",
                1 + source.below(4),
                2 * (1 + source.below(2))
            ),
        ),
        4 if lattice.has_spins() => {
            let name = source.pick(steppers_of_rotations());
            (name, format!("stepper = \"{name}\"\n"))
        }
        5 => ("rk4", "stepper = \"rk4\"\n".to_owned()),
        6 if lattice.length() < 60 => (
            "gauss",
            "stepper = { name = \"gauss\", stages = 2 }\n".to_owned(),
        ),
        _ => {
            // Long series over far sites take long to form.
            let most = if lattice.farthest() <= 12 { 3 } else { 2 };
            let order = 2 * (1 + source.below(most));
            (
                "hamilton-jacobi",
                format!(
                    "realization = \"auto\"\ndynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\n"
                ),
            )
        }
    };
    if source.chance(80) && name != "rk4" {
        let composition = source.pick(&compositions(MOST_ORDER));
        text.push_str(&format!("composition = \"{composition}\"\n"));
    }
    (name, text)
}

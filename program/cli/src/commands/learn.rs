//! `leafwise learn`: a Poisson map from pairs of states one step apart, by least squares.

use leafwise::core::Walk;
use leafwise::generating_function::NAME as DYNAMICS;
use leafwise::learn::{
    BasisAxis, FunctionFamily, LearnAdvice, LearnError, LearnOptions, Learned, StatePairs, learn,
};
use leafwise::scene::compose::{TensorShape, compose, refuse_noise, tensor_shape};
use leafwise::scene::pairs::{read_pairs, read_weights};
use leafwise::scene::{
    ComposedRun, MethodParts, MethodTable, PartUse, SceneDocument, with_hamiltonian, with_system,
};
use serde::Serialize;

use super::find::write_scene;
use crate::arguments::{LearnArguments, PluginArguments};
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
use crate::pulse::Shown;
use crate::scene::SceneText;
use crate::table::words;

/// Steps of the learned map that are looked at for whether they leave the pairs.
const MOST_STEPS: u64 = 1000;

/// A state whose leverage is this many times the largest of the pairs is far from them.
const FAR: f64 = 4.0;

/// Functions that are printed.
const MOST_ROWS: usize = 12;

/// The object of `learn --json`.
#[derive(Serialize)]
struct LearnJson {
    outcome: &'static str,
    degree: usize,
    degrees: Vec<DegreeJson>,
    pairs: usize,
    equations: usize,
    determined: usize,
    time_step: f64,
    motion: f64,
    residual: f64,
    noise: f64,
    off_leaf: Option<f64>,
    one_step: Option<f64>,
    step_error: f64,
    energy_error: f64,
    hamiltonian_error: Option<f64>,
    largest_leverage: f64,
    hamiltonian: String,
    further: Option<String>,
    functions: Vec<FunctionJson>,
    warnings: Vec<String>,
    /// The scene whose map was learned.
    text: String,
}

#[derive(Serialize)]
struct DegreeJson {
    degree: usize,
    error: f64,
}

#[derive(Serialize)]
struct FunctionJson {
    function: String,
    generating: f64,
    hamiltonian: f64,
    error: f64,
}

/// Learns and prints what was learned; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid, or nothing is learned from the pairs.
pub fn execute(
    arguments: &LearnArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let shown = console.shown(false);
    let base = arguments.scene.scene.parent();
    let base = base.unwrap_or(std::path::Path::new(".")).to_owned();
    refuse_noise(&document, "no map is learned", "take the noise out")?;
    let (document, run) = with_chart(&mut parts, &document, &base, shown)?;
    let Some(method) = run.method.written() else {
        return Err(Failure::usage(
            "a lattice that is not written out has no map to learn",
            "shorten it",
        ));
    };
    if run.extension.is_some() || run.plan.coordinates != run.system.dimension() {
        return Err(Failure::usage(
            "a system whose Hamiltonian or bracket names the time, or parameters of sites, has no map of its states alone to learn",
            "give a scene without them",
        ));
    }
    let names = run.system.variables().to_vec();
    let (epsilon, h) = (run.plan.epsilon, run.plan.h);
    let table = read_pairs(&arguments.pairs, &names, epsilon * h).map_err(unread)?;
    let weights = match &arguments.weights {
        Some(file) => Some(read_weights(file).map_err(unread)?),
        None => table.weights,
    };
    let axes = axes(arguments, &run, &names)?;
    let options = LearnOptions {
        axes,
        degree: arguments.degree.map(usize::from),
        ridge: arguments.ridge,
        has_noise: arguments.noisy,
    };
    let pairs = StatePairs::new(names.len(), &table.before, &table.after, weights.as_deref());
    let pairs = pairs.map_err(refused)?;
    let realization = method.shared_realization();
    let learned = while_building(shown, || {
        learn(&run.system, &realization, (epsilon, h), &pairs, &options)
    });
    let mut learned = learned.map_err(refused)?;
    let text = learned_scene(&document, &run, &learned)?;
    let written = parts.document(
        SceneText {
            name: document.name.clone(),
            text: text.clone(),
            overrides: Vec::new(),
        },
        &base,
    )?;
    let composed = while_building(shown, || compose(&written, &parts.registry))?;
    let mut warnings: Vec<String> = learned.advice.iter().map(ToString::to_string).collect();
    warnings.extend(far(&mut learned, &composed));
    let is_poor = learned.advice.iter().any(|advice| {
        matches!(
            advice,
            LearnAdvice::Unexplained { .. } | LearnAdvice::OffLeaf { .. }
        )
    });
    if arguments.json {
        console.json(&json(
            &learned,
            epsilon * h,
            &warnings,
            text.clone(),
            is_poor,
        ));
    } else {
        for line in lines(&learned) {
            console.result(&line);
        }
        for warning in &warnings {
            let word = console.warning_word();
            console.prose(&format!("{word} {warning}"));
        }
    }
    if let Some(file) = &arguments.out {
        write_scene(file, &text, console)?;
    }
    Ok(match is_poor {
        true => exit::CHECK_FAILED,
        false => exit::DONE,
    })
}

/// The scene over a realization with a chart: its own where it names one, else the one that fits the tensor.
fn with_chart(
    parts: &mut Parts,
    document: &SceneDocument,
    base: &std::path::Path,
    shown: Shown,
) -> Result<(SceneDocument, ComposedRun), Failure> {
    let run = while_building(shown, || compose(document, &parts.registry))?;
    if run.system.has_forces() {
        return Err(Failure::usage(
            "a motion with forces is the flow of no Hamiltonian, and no generating function makes it",
            "take the forces out of the scene, and out of the data",
        ));
    }
    let own = run.method.written().filter(|method| {
        let abilities = method.realization().abilities();
        abilities.ends.is_some() && abilities.lift.is_none()
    });
    let named = MethodTable::of_choices(&run.plan.parts).and_then(|table| match table.parts {
        MethodParts::Pair { realization, .. } if own.is_some() => Some(realization),
        _ => None,
    });
    let realization = named.unwrap_or_else(|| PartUse::named("auto"));
    let table = MethodTable::pair(realization, PartUse::named(DYNAMICS).with("order", 2_i64));
    let text = table.write_into(
        &document.text,
        run.plan.epsilon * run.plan.h,
        run.plan.steps,
    );
    let text = text.map_err(unwritten)?;
    let document = parts.document(
        SceneText {
            name: document.name.clone(),
            text,
            overrides: Vec::new(),
        },
        base,
    )?;
    let run = while_building(shown, || compose(&document, &parts.registry))?;
    Ok((document, run))
}

/// The scene of the learned map: H, and Ŝ by S_1 = H and what is beside it.
fn learned_scene(
    document: &SceneDocument,
    run: &ComposedRun,
    learned: &Learned,
) -> Result<String, Failure> {
    let text = match with_hamiltonian(&document.text, &learned.hamiltonian).map_err(unwritten)? {
        Some(text) => text,
        None => {
            let system = run.system.formulas("learning")?;
            let fragment = with_hamiltonian(&system.fragment(), &learned.hamiltonian);
            let fragment = fragment.map_err(unwritten)?.unwrap_or_default();
            with_system(&document.text, &fragment).map_err(unwritten)?
        }
    };
    let coefficients: Vec<&str> = std::iter::once("H")
        .chain(learned.further.as_deref())
        .collect();
    let mut table = MethodTable::of_choices(&run.plan.parts)
        .ok_or_else(|| Failure::usage("a stepper has no map to learn", "name a realization"))?;
    if let MethodParts::Pair { dynamics, .. } = &mut table.parts {
        *dynamics = PartUse::named(DYNAMICS)
            .with("S", coefficients.join("; ").as_str())
            .with("order", 2_i64);
    }
    table
        .write_into(&text, run.plan.epsilon * run.plan.h, run.plan.steps)
        .map_err(unwritten)
}

/// Where the learned map leaves the states of the pairs, from the scene's initial state on.
fn far(learned: &mut Learned, run: &ComposedRun) -> Option<String> {
    let steps = run.plan.steps.min(MOST_STEPS);
    let parameters = run.system.parameter_values();
    let (epsilon, h) = (run.plan.epsilon, run.plan.h);
    let mut walk = Walk::new(run.method.map(), &parameters, epsilon, h, &run.plan.initial);
    let most = FAR * learned.largest_leverage.max(f64::MIN_POSITIVE);
    let mut first = (learned.leverage(walk.state()) > most).then_some(0);
    let ended = walk.watch(steps, |walk| {
        if first.is_none() && learned.leverage(walk.state()) > most {
            first = Some(walk.steps());
        }
    });
    let told = match (first, ended) {
        (Some(0), _) => "the scene's initial state is".to_owned(),
        (Some(step), _) => format!("from the scene's initial state on, step {step} is"),
        (None, Err(error)) => {
            return Some(format!(
                "the learned map ends after {} steps from the scene's initial state: {error}",
                walk.steps()
            ));
        }
        (None, Ok(())) => return None,
    };
    Some(format!(
        "{told} far from the pairs, where the learned map extrapolates: its leverage is above {FAR} times the largest of a pair; give pairs from there, or a lower degree"
    ))
}

/// The basis of every variable: `--basis [VARIABLE=]FAMILY[:PERIOD][+ln]`.
fn axes(
    arguments: &LearnArguments,
    run: &ComposedRun,
    names: &[String],
) -> Result<Vec<BasisAxis>, Failure> {
    let is_log_canonical = tensor_shape(&run.system) == TensorShape::LogCanonical;
    let default = BasisAxis {
        family: FunctionFamily::Polynomial,
        has_logarithm: is_log_canonical,
    };
    let mut axes = vec![default; names.len()];
    for given in &arguments.basis {
        let (places, family) = match given.split_once('=') {
            None => (0..names.len(), given.as_str()),
            Some((name, family)) => {
                let at = names.iter().position(|known| known == name.trim());
                let at = at.ok_or_else(|| {
                    Failure::usage(
                        format!(
                            "--basis {given}: the scene has no variable `{}`",
                            name.trim()
                        ),
                        format!("name one of {}", names.join(", ")),
                    )
                })?;
                (at..at + 1, family)
            }
        };
        let unknown = || {
            Failure::usage(
                format!("--basis {given} is no basis"),
                "write polynomial, exponential, fourier, fourier:PERIOD, or with logarithms polynomial+ln; for one variable q=fourier",
            )
        };
        let (family, has_logarithm) = match family.trim().strip_suffix("+ln") {
            Some(family) => (family, true),
            None => (family.trim(), false),
        };
        let family = match family.split_once(':') {
            Some(("fourier", period)) => FunctionFamily::Fourier {
                period: period.parse().map_err(|_| unknown())?,
            },
            None if family == "polynomial" => FunctionFamily::Polynomial,
            None if family == "exponential" => FunctionFamily::Exponential,
            None if family == "fourier" => FunctionFamily::Fourier {
                period: std::f64::consts::TAU,
            },
            _ => return Err(unknown()),
        };
        for at in places {
            axes[at] = BasisAxis {
                family,
                has_logarithm,
            };
        }
    }
    Ok(axes)
}

fn unread(reason: String) -> Failure {
    Failure::usage(reason, "`leafwise explain learn` shows files of pairs")
}

fn unwritten(error: leafwise::scene::RewriteError) -> Failure {
    Failure::usage(
        error.to_string(),
        "name a scene with [system], [method] and [run]",
    )
}

fn refused(error: LearnError) -> Failure {
    match error {
        LearnError::Build(error) => error.into(),
        error => Failure::usage(
            error.to_string(),
            "`leafwise explain learn` says what is learned from pairs",
        ),
    }
}

fn json(
    learned: &Learned,
    time_step: f64,
    warnings: &[String],
    text: String,
    is_poor: bool,
) -> LearnJson {
    LearnJson {
        outcome: if is_poor { "poor" } else { "learned" },
        degree: learned.degree,
        degrees: (learned.degrees.iter())
            .map(|&(degree, error)| DegreeJson { degree, error })
            .collect(),
        pairs: learned.pairs,
        equations: learned.equations,
        determined: learned.determined,
        time_step,
        motion: learned.motion,
        residual: learned.residual,
        noise: learned.noise,
        off_leaf: learned.off_leaf,
        one_step: learned.one_step,
        step_error: learned.step_error,
        energy_error: learned.energy_error,
        hamiltonian_error: learned.hamiltonian_error,
        largest_leverage: learned.largest_leverage,
        hamiltonian: learned.hamiltonian.clone(),
        further: learned.further.clone(),
        functions: (learned.functions.iter())
            .map(|own| FunctionJson {
                function: own.formula.clone(),
                generating: own.generating,
                hamiltonian: own.hamiltonian,
                error: own.error,
            })
            .collect(),
        warnings: warnings.to_vec(),
        text,
    }
}

fn lines(learned: &Learned) -> Vec<String> {
    let mut lines = vec![
        format!(
            "Degree {}: {} functions, {} of them determined by {} equations from {} pairs",
            learned.degree,
            learned.functions.len(),
            learned.determined,
            learned.equations,
            learned.pairs
        ),
        String::new(),
    ];
    let row = |name: &str, value: f64, meaning: &str| {
        vec![
            format!("  {name}"),
            format!("{value:.1e}"),
            meaning.to_owned(),
        ]
    };
    let mut rows = vec![
        row("motion", learned.motion, "x' - x, root mean square"),
        row(
            "residual",
            learned.residual,
            "what is left of it along leaves",
        ),
    ];
    if let Some(off) = learned.off_leaf {
        rows.push(row(
            "off leaves",
            off,
            "the part of it that no Hamiltonian makes",
        ));
    }
    rows.push(row(
        "step error",
        learned.step_error,
        "standard error of a learned step, by the residuals",
    ));
    rows.push(row(
        "energy error",
        learned.energy_error,
        "standard error of H less its mean, over the pairs",
    ));
    if let Some(error) = learned.hamiltonian_error {
        rows.push(row(
            "flow of H",
            error,
            "part of the learned map's velocity that H does not make",
        ));
    }
    lines.extend(words(&rows));
    if !learned.degrees.is_empty() {
        lines.push(String::new());
        lines.push("Degrees by pairs that were held out:".to_owned());
        let rows: Vec<Vec<String>> = (learned.degrees.iter())
            .map(|(degree, error)| vec![format!("  {degree}"), format!("{error:.1e}")])
            .collect();
        lines.extend(words(&rows));
    }
    lines.push(String::new());
    lines.push("H, largest coefficients first:".to_owned());
    let mut functions: Vec<_> = learned.functions.iter().collect();
    functions.sort_by(|a, b| b.hamiltonian.abs().total_cmp(&a.hamiltonian.abs()));
    let rows: Vec<Vec<String>> = (functions.iter().take(MOST_ROWS))
        .map(|own| {
            vec![
                format!("  {}", own.formula),
                format!("{:.10}", own.hamiltonian),
                format!("± {:.1e}", own.error),
            ]
        })
        .collect();
    lines.extend(words(&rows));
    if functions.len() > MOST_ROWS {
        lines.push(format!("  … and {} more", functions.len() - MOST_ROWS));
    }
    lines
}

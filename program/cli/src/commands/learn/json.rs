//! The JSON of `learn`.

use leafwise::learn::Learned;
use serde::Serialize;

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

/// The learned map as an object.
pub(super) fn json(
    learned: &Learned,
    time_step: f64,
    warnings: &[String],
    text: String,
    is_poor: bool,
) -> impl Serialize + use<> {
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

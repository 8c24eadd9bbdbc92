//! What the benches share: scenes from text, composed; code by hand.

pub mod rotations;

use std::path::Path;

use leafwise::core::Registry;
use leafwise::run::RunOptions;
use leafwise::scene::{ComposedRun, SceneDocument, compose};

/// A scene of a library system with its default start, Karasev n and Hamilton–Jacobi m.
pub fn scene(library: &str, initial: &str, n: usize, m: usize, time_step: f64) -> String {
    let realization = format!("{{ name = \"karasev-truncated\", order = {n} }}");
    scene_with(library, initial, &realization, m, time_step)
}

/// A scene of a library system with its default start, any realization and Hamilton–Jacobi m.
pub fn scene_with(
    library: &str,
    initial: &str,
    realization: &str,
    m: usize,
    time_step: f64,
) -> String {
    let dynamics = format!("{{ name = \"hamilton-jacobi\", order = {m} }}");
    scene_of(library, initial, realization, &dynamics, time_step)
}

/// The same with any dynamics.
pub fn scene_of(
    library: &str,
    initial: &str,
    realization: &str,
    dynamics: &str,
    time_step: f64,
) -> String {
    format!(
        "[system]\nlibrary = \"{library}\"\n\
         [method]\n\
         realization = {realization}\n\
         dynamics = {dynamics}\n\
         time-step = {time_step}\n\
         [run]\ninitial = {initial}\nsteps = 1\n"
    )
}

/// The Volterra lattice on a ring of `sites` sites, n = m = 2.
pub fn lattice_scene(sites: usize) -> String {
    scene(
        "volterra-lattice",
        "{ \"x[i]\" = \"1 + 0.1*sin(2*pi*i/N)\" }",
        2,
        2,
        0.1,
    )
    .replace(
        "\"volterra-lattice\"",
        &format!("\"volterra-lattice\"\nfamilies = {{ x = {sites} }}"),
    )
}

/// The rigid body of the paper from (1, 3, 3).
pub const RIGID_BODY: (&str, &str) = ("rigid-body", "[1, 3, 3]");

/// The heavy top from a generic state.
pub const HEAVY_TOP: (&str, &str) = ("heavy-top", "[0.5, -0.4, 1.2, 0.6, 0.0, 0.8]");

/// The bounded Lotka–Volterra system of Cohen and Hairer.
pub const PERIODIC_LOTKA_VOLTERRA: (&str, &str) = ("lotka-volterra-periodic", "[1, 1.9, 0.5]");

/// Composes a scene.
///
/// # Panics
/// When the scene is not valid: a defect of the bench.
pub fn composed(text: &str) -> ComposedRun {
    let document =
        SceneDocument::parse("bench.toml", text, &Registry::with_builtin()).expect("a scene");
    compose(&document, &Registry::with_builtin()).expect("a method")
}

/// A run or an ensemble into a directory, whatever is there.
pub fn options(directory: &Path) -> RunOptions {
    RunOptions {
        force: true,
        ..RunOptions::within(directory)
    }
}

/// A method whose step is compared with formulas written out as Rust.
pub struct StepCase {
    /// The name of the type that holds the formulas.
    pub formulas: &'static str,
    /// System and start.
    pub problem: (&'static str, &'static str),
    /// An exact realization.
    pub realization: &'static str,
    /// The order of Hamilton–Jacobi.
    pub order: usize,
    /// εh.
    pub time_step: f64,
}

/// The methods that are compared so.
pub const STEP_CASES: [StepCase; 9] = [
    rigid_body("RigidBody2", 2),
    rigid_body("RigidBody4", 4),
    rigid_body("RigidBody8", 8),
    lotka_volterra("LotkaVolterra2", 2),
    lotka_volterra("LotkaVolterra4", 4),
    lotka_volterra("LotkaVolterra8", 8),
    heavy_top("HeavyTop2", 2),
    heavy_top("HeavyTop4", 4),
    heavy_top("HeavyTop8", 8),
];

const fn rigid_body(formulas: &'static str, order: usize) -> StepCase {
    StepCase {
        formulas,
        problem: RIGID_BODY,
        realization: "so3-exponential",
        order,
        time_step: 0.1,
    }
}

const fn lotka_volterra(formulas: &'static str, order: usize) -> StepCase {
    StepCase {
        formulas,
        problem: PERIODIC_LOTKA_VOLTERRA,
        realization: "log-canonical",
        order,
        time_step: 0.05,
    }
}

const fn heavy_top(formulas: &'static str, order: usize) -> StepCase {
    StepCase {
        formulas,
        problem: HEAVY_TOP,
        realization: "lie-poisson",
        order,
        time_step: 0.05,
    }
}

impl StepCase {
    /// The scene, composed.
    pub fn composed(&self) -> ComposedRun {
        let realization = format!("{{ name = \"{}\" }}", self.realization);
        let (library, initial) = self.problem;
        composed(&scene_with(
            library,
            initial,
            &realization,
            self.order,
            self.time_step,
        ))
    }
}

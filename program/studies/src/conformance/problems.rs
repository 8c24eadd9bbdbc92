//! Problems on which parts are tried: systems of the library, systems written here, and those of plugins.

use leafwise_core::part::Family;
use leafwise_core::registry::SystemPart;
use leafwise_core::{
    BuildError, Evaluator, PartKind, PartParameters, PoissonSystem, Registry, StepError, Walk,
};
use leafwise_scene::SceneDocument;

use crate::verify::Problem;

/// Systems of the library: linear, log-canonical, nonlinear, with a magnetic field, of dimension 6.
const LIBRARY: [&str; 5] = [
    "rigid-body",
    "lotka-volterra-periodic",
    "gradient",
    "magnetic",
    "heavy-top",
];

/// Canonical systems, a pendulum and Hénon and Heiles', and a spin that drives an oscillator, a direct sum. Two spins with
/// exchange, and a body with damping and a force are for parts that take them.
const WRITTEN: [(&str, &str); 5] = [
    (
        "pendulum",
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"-1\" }\n\
         hamiltonian = \"p^2/2 - cos(q)\"\n[method]\ntime-step = 0.1\n\
         [run]\ninitial = [1.0, 0.5]\nsteps = 1\n",
    ),
    (
        "Henon-Heiles",
        "[system]\nvariables = [\"q1\", \"q2\", \"p1\", \"p2\"]\n\
         bracket = { \"q1,p1\" = \"-1\", \"q2,p2\" = \"-1\" }\n\
         hamiltonian = \"(p1^2 + p2^2 + q1^2 + q2^2)/2 + q1^2*q2 - q2^3/3\"\n\
         [method]\ntime-step = 0.1\n[run]\ninitial = [0.3, 0.1, -0.2, 0.25]\nsteps = 1\n",
    ),
    (
        "spin and oscillator",
        "[system]\nvariables = [\"x\", \"y\", \"z\", \"q\", \"p\"]\n\
         bracket = { \"x,y\" = \"-z\", \"y,z\" = \"-x\", \"z,x\" = \"-y\", \"q,p\" = \"-1\" }\n\
         hamiltonian = \"x^2/2 + y^2/3 + z^2/4 + (p^2 + q^2)/2 + q*x/5\"\n\
         casimirs = { spin = \"x^2 + y^2 + z^2\" }\n\
         [method]\ntime-step = 0.1\n[run]\ninitial = [0.6, -0.3, 0.7, 0.4, 0.2]\nsteps = 1\n",
    ),
    (
        "two spins",
        "[system]\nvariables = [\"x1\", \"y1\", \"z1\", \"x2\", \"y2\", \"z2\"]\n\
         bracket = { \"x1,y1\" = \"-z1\", \"y1,z1\" = \"-x1\", \"z1,x1\" = \"-y1\", \
         \"x2,y2\" = \"-z2\", \"y2,z2\" = \"-x2\", \"z2,x2\" = \"-y2\" }\n\
         hamiltonian = \"-x1*x2 - y1*y2/2 - z1*z2/3 - z1/4 + x2/5\"\n\
         casimirs = { first = \"x1^2 + y1^2 + z1^2\", second = \"x2^2 + y2^2 + z2^2\" }\n\
         [method]\ntime-step = 0.1\n[run]\ninitial = [0.6, -0.3, 0.7, 0.1, 0.8, -0.5]\nsteps = 1\n",
    ),
    (
        "damped body",
        "[system]\nvariables = [\"x\", \"y\", \"z\"]\n\
         bracket = { \"x,y\" = \"-z\", \"y,z\" = \"-x\", \"z,x\" = \"-y\" }\n\
         hamiltonian = \"x^2/2 + y^2/3 + z^2/4\"\ncasimirs = { spin = \"x^2 + y^2 + z^2\" }\n\
         forces = [\"y/5\", \"0\", \"0\"]\ndamping = { rate = \"0.2\" }\n\
         [method]\ntime-step = 0.1\n[run]\ninitial = [0.6, -0.3, 0.7]\nsteps = 1\n",
    ),
];

/// The problems of the library, and those of plugins.
pub(super) fn all(registry: &Registry) -> Vec<Problem> {
    let written = WRITTEN.into_iter().map(|(name, text)| {
        let document =
            SceneDocument::parse(name, text, &Registry::empty()).expect("a scene of this file");
        Problem::of_scene(&document).expect("a system of this file")
    });
    let library = LIBRARY
        .into_iter()
        .map(|id| Problem::of_library(id).expect("a system of the library"));
    library.chain(written).chain(of_plugins(registry)).collect()
}

/// The systems that plugins added to the registry.
pub(super) fn of_plugins(registry: &Registry) -> Vec<Problem> {
    let systems = registry.parts().into_iter();
    systems
        .filter(|info| info.kind == PartKind::System && !info.paths.is_empty())
        .filter_map(|info| registry.system(info.name).ok())
        .filter_map(|part| of_part(&part, &PartParameters::new()).ok()?)
        .collect()
}

/// The system of a part at a state of its domain, `None` where no state tried is one.
///
/// # Errors
/// [`BuildError`] of the part.
pub(super) fn of_part(
    part: &SystemPart,
    parameters: &PartParameters,
) -> Result<Option<Problem>, BuildError> {
    let system = part.build(parameters)?;
    let found = states(system.dimension()).into_iter().find_map(|initial| {
        let time_step = time_step(&system, &initial).ok()?;
        Some((initial, time_step))
    });
    Ok(found.map(|(initial, time_step)| Problem {
        own: None,
        name: part.info.name.to_owned(),
        system,
        initial,
        time_step,
    }))
}

/// Steps of an orbit, and states of it that are looked at: a part may be right at its first state and wrong elsewhere.
const ORBIT: u64 = 512;
const STATES: u64 = 16;

/// States along an orbit of the problem, by a method that needs no part but the field.
pub(super) fn along(registry: &Registry, problem: &Problem) -> Vec<Vec<f64>> {
    let mut states = vec![problem.initial.clone()];
    let reference = registry.reference(Family::Explicit);
    let map = reference.and_then(|(part, given)| part.build(&problem.system, &given));
    let Ok(map) = map else {
        return states;
    };
    let values = problem.system.parameter_values();
    let (t, initial) = (problem.time_step, &problem.initial);
    let mut walk = Walk::new(map.as_ref(), &values, 1.0, t, initial);
    for _ in 0..STATES {
        if walk.advance(ORBIT / STATES).is_err() {
            break;
        }
        states.push(walk.state().to_vec());
    }
    states
}

/// States that most domains contain: positive and all different, then of both signs, then small.
fn states(d: usize) -> Vec<Vec<f64>> {
    let state = |size: f64, step: f64, sign: f64| -> Vec<f64> {
        let at = |i: usize| size + step * (i % 8) as f64 + (i / 8) as f64 / 64.0;
        let signed = |i: usize| {
            if i.is_multiple_of(2) {
                at(i)
            } else {
                sign * at(i)
            }
        };
        (0..d).map(signed).collect()
    };
    vec![
        state(0.75, 0.25, 1.0),
        state(1.125, -0.0625, 1.0),
        state(0.75, 0.25, -1.0),
        state(0.0625, 0.015625, 1.0),
    ]
}

/// How far a state moves in a problem's step, relative to itself.
const MOVE: f64 = 0.05;

/// A power of two in which a state moves by about a twentieth of itself; an eighth where it rests.
fn time_step(system: &PoissonSystem, initial: &[f64]) -> Result<f64, StepError> {
    const MOST: f64 = 0.125;
    let Ok(field) = system.field_values() else {
        return Ok(MOST);
    };
    let mut velocity = vec![0.0; initial.len()];
    field
        .evaluator(&system.parameter_values(), 1.0, 1.0)
        .values(initial, &mut velocity)?;
    if velocity.iter().any(|v| !v.is_finite()) {
        return Err(StepError::NonFinite {
            what: "the vector field",
        });
    }
    let length = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>();
    let speed = libm::sqrt(length(&velocity) / length(initial));
    let exponent = libm::floor(libm::log2(MOVE / speed));
    Ok(if exponent.is_finite() {
        libm::exp2(exponent).min(MOST)
    } else {
        MOST
    })
}

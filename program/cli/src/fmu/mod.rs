//! Functional mock-up units of scenes, FMI 3.0 for co-simulation: what is in one, and its archive.
//!
//! - [`Variable`]: the variables of a unit, with their numbers.
//! - `description`: `modelDescription.xml`.
//! - [`Archive`]: a ZIP file of stored entries.
//!
//! The unit's library is `libleafwise_c`, which reads the scene from the unit's resources.

mod archive;
mod description;

use leafwise::scene::compose::ComposedRun;
use sha2::{Digest, Sha256};

pub use archive::Archive;
pub use description::description;

/// The identifier of the library in a unit.
pub const IDENTIFIER: &str = "leafwise_c";

/// The scene's name within the resources of a unit.
pub const SCENE: &str = "scene.toml";

/// The role of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The time.
    Time,
    /// A parameter of the system, by its place.
    Parameter(usize),
    /// A coordinate, by its place: its initial value may be set.
    Coordinate(usize),
    /// Energy, then Casimirs, by their place.
    Invariant(usize),
}

/// A variable of a unit; its number is its place among [all](variables).
#[derive(Clone, Debug)]
pub struct Variable {
    /// The name, no other's.
    pub name: String,
    /// Its role.
    pub role: Role,
    /// Its value at the start, where it may be set.
    pub start: Option<f64>,
}

/// The variables of a run's unit: the time, parameters, coordinates, the energy and Casimirs.
pub fn variables(run: &ComposedRun) -> Vec<Variable> {
    let mut all: Vec<Variable> = Vec::new();
    let mut add = |name: &str, role: Role, start: Option<f64>| {
        let mut own = name.to_owned();
        while all.iter().any(|other| other.name == own) {
            own.push('\'');
        }
        all.push(Variable {
            name: own,
            role,
            start,
        });
    };
    add("time", Role::Time, None);
    let values = run.system.parameter_values();
    for (at, (parameter, value)) in run.system.parameters().iter().zip(values).enumerate() {
        add(&parameter.name, Role::Parameter(at), Some(value));
    }
    let initial = run.own(&run.plan.initial);
    for (at, (name, value)) in run.names().iter().zip(initial).enumerate() {
        add(name, Role::Coordinate(at), Some(*value));
    }
    add("energy", Role::Invariant(0), None);
    for (at, name) in run.system.casimir_names().into_iter().enumerate() {
        add(name, Role::Invariant(at + 1), None);
    }
    all
}

/// The token that a unit's description and its library have in common: a digest of the scene's text.
pub fn token(scene: &str) -> String {
    let digest = Sha256::digest(scene.as_bytes());
    let mut token: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    token.truncate(32);
    format!("{{{token}}}")
}

//! The scene's text as typed sections, every value with its place in the text.
//!
//! - `located`: values that remember where they were written;
//! - `system`, `bracket`, `method`, `run`, `ensemble`, `sweep`, `plugin`: one table or list of the scene each;
//! - `canonical`: pairs of a coordinate and its momentum, the bracket of a word;
//! - `system_section`: the contents of `[system]`, read from the scene, a library or a system without formulas;
//! - `equations`: equations of motion, whose bracket is found;
//! - `forces`: forces that move the system beside its Hamiltonian;
//! - `noise`: channels that move it at random;
//! - `variables`: single variables, and vectors of them;
//! - `families`: lengths of axes and ends of a lattice;
//! - `field`: values that variables, sites of families and parameters of sites begin with;
//! - `site_names`: names of the sites of a chain;
//! - `numbers`: systems that have no formulas;
//! - `method_table`: a method as a value, written into a scene's text;
//! - `overrides`: `--set path=value`, applied by rewriting the text;
//! - `assign`: values that no part is made of, set without reading the text again;
//! - `schema`: every key that a scene may have, with the shape of its value;
//! - `json_schema`, `key_tables`: the same for editors, and for the guide;
//! - `faults`: values with one fault each, from the shape of every key;
//! - `contradictions`: keys of different tables that do not stand beside one another;
//! - `error`, `suggest`: the errors of the text, and the nearest valid name;
//! - `reader`: typed access to parsed TOML.

mod assign;
mod bracket;
mod canonical;
mod contradictions;
mod ensemble;
mod equations;
mod error;
mod families;
mod faults;
mod field;
mod forces;
mod json_schema;
mod key_tables;
mod lie_algebra;
mod located;
mod matrices;
mod method;
mod method_table;
mod noise;
mod numbers;
mod observable;
mod overrides;
mod plugin;
mod reader;
mod run;
mod scene;
mod schema;
mod shape;
mod site_names;
mod slips;
mod suggest;
mod sweep;
mod system;
mod system_checks;
mod system_schema;
mod system_section;
mod tables;
#[cfg(test)]
mod tests;
mod variables;
mod vector_formulas;

pub use bracket::{BracketSpec, SummandSpec};
pub(crate) use canonical::is_pair;
pub use ensemble::{Distribution, EnsembleSection, FinalStates, InitialDraw, ParameterDraw};
pub(crate) use equations::{asking_for_casimirs, no_casimirs};
pub use equations::{equations_of, with_casimirs, with_hamiltonian, with_plain_run, with_system};
pub use error::{ConstantNames, SceneErrors, SceneProblem, SceneProblemCause};
pub use families::DENSE_LIMIT;
pub use faults::{Fault, faults};
pub use field::FieldSpec;
pub use forces::{ByCoordinate, ComponentsSpec, DampingSpec, ForcesSpec, MetricSpec, TorqueSpec};
pub use json_schema::json_schema;
pub use key_tables::key_tables;
pub use lie_algebra::{AlgebraSpec, LieAlgebraSpec, Matrix, StructureConstant};
pub use located::{Located, Number, Place, Source};
pub use matrices::{MatrixNumbers, MatrixSpec};
pub use method::{MethodSection, ParameterValue, PartSpec, StepSpec};
pub use method_table::{MethodParts, MethodTable, PartUse, RewriteError};
pub use noise::NoiseSpec;
pub use observable::ObservableSpec;
pub use plugin::PluginSpec;
pub use run::ALL_STATES;
pub use run::{InitialSpec, RecordSpec, RunSection, SectionSpec};
pub use scene::SceneDocument;
pub use schema::{CHOSEN_AT, scene_keys};
pub use suggest::nearest;
pub use sweep::{
    MOST_SETTINGS, SettingsSpec, SweepSection, SweptDirection, SweptKey, SweptRow, conflict,
    refuse_key,
};
pub use system_section::{Boundary, Convention, NumbersSystem, SystemSection, VectorFamily};
pub use tables::TableSpec;

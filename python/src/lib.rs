//! The Python package `leafwise`: scenes, runs as arrays, and the program's commands.
//!
//! - [`scene`]: scenes, composed and stepped without the interpreter's lock;
//! - [`read`]: scenes as read, composed and checked;
//! - [`recorded`]: results of a run, as arrays;
//! - [`ensemble`]: results of an ensemble, as arrays;
//! - [`sweep`]: results of a sweep;
//! - [`functions`]: a system whose values functions of Python compute;
//! - [`progress`]: progress of a run as a function of Python sees it, and its interruption;
//! - [`kept`]: a composed scene that is kept for others with the same method;
//! - [`retraced`]: the states of a run at any times;
//! - [`integrator`]: one trajectory, step by step;
//! - [`gradient`]: trajectories with their derivatives;
//! - [`command`]: the program, in this process;
//! - [`text`]: tables of Python as text of a scene;
//! - [`error`]: the program's failures as exceptions.

mod arrays;
mod command;
mod ensemble;
mod error;
mod functions;
mod gradient;
mod integrator;
mod job;
mod kept;
mod progress;
mod read;
mod recorded;
mod retraced;
mod scene;
mod sweep;
mod text;

/// The compiled part of the package.
#[pyo3::pymodule]
mod _leafwise {
    #[pymodule_export]
    use super::command::{command, load_plugin, program, start_again_by, version};
    #[pymodule_export]
    use super::ensemble::Ensemble;
    #[pymodule_export]
    use super::error::{IntegrationError, LeafwiseError, SceneError};
    #[pymodule_export]
    use super::gradient::{Growth, Map};
    #[pymodule_export]
    use super::integrator::Integrator;
    #[pymodule_export]
    use super::kept::compositions;
    #[pymodule_export]
    use super::recorded::Recorded;
    #[pymodule_export]
    use super::retraced::Retraced;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::sweep::Sweep;
    #[pymodule_export]
    use super::text::{table_of_text, text_of, text_of_value};
}

//! Claims about ensembles.

mod events;
mod members;
mod refusals;
mod running;
mod shards;

use std::num::NonZeroUsize;
use std::path::Path;

use leafwise_core::Registry;
use leafwise_hamilton_jacobi as _;
use leafwise_karasev as _;
use leafwise_reference as _;
use leafwise_splitting as _;

use super::*;
use crate::shards::{Portion, Shard};
use crate::{Progress, RunError, RunOptions, perform};
use leafwise_scene::document::SceneDocument;

const BODY: &str = r#"
[system]
variables   = ["x1", "x2", "x3"]
parameters  = { I1 = 1.0, I2 = 0.75, I3 = 1.25 }
bracket     = { "x1,x2" = "-x3", "x2,x3" = "-x1", "x3,x1" = "-x2" }
hamiltonian = "x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)"
casimirs    = { spin = "x1^2 + x2^2 + x3^2" }
[method]
METHOD
time-step   = 0.1
[run]
initial = [1, 3, 3]
steps   = 43
[ensemble]
ENSEMBLE
"#;

const METHODS: [&str; 3] = [
    "stepper = \"splitting\"",
    "realization = { name = \"karasev-truncated\", order = 4 }\n\
     dynamics = { name = \"hamilton-jacobi\", order = 2 }",
    "stepper = \"implicit-midpoint\"",
];

const ENSEMBLE: &str = "members = 60\nseed = 5\ninitial = { ball = 0.2 }\n\
    parameters = { I2 = { normal = [0.75, 0.01] }, I3 = { values = [1.25, 1.5, 2] } }\n\
    record = { every = 10, observables = [\"energy\", \"x1*x2\"], quantiles = [0.25, 0.5] }\n\
    final-states = \"csv\"";

fn scene(method: &str, ensemble: &str) -> SceneDocument {
    let text = BODY.replace("METHOD", method).replace("ENSEMBLE", ensemble);
    SceneDocument::parse("body.toml", &text, &Registry::empty()).expect("a scene")
}

fn composed(document: &SceneDocument) -> ComposedEnsemble {
    let registry = Registry::with_builtin();
    compose_ensemble(document, &registry, Path::new("")).expect("an ensemble")
}

fn workforce(threads: usize, lanes: usize) -> Workforce {
    let count = |n| NonZeroUsize::new(n).expect("positive");
    Workforce {
        threads: count(threads),
        lanes: count(lanes),
    }
}

fn options(directory: &Path) -> RunOptions {
    RunOptions {
        command: "leafwise ensemble body.toml".to_owned(),
        ..RunOptions::within(directory)
    }
}

fn attempt(
    document: &SceneDocument,
    directory: &Path,
    force: Workforce,
    progress: &mut dyn Progress,
) -> Result<EnsembleReport, RunError> {
    make(document, None, &options(directory), force, progress)
}

/// Makes an ensemble, or a shard of it.
fn make(
    document: &SceneDocument,
    shard: Option<&Shard>,
    options: &RunOptions,
    force: Workforce,
    progress: &mut dyn Progress,
) -> Result<EnsembleReport, RunError> {
    let (ensemble, portion) = (composed(document), Portion::computed(shard));
    let job = EnsembleJob::new(document, &ensemble, portion, options, force)?;
    perform(&job, progress)
}

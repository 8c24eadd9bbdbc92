//! `leafwise merge`: the shards of an ensemble or a sweep as one.

use std::num::NonZeroUsize;
use std::path::Path;

use leafwise::run::ensemble::{EnsembleJob, Workforce, advise_ensemble, compose_ensemble};
use leafwise::run::shards::{MergeError, Portion, Shards, Whole};
use leafwise::run::sweep::{Settings, SweepJob, compose_sweep};
use leafwise::run::{Quiet, perform};

use super::{ensemble, sweep};
use crate::arguments::{MergeArguments, PluginArguments, SceneArguments};
use crate::console::Console;
use crate::failure::Failure;
use crate::plugins::Parts;

impl From<MergeError> for Failure {
    fn from(error: MergeError) -> Self {
        match error {
            MergeError::Run(error) => error.into(),
            other => Self::Merge(Box::new(other)),
        }
    }
}

/// Joins the shards; returns the exit code.
///
/// # Errors
/// [`Failure`] where they do not fit together, or members are missing.
pub fn execute(
    arguments: &MergeArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let shards = Shards::find(&arguments.shards)?;
    let mut parts = Parts::new(plugins)?;
    let scene = arguments.scene.clone().unwrap_or_else(|| shards.scene());
    let mut document = parts.scene(&SceneArguments {
        scene: scene.clone(),
        overrides: Vec::new(),
    })?;
    if arguments.scene.is_some() {
        shards.check_scene(&document.text)?;
    } else {
        shards.scene_name().clone_into(&mut document.name);
    }
    let output = arguments.output;
    let command = format!("leafwise merge, of {} shards", shards.count());
    let options = output.options(arguments.out.clone(), command);
    if shards.whole() == Whole::Settings {
        let settings = Settings::of(&document)?;
        let allow = output.allow_non_poisson;
        let merged = compose_sweep(
            &document,
            &parts.registry,
            settings,
            0..0,
            allow,
            &mut |_, _| (),
        )?;
        let (portion, threads) = (Portion::merged(&shards)?, NonZeroUsize::MIN);
        let job = SweepJob::new(&document, &merged, portion, &options, threads);
        let report = perform(&job, &mut Quiet)?;
        return Ok(sweep::tell(&report, None, output, console));
    }
    let folder = scene.parent().unwrap_or(Path::new(""));
    let composed = compose_ensemble(&document, &parts.registry, folder)?;
    let (portion, workforce) = (Portion::merged(&shards)?, Workforce::default());
    let job = EnsembleJob::new(&document, &composed, portion, &options, workforce)?;
    let report = perform(&job, &mut Quiet)?;
    let mut advice = report.advice.clone();
    advice.extend(advise_ensemble(&composed, &parts.registry));
    ensemble::tell(
        (&composed, &parts.registry),
        &report,
        &advice,
        output,
        console,
    )
}

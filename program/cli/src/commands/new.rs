//! `leafwise new`: a commented scene file.

use std::path::PathBuf;

use leafwise::systems::{Defaults, PacedDefaults};

use crate::arguments::NewArguments;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files;

/// The scene that is written when no library system is asked for.
const TEMPLATE: &str = include_str!("new_scene.toml");

/// Writes the file; returns the exit code.
///
/// # Errors
/// [`Failure::Usage`] when the file exists or the library has no such system.
pub fn execute(arguments: &NewArguments, console: &mut Console<'_>) -> Result<u8, Failure> {
    let text = match &arguments.library {
        None => TEMPLATE.to_owned(),
        Some(id) => library_scene(id)?,
    };
    let default = arguments.library.as_ref().map_or_else(
        || "scene.toml".to_owned(),
        |id| format!("{}.toml", id.replace('-', "_")),
    );
    let mut file = arguments
        .file
        .clone()
        .unwrap_or_else(|| PathBuf::from(default));
    if file.extension().is_none() {
        file.set_extension("toml");
    }
    files::write_new(&file, &text, "name another file: leafwise new NAME")?;
    console.prose(&format!(
        "wrote {0}; `leafwise run {0}` integrates it",
        file.display()
    ));
    Ok(exit::DONE)
}

fn library_scene(id: &str) -> Result<String, Failure> {
    let Some(system) = leafwise::systems::find(id) else {
        let help = match leafwise::systems::nearest(id) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "`leafwise list systems` prints every name".to_owned(),
        };
        return Err(Failure::usage(
            format!("the library has no system `{id}`"),
            help,
        ));
    };
    let malformed =
        |error: leafwise::systems::SystemError| Failure::usage(error.to_string(), "report this");
    let about = system.about().map_err(malformed)?;
    let defaults = system.defaults().map_err(malformed)?;
    Ok(format!(
        "# {title}\n# {reference}\n# `leafwise describe {id}` shows its tensor, Hamiltonian and \
         Casimirs.\n\n[system]\nlibrary = \"{id}\"\n# parameters = {{ … }}   replaces the \
         library's values, by name\n\n[method]\n# The geometry: an exact closed form where the \
         tensor has one, collocation elsewhere.\nrealization = \"auto\"\n# The \
         dynamics, of even order.\ndynamics    = {{ name = \"hamilton-jacobi\", order = {order} }}\n\
         {steps}\n[run]\ninitial = {initial}\n{run}",
        title = about.title,
        reference = about.reference,
        order = if defaults.paced.is_some() { 8 } else { 4 },
        steps = steps(&defaults),
        initial = defaults.initial,
        run = run(&defaults),
    ))
}

/// The keys of `[method]` that say how long steps are.
fn steps(defaults: &Defaults) -> String {
    match &defaults.paced {
        None => format!(
            "# One step advances time by this much.\ntime-step   = {}\n",
            defaults.time_step
        ),
        Some(PacedDefaults {
            pace, time_step, ..
        }) => format!(
            "# dt/dtau: steps of t shorten where it is small, and stay exactly Poisson.\npace        = \
             \"{pace}\"\n# One step advances tau by this much.\ntime-step   = {time_step}\n"
        ),
    }
}

/// The keys of `[run]` behind the initial state.
fn run(defaults: &Defaults) -> String {
    match &defaults.paced {
        None => "steps   = 1000\n# What is written down, every how many steps; the largest drifts are taken over every step.\n\
                 record  = { every = 1 }\n"
            .to_owned(),
        Some(PacedDefaults {
            until, interval, ..
        }) => format!(
            "until   = {until}\n# What is written down, at which times; the largest drifts are taken over every step.\n\
             record  = {{ interval = {interval} }}\n"
        ),
    }
}

//! Reading a scene with its overrides.

use std::fs;

use leafwise::ProblemLibrary;
use leafwise::scene::SceneDocument;

use crate::arguments::SceneArguments;
use crate::failure::Failure;

/// Reads the scene that the command line names.
///
/// # Errors
/// [`Failure::File`] when the file cannot be read, [`Failure::Usage`] for an override without
/// `=`, [`Failure::Scene`] for everything wrong inside.
pub fn load(arguments: &SceneArguments) -> Result<SceneDocument, Failure> {
    let file = &arguments.scene;
    let text = fs::read_to_string(file).map_err(|source| {
        if source.kind() == std::io::ErrorKind::NotFound {
            return Failure::usage(
                format!("there is no file {}", file.display()),
                "`leafwise new` writes a scene to start from",
            );
        }
        Failure::File {
            action: "read",
            file: file.clone(),
            source,
        }
    })?;
    let mut overrides = Vec::with_capacity(arguments.overrides.len());
    for given in &arguments.overrides {
        let Some((path, value)) = given.split_once('=') else {
            return Err(Failure::usage(
                format!("--set {given} has no value"),
                "write --set key=value, as in --set method.epsilon=0.05",
            ));
        };
        overrides.push((path.trim().to_owned(), value.trim().to_owned()));
    }
    let name = file.display().to_string();
    SceneDocument::parse_with(&name, &text, &overrides, &ProblemLibrary)
        .map_err(|errors| Failure::Scene(errors.diagnostics()))
}

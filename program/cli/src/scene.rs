//! Reading a scene with its overrides.

use std::path::Path;
use std::string::FromUtf8Error;

use leafwise::expression::words::counted;
use leafwise::scene::input::{LARGEST_SCENE, read_bounded};
use leafwise::scene::{SceneDiagnostic, SceneDocument};

use crate::arguments::SceneArguments;
use crate::failure::Failure;

/// A scene file as it is, with the overrides of the command line.
pub struct SceneText {
    /// The file's name.
    pub name: String,
    /// Its text.
    pub text: String,
    /// Keys and values.
    pub overrides: Vec<(String, String)>,
}

impl SceneText {
    /// Another text under the name of a scene.
    pub fn again(document: &SceneDocument, text: String) -> Self {
        Self {
            name: document.name.clone(),
            text,
            overrides: Vec::new(),
        }
    }
}

/// Reads the file that the command line names.
///
/// # Errors
/// [`Failure::File`] when the file cannot be read, [`Failure::Usage`] for an override without
/// `=`, [`Failure::Scene`] for text in another encoding.
pub fn read(arguments: &SceneArguments) -> Result<SceneText, Failure> {
    let file = &arguments.scene;
    let bytes = read_bounded(file, LARGEST_SCENE).map_err(|source| {
        if source.kind() == std::io::ErrorKind::NotFound {
            return Failure::usage(
                format!("there is no file {}", file.display()),
                "`leafwise new` writes a scene to start from",
            );
        }
        if file.is_dir() {
            return Failure::usage(
                format!("{} is a folder", file.display()),
                scenes_within(file),
            );
        }
        Failure::File {
            action: "read",
            file: file.clone(),
            source,
        }
    })?;
    let text = String::from_utf8(bytes).map_err(|error| not_utf8(file, &error))?;
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
    Ok(SceneText {
        name: file.display().to_string(),
        text,
        overrides,
    })
}

/// Advice on what to name in place of a folder: a scene that it holds.
fn scenes_within(folder: &Path) -> String {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut scenes: Vec<_> = entries
        .map(|entry| entry.path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    scenes.sort();
    match scenes.first() {
        Some(first) => format!(
            "name one scene in it, as {}; it holds {} *.toml",
            first.display(),
            counted(scenes.len(), "file")
        ),
        None => "name a scene, a file *.toml; the folder holds none".to_owned(),
    }
}

/// A scene in another encoding, at the first byte that is not UTF-8.
fn not_utf8(file: &Path, error: &FromUtf8Error) -> Failure {
    let at = error.utf8_error().valid_up_to();
    Failure::Scene(vec![SceneDiagnostic {
        message: "the scene is not UTF-8 text".to_owned(),
        label: "the first byte that is not".to_owned(),
        source_name: file.display().to_string(),
        source_text: String::from_utf8_lossy(error.as_bytes()).into_owned(),
        span: at..at + char::REPLACEMENT_CHARACTER.len_utf8(),
        help: Some("save it in the encoding UTF-8".to_owned()),
    }])
}

//! Side files: descriptions of a library beside it, to be read without running its code.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::declaration::PluginDeclaration;
use crate::error::Refusal;

/// `acme.plugin.toml` beside `libacme.so` or `acme.so`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SideFile {
    /// The plugin's id.
    pub id: Option<String>,
    /// Its version.
    pub version: Option<String>,
    /// The SHA-256 of the library, in hexadecimal: another file is refused.
    pub sha256: Option<String>,
    /// Its parts.
    #[serde(default)]
    pub parts: Vec<SidePart>,
}

/// A part as a side file has it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SidePart {
    /// Its id.
    pub id: String,
    /// `system`, `realization`, `dynamics` or `step-map`.
    pub kind: String,
    /// A description of the part, in one line.
    pub summary: Option<String>,
}

/// A side file with more bytes is none.
const LONGEST: u64 = 1 << 20;

impl SideFile {
    /// Refuses a file that speaks of another plugin, or of another version of it.
    pub(crate) fn check(
        &self,
        library: &Path,
        declaration: &PluginDeclaration,
    ) -> Result<(), Refusal> {
        let pairs = [
            ("id", &self.id, &declaration.id),
            ("version", &self.version, &declaration.version),
        ];
        for (what, said, own) in pairs {
            if let Some(said) = said
                && said != own
            {
                return Err(Refusal::SideFile {
                    file: side_file_of(library).unwrap_or_default(),
                    message: format!("its {what} is `{said}`, and the library's `{own}`"),
                });
            }
        }
        Ok(())
    }
}

/// Where the side file of a library is.
pub fn side_file_of(library: &Path) -> Option<PathBuf> {
    let stem = library.file_stem()?.to_str()?;
    let name = stem
        .strip_prefix(std::env::consts::DLL_PREFIX)
        .unwrap_or(stem);
    Some(library.with_file_name(format!("{name}.plugin.toml")))
}

/// The side file of a library, `None` where there is none.
///
/// # Errors
/// [`Refusal::SideFile`] where it says something else than it may.
pub fn read(library: &Path) -> Result<Option<SideFile>, Refusal> {
    let Some(file) = side_file_of(library).filter(|file| file.exists()) else {
        return Ok(None);
    };
    let wrong = |message: String| Refusal::SideFile {
        file: file.clone(),
        message,
    };
    // A pipe would be waited for.
    let metadata = fs::metadata(&file).map_err(|error| wrong(error.to_string()))?;
    if !metadata.is_file() || metadata.len() > LONGEST {
        return Err(wrong(format!(
            "it is not a regular file of at most {LONGEST} bytes"
        )));
    }
    let text = fs::read_to_string(&file).map_err(|error| wrong(error.to_string()))?;
    toml::from_str(&text)
        .map(Some)
        .map_err(|error| wrong(error.message().to_owned()))
}

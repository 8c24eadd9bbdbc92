//! The folder of a job, and the scene that its checkpoints are of.

use std::ops::Deref;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::difference::meaning;
use super::manifest::Kind;
use super::subject::JobSubject;

/// SHA-256 of what a scene means: its keys and values in their order, the step, and the numbers that it reads from files.
/// The end of a run is left out, since a run may become longer.
pub(crate) type SceneDigest = [u8; 32];

/// A folder whose checkpoints are of one scene.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    scene: SceneDigest,
}

impl Folder {
    /// The folder of a job.
    pub(crate) fn of(path: &Path, subject: &JobSubject<'_>) -> Self {
        let mut digest = Sha256::new();
        let is_end =
            |key: &str| subject.kind == Kind::Run && ["run.steps", "run.until"].contains(&key);
        for (key, value) in meaning(&subject.document.text) {
            if !is_end(&key) {
                digest.update(format!("{key}\0{value}\0"));
            }
        }
        let plan = &subject.run.plan;
        for size in [plan.epsilon, plan.h] {
            digest.update(size.to_le_bytes());
        }
        if let Some(files) = &subject.files {
            digest.update(&files.sha256);
        }
        Self {
            path: path.to_owned(),
            scene: digest.finalize().into(),
        }
    }

    /// Another folder, of the same scene.
    pub(crate) fn beside(&self, path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            scene: self.scene,
        }
    }

    /// The digest of the scene.
    pub(crate) fn scene(&self) -> &SceneDigest {
        &self.scene
    }

    #[cfg(test)]
    pub(crate) fn of_no_scene(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            scene: [0; 32],
        }
    }
}

impl Deref for Folder {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.path
    }
}

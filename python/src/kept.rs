//! A composed scene that is kept for others which differ from it in values alone.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use leafwise::core::Registry;
use leafwise::scene::compose::Refusal;
use leafwise::scene::{self, ComposedRun, SceneDocument};
use pyo3::prelude::*;

/// Methods that were composed for runs in this process.
static COMPOSITIONS: AtomicU64 = AtomicU64::new(0);

/// The system and the method of a scene, counted.
///
/// # Errors
/// As [`scene::compose`].
pub(crate) fn compose(
    document: &SceneDocument,
    registry: &Registry,
) -> Result<ComposedRun, Refusal> {
    COMPOSITIONS.fetch_add(1, Ordering::Relaxed);
    scene::compose(document, registry)
}

/// How many methods were composed for runs in this process.
#[pyfunction]
pub(crate) fn compositions() -> u64 {
    COMPOSITIONS.load(Ordering::Relaxed)
}

/// Room for a composed scene with its text; clones share it.
#[derive(Clone, Default)]
pub(crate) struct Kept(Arc<Mutex<Option<Arc<Composed>>>>);

struct Composed {
    text: String,
    run: ComposedRun,
}

impl Kept {
    /// The kept run at the values of a document that differs from its own in values alone. It is composed first where
    /// there is none. The result is `None` where the method has to be composed for these values.
    ///
    /// # Errors
    /// Values that are none.
    pub fn at(
        &self,
        document: &SceneDocument,
        compose: impl FnOnce() -> Option<(String, ComposedRun)>,
    ) -> Result<Option<ComposedRun>, Refusal> {
        let Some(composed) = self.get().or_else(|| self.keep(compose()?)) else {
            return Ok(None);
        };
        if composed.text == document.text {
            return Ok(Some(composed.run.clone()));
        }
        composed.run.at(document)
    }

    fn get(&self) -> Option<Arc<Composed>> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    fn keep(&self, (text, run): (String, ComposedRun)) -> Option<Arc<Composed>> {
        let composed = Arc::new(Composed { text, run });
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&composed));
        Some(composed)
    }
}

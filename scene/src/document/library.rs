//! Where `library = "…"` is looked up.

use leafwise_core::registry::SystemPart;

/// A collection of named scene fragments, each a TOML text with a `[system]` table.
pub trait SceneLibrary {
    /// The text of the fragment with this id.
    fn fragment(&self, id: &str) -> Option<&str>;

    /// The system with this id as a part, where it can compute numbers without formulas.
    fn part(&self, id: &str) -> Option<&SystemPart> {
        let _ = id;
        None
    }

    /// All ids, for suggestions.
    fn ids(&self) -> Vec<&str>;
}

/// The empty library.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoLibrary;

impl SceneLibrary for NoLibrary {
    fn fragment(&self, _id: &str) -> Option<&str> {
        None
    }

    fn ids(&self) -> Vec<&str> {
        Vec::new()
    }
}

/// Pairs of id and text.
impl SceneLibrary for [(&str, &str)] {
    fn fragment(&self, id: &str) -> Option<&str> {
        self.iter()
            .find(|(name, _)| *name == id)
            .map(|(_, text)| *text)
    }

    fn ids(&self) -> Vec<&str> {
        self.iter().map(|(name, _)| *name).collect()
    }
}

/// Pairs of id and text.
impl<const N: usize> SceneLibrary for [(&str, &str); N] {
    fn fragment(&self, id: &str) -> Option<&str> {
        self.as_slice().fragment(id)
    }

    fn ids(&self) -> Vec<&str> {
        self.as_slice().ids()
    }
}

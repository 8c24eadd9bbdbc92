//! Values that remember where they were written.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// The name of the text that stands in the place of equations, as that of a library system.
pub(super) const FOUND: &str = "the bracket that was found";

/// The text a byte range refers to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub enum Source {
    /// The scene as run, after overrides.
    #[default]
    Scene,
    /// The fragment of the library system with this id.
    Library(Arc<str>),
    /// An override given on the command line, `path=value`.
    Override(Arc<str>),
}

/// A byte range of one of the texts a scene is made of.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Place {
    /// The text the range refers to.
    pub source: Source,
    /// The byte range; of a string, its quotes included.
    pub span: Range<usize>,
}

/// A value and the byte range it was read from.
#[derive(Clone, Debug, PartialEq)]
pub struct Located<T> {
    /// The value.
    pub value: T,
    /// Its byte range in the text named by `source`; of a string, its quotes included.
    pub span: Range<usize>,
    /// The text the range refers to.
    pub source: Source,
}

impl<T> Located<T> {
    /// A value at a place.
    pub fn new(value: T, place: Place) -> Self {
        Self {
            value,
            span: place.span,
            source: place.source,
        }
    }

    /// Where the value was read.
    pub fn place(&self) -> Place {
        Place {
            source: self.source.clone(),
            span: self.span.clone(),
        }
    }

    /// Another value at the same place.
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> Located<U> {
        Located {
            value: change(self.value),
            span: self.span,
            source: self.source,
        }
    }
}

/// A finite number with its decimal literal, which is an exact rational.
///
/// The literal is the text of the file without `_` separators; hexadecimal, octal and binary
/// integers are rewritten in decimal.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// The decimal literal.
    pub literal: String,
    /// The double nearest to it.
    pub value: f64,
}

impl fmt::Display for Number {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.literal)
    }
}

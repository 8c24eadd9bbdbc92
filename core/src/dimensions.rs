//! The dimensions that a part serves.

use std::fmt;

use crate::error::BuildError;

/// The dimensions d that a part serves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimensions {
    /// The smallest, at least 1.
    pub least: usize,
    /// The largest; `None` where there is no bound.
    pub most: Option<usize>,
}

impl Dimensions {
    /// d alone.
    pub fn only(d: usize) -> Self {
        Self {
            least: d,
            most: Some(d),
        }
    }

    /// Whether d is among them.
    pub fn contains(self, d: usize) -> bool {
        d >= self.least && self.most.is_none_or(|most| d <= most)
    }

    /// Refuses a dimension that the part of this name does not serve.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] where d is not among them.
    pub fn check(self, part: &'static str, d: usize) -> Result<(), BuildError> {
        match self.contains(d) {
            true => Ok(()),
            false => Err(BuildError::DoesNotFit {
                part,
                reason: format!("it serves dimension {self}, and this system has {d}"),
            }),
        }
    }
}

impl fmt::Display for Dimensions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.most {
            Some(most) if most == self.least => write!(f, "{most}"),
            Some(most) => write!(f, "{} to {most}", self.least),
            None => write!(f, "{} and more", self.least),
        }
    }
}

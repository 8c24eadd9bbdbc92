//! A picture with what stands around it.

use serde::Serialize;

/// A picture, its legend, caption and notes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Figure {
    /// The heading.
    pub title: String,
    /// The `<svg>` element.
    pub svg: String,
    /// Series names, in the order of the series colours; empty when one series needs no name.
    pub legend: Vec<String>,
    /// What is shown and how to read it.
    pub caption: String,
    /// What the picture could not show: values moved or left out.
    pub notes: Vec<String>,
}

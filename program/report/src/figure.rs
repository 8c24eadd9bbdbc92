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
    /// The colours, as "#00A3B4", of names behind those in the colours of the series; empty where these begin anew.
    pub colors: Vec<String>,
    /// Caption: the quantities shown and how to read the picture.
    pub caption: String,
    /// Notes on values that the picture could not show: those moved or left out.
    pub notes: Vec<String>,
}

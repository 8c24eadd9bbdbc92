//! Why a report could not be written.

use thiserror::Error;

/// Why a report could not be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The drawing library refused a figure.
    #[error("cannot draw the figure \"{figure}\": {message}")]
    Drawing {
        /// The figure.
        figure: String,
        /// The library's message.
        message: String,
    },
    /// A letter that the fonts of PDF do not have.
    #[error("the fonts of PDF have no {letter:?}, in \"{text}\": write SVG, or other letters")]
    Letter {
        /// The text.
        text: String,
        /// The letter.
        letter: char,
    },
    /// A template does not fit the values that it was given.
    #[error("cannot write the page {page}: {message}")]
    Page {
        /// The template.
        page: &'static str,
        /// Mismatch of the template and its values, in the words of the template engine.
        message: String,
    },
}

//! Errors of reading a library text.

use thiserror::Error;

/// Why a library text could not be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SystemError {
    /// The text is not TOML, or one of its tables lacks a key or has one too many.
    #[error("library system `{id}` is malformed: {message}")]
    Malformed {
        /// The system's id.
        id: String,
        /// The line, the column and the cause.
        message: String,
    },
    /// A table that every library text has is missing.
    #[error("library system `{id}` has no [{table}] table; add one")]
    MissingTable {
        /// The system's id.
        id: String,
        /// The table's name.
        table: &'static str,
    },
    /// `[system]` names neither `variables` nor `families`, so it has no dimension.
    #[error("library system `{id}` names no variables; add `variables` or `families` to [system]")]
    NoVariables {
        /// The system's id.
        id: String,
    },
}

//! Why a call failed.

use std::fmt;

use leafwise_plugin_abi::{LW_DISCARD, LW_ERROR, LW_UNSUPPORTED, LwStatus};

/// Why a call failed. The text says what failed, at which values, and what to try.
#[derive(Clone, Debug, PartialEq)]
pub enum Fail {
    /// The point is outside the part's domain, or an inner iteration did not converge there: the host
    /// may try a smaller ε or h.
    Outside {
        /// How far the point reaches over how far the domain does, greater than 1; 0 where unknown.
        ratio: f64,
        /// Why the point is outside: the domain that it left, as text for the host.
        reason: String,
    },
    /// Anything else that concerns this call only.
    Error(String),
    /// The part does not serve this system, dimension, parameter or partner, or lacks this function.
    Unsupported(String),
}

impl Fail {
    /// Outside the domain, which the point exceeds by this ratio (0: unknown).
    pub fn outside(ratio: f64, reason: impl Into<String>) -> Self {
        Self::Outside {
            ratio,
            reason: reason.into(),
        }
    }

    /// Anything else that concerns this call only.
    pub fn error(reason: impl Into<String>) -> Self {
        Self::Error(reason.into())
    }

    /// The failure [`Unsupported`](Self::Unsupported), with the system, dimension, parameter or
    /// partner that the part does not serve as its reason.
    pub fn unsupported(reason: impl Into<String>) -> Self {
        Self::Unsupported(reason.into())
    }

    pub(crate) fn status(&self) -> LwStatus {
        match self {
            Self::Outside { .. } => LW_DISCARD,
            Self::Error(_) => LW_ERROR,
            Self::Unsupported(_) => LW_UNSUPPORTED,
        }
    }

    pub(crate) fn ratio(&self) -> f64 {
        match self {
            Self::Outside { ratio, .. } => *ratio,
            _ => 0.0,
        }
    }
}

impl fmt::Display for Fail {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outside { reason, .. } => f.write_str(reason),
            Self::Error(reason) | Self::Unsupported(reason) => f.write_str(reason),
        }
    }
}

impl std::error::Error for Fail {}

//! How a call into a library failed.

use std::ffi::c_char;

use leafwise_core::{BuildError, StepError};
use leafwise_plugin_abi::{LW_DISCARD, LW_FATAL, LW_OK, LW_UNSUPPORTED, LwError, LwStatus};

/// Room for what a failing call says.
pub(super) const MESSAGE: usize = 512;

/// A call that returned no result.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CallFailure {
    /// The point is outside the domain; the ratio is known where it exceeds 0.
    Discarded {
        ratio: f64,
        point: Option<usize>,
        message: String,
    },
    /// The instance does not offer this.
    Unsupported { message: String },
    /// Any other failure.
    Failed {
        point: Option<usize>,
        message: String,
    },
    /// The instance is broken, from this call on.
    Broken { message: String },
    /// A result that is no finite number.
    NotFinite { point: usize, coordinate: usize },
    /// A result that was not written.
    Unwritten { point: usize, coordinate: usize },
    /// The call changed how this thread computes.
    FloatingPoint { message: String },
}

impl CallFailure {
    /// The failure that a status other than `LW_OK` and the texts beside it mean.
    fn new(status: LwStatus, point: i64, ratio: f64, message: String) -> Self {
        let point = usize::try_from(point).ok();
        match status {
            LW_DISCARD => Self::Discarded {
                ratio,
                point,
                message,
            },
            LW_UNSUPPORTED => Self::Unsupported { message },
            LW_FATAL => Self::Broken { message },
            _ => Self::Failed { point, message },
        }
    }

    /// As the failure of a step.
    pub(crate) fn of_step(self, part: &str, function: &str) -> StepError {
        let (part, message) = (part.to_owned(), format!("{function}: {self}"));
        match self {
            Self::Discarded { ratio, .. } if ratio > 0.0 => StepError::OutsideDomain {
                part,
                ratio,
                message,
            },
            _ => StepError::Part { part, message },
        }
    }

    /// As the refusal of a system, a parameter or a partner.
    pub(crate) fn of_build(self, part: &'static str) -> BuildError {
        BuildError::DoesNotFit {
            part,
            reason: self.to_string(),
        }
    }
}

impl std::fmt::Display for CallFailure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let at = |point: &Option<usize>| {
            point.map_or_else(String::new, |point| format!(" at point {point}"))
        };
        let (what, message) = match self {
            Self::Discarded {
                ratio,
                point,
                message,
            } => {
                let how_far = if *ratio > 0.0 {
                    format!(" ({ratio:.2} times as far as it reaches)")
                } else {
                    String::new()
                };
                (format!("outside its domain{}{how_far}", at(point)), message)
            }
            Self::Unsupported { message } => ("not supported".to_owned(), message),
            Self::Failed { point, message } => (format!("error{}", at(point)), message),
            Self::Broken { message } => ("fatal".to_owned(), message),
            Self::NotFinite { point, coordinate } => {
                return write!(
                    f,
                    "non-finite output at point {point} coordinate {coordinate}"
                );
            }
            Self::Unwritten { point, coordinate } => {
                return write!(
                    f,
                    "LW_OK, and the output at point {point} coordinate {coordinate} is not written"
                );
            }
            Self::FloatingPoint { message } => return f.write_str(message),
        };
        if message.is_empty() {
            write!(f, "{what}, with no reason given")
        } else {
            write!(f, "{what}: {message}")
        }
    }
}

/// Where a call says why it failed.
#[inline]
pub(super) fn error_into(message: &mut [c_char; MESSAGE]) -> LwError {
    message[0] = 0;
    LwError {
        capacity: MESSAGE as u32,
        message: message.as_mut_ptr(),
        point: -1,
        ..LwError::empty()
    }
}

/// The failure that a status and the texts beside it stand for.
#[cold]
pub(super) fn failure(
    status: LwStatus,
    error: &LwError,
    message: &[c_char; MESSAGE],
) -> Result<(), CallFailure> {
    if status == LW_OK {
        return Ok(());
    }
    let bytes: Vec<u8> = message
        .iter()
        .take_while(|c| **c != 0)
        .map(|c| c.cast_unsigned())
        .collect();
    let text = String::from_utf8_lossy(&bytes).trim().to_owned();
    Err(CallFailure::new(status, error.point, error.ratio, text))
}

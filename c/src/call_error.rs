//! Failures as codes with messages.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use leafwise::core::StepError;
use leafwise::core::gradient::GradientError;
use leafwise::scene::compose::Refusal as SceneRefusal;
use leafwise_cli::console::Console;
use leafwise_cli::failure::{Failure, exit};

use crate::code::LeafwiseCode;

/// Why a call did nothing.
pub(crate) struct CallError {
    pub(crate) code: LeafwiseCode,
    pub(crate) message: String,
}

impl CallError {
    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self {
            code: LeafwiseCode::LEAFWISE_USAGE,
            message: message.into(),
        }
    }
}

/// The text of an argument.
///
/// # Safety
/// `argument` is NULL or a string with a NUL at its end, which lives as long as the result.
pub(crate) unsafe fn text<'a>(what: &str, argument: *const c_char) -> Result<&'a str, CallError> {
    if argument.is_null() {
        return Err(CallError::usage(format!("{what} is NULL")));
    }
    // SAFETY: as the caller's.
    let text = unsafe { CStr::from_ptr(argument) };
    text.to_str()
        .map_err(|_| CallError::usage(format!("{what} is not UTF-8 text")))
}

impl From<Failure> for CallError {
    fn from(failure: Failure) -> Self {
        let (mut out, mut err) = (Vec::new(), Vec::new());
        let exit = failure.print(&mut Console::new(&mut out, &mut err, false, false), false);
        let text = String::from_utf8_lossy(&err);
        let text = text.trim();
        let code = match exit {
            exit::RUN_FAILED => LeafwiseCode::LEAFWISE_STEP_FAILED,
            exit::INVALID_SCENE | exit::PLUGIN_REFUSED => LeafwiseCode::LEAFWISE_INVALID_SCENE,
            _ => LeafwiseCode::LEAFWISE_USAGE,
        };
        Self {
            code,
            message: text.strip_prefix("error: ").unwrap_or(text).to_owned(),
        }
    }
}

impl From<SceneRefusal> for CallError {
    fn from(refusal: SceneRefusal) -> Self {
        Failure::from(refusal).into()
    }
}

impl From<StepError> for CallError {
    fn from(error: StepError) -> Self {
        Self {
            code: LeafwiseCode::LEAFWISE_STEP_FAILED,
            message: error.to_string(),
        }
    }
}

impl From<GradientError> for CallError {
    fn from(error: GradientError) -> Self {
        let code = match error {
            GradientError::Step { .. } | GradientError::Overflow { .. } => {
                LeafwiseCode::LEAFWISE_STEP_FAILED
            }
            _ => LeafwiseCode::LEAFWISE_UNSUPPORTED,
        };
        Self {
            code,
            message: error.to_string(),
        }
    }
}

thread_local! {
    /// The message of this thread's last call, empty where it was done.
    static LAST: RefCell<CString> = RefCell::default();
}

/// The message of this thread's last call.
pub(crate) fn last() -> *const c_char {
    LAST.with_borrow(|message| message.as_ptr())
}

/// Works, and keeps the message of what failed for [`last`].
pub(crate) fn call(work: impl FnOnce() -> Result<(), CallError>) -> LeafwiseCode {
    // What a panic leaves half done is behind mutexes, which say so.
    let ended = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        Err(CallError {
            code: LeafwiseCode::LEAFWISE_MISTAKE,
            message: "the call panicked: this is a defect of the library".to_owned(),
        })
    });
    let (code, message) = match ended {
        Ok(()) => (LeafwiseCode::LEAFWISE_DONE, String::new()),
        Err(refusal) => (refusal.code, refusal.message),
    };
    let message = CString::new(message.replace('\0', "?")).unwrap_or_default();
    LAST.with_borrow_mut(|last| *last = message);
    code
}

//! The boundary: no panic leaves, every failure becomes a status and a line of text.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use leafwise_plugin_abi::{LW_FATAL, LW_OK, LwError, LwStatus};

use crate::fail::Fail;

/// A failure and the point of the batch it happened at, -1 outside batches.
pub(crate) struct Failure {
    pub(crate) point: i64,
    pub(crate) fail: Fail,
}

impl From<Fail> for Failure {
    fn from(fail: Fail) -> Self {
        Self { point: -1, fail }
    }
}

/// Runs `call`; a panic is `LW_FATAL` with its message.
///
/// # Safety
/// `err` is NULL or what the ABI says of it.
#[inline]
pub(crate) unsafe fn guard(
    err: *mut LwError,
    call: impl FnOnce() -> Result<(), Failure>,
) -> LwStatus {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(())) => LW_OK,
        // SAFETY: the caller's promise on `err`.
        Ok(Err(failure)) => unsafe { failed(err, &failure) },
        // SAFETY: as above.
        Err(payload) => unsafe { panicked(err, payload) },
    }
}

/// # Safety
/// `err` is NULL or what the ABI says of it.
#[cold]
unsafe fn failed(err: *mut LwError, Failure { point, fail }: &Failure) -> LwStatus {
    // SAFETY: passed on to the caller.
    unsafe { report(err, *point, fail.ratio(), &fail.to_string()) };
    fail.status()
}

/// # Safety
/// `err` is NULL or what the ABI says of it.
#[cold]
unsafe fn panicked(err: *mut LwError, payload: Box<dyn Any + Send>) -> LwStatus {
    let text = format!("panic: {}", message(payload.as_ref()));
    // Dropping what was thrown may panic again.
    std::mem::forget(payload);
    // SAFETY: passed on to the caller.
    unsafe { report(err, -1, 0.0, &text) };
    LW_FATAL
}

fn message(payload: &(dyn Any + Send)) -> &str {
    payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("(no message)")
}

/// Writes `text`, cut at a character's end, into the caller's buffer.
///
/// # Safety
/// `err` is NULL or points to an `LwError` whose `message` has room for `capacity` bytes.
unsafe fn report(err: *mut LwError, point: i64, ratio: f64, text: &str) {
    // SAFETY: NULL, or valid for this call.
    let Some(err) = (unsafe { err.as_mut() }) else {
        return;
    };
    err.point = point;
    err.ratio = ratio;
    let Some(room) = (err.capacity as usize).checked_sub(1) else {
        return;
    };
    if err.message.is_null() {
        return;
    }
    let mut end = text.len().min(room);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    // SAFETY: `end` + 1 ≤ `capacity` bytes of the caller's buffer, which no text of ours overlaps.
    unsafe {
        std::ptr::copy_nonoverlapping(text.as_ptr(), err.message.cast::<u8>(), end);
        err.message.add(end).write(0);
    }
}

//! Instances by numbers, in the form of pointers, and calls on them.

use std::collections::BTreeMap;
use std::ffi::{CString, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError, RwLock, TryLockError};

use super::instance::UnitInstance;
use crate::call_error::CallError;

/// An `fmi3Instance`: a number, never read as a pointer.
pub type Pointer = *mut c_void;

/// An `fmi3Status`.
pub type Status = i32;

/// `fmi3OK`.
pub const DONE: Status = 0;

/// `fmi3Error`.
pub const FAILED: Status = 3;

/// An `fmi3LogMessageCallback`.
pub type LogMessage = unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char);

/// Where messages go.
#[derive(Clone, Copy)]
pub(super) struct Log {
    /// The caller's pointer, as a number: it is handed back, and not read.
    environment: usize,
    log: Option<LogMessage>,
}

impl Log {
    pub fn new(environment: *mut c_void, log: Option<LogMessage>) -> Self {
        Self {
            environment: environment.expose_provenance(),
            log,
        }
    }

    pub fn error(&self, message: &str) {
        let Some(log) = self.log else { return };
        let message = CString::new(message.replace('\0', "?")).unwrap_or_default();
        let environment = std::ptr::with_exposed_provenance_mut(self.environment);
        // SAFETY: the caller gave the function to be called with this pointer and strings.
        unsafe {
            log(
                environment,
                FAILED,
                c"logStatusError".as_ptr(),
                message.as_ptr(),
            )
        };
    }
}

#[derive(Clone)]
struct HeldInstance {
    instance: Arc<Mutex<UnitInstance>>,
    log: Log,
}

static INSTANCES: RwLock<(usize, BTreeMap<usize, HeldInstance>)> =
    RwLock::new((0, BTreeMap::new()));

/// Gives an instance a number.
pub(super) fn hold(instance: UnitInstance, log: Log) -> Pointer {
    let mut all = INSTANCES.write().unwrap_or_else(PoisonError::into_inner);
    all.0 += 1;
    let number = all.0;
    let instance = Arc::new(Mutex::new(instance));
    all.1.insert(number, HeldInstance { instance, log });
    std::ptr::without_provenance_mut(number)
}

/// Lets an instance go.
pub(super) fn release(instance: Pointer) {
    let mut all = INSTANCES.write().unwrap_or_else(PoisonError::into_inner);
    let held = all.1.remove(&instance.addr());
    drop(all);
    drop(held);
}

/// Works; a panic is a mistake of the library, and leaves as an error.
pub(super) fn guarded<T>(work: impl FnOnce() -> Result<T, CallError>) -> Result<T, CallError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        Err(CallError::usage(
            "the call panicked: this is a defect of the library",
        ))
    })
}

/// Works on an instance, and logs why it did nothing.
pub(super) fn call(
    instance: Pointer,
    work: impl FnOnce(&mut UnitInstance) -> Result<(), CallError>,
) -> Status {
    let all = INSTANCES.read().unwrap_or_else(PoisonError::into_inner);
    let held = all.1.get(&instance.addr()).cloned();
    drop(all);
    let Some(held) = held else { return FAILED };
    let done = match held.instance.try_lock() {
        Ok(mut own) => guarded(|| work(&mut own)),
        Err(TryLockError::Poisoned(_)) => Err(CallError::usage(
            "an earlier call on this instance panicked; create another instance",
        )),
        Err(TryLockError::WouldBlock) => {
            Err(CallError::usage("the instance is in use by another thread"))
        }
    };
    match done {
        Ok(()) => DONE,
        Err(refusal) => {
            held.log.error(&refusal.message);
            FAILED
        }
    }
}

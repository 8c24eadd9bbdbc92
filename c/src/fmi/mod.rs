//! FMI 3.0 for co-simulation: the functions that a functional mock-up unit's library has
//! (<https://fmi-standard.org/docs/3.0>).
//!
//! - `instance`: a unit's variables and its trajectory.
//! - `held`: instances by numbers, and calls on them.
//! - `refused`: functions of what units of scenes do not offer.
//!
//! A call that does nothing returns `fmi3Error` and logs why. Instances are numbers in the form of pointers: one that was freed,
//! or never given, is an error and no crash.

mod held;
mod instance;
mod refused;

use std::ffi::{c_char, c_void};
use std::path::Path;

use crate::call_error::{CallError, text};
use crate::strided::Strided;
use held::{Log, call, hold, release};
use instance::UnitInstance;

pub use held::{LogMessage, Pointer, Status};
pub use refused::*;

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Errors are logged always, and there is nothing else to log.
///
/// # Safety
/// Categories are not read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: Pointer,
    _logging_on: bool,
    _count: usize,
    _categories: *const *const c_char,
) -> Status {
    call(instance, |_| Ok(()))
}

/// A unit of the scene in its resources; NULL with the reason logged where there is none.
///
/// # Safety
/// Strings are NULL or have a NUL at their ends. `log` may be called, with `environment`, in this call and those on the instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging_on: bool,
    event_mode_used: bool,
    _early_return_allowed: bool,
    _required: *const u32,
    required_count: usize,
    environment: *mut c_void,
    log: Option<LogMessage>,
    _intermediate_update: Option<unsafe extern "C" fn()>,
) -> Pointer {
    let log = Log::new(environment, log);
    let made = held::guarded(|| {
        if event_mode_used || required_count > 0 {
            return Err(CallError::usage(
                "units of scenes have no event mode and no intermediate values",
            ));
        }
        // SAFETY: as the caller's.
        let (token, resources) =
            unsafe { (text("the token", token)?, text("resourcePath", resources)?) };
        let resources = resources.strip_prefix("file://").unwrap_or(resources);
        UnitInstance::new(Path::new(resources), token)
    });
    match made {
        Ok(instance) => hold(instance, log),
        Err(refusal) => {
            log.error(&refusal.message);
            std::ptr::null_mut()
        }
    }
}

/// Lets an instance go.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3FreeInstance(instance: Pointer) {
    release(instance);
}

/// Begins the initialisation, at a time from which the unit's is counted.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3EnterInitializationMode(
    instance: Pointer,
    _tolerance_defined: bool,
    _tolerance: f64,
    start: f64,
    _stop_defined: bool,
    _stop: f64,
) -> Status {
    call(instance, |own| own.enter_initialization(start))
}

/// Ends it: parameters and initial values stay.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3ExitInitializationMode(instance: Pointer) -> Status {
    call(instance, UnitInstance::exit_initialization)
}

/// Ends the simulation.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3Terminate(instance: Pointer) -> Status {
    call(instance, |own| {
        own.terminate();
        Ok(())
    })
}

/// Goes back to what the instance was at first.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3Reset(instance: Pointer) -> Status {
    call(instance, UnitInstance::reset)
}

/// Writes values of variables.
///
/// # Safety
/// `references` may be read and `values` written, as many as their counts say, or are NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: Pointer,
    references: *const u32,
    count: usize,
    values: *mut f64,
    value_count: usize,
) -> Status {
    call(instance, |own| {
        // SAFETY: as the caller's.
        let references = unsafe { numbers(references, count) }?;
        let found = own.values(&references)?;
        let target = Strided {
            data: values,
            length: value_count,
            stride: 1,
        };
        if found.is_empty() && value_count == 0 {
            return Ok(());
        }
        // SAFETY: as the caller's.
        unsafe { target.write("values", &found) }
    })
}

/// Sets parameters and initial values of coordinates, before the initialisation ends.
///
/// # Safety
/// `references` and `values` may be read, as many as their counts say, or are NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: Pointer,
    references: *const u32,
    count: usize,
    values: *const f64,
    value_count: usize,
) -> Status {
    call(instance, |own| {
        // SAFETY: as the caller's.
        let references = unsafe { numbers(references, count) }?;
        if references.is_empty() && value_count == 0 {
            return Ok(());
        }
        let source = Strided {
            data: values,
            length: value_count,
            stride: 1,
        };
        // SAFETY: as the caller's.
        let values = unsafe { source.read("values", count) }?;
        own.set(&references, &values)
    })
}

/// Advances by whole steps of the scene, as many as the communication step is a multiple of their time.
///
/// # Safety
/// Each of the four places is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: Pointer,
    time: f64,
    step: f64,
    _no_set_state_before: bool,
    event_needed: *mut bool,
    terminate: *mut bool,
    early_return: *mut bool,
    last_time: *mut f64,
) -> Status {
    let mut reached = None;
    let status = call(instance, |own| {
        let made = own.advance(time, step);
        reached = Some(own.time());
        made
    });
    for place in [event_needed, terminate, early_return] {
        if !place.is_null() {
            // SAFETY: the caller lets it be written.
            unsafe { place.write(false) };
        }
    }
    if let Some(reached) = reached
        && !last_time.is_null()
    {
        // SAFETY: the caller lets it be written.
        unsafe { last_time.write(reached) };
    }
    status
}

/// Writes the number of coordinates, energy and Casimirs that a value depends on: of none it is told.
///
/// # Safety
/// `count` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfVariableDependencies(
    instance: Pointer,
    _reference: u32,
    count: *mut usize,
) -> Status {
    call(instance, |_| {
        if count.is_null() {
            return Err(CallError::usage("nDependencies is NULL"));
        }
        // SAFETY: the caller lets it be written.
        unsafe { count.write(0) };
        Ok(())
    })
}

/// Numbers of variables.
///
/// # Safety
/// `references` is NULL, or so many may be read.
unsafe fn numbers(references: *const u32, count: usize) -> Result<Vec<u32>, CallError> {
    if count == 0 {
        return Ok(Vec::new());
    }
    if references.is_null() || count > isize::MAX as usize / size_of::<u32>() {
        return Err(CallError::usage("valueReferences are NULL, or too many"));
    }
    // SAFETY: the caller vouches for every element.
    let read = |at: usize| unsafe { references.add(at).read_unaligned() };
    Ok((0..count).map(read).collect())
}

/// The status of functions that are refused.
fn refuse(instance: Pointer, name: &str) -> Status {
    let refused = |_: &mut UnitInstance| {
        Err(CallError::usage(format!(
            "{name} is not offered: units of scenes are for co-simulation, their variables are of the type Float64"
        )))
    };
    call(instance, refused)
}

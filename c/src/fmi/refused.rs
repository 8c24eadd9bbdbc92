//! Functions of the standard that units of scenes do not offer: other types, events, clocks, states, and other kinds of units.

use std::ffi::{c_char, c_void};

use super::held::{Log, LogMessage, Pointer, Status};
use super::refuse;

/// Functions that log their name and return `fmi3Error`; their arguments are not read.
macro_rules! refused {
    ($($name:ident($($argument:ty),*);)*) => {$(
        /// Not offered: returns `fmi3Error`, and logs so.
        #[unsafe(no_mangle)]
        pub extern "C" fn $name(instance: Pointer, $(_: $argument),*) -> Status {
            refuse(instance, stringify!($name))
        }
    )*};
}

refused! {
    fmi3GetFloat32(*const u32, usize, *mut f32, usize);
    fmi3SetFloat32(*const u32, usize, *const f32, usize);
    fmi3GetInt8(*const u32, usize, *mut i8, usize);
    fmi3SetInt8(*const u32, usize, *const i8, usize);
    fmi3GetUInt8(*const u32, usize, *mut u8, usize);
    fmi3SetUInt8(*const u32, usize, *const u8, usize);
    fmi3GetInt16(*const u32, usize, *mut i16, usize);
    fmi3SetInt16(*const u32, usize, *const i16, usize);
    fmi3GetUInt16(*const u32, usize, *mut u16, usize);
    fmi3SetUInt16(*const u32, usize, *const u16, usize);
    fmi3GetInt32(*const u32, usize, *mut i32, usize);
    fmi3SetInt32(*const u32, usize, *const i32, usize);
    fmi3GetUInt32(*const u32, usize, *mut u32, usize);
    fmi3SetUInt32(*const u32, usize, *const u32, usize);
    fmi3GetInt64(*const u32, usize, *mut i64, usize);
    fmi3SetInt64(*const u32, usize, *const i64, usize);
    fmi3GetUInt64(*const u32, usize, *mut u64, usize);
    fmi3SetUInt64(*const u32, usize, *const u64, usize);
    fmi3GetBoolean(*const u32, usize, *mut bool, usize);
    fmi3SetBoolean(*const u32, usize, *const bool, usize);
    fmi3GetString(*const u32, usize, *mut *const c_char, usize);
    fmi3SetString(*const u32, usize, *const *const c_char, usize);
    fmi3GetBinary(*const u32, usize, *mut usize, *mut *const u8, usize);
    fmi3SetBinary(*const u32, usize, *const usize, *const *const u8, usize);
    fmi3GetClock(*const u32, usize, *mut bool);
    fmi3SetClock(*const u32, usize, *const bool);
    fmi3GetVariableDependencies(u32, *mut usize, *mut u32, *mut usize, *mut i32, usize);
    fmi3GetFMUState(*mut *mut c_void);
    fmi3SetFMUState(*mut c_void);
    fmi3FreeFMUState(*mut *mut c_void);
    fmi3SerializedFMUStateSize(*mut c_void, *mut usize);
    fmi3SerializeFMUState(*mut c_void, *mut u8, usize);
    fmi3DeserializeFMUState(*const u8, usize, *mut *mut c_void);
    fmi3GetDirectionalDerivative(*const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize);
    fmi3GetAdjointDerivative(*const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize);
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3EnterEventMode();
    fmi3EvaluateDiscreteStates();
    fmi3EnterContinuousTimeMode();
    fmi3EnterStepMode();
    fmi3GetIntervalDecimal(*const u32, usize, *mut f64, *mut i32);
    fmi3GetIntervalFraction(*const u32, usize, *mut u64, *mut u64, *mut i32);
    fmi3GetShiftDecimal(*const u32, usize, *mut f64);
    fmi3GetShiftFraction(*const u32, usize, *mut u64, *mut u64);
    fmi3SetIntervalDecimal(*const u32, usize, *const f64);
    fmi3SetIntervalFraction(*const u32, usize, *const u64, *const u64);
    fmi3SetShiftDecimal(*const u32, usize, *const f64);
    fmi3SetShiftFraction(*const u32, usize, *const u64, *const u64);
    fmi3UpdateDiscreteStates(*mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64);
    fmi3CompletedIntegratorStep(bool, *mut bool, *mut bool);
    fmi3SetTime(f64);
    fmi3SetContinuousStates(*const f64, usize);
    fmi3GetContinuousStateDerivatives(*mut f64, usize);
    fmi3GetEventIndicators(*mut f64, usize);
    fmi3GetContinuousStates(*mut f64, usize);
    fmi3GetNominalsOfContinuousStates(*mut f64, usize);
    fmi3GetNumberOfEventIndicators(*mut usize);
    fmi3GetNumberOfContinuousStates(*mut usize);
    fmi3GetOutputDerivatives(*const u32, usize, *const i32, *mut f64, usize);
    fmi3ActivateModelPartition(u32, f64);
}

/// Not offered: NULL, with the reason logged.
///
/// # Safety
/// `log` may be called with `environment`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: bool,
    _logging_on: bool,
    environment: *mut c_void,
    log: Option<LogMessage>,
) -> Pointer {
    nothing(environment, log)
}

/// Not offered: NULL, with the reason logged.
///
/// # Safety
/// `log` may be called with `environment`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: bool,
    _logging_on: bool,
    environment: *mut c_void,
    log: Option<LogMessage>,
    _clock_update: Option<unsafe extern "C" fn()>,
    _lock: Option<unsafe extern "C" fn()>,
    _unlock: Option<unsafe extern "C" fn()>,
) -> Pointer {
    nothing(environment, log)
}

/// No unit, and the reason in the log.
fn nothing(environment: *mut c_void, log: Option<LogMessage>) -> Pointer {
    Log::new(environment, log).error("units of scenes are for co-simulation");
    std::ptr::null_mut()
}

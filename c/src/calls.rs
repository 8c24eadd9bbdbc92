//! The functions of the library.

use std::ffi::{CStr, c_char};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

use crate::call_error::{self, CallError, call, text};
use crate::code::LeafwiseCode;
use crate::handle::{self, LeafwiseHandle, Object};
use crate::integrator::Integrator;
use crate::samples;
use crate::scene::{LeafwiseName, LeafwiseShape, Scene};
use crate::strided::{Strided, StridedRows};

/// The library's version, as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn leafwise_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => c"",
        };
    VERSION.as_ptr()
}

/// The message of this thread's last call, with places and advice; "" where it was done. It holds until the thread's
/// next call.
#[unsafe(no_mangle)]
pub extern "C" fn leafwise_last_error() -> *const c_char {
    call_error::last()
}

/// Reads the scene in a file and composes its method. Scenes that name plugins are refused.
///
/// # Safety
/// `file` is NULL or a string with a NUL at its end. `scene` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_scene_read(
    file: *const c_char,
    scene: *mut LeafwiseHandle,
) -> LeafwiseCode {
    call(|| {
        // SAFETY: as the caller's.
        let file = unsafe { text("file", file) }?;
        let read = Object::Scene(Arc::new(Scene::read(Path::new(file))?));
        // SAFETY: as the caller's.
        unsafe { give("scene", scene, || handle::hold(read)) }
    })
}

/// The scene of a text in TOML, as a file holds it. Relative paths in it start from the current folder.
///
/// # Safety
/// `toml` is NULL or a string with a NUL at its end. `scene` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_scene_parse(
    toml: *const c_char,
    scene: *mut LeafwiseHandle,
) -> LeafwiseCode {
    call(|| {
        // SAFETY: as the caller's.
        let toml = unsafe { text("toml", toml) }?;
        let parsed = Object::Scene(Arc::new(Scene::parse("scene", toml)?));
        // SAFETY: as the caller's.
        unsafe { give("scene", scene, || handle::hold(parsed)) }
    })
}

/// The same scene with one key at another value, as `--set key=value`: "method.time-step" and "0.05". The scene itself
/// stays as it is.
///
/// # Safety
/// `key` and `value` are NULL or strings with a NUL at their ends. `changed` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_scene_set(
    scene: LeafwiseHandle,
    key: *const c_char,
    value: *const c_char,
    changed: *mut LeafwiseHandle,
) -> LeafwiseCode {
    call(|| {
        let scene = handle::scene(scene)?;
        // SAFETY: as the caller's.
        let (key, value) = unsafe { (text("key", key)?, text("value", value)?) };
        let other = Object::Scene(Arc::new(scene.with(key, value)?));
        // SAFETY: as the caller's.
        unsafe { give("changed", changed, || handle::hold(other)) }
    })
}

/// The numbers of coordinates, parameters, Casimirs and steps, and the time of a step.
///
/// # Safety
/// `shape` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_scene_shape(
    scene: LeafwiseHandle,
    shape: *mut LeafwiseShape,
) -> LeafwiseCode {
    call(|| {
        let scene = handle::scene(scene)?;
        // SAFETY: as the caller's.
        unsafe { give("shape", shape, || scene.shape()) }
    })
}

/// Writes the name of a coordinate, parameter or Casimir (a value of LeafwiseName), counted from 0, with a NUL at its end.
///
/// # Safety
/// `buffer` is NULL or `capacity` bytes of it may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_scene_name(
    scene: LeafwiseHandle,
    kind: u32,
    index: usize,
    buffer: *mut c_char,
    capacity: usize,
) -> LeafwiseCode {
    call(|| {
        let scene = handle::scene(scene)?;
        let kind = LeafwiseName::of(kind);
        let kind = kind.ok_or_else(|| CallError::usage("kind is not a value of LeafwiseName"))?;
        let names = scene.names(kind);
        let name = names.get(index).ok_or_else(|| {
            CallError::usage(format!(
                "there are {} names, and none at {index}",
                names.len()
            ))
        })?;
        if buffer.is_null() {
            return Err(CallError::usage("buffer is NULL"));
        }
        if name.len() >= capacity {
            return Err(CallError::usage(format!(
                "the name takes {} bytes, and the buffer has {capacity}",
                name.len() + 1
            )));
        }
        // SAFETY: the name and its NUL fit into the buffer, which the caller lets be written.
        unsafe {
            buffer
                .cast::<u8>()
                .copy_from_nonoverlapping(name.as_ptr(), name.len());
            buffer.add(name.len()).write(0);
        }
        Ok(())
    })
}

/// Writes the scene's initial state, d numbers.
///
/// # Safety
/// `x` is NULL, or `x[i*stride]` may be written for every i < n.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_scene_initial(
    scene: LeafwiseHandle,
    x: *mut f64,
    n: usize,
    stride: isize,
) -> LeafwiseCode {
    call(|| {
        let scene = handle::scene(scene)?;
        let initial = scene.run.own(&scene.run.plan.initial);
        // SAFETY: as the caller's.
        unsafe { out(x, n, stride).write("x", initial) }
    })
}

/// Writes the values of the scene's parameters.
///
/// # Safety
/// `values` is NULL, or `values[i*stride]` may be written for every i < n.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_scene_parameters(
    scene: LeafwiseHandle,
    values: *mut f64,
    n: usize,
    stride: isize,
) -> LeafwiseCode {
    call(|| {
        let scene = handle::scene(scene)?;
        let parameters = scene.run.system.parameter_values();
        // SAFETY: as the caller's.
        unsafe { out(values, n, stride).write("values", &parameters) }
    })
}

/// Steps from `initial`, or from the scene's own initial state where that is NULL, and writes `rows` samples of d numbers: the
/// initial state, and one every so many steps. Element j of row i is at `samples[i*row_stride + j*column_stride]`. A step
/// that fails writes nothing.
///
/// # Safety
/// `initial` is NULL, or `initial[i*stride]` may be read for every i < n. `samples` is NULL, or all of its elements may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_scene_run(
    scene: LeafwiseHandle,
    initial: *const f64,
    n: usize,
    stride: isize,
    every: u64,
    samples: *mut f64,
    rows: usize,
    row_stride: isize,
    column_stride: isize,
) -> LeafwiseCode {
    call(|| {
        // SAFETY: as the caller's.
        let scene = unsafe { from(handle::scene(scene)?, initial, n, stride) }?;
        let target = StridedRows {
            data: samples,
            rows,
            row_stride,
            stride: column_stride,
        };
        target.check(
            "samples",
            samples.is_null(),
            scene.run.plan.layout.coordinates(),
        )?;
        let made = samples::samples(&scene, rows, every)?;
        // SAFETY: as the caller's.
        unsafe { target.write("samples", &made, scene.run.plan.layout.coordinates()) }
    })
}

/// The gradient of a function of the samples that `leafwise_scene_run` writes, exact for the map that is stepped. The
/// function has the derivatives `cotangents` by them. `by_initial` gets the d derivatives by the initial state, and
/// `by_parameters`, unless it is NULL, those by the m parameters.
///
/// # Safety
/// As for `leafwise_scene_run`; `cotangents` may be read, `by_initial` and `by_parameters` written, where they are not NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_scene_vjp(
    scene: LeafwiseHandle,
    initial: *const f64,
    n: usize,
    stride: isize,
    every: u64,
    cotangents: *const f64,
    rows: usize,
    row_stride: isize,
    column_stride: isize,
    by_initial: *mut f64,
    d: usize,
    by_initial_stride: isize,
    by_parameters: *mut f64,
    m: usize,
    by_parameters_stride: isize,
) -> LeafwiseCode {
    call(|| {
        // SAFETY: as the caller's.
        let scene = unsafe { from(handle::scene(scene)?, initial, n, stride) }?;
        let source = StridedRows {
            data: cotangents,
            rows,
            row_stride,
            stride: column_stride,
        };
        // SAFETY: as the caller's.
        let cotangents = unsafe { source.read("cotangents", scene.run.plan.layout.coordinates()) }?;
        let shape = scene.shape();
        out(by_initial, d, by_initial_stride).check("by_initial", shape.coordinates)?;
        let target = out(by_parameters, m, by_parameters_stride);
        if !by_parameters.is_null() {
            target.check("by_parameters", shape.parameters)?;
        }
        let gradient = samples::pull(&scene, every, &cotangents, !by_parameters.is_null())?;
        let own = scene.run.own(&gradient.initial);
        // SAFETY: as the caller's.
        unsafe { out(by_initial, d, by_initial_stride).write("by_initial", own) }?;
        if by_parameters.is_null() {
            return Ok(());
        }
        // SAFETY: as the caller's.
        unsafe { target.write("by_parameters", &gradient.parameters) }
    })
}

/// A trajectory from `initial`, or from the scene's own initial state where that is NULL.
///
/// # Safety
/// `initial` is NULL, or `initial[i*stride]` may be read for every i < n. `integrator` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_integrator_new(
    scene: LeafwiseHandle,
    initial: *const f64,
    n: usize,
    stride: isize,
    integrator: *mut LeafwiseHandle,
) -> LeafwiseCode {
    call(|| {
        // SAFETY: as the caller's.
        let scene = unsafe { from(handle::scene(scene)?, initial, n, stride) }?;
        let made = Object::Integrator(Arc::new(Mutex::new(Integrator::new(&scene)?)));
        // SAFETY: as the caller's.
        unsafe { give("integrator", integrator, || handle::hold(made)) }
    })
}

/// Makes so many steps. Where one fails, the integrator stays at the state before it, and the message has its number.
#[unsafe(no_mangle)]
pub extern "C" fn leafwise_integrator_advance(
    integrator: LeafwiseHandle,
    steps: u64,
) -> LeafwiseCode {
    call(|| free(&*handle::integrator(integrator)?)?.advance(steps))
}

/// Writes the present state, d numbers.
///
/// # Safety
/// `x` is NULL, or `x[i*stride]` may be written for every i < n.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_integrator_state(
    integrator: LeafwiseHandle,
    x: *mut f64,
    n: usize,
    stride: isize,
) -> LeafwiseCode {
    call(|| {
        let held = handle::integrator(integrator)?;
        let own = free(&held)?;
        // SAFETY: as the caller's.
        unsafe { out(x, n, stride).write("x", own.state()) }
    })
}

/// The present time.
///
/// # Safety
/// `t` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_integrator_time(
    integrator: LeafwiseHandle,
    t: *mut f64,
) -> LeafwiseCode {
    call(|| {
        let held = handle::integrator(integrator)?;
        let own = free(&held)?;
        // SAFETY: as the caller's.
        unsafe { give("t", t, || own.time()) }
    })
}

/// The number of steps made.
///
/// # Safety
/// `steps` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_integrator_steps(
    integrator: LeafwiseHandle,
    steps: *mut u64,
) -> LeafwiseCode {
    call(|| {
        let held = handle::integrator(integrator)?;
        let own = free(&held)?;
        // SAFETY: as the caller's.
        unsafe { give("steps", steps, || own.steps()) }
    })
}

/// Writes the energy and the Casimirs at the present state, 1 + casimirs numbers.
///
/// # Safety
/// `values` is NULL, or `values[i*stride]` may be written for every i < n.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn leafwise_integrator_invariants(
    integrator: LeafwiseHandle,
    values: *mut f64,
    n: usize,
    stride: isize,
) -> LeafwiseCode {
    call(|| {
        let held = handle::integrator(integrator)?;
        let mut own = free(&held)?;
        // SAFETY: as the caller's.
        unsafe { out(values, n, stride).write("values", own.invariants()) }
    })
}

/// Lets a scene or an integrator go. Integrators hold what they need of their scene.
#[unsafe(no_mangle)]
pub extern "C" fn leafwise_free(handle: LeafwiseHandle) -> LeafwiseCode {
    call(|| handle::release(handle))
}

/// The integrator, unless it steps in another thread.
fn free(integrator: &Mutex<Integrator>) -> Result<MutexGuard<'_, Integrator>, CallError> {
    match integrator.try_lock() {
        Ok(own) => Ok(own),
        Err(TryLockError::Poisoned(_)) => Err(CallError {
            code: LeafwiseCode::LEAFWISE_MISTAKE,
            message: "an earlier call on this integrator panicked; create another integrator"
                .to_owned(),
        }),
        Err(TryLockError::WouldBlock) => Err(CallError {
            code: LeafwiseCode::LEAFWISE_BUSY,
            message: "the integrator is in use by another thread".to_owned(),
        }),
    }
}

/// Writes a value that is made only where there is a place for it.
///
/// # Safety
/// `place` is NULL or may be written.
unsafe fn give<T>(what: &str, place: *mut T, value: impl FnOnce() -> T) -> Result<(), CallError> {
    if place.is_null() {
        return Err(CallError::usage(format!("{what} is NULL")));
    }
    // SAFETY: as the caller's.
    unsafe { place.write_unaligned(value()) };
    Ok(())
}

fn out(data: *mut f64, length: usize, stride: isize) -> Strided<*mut f64> {
    Strided {
        data,
        length,
        stride,
    }
}

/// The scene from another initial state, or the same one where `initial` is NULL.
///
/// # Safety
/// `initial` is NULL, or `initial[i*stride]` may be read for every i < n.
unsafe fn from(
    scene: Arc<Scene>,
    initial: *const f64,
    n: usize,
    stride: isize,
) -> Result<Arc<Scene>, CallError> {
    if initial.is_null() {
        return Ok(scene);
    }
    let initial = Strided {
        data: initial,
        length: n,
        stride,
    };
    // SAFETY: as the caller's.
    let initial = unsafe { initial.read("initial", scene.run.plan.layout.coordinates()) }?;
    Ok(Arc::new(scene.from(&initial)?))
}

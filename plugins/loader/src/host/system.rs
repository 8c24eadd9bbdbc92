//! A Poisson system as a table of functions.

use std::cell::UnsafeCell;
use std::ffi::{CString, c_char, c_void};
use std::sync::atomic::{AtomicBool, Ordering};

use leafwise_core::system::{Derivatives, SystemEvaluator};
use leafwise_core::{BuildError, PoissonSystem, StepError};
use leafwise_plugin_abi::{LW_ERROR, LwError, LwHostSystem, LwMapCall, LwStatus, LwSystem};

use super::points::{Buffers, Shape, batches, fail};

/// Points that are handed over to an evaluator at once, at most.
const BATCH: usize = 64;

/// The system of one instance, lent from `create` to `destroy`.
pub(crate) struct HostSystem {
    shared: Box<Shared>,
}

/// The system behind the plugin's pointers.
struct Shared {
    raw: LwHostSystem,
    functions: LwSystem,
    dimension: usize,
    variables: Vec<CString>,
    casimirs: Vec<CString>,
    is_called: AtomicBool,
    state: UnsafeCell<State>,
}

struct State {
    evaluator: Box<dyn SystemEvaluator>,
    buffers: Buffers,
}

// SAFETY: the pointers lead to the box itself and to constant functions; the state is reached behind
// `is_called` only.
unsafe impl Send for HostSystem {}

impl HostSystem {
    /// The system with these values of its parameters.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or its derivative has no code.
    pub(crate) fn new(system: &PoissonSystem, parameters: &[f64]) -> Result<Self, BuildError> {
        let numbers = system.numbers()?;
        let names = |names: &mut dyn Iterator<Item = &str>| -> Vec<CString> {
            names
                .map(|name| CString::new(name).unwrap_or_default())
                .collect()
        };
        let casimirs = names(&mut system.casimir_names().into_iter());
        let functions = table(numbers.derivatives, !casimirs.is_empty());
        let mut shared = Box::new(Shared {
            raw: LwHostSystem::empty(),
            functions,
            dimension: system.dimension(),
            variables: names(&mut system.variables().iter().map(String::as_str)),
            casimirs,
            is_called: AtomicBool::new(false),
            state: UnsafeCell::new(State {
                evaluator: numbers.evaluator(parameters),
                buffers: Buffers::default(),
            }),
        });
        shared.raw.functions = &raw const shared.functions;
        shared.raw.instance = (&raw mut *shared).cast();
        Ok(Self { shared })
    }

    /// The pointer that `create` is given.
    pub(crate) fn raw(&self) -> *const LwHostSystem {
        &raw const self.shared.raw
    }
}

/// The functions that a system of these abilities has.
fn table(derivatives: Derivatives, has_casimirs: bool) -> LwSystem {
    let mut table = LwSystem::empty();
    table.dimension = Some(dimension);
    table.variable_name = Some(variable_name);
    table.tensor = Some(tensor);
    table.hamiltonian = Some(hamiltonian);
    table.gradient = Some(gradient);
    table.casimir_count = Some(casimir_count);
    if has_casimirs {
        table.casimir_name = Some(casimir_name);
        table.casimirs = Some(casimirs);
        if derivatives.casimirs {
            table.casimir_gradients = Some(casimir_gradients);
        }
    }
    if derivatives.tensor {
        table.tensor_tangent = Some(tensor_tangent);
    }
    if derivatives.hamiltonian {
        table.hessian = Some(hessian);
    }
    table
}

/// The system behind a plugin's first argument.
///
/// # Safety
/// `instance` is that of an [`LwHostSystem`] that is still lent.
unsafe fn shared<'a>(instance: *mut c_void) -> &'a Shared {
    // SAFETY: passed on to the caller.
    unsafe { &*instance.cast::<Shared>() }
}

unsafe extern "C" fn dimension(instance: *mut c_void) -> usize {
    // SAFETY: the contract of the table, here and in the functions below.
    unsafe { shared(instance) }.dimension
}

unsafe extern "C" fn variable_name(instance: *mut c_void, index: usize) -> *const c_char {
    // SAFETY: as above.
    let names = unsafe { &shared(instance).variables };
    names
        .get(index)
        .map_or(std::ptr::null(), |name| name.as_ptr())
}

unsafe extern "C" fn casimir_count(instance: *mut c_void) -> usize {
    // SAFETY: as above.
    unsafe { shared(instance) }.casimirs.len()
}

unsafe extern "C" fn casimir_name(instance: *mut c_void, index: usize) -> *const c_char {
    // SAFETY: as above.
    let names = unsafe { &shared(instance).casimirs };
    names
        .get(index)
        .map_or(std::ptr::null(), |name| name.as_ptr())
}

/// Evaluates one function at the points of a call.
///
/// # Safety
/// The contract of the table: the instance is lent, the call and the error are what the interface
/// says.
unsafe fn evaluate(
    instance: *mut c_void,
    call: *const LwMapCall,
    err: *mut LwError,
    shape: impl FnOnce(usize, usize) -> Shape,
    mut function: impl FnMut(&mut dyn SystemEvaluator, [&[f64]; 3], &mut [f64]) -> Result<(), StepError>,
) -> LwStatus {
    // SAFETY: passed on to the caller.
    let shared = unsafe { shared(instance) };
    if shared.is_called.swap(true, Ordering::Acquire) {
        let text = "the system is called from two threads at once";
        // SAFETY: passed on to the caller.
        return unsafe { fail(err, LW_ERROR, -1, 0.0, text) };
    }
    // SAFETY: nobody else is between the two changes of `is_called`.
    let state = unsafe { &mut *shared.state.get() };
    let shape = shape(shared.dimension, shared.casimirs.len());
    let evaluator = state.evaluator.as_mut();
    // SAFETY: passed on to the caller.
    let status = unsafe {
        let buffers = &mut state.buffers;
        batches(call, err, (shape, BATCH), buffers, |y, v, w, out| {
            function(evaluator, [y, v, w], out)
        })
    };
    shared.is_called.store(false, Ordering::Release);
    status
}

macro_rules! maps {
    ($($name:ident($v:literal, $w:literal) -> $output:expr, $evaluate:expr;)*) => {$(
        unsafe extern "C" fn $name(
            instance: *mut c_void,
            call: *const LwMapCall,
            err: *mut LwError,
        ) -> LwStatus {
            let shape = |d: usize, c: usize| Shape {
                point: d,
                v: $v * d,
                w: $w * d,
                output: $output(d, c),
            };
            // SAFETY: the contract of the table.
            unsafe { evaluate(instance, call, err, shape, $evaluate) }
        }
    )*};
}

maps! {
    tensor(1, 0) -> |d, _| d, |evaluator, [y, v, _], out| evaluator.tensor(y, v, out);
    hamiltonian(0, 0) -> |_, _| 1, |evaluator, [y, _, _], out| evaluator.hamiltonian(y, out);
    gradient(0, 0) -> |d, _| d, |evaluator, [y, _, _], out| evaluator.gradient(y, out);
    casimirs(0, 0) -> |_, c| c, |evaluator, [y, _, _], out| evaluator.casimirs(y, out);
    casimir_gradients(0, 0) -> |d, c| d * c, |evaluator, [y, _, _], out| {
        evaluator.casimir_gradients(y, out)
    };
    tensor_tangent(1, 1) -> |d, _| d, |evaluator, [y, v, w], out| {
        evaluator.tensor_tangent(y, v, w, out)
    };
    hessian(1, 0) -> |d, _| d, |evaluator, [y, v, _], out| evaluator.hessian(y, v, out);
}

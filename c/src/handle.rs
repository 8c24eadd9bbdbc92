//! Objects by numbers.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use crate::call_error::CallError;
use crate::integrator::Integrator;
use crate::scene::Scene;

/// The number of a scene or an integrator. No number is given twice; 0 is none.
pub type LeafwiseHandle = u64;

/// An object that a caller holds.
#[derive(Clone)]
pub(crate) enum Object {
    Scene(Arc<Scene>),
    Integrator(Arc<Mutex<Integrator>>),
}

impl Object {
    fn kind(&self) -> &'static str {
        match self {
            Self::Scene(_) => "a scene",
            Self::Integrator(_) => "an integrator",
        }
    }
}

struct Objects {
    last: LeafwiseHandle,
    held: BTreeMap<LeafwiseHandle, Object>,
}

static OBJECTS: RwLock<Objects> = RwLock::new(Objects {
    last: 0,
    held: BTreeMap::new(),
});

/// Gives an object a number.
pub(crate) fn hold(object: Object) -> LeafwiseHandle {
    let mut objects = OBJECTS.write().unwrap_or_else(PoisonError::into_inner);
    objects.last += 1;
    let handle = objects.last;
    objects.held.insert(handle, object);
    handle
}

/// Lets an object go. A call that works with it in another thread ends first.
pub(crate) fn release(handle: LeafwiseHandle) -> Result<(), CallError> {
    let mut objects = OBJECTS.write().unwrap_or_else(PoisonError::into_inner);
    let held = objects.held.remove(&handle);
    drop(objects);
    held.map(drop).ok_or_else(|| unknown(handle))
}

pub(crate) fn scene(handle: LeafwiseHandle) -> Result<Arc<Scene>, CallError> {
    match held(handle)? {
        Object::Scene(scene) => Ok(scene),
        other => Err(wrong(handle, &other, "a scene")),
    }
}

pub(crate) fn integrator(handle: LeafwiseHandle) -> Result<Arc<Mutex<Integrator>>, CallError> {
    match held(handle)? {
        Object::Integrator(integrator) => Ok(integrator),
        other => Err(wrong(handle, &other, "an integrator")),
    }
}

fn held(handle: LeafwiseHandle) -> Result<Object, CallError> {
    let objects = OBJECTS.read().unwrap_or_else(PoisonError::into_inner);
    let held = objects.held.get(&handle).cloned();
    held.ok_or_else(|| unknown(handle))
}

fn unknown(handle: LeafwiseHandle) -> CallError {
    CallError::usage(format!(
        "{handle} is not a valid handle: it was never created, or was freed"
    ))
}

fn wrong(handle: LeafwiseHandle, held: &Object, wanted: &str) -> CallError {
    CallError::usage(format!(
        "handle {handle} is {}, and the call takes {wanted}",
        held.kind()
    ))
}

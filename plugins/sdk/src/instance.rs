//! Instances of a part: made, kept behind a pointer, ended.

use std::ffi::c_void;

use leafwise_plugin_abi::{LwCreate, LwError, LwLifecycle, LwStatus};

use crate::create::Create;
use crate::fail::Fail;
use crate::guard::guard;
use crate::info::Info;

/// A part: what it declares and how it is made. Beside it stands one of [`System`](crate::System),
/// [`Realization`](crate::Realization), [`ChartRealization`](crate::ChartRealization),
/// [`OneForm`](crate::OneForm), [`Embedding`](crate::Embedding), [`Flow`](crate::Flow),
/// [`StepMap`](crate::StepMap).
///
/// The host makes one instance for each thread and each set of parameters; calls on one instance
/// never overlap.
pub trait Part: Sized + Send + 'static {
    /// The part's declaration.
    const INFO: Info;
    /// An instance for the host's dimension, parameters and partners.
    ///
    /// # Errors
    /// [`Fail::Unsupported`], with the reason, for what the part does not serve.
    fn create(args: &Create<'_>) -> Result<Self, Fail>;
}

/// A part with its room for copies, which `create` leaves behind the host's pointer.
pub(crate) struct Instance<T> {
    pub(crate) part: T,
    pub(crate) scratch: Scratch,
}

/// Room for points whose coordinates are not neighbours in memory.
#[derive(Default)]
pub(crate) struct Scratch {
    pub(crate) point: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) w: Vec<f64>,
    pub(crate) out: Vec<f64>,
}

/// The lifecycle of a part.
pub(crate) const fn lifecycle<T: Part>() -> LwLifecycle {
    LwLifecycle {
        create: Some(create::<T>),
        destroy: Some(destroy::<T>),
        properties: None,
    }
}

unsafe extern "C" fn create<T: Part>(
    args: *const LwCreate,
    instance: *mut *mut c_void,
    err: *mut LwError,
) -> LwStatus {
    // SAFETY: the host's `err`; its `args` and `instance` are checked for NULL before use.
    unsafe {
        guard(err, || {
            let (Some(args), false) = (args.as_ref(), instance.is_null()) else {
                return Err(Fail::error("create was called with NULL").into());
            };
            let part = T::create(&Create::new(args))?;
            let scratch = Scratch::default();
            instance.write(Box::into_raw(Box::new(Instance { part, scratch })).cast());
            Ok(())
        })
    }
}

unsafe extern "C" fn destroy<T: Part>(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: made by `create::<T>`, and the host ends an instance once. A panic in a
        // destructor has no one to be told to; it is caught by the guard.
        unsafe {
            guard(std::ptr::null_mut(), || {
                drop(Box::from_raw(instance.cast::<Instance<T>>()));
                Ok(())
            });
        }
    }
}

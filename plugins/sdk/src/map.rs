//! A batched map from a method of a trait.

use std::ffi::c_void;

use leafwise_plugin_abi::{LwError, LwInput, LwMapCall, LwMapFn, LwOutput, LwStatus};

use crate::fail::Fail;
use crate::guard::{Failure, guard};
use crate::instance::Instance;

/// The step sizes of a call: time advances by ε h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// The geometric parameter ε of (M, επ), of either sign.
    pub epsilon: f64,
    /// The dynamic step h, of either sign.
    pub h: f64,
}

/// The inputs at one point.
pub(crate) struct Arguments<'a> {
    pub(crate) steps: Steps,
    pub(crate) point: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) w: &'a [f64],
}

/// One method of a part's trait, as a type, so that it is inlined into its shim.
pub(crate) trait Map<T> {
    /// The result at one point.
    fn evaluate(part: &mut T, at: Arguments<'_>, out: &mut [f64]) -> Result<(), Fail>;
}

/// The shim of `M`.
pub(crate) const fn map<T, M: Map<T>>() -> LwMapFn {
    Some(shim::<T, M>)
}

/// The shim of `M`, or NULL where the part does not offer it.
pub(crate) const fn optional<T, M: Map<T>>(offered: bool) -> LwMapFn {
    if offered { map::<T, M>() } else { None }
}

unsafe extern "C" fn shim<T, M: Map<T>>(
    instance: *mut c_void,
    call: *const LwMapCall,
    err: *mut LwError,
) -> LwStatus {
    // SAFETY: `err` is the host's; `instance` was made by `create::<T>` and no other call on it
    // runs; `call` and its buffers are the host's and have the sizes they state.
    unsafe {
        guard(err, || {
            let instance = instance.cast::<Instance<T>>().as_mut();
            let (Some(instance), Some(call)) = (instance, call.as_ref()) else {
                return Err(Fail::error("a map was called with NULL").into());
            };
            let steps = Steps {
                epsilon: call.epsilon,
                h: call.h,
            };
            let Instance { part, scratch } = instance;
            for i in 0..call.count {
                let at = Arguments {
                    steps,
                    point: read(&call.point, i, &mut scratch.point),
                    v: read(&call.v, i, &mut scratch.v),
                    w: read(&call.w, i, &mut scratch.w),
                };
                write(&call.output, i, &mut scratch.out, |out| {
                    M::evaluate(part, at, out)
                })
                .map_err(|fail| Failure {
                    point: i as i64,
                    fail,
                })?;
            }
            Ok(())
        })
    }
}

/// The coordinates of point `i`.
///
/// # Safety
/// `input` describes readable memory.
#[inline]
unsafe fn read<'a>(input: &LwInput, i: usize, room: &'a mut Vec<f64>) -> &'a [f64] {
    if input.data.is_null() {
        return &[];
    }
    // SAFETY: inside what `input` describes.
    unsafe {
        let first = input.data.add(i * input.point_stride);
        if input.coordinate_stride == 1 {
            return std::slice::from_raw_parts(first, input.dim);
        }
        room.clear();
        room.extend((0..input.dim).map(|j| first.add(j * input.coordinate_stride).read()));
    }
    room
}

/// Lets `fill` write the coordinates of point `i`.
///
/// # Safety
/// `output` describes writable memory that nothing else uses during the call.
#[inline]
unsafe fn write(
    output: &LwOutput,
    i: usize,
    room: &mut Vec<f64>,
    fill: impl FnOnce(&mut [f64]) -> Result<(), Fail>,
) -> Result<(), Fail> {
    if output.data.is_null() {
        return fill(&mut []);
    }
    // SAFETY: inside what `output` describes.
    unsafe {
        let first = output.data.add(i * output.point_stride);
        if output.coordinate_stride == 1 {
            return fill(std::slice::from_raw_parts_mut(first, output.dim));
        }
        room.resize(output.dim, 0.0);
        fill(room)?;
        for (j, value) in room.iter().enumerate() {
            first.add(j * output.coordinate_stride).write(*value);
        }
    }
    Ok(())
}

/// Names a method as a [`Map`].
macro_rules! maps {
    ($bound:ident: $($name:ident = |$part:ident, $at:ident, $out:ident| $body:expr;)*) => {$(
        pub(crate) struct $name;
        impl<T: $bound> $crate::map::Map<T> for $name {
            #[inline]
            fn evaluate(
                $part: &mut T,
                $at: $crate::map::Arguments<'_>,
                $out: &mut [f64],
            ) -> Result<(), $crate::fail::Fail> {
                $body
            }
        }
    )*};
}
pub(crate) use maps;

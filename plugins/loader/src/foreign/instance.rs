//! One instance of a part: made, called, ended.

use std::ffi::{c_char, c_void};
use std::sync::Arc;

use leafwise_plugin_abi::{LW_FATAL, LW_OK, LwMapCall, LwMapFn};

use super::batch::{Input, Output, is_unwritten};
use super::failure::{CallFailure, MESSAGE, error_into, failure};
use super::making::{HostObjects, Making, with_arguments};
use super::part::ForeignPart;
use crate::exits::in_call;

/// An instance of a part, with what it was lent.
pub(crate) struct Instance {
    part: Arc<ForeignPart>,
    pointer: *mut c_void,
    /// Why it is called no more.
    broken: Option<String>,
    message: Box<[c_char; MESSAGE]>,
    /// Dropped behind `destroy`.
    _lent: HostObjects,
}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Instance")
            .field("part", &self.part.name())
            .field("broken", &self.broken)
            .finish_non_exhaustive()
    }
}

// SAFETY: the contract of plugins: consecutive calls on an instance may come from different threads,
// and what the host lends is used during those calls only.
unsafe impl Send for Instance {}

/// One batched evaluation, its output excepted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Call<'a> {
    /// The number of points.
    pub count: usize,
    /// ε.
    pub epsilon: f64,
    /// h.
    pub h: f64,
    /// The points.
    pub point: Input<'a>,
    /// A second vector at each point.
    pub v: Input<'a>,
    /// A third vector at each point.
    pub w: Input<'a>,
}

impl<'a> Call<'a> {
    /// A call at these points and step sizes.
    pub(crate) fn at(count: usize, epsilon: f64, h: f64, point: Input<'a>) -> Self {
        Self {
            count,
            epsilon,
            h,
            point,
            v: Input::NONE,
            w: Input::NONE,
        }
    }
}

impl Instance {
    /// Makes an instance.
    pub(crate) fn new(
        part: &Arc<ForeignPart>,
        making: Making<'_>,
        lent: HostObjects,
    ) -> Result<Self, CallFailure> {
        let mut message = Box::new([0; MESSAGE]);
        let mut pointer = std::ptr::null_mut();
        let status = with_arguments(making, &lent, |arguments| {
            let mut error = error_into(&mut message);
            let create = part
                .lifecycle()
                .create
                .expect("checked when the part was read");
            let status = in_call(&part.info.name, || {
                // SAFETY: the arguments, the place for the instance and the error live during the
                // call; what `arguments` points to beyond it lives in `lent`, as long as the instance.
                unsafe { create(arguments, &mut pointer, &mut error) }
            });
            failure(status, &error, &message)
        });
        status.map(|()| Self {
            part: Arc::clone(part),
            pointer,
            broken: None,
            message,
            _lent: lent,
        })
    }

    /// Whether it is called no more.
    pub(crate) fn is_broken(&self) -> bool {
        self.broken.is_some()
    }

    /// Calls functions of the instance that take no batch, with their first argument.
    pub(crate) fn ask<T>(&self, question: impl FnOnce(*mut c_void) -> T) -> T {
        in_call(&self.part.info.name, || question(self.pointer))
    }

    /// The function, unless the instance says of a call that it does not offer it: a property of the
    /// instance, whatever the point.
    pub(crate) fn offered(
        &mut self,
        function: LwMapFn,
        call: &Call<'_>,
        results: usize,
    ) -> LwMapFn {
        /// More results than these are not asked for.
        const MOST: usize = 1 << 24;
        if function.is_none() || results == 0 || results > MOST {
            return function;
        }
        let mut room = vec![0.0; results];
        match self.evaluate(function, call, Output::points(&mut room, results)) {
            Err(CallFailure::Unsupported { .. }) => None,
            _ => function,
        }
    }

    /// Evaluates a function; every result is written, and finite.
    #[inline(always)]
    pub(crate) fn evaluate(
        &mut self,
        function: LwMapFn,
        call: &Call<'_>,
        mut output: Output<'_>,
    ) -> Result<(), CallFailure> {
        let (Some(function), None) = (function, &self.broken) else {
            return Err(self.not_called());
        };
        output.clear(call.count);
        let raw = LwMapCall {
            struct_size: size_of::<LwMapCall>() as u32,
            reserved: 0,
            count: call.count,
            epsilon: call.epsilon,
            h: call.h,
            point: call.point.raw(call.count),
            v: call.v.raw(call.count),
            w: call.w.raw(call.count),
            output: output.raw(call.count),
        };
        let mut error = error_into(&mut self.message);
        let status = in_call(&self.part.info.name, || {
            // SAFETY: the instance was made by this part and is not broken; every vector of the batch
            // lies in a live slice, the output in one that nothing else refers to.
            unsafe { function(self.pointer, &raw, &mut error) }
        });
        if status == LW_OK && output.is_finite(call.count) {
            return Ok(());
        }
        let failed = failure(status, &error, &self.message);
        if let (LW_FATAL, Err(CallFailure::Broken { message })) = (status, &failed) {
            self.broken = Some(message.clone());
        }
        failed?;
        match output.first_not_finite(call.count) {
            None => Ok(()),
            Some((point, coordinate)) if is_unwritten(output.at(point, coordinate)) => {
                Err(CallFailure::Unwritten { point, coordinate })
            }
            Some((point, coordinate)) => Err(CallFailure::NotFinite { point, coordinate }),
        }
    }

    /// Why a function is not called.
    #[cold]
    fn not_called(&self) -> CallFailure {
        match &self.broken {
            Some(reason) => CallFailure::Broken {
                message: format!("an earlier call broke this instance: {reason}"),
            },
            None => CallFailure::Unsupported {
                message: "the part has no such function".to_owned(),
            },
        }
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if self.broken.is_some() {
            return;
        }
        let destroy = self
            .part
            .lifecycle()
            .destroy
            .expect("checked when the part was read");
        in_call(&self.part.info.name, || {
            // SAFETY: the instance was made by this part, is not broken, and is not called again.
            unsafe { destroy(self.pointer) };
        });
    }
}

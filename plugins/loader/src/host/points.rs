//! The points of a call by a plugin, gathered in batches.

use std::ffi::c_char;
use std::mem::offset_of;

use leafwise_core::StepError;
use leafwise_plugin_abi::{
    LW_DISCARD, LW_ERROR, LW_OK, LW_UNSUPPORTED, LwError, LwInput, LwMapCall, LwOutput, LwStatus,
};

/// Numbers of coordinates that a function takes and gives: of the point, of the two vectors, of the result.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub point: usize,
    pub v: usize,
    pub w: usize,
    pub output: usize,
}

impl Shape {
    /// The mismatch of a call with this shape, in words; `None` where it fits.
    fn problem(self, call: &LwMapCall) -> Option<&'static str> {
        if (call.struct_size as usize) < size_of::<LwMapCall>() {
            return Some("struct_size of the call is too small");
        }
        let takes = [
            (&call.point, self.point),
            (&call.v, self.v),
            (&call.w, self.w),
        ];
        let fits = |(input, dim): &(&LwInput, usize)| {
            *dim == 0 || (input.dim == *dim && !input.data.is_null())
        };
        let gives = call.output.dim == self.output && !call.output.data.is_null();
        (!takes.iter().all(fits) || !gives)
            .then_some("an input or the output has another dimension than the function takes")
    }
}

/// The vectors of a batch, contiguous.
#[derive(Debug, Default)]
pub(super) struct Buffers {
    point: Vec<f64>,
    v: Vec<f64>,
    w: Vec<f64>,
    output: Vec<f64>,
}

impl Buffers {
    /// Evaluates `function` on the points from `from` on that are gathered here.
    fn evaluate(
        &mut self,
        shape: Shape,
        from: usize,
        to: usize,
        function: &mut impl FnMut(&[f64], &[f64], &[f64], &mut [f64]) -> Result<(), StepError>,
    ) -> Result<(), StepError> {
        let own = |values: &[f64], dim: usize| {
            // Shorter than a batch: one vector that serves all points.
            if values.len() < to * dim {
                0..dim
            } else {
                from * dim..to * dim
            }
        };
        function(
            &self.point[from * shape.point..to * shape.point],
            &self.v[own(&self.v, shape.v)],
            &self.w[own(&self.w, shape.w)],
            &mut self.output[from * shape.output..to * shape.output],
        )
    }
}

/// Evaluates `function(point, v, w, output)` at all points of a call, at most `most` of them at once. Vectors are
/// contiguous, but for v and w that serve all points.
///
/// # Safety
/// `call` is a call as the interface describes it. The pointer `err` is NULL or leads to an error.
pub(super) unsafe fn batches(
    call: *const LwMapCall,
    err: *mut LwError,
    (shape, most): (Shape, usize),
    buffers: &mut Buffers,
    mut function: impl FnMut(&[f64], &[f64], &[f64], &mut [f64]) -> Result<(), StepError>,
) -> LwStatus {
    // SAFETY: passed on to the caller.
    let call = unsafe { call.as_ref() };
    let problem = match call {
        None => Some("the call is NULL"),
        Some(call) => shape.problem(call),
    };
    let (Some(call), None) = (call, problem) else {
        // SAFETY: passed on to the caller.
        return unsafe { fail(err, LW_ERROR, -1, 0.0, problem.unwrap_or_default()) };
    };
    let mut first = 0;
    while first < call.count {
        let count = (call.count - first).min(most);
        let serves_all = |input: &LwInput| {
            if input.point_stride == 0 { 1 } else { count }
        };
        // SAFETY: the dimensions are those of the call.
        unsafe {
            let (v, w) = (serves_all(&call.v), serves_all(&call.w));
            read(&call.point, shape.point, first, count, &mut buffers.point);
            read(&call.v, shape.v, first, v, &mut buffers.v);
            read(&call.w, shape.w, first, w, &mut buffers.w);
        }
        buffers.output.resize(count * shape.output, 0.0);
        if let Err(error) = buffers.evaluate(shape, 0, count, &mut function) {
            // A batch that fails is taken again point by point, to tell which one does.
            let found = (0..count).find_map(|at| {
                let alone = buffers.evaluate(shape, at, at + 1, &mut function);
                alone.err().map(|error| (Some(first + at), error))
            });
            let (point, error) = found.unwrap_or((None, error));
            let point = point.and_then(|point| i64::try_from(point).ok());
            // The step is the caller's: it knows what to try.
            let cause = error.cause().to_string();
            let (status, ratio) = match error {
                StepError::LeftChart { ratio } | StepError::OutsideDomain { ratio, .. } => {
                    (LW_DISCARD, ratio)
                }
                StepError::NoConvergence { .. } => (LW_DISCARD, 0.0),
                StepError::NoTangent => (LW_UNSUPPORTED, 0.0),
                _ => (LW_ERROR, 0.0),
            };
            // SAFETY: passed on to the caller.
            return unsafe { fail(err, status, point.unwrap_or(-1), ratio, &cause) };
        }
        // SAFETY: the output has room for these points.
        unsafe { write(&call.output, shape.output, first, &buffers.output) };
        first += count;
    }
    LW_OK
}

/// Gathers the vectors of `count` points from `first` on.
///
/// # Safety
/// `input` has as many vectors of dimension `dim`.
unsafe fn read(input: &LwInput, dim: usize, first: usize, count: usize, into: &mut Vec<f64>) {
    into.clear();
    for at in first..first + count {
        let places = (0..dim).map(|j| at * input.point_stride + j * input.coordinate_stride);
        // SAFETY: a coordinate of a point of the call.
        into.extend(places.map(|place| unsafe { input.data.add(place).read() }));
    }
}

/// Hands over the vectors of the points from `first` on.
///
/// # Safety
/// `output` has room for them.
unsafe fn write(output: &LwOutput, dim: usize, first: usize, values: &[f64]) {
    for (at, own) in values.chunks_exact(dim.max(1)).enumerate() {
        for (j, value) in own.iter().enumerate() {
            let place = (first + at) * output.point_stride + j * output.coordinate_stride;
            // SAFETY: a coordinate of a point of the call.
            unsafe { output.data.add(place).write(*value) };
        }
    }
}

/// Says why a call failed, where the caller wants to know.
///
/// # Safety
/// `err` is NULL or leads to an error with the room it states.
pub(super) unsafe fn fail(
    err: *mut LwError,
    status: LwStatus,
    point: i64,
    ratio: f64,
    text: &str,
) -> LwStatus {
    if err.is_null() {
        return status;
    }
    // SAFETY: not NULL; a field is written only where the struct is large enough to have it.
    unsafe {
        let size = (*err).struct_size as usize;
        if size >= offset_of!(LwError, point) + 8 {
            (*err).point = point;
        }
        if size >= offset_of!(LwError, ratio) + 8 {
            (*err).ratio = ratio;
        }
        let (message, capacity) = ((*err).message, (*err).capacity as usize);
        if !message.is_null() && capacity > 0 {
            let mut length = text.len().min(capacity - 1);
            while !text.is_char_boundary(length) {
                length -= 1;
            }
            std::ptr::copy_nonoverlapping(text.as_ptr().cast::<c_char>(), message, length);
            message.add(length).write(0);
        }
    }
    status
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (x, y) with (v1, v2) shared ↦ x v1 + y v2, at points of a structure of arrays, into an output
    /// with gaps.
    #[test]
    fn any_layout_is_read_and_gaps_are_left_alone() {
        let points = [1.0, 2.0, 3.0, 10.0, 20.0, 30.0];
        let vector = [1.0, 0.5];
        let mut results = [-1.0; 6];
        let mut call = LwMapCall::empty();
        call.count = 3;
        call.point = LwInput {
            data: points.as_ptr(),
            dim: 2,
            point_stride: 1,
            coordinate_stride: 3,
        };
        call.v = LwInput {
            data: vector.as_ptr(),
            dim: 2,
            point_stride: 0,
            coordinate_stride: 1,
        };
        call.output = LwOutput {
            data: results.as_mut_ptr(),
            dim: 1,
            point_stride: 2,
            coordinate_stride: 1,
        };
        let shape = Shape {
            point: 2,
            v: 2,
            w: 0,
            output: 1,
        };
        let mut text = [1; 8];
        let mut error = LwError {
            capacity: 8,
            message: text.as_mut_ptr(),
            point: -1,
            ..LwError::empty()
        };
        for most in 1..4 {
            let mut evaluate = |function: &dyn Fn(f64) -> Result<(), StepError>| {
                // SAFETY: the call's vectors live here, and so does the error.
                unsafe {
                    batches(
                        &call,
                        &mut error,
                        (shape, most),
                        &mut Buffers::default(),
                        |y, v, _, out| {
                            assert_eq!((y.len(), v.len()), (2 * out.len(), 2));
                            assert!(out.len() <= most);
                            for (out, y) in out.iter_mut().zip(y.chunks_exact(2)) {
                                *out = y[0] * v[0] + y[1] * v[1];
                                function(y[0])?;
                            }
                            Ok(())
                        },
                    )
                }
            };
            assert_eq!(evaluate(&|_| Ok(())), LW_OK);
            let left = |x: f64| match x > 1.0 {
                true => Err(StepError::LeftChart { ratio: 4.0 }),
                false => Ok(()),
            };
            assert_eq!(evaluate(&left), LW_DISCARD);
            assert_eq!((error.point, error.ratio), (1, 4.0));
        }
        assert_eq!(results, [6.0, -1.0, 12.0, -1.0, 18.0, -1.0]);
        assert_eq!(text.map(|c| c as u8), *b"the ste\0");
        call.output.dim = 2;
        // SAFETY: as above; the call is refused before anything is written.
        let status = unsafe {
            let error = std::ptr::null_mut();
            batches(
                &call,
                error,
                (shape, 1),
                &mut Buffers::default(),
                |_, _, _, _| Ok(()),
            )
        };
        assert_eq!(status, LW_ERROR);
    }
}

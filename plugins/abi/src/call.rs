//! One batched evaluation.

use core::ffi::c_void;

use crate::status::{LwError, LwStatus};

/// One vector for each point of a batch, read by the callee. Coordinate j of point i is
/// `data[i * point_stride + j * coordinate_stride]`.
///
/// Frozen for ABI 1.
///
/// An array of points (C order, `n × dim`) has strides (dim, 1); the host's structure of arrays over
/// lanes has (1, lanes). A `point_stride` of 0 gives all points the same vector. An input that a
/// function does not take has `data` NULL and `dim` 0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwInput {
    /// The numbers; aligned for double, valid during the call.
    pub data: *const f64,
    /// Coordinates of a vector.
    pub dim: usize,
    /// Distance of neighbouring points, in doubles.
    pub point_stride: usize,
    /// Distance of neighbouring coordinates, in doubles.
    pub coordinate_stride: usize,
}

/// One vector for each point of a batch, written by the callee; addressed as `LwInput` is. No two
/// numbers share a place, and none is shared with an input. Nothing outside those places may be
/// written, the gaps between them included. Every number of the batch is written before `LW_OK` is returned:
/// the host takes what is left out as a failure. Frozen for ABI 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwOutput {
    /// Room for the numbers; aligned for double, valid during the call.
    pub data: *mut f64,
    /// Coordinates of a vector.
    pub dim: usize,
    /// Distance of neighbouring points, in doubles.
    pub point_stride: usize,
    /// Distance of neighbouring coordinates, in doubles.
    pub coordinate_stride: usize,
}

/// One batched evaluation of a map at `count` points. The caller owns the struct and every buffer.
///
/// Each function says which inputs it takes, their dimensions and that of its output. A function
/// with several results writes them contiguously. Matrices are row-major: entry (r, c) of an R × C
/// matrix at offset o is coordinate o + r C + c.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwMapCall {
    /// Bytes of this struct known to the caller.
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// The number of points; 0 is allowed and does nothing.
    pub count: usize,
    /// The geometric parameter ε of (M, επ): positive or negative, never 0. 1 for a system.
    pub epsilon: f64,
    /// The dynamic step h, positive or negative; time advances by ε h. 0 for systems and
    /// realizations.
    pub h: f64,
    /// The points: y or x in M (d coordinates), or z in S (d_S coordinates).
    pub point: LwInput,
    /// A second vector at each point, for functions that say so.
    pub v: LwInput,
    /// A third vector at each point, for functions that say so.
    pub w: LwInput,
    /// The results.
    pub output: LwOutput,
}

/// A batched map. Its first argument is the instance, of whose calls no two overlap in time unless
/// the part is `LW_FLAG_SHAREABLE`; the calling thread may change from call to call.
///
/// A pure function: the result at a point depends on the instance and on that point's inputs alone.
/// It allocates nothing that it does not free. A result that is not finite is a failure: the host
/// checks, and takes it as `LW_ERROR`.
pub type LwMapFn = Option<
    unsafe extern "C" fn(
        instance: *mut c_void,
        call: *const LwMapCall,
        err: *mut LwError,
    ) -> LwStatus,
>;

//! Poisson systems as numbers.

use core::ffi::{c_char, c_void};

use crate::call::LwMapFn;
use crate::create::LwLifecycle;

/// Functions of a Poisson system (M, π, H): `LW_KIND_SYSTEM`.
///
/// Its parameters are those of the part (`LwPart.parameters`), fixed when an instance is made. Maps
/// read `point` = y, of d coordinates; `epsilon` is 1 and `h` is 0. Threads: every function as
/// `LwMapFn` says, no two calls on one instance at once unless `LW_FLAG_SHAREABLE`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwSystem {
    /// Bytes of this struct known to its author.
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// How instances are made and ended.
    pub life: LwLifecycle,
    /// d, the dimension of M, at least 1. Required. *Threads*: as `LwMapFn`.
    pub dimension: Option<unsafe extern "C" fn(instance: *mut c_void) -> usize>,
    /// The name of variable `index` < d; the string lives as long as the instance. Optional: NULL, or
    /// a NULL result, means x1, x2, …. *Threads*: as `LwMapFn`.
    pub variable_name:
        Option<unsafe extern "C" fn(instance: *mut c_void, index: usize) -> *const c_char>,
    /// Π(y)·v, (Π v)_i = Σ_j Π_ij(y) v_j with Π_ij = {x_i, x_j}; takes `v` (d); output d. Required.
    pub tensor: LwMapFn,
    /// H(y); output 1. Required.
    pub hamiltonian: LwMapFn,
    /// ∇H(y); output d. Required.
    pub gradient: LwMapFn,
    /// The number of Casimirs, C. Optional: NULL means 0. *Threads*: as `LwMapFn`.
    pub casimir_count: Option<unsafe extern "C" fn(instance: *mut c_void) -> usize>,
    /// The name of Casimir `index` < C in reports; the string lives as long as the instance. Required
    /// where there are Casimirs. *Threads*: as `LwMapFn`.
    pub casimir_name:
        Option<unsafe extern "C" fn(instance: *mut c_void, index: usize) -> *const c_char>,
    /// All Casimirs at y; output C. Required where there are Casimirs.
    pub casimirs: LwMapFn,
    /// Their gradients; output C × d. Optional: without it Π ∇C = 0 is checked by differences.
    pub casimir_gradients: LwMapFn,
    /// The derivative of Π(y)·v along y in the direction w, Σ_jk ∂_k Π_ij(y) v_j w_k; takes `v` and
    /// `w` (d each); output d. Optional: exact tangents need it.
    pub tensor_tangent: LwMapFn,
    /// D²H(y)·v; takes `v` (d); output d. Optional: exact tangents need it.
    pub hessian: LwMapFn,
}

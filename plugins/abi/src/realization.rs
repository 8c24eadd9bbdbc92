//! Realization data as numbers.

use core::ffi::c_void;

use crate::call::LwMapFn;
use crate::create::LwLifecycle;

/// Functions of realization data (S, ω, α̂_ε, β̂_ε, σ) of (M, επ): `LW_KIND_REALIZATION`.
///
/// α̂ is a Poisson map and β̂ anti-Poisson, exactly or to the declared order n in ε, and
/// α̂∘σ = β̂∘σ = id. Points z of S are flat vectors of d_S coordinates. In a cotangent chart
/// (`LW_FLAG_COTANGENT_CHART`) z = (x, p) with d_S = 2 d, {x_i, p_j} = δ_ij and σ(x) = (x, 0).
///
/// Maps read `point` = z except where they say x, and `epsilon`; `h` is 0. Outside the domain they
/// return `LW_DISCARD`, never a number. Threads: every function as `LwMapFn` says, no two calls on
/// one instance at once unless `LW_FLAG_SHAREABLE`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwRealization {
    /// Bytes of this struct known to its author.
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// How instances are made and ended; `LwCreate.system` holds the tensor.
    pub life: LwLifecycle,
    /// d_S, the number of coordinates of a point of S. Required. *Threads*: as `LwMapFn`.
    pub space_dimension: Option<unsafe extern "C" fn(instance: *mut c_void) -> usize>,
    /// α̂_ε(z), the end of a step; output d. Required.
    pub alpha: LwMapFn,
    /// β̂_ε(z), the start of a step; output d. Required.
    pub beta: LwMapFn,
    /// σ(x); `point` = x in M (d); output d_S. NULL means (x, 0), which needs
    /// `LW_FLAG_COTANGENT_CHART`.
    pub sigma: LwMapFn,
    /// The two ends without cancellation: a base point near both (x, in a chart), β̂ − base, and
    /// α̂ − β̂, the latter two formed directly and not as differences of the ends; output 3 d. Optional:
    /// without it the host takes β̂, 0 and the difference α̂ − β̂, at the cost of a few units of
    /// round-off a step.
    pub ends: LwMapFn,
    /// Dα̂(z); output d × d_S. Optional: collective integrators and Newton's method need it.
    pub alpha_jacobian: LwMapFn,
    /// β̂(z), then Dβ̂(z); output d + d × d_S. Optional: Newton's method needs it.
    pub beta_with_jacobian: LwMapFn,
    /// Dβ̂(z), then D(α̂ − β̂)(z), the latter without cancellation; output 2 × d × d_S. Optional:
    /// preferred to the two above where all are offered, called at points where `ends` was.
    pub ends_jacobian: LwMapFn,
    /// How far z is from σ over how far the domain reaches there: less than 1 inside; output 1.
    /// Optional: without it a point is inside unless a map says `LW_DISCARD`.
    pub domain: LwMapFn,
    /// The symplectic chart χ(x, p) of S about σ, χ(x, 0) = σ(x), for S whose points are not pairs
    /// (x, p); `point` = x and `v` = p in ℝᵈ each; output d_S. Optional: generating functions need
    /// it, or `LW_FLAG_COTANGENT_CHART`.
    pub chart: LwMapFn,
    /// Dχ(x, p); inputs as `chart`; output d_S × 2 d, the columns of x first. Optional, beside
    /// `chart`.
    pub chart_jacobian: LwMapFn,
}

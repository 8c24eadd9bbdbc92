//! Instances: what they are made of, how they are made and ended, and the systems and realizations that both
//! sides hand to each other. One module, for these tables point to one another.

use core::ffi::{c_char, c_void};

use crate::call::LwMapFn;
use crate::status::{LwError, LwStatus};

/// `LwSetting.kind`: a whole number.
pub const LW_SETTING_INTEGER: u32 = 1;
/// `LwSetting.kind`: a number.
pub const LW_SETTING_REAL: u32 = 2;
/// `LwSetting.kind`: a word.
pub const LW_SETTING_TEXT: u32 = 3;

/// The value of one parameter of a part, of the type of its declared default. Frozen for ABI 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwSetting {
    /// The parameter's name.
    pub name: *const c_char,
    /// `LW_SETTING_INTEGER`, `LW_SETTING_REAL` or `LW_SETTING_TEXT`.
    pub kind: u32,
    /// 0.
    pub reserved: u32,
    /// The whole number; 0 for other kinds.
    pub integer: i64,
    /// The number, whole numbers included; 0 for a word.
    pub real: f64,
    /// The word; NULL for numbers.
    pub text: *const c_char,
}

/// Arguments of `create` and `properties`: dimension, parameters, and the system and realization to
/// serve. The host owns the struct. It and its strings are valid during the call only, but `system`
/// and `realization` point to objects that stay valid until the instance's `destroy` returns.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwCreate {
    /// Bytes of this struct known to the host.
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// d, the dimension of M; 0 for a system, which says it itself, and in `properties` where no
    /// system is chosen yet.
    pub dim: usize,
    /// All parameters as one JSON object: `{"order": 4, "tolerance": 1e-12}`. The same values as
    /// `settings`, for authors who have a JSON reader at hand.
    pub params: *const c_char,
    /// One setting for each entry of `LwPart.parameters`, in the same order, defaults filled in.
    pub settings: *const LwSetting,
    /// The number of settings.
    pub setting_count: usize,
    /// The system to serve, its parameters fixed; NULL for a system, and in `properties` where none
    /// is chosen yet.
    pub system: *const LwHostSystem,
    /// The realization to serve; NULL except for a dynamic approximation.
    pub realization: *const LwHostRealization,
}

/// Order, structure and flags that a part promises for given parameters.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwProperties {
    /// Bytes of this struct known to the host.
    pub struct_size: u32,
    /// As `LwPart.order`.
    pub order: i32,
    /// As `LwPart.structure`.
    pub structure: i32,
    /// As `LwPart.flags`.
    pub flags: u32,
}

/// How instances of a part are made and ended; part of every table of functions. Frozen for ABI 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwLifecycle {
    /// Makes an instance and leaves it at `*instance`; on failure the host ignores `*instance`.
    /// Required. A part without state may leave NULL there.
    ///
    /// The host makes one instance for each thread that needs one and for each set of parameter
    /// values. A return of `LW_UNSUPPORTED` says that the part does not serve this system,
    /// dimension or parameter. *Threads*: any, also while other instances are made or called.
    pub create: Option<
        unsafe extern "C" fn(
            args: *const LwCreate,
            instance: *mut *mut c_void,
            err: *mut LwError,
        ) -> LwStatus,
    >,
    /// Ends an instance: frees all that `create` and the calls made. Required. Called once, never
    /// after `LW_FATAL`. *Threads*: any, after the last call on the instance has returned.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// Changes those of `properties` that depend on the parameters: the host has filled in what
    /// `LwPart` declares. Optional; NULL when nothing depends on them. Called before any instance
    /// exists. *Threads*: any, also while instances are made or called.
    pub properties: Option<
        unsafe extern "C" fn(
            args: *const LwCreate,
            properties: *mut LwProperties,
            err: *mut LwError,
        ) -> LwStatus,
    >,
}

/// The host's Poisson system with its parameters fixed, for a part to call. The host owns it. It is
/// valid from `create` until the instance's `destroy` returns.
///
/// *Threads*: call it only during a call of the host on the instance it was given to. That includes
/// `create` and `destroy`. Call it on the same thread as that call. A part that is
/// `LW_FLAG_SHAREABLE` may do so from several such calls at once. A status other than `LW_OK` is to
/// be returned to the host.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwHostSystem {
    /// Bytes of this struct known to the host.
    pub struct_size: u32,
    /// 0; no flag is defined for systems.
    pub flags: u32,
    /// The first argument of the functions.
    pub instance: *mut c_void,
    /// The functions; `life` is all NULL. The required ones are present; the optional ones are
    /// present where the system is given by formulas, otherwise they may be NULL.
    pub functions: *const LwSystem,
}

/// The host's realization, for a dynamic approximation to call. Ownership and threads as for
/// `LwHostSystem`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwHostRealization {
    /// Bytes of this struct known to the host.
    pub struct_size: u32,
    /// `LW_FLAG_EXACT`, `LW_FLAG_COTANGENT_CHART` and `LW_FLAG_REVERSIBLE`, as for the realization's
    /// part.
    pub flags: u32,
    /// The order n of the realization; 0 with `LW_FLAG_EXACT`.
    pub order: i32,
    /// 0.
    pub reserved: u32,
    /// The first argument of the functions.
    pub instance: *mut c_void,
    /// The functions; `life` is all NULL. `alpha`, `beta`, `sigma`, `space_dimension` are present,
    /// the others may be NULL.
    pub functions: *const LwRealization,
}

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

/// Functions of realization data (S, ω, α̂_ε, β̂_ε, σ) of (M, επ): `LW_KIND_REALIZATION`.
///
/// The map α̂ is a Poisson map and β̂ anti-Poisson, exactly or to the declared order n in ε, and
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
    /// The two ends without cancellation: a base point near both (x, in a chart), β̂ − base, and α̂
    /// − β̂; output 3 d. The latter two are formed directly and not as differences of the ends.
    /// Optional: without it the host takes β̂, 0 and the difference α̂ − β̂, at the cost of a few
    /// units of round-off a step.
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
    /// (x, p). Inputs `point` = x and `v` = p in ℝᵈ each; output d_S. Optional: generating
    /// functions need it, or `LW_FLAG_COTANGENT_CHART`.
    pub chart: LwMapFn,
    /// Dχ(x, p); inputs as `chart`; output d_S × 2 d, the columns of x first. Optional, beside
    /// `chart`.
    pub chart_jacobian: LwMapFn,
}

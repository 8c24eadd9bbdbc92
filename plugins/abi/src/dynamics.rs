//! Dynamic approximations as numbers.

use crate::call::LwMapFn;
use crate::instance::LwLifecycle;

/// Functions of a dynamic approximation: `LW_KIND_DYNAMICS`. It parametrizes a Lagrangian bisection
/// y ↦ L_{ε,h}(y) of S that approximates φ_h^{α_ε^*H}(σ(M)) to order m in h; the host solves
/// β̂(L(y)) = x_k and returns α̂(L(y)).
///
/// Exactly one of `one_form`, `embedding` and `flow` is present. Maps read `epsilon`, `h` and
/// `point` = y in M (d coordinates), `flow` z in S. The struct `LwCreate` holds both the system and
/// the realization, which is that of the whole method. Threads: every function as `LwMapFn` says,
/// no two calls on one instance at once unless `LW_FLAG_SHAREABLE`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwDynamics {
    /// Bytes of this struct known to its author.
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// How instances are made and ended.
    pub life: LwLifecycle,
    /// θ̂_{ε,h}(y) = dŜ_{ε,h}(y), a closed one-form of M: L(y) = χ(y, θ̂(y)) in the realization's
    /// cotangent chart; output d. The realization must have one, which is checked when a method is
    /// composed.
    pub one_form: LwMapFn,
    /// Dθ̂(y), a symmetric matrix; output d × d. Optional, beside `one_form`: Newton's method and
    /// exact tangents need it.
    pub one_form_jacobian: LwMapFn,
    /// L(y); output d_S.
    pub embedding: LwMapFn,
    /// DL(y); output d_S × d. Optional, beside `embedding`.
    pub embedding_jacobian: LwMapFn,
    /// A symplectic integrator's map Σ_{ε,h}(z) of the collective Hamiltonian H∘α̂_ε; `point` = z in S;
    /// output d_S. L(y) = Σ(σ(y)).
    pub flow: LwMapFn,
    /// DΣ(z); output d_S × d_S. Optional, beside `flow`.
    pub flow_jacobian: LwMapFn,
}

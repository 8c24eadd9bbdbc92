//! Step maps as numbers.

use crate::call::LwMapFn;
use crate::instance::LwLifecycle;

/// Functions of a step map Φ_{ε,h}: M → M that needs no realization: `LW_KIND_STEP_MAP`.
///
/// Maps read `point` = x (d coordinates), `epsilon` and `h`; time advances by ε h, of either sign.
/// Implicit maps start each solve from x alone: the result does not depend on earlier steps.
/// Threads: every function as `LwMapFn` says, no two calls on one instance at once unless
/// `LW_FLAG_SHAREABLE`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwStepMap {
    /// Bytes of this struct known to its author.
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// How instances are made and ended.
    pub life: LwLifecycle,
    /// Φ(x + low) − (x + low), formed without adding x back; output d. Takes `v` = low (d), what the
    /// host's compensated state holds beyond a double, less than an ulp of x: a map may ignore it,
    /// and it may be absent. Required.
    pub increment: LwMapFn,
    /// DΦ(x), exact through any inner solve; output d × d. Optional: the tensor defect needs it.
    pub tangent: LwMapFn,
}

//! Declaration of a part, readable before any instance exists.

use core::ffi::{c_char, c_void};

use crate::expression::LwExpression;

/// `LwPart.kind`: a Poisson system; `functions` is an `LwSystem`.
pub const LW_KIND_SYSTEM: u32 = 1;
/// `LwPart.kind`: realization data; `functions` is an `LwRealization`.
pub const LW_KIND_REALIZATION: u32 = 2;
/// `LwPart.kind`: a dynamic approximation; `functions` is an `LwDynamics`.
pub const LW_KIND_DYNAMICS: u32 = 3;
/// `LwPart.kind`: a step map; `functions` is an `LwStepMap`.
pub const LW_KIND_STEP_MAP: u32 = 4;

/// Realization: α̂ is Poisson and β̂ anti-Poisson to round-off; `order` is ignored.
pub const LW_FLAG_EXACT: u32 = 1;
/// Dynamic approximation: L is Lagrangian to round-off (θ̂ closed, Σ symplectic). Without it no
/// method made of it is declared a Poisson map.
pub const LW_FLAG_SYMPLECTIC: u32 = 2;
/// Dynamic approximation, step map: Φ_{−h} ∘ Φ_h = id; for a dynamic approximation over a reversible
/// realization.
pub const LW_FLAG_SELF_ADJOINT: u32 = 4;
/// Dynamic approximation, step map: known not to be self-adjoint. With neither flag it is unknown.
pub const LW_FLAG_NOT_SELF_ADJOINT: u32 = 8;
/// Realization: points of S are pairs z = (x, p), d_S = 2 d, ω canonical, σ(x) = (x, 0).
pub const LW_FLAG_COTANGENT_CHART: u32 = 16;
/// Realization with a cotangent chart: β̂(x, p) = α̂(x, −p).
pub const LW_FLAG_REVERSIBLE: u32 = 32;
/// Any part: calls on one instance may overlap in time. Whatever it says, this host makes an instance for
/// each of its evaluators, and instances run in parallel.
pub const LW_FLAG_SHAREABLE: u32 = 64;
/// Dynamic approximation: the host takes y = x_k instead of solving β̂(L(y)) = x_k.
pub const LW_FLAG_UNCORRECTED: u32 = 128;

/// `LwPart.structure`: not a Poisson map, or not known to be one.
pub const LW_STRUCTURE_NONE: i32 = 0;
/// `LwPart.structure`: a Poisson map to round-off.
pub const LW_STRUCTURE_EXACT: i32 = -1;

/// One parameter of a part. Frozen for ABI 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwParameter {
    /// Its name in a scene: a letter, then letters, digits, `_`.
    pub name: *const c_char,
    /// Its meaning and its allowed values, in one line.
    pub summary: *const c_char,
    /// Its default as a JSON literal, which is also its type: `4` is a whole number, `4.0` or `1e-3`
    /// a number, `"none"` a word. Decimal literals stay exact in formulas.
    pub default_json: *const c_char,
}

/// One part of a plugin: constant data that lives until the process ends.
///
/// A part without `functions` consists of expressions alone; one with both is used by its
/// expressions, its functions serving where the user asks for numbers. The two must agree.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwPart {
    /// Bytes of this struct known to its author.
    pub struct_size: u32,
    /// `LW_KIND_SYSTEM`, `LW_KIND_REALIZATION`, `LW_KIND_DYNAMICS` or `LW_KIND_STEP_MAP`.
    pub kind: u32,
    /// Its name in a scene, `vendor/name`: lower-case letters, digits, `-`, and one `/`. Required.
    pub id: *const c_char,
    /// A description of the part, in one line. Required.
    pub summary: *const c_char,
    /// Its promises, in words: order, exactness, symmetry. Optional.
    pub declares: *const c_char,
    /// Where it is defined, in words: states, tensors, step sizes. Optional.
    pub domain: *const c_char,
    /// Where it is published. Optional.
    pub reference: *const c_char,
    /// Its parameters; NULL where there are none.
    pub parameters: *const LwParameter,
    /// The number of parameters.
    pub parameter_count: usize,
    /// Its formulas; NULL where there are none.
    pub expressions: *const LwExpression,
    /// The number of formulas.
    pub expression_count: usize,
    /// Its functions: the struct of its kind; NULL where it consists of expressions alone.
    pub functions: *const c_void,
    /// Realization: n, α̂ = α + O(ε^{n+1}). Dynamic approximation: m, in h. Step map: the order in
    /// t = ε h. Lower bounds, at least 1 where they count; 0 for a system.
    pub order: i32,
    /// Step map: `LW_STRUCTURE_NONE`, `LW_STRUCTURE_EXACT`, or n > 0 where Φ_* π − π = O(t^{n+1}).
    /// 0 for other kinds.
    pub structure: i32,
    /// The smallest dimension d it serves; 0 for no bound.
    pub dim_min: u32,
    /// The largest dimension d it serves; 0 for no bound.
    pub dim_max: u32,
    /// A sum of `LW_FLAG_…`.
    pub flags: u32,
    /// 0.
    pub reserved: u32,
}

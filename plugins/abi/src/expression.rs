//! Parts as formulas.

use core::ffi::c_char;

/// One formula of a part, in the syntax of a scene. Frozen for ABI 1.
///
/// With formulas all works for a part that works for a built-in one: exact derivatives, series,
/// Hamilton–Jacobi of any order. A key is a name, or a name, a dot and the rest. The keys of each
/// kind:
///
/// - *System*: the keys of a scene's `[system]` table. They are `variables`: names separated by
///   commas; `families.NAME`: a length; `bracket.x1,x2`: the formula of {x1, x2};
///   `bracket.lie-algebra`: a name; `hamiltonian`; `casimirs.NAME`. And `convention`: `{H,x}` (the
///   default) or `{x,H}`; `boundary`: `periodic` or `open`. Formulas use the variables and the
///   part's numeric parameters. Their defaults stand in `LwPart.parameters`.
/// - *Realization* in a cotangent chart: `alpha.1` … `alpha.d`, formulas of x1 … xd, p1 … pd and
///   `epsilon`. Further `beta.1` … `beta.d`, absent where β̂(x, p) = α̂(x, −p). Then `domain`,
///   absent where it holds everywhere: less than 1 inside.
/// - *Dynamic approximation*: `S.1`, `S.3`, …, formulas of x1 … xd. These are the coefficients
///   S_l(x), l odd, of the generating function. Its formula is Ŝ_{ε,h} = Σ_l ε^{l−1} hˡ S_l.
/// - *Step map*: `increment.1` … `increment.d`: Φ(x) − x, formulas of x1 … xd, `epsilon` and `h`.
///
/// Realizations, dynamic approximations and step maps name the variables x1, x2, … whatever the
/// system calls them, and may use their own numeric parameters. Every key occurs once.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwExpression {
    /// Which formula.
    pub key: *const c_char,
    /// The formula, or the word or list the key takes.
    pub formula: *const c_char,
}

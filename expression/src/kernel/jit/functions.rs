//! The functions that machine code calls: those of the interpreter, with the platform's C convention.

use crate::analytic::{AnalyticFunction, FunctionPair};
use crate::expression::{Binary, Function};
use crate::kernel::code::Instruction;

macro_rules! entries {
    ($($variant:ident => $entry:ident, $entry_lanes:ident;)*) => {
        $(
            extern "C" fn $entry(x: f64) -> f64 {
                Function::$variant.apply(x)
            }

            unsafe extern "C" fn $entry_lanes(values: *mut f64, count: usize) {
                // SAFETY: the code passes its own memory of `count` numbers.
                let values = unsafe { std::slice::from_raw_parts_mut(values, count) };
                Function::$variant.apply_lanes(values);
            }
        )*

        /// The address of x ↦ f(x).
        pub(super) fn elementary(function: Function) -> usize {
            let entry: extern "C" fn(f64) -> f64 = match function {
                $(Function::$variant => $entry,)*
                Function::Special(..) => unknown,
            };
            entry as usize
        }

        /// The address of (values, count), which replaces each x by f(x).
        pub(super) fn elementary_lanes(function: Function) -> usize {
            let entry: unsafe extern "C" fn(*mut f64, usize) = match function {
                $(Function::$variant => $entry_lanes,)*
                Function::Special(..) => unknown_lanes,
            };
            entry as usize
        }
    };
}

entries! {
    Exp => exp, exp_lanes;
    Ln => ln, ln_lanes;
    Sqrt => sqrt, sqrt_lanes;
    Sin => sin, sin_lanes;
    Cos => cos, cos_lanes;
    Tan => tan, tan_lanes;
    Asin => asin, asin_lanes;
    Acos => acos, acos_lanes;
    Atan => atan, atan_lanes;
    Sinh => sinh, sinh_lanes;
    Cosh => cosh, cosh_lanes;
    Tanh => tanh, tanh_lanes;
    Asinh => asinh, asinh_lanes;
    Acosh => acosh, acosh_lanes;
    Atanh => atanh, atanh_lanes;
    Abs => abs, abs_lanes;
    Sign => sign, sign_lanes;
    Floor => floor, floor_lanes;
    Erf => erf, erf_lanes;
    Erfc => erfc, erfc_lanes;
    Gamma => gamma, gamma_lanes;
    Log10 => log10, log10_lanes;
    Log2 => log2, log2_lanes;
}

/// Special functions are analytic ones in code: no instruction applies them by this way.
extern "C" fn unknown(_: f64) -> f64 {
    f64::NAN
}

unsafe extern "C" fn unknown_lanes(values: *mut f64, count: usize) {
    // SAFETY: the code passes its own memory of `count` numbers.
    let values = unsafe { std::slice::from_raw_parts_mut(values, count) };
    values.fill(f64::NAN);
}

/// Two numbers: the first two registers in the System V convention.
#[repr(C)]
struct Two(f64, f64);

/// f(x) and g(x) of the pair.
///
/// # Safety
/// `pair` points to a pair.
unsafe extern "C" fn both(pair: *const FunctionPair, x: f64) -> Two {
    // SAFETY: the code passes a static pair.
    let (f, g) = (unsafe { &*pair }.values)(x);
    Two(f, g)
}

/// The address of (pair, x) ↦ (f(x), g(x)).
pub(super) fn pair() -> usize {
    let entry: unsafe extern "C" fn(*const FunctionPair, f64) -> Two = both;
    entry as usize
}

/// Replaces each x by f(x) and writes g(x).
unsafe extern "C" fn both_lanes(
    pair: *const FunctionPair,
    values: *mut f64,
    others: *mut f64,
    count: usize,
) {
    // SAFETY: the code passes a static pair and two pieces of its own memory, of `count` numbers each.
    let (pair, values, others) = unsafe {
        (
            &*pair,
            std::slice::from_raw_parts_mut(values, count),
            std::slice::from_raw_parts_mut(others, count),
        )
    };
    (pair.lanes)(values, others);
}

/// The address of (pair, values, others, count), which replaces each x by f(x) and writes g(x).
pub(super) fn pair_lanes() -> usize {
    let entry: unsafe extern "C" fn(*const FunctionPair, *mut f64, *mut f64, usize) = both_lanes;
    entry as usize
}

extern "C" fn raise(a: f64, b: f64) -> f64 {
    libm::pow(a, b)
}

extern "C" fn atan2(a: f64, b: f64) -> f64 {
    Binary::Atan2.apply(a, b)
}

extern "C" fn remainder(a: f64, b: f64) -> f64 {
    Binary::Mod.apply(a, b)
}

/// The address of (a, b) ↦ f(a, b), f the function that an instruction takes of two arguments: a power where it is
/// no other.
pub(super) fn of_two(instruction: &Instruction) -> usize {
    let entry: extern "C" fn(f64, f64) -> f64 = match instruction {
        Instruction::ApplyTwo { function, .. } => match function {
            Binary::Atan2 => atan2,
            Binary::Mod => remainder,
        },
        _ => raise,
    };
    entry as usize
}

/// f⁽ᵏ⁾(x) of the function at `function`.
///
/// # Safety
/// `function` points to a live [`AnalyticFunction`].
unsafe extern "C" fn differentiate(function: *const AnalyticFunction, order: u32, x: f64) -> f64 {
    // SAFETY: the caller passes a pointer to a live function.
    unsafe { &*function }.derivative(order, x)
}

/// The address of (f, k, x) ↦ f⁽ᵏ⁾(x), f by its address.
pub(super) fn analytic() -> usize {
    let entry: unsafe extern "C" fn(*const AnalyticFunction, u32, f64) -> f64 = differentiate;
    entry as usize
}

/// Replaces each a by f(a, b).
///
/// # Safety
/// `a` and `b` point to `count` numbers each, which are the code's own.
unsafe fn replace(a: *mut f64, b: *const f64, count: usize, f: impl Fn(f64, f64) -> f64) {
    // SAFETY: as the caller says.
    let (a, b) = unsafe {
        (
            std::slice::from_raw_parts_mut(a, count),
            std::slice::from_raw_parts(b, count),
        )
    };
    for (a, b) in a.iter_mut().zip(b) {
        *a = f(*a, *b);
    }
}

unsafe extern "C" fn raise_lanes(a: *mut f64, b: *const f64, count: usize) {
    // SAFETY: the code passes two pieces of its own memory, of `count` numbers each.
    unsafe { replace(a, b, count, libm::pow) }
}

unsafe extern "C" fn atan2_lanes(a: *mut f64, b: *const f64, count: usize) {
    // SAFETY: as above.
    unsafe { replace(a, b, count, |a, b| Binary::Atan2.apply(a, b)) }
}

unsafe extern "C" fn remainder_lanes(a: *mut f64, b: *const f64, count: usize) {
    // SAFETY: as above.
    unsafe { replace(a, b, count, |a, b| Binary::Mod.apply(a, b)) }
}

/// The address of (a, b, count), which replaces each a by f(a, b), f as of [`of_two`].
pub(super) fn of_two_lanes(instruction: &Instruction) -> usize {
    let entry: unsafe extern "C" fn(*mut f64, *const f64, usize) = match instruction {
        Instruction::ApplyTwo { function, .. } => match function {
            Binary::Atan2 => atan2_lanes,
            Binary::Mod => remainder_lanes,
        },
        _ => raise_lanes,
    };
    entry as usize
}

/// Replaces each x by f⁽ᵏ⁾(x).
unsafe extern "C" fn differentiate_lanes(
    function: *const AnalyticFunction,
    order: u32,
    values: *mut f64,
    count: usize,
) {
    // SAFETY: the code passes a live function and its own memory of `count` numbers.
    let (function, values) = unsafe { (&*function, std::slice::from_raw_parts_mut(values, count)) };
    function.derivative_lanes(order, values);
}

/// The address of (f, k, values, count), which replaces each x by f⁽ᵏ⁾(x).
pub(super) fn analytic_lanes() -> usize {
    let entry: unsafe extern "C" fn(*const AnalyticFunction, u32, *mut f64, usize) =
        differentiate_lanes;
    entry as usize
}

//! The functions that machine code calls: those of the interpreter, with the platform's C convention.

use crate::analytic::AnalyticFunction;
use crate::expression::Function;

macro_rules! entries {
    ($($variant:ident => $entry:ident),* $(,)?) => {
        $(
            extern "C" fn $entry(x: f64) -> f64 {
                Function::$variant.apply(x)
            }
        )*

        /// The address of x ↦ f(x).
        pub(super) fn elementary(function: Function) -> usize {
            let entry: extern "C" fn(f64) -> f64 = match function {
                $(Function::$variant => $entry,)*
            };
            entry as usize
        }
    };
}

entries! {
    Exp => exp,
    Ln => ln,
    Sqrt => sqrt,
    Sin => sin,
    Cos => cos,
    Tan => tan,
    Asin => asin,
    Acos => acos,
    Atan => atan,
    Sinh => sinh,
    Cosh => cosh,
    Tanh => tanh,
    Asinh => asinh,
    Acosh => acosh,
    Atanh => atanh,
}

extern "C" fn raise(a: f64, b: f64) -> f64 {
    libm::pow(a, b)
}

/// The address of (a, b) ↦ a^b.
pub(super) fn power() -> usize {
    let entry: extern "C" fn(f64, f64) -> f64 = raise;
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

//! Elementary functions on many numbers at once, to the bits of the `libm` crate, and pairs of
//! functions that are computed together.
//!
//! The algorithms, constants and orders of operations are those of fdlibm, which `libm` follows;
//! its branches are selections here, so that all lanes go the same way. Arguments for which that
//! does not serve (NaN, huge ones, results that are not normal numbers, ties of a reduction) get `libm`'s own value,
//! lane by lane. The value of a lane depends neither on its neighbours nor on the machine. The pairs
//! [`exp_m1_mirrored`] and [`sin_and_versine`] are algorithms of our own with fused products. They give the same bits
//! in lanes and alone, by an instruction or by whole numbers.
//!
//! fdlibm is Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved. Developed at SunPro,
//! a Sun Microsystems, Inc. business. Permission to use, copy, modify, and distribute this software
//! is freely granted, provided that this notice is preserved.

mod arctangent;
mod exponential;
mod lanes;
mod logarithm;
mod mirrored;
mod near;
mod reduction;
mod root;
#[cfg(test)]
mod tests;
mod trigonometric;
mod turn;

use arctangent::Atan;
use exponential::Exp;
use lanes::{First, Second, apply, apply_pair, both};
use logarithm::Ln;
use mirrored::Mirrored;
pub(crate) use near::{NearZero, exp_m1_mirrored_near_zero, sin_and_versine_near_zero};
use root::Roots;
use trigonometric::{Cos, Sin, SinCos, Tan};
use turn::Turn;

use crate::vector::run_loops;

/// Replaces each x by eˣ, as `libm::exp` gives it.
pub fn exp_lanes(values: &mut [f64]) {
    apply::<Exp>(values);
}

/// Replaces each x by ln x, as `libm::log` gives it.
pub fn ln_lanes(values: &mut [f64]) {
    apply::<Ln>(values);
}

/// Replaces each x by √x, as `libm::sqrt` gives it.
pub fn sqrt_lanes(values: &mut [f64]) {
    run_loops(Roots(values));
}

/// Replaces each x by sin x, as `libm::sin` gives it.
pub fn sin_lanes(values: &mut [f64]) {
    apply::<Sin>(values);
}

/// Replaces each x by cos x, as `libm::cos` gives it.
pub fn cos_lanes(values: &mut [f64]) {
    apply::<Cos>(values);
}

/// Replaces each x by sin x and writes cos x, for the price of one of the two.
///
/// # Panics
/// When the slices have different lengths.
pub fn sin_cos_lanes(values: &mut [f64], cosines: &mut [f64]) {
    apply_pair::<SinCos>(values, cosines);
}

/// sin x and cos x, as `libm` gives them.
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// eˣ − 1 and e⁻ˣ − 1, each within 2 ulps.
pub fn exp_m1_mirrored(x: f64) -> (f64, f64) {
    both::<Mirrored>(x)
}

/// Replaces each x by eˣ − 1.
pub fn exp_m1_lanes(values: &mut [f64]) {
    apply::<First<Mirrored>>(values);
}

/// Replaces each x by e⁻ˣ − 1.
pub fn exp_m1_of_negative_lanes(values: &mut [f64]) {
    apply::<Second<Mirrored>>(values);
}

/// Replaces each x by eˣ − 1 and writes e⁻ˣ − 1.
///
/// # Panics
/// When the slices have different lengths.
pub fn exp_m1_mirrored_lanes(values: &mut [f64], mirrored: &mut [f64]) {
    apply_pair::<Mirrored>(values, mirrored);
}

/// sin x and 1 − cos x, each within 2 ulps.
pub fn sin_and_versine(x: f64) -> (f64, f64) {
    both::<Turn>(x)
}

/// Replaces each x by sin x, to the bits of [`sin_and_versine`].
pub fn sine_lanes(values: &mut [f64]) {
    apply::<First<Turn>>(values);
}

/// Replaces each x by 1 − cos x.
pub fn versine_lanes(values: &mut [f64]) {
    apply::<Second<Turn>>(values);
}

/// Replaces each x by sin x and writes 1 − cos x.
///
/// # Panics
/// When the slices have different lengths.
pub fn sin_and_versine_lanes(values: &mut [f64], versines: &mut [f64]) {
    apply_pair::<Turn>(values, versines);
}

/// Replaces each x by tan x, as `libm::tan` gives it.
pub fn tan_lanes(values: &mut [f64]) {
    apply::<Tan>(values);
}

/// Replaces each x by arctan x, as `libm::atan` gives it.
pub fn atan_lanes(values: &mut [f64]) {
    apply::<Atan>(values);
}

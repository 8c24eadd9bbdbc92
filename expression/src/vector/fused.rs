//! a·b + c rounded once, as IEEE 754 defines it: the same bits by an instruction and by whole numbers.

/// How a machine fuses a product and a sum.
pub(crate) trait Fused: Copy {
    /// a·b + c, rounded once.
    fn times_plus(a: f64, b: f64, c: f64) -> f64;
}

/// By an instruction, inside of functions of an instruction set that has it.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub(crate) struct Hardware;

#[cfg(target_arch = "x86_64")]
impl Fused for Hardware {
    #[inline(always)]
    fn times_plus(a: f64, b: f64, c: f64) -> f64 {
        by_instruction(a, b, c)
    }
}

/// As every machine of the target can: by whole numbers where not all have the instruction.
#[derive(Clone, Copy)]
pub(crate) struct Baseline;

impl Fused for Baseline {
    #[inline(always)]
    fn times_plus(a: f64, b: f64, c: f64) -> f64 {
        if cfg!(any(target_arch = "aarch64", target_feature = "fma")) {
            by_instruction(a, b, c)
        } else {
            libm::fma(a, b, c)
        }
    }
}

#[inline(always)]
#[allow(
    clippy::disallowed_methods,
    reason = "an instruction where this is called, to the bits of libm::fma"
)]
fn by_instruction(a: f64, b: f64, c: f64) -> f64 {
    a.mul_add(b, c)
}

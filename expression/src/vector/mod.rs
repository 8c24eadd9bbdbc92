//! Code compiled once for each instruction set, the widest chosen at run time.
//!
//! Plain loops over lanes (`Work`) are compiled for the baseline, for AVX2 and for AVX-512 from one source. Code that
//! a compiler does not turn into vector instructions by itself is written over a [`Register`]. A product and a sum are
//! fused where the source says so and nowhere else. So the bits are the same everywhere; only the number of lanes that
//! ride together differs.

#![allow(
    unsafe_code,
    reason = "functions of an instruction set are called where it was detected"
)]

#[cfg(target_arch = "x86_64")]
use std::sync::LazyLock;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod fused;
mod one;
mod register;
mod traced;

#[cfg(target_arch = "x86_64")]
use fused::Hardware;
pub(crate) use fused::{Baseline, Fused};
pub(crate) use one::One;
pub use register::Register;
pub(crate) use register::SIGN;
pub(crate) use traced::{Number, Tape, Traceable};

/// Loops over lanes, written once.
pub trait Work {
    /// Runs them. Implementations are `#[inline(always)]`: the instruction set is the caller's.
    fn run(self);
}

/// Runs loops compiled for the widest registers of this machine. Results have the same bits on any.
///
/// ```
/// use leafwise_expression::vector::{Work, run_loops};
///
/// struct Scatter<'a>(&'a mut [u32]);
/// impl Work for Scatter<'_> {
///     #[inline(always)]
///     fn run(self) {
///         self.0.iter_mut().for_each(|bits| *bits = bits.wrapping_mul(0x9E37_79B9));
///     }
/// }
/// let mut bits = [0, 1, 2, 3];
/// run_loops(Scatter(&mut bits));
/// assert_eq!(bits, [0, 0x9E37_79B9, 0x3C6E_F372, 0xDAA6_6D2B]);
/// ```
#[inline]
pub fn run_loops(work: impl Work) {
    InstructionSet::best().run(work);
}

/// Code over registers, written once.
pub trait RegisterWork: Sized {
    /// Runs it on registers R. Implementations are `#[inline(always)]`.
    fn run<R: Register>(self);
    /// Does the same without registers.
    #[inline(always)]
    fn run_alone(self) {
        self.run::<One<Baseline>>();
    }
}

/// Runs code over rows of `lanes` numbers, 1, 4 or a multiple of 8, on the widest registers of this machine of which they
/// are a whole number. Results have the same bits on any.
///
/// ```
/// use leafwise_expression::vector::{Register, RegisterWork, run_on_registers};
///
/// struct Double<'a>(&'a mut [f64]);
/// impl RegisterWork for Double<'_> {
///     #[inline(always)]
///     fn run<R: Register>(self) {
///         for row in self.0.chunks_exact_mut(R::LANES) {
///             (R::load(row) * R::splat(2.0)).store(row);
///         }
///     }
/// }
/// let mut values = [1.0, 2.5, 3.0, 4.0];
/// run_on_registers(4, Double(&mut values));
/// assert_eq!(values, [2.0, 5.0, 6.0, 8.0]);
/// ```
#[inline]
pub fn run_on_registers<W: RegisterWork>(lanes: usize, work: W) {
    let set = match lanes {
        _ if lanes.is_multiple_of(8) => InstructionSet::best(),
        _ if lanes.is_multiple_of(4) => InstructionSet::best_of_256_bits(),
        _ => InstructionSet(Kind::Baseline),
    };
    set.run_registers(work);
}

/// Code over one number, written once.
pub(crate) trait ScalarWork {
    /// The result.
    type Output;
    /// Runs it. Implementations are `#[inline(always)]`.
    fn run<F: Fused>(self) -> Self::Output;
}

/// Runs code over one number with the machine's fused products.
#[inline(always)]
pub(crate) fn run_scalar<W: ScalarWork>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("fma") {
        // SAFETY: the machine has the instructions.
        return unsafe { fused_scalar(work) };
    }
    baseline_scalar(work)
}

/// Apart from its caller, which then is a jump where the machine has the instructions.
#[cfg_attr(target_arch = "x86_64", cold, inline(never))]
fn baseline_scalar<W: ScalarWork>(work: W) -> W::Output {
    work.run::<Baseline>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "fma")]
fn fused_scalar<W: ScalarWork>(work: W) -> W::Output {
    work.run::<Hardware>()
}

/// Whether registers of 512 bits are taken: where the machine has them, and `LEAFWISE_VECTORS` in the environment is not 256.
/// Results have the same bits; the variable is there to measure what the width is worth.
#[cfg(target_arch = "x86_64")]
#[inline]
pub(crate) fn has_512_bits() -> bool {
    static FOUND: LazyLock<bool> = LazyLock::new(|| {
        is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && std::env::var_os("LEAFWISE_VECTORS").is_none_or(|bits| bits != "256")
    });
    *FOUND
}

/// One of the instruction sets of this machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InstructionSet(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Instructions that every machine of the target has.
    Baseline,
    /// 256-bit registers and fused products.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// 512-bit registers and masks.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl InstructionSet {
    /// The widest.
    #[inline]
    pub(crate) fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if has_512_bits() {
            return Self(Kind::Avx512);
        }
        Self::best_of_256_bits()
    }

    /// The widest of at most 256 bits.
    ///
    /// A 512-bit register that was just stored is slow to load: loops that go through memory from
    /// one operation to the next are faster in halves.
    #[inline]
    pub(crate) fn best_of_256_bits() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return Self(Kind::Avx2);
        }
        Self(Kind::Baseline)
    }

    /// All of this machine.
    #[cfg(test)]
    pub(crate) fn available() -> Vec<Self> {
        let mut all = vec![Self(Kind::Baseline)];
        for set in [Self::best_of_256_bits(), Self::best()] {
            if !all.contains(&set) {
                all.push(set);
            }
        }
        all
    }

    /// Runs loops.
    #[inline]
    pub(crate) fn run<W: Work>(self, work: W) {
        match self.0 {
            Kind::Baseline => work.run(),
            // SAFETY: an `InstructionSet` is made only of what this machine was found to have.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => unsafe { avx2_loops(work) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => unsafe { avx512_loops(work) },
        }
    }

    /// Runs code on the set's registers, without where it has none.
    #[inline]
    pub(crate) fn run_registers<W: RegisterWork>(self, work: W) {
        match self.0 {
            Kind::Baseline => work.run_alone(),
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => unsafe { avx2_registers(work) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => unsafe { avx512_registers(work) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn avx2_loops<W: Work>(work: W) {
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
fn avx512_loops<W: Work>(work: W) {
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn avx2_registers<W: RegisterWork>(work: W) {
    work.run::<avx2::Four>();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
fn avx512_registers<W: RegisterWork>(work: W) {
    work.run::<avx512::Eight>();
}

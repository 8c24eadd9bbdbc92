//! The formulas of a pair of functions near 0, as data.

use super::lanes::ElementaryPair;
use super::mirrored::Mirrored;
use super::turn::Turn;
use crate::vector::{Number, Tape, Traceable};

/// f(x) and g(x) where |x| is below a bound: to the bits of the pair, without a branch.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "jit"), allow(dead_code, reason = "for machine code"))]
pub(crate) struct NearZero {
    /// The operations in order, with their operands; an operation of two repeats its second.
    pub(crate) operations: Vec<(Traceable, [Number; 3])>,
    /// f(x) and g(x).
    pub(crate) values: [Number; 2],
    /// Size |x|, which must be below the bound.
    pub(crate) size: Number,
    pub(crate) bound: f64,
}

/// The formulas by which a pair goes where every argument is near 0.
fn near_zero<P: ElementaryPair>() -> NearZero {
    let tape = Tape::default();
    let (first, second, _) = P::ordinary(tape.argument());
    let values = [first.number, second.number];
    let (size, bound) = tape.limit().expect("a pair that looks whether x is near 0");
    NearZero {
        operations: tape.operations(),
        values,
        size,
        bound,
    }
}

/// Those of eˣ − 1 and e⁻ˣ − 1.
pub(crate) fn exp_m1_mirrored_near_zero() -> NearZero {
    near_zero::<Mirrored>()
}

/// Those of sin x and 1 − cos x.
pub(crate) fn sin_and_versine_near_zero() -> NearZero {
    near_zero::<Turn>()
}

//! √x, correctly rounded by the machine and by `libm`.

use crate::vector::Work;

/// x ↦ √x for each number.
pub(super) struct Roots<'a>(pub(super) &'a mut [f64]);

impl Work for Roots<'_> {
    #[inline(always)]
    #[allow(
        clippy::disallowed_methods,
        reason = "IEEE 754 asks for the correctly rounded root: one instruction for many lanes"
    )]
    fn run(self) {
        for value in self.0 {
            *value = value.sqrt();
        }
    }
}

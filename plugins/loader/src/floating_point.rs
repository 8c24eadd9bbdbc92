//! The floating-point control word of the calling thread.

use std::sync::{Mutex, PoisonError};

use crate::error::Refusal;

/// Rounding, masks and flush-to-zero of this thread, without the sticky exception flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ControlWord(u64);

#[cfg(target_arch = "x86_64")]
mod register {
    use std::arch::asm;

    /// The six exception flags, which every operation may set.
    const FLAGS: u32 = 0x3f;

    pub fn read() -> u64 {
        let mut word = 0_u32;
        // SAFETY: the instruction stores four bytes at the address given, which is a live u32.
        unsafe { asm!("stmxcsr [{}]", in(reg) &mut word, options(nostack, preserves_flags)) };
        (word & !FLAGS).into()
    }

    pub fn write(word: u64) {
        let word = u32::try_from(word).expect("the register has 32 bits");
        // SAFETY: the instruction loads four bytes from a live u32, which `read` took from the same
        // register, so that no reserved bit is set.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &word, options(nostack, readonly)) };
    }
}

#[cfg(target_arch = "aarch64")]
mod register {
    use std::arch::asm;

    pub fn read() -> u64 {
        let word: u64;
        // SAFETY: reads a register of this thread.
        unsafe { asm!("mrs {}, fpcr", out(reg) word, options(nomem, nostack, preserves_flags)) };
        word
    }

    pub fn write(word: u64) {
        // SAFETY: writes back what `read` took from this register.
        unsafe { asm!("msr fpcr, {}", in(reg) word, options(nomem, nostack)) };
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod register {
    pub fn read() -> u64 {
        0
    }

    pub fn write(_: u64) {}
}

impl ControlWord {
    /// That of this thread now.
    pub(crate) fn read() -> Self {
        Self(register::read())
    }

    /// Restores this word, and refuses what has changed it.
    pub(crate) fn restore(self, when: &str) -> Result<(), Refusal> {
        let after = Self::read();
        let flushes = flushes_to_zero();
        if after == self && !flushes {
            return Ok(());
        }
        register::write(self.0);
        Err(Refusal::FloatingPoint {
            when: when.to_owned(),
            before: self.0,
            after: after.0,
            flushes,
        })
    }
}

/// Change to how a thread computes, noticed too late to fail a call.
static CHANGE: Mutex<Option<String>> = Mutex::new(None);

/// Keeps the first change for [`change_of_arithmetic`].
pub(crate) fn note_change(what: String) {
    let mut change = CHANGE.lock().unwrap_or_else(PoisonError::into_inner);
    change.get_or_insert(what);
}

/// Change by a library to how this process computes, where no call could be failed for it any more. Numbers since may
/// be rounded in another way. Taken out, so that a second call gives `None`.
pub fn change_of_arithmetic() -> Option<String> {
    CHANGE.lock().unwrap_or_else(PoisonError::into_inner).take()
}

/// Whether a subnormal result becomes 0.
fn flushes_to_zero() -> bool {
    let tiny = std::hint::black_box(f64::MIN_POSITIVE);
    std::hint::black_box(tiny * 0.5) == 0.0
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    #[test]
    fn a_changed_control_word_is_reported_and_restored() {
        let before = ControlWord::read();
        assert_eq!(before.restore("opened"), Ok(()));
        // Flush to zero and denormals are zero.
        register::write(before.0 | 0x8040);
        let refusal = before.restore("opened").expect_err("it changed");
        assert_eq!(ControlWord::read(), before);
        assert!(!flushes_to_zero());
        let text = refusal.to_string();
        assert!(text.contains("floating-point environment changed when it was opened"));
        assert!(text.contains("subnormal numbers become 0"), "{text}");
    }
}

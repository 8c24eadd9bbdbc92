//! Numbers that start on a cache line.

use std::ops::{Deref, DerefMut};

/// A cache line and a register of the widest machines.
const ALIGNMENT: usize = 64;

/// A fixed number of doubles of which the first starts a cache line: no register of lanes then
/// lies across two (on AVX-512 that doubled an instruction's time).
#[derive(Debug)]
pub struct Aligned {
    buffer: Vec<f64>,
    start: usize,
    length: usize,
}

impl Aligned {
    /// The numbers of a cache line.
    pub const LINE: usize = ALIGNMENT / size_of::<f64>();

    /// `length` times `value`.
    pub fn filled(length: usize, value: f64) -> Self {
        let buffer = vec![value; length + Self::LINE];
        let offset = buffer.as_ptr().align_offset(ALIGNMENT);
        // `align_offset` may decline to answer, which costs nothing but time.
        let start = offset.min(buffer.len() - length);
        Self {
            buffer,
            start,
            length,
        }
    }
}

impl Deref for Aligned {
    type Target = [f64];

    #[inline]
    fn deref(&self) -> &[f64] {
        &self.buffer[self.start..][..self.length]
    }
}

impl DerefMut for Aligned {
    #[inline]
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.buffer[self.start..][..self.length]
    }
}

impl From<&[f64]> for Aligned {
    fn from(numbers: &[f64]) -> Self {
        let mut copy = Self::filled(numbers.len(), 0.0);
        copy.copy_from_slice(numbers);
        copy
    }
}

impl Clone for Aligned {
    fn clone(&self) -> Self {
        Self::from(&self[..])
    }
}

#[cfg(test)]
mod tests {
    use super::{ALIGNMENT, Aligned};

    #[test]
    fn a_copy_starts_a_cache_line_too() {
        for length in [0, 1, 7, 64, 1000] {
            let mut numbers = Aligned::filled(length, 1.5);
            numbers
                .iter_mut()
                .enumerate()
                .for_each(|(at, x)| *x += at as f64);
            let copy = numbers.clone();
            assert_eq!(copy[..], numbers[..]);
            assert_eq!(copy.len(), length);
            assert_eq!(copy.as_ptr().align_offset(ALIGNMENT), 0);
        }
    }
}

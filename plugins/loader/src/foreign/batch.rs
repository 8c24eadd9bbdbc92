//! Batches of vectors, as the interface lays them out.

use leafwise_plugin_abi::{LwInput, LwOutput};

/// One vector for each point of a batch, to be read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input<'a> {
    data: &'a [f64],
    dim: usize,
    point_stride: usize,
    coordinate_stride: usize,
}

impl<'a> Input<'a> {
    /// No vector.
    pub(crate) const NONE: Self = Self {
        data: &[],
        dim: 0,
        point_stride: 0,
        coordinate_stride: 0,
    };

    /// Contiguous vectors of `dim` coordinates.
    #[inline]
    pub(crate) fn points(data: &'a [f64], dim: usize) -> Self {
        Self {
            data,
            dim,
            point_stride: dim,
            coordinate_stride: 1,
        }
    }

    /// One vector that serves all points.
    pub(crate) fn shared(data: &'a [f64]) -> Self {
        Self {
            data,
            dim: data.len(),
            point_stride: 0,
            coordinate_stride: 1,
        }
    }

    /// Any layout.
    pub(crate) fn strided(
        data: &'a [f64],
        dim: usize,
        point_stride: usize,
        coordinate_stride: usize,
    ) -> Self {
        Self {
            data,
            dim,
            point_stride,
            coordinate_stride,
        }
    }

    /// The struct of the interface, where `count` vectors are there.
    #[inline]
    pub(super) fn raw(&self, count: usize) -> LwInput {
        if self.dim == 0 {
            return LwInput {
                data: std::ptr::null(),
                dim: 0,
                point_stride: 0,
                coordinate_stride: 0,
            };
        }
        let end = end(count, self.dim, self.point_stride, self.coordinate_stride);
        assert!(end <= self.data.len(), "a whole batch");
        LwInput {
            data: self.data.as_ptr(),
            dim: self.dim,
            point_stride: self.point_stride,
            coordinate_stride: self.coordinate_stride,
        }
    }
}

/// Marker of a place where nothing was written: a NaN with bits of its own.
pub(crate) fn unwritten() -> f64 {
    f64::from_bits(0x7ff8_1ea5_0000_ca4a)
}

/// Whether nothing was written to this place.
pub(crate) fn is_unwritten(value: f64) -> bool {
    value.to_bits() == unwritten().to_bits()
}

/// One vector for each point of a batch, to be written.
#[derive(Debug)]
pub(crate) struct Output<'a> {
    data: &'a mut [f64],
    dim: usize,
    point_stride: usize,
    coordinate_stride: usize,
}

impl<'a> Output<'a> {
    /// Contiguous vectors of `dim` coordinates.
    #[inline]
    pub(crate) fn points(data: &'a mut [f64], dim: usize) -> Self {
        Self {
            data,
            dim,
            point_stride: dim,
            coordinate_stride: 1,
        }
    }

    /// Any layout in which no two numbers share a place.
    pub(crate) fn strided(
        data: &'a mut [f64],
        dim: usize,
        point_stride: usize,
        coordinate_stride: usize,
    ) -> Self {
        Self {
            data,
            dim,
            point_stride,
            coordinate_stride,
        }
    }

    /// The struct of the interface, where there is room for `count` vectors.
    #[inline]
    pub(super) fn raw(&mut self, count: usize) -> LwOutput {
        let end = end(count, self.dim, self.point_stride, self.coordinate_stride);
        assert!(end <= self.data.len(), "room for a batch");
        LwOutput {
            data: self.data.as_mut_ptr(),
            dim: self.dim,
            point_stride: self.point_stride,
            coordinate_stride: self.coordinate_stride,
        }
    }

    /// Marks the places of `count` vectors as not written, so that what a call leaves out is told from
    /// what it writes.
    #[inline]
    pub(super) fn clear(&mut self, count: usize) {
        if self.data.len() == count * self.dim {
            self.data.fill(unwritten());
            return;
        }
        for point in 0..count {
            for coordinate in 0..self.dim {
                self.data[point * self.point_stride + coordinate * self.coordinate_stride] =
                    unwritten();
            }
        }
    }

    /// The number at a place of the batch.
    pub(super) fn at(&self, point: usize, coordinate: usize) -> f64 {
        self.data[point * self.point_stride + coordinate * self.coordinate_stride]
    }

    /// Whether every number of the batch is finite.
    #[inline]
    pub(super) fn is_finite(&self, count: usize) -> bool {
        let is_dense = self.data.len() == count * self.dim;
        are_finite(self.data) || (!is_dense && self.first_not_finite(count).is_none())
    }

    /// The first point and coordinate that is not finite, by the bits of the exponent.
    pub(super) fn first_not_finite(&self, count: usize) -> Option<(usize, usize)> {
        (0..count)
            .flat_map(|point| (0..self.dim).map(move |coordinate| (point, coordinate)))
            .find(|(point, coordinate)| {
                self.at(*point, *coordinate).to_bits() & EXPONENT == EXPONENT
            })
    }
}

/// The exponent's bits; all of them are set in a number that is not finite.
const EXPONENT: u64 = 0x7ff0_0000_0000_0000;

/// From how many numbers on it pays to ask for wide registers.
const WIDE: usize = 32;

/// Whether all numbers are finite.
#[inline]
fn are_finite(values: &[f64]) -> bool {
    #[cfg(target_arch = "x86_64")]
    if values.len() >= WIDE && is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2.
        return unsafe { are_finite_wide(values) };
    }
    exponents_leave_room(values)
}

/// The same on registers of four numbers.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn are_finite_wide(values: &[f64]) -> bool {
    exponents_leave_room(values)
}

/// Whether no exponent is the largest one: one more in it is the sign's bit. Without a branch, so that
/// several are looked at at once.
#[inline(always)]
fn exponents_leave_room(values: &[f64]) -> bool {
    const UNIT: u64 = 1 << 52;
    let above = |value: &f64| (value.to_bits() & EXPONENT) + UNIT;
    values.iter().fold(0, |any, value| any | above(value)) >> 63 == 0
}

/// One more than the largest index that a batch touches; 0 for none.
#[inline]
fn end(count: usize, dim: usize, point: usize, coordinate: usize) -> usize {
    if count == 0 || dim == 0 {
        return 0;
    }
    (count - 1) * point + (dim - 1) * coordinate + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_is_found_by_point_and_coordinate() {
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -f64::NAN] {
            let mut values = [1.0, f64::MAX, 5e-324, -0.0, wrong, wrong];
            let found = |output: Output<'_>, count: usize| {
                let first = output.first_not_finite(count);
                assert_eq!(output.is_finite(count), first.is_none());
                first
            };
            assert_eq!(found(Output::points(&mut values, 2), 3), Some((2, 0)));
            assert_eq!(found(Output::points(&mut values, 2), 2), None);
            let lanes = Output::strided(&mut values, 3, 1, 2);
            assert_eq!(found(lanes, 2), Some((0, 2)));
            // Gaps are not looked at.
            let gaps = Output::strided(&mut values, 2, 2, 1);
            assert_eq!(found(gaps, 2), None);
        }
    }

    #[test]
    fn one_number_among_many_is_found() {
        for count in [1, 31, 32, 33, 100] {
            let mut values = vec![f64::MAX; count];
            assert!(Output::points(&mut values, 1).is_finite(count));
            for at in 0..count {
                values[at] = f64::NEG_INFINITY;
                assert!(
                    !Output::points(&mut values, 1).is_finite(count),
                    "{at} of {count}"
                );
                values[at] = -f64::MAX;
            }
        }
    }

    #[test]
    #[should_panic(expected = "room for a batch")]
    fn a_batch_never_reaches_beyond_its_buffer() {
        let mut values = [0.0; 5];
        Output::points(&mut values, 3).raw(2);
    }
}

//! Arrays of a caller, with strides.

use crate::call_error::CallError;

/// The most numbers that an array may have: its bytes are fewer than `isize::MAX`.
const MOST: usize = isize::MAX as usize / size_of::<f64>();

/// Numbers that a caller lets this library read or write: element i at `data[i*stride]`.
#[derive(Clone, Copy)]
pub(crate) struct Strided<T> {
    pub(crate) data: T,
    pub(crate) length: usize,
    pub(crate) stride: isize,
}

/// StridedRows of numbers: element j of row i at `data[i*row_stride + j*stride]`.
#[derive(Clone, Copy)]
pub(crate) struct StridedRows<T> {
    pub(crate) data: T,
    pub(crate) rows: usize,
    pub(crate) row_stride: isize,
    pub(crate) stride: isize,
}

/// Refuses NULL, another length, and strides that lead out of memory.
fn check(
    what: &str,
    is_null: bool,
    length: usize,
    expected: usize,
    stride: isize,
) -> Result<(), CallError> {
    if is_null {
        return Err(CallError::usage(format!("{what} is NULL")));
    }
    if length != expected {
        return Err(CallError::usage(format!(
            "{what} has {length} numbers, and the scene {expected}"
        )));
    }
    if length
        .checked_mul(stride.unsigned_abs())
        .is_none_or(|reach| reach > MOST)
    {
        return Err(CallError::usage(format!(
            "{what} has a stride of {stride}, which reaches outside the address space"
        )));
    }
    Ok(())
}

impl Strided<*const f64> {
    /// The numbers, of which there must be `expected`.
    ///
    /// # Safety
    /// `data` is NULL, or element i may be read for every i < length.
    pub(crate) unsafe fn read(self, what: &str, expected: usize) -> Result<Vec<f64>, CallError> {
        check(
            what,
            self.data.is_null(),
            self.length,
            expected,
            self.stride,
        )?;
        let place = |i: usize| self.data.wrapping_offset(i as isize * self.stride);
        // SAFETY: the caller vouches for every element, and `check` for the offsets.
        Ok((0..expected)
            .map(|i| unsafe { place(i).read_unaligned() })
            .collect())
    }
}

impl Strided<*mut f64> {
    /// Refuses a place for other than so many numbers.
    pub(crate) fn check(self, what: &str, expected: usize) -> Result<(), CallError> {
        check(
            what,
            self.data.is_null(),
            self.length,
            expected,
            self.stride,
        )
    }

    /// Writes numbers, of which there must be as many as the array has.
    ///
    /// # Safety
    /// `data` is NULL, or element i may be written for every i < length.
    pub(crate) unsafe fn write(self, what: &str, values: &[f64]) -> Result<(), CallError> {
        check(
            what,
            self.data.is_null(),
            self.length,
            values.len(),
            self.stride,
        )?;
        for (i, value) in values.iter().enumerate() {
            let place = self.data.wrapping_offset(i as isize * self.stride);
            // SAFETY: the caller vouches for every element, and `check` for the offset.
            unsafe { place.write_unaligned(*value) };
        }
        Ok(())
    }
}

impl<T: Copy> StridedRows<T> {
    /// Refuses rows that lead out of memory.
    pub(crate) fn check(self, what: &str, is_null: bool, width: usize) -> Result<(), CallError> {
        check(what, is_null, self.rows, self.rows, self.row_stride)?;
        check(what, is_null, width, width, self.stride)?;
        let reach = self.rows.checked_mul(self.row_stride.unsigned_abs());
        let own = width.checked_mul(self.stride.unsigned_abs());
        let reach = reach.and_then(|rows| rows.checked_add(own?));
        match reach {
            Some(reach) if reach <= MOST => Ok(()),
            _ => Err(CallError::usage(format!(
                "{what} reaches outside the address space"
            ))),
        }
    }

    fn offset(self, row: usize) -> isize {
        row as isize * self.row_stride
    }
}

impl StridedRows<*const f64> {
    /// The numbers row by row, each row `width` of them.
    ///
    /// # Safety
    /// `data` is NULL, or element j of row i may be read for every i < rows and j < width.
    pub(crate) unsafe fn read(self, what: &str, width: usize) -> Result<Vec<f64>, CallError> {
        self.check(what, self.data.is_null(), width)?;
        let mut values = Vec::new();
        for row in 0..self.rows {
            let row = Strided {
                data: self.data.wrapping_offset(self.offset(row)),
                length: width,
                stride: self.stride,
            };
            // SAFETY: the caller vouches for every element of the row.
            values.extend(unsafe { row.read(what, width) }?);
        }
        Ok(values)
    }
}

impl StridedRows<*mut f64> {
    /// Writes rows of `width` numbers, of which there must be as many as the array has.
    ///
    /// # Safety
    /// `data` is NULL, or element j of row i may be written for every i < rows and j < width.
    pub(crate) unsafe fn write(
        self,
        what: &str,
        values: &[f64],
        width: usize,
    ) -> Result<(), CallError> {
        self.check(what, self.data.is_null(), width)?;
        for (row, values) in values.chunks_exact(width).take(self.rows).enumerate() {
            let row = Strided {
                data: self.data.wrapping_offset(self.offset(row)),
                length: width,
                stride: self.stride,
            };
            // SAFETY: the caller vouches for every element of the row.
            unsafe { row.write(what, values) }?;
        }
        Ok(())
    }
}

//! Fields one after the other in one array, so that a kernel finds all of them from one place.

use std::ops::Range;

use leafwise_expression::Aligned;

use super::stages::Field;

/// The numbers a program works on.
#[derive(Clone, Debug)]
pub struct Fields {
    numbers: Aligned,
    dimension: usize,
}

/// From the start of one field to that of the next: each starts a cache line.
pub(super) fn stride(dimension: usize) -> usize {
    dimension.next_multiple_of(Aligned::LINE)
}

impl Fields {
    /// So many fields of zeros.
    pub(super) fn zeros(fields: usize, dimension: usize) -> Self {
        Self {
            numbers: Aligned::filled(fields * stride(dimension), 0.0),
            dimension,
        }
    }

    /// A field's values.
    pub fn get(&self, field: Field) -> &[f64] {
        &self.numbers[self.range(field)]
    }

    /// A field's values, to be written.
    pub fn get_mut(&mut self, field: Field) -> &mut [f64] {
        let range = self.range(field);
        &mut self.numbers[range]
    }

    /// Makes all numbers 0.
    pub fn clear(&mut self) {
        self.numbers.fill(0.0);
    }

    fn range(&self, field: Field) -> Range<usize> {
        let start = field.0 * stride(self.dimension);
        start..start + self.dimension
    }

    /// All fields, each [`stride`] numbers behind the one before it.
    pub(super) fn all_mut(&mut self) -> &mut [f64] {
        &mut self.numbers
    }

    /// Copies a range of a field to the same place of another one.
    pub(super) fn copy(&mut self, from: Field, to: Field, range: Range<usize>) {
        let [from, to] = [from, to].map(|field| self.range(field).start + range.start);
        self.numbers.copy_within(from..from + range.len(), to);
    }
}

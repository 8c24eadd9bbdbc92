//! Measures of corrections that doubles and code share, line by line.

/// Beside this a few of the smallest numbers, which have no digits, are a negligible remainder: components that die out pass
/// through them to 0.
pub(crate) const SMALLEST_SCALE: f64 = 1e-303;

/// How many times the size of a state what a step adds to it may be and still serve as a scale. A
/// correction that is negligible beside it is below an ulp of the state.
const MOST_GROWTH: f64 = 1024.0;

/// min of a and b, which counts only where it is a number.
#[inline(always)]
pub fn at_most(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// Arithmetic that measures are formed in: that of doubles, or of values in code, several components at once.
pub(crate) trait Numbers {
    /// A number.
    type Number;
    /// One that is known, beside another.
    fn known(&mut self, value: f64, beside: &Self::Number) -> Self::Number;
    /// |a|.
    fn magnitude(&mut self, a: &Self::Number) -> Self::Number;
    /// a + b.
    fn add(&mut self, a: &Self::Number, b: &Self::Number) -> Self::Number;
    /// a b.
    fn multiply(&mut self, a: &Self::Number, b: &Self::Number) -> Self::Number;
    /// a/b.
    fn divide(&mut self, a: &Self::Number, b: &Self::Number) -> Self::Number;
    /// min of a and b.
    fn smaller(&mut self, a: &Self::Number, b: &Self::Number) -> Self::Number;
}

/// Doubles.
pub(crate) struct Doubles;

impl Numbers for Doubles {
    type Number = f64;

    #[inline(always)]
    fn known(&mut self, value: f64, _: &f64) -> f64 {
        value
    }

    #[inline(always)]
    fn magnitude(&mut self, a: &f64) -> f64 {
        a.abs()
    }

    #[inline(always)]
    fn add(&mut self, a: &f64, b: &f64) -> f64 {
        a + b
    }

    #[inline(always)]
    fn multiply(&mut self, a: &f64, b: &f64) -> f64 {
        a * b
    }

    #[inline(always)]
    fn divide(&mut self, a: &f64, b: &f64) -> f64 {
        a / b
    }

    #[inline(always)]
    fn smaller(&mut self, a: &f64, b: &f64) -> f64 {
        at_most(*a, *b)
    }
}

/// |size|/(scale + |size|), 0 for 0: a component that has no scale yet counts as 1.
#[inline(always)]
pub(crate) fn relative_size<N: Numbers>(
    numbers: &mut N,
    size: &N::Number,
    scale: &N::Number,
) -> N::Number {
    let size = numbers.magnitude(size);
    let smallest = numbers.known(SMALLEST_SCALE, &size);
    let sum = numbers.add(scale, &size);
    let sum = numbers.add(&sum, &smallest);
    numbers.divide(&size, &sum)
}

/// |x| + min(1024 allowed, `change`) + `reached`, of the size of a change: the scale that a correction is judged against.
#[inline(always)]
pub(crate) fn scale_beside<N: Numbers>(
    numbers: &mut N,
    [x, change, allowed, reached]: [&N::Number; 4],
) -> N::Number {
    let growth = numbers.known(MOST_GROWTH, allowed);
    let most = numbers.multiply(&growth, allowed);
    let x = numbers.magnitude(x);
    let change = numbers.smaller(&most, change);
    let own = numbers.add(&x, &change);
    numbers.add(&own, reached)
}

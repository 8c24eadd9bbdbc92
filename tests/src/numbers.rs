//! Sizes and distances of vectors, componentwise errors, decimal strings of reference data.

use std::borrow::Borrow;

use serde_json::Value;

/// u, half a unit in the last place of 1.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// A decimal string of reference data, rounded to the nearest double.
///
/// # Panics
/// When the value is not a string that holds a number.
pub fn decimal(value: &Value) -> f64 {
    let text = value.as_str().expect("reference numbers are strings");
    text.parse()
        .unwrap_or_else(|error| panic!("`{text}`: {error}"))
}

/// A list of decimal strings.
///
/// # Panics
/// When the value is not a list of such strings.
pub fn decimals(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list of numbers");
    list.iter().map(decimal).collect()
}

/// max |vᵢ|; NaN if any entry is.
pub fn largest<V>(values: V) -> f64
where
    V: IntoIterator,
    V::Item: Borrow<f64>,
{
    let sizes = values.into_iter().map(|v| v.borrow().abs());
    sizes.fold(0.0, |m: f64, v| if m.is_nan() || v <= m { m } else { v })
}

/// max |aᵢ − bᵢ|; NaN if any entry is.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len(), "vectors of one length");
    largest(a.iter().zip(b).map(|(a, b)| a - b))
}

/// max |found_i − expected_i| / |expected_i|; where an expected entry is 0, relative to `scale`.
pub fn relative_error(found: &[f64], expected: &[f64], scale: f64) -> f64 {
    assert_eq!(found.len(), expected.len(), "vectors of one length");
    let errors: Vec<f64> = found
        .iter()
        .zip(expected)
        .map(
            |(&f, &e)| match (f - e, if e == 0.0 { scale } else { e.abs() }) {
                (0.0, _) => 0.0,
                (difference, size) => difference / size,
            },
        )
        .collect();
    largest(&errors)
}

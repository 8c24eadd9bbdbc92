//! Decimal strings of reference data, componentwise errors.

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

/// The largest absolute value.
pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(
        0.0,
        |m, v| if v.is_nan() { f64::NAN } else { v.abs().max(m) },
    )
}

/// max |found_i − expected_i|.
pub fn distance(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len(), "vectors of one length");
    let differences: Vec<f64> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
    largest(&differences)
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

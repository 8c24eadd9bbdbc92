//! Numbers as reports show them.

/// A number with up to twelve digits.
pub(crate) fn short(value: f64) -> String {
    rounded(value, 12)
}

/// A number with up to this many digits, at least one.
pub(crate) fn rounded(value: f64, digits: usize) -> String {
    let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    if rounded == 0.0 || (1e-4..1e9).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

/// A value of a row; not a number beyond its end.
pub(crate) fn value(row: &[f64], column: usize) -> f64 {
    row.get(column).copied().unwrap_or(f64::NAN)
}

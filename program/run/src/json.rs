//! Numbers as JSON.

use serde_json::Value;

/// A double as JSON; what JSON has no number for is the string "NaN", "Infinity" or "-Infinity".
pub fn json_number(value: f64) -> Value {
    serde_json::Number::from_f64(value).map_or_else(
        || {
            let name = if value.is_nan() {
                "NaN"
            } else if value > 0.0 {
                "Infinity"
            } else {
                "-Infinity"
            };
            Value::from(name)
        },
        Value::Number,
    )
}

/// A list of doubles as JSON.
pub fn json_numbers(values: &[f64]) -> Value {
    values.iter().map(|value| json_number(*value)).collect()
}

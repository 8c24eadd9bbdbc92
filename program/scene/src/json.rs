//! Values that JSON has no word for: doubles that are not finite, and lists of named values as objects.
//!
//! The functions for `serialize_with` have the errors of the serializer.

use std::io;

use serde::{Serialize, Serializer};

/// A double. What JSON has no number for is the string "NaN", "Infinity" or "-Infinity".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Double(pub f64);

impl Serialize for Double {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            // A binary format has all doubles.
            value if value.is_finite() || !serializer.is_human_readable() => {
                serializer.serialize_f64(value)
            }
            f64::INFINITY => serializer.serialize_str("Infinity"),
            f64::NEG_INFINITY => serializer.serialize_str("-Infinity"),
            _ => serializer.serialize_str("NaN"),
        }
    }
}

/// For `serialize_with`: a [`Double`].
pub fn double<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Double(*value).serialize(serializer)
}

/// For `serialize_with`: a [`Double`] or nothing.
pub fn optional<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    value.map(Double).serialize(serializer)
}

/// For `serialize_with`: a list of [`Double`]s.
pub fn doubles<S: Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(values.iter().copied().map(Double))
}

/// For `serialize_with`: a list of pairs of [`Double`]s.
pub fn points<S: Serializer>(points: &[(f64, f64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(points.iter().map(|(x, y)| (Double(*x), Double(*y))))
}

/// For `serialize_with`: named values as one object, in their order.
pub fn object<S: Serializer, N: Serialize, V: Serialize>(
    values: &[(N, V)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(values.iter().map(|(name, value)| (name, value)))
}

/// A value as lines of JSON; a name that an object has twice keeps the last value.
///
/// # Errors
/// A path that is not Unicode.
pub fn pretty(value: &impl Serialize) -> io::Result<String> {
    Ok(format!("{:#}", serde_json::to_value(value)?))
}

#[cfg(test)]
mod tests {
    use serde::Serialize;

    /// Every way to write a double.
    #[derive(Serialize)]
    struct Doubles {
        #[serde(serialize_with = "super::double")]
        one: f64,
        #[serde(serialize_with = "super::optional")]
        none: Option<f64>,
        #[serde(serialize_with = "super::doubles")]
        list: Vec<f64>,
        #[serde(serialize_with = "super::points")]
        points: Vec<(f64, f64)>,
        #[serde(serialize_with = "super::object")]
        object: Vec<(&'static str, super::Double)>,
    }

    #[test]
    fn doubles_that_json_lacks_are_words() {
        let doubles = Doubles {
            one: f64::NAN,
            none: None,
            list: vec![f64::INFINITY, -0.0, 0.1],
            points: vec![(1.0, f64::NEG_INFINITY)],
            object: vec![("z", super::Double(1e300)), ("a", super::Double(-f64::NAN))],
        };
        let text = serde_json::to_string(&doubles).expect("JSON");
        let expected = r#"{"one":"NaN","none":null,"list":["Infinity",-0.0,0.1],"points":[[1.0,"-Infinity"]],"object":{"z":1e+300,"a":"NaN"}}"#;
        assert_eq!(text, expected);
    }
}

//! The recorded states as text within the page, from which its script draws.

use serde::Serialize;

use super::data::{Recorded, ReportData, Trajectory};

/// The most numbers that a page carries: half a megabyte of text.
const MOST_NUMBERS: usize = 48_000;

/// The most columns, the time among them.
const MOST_COLUMNS: usize = 48;

/// Data for the page's script: the recorded states.
#[derive(Serialize)]
pub(super) struct Explored {
    /// The columns' names, a line each; the time is the first.
    names: String,
    /// How many of them are coordinates.
    coordinates: usize,
    /// The columns over which the orbit is first drawn.
    axes: String,
    /// Center and semi-axes of the leaf; empty without one.
    leaf: String,
    /// One state of so many is there.
    stride: usize,
    /// Columns one after the other, little-endian doubles in base 64.
    numbers: String,
}

impl Explored {
    /// Of recorded states, if there are two at least, and something beside the time.
    pub fn of(data: &ReportData) -> Option<Self> {
        let Recorded {
            names,
            coordinates,
            rows,
        } = data.recorded.as_ref()?;
        let own = (*coordinates).min(names.len().saturating_sub(1));
        let others = names.len().saturating_sub(1 + own);
        let room = (MOST_COLUMNS - 1).saturating_sub(others);
        let first = own.min(room.max(MOST_COLUMNS / 2));
        let columns: Vec<usize> = (0..=first)
            .chain(1 + own..names.len())
            .take(MOST_COLUMNS)
            .collect();
        if rows.len() < 2 || columns.len() < 2 {
            return None;
        }
        let stride = (rows.len() * columns.len()).div_ceil(MOST_NUMBERS);
        let mut kept: Vec<_> = rows.iter().step_by(stride).collect();
        if !(rows.len() - 1).is_multiple_of(stride) {
            kept.extend(rows.last());
        }
        let mut bytes = Vec::with_capacity(8 * kept.len() * columns.len());
        for column in &columns {
            for row in &kept {
                let value = row.get(*column).copied().unwrap_or(f64::NAN);
                bytes.extend(value.to_le_bytes());
            }
        }
        let named: Vec<&str> = columns.iter().map(|at| names[*at].as_str()).collect();
        let place = |name: &String| named.iter().position(|known| known == name);
        let (axes, leaf) = match &data.trajectory {
            Some(Trajectory::Orbit { names, leaf, .. }) => {
                (names.iter().take(3).filter_map(place).collect(), *leaf)
            }
            _ => (Vec::new(), None),
        };
        let leaf = leaf.map(|leaf| [leaf.center, leaf.semi_axes].concat());
        Some(Self {
            names: named.join("\n"),
            coordinates: first,
            axes: words(&axes),
            leaf: leaf.as_deref().map(words).unwrap_or_default(),
            stride,
            numbers: base64(&bytes),
        })
    }
}

fn words<T: ToString>(values: &[T]) -> String {
    let words: Vec<String> = values.iter().map(T::to_string).collect();
    words.join(" ")
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |at: usize| u32::from(group.get(at).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for at in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * at) & 63) as usize];
            text.push(if at <= group.len() {
                char::from(letter)
            } else {
                '='
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::base64;

    /// The examples of RFC 4648, section 10.
    #[test]
    fn base_64_is_that_of_its_standard() {
        let pairs = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (bytes, text) in pairs {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}

//! Arrays of numbers in NumPy's format (NEP 1, versions 1 to 3).

use std::path::Path;

use leafwise_core::NumberArray;

use crate::input::{LARGEST_TABLE, read_bounded};

/// First bytes of such a file.
const MAGIC: &[u8] = b"\x93NUMPY";

/// The array of a file: doubles, floats or whole numbers of 32 or 64 bits, of either order of bytes and axes.
///
/// # Errors
/// The reason where it is none.
pub fn read_npy(path: &Path) -> Result<NumberArray, String> {
    let bytes = read_bounded(path, LARGEST_TABLE);
    let bytes = bytes.map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    array(&bytes).map_err(|reason| format!("{}: {reason}", path.display()))
}

fn array(bytes: &[u8]) -> Result<NumberArray, String> {
    let not_one = || "it is not an array of NumPy's: `numpy.save` writes one".to_owned();
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(not_one)?;
    let (length, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => {
            let length = u32::from_le_bytes([*a, *b, *c, *d]);
            (usize::try_from(length).map_err(|_| not_one())?, rest)
        }
        _ => return Err(not_one()),
    };
    let (header, data) = rest.split_at_checked(length).ok_or_else(not_one)?;
    let header = std::str::from_utf8(header).map_err(|_| not_one())?;
    let field = |name: &str| {
        let (_, behind) = header.split_once(&format!("'{name}':"))?;
        Some(behind.trim_start())
    };
    let descr = field("descr").and_then(|text| text.strip_prefix('\'')?.split_once('\''));
    let (kind, _) = descr.ok_or_else(|| "its numbers are not of a plain type".to_owned())?;
    let is_fortran = field("fortran_order").is_some_and(|text| text.starts_with("True"));
    let shape = field("shape").and_then(|text| text.strip_prefix('(')?.split_once(')'));
    let (shape, _) = shape.ok_or_else(not_one)?;
    let lengths = shape
        .split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty());
    let lengths: Result<Vec<usize>, _> = lengths.map(str::parse).collect();
    let shape = lengths.map_err(|_| not_one())?;
    let numbers = numbers(kind, data)?;
    let count = shape
        .iter()
        .try_fold(1_usize, |all, own| all.checked_mul(*own));
    if count != Some(numbers.len()) {
        let found = numbers.len();
        return Err(format!(
            "it ends early: {found} numbers, and its shape is {shape:?}"
        ));
    }
    let numbers = match is_fortran {
        true => last_axis_fastest(&numbers, &shape),
        false => numbers,
    };
    Ok(NumberArray { shape, numbers })
}

fn numbers(kind: &str, data: &[u8]) -> Result<Vec<f64>, String> {
    fn each<const N: usize>(data: &[u8], of: impl Fn([u8; N]) -> f64) -> Vec<f64> {
        data.as_chunks().0.iter().map(|bytes| of(*bytes)).collect()
    }
    Ok(match kind {
        "<f8" => each(data, f64::from_le_bytes),
        ">f8" => each(data, f64::from_be_bytes),
        "<f4" => each(data, |bytes| f32::from_le_bytes(bytes).into()),
        ">f4" => each(data, |bytes| f32::from_be_bytes(bytes).into()),
        "<i4" => each(data, |bytes| i32::from_le_bytes(bytes).into()),
        ">i4" => each(data, |bytes| i32::from_be_bytes(bytes).into()),
        "<i8" => each(data, |bytes| i64::from_le_bytes(bytes) as f64),
        ">i8" => each(data, |bytes| i64::from_be_bytes(bytes) as f64),
        _ => {
            return Err(format!(
                "its numbers are of the kind {kind}: save it as doubles, numpy.save(file, array.astype(float))"
            ));
        }
    })
}

/// Numbers of which the first axis is fastest, in the other order.
fn last_axis_fastest(numbers: &[f64], shape: &[usize]) -> Vec<f64> {
    let place = |at: usize| {
        let mut rest = at;
        let mut node = vec![0; shape.len()];
        for (place, length) in node.iter_mut().zip(shape).rev() {
            *place = rest % length;
            rest /= length;
        }
        let axes = node.iter().zip(shape).rev();
        axes.fold(0, |place, (at, length)| place * length + at)
    };
    (0..numbers.len()).map(|at| numbers[place(at)]).collect()
}

#[cfg(test)]
mod tests {
    use super::array;

    /// A file as `numpy.save` writes it.
    fn file(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY".to_vec();
        bytes.extend([version, 0]);
        let length = header.len() as u32;
        let length = length.to_le_bytes();
        bytes.extend(if version == 1 {
            &length[..2]
        } else {
            &length[..]
        });
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    fn header(kind: &str, fortran: &str, shape: &str) -> String {
        format!("{{'descr': '{kind}', 'fortran_order': {fortran}, 'shape': {shape}, }}   \n")
    }

    #[test]
    fn numbers_of_each_kind_are_read_in_the_order_of_the_last_axis() {
        let values: Vec<f64> = (0..6).map(f64::from).collect();
        let doubles: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        let large: Vec<u8> = values.iter().flat_map(|x| x.to_be_bytes()).collect();
        let floats: Vec<u8> = (0..6).flat_map(|x| (x as f32).to_le_bytes()).collect();
        let whole: Vec<u8> = (0..6_i64).flat_map(|x| x.to_be_bytes()).collect();
        for (kind, data) in [
            ("<f8", &doubles),
            (">f8", &large),
            ("<f4", &floats),
            (">i8", &whole),
        ] {
            for version in [1, 2] {
                let bytes = file(version, &header(kind, "False", "(2, 3)"), data);
                let read = array(&bytes).expect(kind);
                assert_eq!((read.shape, read.numbers), (vec![2, 3], values.clone()));
            }
        }
        let read = array(&file(1, &header("<f8", "True", "(2, 3)"), &doubles)).expect("an array");
        assert_eq!(read.numbers, [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
        let read = array(&file(1, &header("<f8", "False", "(6,)"), &doubles)).expect("an array");
        assert_eq!(read.shape, [6]);
    }

    #[test]
    fn what_is_no_array_is_refused() {
        let doubles = [0; 40];
        for (bytes, said) in [
            (b"1,2,3".to_vec(), "not an array of NumPy's"),
            (
                file(1, &header("<c16", "False", "(2,)"), &doubles),
                "of the kind <c16",
            ),
            (
                file(1, &header("<f8", "False", "(6,)"), &doubles),
                "ends early: 5 numbers",
            ),
            (
                file(1, "{'descr': [('a', '<f8')]}", &doubles),
                "not of a plain type",
            ),
            (file(9, "", &doubles), "not an array of NumPy's"),
        ] {
            let error = array(&bytes).expect_err(said);
            assert!(error.contains(said), "{error}");
        }
    }
}

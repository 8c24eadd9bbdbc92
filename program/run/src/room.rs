//! Memory for what is kept: asked for before it is needed, so that its want is an error and not the end of the process.

use std::fmt;

use thiserror::Error;

/// There is not enough memory for what would be kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub struct NoRoom {
    /// Rows that would be kept, where their number is known.
    pub rows: Option<u64>,
    /// Numbers in each.
    pub width: usize,
    /// Bytes that are free, where the system says it.
    pub free: Option<u64>,
}

impl fmt::Display for NoRoom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.width;
        match self.rows {
            Some(rows) => {
                let size = size(bytes(rows, width));
                write!(
                    f,
                    "{rows} samples of {width} numbers each take {size} of memory, "
                )?;
            }
            None => write!(
                f,
                "there is no memory for more samples of {width} numbers each, "
            )?,
        }
        match self.free {
            Some(free) => write!(f, "and {} are free", size(free.into()))?,
            None => write!(f, "more than there is")?,
        }
        write!(f, "; keep fewer: `record` one every so many steps")
    }
}

fn bytes(rows: u64, width: usize) -> u128 {
    let numbers = u128::from(rows).saturating_mul(width as u128);
    numbers.saturating_mul(8)
}

/// A size for people.
fn size(bytes: u128) -> String {
    let units = ["bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
    let mut value = bytes as f64;
    let mut at = 0;
    while value >= 1024.0 && at + 1 < units.len() {
        (value, at) = (value / 1024.0, at + 1);
    }
    match at {
        0 => format!("{bytes} bytes"),
        _ => format!("{value:.1} {}", units[at]),
    }
}

/// A vector without numbers that has room for so many rows.
///
/// # Errors
/// [`NoRoom`].
pub fn with_room(rows: u64, width: usize) -> Result<Vec<f64>, NoRoom> {
    let bytes = bytes(rows, width);
    let is_large = bytes >= 8 * LARGE as u128;
    let no_room = NoRoom {
        rows: Some(rows),
        width,
        free: if is_large { free() } else { None },
    };
    if no_room.free.is_some_and(|free| bytes > u128::from(free)) {
        return Err(no_room);
    }
    let mut values = Vec::new();
    let count = usize::try_from(bytes / 8).map_err(|_| no_room)?;
    reserve(&mut values, count).ok_or(no_room)?;
    Ok(values)
}

/// Makes room for so many more numbers, and sees that after them there is some left for everything else.
fn reserve(values: &mut Vec<f64>, count: usize) -> Option<()> {
    values.try_reserve_exact(count).ok()?;
    let mut rest: Vec<u8> = Vec::new();
    if count >= LARGE / 8 && rest.try_reserve_exact(REST).is_err() {
        values.shrink_to_fit();
        return None;
    }
    Some(())
}

/// Bytes for all that is not samples: a report, a few kernels.
const REST: usize = 1 << 26;

/// From so many numbers on the system is asked whether there is memory for as many more.
const LARGE: usize = 1 << 23;

/// Makes room for one more row.
///
/// # Errors
/// [`NoRoom`].
pub(crate) fn make_room(values: &mut Vec<f64>, width: usize) -> Result<(), NoRoom> {
    if values.len() + width <= values.capacity() {
        return Ok(());
    }
    let more = values.len().max(width);
    let free = if more < LARGE { None } else { free() };
    let no_room = NoRoom {
        rows: None,
        width,
        free,
    };
    if free.is_some_and(|free| 8 * more as u64 > free) {
        return Err(no_room);
    }
    reserve(values, more).ok_or(no_room)
}

/// The bytes that programs may still take without others being pushed out, where the system says it.
fn free() -> Option<u64> {
    let told = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = told
        .lines()
        .find(|line| line.starts_with("MemAvailable:"))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::{make_room, with_room};

    #[test]
    fn what_has_no_room_is_refused_with_its_size() {
        let refused = with_room(1_000_000_000_001, 4).expect_err("32 TB");
        let told = refused.to_string();
        assert!(
            told.starts_with("1000000000001 samples of 4 numbers each take 29.1 TiB of memory, "),
            "{told}"
        );
        assert!(
            told.ends_with("; keep fewer: `record` one every so many steps"),
            "{told}"
        );
        assert!(with_room(u64::MAX, usize::MAX).is_err());
    }

    #[test]
    fn rows_that_are_not_counted_find_room_one_by_one() {
        let mut values = with_room(0, 3).expect("nothing");
        for row in 0..1000 {
            make_room(&mut values, 3).expect("24 kB");
            values.extend([f64::from(row); 3]);
        }
        assert_eq!(values.len(), 3000);
        assert!(values.capacity() <= 2 * 3000);
    }
}

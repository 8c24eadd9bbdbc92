//! Files that are read whole, within bounds: a device or a pipe may never end.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// A scene is no larger, in bytes.
pub const LARGEST_SCENE: u64 = 1 << 26;

/// A file of states is no larger, in bytes.
pub(crate) const LARGEST_TABLE: u64 = 1 << 32;

/// Bytes read between two looks at them.
const CHUNK: u64 = 1 << 20;

/// All bytes of a file, at most `most`.
///
/// # Errors
/// The system's, and [`ErrorKind::FileTooLarge`].
pub fn read_bounded(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    read_chunks(File::open(path)?, most, &mut bytes, |_| Ok(()))?;
    Ok(bytes)
}

/// A table as text: UTF-8 without the byte 0, which no text holds and endless files begin with.
///
/// # Errors
/// The system's, [`ErrorKind::FileTooLarge`] and [`ErrorKind::InvalidData`].
pub fn read_text(path: &Path) -> io::Result<String> {
    let not_text = |reason: &str| io::Error::new(ErrorKind::InvalidData, reason);
    let mut bytes = Vec::new();
    read_chunks(File::open(path)?, LARGEST_TABLE, &mut bytes, |chunk| {
        if chunk.contains(&0) {
            return Err(not_text("it holds a byte 0, which is in no UTF-8 text"));
        }
        Ok(())
    })?;
    String::from_utf8(bytes).map_err(|_| not_text("it is not UTF-8 text"))
}

fn read_chunks(
    mut file: impl Read,
    most: u64,
    bytes: &mut Vec<u8>,
    look: impl Fn(&[u8]) -> io::Result<()>,
) -> io::Result<()> {
    loop {
        let before = bytes.len();
        file.by_ref().take(CHUNK).read_to_end(bytes)?;
        if bytes.len() == before {
            return Ok(());
        }
        if bytes.len() as u64 > most {
            let reason = format!("it is larger than {} MiB", most >> 20);
            return Err(io::Error::new(ErrorKind::FileTooLarge, reason));
        }
        look(&bytes[before..])?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_never_ends_or_is_too_large_is_refused() {
        let read = |file: &dyn Fn() -> Box<dyn Read>, most: u64| {
            let mut bytes = Vec::new();
            read_chunks(file(), most, &mut bytes, |_| Ok(())).map(|()| bytes)
        };
        let endless = || -> Box<dyn Read> { Box::new(io::repeat(b'1')) };
        let error = read(&endless, 3 << 20).expect_err("an endless file");
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
        let text = || -> Box<dyn Read> { Box::new(io::repeat(b'1').take(3 << 20)) };
        assert_eq!(
            read(&text, 3 << 20).expect("within the bound").len(),
            3 << 20
        );
        assert!(read(&text, (3 << 20) - 1).is_err());
    }
}

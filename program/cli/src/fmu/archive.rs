//! ZIP files whose entries are stored as they are (PKWARE, APPNOTE.TXT 6.3.9).

/// The largest size of an archive, whose places are numbers of 32 bits.
const LARGEST: usize = u32::MAX as usize;

/// The first of 1980, the earliest date that an entry can have: the same files are the same bytes.
const DATE: u16 = (1 << 5) | 1;

/// Names are in UTF-8.
const UTF_8: u16 = 1 << 11;

/// A regular file, and a program's.
const MODE: u32 = 0o100_755 << 16;

/// An archive in the making.
#[derive(Default)]
pub struct Archive {
    bytes: Vec<u8>,
    /// The directory at its end.
    directory: Vec<u8>,
    entries: u16,
}

impl Archive {
    /// Adds a file; `None` where the archive would be too large.
    #[must_use]
    pub fn with(mut self, name: &str, content: &[u8]) -> Option<Self> {
        let place = u32::try_from(self.bytes.len()).ok()?;
        let size = u32::try_from(content.len()).ok()?;
        let length = u16::try_from(name.len()).ok()?;
        self.entries = self.entries.checked_add(1)?;
        let mut common = Vec::new();
        // The version that is needed, flags, the method, the time and the date.
        for number in [20, UTF_8, 0, 0, DATE] {
            common.extend(u16::to_le_bytes(number));
        }
        for number in [checksum(content), size, size] {
            common.extend(number.to_le_bytes());
        }
        common.extend(length.to_le_bytes());
        common.extend([0; 2]);
        self.bytes.extend(b"PK\x03\x04");
        self.bytes.extend(&common);
        self.bytes.extend(name.as_bytes());
        self.bytes.extend(content);
        self.directory.extend(b"PK\x01\x02");
        // Made on Unix.
        self.directory.extend([20, 3]);
        self.directory.extend(&common);
        // No comment, the first disk, no attributes within.
        self.directory.extend([0; 6]);
        self.directory.extend(MODE.to_le_bytes());
        self.directory.extend(place.to_le_bytes());
        self.directory.extend(name.as_bytes());
        (self.bytes.len() + self.directory.len() < LARGEST).then_some(self)
    }

    /// The bytes of the file.
    pub fn finish(mut self) -> Vec<u8> {
        let place = self.bytes.len() as u32;
        let size = self.directory.len() as u32;
        self.bytes.append(&mut self.directory);
        self.bytes.extend(b"PK\x05\x06\0\0\0\0");
        self.bytes.extend(self.entries.to_le_bytes());
        self.bytes.extend(self.entries.to_le_bytes());
        self.bytes.extend(size.to_le_bytes());
        self.bytes.extend(place.to_le_bytes());
        self.bytes.extend([0; 2]);
        self.bytes
    }
}

/// CRC-32 of ISO 3309.
fn checksum(content: &[u8]) -> u32 {
    let table: [u32; 256] = std::array::from_fn(|at| {
        (0..8).fold(at as u32, |sum, _| {
            (sum >> 1) ^ if sum & 1 == 1 { 0xEDB8_8320 } else { 0 }
        })
    });
    !content.iter().fold(u32::MAX, |sum, byte| {
        (sum >> 8) ^ table[usize::from(sum as u8 ^ byte)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check value of CRC-32 in the catalogue of parametrised CRC algorithms.
    #[test]
    fn the_checksum_has_its_check_value() {
        assert_eq!(checksum(b"123456789"), 0xCBF4_3926);
        assert_eq!(checksum(b""), 0);
    }
}

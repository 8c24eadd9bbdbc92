//! Files that are read back to every bit or refused: name, format, content, digest.
//!
//! A name of 7 bytes, the format's number as a digit or a letter, the content as the crate `postcard` writes it through
//! serde, and the SHA-256 of all before. A double is its 8 bytes, least significant first.

use std::fs;
use std::io;

use postcard::experimental::serialized_size;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use super::error::RunError;
use super::job::{CHECKPOINT, Folder, SceneDigest};
use super::replaced::replace;

/// Why a file is refused whose digest fits.
const NOT_WHOLE: &str = "it is not a whole checkpoint";

/// Bytes of a SHA-256.
const DIGEST: usize = 32;

/// Format of a file: the name of its content, and the number of the way it is written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Format {
    /// The name, of any format.
    pub name: &'static [u8; 7],
    /// The digit.
    pub number: u8,
}

/// Why bytes are refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Unsealed {
    /// They are not what was written.
    Damaged(&'static str),
    /// They are what was written, in the format of this digit.
    Format(char),
}

impl Format {
    /// Replaces the checkpoint of a folder in one operation; the digest of its scene stands before the content.
    pub fn write(&self, folder: &Folder, content: &impl Serialize) -> Result<(), RunError> {
        let path = folder.join(CHECKPOINT);
        let bytes = self.seal(&(folder.scene(), content));
        let bytes = bytes.map_err(RunError::io(&path))?;
        replace(&path, &bytes)
    }

    /// Reads what [`write`](Self::write) wrote for the same scene.
    ///
    /// # Errors
    /// [`RunError::Damaged`], also for the checkpoint of another scene, and [`RunError::Format`].
    pub fn read<T: DeserializeOwned>(&self, folder: &Folder) -> Result<T, RunError> {
        let file = folder.join(CHECKPOINT);
        let bytes = fs::read(&file).map_err(RunError::resuming(&file))?;
        let damaged = |reason: &str| RunError::Damaged {
            file: file.clone(),
            reason: reason.to_owned(),
        };
        let opened = self.open::<(SceneDigest, T)>(&bytes);
        let (scene, content) = opened.map_err(|unsealed| match unsealed {
            Unsealed::Damaged(reason) => damaged(reason),
            Unsealed::Format(found) => RunError::Format {
                file: file.clone(),
                found,
                read: char::from(self.number),
            },
        })?;
        match scene == *folder.scene() {
            true => Ok(content),
            false => Err(damaged(
                "it is of another scene, or of steps of another length",
            )),
        }
    }

    /// The bytes of a file. Their memory is asked for once: a vector that grows holds up to three times as much while it
    /// moves, and ends the program where there is too little.
    pub fn seal(&self, content: &impl Serialize) -> io::Result<Vec<u8>> {
        let size = serialized_size(content).map_err(io::Error::other)?;
        let mut bytes = Vec::new();
        bytes
            .try_reserve_exact(self.name.len() + 1 + size + DIGEST)
            .map_err(|error| io::Error::new(io::ErrorKind::OutOfMemory, error))?;
        bytes.extend_from_slice(self.name);
        bytes.push(self.number);
        let bytes = postcard::to_extend(content, bytes).map_err(io::Error::other)?;
        Ok(with_digest(bytes))
    }

    /// The content of exactly one file.
    pub fn open<T: DeserializeOwned>(&self, bytes: &[u8]) -> Result<T, Unsealed> {
        let (head, digest) = bytes
            .split_last_chunk::<DIGEST>()
            .ok_or(Unsealed::Damaged(NOT_WHOLE))?;
        let named = head.strip_prefix(self.name.as_slice());
        let Some((number, content)) = named.and_then(<[u8]>::split_first) else {
            return Err(Unsealed::Damaged("it is not a checkpoint of this kind"));
        };
        if Sha256::digest(head)[..] != digest[..] {
            return Err(Unsealed::Damaged(
                "it differs from what was written: it was changed since, or damaged",
            ));
        }
        if *number != self.number {
            return Err(Unsealed::Format(char::from(*number)));
        }
        match postcard::take_from_bytes(content) {
            Ok((content, [])) => Ok(content),
            _ => Err(Unsealed::Damaged(NOT_WHOLE)),
        }
    }
}

/// Bytes with their digest behind them: no bit of them changes unseen.
fn with_digest(mut bytes: Vec<u8>) -> Vec<u8> {
    let digest = Sha256::digest(&bytes);
    bytes.extend_from_slice(&digest);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORMAT: Format = Format {
        name: b"example",
        number: b'2',
    };

    fn sealed(values: &[f64]) -> Vec<u8> {
        FORMAT.seal(&values).expect("bytes")
    }

    fn opened(bytes: &[u8]) -> Result<Vec<f64>, Unsealed> {
        FORMAT.open(bytes)
    }

    #[test]
    fn doubles_keep_every_bit() {
        let bits = [
            0,
            1,
            1 << 63,
            f64::INFINITY.to_bits(),
            f64::NEG_INFINITY.to_bits(),
            // NaN, quiet and signalling, of either sign, with what it carries.
            0x7ff8_0000_0000_0000,
            0x7ff0_0000_0000_0001,
            0xfff4_dead_beef_0123,
            0x3fb9_9999_9999_999a,
        ];
        let values: Vec<f64> = bits.into_iter().map(f64::from_bits).collect();
        let back = opened(&sealed(&values)).expect("doubles");
        assert!(back.into_iter().map(f64::to_bits).eq(bits));
    }

    /// The layout that other programs may rely on.
    #[test]
    fn the_bytes_are_name_digit_length_and_doubles() {
        let bytes = sealed(&[-2.0]);
        assert_eq!(bytes.len(), 8 + 1 + 8 + DIGEST);
        assert_eq!(&bytes[..17], b"example2\x01\0\0\0\0\0\0\0\xc0");
    }

    /// Of a lattice of a million sites a growing vector would take as much again as all the rest of the run.
    #[test]
    fn bytes_take_the_memory_of_their_number() {
        for count in [0, 1, 127, 128, 1000, 16_384, 100_000] {
            let bytes = sealed(&vec![0.5; count]);
            assert_eq!(bytes.capacity(), bytes.len(), "{count} doubles");
        }
    }

    #[test]
    fn every_flipped_bit_is_damage() {
        let good = sealed(&[0.5, -0.0, f64::NAN]);
        for bit in 0..8 * good.len() {
            let mut flipped = good.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let refused = opened(&flipped).expect_err("damage");
            assert!(matches!(refused, Unsealed::Damaged(_)), "bit {bit}");
        }
    }

    #[test]
    fn a_cut_or_lengthened_file_is_damaged() {
        let bytes = sealed(&[0.5; 3]);
        for cut in 0..bytes.len() {
            assert!(opened(&bytes[..cut]).is_err(), "{cut} bytes");
        }
        assert!(opened(&[bytes.clone(), vec![0]].concat()).is_err());
        // With a digest that fits: a number more, one less, and a list longer than any memory.
        let content = &bytes[..bytes.len() - DIGEST];
        let mut endless = content[..8].to_vec();
        endless.extend([0xff; 9]);
        endless.push(1);
        endless.extend_from_slice(&content[9..]);
        let (less, more) = (&content[..content.len() - 8], [content, &[0; 8]].concat());
        for other in [less.to_vec(), more, endless] {
            let refused = opened(&with_digest(other));
            assert_eq!(refused, Err(Unsealed::Damaged(NOT_WHOLE)));
        }
        assert!(opened(&with_digest(content.to_vec())).is_ok());
    }

    #[test]
    fn an_older_format_is_named_and_never_read() {
        let older = Format {
            number: b'1',
            ..FORMAT
        };
        let bytes = older.seal(&vec![1.0]).expect("bytes");
        assert_eq!(opened(&bytes), Err(Unsealed::Format('1')));
    }
}

//! Everything later steps depend on, in one file that is replaced atomically.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use leafwise_core::SolverStatistics;
use leafwise_core::integrator::Checkpoint as IntegratorState;
use sha2::{Digest, Sha256};

use super::appended::{Vouched, create_anew};
use super::error::RunError;
use super::invariants::Windows;
use super::samples;
use super::snapshots::Snapshots;

/// The file's name in the run directory.
pub(crate) const FILE: &str = "checkpoint.bin";

/// The file begins with this: name and format version.
const MAGIC: &[u8; 8] = b"leafwis6";

/// A count that is not known.
const UNKNOWN: u64 = u64::MAX;

/// A run between two steps.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Checkpoint {
    /// x_k, its compensation and the solver's memory.
    pub integrator: IntegratorState,
    /// The solver's work so far.
    pub statistics: SolverStatistics,
    /// Seconds of integration so far.
    pub wall_seconds: f64,
    /// The beginning of `samples.csv` that holds them.
    pub vouched: Vouched,
    /// The beginning of what `states.npy` holds behind its header, if there is one.
    pub states: Vouched,
    /// Samples recorded.
    pub samples: u64,
    /// The step after which the last sample was recorded.
    pub last_sample: Option<u64>,
    /// For each formula, the samples at which it has no finite value.
    pub undefined: Vec<u64>,
    /// Invariants over windows.
    pub windows: Windows,
    /// Fields of a long lattice.
    pub snapshots: Snapshots,
}

/// Replaces `path` in one operation: readers see the old content or the new.
pub(crate) fn replace(path: &Path, content: &[u8]) -> Result<(), RunError> {
    let temporary = path.with_extension("new");
    let written = write_whole(&temporary, content).and_then(|()| fs::rename(&temporary, path));
    written.map_err(|source| {
        // What a full disk has no room for does not stay there either.
        let _ = fs::remove_file(&temporary);
        RunError::io(path)(source)
    })
}

fn write_whole(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut file = create_anew(path)?;
    file.write_all(content)?;
    file.sync_data()
}

impl Checkpoint {
    /// Writes the checkpoint of a directory.
    pub fn write(&self, directory: &Path) -> Result<(), RunError> {
        replace(&directory.join(FILE), &self.encode())
    }

    /// Reads the checkpoint of an unfinished run, `None` where it was killed before the first: at most
    /// its initial state is recorded then, and it begins anew.
    pub fn of_unfinished(directory: &Path, header: &str) -> Result<Option<Self>, RunError> {
        if !directory.join(FILE).exists() && samples::has_begun_at_most(directory, header) {
            return Ok(None);
        }
        Self::read(directory).map(Some)
    }

    /// Reads the checkpoint of a directory.
    pub fn read(directory: &Path) -> Result<Self, RunError> {
        let path = directory.join(FILE);
        let bytes = fs::read(&path).map_err(RunError::resuming(&path))?;
        Self::decode(&bytes).map_err(|reason| RunError::Damaged {
            file: path,
            reason: reason.to_owned(),
        })
    }

    /// Every number in 8 bytes, least significant first, lists behind their length; [`sealed`].
    fn encode(&self) -> Vec<u8> {
        let mut out = Writer(MAGIC.to_vec());
        out.whole(self.integrator.steps);
        out.list(&self.integrator.state);
        out.list(&self.integrator.compensation);
        out.list(&self.integrator.memory);
        out.statistics(&self.statistics);
        out.number(self.wall_seconds);
        out.vouched(&self.vouched);
        out.vouched(&self.states);
        out.whole(self.samples);
        out.whole(self.last_sample.unwrap_or(UNKNOWN));
        out.wholes(&self.undefined);
        out.list(&self.windows.initial);
        out.whole(self.windows.width);
        out.whole(self.windows.filled);
        out.list(&self.windows.current);
        out.list(&self.windows.maxima);
        out.wholes(&self.windows.evaluations);
        out.whole(self.snapshots.every);
        out.whole(self.snapshots.seen);
        out.list(&self.snapshots.times);
        out.list(&self.snapshots.values);
        sealed(out)
    }

    /// The bytes of exactly one checkpoint; what is wrong with any other.
    fn decode(bytes: &[u8]) -> Result<Self, &'static str> {
        Self::content(unsealed(bytes, MAGIC)?).ok_or(NOT_WHOLE)
    }

    fn content(mut from: Reader<'_>) -> Option<Self> {
        let integrator = IntegratorState {
            steps: from.whole()?,
            state: from.list()?,
            compensation: from.list()?,
            memory: from.list()?,
        };
        let statistics = from.statistics()?;
        let (wall_seconds, vouched, states) = (from.number()?, from.vouched()?, from.vouched()?);
        let samples = from.whole()?;
        let last_sample = Some(from.whole()?).filter(|step| *step != UNKNOWN);
        let undefined = from.wholes()?;
        let windows = Windows {
            initial: from.list()?,
            width: from.whole()?,
            filled: from.whole()?,
            current: from.list()?,
            maxima: from.list()?,
            evaluations: from.wholes()?,
        };
        let snapshots = Snapshots {
            every: from.whole()?,
            seen: from.whole()?,
            times: from.list()?,
            values: from.list()?,
        };
        let count = windows.initial.len();
        let agrees = windows.current.len() == count
            && windows.maxima.len() == count * windows.evaluations.len()
            && integrator.compensation.len() == integrator.state.len()
            && snapshots.every > 0;
        let whole = from.0.is_empty() && agrees;
        whole.then_some(Self {
            integrator,
            statistics,
            wall_seconds,
            vouched,
            states,
            samples,
            last_sample,
            undefined,
            windows,
            snapshots,
        })
    }
}

/// Why a checkpoint is refused whose digest fits.
pub(crate) const NOT_WHOLE: &str = "it is not a whole checkpoint";

/// Bytes of a SHA-256.
const DIGEST: usize = 32;

/// The content of a file with the digest of all of it at the end: no bit of it changes unseen.
pub(crate) fn sealed(Writer(mut content): Writer) -> Vec<u8> {
    let digest = Sha256::digest(&content);
    content.extend_from_slice(&digest);
    content
}

/// What stands behind the name and format version of a file that was [`sealed`].
pub(crate) fn unsealed<'a>(bytes: &'a [u8], magic: &[u8; 8]) -> Result<Reader<'a>, &'static str> {
    let (content, digest) = bytes.split_last_chunk::<DIGEST>().ok_or(NOT_WHOLE)?;
    let Some(numbers) = content.strip_prefix(magic) else {
        return Err("it is not a checkpoint in the format of this version");
    };
    if Sha256::digest(content)[..] != digest[..] {
        return Err("it is not what was written: it was changed since, or damaged");
    }
    Ok(Reader(numbers))
}

/// Numbers as bytes, 8 each.
pub(crate) struct Writer(pub(crate) Vec<u8>);

impl Writer {
    pub(crate) fn whole(&mut self, value: u64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    pub(crate) fn number(&mut self, value: f64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    pub(crate) fn list(&mut self, values: &[f64]) {
        self.whole(values.len() as u64);
        values.iter().for_each(|value| self.number(*value));
    }

    pub(crate) fn wholes(&mut self, values: &[u64]) {
        self.whole(values.len() as u64);
        values.iter().for_each(|value| self.whole(*value));
    }

    pub(crate) fn vouched(&mut self, vouched: &Vouched) {
        self.whole(vouched.bytes);
        self.0.extend_from_slice(&vouched.sha256);
    }

    pub(crate) fn statistics(&mut self, statistics: &SolverStatistics) {
        for count in [
            statistics.steps,
            statistics.evaluations,
            statistics.operations.unwrap_or(UNKNOWN),
            statistics.most_evaluations,
            statistics.failures,
            statistics.rounded,
        ] {
            self.whole(count);
        }
    }

    /// A text as so many whole numbers, its bytes in eights, filled up with zeros.
    pub(crate) fn text(&mut self, text: &str) {
        let words = text.len().div_ceil(8);
        self.whole(words as u64);
        let end = self.0.len() + 8 * words;
        self.0.extend_from_slice(text.as_bytes());
        self.0.resize(end, 0);
    }
}

/// What a [`Writer`] wrote.
pub(crate) struct Reader<'a>(pub(crate) &'a [u8]);

impl Reader<'_> {
    fn eight(&mut self) -> Option<[u8; 8]> {
        let (first, rest) = self.0.split_first_chunk::<8>()?;
        self.0 = rest;
        Some(*first)
    }

    pub(crate) fn whole(&mut self) -> Option<u64> {
        self.eight().map(u64::from_le_bytes)
    }

    pub(crate) fn number(&mut self) -> Option<f64> {
        self.eight().map(f64::from_le_bytes)
    }

    /// A list's length, which the rest must hold.
    pub(crate) fn length(&mut self) -> Option<usize> {
        let length = usize::try_from(self.whole()?).ok()?;
        (length <= self.0.len() / 8).then_some(length)
    }

    pub(crate) fn text(&mut self) -> Option<String> {
        let length = 8 * self.length()?;
        let (text, rest) = self.0.split_at(length);
        self.0 = rest;
        let text = std::str::from_utf8(text).ok()?;
        Some(text.trim_end_matches('\0').to_owned())
    }

    pub(crate) fn list(&mut self) -> Option<Vec<f64>> {
        (0..self.length()?).map(|_| self.number()).collect()
    }

    pub(crate) fn wholes(&mut self) -> Option<Vec<u64>> {
        (0..self.length()?).map(|_| self.whole()).collect()
    }

    pub(crate) fn vouched(&mut self) -> Option<Vouched> {
        let bytes = self.whole()?;
        let (sha256, rest) = self.0.split_first_chunk::<DIGEST>()?;
        self.0 = rest;
        Some(Vouched {
            bytes,
            sha256: *sha256,
        })
    }

    pub(crate) fn statistics(&mut self) -> Option<SolverStatistics> {
        Some(SolverStatistics {
            steps: self.whole()?,
            evaluations: self.whole()?,
            operations: Some(self.whole()?).filter(|count| *count != UNKNOWN),
            most_evaluations: self.whole()?,
            failures: self.whole()?,
            rounded: self.whole()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Checkpoint {
        let mut windows = Windows::new(&[1.0, -0.0]);
        (1..=5000_u64).for_each(|k| windows.push(&[k as f64, f64::NAN], || k));
        Checkpoint {
            integrator: IntegratorState {
                steps: 5000,
                state: vec![0.1, -0.0, 5e-324],
                compensation: vec![1e-17, 0.0, f64::MIN_POSITIVE],
                memory: vec![f64::INFINITY, 3.0],
            },
            statistics: SolverStatistics {
                steps: 5000,
                evaluations: 10_001,
                operations: None,
                most_evaluations: 7,
                failures: 0,
                rounded: 3,
            },
            wall_seconds: 0.25,
            vouched: Vouched {
                bytes: 1 << 40,
                sha256: [7; 32],
            },
            states: Vouched::NOTHING,
            samples: 77,
            last_sample: Some(4998),
            undefined: vec![0, 3],
            windows,
            snapshots: Snapshots {
                every: 2,
                seen: 3,
                times: vec![0.5],
                values: vec![-0.0],
            },
        }
    }

    #[test]
    fn a_checkpoint_reads_back_to_the_same_bits() {
        let bytes = example().encode();
        let back = Checkpoint::decode(&bytes).expect("a checkpoint");
        assert_eq!(back.encode(), bytes);
        assert_eq!(back.integrator, example().integrator);
    }

    #[test]
    fn every_flipped_bit_is_refused() {
        let mut small = example();
        small.windows = Windows::new(&[1.0, -0.0]);
        let good = small.encode();
        for bit in 0..8 * good.len() {
            let mut flipped = good.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(Checkpoint::decode(&flipped).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn a_cut_or_lengthened_checkpoint_is_refused() {
        let bytes = example().encode();
        for cut in [0, 7, 8, 15, 100, bytes.len() - 1] {
            assert!(Checkpoint::decode(&bytes[..cut]).is_err(), "{cut} bytes");
        }
        assert!(Checkpoint::decode(&[bytes.clone(), vec![0]].concat()).is_err());
        // With a digest that fits.
        let content = bytes[..bytes.len() - DIGEST].to_vec();
        let mut long_list = content.clone();
        long_list[16..24].copy_from_slice(&u64::MAX.to_le_bytes());
        for other in [long_list, [content.clone(), vec![0]].concat()] {
            assert_eq!(Checkpoint::decode(&sealed(Writer(other))), Err(NOT_WHOLE));
        }
        assert!(Checkpoint::decode(&sealed(Writer(content))).is_ok());
    }
}

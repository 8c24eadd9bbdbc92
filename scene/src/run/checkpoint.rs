//! Everything later steps depend on, in one file that is replaced atomically.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use leafwise_core::SolverStatistics;
use leafwise_core::integrator::Checkpoint as IntegratorState;

use super::error::RunError;
use super::invariants::Windows;
use super::samples;
use super::snapshots::Snapshots;

/// The file's name in the run directory.
pub(crate) const FILE: &str = "checkpoint.bin";

/// The file begins with this: name and format version.
const MAGIC: &[u8; 8] = b"leafwis3";

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
    /// Bytes of `samples.csv`.
    pub sample_bytes: u64,
    /// Samples recorded.
    pub samples: u64,
    /// The step after which the last sample was recorded.
    pub last_sample: Option<u64>,
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
    let mut file = File::create(path)?;
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
    pub fn of_unfinished(directory: &Path) -> Result<Option<Self>, RunError> {
        if !directory.join(FILE).exists() && samples::has_begun_at_most(directory) {
            return Ok(None);
        }
        Self::read(directory).map(Some)
    }

    /// Reads the checkpoint of a directory.
    pub fn read(directory: &Path) -> Result<Self, RunError> {
        let path = directory.join(FILE);
        let bytes = fs::read(&path).map_err(RunError::resuming(&path))?;
        Self::decode(&bytes).ok_or_else(|| RunError::Damaged {
            file: path,
            reason: "it is not a whole checkpoint of this program".to_owned(),
        })
    }

    /// The magic number, then every number in 8 bytes, least significant first; lists behind their
    /// length.
    fn encode(&self) -> Vec<u8> {
        let mut out = Writer(MAGIC.to_vec());
        out.whole(self.integrator.steps);
        out.list(&self.integrator.state);
        out.list(&self.integrator.compensation);
        out.list(&self.integrator.memory);
        for count in [
            self.statistics.steps,
            self.statistics.evaluations,
            self.statistics.operations.unwrap_or(UNKNOWN),
            self.statistics.most_evaluations,
            self.statistics.failures,
        ] {
            out.whole(count);
        }
        out.number(self.wall_seconds);
        out.whole(self.sample_bytes);
        out.whole(self.samples);
        out.whole(self.last_sample.unwrap_or(UNKNOWN));
        out.list(&self.windows.initial);
        out.whole(self.windows.width);
        out.whole(self.windows.filled);
        out.list(&self.windows.current);
        out.list(&self.windows.maxima);
        out.whole(self.windows.evaluations.len() as u64);
        self.windows
            .evaluations
            .iter()
            .for_each(|count| out.whole(*count));
        out.whole(self.snapshots.every);
        out.whole(self.snapshots.seen);
        out.list(&self.snapshots.times);
        out.list(&self.snapshots.values);
        out.0
    }

    /// `None` unless the bytes are exactly one checkpoint.
    fn decode(bytes: &[u8]) -> Option<Self> {
        let mut from = Reader(bytes.strip_prefix(MAGIC)?);
        let integrator = IntegratorState {
            steps: from.whole()?,
            state: from.list()?,
            compensation: from.list()?,
            memory: from.list()?,
        };
        let statistics = SolverStatistics {
            steps: from.whole()?,
            evaluations: from.whole()?,
            operations: Some(from.whole()?).filter(|count| *count != UNKNOWN),
            most_evaluations: from.whole()?,
            failures: from.whole()?,
        };
        let (wall_seconds, sample_bytes, samples) = (from.number()?, from.whole()?, from.whole()?);
        let last_sample = Some(from.whole()?).filter(|step| *step != UNKNOWN);
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
            sample_bytes,
            samples,
            last_sample,
            windows,
            snapshots,
        })
    }
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

    fn wholes(&mut self) -> Option<Vec<u64>> {
        (0..self.length()?).map(|_| self.whole()).collect()
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
            },
            wall_seconds: 0.25,
            sample_bytes: 1 << 40,
            samples: 77,
            last_sample: Some(4998),
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
    fn a_cut_or_lengthened_checkpoint_is_refused() {
        let bytes = example().encode();
        for cut in [0, 7, 8, 15, 100, bytes.len() - 1] {
            assert_eq!(Checkpoint::decode(&bytes[..cut]), None, "{cut} bytes");
        }
        assert_eq!(Checkpoint::decode(&[bytes.clone(), vec![0]].concat()), None);
        let mut long_list = bytes.clone();
        long_list[16..24].copy_from_slice(&u64::MAX.to_le_bytes());
        assert_eq!(Checkpoint::decode(&long_list), None);
    }
}

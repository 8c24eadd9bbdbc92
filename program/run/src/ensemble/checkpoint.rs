//! What a resumed ensemble needs, in one file that is replaced atomically.

use std::fs;
use std::path::Path;

use super::quantiles::Sketch;
use super::statistics::{Deviation, MemberFailure, Reductions, Summary};
use crate::{CHECKPOINT, NOT_WHOLE, Reader, RunError, Vouched, Writer, replace, sealed, unsealed};

/// The file begins with this: name and format version.
const MAGIC: &[u8; 8] = b"leafens3";

/// An ensemble between two members.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Checkpoint {
    /// Of a file of states.
    pub fingerprint: u64,
    /// Members of the whole ensemble.
    pub members: u64,
    /// Seconds of integration so far.
    pub wall_seconds: f64,
    /// The beginning of the file of last states that holds them.
    pub vouched: Vouched,
    /// The members taken in so far.
    pub reductions: Reductions,
}

impl Checkpoint {
    /// Writes the checkpoint of a directory.
    pub fn write(&self, directory: &Path) -> Result<(), RunError> {
        replace(&directory.join(CHECKPOINT), &self.encode())
    }

    /// Reads the checkpoint of a directory.
    pub fn read(directory: &Path) -> Result<Self, RunError> {
        let path = directory.join(CHECKPOINT);
        let bytes = fs::read(&path).map_err(RunError::resuming(&path))?;
        Self::decode(&bytes).map_err(|reason| RunError::Damaged {
            file: path,
            reason: reason.to_owned(),
        })
    }

    /// Every number in 8 bytes, least significant first, lists behind their length; [`sealed`].
    fn encode(&self) -> Vec<u8> {
        let mut out = Writer(MAGIC.to_vec());
        out.whole(self.fingerprint);
        out.whole(self.members);
        out.number(self.wall_seconds);
        out.vouched(&self.vouched);
        let all = &self.reductions;
        out.whole(all.members);
        out.whole(all.failed);
        out.statistics(&all.statistics);
        out.whole(all.failures.len() as u64);
        for failure in &all.failures {
            out.whole(failure.member);
            out.whole(failure.step);
            out.number(failure.time);
            out.text(&failure.message);
            out.list(&failure.state);
        }
        for summaries in [&all.summaries, &all.initial] {
            out.whole(summaries.len() as u64);
            summaries
                .iter()
                .for_each(|summary| write_summary(&mut out, summary));
        }
        for deviations in [&all.windows, &all.whole, &all.relative] {
            out.whole(deviations.len() as u64);
            for deviation in deviations {
                out.number(deviation.maximum);
                out.whole(deviation.member);
                out.number(deviation.sum);
            }
        }
        sealed(out)
    }

    /// The bytes of exactly one checkpoint; what is wrong with any other.
    fn decode(bytes: &[u8]) -> Result<Self, &'static str> {
        Self::content(unsealed(bytes, MAGIC)?).ok_or(NOT_WHOLE)
    }

    fn content(mut from: Reader<'_>) -> Option<Self> {
        let (fingerprint, total) = (from.whole()?, from.whole()?);
        let (wall_seconds, vouched) = (from.number()?, from.vouched()?);
        let (members, failed) = (from.whole()?, from.whole()?);
        let statistics = from.statistics()?;
        let mut failures = Vec::new();
        for _ in 0..from.length()? {
            failures.push(MemberFailure {
                member: from.whole()?,
                step: from.whole()?,
                time: from.number()?,
                message: from.text()?,
                state: from.list()?,
            });
        }
        let (summaries, initial) = (read_summaries(&mut from)?, read_summaries(&mut from)?);
        let mut deviations = || -> Option<Vec<Deviation>> {
            let deviation = |from: &mut Reader<'_>| {
                Some(Deviation {
                    maximum: from.number()?,
                    member: from.whole()?,
                    sum: from.number()?,
                })
            };
            (0..from.length()?).map(|_| deviation(&mut from)).collect()
        };
        let (windows, whole, relative) = (deviations()?, deviations()?, deviations()?);
        from.0.is_empty().then_some(Self {
            fingerprint,
            members: total,
            wall_seconds,
            vouched,
            reductions: Reductions {
                members,
                failed,
                failures,
                summaries,
                windows,
                whole,
                relative,
                initial,
                statistics,
            },
        })
    }
}

fn write_summary(out: &mut Writer, summary: &Summary) {
    out.whole(summary.count);
    out.whole(summary.undefined);
    out.number(summary.mean);
    out.number(summary.squares);
    for (value, member) in [summary.minimum, summary.maximum] {
        out.number(value);
        out.whole(member);
    }
    let levels = summary
        .sketch
        .as_ref()
        .map(|sketch| sketch.levels.len() + 1);
    out.whole(levels.unwrap_or(0) as u64);
    if let Some(sketch) = &summary.sketch {
        for (level, compactions) in sketch.levels.iter().zip(&sketch.compactions) {
            out.list(level);
            out.whole(*compactions);
        }
    }
}

fn read_summaries(from: &mut Reader<'_>) -> Option<Vec<Summary>> {
    (0..from.length()?).map(|_| read_summary(from)).collect()
}

fn read_summary(from: &mut Reader<'_>) -> Option<Summary> {
    let (count, undefined) = (from.whole()?, from.whole()?);
    let (mean, squares) = (from.number()?, from.number()?);
    let minimum = (from.number()?, from.whole()?);
    let maximum = (from.number()?, from.whole()?);
    let sketch = match from.length()?.checked_sub(1) {
        None => None,
        Some(levels) => {
            let mut sketch = Sketch::default();
            for _ in 0..levels {
                sketch.levels.push(from.list()?);
                sketch.compactions.push(from.whole()?);
            }
            Some(sketch)
        }
    };
    Some(Summary {
        count,
        undefined,
        mean,
        squares,
        minimum,
        maximum,
        sketch,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::statistics::Shape;

    #[test]
    fn a_checkpoint_reads_back_whole_and_not_otherwise() {
        let mut reductions = Reductions::new(Shape {
            times: 2,
            observables: 1,
            windows: 3,
            invariants: 1,
            has_quantiles: true,
        });
        for member in 0..5000_u64 {
            reductions.summaries[1].push(1.0 / (1 + member) as f64, member);
        }
        reductions.windows[2].push(1e-9, 17);
        reductions.push_failure(MemberFailure {
            member: 3,
            step: 12,
            time: 0.6,
            message: "the state went nowhere · ∞".to_owned(),
            state: vec![0.1, -0.0],
        });
        reductions.statistics.operations = None;
        let checkpoint = Checkpoint {
            fingerprint: 5,
            members: 10_000,
            wall_seconds: 1.5,
            vouched: Vouched {
                bytes: 99,
                sha256: [3; 32],
            },
            reductions,
        };
        let bytes = checkpoint.encode();
        assert_eq!(Checkpoint::decode(&bytes), Ok(checkpoint));
        for cut in [0, 7, 8, 40, bytes.len() / 2, bytes.len() - 1] {
            assert!(Checkpoint::decode(&bytes[..cut]).is_err(), "{cut} bytes");
        }
        assert!(Checkpoint::decode(&[bytes, vec![0]].concat()).is_err());
    }
}

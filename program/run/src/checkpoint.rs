//! Everything later steps depend on, in one file that is replaced atomically.

#[cfg(test)]
use std::path::Path;

use leafwise_core::SolverStatistics;
use leafwise_core::walk::Checkpoint as IntegratorState;
use leafwise_walk::{Deviation, PacedSteps, Past, Side, StepStart, StopPlace};
use serde::{Deserialize, Serialize};

use super::appended::Vouched;
use super::error::RunError;
use super::invariants::Windows;
use super::sealed::Format;
use super::snapshots::Snapshots;
use super::watch::Watch;
use crate::CHECKPOINT;
use crate::job::Folder;
#[cfg(test)]
use crate::job::SceneDigest;

/// Format of the checkpoint of a run: the name of its content, and its number.
const FORMAT: Format = Format {
    name: b"leafwis",
    number: b'H',
};

/// A run between two steps. Another field, order or type is another format.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// x_k, its compensation and the solver's memory.
    #[serde(with = "IntegratorFields")]
    pub walk: IntegratorState,
    /// The solver's work so far.
    #[serde(with = "StatisticsFields")]
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
    /// States that the method is judged at.
    pub watch: Watch,
    /// Fields of a long lattice.
    pub snapshots: Snapshots,
    /// Steps of a fictitious time.
    pub paced: PacedSteps,
    /// The beginning of `section.csv` that holds what was recorded on a section, if there is one.
    pub section: Vouched,
    /// Crossings recorded.
    pub crossings: u64,
    /// Where the run stands beside its section.
    pub side: Side,
    /// Values of the difference of the condition that ends the run.
    pub stop: Past,
    /// Values of the corners of both, where they are not smooth.
    pub corners: Vec<Past>,
    /// Where the condition has ended the run between two steps.
    pub stopped: Option<StopPlace>,
    /// The state before the last step.
    pub start: StepStart,
    /// Vectors of indicators of chaos.
    pub deviation: Deviation,
}

impl Checkpoint {
    /// Writes the checkpoint of a directory.
    pub fn write(&self, folder: &Folder) -> Result<(), RunError> {
        FORMAT.write(folder, self)
    }

    /// Reads the checkpoint of a directory.
    pub fn read(folder: &Folder) -> Result<Self, RunError> {
        let checkpoint: Self = FORMAT.read(folder)?;
        if checkpoint.agrees() {
            return Ok(checkpoint);
        }
        Err(RunError::Damaged {
            file: folder.join(CHECKPOINT),
            reason: "its lists do not belong together".to_owned(),
        })
    }

    /// Reads a checkpoint of whatever scene.
    #[cfg(test)]
    pub fn of_any_scene(directory: &Path) -> Self {
        let bytes = std::fs::read(directory.join(CHECKPOINT)).expect("a checkpoint");
        let (_, checkpoint): (SceneDigest, Self) = FORMAT.open(&bytes).expect("a whole one");
        checkpoint
    }

    /// Whether lists that belong together are as long as each other.
    fn agrees(&self) -> bool {
        let (windows, walk) = (&self.windows, &self.walk);
        let count = windows.initial.len();
        windows.current.len() == count
            && windows.maxima.len() == count * windows.evaluations.len()
            && windows.times.len() == windows.evaluations.len()
            && self.start.compensation.len() == self.start.state.len()
            && walk.compensation.len() == walk.state.len()
            && self.watch.agrees(walk.state.len())
            && self.snapshots.every > 0
    }
}

/// The fields of [`IntegratorState`], for serde.
#[derive(Serialize, Deserialize)]
#[serde(remote = "IntegratorState")]
struct IntegratorFields {
    steps: u64,
    state: Vec<f64>,
    compensation: Vec<f64>,
    memory: Vec<f64>,
}

/// The fields of [`SolverStatistics`], for serde.
#[derive(Serialize, Deserialize)]
#[serde(remote = "SolverStatistics")]
pub(crate) struct StatisticsFields {
    steps: u64,
    evaluations: u64,
    operations: Option<u64>,
    most_evaluations: u64,
    failures: u64,
    rounded: u64,
    held: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Checkpoint {
        let mut windows = Windows::new(&[1.0, -0.0]);
        (1..=5000_u64).for_each(|k| windows.push(&[k as f64, f64::NAN], 0.5 * k as f64, || k));
        Checkpoint {
            walk: IntegratorState {
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
                held: 3e-16,
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
            watch: Watch::new(&[0.1, -0.0, 5e-324]),
            snapshots: Snapshots {
                every: 2,
                seen: 3,
                times: vec![0.5],
                values: vec![-0.0],
            },
            paced: PacedSteps {
                least: 1e-3,
                most: 0.5,
                seen: 0.25,
                doubled: 0.75,
                advance: 0.125,
                slower: 3,
            },
            section: Vouched::NOTHING,
            crossings: 3,
            side: Side::begin(-1.0),
            stop: Past::begin(-0.5).then(f64::INFINITY),
            corners: vec![Past::begin(0.5).then(-0.5)],
            stopped: Some(StopPlace {
                steps: 7,
                time: 0.65,
                state: vec![0.1, 0.2],
            }),
            start: StepStart {
                state: vec![0.1, 0.2],
                compensation: vec![0.0, -1e-18],
                from: vec![0.25],
            },
            deviation: Deviation::default(),
        }
    }

    #[test]
    fn a_checkpoint_reads_back_to_the_same_bits() {
        let root = tempfile::tempdir().expect("a directory");
        example()
            .write(&Folder::of_no_scene(root.path()))
            .expect("written");
        let back = Checkpoint::read(&Folder::of_no_scene(root.path())).expect("a checkpoint");
        let bytes = |checkpoint| FORMAT.seal(checkpoint).expect("bytes");
        assert_eq!(bytes(&back), bytes(&example()));
        assert_eq!(back.walk, example().walk);
    }

    #[test]
    fn lists_that_do_not_belong_together_are_refused() {
        let spoils: [fn(&mut Checkpoint); 7] = [
            |it| it.watch = Watch::new(&[0.0]),
            |it| it.windows.times.push(0.0),
            |it| it.start.state.push(0.0),
            |it| it.windows.current.push(0.0),
            |it| it.windows.maxima.push(0.0),
            |it| it.walk.compensation.push(0.0),
            |it| it.snapshots.every = 0,
        ];
        for spoil in spoils {
            let root = tempfile::tempdir().expect("a directory");
            let mut checkpoint = example();
            spoil(&mut checkpoint);
            checkpoint
                .write(&Folder::of_no_scene(root.path()))
                .expect("written");
            let refused = Checkpoint::read(&Folder::of_no_scene(root.path()))
                .expect_err("lists that disagree");
            assert!(matches!(refused, RunError::Damaged { .. }), "{refused}");
        }
    }

    /// The bytes of formats 6 and 7 began with their digit too, and ended in their digest.
    #[test]
    fn a_checkpoint_of_an_older_format_is_refused_with_what_to_do() {
        let root = tempfile::tempdir().expect("a directory");
        let older = Format {
            number: b'6',
            ..FORMAT
        };
        older
            .write(&Folder::of_no_scene(root.path()), &example())
            .expect("written");
        let refused =
            Checkpoint::read(&Folder::of_no_scene(root.path())).expect_err("another format");
        assert!(
            matches!(refused, RunError::Format { found: '6', .. }),
            "{refused}"
        );
        let said = refused.to_string();
        for piece in ["checkpoint.bin", "format 6", "--force", "--out DIR"] {
            assert!(said.contains(piece), "{said}");
        }
    }
}

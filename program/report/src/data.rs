//! Contents of a report: recorded data.

use serde::Serialize;

/// Everything a report shows; plain recorded data, nothing is recomputed.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ReportData {
    /// The heading, as "Rigid body".
    pub title: String,
    /// Program and version, as "leafwise 0.1.0".
    pub version: String,
    /// The effective command line.
    pub command: String,
    /// The scene's file name.
    pub scene_name: String,
    /// The scene as run.
    pub scene_text: String,
    /// How the run ended.
    pub outcome: Outcome,
    /// Changes to the scene that are advised, as pairs: the finding, measured, and the line to write instead.
    pub advice: Vec<(String, String)>,
    /// Label and text for each line about the method: realization, dynamics, orders, step.
    pub method: Vec<(String, String)>,
    /// Label and value for each line of the summary.
    pub facts: Vec<(String, String)>,
    /// Deviation of each invariant, maxima over windows of every step.
    #[serde(skip)]
    pub invariants: Vec<InvariantSeries>,
    /// Whether the drift plot has a logarithmic time axis, for long runs.
    pub logarithmic_time: bool,
    /// Every how many steps the invariants are looked at.
    pub drift_every: u64,
    /// How the energy of the motion itself changes, in words, as "changes by the forces"; none where it is an
    /// invariant.
    pub work: Option<String>,
    /// Energy at the recorded states.
    #[serde(skip)]
    pub energy: Option<TimeSeries>,
    /// Recorded formulas by their names.
    #[serde(skip)]
    pub observables: Vec<(String, TimeSeries)>,
    /// The recorded states on a section.
    #[serde(skip)]
    pub section: Option<SectionPoints>,
    /// The recorded states to draw.
    #[serde(skip)]
    pub trajectory: Option<Trajectory>,
    /// Structure factors of the recorded states, one of each field.
    #[serde(skip)]
    pub structure: Vec<StructureFactor>,
    /// The recorded samples, which a script turns and zooms.
    #[serde(skip)]
    pub recorded: Option<Recorded>,
    /// Solver evaluations a step.
    #[serde(skip)]
    pub solver: Option<TimeSeries>,
}

/// How a run ended.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Outcome {
    /// All steps were made.
    Done {
        /// Summary of the whole run, as "1000 steps to t = 200".
        message: String,
    },
    /// The run was stopped and can be resumed.
    Interrupted {
        /// Where it stopped.
        message: String,
    },
    /// The run failed; what was recorded before is shown.
    Failed {
        /// Cause of the failure, in words.
        message: String,
        /// The step that failed.
        step: u64,
        /// The time before that step.
        time: f64,
        /// The state before that step, by coordinate.
        state: Vec<(String, f64)>,
        /// Advice: a remedy to try.
        hint: String,
    },
}

impl Default for Outcome {
    fn default() -> Self {
        Self::Done {
            message: String::new(),
        }
    }
}

/// Values over time.
#[derive(Clone, Debug, Default)]
pub struct TimeSeries {
    /// Times.
    pub times: Vec<f64>,
    /// One value for each time.
    pub values: Vec<f64>,
}

/// Recorded samples.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    /// The columns' names: the time, the coordinates, the observables.
    pub names: Vec<String>,
    /// How many are coordinates.
    pub coordinates: usize,
    /// A row for each sample.
    pub rows: Vec<Vec<f64>>,
}

/// How far an invariant strayed from its initial value.
#[derive(Clone, Debug, Default)]
pub struct InvariantSeries {
    /// The invariant's name.
    pub name: String,
    /// Its value I(0).
    pub reference: f64,
    /// The end time of each window.
    pub times: Vec<f64>,
    /// max |I(t) − I(0)| over every step of each window.
    pub deviations: Vec<f64>,
}

/// States on a section.
#[derive(Clone, Debug, Default)]
pub struct SectionPoints {
    /// The section and the direction, as "q1 = 0, upwards".
    pub title: String,
    /// Names of the two columns that are drawn over each other: across, then up.
    pub names: [String; 2],
    /// A point for each crossing.
    pub points: Vec<[f64; 2]>,
    /// The member of an ensemble that each is of; nothing of a run.
    pub members: Vec<u64>,
}

/// The states to draw.
#[derive(Clone, Debug)]
pub enum Trajectory {
    /// A few coordinates of the state; the first three are drawn.
    Orbit {
        /// The coordinates' names.
        names: Vec<String>,
        /// Times of the recorded states.
        times: Vec<f64>,
        /// One point for each time, as long as `names`.
        points: Vec<Vec<f64>>,
        /// The symplectic leaf, where it is an ellipsoid in the first three coordinates.
        leaf: Option<Ellipsoid>,
    },
    /// A field on the sites of a family.
    Lattice {
        /// The family's name.
        name: String,
        /// Times of the recorded fields.
        times: Vec<f64>,
        /// Sites from one value of a field to the next; 1 where every site is there.
        spacing: usize,
        /// One field for each time.
        fields: Vec<Vec<f64>>,
        /// Whether sites have neighbours: of others their order says nothing.
        has_neighbours: bool,
    },
    /// Bodies in a plane.
    Bodies {
        /// The names of the places, across and up.
        axes: [String; 2],
        /// The bodies that are drawn.
        bodies: Vec<BodyPath>,
        /// How many bodies there are.
        count: usize,
    },
    /// Fields over two axes of a lattice.
    Planes {
        /// The fields, a figure each.
        fields: Vec<FieldMaps>,
        /// Which plane of a lattice of three axes they show.
        slice: Option<String>,
        /// Which fields are not drawn.
        rest: Option<String>,
    },
}

/// S(q) = ⟨|Σ_r s(r) exp(−i q·r)|²⟩/N of a field s on N sites, summed over the components of a vector.
#[derive(Clone, Debug)]
pub struct StructureFactor {
    /// The field, as "s".
    pub name: String,
    /// The letters of one or two axes; of a chain there is none.
    pub axes: Vec<String>,
    /// The numbers L of sites along them.
    pub lengths: Vec<usize>,
    /// S at q = 2πm/L, m from 0 to L − 1 along each axis, the last one first.
    pub values: Vec<f64>,
    /// How many states the mean is of, and how many were recorded.
    pub states: [u64; 2],
    /// Which axes have q = 0 alone, and why.
    pub notes: Vec<String>,
}

/// The path of a body in a plane.
#[derive(Clone, Debug)]
pub struct BodyPath {
    /// The body, as `q[3]`.
    pub name: String,
    /// Its number among all bodies.
    pub number: usize,
    /// Its places, from the start on.
    pub places: Vec<[f64; 2]>,
}

/// A field over two axes of a lattice at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneMap {
    /// The field and the time, as "s.z at t = 10".
    pub title: String,
    /// The names of the axes, across and up.
    pub axes: [String; 2],
    /// The number of sites across.
    pub columns: usize,
    /// The values at all sites, one row above the other.
    pub values: Vec<f64>,
    /// A vector in the plane at each site, across and up; none of a field of numbers.
    pub arrows: Vec<[f64; 2]>,
}

/// Maps of a field over two axes of a lattice at some times.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldMaps {
    /// The field, as "s".
    pub name: String,
    /// The maps, in the order in which they are drawn.
    pub maps: Vec<PlaneMap>,
    /// The quantity in colour, as "s.z".
    pub color: String,
}

/// Σ ((x_i − c_i)/a_i)² = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// The center c.
    pub center: [f64; 3],
    /// The semi-axes a.
    pub semi_axes: [f64; 3],
}

//! The recorded states of a run directory: by which file, and where each coordinate stands in a row.

use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use serde::Deserialize;
use serde_json::{Map, Value};

use super::job::MANIFEST;
use super::states::HEADER;

/// Fields of a manifest that say where states are.
#[derive(Deserialize)]
pub(super) struct StateFields {
    #[serde(default)]
    pub axes: Vec<usize>,
    pub variables: Value,
    /// Names of the sites of a chain; none where they are numbers.
    #[serde(default)]
    pub site_names: Vec<String>,
    #[serde(default)]
    pub dimension: usize,
    pub states: StatesEntry,
    #[serde(default)]
    pub time: f64,
}

/// The recorded states of a manifest.
#[derive(Deserialize)]
pub(super) struct StatesEntry {
    pub file: Option<String>,
    pub slices: Vec<RecordedSlice>,
}

/// A slice of the state that was recorded.
#[derive(Deserialize)]
pub(super) struct RecordedSlice {
    pub name: String,
    pub first: Option<usize>,
    pub step: usize,
    pub count: usize,
}

/// A coordinate of a run by its name.
pub enum NamedState {
    /// Its values, one for each row of `samples.csv`.
    Recorded(Vec<f64>),
    /// The run has such a coordinate, and did not record it.
    NotRecorded,
    /// It is none of the run in this directory, or there is no run.
    Unknown,
}

/// A coordinate, as `q[3]`, `q[Sun]` or `s.z[2,5]`, of the run in a directory, whose states stand in `states.npy`.
///
/// # Errors
/// That of a file of states that cannot be read, or is too short.
pub fn named_state(directory: &Path, name: &str) -> std::io::Result<NamedState> {
    let Some(fields) = StateFields::read(directory) else {
        return Ok(NamedState::Unknown);
    };
    let Some((family, site)) = fields.site(name) else {
        return Ok(NamedState::Unknown);
    };
    let states = &fields.states;
    let is_table = states.file.as_deref() == Some(super::states::FILE);
    let Some(place) = states.place(family, site).filter(|_| is_table) else {
        return Ok(NamedState::NotRecorded);
    };
    let file = directory.join(super::states::FILE);
    let width = states.width();
    let length = fs::metadata(&file)?.len();
    let rows = length.saturating_sub(HEADER as u64) as usize / (8 * width);
    let value = |row: usize| {
        let start = HEADER + 8 * (row * width + place);
        doubles(&file, start as u64, 1).map(|value| value[0])
    };
    let values: std::io::Result<_> = (0..rows).map(value).collect();
    values.map(NamedState::Recorded)
}

impl StateFields {
    /// Those of the run in a directory; `None` where there is none.
    pub fn read(directory: &Path) -> Option<Self> {
        let text = fs::read_to_string(directory.join(MANIFEST)).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// The names of the families, of variables `x[0,0]`, …, or of names with lengths; single variables are none.
    pub fn families(&self) -> Option<Vec<String>> {
        match &self.variables {
            Value::Object(families) => Some(Map::keys(families).cloned().collect()),
            Value::Array(names) => {
                let mut families: Vec<String> = Vec::new();
                for name in names {
                    let Some((family, _)) = name.as_str()?.split_once('[') else {
                        continue;
                    };
                    if families.last().is_none_or(|last| last != family) {
                        families.push(family.to_owned());
                    }
                }
                Some(families)
            }
            _ => None,
        }
    }

    /// The family and the site of a coordinate by its name.
    fn site<'a>(&self, name: &'a str) -> Option<(&'a str, usize)> {
        let (family, rest) = name.trim().split_once('[')?;
        let family = family.trim();
        let places = rest.strip_suffix(']')?.split(',');
        let number = |place: &str| {
            let mut names = self.site_names.iter();
            let named = names.position(|own| own == place);
            named.or_else(|| place.parse().ok())
        };
        let places: Vec<usize> = places
            .map(|place| number(place.trim()))
            .collect::<Option<_>>()?;
        let is_there = self.families()?.iter().any(|own| own == family);
        let site = match (&places[..], &self.axes[..]) {
            ([site], axes) if axes.len() < 2 => *site,
            (places, axes) if places.len() == axes.len() => {
                let pairs = || places.iter().zip(axes);
                let is_within = pairs().all(|(place, length)| place < length);
                is_within.then(|| pairs().fold(0, |all, (place, length)| all * length + place))?
            }
            _ => return None,
        };
        is_there.then_some((family, site))
    }
}

impl StatesEntry {
    /// The number of coordinates of a row.
    pub fn width(&self) -> usize {
        self.slices.iter().map(|slice| slice.count).sum()
    }

    /// Where a site of a family stands in a row.
    fn place(&self, family: &str, site: usize) -> Option<usize> {
        let mut before = 0;
        for slice in &self.slices {
            let steps = slice.first.and_then(|first| site.checked_sub(first));
            let at = steps.filter(|steps| {
                slice.name == family && steps % slice.step == 0 && steps / slice.step < slice.count
            });
            if let Some(steps) = at {
                return Some(before + steps / slice.step);
            }
            before += slice.count;
        }
        None
    }
}

/// So many doubles of a file from a place on.
pub(super) fn doubles(file: &Path, start: u64, count: usize) -> std::io::Result<Vec<f64>> {
    let mut open = File::open(file)?;
    let length = open.metadata()?.len();
    if length < start.saturating_add(8 * count as u64) {
        return Err(std::io::Error::from(std::io::ErrorKind::UnexpectedEof));
    }
    open.seek(SeekFrom::Start(start))?;
    let mut bytes = vec![0; 8 * count];
    open.read_exact(&mut bytes)?;
    let values = bytes.chunks_exact(8);
    Ok(values
        .map(|value| f64::from_le_bytes(value.try_into().unwrap_or_default()))
        .collect())
}

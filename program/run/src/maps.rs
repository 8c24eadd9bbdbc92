//! Maps of the states that a run directory holds.

use std::path::{Path, PathBuf};

use leafwise_core::lattice::{Axis, LatticeGeometry};
use leafwise_report::FieldMaps;
use leafwise_scene::input::read_text;
use leafwise_scene::table::Table;
use thiserror::Error;

use super::planes::{LETTERS, MapField, Slice, map, places_alone};
use super::recorded_states::{StateFields, StatesEntry, doubles};
use super::shown::rounded;
use super::states::{FINAL_STATE, HEADER};

/// A choice of what maps show.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapRequest {
    /// A family or a component in colour, as `q` or `s.z`; or a vector `s` of x, y and z, with s.z in colour and s.x and s.y
    /// as arrows.
    pub field: String,
    /// The times; where there are none, up to six recorded ones. Of each the nearest recorded state is drawn.
    pub at: Vec<f64>,
    /// The axis of a lattice of three axes that is cut, and at which site: `("k", 3)`. Its middle where not said.
    pub slice: Option<(String, usize)>,
}

/// Reasons why there are no such maps.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NoMaps {
    /// The directory holds no run, or one of another version.
    #[error("{} holds no run with the axes of a lattice", .0.display())]
    NoRun(PathBuf),
    /// The families of the run have one axis, or there are none.
    #[error("the run in {} has no lattice of two or three axes", .0.display())]
    NoAxes(PathBuf),
    /// There is no such family or vector.
    #[error("the lattice has no field `{name}`; it has {}", fields.join(", "))]
    NoField {
        /// The name that was asked for.
        name: String,
        /// The names that there are.
        fields: Vec<String>,
    },
    /// The states were not recorded at every site.
    #[error("`{0}` was not recorded at every site: the directory has its last state alone")]
    NotRecorded(String),
    /// A time before the first or behind the last recorded one.
    #[error("t = {time} is outside of the recorded times, {first} to {last}")]
    NoTime {
        /// The time that was asked for.
        time: f64,
        /// The first recorded time.
        first: f64,
        /// The last one.
        last: f64,
    },
    /// A slice that does not cut the lattice.
    #[error("{axis} = {at} is no plane of a lattice of {} sites", lengths.join(" × "))]
    NoSlice {
        /// The axis.
        axis: String,
        /// The site.
        at: usize,
        /// The lengths of its axes.
        lengths: Vec<String>,
    },
    /// A file that cannot be read.
    #[error("cannot read {}: {reason}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// Why.
        reason: String,
    },
}

impl NoMaps {
    /// Advice: another request.
    pub fn help(&self) -> String {
        match self {
            Self::NoRun(_) => {
                "give the directory of a run; one of an older version is run again".to_owned()
            }
            Self::NoAxes(_) => {
                "--x and --y draw columns; the report has chains over space and time".to_owned()
            }
            Self::NoField { fields, .. } => format!("write --map {}", fields[0]),
            Self::NotRecorded(_) => {
                "record the states in [run], record = { states = \"all\" }, or leave --at out"
                    .to_owned()
            }
            Self::NoTime { .. } => "take one of them, or leave --at out".to_owned(),
            Self::NoSlice { lengths, .. } => match lengths.len() {
                3 => format!("axes are {}, sites are counted from 0", LETTERS.join(", ")),
                _ => "a plane has no slices: leave --slice out".to_owned(),
            },
            Self::File { .. } => "run the scene again".to_owned(),
        }
    }
}

/// Maps of a field of the run in a directory.
///
/// # Errors
/// [`NoMaps`], with what to do instead.
pub fn maps(directory: &Path, request: &MapRequest) -> Result<FieldMaps, NoMaps> {
    let none = || NoMaps::NoRun(directory.to_owned());
    let fields = StateFields::read(directory).ok_or_else(none)?;
    let names = fields.families().ok_or_else(none)?;
    if fields.axes.is_empty() || names.is_empty() {
        return Err(none());
    }
    if !(2..=LETTERS.len()).contains(&fields.axes.len()) {
        return Err(NoMaps::NoAxes(directory.to_owned()));
    }
    let axes = fields.axes.iter().map(|length| Axis {
        length: *length,
        periodic: true,
    });
    let geometry = LatticeGeometry::along(names, axes.collect());
    let slice = slice(&geometry, request)?;
    let (field, color, families) = field(&geometry, &request.field)?;
    let states = match places(&fields.states, &geometry, &families) {
        Some(places) => recorded(directory, &fields.states, &places, request)?,
        None if request.at.is_empty() => {
            let file = directory.join(FINAL_STATE);
            // Single variables stand before families.
            let first = fields.dimension.saturating_sub(geometry.dimension());
            let whole = last_state(&file, first, &geometry)?;
            let sites = geometry.length();
            let own = families
                .iter()
                .flat_map(|family| &whole[family * sites..][..sites]);
            vec![(fields.time, own.copied().collect())]
        }
        None => return Err(NoMaps::NotRecorded(request.field.clone())),
    };
    let maps = states
        .iter()
        .map(|(time, state)| map(&geometry, &field, &(rounded(*time, 6), &state[..]), slice));
    let cut = slice.map_or_else(String::new, |slice| format!("{}, ", slice.text()));
    let mut maps: Vec<_> = maps.collect();
    for map in &mut maps {
        map.title = map.title.replacen("t = ", &format!("{cut}t = "), 1);
    }
    Ok(FieldMaps {
        name: request.field.clone(),
        maps,
        color,
    })
}

/// The field of this name among the coordinates of its families alone, its name in colour, and these families.
fn field(geometry: &LatticeGeometry, name: &str) -> Result<(MapField, String, Vec<usize>), NoMaps> {
    let place = |name: &str| geometry.families.iter().position(|(own, _)| own == name);
    let own = |color: usize, arrows: Option<[usize; 2]>| MapField {
        name: name.to_owned(),
        color: color * geometry.length(),
        arrows: arrows.map(|arrows| arrows.map(|family| family * geometry.length())),
    };
    if let Some(family) = place(name) {
        return Ok((own(0, None), name.to_owned(), vec![family]));
    }
    let [x, y, z] = ["x", "y", "z"].map(|letter| place(&format!("{name}.{letter}")));
    if let (Some(x), Some(y), Some(z)) = (x, y, z) {
        return Ok((own(2, Some([0, 1])), format!("{name}.z"), vec![x, y, z]));
    }
    let mut fields: Vec<String> = Vec::new();
    for (family, _) in &geometry.families {
        let vector = family.strip_suffix(".x");
        let has_all = |vector: &&str| {
            let mut others = ["y", "z"].into_iter();
            others.all(|letter| place(&format!("{vector}.{letter}")).is_some())
        };
        fields.extend(vector.filter(has_all).map(str::to_owned));
        fields.push(family.clone());
    }
    Err(NoMaps::NoField {
        name: name.to_owned(),
        fields,
    })
}

/// The plane to draw.
fn slice(geometry: &LatticeGeometry, request: &MapRequest) -> Result<Option<Slice>, NoMaps> {
    let Some((letter, at)) = &request.slice else {
        return Ok(Slice::middle(geometry));
    };
    let axis = LETTERS.iter().position(|known| known == letter);
    let axis = axis
        .filter(|axis| geometry.axes.len() == LETTERS.len() && *at < geometry.axes[*axis].length);
    match axis {
        Some(axis) => Ok(Some(Slice { axis, at: *at })),
        None => Err(NoMaps::NoSlice {
            axis: letter.clone(),
            at: *at,
            lengths: geometry.lengths().iter().map(usize::to_string).collect(),
        }),
    }
}

/// Where each family stands in a row of recorded coordinates; `None` where one is not there at every site.
fn places(
    states: &StatesEntry,
    geometry: &LatticeGeometry,
    families: &[usize],
) -> Option<Vec<usize>> {
    let place = |family: &usize| {
        let mut before = 0;
        for slice in &states.slices {
            let is_whole = slice.step == 1
                && slice.first == Some(0)
                && slice.count == geometry.length()
                && slice.name == geometry.families[*family].0;
            if is_whole {
                return Some(before..before + slice.count);
            }
            before += slice.count;
        }
        None
    };
    let places: Option<Vec<_>> = families.iter().map(place).collect();
    Some(places?.into_iter().flatten().collect())
}

/// The recorded states nearest to the times, each the coordinates at these places of a row.
fn recorded(
    directory: &Path,
    states: &StatesEntry,
    places: &[usize],
    request: &MapRequest,
) -> Result<Vec<(f64, Vec<f64>)>, NoMaps> {
    let broken = |file: &Path, reason: &dyn ToString| NoMaps::File {
        file: file.to_owned(),
        reason: reason.to_string(),
    };
    let samples = directory.join(super::samples::FILE);
    let text = read_text(&samples).map_err(|error| broken(&samples, &error))?;
    let table = Table::read(&text).map_err(|error| broken(&samples, &error))?;
    let times: Vec<f64> = table.rows.iter().map(|row| row[0]).collect();
    let chosen = match request.at.is_empty() {
        true => places_alone(times.len()),
        false => (request.at.iter())
            .map(|time| nearest(&times, *time))
            .collect::<Result<_, _>>()?,
    };
    let width = states.width();
    let is_in_samples = states.file.as_deref() == Some(super::samples::FILE);
    let mut states = Vec::with_capacity(chosen.len());
    for at in chosen {
        let row = match is_in_samples {
            true => table.rows[at].iter().skip(1).take(width).copied().collect(),
            false => {
                let file = directory.join(super::states::FILE);
                let start = HEADER as u64 + 8 * (at * width) as u64;
                doubles(&file, start, width).map_err(|error| broken(&file, &error))?
            }
        };
        let own: Option<Vec<f64>> = places
            .iter()
            .map(|place| row.get(*place).copied())
            .collect();
        let own = own.ok_or_else(|| broken(&samples, &"a row is too short"))?;
        states.push((times[at], own));
    }
    Ok(states)
}

/// The place of the time nearest to one.
fn nearest(times: &[f64], time: f64) -> Result<usize, NoMaps> {
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    let most = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // Decimals of a time are not its double.
    let slack = 1e-9 * (most - least);
    let is_within = time >= least - slack && time <= most + slack;
    let places = 0..times.len();
    let near = places.min_by(|a, b| {
        (times[*a] - time)
            .abs()
            .total_cmp(&(times[*b] - time).abs())
    });
    near.filter(|_| is_within).ok_or(NoMaps::NoTime {
        time,
        first: times.first().copied().unwrap_or(f64::NAN),
        last: times.last().copied().unwrap_or(f64::NAN),
    })
}

/// The families at the end, which are in no other file, behind so many single variables.
fn last_state(file: &Path, first: usize, geometry: &LatticeGeometry) -> Result<Vec<f64>, NoMaps> {
    doubles(file, 8 * first as u64, geometry.dimension()).map_err(|error| NoMaps::File {
        file: file.to_owned(),
        reason: error.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::job::MANIFEST;
    use crate::recorded_states::{NamedState, named_state};

    const MANIFEST_OF: &str = r#"{"variables": {"s.x": 24, "s.y": 24, "s.z": 24}, "axes": [2, 3, 4], "time": 7.5,
        "states": {"file": "states.npy", "slices": SLICES, "last": "final_state.bin"}}"#;

    /// A directory of 2 × 3 × 4 spins with three recorded states, the number of a coordinate plus 100 times that of the state.
    fn run(slices: &str) -> tempfile::TempDir {
        let root = tempfile::tempdir().expect("a directory");
        let write =
            |name: &str, bytes: &[u8]| fs::write(root.path().join(name), bytes).expect("written");
        write(MANIFEST, MANIFEST_OF.replace("SLICES", slices).as_bytes());
        write("samples.csv", b"t,energy\n0,1\n2.5,1\n7.5,1\n");
        let states = (0..3_u32).flat_map(|k| (0..72).map(move |at| f64::from(100 * k + at)));
        let bytes: Vec<u8> = states.flat_map(f64::to_le_bytes).collect();
        write("states.npy", &[&[0; HEADER], &bytes[..]].concat());
        let last = (0..72).map(|at| f64::from(at) - 0.5);
        write(
            "final_state.bin",
            &last.flat_map(f64::to_le_bytes).collect::<Vec<u8>>(),
        );
        root
    }

    const ALL: &str = r#"[{"name": "s.x", "first": 0, "step": 1, "count": 24},
        {"name": "s.y", "first": 0, "step": 1, "count": 24}, {"name": "s.z", "first": 0, "step": 1, "count": 24}]"#;

    fn request(field: &str, at: &[f64], slice: Option<(&str, usize)>) -> MapRequest {
        MapRequest {
            field: field.to_owned(),
            at: at.to_vec(),
            slice: slice.map(|(axis, at)| (axis.to_owned(), at)),
        }
    }

    #[test]
    fn maps_are_slices_of_recorded_states() {
        let run = run(ALL);
        let drawn = |request: &MapRequest| maps(run.path(), request).expect("maps");
        let whole = drawn(&request("s", &[], None));
        let titles: Vec<&str> = whole.maps.iter().map(|map| map.title.as_str()).collect();
        assert_eq!(
            titles,
            [
                "s at k = 2, t = 0",
                "s at k = 2, t = 2.5",
                "s at k = 2, t = 7.5"
            ]
        );
        assert_eq!(whole.color, "s.z");
        // The site i, j, 2 is the number 12 i + 4 j + 2.
        let sites = [2, 14, 6, 18, 10, 22].map(f64::from);
        assert_eq!(whole.maps[1].values, sites.map(|site| 100.0 + 48.0 + site));
        assert_eq!(
            whole.maps[1].arrows,
            sites.map(|site| [100.0 + site, 124.0 + site])
        );
        let one = drawn(&request("s.y", &[3.0, 7.5], Some(("i", 1))));
        assert_eq!(one.maps.len(), 2);
        assert_eq!(one.maps[0].title, "s.y at i = 1, t = 2.5");
        assert_eq!(
            (one.maps[0].axes[0].as_str(), one.maps[0].columns),
            ("j", 3)
        );
        let first_row = [12, 16, 20].map(|site| 100.0 + 24.0 + f64::from(site));
        assert_eq!(one.maps[0].values[..3], first_row);
    }

    /// Without recorded states there is the last one, and no other time.
    #[test]
    fn the_last_state_is_drawn_where_none_was_recorded() {
        let run = run(r#"[{"name": "s.x", "first": 3, "step": 1, "count": 1}]"#);
        let last = maps(run.path(), &request("s.z", &[], None)).expect("a map");
        assert_eq!(last.maps.len(), 1);
        assert_eq!(last.maps[0].values[0], 48.0 + 2.0 - 0.5);
        let error = maps(run.path(), &request("s.z", &[0.0], None)).expect_err("no state");
        assert!(
            error.help().contains("states = \"all\""),
            "{}",
            error.help()
        );
    }

    /// Single variables stand before families, in the names of a short state and in its file.
    #[test]
    fn single_variables_are_no_fields() {
        let root = tempfile::tempdir().expect("a directory");
        let sites = "\"q[0,0]\", \"q[0,1]\", \"q[1,0]\", \"q[1,1]\"";
        let manifest = format!(
            "{{\"variables\": [\"a\", {sites}], \"dimension\": 5, \"axes\": [2, 2], \"time\": 1, \"states\": {{\"slices\": []}}}}"
        );
        fs::write(root.path().join(MANIFEST), manifest).expect("written");
        let state = [7.0, 1.0, 2.0, 3.0, 4.0];
        let bytes: Vec<u8> = state.into_iter().flat_map(f64::to_le_bytes).collect();
        fs::write(root.path().join(FINAL_STATE), bytes).expect("written");
        let drawn = maps(root.path(), &request("q", &[], None)).expect("a map");
        // i runs across.
        assert_eq!(drawn.maps[0].values, [1.0, 3.0, 2.0, 4.0]);
        assert_eq!(drawn.name, "q");
    }

    /// Each wrong request has its own words, and the way out.
    #[test]
    fn wrong_requests_are_told() {
        let run = run(ALL);
        let nowhere = tempfile::tempdir().expect("a directory");
        for (directory, request, said, help) in [
            (
                run.path(),
                request("m", &[], None),
                "has s, s.x, s.y, s.z",
                "--map s",
            ),
            (run.path(), request("s", &[8.0], None), "0 to 7.5", "--at"),
            (
                run.path(),
                request("s", &[f64::NAN], None),
                "t = NaN",
                "--at",
            ),
            (
                run.path(),
                request("s", &[], Some(("k", 4))),
                "2 × 3 × 4",
                "i, j, k",
            ),
            (
                run.path(),
                request("s", &[], Some(("x", 0))),
                "x = 0",
                "i, j, k",
            ),
            (
                nowhere.path(),
                request("s", &[], None),
                "holds no run",
                "directory of a run",
            ),
        ] {
            let error = maps(directory, &request).expect_err("no maps");
            assert!(error.to_string().contains(said), "{error}");
            assert!(error.help().contains(help), "{}", error.help());
        }
        fs::remove_file(run.path().join("states.npy")).expect("removed");
        let error = maps(run.path(), &request("s", &[], None)).expect_err("no file");
        assert!(error.to_string().contains("states.npy"), "{error}");
    }

    /// A coordinate by its name is a column of the table of states, or one that the run has and did not record.
    #[test]
    fn a_recorded_coordinate_is_a_column() {
        let run = run(
            r#"[{"name": "s.x", "first": 0, "step": 5, "count": 5}, {"name": "s.y", "first": 0, "step": 1, "count": 24},
                {"name": "s.z", "first": 1, "step": 1, "count": 43}]"#,
        );
        let named = |name: &str| named_state(run.path(), name).expect("a file");
        // The site 0, 2, 2 is the number 10, the third of every fifth; 1, 1, 1 is the number 17.
        for (name, place) in [("s.x[0,2,2]", 2), ("s.y[1,1,1]", 5 + 17)] {
            let NamedState::Recorded(values) = named(name) else {
                panic!("{name}");
            };
            let expected = [0, 100, 200].map(|at| f64::from(at + place));
            assert_eq!(values, expected, "{name}");
        }
        assert!(matches!(named("s.x[0,0,1]"), NamedState::NotRecorded));
        for none in ["s.x[0,0,4]", "s.x[3]", "s.w[0,0,0]", "energy"] {
            assert!(matches!(named(none), NamedState::Unknown), "{none}");
        }
        fs::remove_file(run.path().join("states.npy")).expect("removed");
        assert!(named_state(run.path(), "s.y[0,0,0]").is_err());
    }
}

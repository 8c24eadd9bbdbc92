//! Maps of the fields of a lattice of several axes.

use leafwise_core::lattice::LatticeGeometry;
use leafwise_report::{FieldMaps, PlaneMap, Trajectory};
use leafwise_scene::compose::{SiteField, Sites};

/// The most fields that are drawn, and the most components of a vector.
const MOST_FIELDS: usize = 3;

/// The most times at which a field alone is drawn, and each of several.
const MOST_TIMES: usize = 6;
const FEWER_TIMES: usize = 3;

/// The letters of axes.
pub(crate) const LETTERS: [&str; 3] = ["i", "j", "k"];

/// A state of a lattice at a time, which is written beside its maps.
pub(crate) type Timed<'a> = (String, &'a [f64]);

/// A field of a lattice: the place of its first family, and of two components to be drawn as arrows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MapField {
    /// The field, as "s" or "q".
    pub name: String,
    /// The coordinate at the first site of the family in colour.
    pub color: usize,
    /// The same of the two families whose values are arrows across and up.
    pub arrows: Option<[usize; 2]>,
}

/// The plane that a map shows: the first two axes but one that is cut, at a site of that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slice {
    /// The axis that is cut.
    pub axis: usize,
    /// Where.
    pub at: usize,
}

impl Slice {
    /// The middle of the last axis of three; `None` of a plane.
    pub fn middle(geometry: &LatticeGeometry) -> Option<Self> {
        let axis = 2;
        let own = geometry.axes.get(axis)?;
        let at = own.length / 2;
        Some(Self { axis, at })
    }

    /// The slice in words.
    pub fn text(self) -> String {
        format!("{} = {}", LETTERS[self.axis], self.at)
    }
}

/// The fields that pictures show: no momenta where there are others, and a few of many.
pub(super) fn shown_fields(sites: &Sites) -> Vec<SiteField> {
    let fields = sites.fields();
    let has_places = fields.iter().any(|field| !field.is_momentum);
    let shown = fields.into_iter();
    let shown = shown.filter(|field| !(has_places && field.is_momentum));
    shown.take(MOST_FIELDS).collect()
}

/// Maps along a run, a figure a field. Spins are shown at some of its states, s.z in colour and (s.x, s.y) as arrows. Other
/// vectors have every component at the last state.
pub(super) fn planes(sites: &Sites, states: &[Timed<'_>]) -> Option<Trajectory> {
    let geometry = &sites.geometry;
    let slice = Slice::middle(geometry);
    let shown = shown_fields(sites);
    let most = match shown.len() {
        1 => MOST_TIMES,
        _ => FEWER_TIMES,
    };
    let last = states.len().saturating_sub(1);
    let fields = shown.iter().map(|field| {
        let color = |family: usize| MapField {
            name: geometry.families[family].0.clone(),
            color: sites.coordinates(family).start,
            arrows: None,
        };
        let (own, places, color) = match (field.spins, &field.families[..]) {
            (Some([x, y, z]), _) => {
                let spins = MapField {
                    name: field.name.clone(),
                    arrows: Some([x, y].map(|family| sites.coordinates(family).start)),
                    ..color(z)
                };
                let name = color(z).name;
                (vec![spins], some_places(states.len(), most), name)
            }
            (None, [family]) => {
                let own = vec![color(*family)];
                (own, some_places(states.len(), most), field.name.clone())
            }
            (None, families) => {
                let own = families.iter().take(MOST_FIELDS).copied().map(color);
                (own.collect(), vec![last], field.name.clone())
            }
        };
        let maps = own.iter().flat_map(|field| {
            let maps = places.iter().filter_map(|at| states.get(*at));
            maps.map(|state| map(geometry, field, state, slice))
                .collect::<Vec<_>>()
        });
        FieldMaps {
            name: field.name.clone(),
            maps: maps.collect(),
            color,
        }
    });
    let fields: Vec<FieldMaps> = fields.collect();
    let rest = sites.fields();
    let rest = rest.iter().filter(|field| !shown.contains(field));
    let rest: Vec<&str> = rest.map(|field| field.name.as_str()).collect();
    (!fields.is_empty()).then(|| Trajectory::Planes {
        fields,
        slice: slice
            .map(|slice| format!("The plane {} of the lattice, in its middle.", slice.text())),
        rest: (!rest.is_empty()).then(|| {
            let draws = format!("leafwise plot RUN --map {} draws", rest[0]);
            match rest.len() {
                1 => format!("Not drawn: {}; {draws} it.", rest[0]),
                _ => format!("Not drawn: {}; {draws} the first of them.", rest.join(", ")),
            }
        }),
    })
}

/// The places of some times at which a field alone is drawn.
pub(crate) fn places_alone(things: usize) -> Vec<usize> {
    some_places(things, MOST_TIMES)
}

/// The places of at most so many things, evenly, the first and the last among them.
fn some_places(things: usize, most: usize) -> Vec<usize> {
    let count = things.min(most);
    let parts = count.saturating_sub(1).max(1);
    let place = |k: usize| (k * (things - 1) + parts / 2) / parts;
    (0..count).map(place).collect()
}

/// A map of a field over two axes, the first of them across.
pub(crate) fn map(
    geometry: &LatticeGeometry,
    field: &MapField,
    (time, state): &Timed<'_>,
    slice: Option<Slice>,
) -> PlaneMap {
    let cut = slice.map_or(geometry.axes.len(), |slice| slice.axis);
    let own: Vec<usize> = (0..geometry.axes.len())
        .filter(|axis| *axis != cut)
        .collect();
    let [across, up] = [own[0], own[1]];
    let mut place = geometry.place(0);
    if let Some(slice) = slice {
        place[slice.axis] = slice.at;
    }
    let (mut values, mut arrows) = (Vec::new(), Vec::new());
    for row in 0..geometry.axes[up].length {
        for column in 0..geometry.axes[across].length {
            (place[across], place[up]) = (column, row);
            let site = geometry.site(place);
            values.push(state[field.color + site]);
            arrows.extend(
                field
                    .arrows
                    .map(|arrows| arrows.map(|first| state[first + site])),
            );
        }
    }
    PlaneMap {
        title: format!("{} at t = {time}", field.name),
        axes: [across, up].map(|axis| LETTERS[axis].to_owned()),
        columns: geometry.axes[across].length,
        values,
        arrows,
    }
}

#[cfg(test)]
mod tests {
    use leafwise_core::lattice::Axis;

    use super::*;

    fn sites(names: &[&str], lengths: &[usize], spins: &[[usize; 3]]) -> Sites {
        let axes = lengths.iter().map(|length| Axis {
            length: *length,
            periodic: true,
        });
        let names = names.iter().map(|name| (*name).to_owned());
        Sites {
            geometry: LatticeGeometry::along(names, axes.collect()),
            first: 0,
            has_neighbours: true,
            plane: None,
            spins: spins.to_vec(),
        }
    }

    fn drawn(sites: &Sites, states: &[Timed<'_>]) -> (Vec<PlaneMap>, Option<String>) {
        match planes(sites, states) {
            Some(Trajectory::Planes { fields, slice, .. }) => (
                fields.into_iter().flat_map(|field| field.maps).collect(),
                slice,
            ),
            other => panic!("{other:?}"),
        }
    }

    /// A box of 3 × 4 × 200 sites: the plane k = 100, its first axis across.
    #[test]
    fn a_map_is_the_plane_through_the_middle() {
        let sites = sites(&["q"], &[3, 4, 200], &[]);
        let state: Vec<f64> = (0..2400).map(f64::from).collect();
        let states = ["0", "2.5"].map(|time| (time.to_owned(), &state[..]));
        let (maps, slice) = drawn(&sites, &states);
        assert_eq!(maps.len(), 2);
        assert!(slice.is_some_and(|slice| slice.contains("k = 100")));
        let map = &maps[1];
        assert_eq!((map.title.as_str(), map.columns), ("q at t = 2.5", 3));
        assert_eq!(map.axes, ["i", "j"]);
        // The site i, j, k is the number 800 i + 200 j + k.
        let row = |j: u32| [0, 1, 2].map(|i| f64::from(800 * i + 200 * j + 100));
        assert_eq!(map.values, [row(0), row(1), row(2), row(3)].concat());
    }

    /// Spins have s.z in colour, and s.x and s.y as arrows, at six times of many.
    #[test]
    fn spins_are_drawn_as_arrows_along_the_run() {
        let sites = sites(&["s.x", "s.y", "s.z"], &[2, 2], &[[0, 1, 2]]);
        let state: Vec<f64> = (0..12).map(f64::from).collect();
        let states: Vec<Timed<'_>> = (0..41).map(|time| (time.to_string(), &state[..])).collect();
        let (maps, slice) = drawn(&sites, &states);
        assert_eq!(slice, None);
        let titles: Vec<&str> = maps.iter().map(|map| map.title.as_str()).collect();
        let times = ["0", "8", "16", "24", "32", "40"];
        assert_eq!(titles, times.map(|time| format!("s at t = {time}")));
        // Sites 0, 2 stand in the first row: i runs across.
        assert_eq!(maps[0].values, [8.0, 10.0, 9.0, 11.0]);
        assert_eq!(
            maps[0].arrows,
            [[0.0, 4.0], [2.0, 6.0], [1.0, 5.0], [3.0, 7.0]]
        );
    }

    /// Every sublattice has maps of its own at three times, S(q) of its own, and momenta are named as not drawn.
    #[test]
    fn fields_of_a_cell_are_drawn_each() {
        let names = ["a.x", "a.y", "a.z", "p", "b.x", "b.y", "b.z", "c"];
        let sites = sites(&names, &[4, 4], &[[0, 1, 2], [4, 5, 6]]);
        let state: Vec<f64> = (0..128).map(f64::from).collect();
        let states: Vec<Timed<'_>> = (0..9).map(|time| (time.to_string(), &state[..])).collect();
        let Some(Trajectory::Planes { fields, rest, .. }) = planes(&sites, &states) else {
            panic!("no maps");
        };
        let told: Vec<_> = fields
            .iter()
            .map(|field| (field.name.as_str(), field.color.as_str(), field.maps.len()))
            .collect();
        assert_eq!(told, [("a", "a.z", 3), ("b", "b.z", 3), ("c", "c", 3)]);
        // Families of 16 sites: b.z is the seventh, and b.x, b.y are the fifth and the sixth.
        let map = &fields[1].maps[2];
        assert_eq!(map.title, "b at t = 8");
        assert_eq!((map.values[0], map.arrows[0]), (96.0, [64.0, 80.0]));
        assert!(rest.is_some_and(|rest| rest.contains("--map p")));
        let whole = [(0.0, state)];
        let factors = crate::structure::structure(&sites, &whole, 1);
        let names: Vec<&str> = factors.iter().map(|factor| factor.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "c"]);
    }
}

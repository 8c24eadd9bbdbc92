//! Maps of the fields of a lattice of several axes.

use leafwise_core::lattice::LatticeGeometry;
use leafwise_report::{PlaneMap, Trajectory};
use leafwise_scene::compose::Sites;

/// The most families that are drawn.
const MOST_FAMILIES: usize = 3;

/// The most times of a field that are drawn.
const MOST_TIMES: usize = 6;

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

/// Maps along a run. Spins are shown at some of its states, s.z in colour and (s.x, s.y) as arrows. Other vectors have every
/// component at the last state, and else there is the first family.
pub(super) fn planes(sites: &Sites, states: &[Timed<'_>]) -> Option<Trajectory> {
    let geometry = &sites.geometry;
    let slice = Slice::middle(geometry);
    let place = |family: usize| sites.coordinates(family).start;
    let name = |family: usize| geometry.families[family].0.clone();
    let first = &geometry.families.first()?.0;
    let vector = |family: &str| family.split_once('.').map(|(vector, _)| vector.to_owned());
    let field = |family: usize| MapField {
        name: name(family),
        color: place(family),
        arrows: None,
    };
    let (fields, states, color) = match (sites.spins, vector(first)) {
        (Some([x, y, z]), _) => {
            let spins = MapField {
                name: vector(&name(z))?,
                color: place(z),
                arrows: Some([place(x), place(y)]),
            };
            (vec![spins], some_of(states), name(z))
        }
        (None, Some(own)) => {
            let families = 0..geometry.families.len();
            let families = families.filter(|at| vector(&name(*at)).as_ref() == Some(&own));
            let last = states.len().saturating_sub(1);
            let fields = families.take(MOST_FAMILIES).map(field).collect();
            (fields, states[last..].iter().collect(), String::new())
        }
        (None, None) => (vec![field(0)], some_of(states), String::new()),
    };
    let maps = fields.iter().flat_map(|field| {
        let maps = states
            .iter()
            .map(|state| map(geometry, field, state, slice));
        maps.collect::<Vec<_>>()
    });
    Some(Trajectory::Planes {
        maps: maps.collect(),
        color,
        slice: slice
            .map(|slice| format!("The plane {} of the lattice, in its middle.", slice.text())),
    })
}

/// Some of the states, the first and the last among them.
fn some_of<'s, 'a>(states: &'s [Timed<'a>]) -> Vec<&'s Timed<'a>> {
    let places = some_places(states.len()).into_iter();
    places.map(|at| &states[at]).collect()
}

/// The places of at most six of so many things, evenly, the first and the last among them.
pub(crate) fn some_places(things: usize) -> Vec<usize> {
    let count = things.min(MOST_TIMES);
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

    fn sites(names: &[&str], lengths: &[usize], spins: Option<[usize; 3]>) -> Sites {
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
            spins,
        }
    }

    fn drawn(sites: &Sites, states: &[Timed<'_>]) -> (Vec<PlaneMap>, Option<String>) {
        match planes(sites, states) {
            Some(Trajectory::Planes { maps, slice, .. }) => (maps, slice),
            other => panic!("{other:?}"),
        }
    }

    /// A box of 3 × 4 × 200 sites: the plane k = 100, its first axis across.
    #[test]
    fn a_map_is_the_plane_through_the_middle() {
        let sites = sites(&["q"], &[3, 4, 200], None);
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
        let sites = sites(&["s.x", "s.y", "s.z"], &[2, 2], Some([0, 1, 2]));
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
}

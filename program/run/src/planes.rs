//! Maps of the fields of a lattice of several axes, where a run begins and where it ends.

use leafwise_core::lattice::LatticeGeometry;
use leafwise_report::{PlaneMap, Trajectory};

/// The most families that are drawn.
const MOST_FAMILIES: usize = 3;

/// Maps of a family at both ends of a run, each with its time as it is written; of vectors those of every component at its end.
pub(super) fn planes(
    geometry: &LatticeGeometry,
    ends: [(String, &[f64]); 2],
) -> Option<Trajectory> {
    let first = &geometry.families.first()?.0;
    let vector = first.split_once('.').map(|(vector, _)| vector);
    let chosen: Vec<(usize, usize)> = match vector {
        None => vec![(0, 0), (0, 1)],
        Some(vector) => {
            let families = geometry.families.iter().enumerate();
            let own = families.filter(|(_, (name, _))| {
                name.split_once('.')
                    .is_some_and(|(other, _)| other == vector)
            });
            own.take(MOST_FAMILIES).map(|(at, _)| (at, 1)).collect()
        }
    };
    let maps = chosen
        .into_iter()
        .map(|(family, end)| map(geometry, family, &ends[end]));
    let slice = match geometry.axes[..] {
        [axis, _, _] => Some(format!(
            "The plane i = {} of the lattice, in its middle.",
            axis.length / 2
        )),
        _ => None,
    };
    Some(Trajectory::Planes {
        maps: maps.collect(),
        slice,
    })
}

/// A map over the last two axes, through the middle of the others.
fn map(geometry: &LatticeGeometry, family: usize, (time, state): &(String, &[f64])) -> PlaneMap {
    let axes = geometry.axes.len();
    let [up, across] = [axes - 2, axes - 1].map(|axis| geometry.axes[axis].length);
    let (start, mut place) = (
        geometry.offsets()[family],
        geometry.place(geometry.middle()),
    );
    let mut values = Vec::new();
    for row in 0..up {
        for column in 0..across {
            (place[axes - 2], place[axes - 1]) = (row, column);
            values.push(state[start + geometry.site(place)]);
        }
    }
    let indices = ["i", "j", "k"];
    PlaneMap {
        title: format!("{} at t = {}", geometry.families[family].0, time),
        axes: [indices[axes - 1], indices[axes - 2]].map(str::to_owned),
        columns: across,
        values,
    }
}

#[cfg(test)]
mod tests {
    use leafwise_core::lattice::Axis;

    use super::*;

    /// A box of 3 × 4 × 200 sites: the plane i = 1.
    #[test]
    fn a_map_is_the_plane_through_the_middle() {
        let axes = [3, 4, 200].map(|length| Axis {
            length,
            periodic: true,
        });
        let geometry = LatticeGeometry::along(["q".to_owned()], axes.to_vec());
        let state: Vec<f64> = (0..2400).map(f64::from).collect();
        let drawn = planes(
            &geometry,
            ["0", "2.5"].map(|time| (time.to_owned(), &state[..])),
        );
        let Some(Trajectory::Planes { maps, slice }) = drawn else {
            panic!("maps");
        };
        assert_eq!(maps.len(), 2);
        assert!(slice.is_some_and(|slice| slice.contains("i = 1")));
        let map = &maps[1];
        assert_eq!((map.title.as_str(), map.columns), ("q at t = 2.5", 200));
        assert_eq!(map.values, state[800..1600]);
    }
}

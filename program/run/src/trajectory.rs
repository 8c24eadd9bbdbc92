//! Trajectories that a report draws: orbits, paths of bodies, fields over chains and planes.

use std::collections::HashMap;

use leafwise_report::{BodyPath, Trajectory};
use leafwise_scene::compose::{ComposedRun, Sites};

use super::drive::Session;
use super::ellipsoid::leaf;
use super::planes::planes;
use super::shown::{rounded, value};
use super::snapshots::{shown, spacing};

/// The trajectory of a run's samples, or of its whole states where these are planes.
pub(super) fn trajectory(
    run: &ComposedRun,
    session: &Session<'_>,
    (times, whole): (Vec<f64>, &[(f64, Vec<f64>)]),
    rows: &[Vec<f64>],
    width: usize,
) -> Option<Trajectory> {
    let (sites, is_whole) = (&run.plan.sites, run.plan.states.is_whole_in_samples());
    let is_lattice = run.method.lattice().is_some();
    if sites.geometry.axes.len() > 1 {
        let first = times.first().copied().unwrap_or(0.0);
        let ends = [
            (first, run.own(&run.plan.initial)),
            (session.time(), run.own(session.state())),
        ];
        let states: Vec<_> = match whole.len() {
            0 | 1 => ends.into_iter().collect(),
            _ => whole
                .iter()
                .map(|(time, state)| (*time, &state[..]))
                .collect(),
        };
        let written = states
            .into_iter()
            .map(|(time, state)| (rounded(time, 6), state));
        return planes(sites, &written.collect::<Vec<_>>());
    }
    // Long families whose states are no columns, but for a few that the scene asks for.
    let snapshots = session.snapshots();
    let has_few = width > 0 && run.plan.states.are_in_samples();
    if !snapshots.times.is_empty() && (is_lattice || !has_few) {
        return Some(along_families(
            sites,
            snapshots.times.clone(),
            snapshots.fields(),
            spacing(sites),
        ));
    }
    if rows.is_empty() || width == 0 {
        return None;
    }
    if is_whole && !sites.geometry.families.is_empty() {
        let shown = shown(sites);
        let field = |row: &Vec<f64>| shown.iter().map(|at| value(row, 1 + at)).collect();
        let fields = rows.iter().map(field).collect();
        return Some(along_families(sites, times, fields, spacing(sites)));
    }
    let names = run.plan.states.names();
    let bodies = recorded_bodies(sites, &names, rows);
    if let Some(bodies) = bodies.or_else(|| single_bodies(&names, rows)) {
        return Some(bodies);
    }
    if let Some(places) = first_body(&names) {
        let point = |row: &Vec<f64>| places.iter().map(|at| row[1 + at]).collect();
        return Some(Trajectory::Orbit {
            names: places.iter().map(|at| names[*at].clone()).collect(),
            times,
            points: rows.iter().map(point).collect(),
            leaf: None,
        });
    }
    Some(Trajectory::Orbit {
        names,
        times,
        points: rows.iter().map(|row| row[1..=width].to_vec()).collect(),
        leaf: is_whole.then(|| leaf(run)).flatten(),
    })
}

/// The paths of bodies, or a field over the sites of a chain: of the coordinates that are [`shown`] at each time.
fn along_families(
    sites: &Sites,
    times: Vec<f64>,
    fields: Vec<Vec<f64>>,
    spacing: usize,
) -> Trajectory {
    let families = &sites.geometry.families;
    let Some([x, y]) = sites.plane else {
        return Trajectory::Lattice {
            name: families[0].0.clone(),
            times,
            spacing,
            fields,
            has_neighbours: sites.has_neighbours,
        };
    };
    let count = families[x].1;
    let drawn = count.div_ceil(spacing);
    let place = |at: usize, field: &Vec<f64>| [value(field, at), value(field, drawn + at)];
    let body = |at: usize| BodyPath {
        name: body_name(sites, x, at * spacing),
        number: at * spacing,
        places: fields.iter().map(|field| place(at, field)).collect(),
    };
    Trajectory::Bodies {
        axes: [x, y].map(|family| families[family].0.clone()),
        bodies: (0..drawn).map(body).collect(),
        count,
    }
}

/// The name of a body with coordinates of a family: its own, `q[3]` of components q.x and q.y, `body 3` of families x and y.
fn body_name(sites: &Sites, family: usize, number: usize) -> String {
    let geometry = &sites.geometry;
    match geometry.families[family].0.split_once('.') {
        _ if !geometry.site_names.is_empty() => geometry.site_name(number),
        Some((vector, _)) => format!("{vector}[{number}]"),
        None => format!("body {number}"),
    }
}

/// The paths of the bodies both of whose coordinates in the plane are recorded; `None` of fewer than two.
fn recorded_bodies(sites: &Sites, names: &[String], rows: &[Vec<f64>]) -> Option<Trajectory> {
    let ([x, y], geometry) = (sites.plane?, &sites.geometry);
    let places = names.iter().enumerate();
    let places: HashMap<&str, usize> = places.map(|(at, name)| (name.as_str(), at)).collect();
    let place = |family: usize, number: usize| {
        let (name, site) = (&geometry.families[family].0, geometry.site_name(number));
        places.get(format!("{name}[{site}]").as_str()).copied()
    };
    let bodies = (0..geometry.families[x].1).filter_map(|number| {
        let own = [place(x, number)?, place(y, number)?];
        let path = |row: &Vec<f64>| own.map(|at| value(row, 1 + at));
        Some(BodyPath {
            name: body_name(sites, x, number),
            number,
            places: rows.iter().map(path).collect(),
        })
    });
    let bodies: Vec<BodyPath> = bodies.collect();
    (bodies.len() > 1).then(|| Trajectory::Bodies {
        axes: [x, y].map(|family| geometry.families[family].0.clone()),
        count: bodies.len(),
        bodies,
    })
}

/// The paths of two bodies or more with coordinates such as x0, y0, x1, y1, …, in a plane: there is no z0.
fn single_bodies(names: &[String], rows: &[Vec<f64>]) -> Option<Trajectory> {
    let place = |name: String| names.iter().position(|known| *known == name);
    let own = names.iter().enumerate().filter_map(|(x, name)| {
        let body = name.strip_prefix('x').filter(|body| !body.is_empty())?;
        let is_in_space = place(format!("z{body}")).is_some();
        let y = place(format!("y{body}")).filter(|_| !is_in_space)?;
        Some((body.trim_matches(['_', '[', ']']), [x, y]))
    });
    let own: Vec<_> = own.collect();
    let is_first = own.first().is_some_and(|(_, [x, _])| *x == 0);
    (is_first && own.len() > 1).then(|| Trajectory::Bodies {
        axes: ["x", "y"].map(str::to_owned),
        count: own.len(),
        bodies: (own.into_iter().enumerate())
            .map(|(number, (body, places))| BodyPath {
                name: format!("body {body}"),
                number,
                places: (rows.iter())
                    .map(|row| places.map(|at| value(row, 1 + at)))
                    .collect(),
            })
            .collect(),
    })
}

/// Of several bodies with coordinates such as x0, x1, …, y0, y1, … those of the first: x0 and y0, and z0
/// where there is one.
fn first_body(names: &[String]) -> Option<Vec<usize>> {
    let first = names.first()?;
    let body = first.strip_prefix('x')?;
    let place = |name: String| names.iter().position(|known| *known == name);
    let second = place(format!("y{body}"))?;
    let third = place(format!("z{body}"));
    let is_alone = names.len() <= 3 || body.is_empty();
    (!is_alone).then(|| {
        [Some(0), Some(second), third]
            .into_iter()
            .flatten()
            .collect()
    })
}

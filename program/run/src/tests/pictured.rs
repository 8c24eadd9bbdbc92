//! What reports draw of the states.

use leafwise_report::{ReportData, Trajectory, render_report};

use super::{Prepared, attempt};
use crate::{Asked, MapRequest, Quiet, maps, run_in_memory};

/// Vortices on a circle, each of which turns about the middle: as many as are asked for, without or with neighbours.
fn vortices(count: usize, neighbours: bool, record: &str) -> String {
    let bond = match neighbours {
        true => " + sum(i, 0.01*x[i]*x[i+1])",
        false => "",
    };
    format!(
        r#"
[system]
families    = {{ x = {count}, y = {count} }}
bracket     = {{ "x[i],y[i]" = "1" }}
convention  = "{{x,H}}"
hamiltonian = "sum(i, (x[i]^2 + y[i]^2)/2){bond}"
[method]
stepper   = {{ name = "gauss", stages = 1 }}
time-step = 0.1
[run]
initial = {{ "x[i]" = "cos(2*pi*i/N)", "y[i]" = "sin(2*pi*i/N)" }}
steps   = 20
record  = {{ every = 2{record} }}
"#
    )
}

/// The report of a run in memory.
fn page(text: &str) -> ReportData {
    let Prepared {
        document,
        registry,
        composed,
    } = Prepared::new(text);
    let run = run_in_memory(
        &document,
        &composed,
        &registry,
        Asked::default(),
        &mut Quiet,
    );
    let page = run.expect("a run").page;
    render_report(&page).expect("a page");
    page
}

/// Few bodies have paths of columns, many of snapshots; either begins where the scene puts it.
#[test]
fn bodies_have_paths_in_a_plane() {
    for (count, record) in [(3, ""), (40, ""), (40, ", states = \"all\"")] {
        let page = page(&vortices(count, false, record));
        let Some(Trajectory::Bodies {
            axes,
            bodies,
            count: all,
        }) = &page.trajectory
        else {
            panic!("{count}{record}: {:?}", page.trajectory);
        };
        assert_eq!(
            (axes.join(","), bodies.len(), *all),
            ("x,y".to_owned(), count, count)
        );
        for (number, body) in bodies.iter().enumerate() {
            assert_eq!(
                (body.number, body.name.as_str()),
                (number, &*format!("body {number}"))
            );
            assert_eq!(body.places.len(), 11);
            let turn = std::f64::consts::TAU * number as f64 / count as f64;
            let (sine, cosine) = libm::sincos(turn);
            let [x, y] = body.places[0];
            // The scene's formulas and these round a few times each.
            assert!(
                (x - cosine).abs() < 1e-14 && (y - sine).abs() < 1e-14,
                "{number}"
            );
        }
        assert!(page.structure.is_empty());
    }
}

/// Neighbours make a chain of them, with a structure factor; chosen coordinates are an orbit.
#[test]
fn chains_and_chosen_coordinates_are_no_bodies() {
    let chain = page(&vortices(8, true, ""));
    assert!(matches!(&chain.trajectory, Some(Trajectory::Lattice { name, .. }) if name == "x"));
    let factors: Vec<_> = chain
        .structure
        .iter()
        .map(|factor| (factor.name.as_str(), &factor.lengths[..], factor.states))
        .collect();
    let own = |name| (name, &[8][..], [11, 11]);
    assert_eq!(factors, [own("x"), own("y")]);
    let chosen = page(&vortices(8, false, ", states = [\"x[1]\", \"y[1]\"]"));
    let Some(Trajectory::Orbit { names, .. }) = &chosen.trajectory else {
        panic!("{:?}", chosen.trajectory);
    };
    assert_eq!(names, &["x[1]", "y[1]"]);
}

/// Bodies may be single variables.
#[test]
fn single_variables_are_bodies_by_their_names() {
    let text = r#"
[system]
variables   = ["x1", "y1", "x2", "y2"]
bracket     = { "x1,y1" = "1", "x2,y2" = "1" }
hamiltonian = "ln((x1 - x2)^2 + (y1 - y2)^2)"
[method]
stepper   = { name = "gauss", stages = 1 }
time-step = 0.1
[run]
initial = [1, 2, -1, 0.5]
steps   = 4
"#;
    let page = page(text);
    let Some(Trajectory::Bodies { bodies, .. }) = &page.trajectory else {
        panic!("{:?}", page.trajectory);
    };
    let begin: Vec<_> = bodies
        .iter()
        .map(|body| (body.name.as_str(), body.places[0]))
        .collect();
    assert_eq!(begin, [("body 1", [1.0, 2.0]), ("body 2", [-1.0, 0.5])]);
}

/// A run of a plane in a directory, whose states are in a file, has the maps and the structure factor of one in memory; `maps` reads
/// the same from the directory.
#[test]
fn states_of_a_file_are_drawn_as_those_in_memory() {
    let text = r#"
[system]
families    = { q = [8, 6], p = [8, 6] }
bracket     = "canonical"
hamiltonian = "sum(i, j, p[i,j]^2/2 - cos(q[i+1,j] - q[i,j]) - cos(q[i,j+1] - q[i,j]))"
[method]
stepper   = "splitting"
time-step = 0.1
[run]
initial = { "q[i,j]" = "sin(i + 2*j)", "p[i,j]" = "i" }
steps   = 20
record  = { every = 2, states = "all", observables = ["energy"] }
"#;
    let page = page(text);
    let Some(Trajectory::Planes { fields, .. }) = &page.trajectory else {
        panic!("{:?}", page.trajectory);
    };
    let in_memory = &fields[0].maps;
    let factor = &page.structure[0];
    assert_eq!(factor.lengths, [8, 6]);
    assert_eq!(factor.states, [11, 11]);
    let root = tempfile::tempdir().expect("a directory");
    let path = root.path().join("run");
    attempt(text, &path, false, &mut Quiet).expect("a run");
    assert!(path.join("states.npy").exists());
    let report = std::fs::read_to_string(path.join("report.html")).expect("a page");
    let request = MapRequest {
        field: "q".to_owned(),
        ..MapRequest::default()
    };
    let read = maps(&path, &request).expect("maps");
    assert_eq!(read.maps.len(), 6);
    for (ours, theirs) in read.maps.iter().zip(in_memory) {
        assert_eq!(ours.title, theirs.title);
        assert_eq!(ours.values, theirs.values);
    }
    let heading = |title: &str| format!("<h3>{title}</h3>");
    assert!(report.contains(&heading("Structure factor of q")));
    // The same pictures, to the letter.
    let of_memory = render_report(&page).expect("a page");
    let figures = |page: &str| -> Vec<String> {
        let figures = page.split("<figure>").skip(1);
        let own = figures.filter(|figure| {
            [
                heading("Structure factor of q"),
                heading("q over the lattice"),
            ]
            .iter()
            .any(|heading| figure.contains(heading))
        });
        own.map(|figure| {
            figure
                .split("</figure>")
                .next()
                .unwrap_or_default()
                .to_owned()
        })
        .collect()
    };
    assert_eq!(figures(&report), figures(&of_memory));
    assert_eq!(figures(&report).len(), 2);
}

/// Bodies by names whose momenta are not recorded have paths by their names; one body alone is an orbit.
#[test]
fn recorded_bodies_have_paths_by_their_names() {
    let names = ["Sun", "Earth", "Moon"];
    let scene = |states: &str| {
        vortices(3, false, &format!(", states = [{states}]"))
            .replace("x = 3", "x = [\"Sun\", \"Earth\", \"Moon\"]")
    };
    let whole = page(&scene("\"y\", \"x\""));
    let Some(Trajectory::Bodies { axes, bodies, .. }) = &whole.trajectory else {
        panic!("{:?}", whole.trajectory);
    };
    assert_eq!(axes, &["x", "y"]);
    assert_eq!(bodies.len(), 3);
    for (number, (body, name)) in bodies.iter().zip(names).enumerate() {
        assert_eq!((body.name.as_str(), body.number), (name, number));
        let angle = std::f64::consts::TAU * number as f64 / 3.0;
        let [x, y] = body.places[0];
        // Cosine and sine of angles rounded twice.
        assert!((x - libm::cos(angle)).abs() <= 4.0 * f64::EPSILON);
        assert!((y - libm::sin(angle)).abs() <= 4.0 * f64::EPSILON);
    }
    let two = page(&scene("\"x\", \"y[Earth..N]\""));
    let Some(Trajectory::Bodies { bodies, .. }) = &two.trajectory else {
        panic!("{:?}", two.trajectory);
    };
    let found: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(found, ["Earth", "Moon"]);
    let one = page(&scene("\"x[Moon]\", \"y[Moon]\""));
    let Some(Trajectory::Orbit { names, .. }) = &one.trajectory else {
        panic!("{:?}", one.trajectory);
    };
    assert_eq!(names, &["x[Moon]", "y[Moon]"]);
}

/// Both sublattices of a honeycomb have maps and a structure factor in the report, and each is a field of `maps`.
#[test]
fn every_family_of_a_cell_has_its_pictures() {
    let text = r#"
[system]
families    = { a = { components = ["x", "y", "z"], length = [4, 5] }, b = { components = ["x", "y", "z"], length = [4, 5] } }
bracket     = { lie-algebra = "so3" }
hamiltonian = "-sum(i, j, dot(a[i,j], b[i,j] + b[i-1,j] + b[i,j-1]))"
[method]
stepper   = "splitting"
time-step = 0.1
[run]
steps  = 4
record = { states = "all" }
[run.initial]
"a.x[i,j]" = "0.1*i"
"a.y[i,j]" = "0.1*j"
"a.z[i,j]" = 1
"b.x[i,j]" = "0.2*j"
"b.y[i,j]" = "-0.1*i"
"b.z[i,j]" = "0.01*(10*i + j)"
"#;
    let root = tempfile::tempdir().expect("a directory");
    let path = root.path().join("run");
    attempt(text, &path, false, &mut Quiet).expect("a run");
    let report = std::fs::read_to_string(path.join("report.html")).expect("a page");
    for name in ["a", "b"] {
        for heading in [
            format!("{name} over the lattice"),
            format!("Structure factor of {name}"),
        ] {
            assert!(report.contains(&format!("<h3>{heading}</h3>")), "{heading}");
        }
        let request = MapRequest {
            field: name.to_owned(),
            at: vec![0.0],
            slice: None,
        };
        let drawn = maps(&path, &request).expect("maps");
        assert_eq!(drawn.color, format!("{name}.z"));
        // i runs across, j up; decimals of the scene and these round once or twice each.
        for (at, value) in drawn.maps[0].values.iter().enumerate() {
            let (i, j) = ((at % 4) as f64, (at / 4) as f64);
            let expected = if name == "a" {
                1.0
            } else {
                0.01 * (10.0 * i + j)
            };
            assert!((value - expected).abs() < 1e-15, "{name} {i} {j}: {value}");
        }
    }
}

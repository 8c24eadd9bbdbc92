//! Recorded states: chosen coordinates, slices, tables of doubles; and how they are told of.

use serde_json::json;

use crate::support::{BODY, Place};

/// A chain of 1000 sites.
const CHAIN: &str = r#"[system]
families    = { q = 1000, p = 1000 }
bracket     = { "q[i],p[i]" = "-1" }
boundary    = "periodic"
hamiltonian = "sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2)"
[method]
stepper   = "splitting"
time-step = 0.1
[run]
initial = { "q[i]" = "exp(-((i-500)/10)^2)", "p[i]" = "0" }
steps   = 20
record  = { every = 3 }
"#;

fn chain(record: &str) -> Place {
    Place::with(&CHAIN.replace("every = 3", &format!("every = 3, {record}")))
}

/// Header and rows of `states.npy`, read as NumPy does.
fn table(bytes: &[u8]) -> (usize, usize, Vec<f64>) {
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!((10 + length) % 64, 0);
    let header = std::str::from_utf8(&bytes[10..10 + length]).expect("ASCII");
    assert!(
        header.contains("'descr': '<f8', 'fortran_order': False"),
        "{header}"
    );
    let (_, shape) = header.split_once("'shape': (").expect("a shape");
    let shape: Vec<usize> = shape
        .split([',', ')'])
        .filter_map(|number| number.trim().parse().ok())
        .collect();
    let values = bytes[10 + length..].chunks_exact(8);
    let values = values.map(|b| f64::from_le_bytes(b.try_into().expect("eight")));
    (shape[0], shape[1], values.collect())
}

fn run(here: &Place) -> String {
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.err
}

#[test]
fn chosen_coordinates_are_columns() {
    let here = chain(
        "observables = [\"energy\", \"q[503]\", { work = \"sum(i, p[i]^2)\" }], states = [\"q[500]\", \"p[0..3]\", \
         \"q[::400]\"]",
    );
    run(&here);
    let samples = here.read("runs/scene/samples.csv");
    let header = samples.lines().next().expect("a header");
    assert_eq!(
        header,
        "t,q[500],p[0],p[1],p[2],q[0],q[400],q[800],energy,q[503],work"
    );
    let first: Vec<f64> = samples
        .lines()
        .nth(1)
        .expect("a row")
        .split(',')
        .map(|cell| cell.parse().expect("a number"))
        .collect();
    assert_eq!(first[1], 1.0);
    assert!((first[9] - libm::exp(-0.09)).abs() < 1e-15, "{first:?}");
    let manifest: serde_json::Value =
        serde_json::from_str(&here.read("runs/scene/manifest.json")).expect("JSON");
    let states = &manifest["states"];
    assert_eq!(
        (&states["file"], &states["last"]),
        (&json!("samples.csv"), &json!("final_state.bin"))
    );
    // Every third of 20 steps, the first and the last.
    assert_eq!(states["shape"], json!([8, 7]));
    assert_eq!(states["columns"][1], "p[0]");
    assert_eq!(
        states["slices"][2],
        json!({ "name": "q", "first": 0, "step": 400, "count": 3 })
    );
    // The last row is the last state.
    let bytes = std::fs::read(here.path("runs/scene/final_state.bin")).expect("the last state");
    let last: Vec<f64> = bytes
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().expect("eight")))
        .collect();
    assert_eq!(last.len(), 2000);
    let row = samples.lines().last().expect("a row");
    let cells: Vec<&str> = row.split(',').collect();
    for (cell, place) in [(1, 500), (2, 1000), (6, 400), (9, 503)] {
        assert_eq!(cells[cell], format!("{:?}", last[place]));
    }
}

/// A figure finds coordinates in the table of states; of one that was not recorded it says how, in words that work.
#[test]
fn coordinates_of_wide_states_are_drawn() {
    let here = chain("states = [\"q\"]");
    run(&here);
    let plot = |run: &str| {
        let arguments = ["plot", run, "--x", "q[500]", "--y", "p[3]", "--json"];
        here.leafwise(&[&arguments[..], &["--force"]].concat())
    };
    let said = here.leafwise(&[
        "plot",
        "runs/scene",
        "--x",
        "q[500]",
        "--y",
        "q[510]",
        "--json",
    ]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    // Every third of 20 steps, the first and the last.
    assert_eq!(said.json()["curves"][0]["points"], 8);
    let said = plot("runs/scene");
    assert_eq!(said.code, Some(2), "{}", said.err);
    said.says(&[
        "the coordinate `p[3]` was not recorded",
        "record = { states = [\"p[3]\"] }",
    ]);
    let cure = "run.record={ states = [\"q\", \"p[3]\"] }";
    let again = here.leafwise(&["run", "scene.toml", "--set", cure, "--out", "again"]);
    assert_eq!(again.code, Some(0), "{}", again.err);
    assert_eq!(plot("again").code, Some(0));
}

#[test]
fn wide_states_are_a_table_of_doubles() {
    let here = chain("states = \"all\"");
    let err = run(&here);
    assert!(
        err.contains("2 000 coordinates at every record, in states.npy"),
        "{err}"
    );
    let bytes = std::fs::read(here.path("runs/scene/states.npy")).expect("a table");
    let (rows, columns, values) = table(&bytes);
    assert_eq!((rows, columns, values.len()), (8, 2000, 16_000));
    assert_eq!(values[500], 1.0);
    let last = std::fs::read(here.path("runs/scene/final_state.bin")).expect("the last state");
    assert!(bytes.ends_with(&last));
    // A selection has the same numbers, and rows of samples.csv belong to those of the table.
    let part = chain("states = [\"p\", \"q[0:1000:2]\"]");
    run(&part);
    let bytes = std::fs::read(part.path("runs/scene/states.npy")).expect("a table");
    let (rows, columns, some) = table(&bytes);
    assert_eq!((rows, columns), (8, 1500));
    for row in 0..8 {
        assert_eq!(some[row * 1500 + 7], values[row * 2000 + 1007]);
        assert_eq!(some[row * 1500 + 1251], values[row * 2000 + 502]);
    }
    assert_eq!(here.read("runs/scene/samples.csv").lines().count(), 9);
}

#[test]
fn states_that_are_not_recorded_are_reported() {
    let here = Place::with(CHAIN);
    let err = run(&here);
    for piece in [
        "2 000 coordinates",
        "final_state.bin",
        "states = [\"q[0]\", \"q[::100]\"]",
    ] {
        assert!(err.contains(piece), "{piece}\n{err}");
    }
    // Who asks for none is not told of it.
    let err = run(&chain("states = []"));
    assert!(!err.contains("final_state.bin"), "{err}");
    // A small system keeps its state whole, or what is chosen of it.
    let here = Place::with_body("every = 3,", "every = 3, states = [\"x3\"],");
    run(&here);
    let samples = here.read("runs/scene/samples.csv");
    assert!(samples.starts_with("t,x3,energy,spin\n"), "{samples}");
    assert!(here.path("runs/scene/final_state.bin").exists());
    let report = here.read("runs/scene/report.html");
    assert!(
        report.contains("x3 at the recorded states"),
        "the chosen one is drawn"
    );
}

#[test]
fn coordinates_that_are_not_there_are_refused_without_the_template() {
    for (record, pieces) in [
        (
            "states = [\"q[1000]\"]",
            &["`q` has the sites 0 to 999"][..],
        ),
        (
            "states = [\"q[5..3]\"]",
            &["`q` has the sites 0 to 999", "q[0..1000] is all of it"],
        ),
        (
            "states = [\"q[x]\"]",
            &["`q[x]` is not a part of `q`", "q[::100]"],
        ),
        (
            "states = [\"r\"]",
            &["the state has no coordinates `r`", "q, p"],
        ),
        ("states = [\"q\", \"q[3]\"]", &["`q[3]` is recorded twice"]),
        (
            "observables = [\"q[5000]\"]",
            &["`q` has the members q[0] to q[999], not q[5000]"],
        ),
        (
            "observables = [\"q[5000]^2\"]",
            &["`q` has the members q[0] to q[999], not q[5000]"],
        ),
        (
            "observables = [\"sum(i, q[i]*q[0])\"]",
            &["q[0]", "write single sites outside of the sum"],
        ),
    ] {
        let said = chain(record).leafwise(&["check", "scene.toml"]);
        assert_eq!(said.code, Some(3), "{record}: {}", said.err);
        said.says(pieces);
        assert!(!said.err.contains("q[8]"), "{record}: {}", said.err);
    }
    let said = Place::with_body("every = 3,", "every = 3, states = [\"x1[0]\"],")
        .leafwise(&["check", "scene.toml"]);
    said.says(&["`x1` is a single variable"]);
}

/// Interrupted wherever it may be, a run leaves the same table.
#[test]
fn an_interrupted_table_of_states_resumes_to_the_same_bits() {
    let long = CHAIN
        .replace("steps   = 20", "steps   = 3000")
        .replace("every = 3", "every = 1, states = [\"q[::10]\"]");
    let whole = Place::with(&long);
    run(&whole);
    let expected = std::fs::read(whole.path("runs/scene/states.npy")).expect("a table");
    let here = Place::with(&long);
    let arguments = ["run", "scene.toml", "--quiet", "--checkpoint-every", "0.02"];
    let mut child = here
        .command(&arguments)
        .spawn()
        .expect("the program starts");
    let is_begun =
        || std::fs::metadata(here.path("runs/scene/states.npy")).is_ok_and(|f| f.len() > 50_000);
    crate::support::wait_for(&mut child, is_begun, "the first states");
    // It may have ended by itself.
    let _ = child.kill();
    let _ = child.wait();
    let bytes = std::fs::read(here.path("runs/scene/states.npy")).expect("a table");
    let (rows, columns, values) = table(&bytes);
    assert!(
        values.len() >= rows * columns,
        "the header counts no more than is there"
    );
    let whole_rows = bytes.len() - (bytes.len() - 128) % (8 * columns);
    assert!(
        expected[128..].starts_with(&bytes[128..whole_rows]),
        "a prefix"
    );
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(std::fs::read(here.path("runs/scene/states.npy")).expect("a table") == expected);
}

#[test]
fn the_manifest_says_what_was_run_and_agrees_with_the_printed_object() {
    let here = Place::with(BODY);
    let printed = here.leafwise(&["run", "scene.toml", "--json"]).json();
    let manifest: serde_json::Value =
        serde_json::from_str(&here.read("runs/scene/manifest.json")).expect("JSON");
    assert_eq!(manifest["variables"], json!(["x1", "x2", "x3"]));
    assert_eq!(
        manifest["parameters"],
        json!({ "I1": 1.0, "I2": 0.75, "I3": 1.25 })
    );
    assert_eq!(manifest["initial"], json!([1.0, 3.0, 3.0]));
    for key in ["drift", "invariants"] {
        assert!(
            manifest[key].is_object() && manifest[key] == printed[key],
            "{key}"
        );
    }
    assert_eq!(manifest["invariants"]["spin"]["initial"], 19.0);
    assert_eq!(manifest["states"]["columns"], json!(["x1", "x2", "x3"]));
    assert_eq!(manifest["states"]["last"], json!(null));
}

/// What fits on a long lattice is what can be swept, and is not what was refused.
#[test]
fn the_help_on_a_long_lattice_names_what_works_there() {
    let method = "realization = \"karasev-collocated\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }";
    let here = Place::with(&CHAIN.replace("stepper   = \"splitting\"", method));
    let said = here.leafwise(&["check", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    let (_, help) = said
        .err
        .split_once("these can be swept over a long lattice: ")
        .expect("a help");
    let names: Vec<&str> = help.lines().next().expect("a line").split(", ").collect();
    assert!(
        !names.is_empty() && !names.contains(&"karasev-collocated"),
        "{names:?}"
    );
    for name in names {
        let set = format!("method.realization={name}");
        let said = here.leafwise(&["check", "scene.toml", "--set", &set]);
        assert_eq!(said.code, Some(0), "{name}: {}", said.err);
    }
}

/// Kepler's problem with vectors, and the same in components.
const VECTORS: &str = r#"[system]
variables = { r = 3, p = 3 }
bracket = "canonical"
define = { A = "cross(p, L) - r/norm(r)", L = "cross(r, p)" }
hamiltonian = "dot(p, p)/2 - 1/norm(r) + 0.01*L.z"
forces = { p = "-0.1*p" }
[method]
stepper = "dop853"
time-step = 0.05
[run]
initial = { r = [1, 0, "0.1"], p = [0, 1.1, 0.2] }
steps = 20
record = { states = ["p", "r.x"], observables = ["energy", "L", { lenz = "A" }, "2*r", "norm(A)"] }
"#;
const WRITTEN: &str = r#"[system]
variables = ["x", "y", "z", "u", "v", "w"]
bracket = { "x,u" = "-1", "y,v" = "-1", "z,w" = "-1" }
define = { a = "y*w - z*v", b = "z*u - x*w", c = "x*v - y*u", n = "sqrt(x*x + y*y + z*z)" }
hamiltonian = "(u*u + v*v + w*w)/2 - 1/n + 0.01*c"
forces = ["0", "0", "0", "-0.1*u", "-0.1*v", "-0.1*w"]
[method]
stepper = "dop853"
time-step = 0.05
[run]
initial = [1, 0, 0.1, 0, 1.1, 0.2]
steps = 20
record = { states = ["u", "v", "w", "x"], observables = ["energy", "a", "b", "c", "v*c - w*b - x/n", "w*a - u*c - y/n", "u*b - v*a - z/n", "2*x", "2*y", "2*z", "sqrt((v*c - w*b - x/n)*(v*c - w*b - x/n) + (w*a - u*c - y/n)*(w*a - u*c - y/n) + (u*b - v*a - z/n)*(u*b - v*a - z/n))"] }
"#;

#[test]
fn vectors_stand_in_initial_states_definitions_forces_and_records() {
    let here = Place::with(VECTORS);
    here.write("written.toml", WRITTEN);
    let table = |scene: &str| -> (String, Vec<f64>) {
        let said = here.leafwise(&["run", scene, "--out", "out", "--force"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let samples = here.read("out/samples.csv");
        let (headings, rows) = samples.split_once('\n').expect("headings");
        let numbers = rows.split([',', '\n']).filter(|text| !text.is_empty());
        let numbers = numbers.map(|text| text.parse().expect("a number"));
        (headings.to_owned(), numbers.collect())
    };
    let ((headings, found), (_, expected)) = (table("scene.toml"), table("written.toml"));
    assert_eq!(
        headings,
        "t,p.x,p.y,p.z,r.x,energy,L.x,L.y,L.z,lenz.x,lenz.y,lenz.z,2*r.x,2*r.y,2*r.z,norm(A)"
    );
    assert_eq!((found.len(), expected.len()), (21 * 16, 21 * 16));
    // Sums in another order round otherwise, some dozen roundings a step.
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}

#[test]
fn vectors_that_do_not_fit_are_refused() {
    for (from, to, message) in [
        ("[0, 1.1, 0.2]", "[0, 1.1]", "2 entries"),
        ("cross(r, p)", "cross(r, q)", "`q` is no vector"),
        ("cross(p, L)", "cross(p, M)", "`M` is no vector"),
        ("cross(p, L)", "cross(p, A)", "is no vector"),
        ("{ p = \"-0.1*p\" }", "{ p = \"-0.1\" }", "`p`"),
        (
            "[\"p\", \"r.x\"]",
            "[\"p\", \"p.x\"]",
            "`p.x` is recorded twice",
        ),
        (
            "[\"p\", \"r.x\"]",
            "[\"L\"]",
            "the state has no coordinates `L`",
        ),
        ("\"2*r\"", "\"2 + r\"", "vector"),
        (
            "L = \"cross(r, p)\"",
            "L = \"cross(r, p)\", energy = \"2*r\"",
            "a vector has a name of its own",
        ),
        (
            "p = 3 }",
            "p = [\"x\", \"z\", \"y\"] }",
            "in the order x, y, z",
        ),
    ] {
        let here = Place::with(&VECTORS.replace(from, to));
        let said = here.leafwise(&["check", "scene.toml"]);
        assert_eq!(said.code, Some(3), "{to}: {}", said.err);
        said.says(&[message]);
    }
}

/// A vector that is recorded by its name has the names of its own components.
#[test]
fn a_vector_by_its_name_keeps_its_letters() {
    let scene = VECTORS.replace("p = 3 }", "p = [\"u\", \"v\", \"w\"] }");
    let scene = scene.replace("L.z", "p.w").replace("\"2*r\"", "\"p\"");
    let pairs = "{ \"r.x,p.u\" = -1, \"r.y,p.v\" = -1, \"r.z,p.w\" = -1 }";
    let scene = scene.replace("\"canonical\"", pairs);
    let scene = scene.replace("states = [\"p\", \"r.x\"]", "states = [\"r\"]");
    let here = Place::with(&scene);
    let said = here.leafwise(&["run", "scene.toml", "--out", "out"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let samples = here.read("out/samples.csv");
    let headings = samples.lines().next().expect("headings");
    assert!(
        headings.ends_with("lenz.z,p.u,p.v,p.w,norm(A)"),
        "{headings}"
    );
}

//! Tables of numbers as functions: their files, and what is said of wrong ones.

use std::fs;

use crate::support::Place;

/// A pendulum whose potential is a table of 16 nodes a period.
const PENDULUM: &str = r#"[system]
variables   = ["q", "p"]
bracket     = { "q,p" = 1 }
convention  = "{x,H}"
hamiltonian = "p^2/2 + V(q)"
tables      = { V = { file = "v.csv", column = "V", axes = { q = ["-pi", "pi"] }, periodic = ["q"] } }
[method]
realization = "auto"
dynamics    = { name = "hamilton-jacobi", order = 4 }
time-step   = 0.1
[run]
initial = [1, 0.5]
steps   = 20
record  = { observables = ["energy", "D(V(q), q)", "V(q, 1)"] }
"#;

fn potential() -> Vec<f64> {
    let angle = |i: i32| f64::from(i) * std::f64::consts::PI / 8.0;
    (-8..8).map(|i| -libm::cos(angle(i))).collect()
}

fn csv(values: &[f64]) -> String {
    let rows = values.iter().enumerate();
    let rows = rows.map(|(at, value)| format!("{at},{value:?}\n"));
    format!("i,V\n{}", rows.collect::<String>())
}

/// As `numpy.save` writes doubles.
fn npy(shape: &str, values: &[f64]) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// From a column, an array and the scene itself a table has the same bits; `D` is the derivative by orders.
#[test]
fn numbers_from_each_place_are_one_table() {
    let values = potential();
    let sources = [
        "file = \"v.csv\", column = \"V\"".to_owned(),
        "file = \"v.npy\"".to_owned(),
        format!("values = {values:?}"),
    ];
    let samples = sources.map(|source| {
        let here = Place::with(&PENDULUM.replace("file = \"v.csv\", column = \"V\"", &source));
        here.write("v.csv", &csv(&values));
        fs::write(here.path("v.npy"), npy("(16,)", &values)).expect("a file");
        let said = here.leafwise(&["run", "scene.toml"]);
        assert_eq!(said.code, Some(0), "{source}: {}", said.err);
        here.read("runs/scene/samples.csv")
    });
    assert_eq!(samples[0], samples[1]);
    assert_eq!(samples[0], samples[2]);
    let last = samples[0].lines().last().expect("rows");
    let cells: Vec<&str> = last.split(',').collect();
    assert_eq!(cells[4], cells[5], "{last}");
    let number = |at: usize| cells[at].parse::<f64>().expect("a number");
    // sin q, as near as 16 nodes of degree 5 are.
    assert!((number(4) - libm::sin(number(1))).abs() < 1e-4, "{last}");
}

/// A potential in the plane by values, with coordinates in its first row and column, and as a list: one motion, to the bit.
#[test]
fn a_grid_with_coordinates_and_a_list_are_the_grid_of_values() {
    let scene = r#"[system]
variables   = ["x", "y", "px", "py"]
bracket     = "canonical"
hamiltonian = "(px^2 + py^2)/2 + V(x, y)"
tables      = { V = { file = "v.csv", axes = { x = [-1, 1], y = [0, 3] } } }
[method]
stepper     = "splitting"
time-step   = 0.05
[run]
initial = [0.1, 1.2, 0.3, 0.2]
steps   = 20
"#;
    let axis = |first: f64, last: f64, nodes: u32| -> Vec<f64> {
        let at = |k: u32| first + (last - first) * f64::from(k) / f64::from(nodes - 1);
        (0..nodes).map(at).collect()
    };
    let (x, y) = (axis(-1.0, 1.0, 9), axis(0.0, 3.0, 7));
    let value = |x: f64, y: f64| x * x + 0.5 * (y - 1.0) * (y - 1.0) + 0.2 * x * y;
    let joined = |cells: Vec<f64>| {
        let cells: Vec<String> = cells.iter().map(|cell| format!("{cell:?}")).collect();
        cells.join(",")
    };
    let row = |x: f64| joined(y.iter().map(|y| value(x, *y)).collect());
    let bare: Vec<String> = x.iter().map(|x| row(*x)).collect();
    let rows: Vec<String> = x.iter().map(|x| format!("{x:?},{}", row(*x))).collect();
    let within = |corner: &str| format!("{corner},{}\n{}\n", joined(y.clone()), rows.join("\n"));
    let list = x.iter().flat_map(|x| {
        y.iter()
            .map(move |y| format!("{x:?},{y:?},{:?}\n", value(*x, *y)))
    });
    let list = format!("x,y,V\n{}", list.collect::<String>());
    let run = |text: &str| {
        let here = Place::with(scene);
        here.write("v.csv", text);
        let said = here.leafwise(&["run", "scene.toml"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        here.read("runs/scene/samples.csv")
    };
    let expected = run(&format!("{}\n", bare.join("\n")));
    for text in [within("0"), within("x\\y"), within(""), list.clone()] {
        assert_eq!(run(&text), expected, "{text}");
    }
    // Of other axes each is refused, and what is said serves.
    let other = scene.replace("x = [-1, 1]", "x = [-2, 2]");
    for (text, said) in [
        (
            within("0"),
            "look like coordinates, and not those of `axes`, x: -2, -1.5, -1, … 2",
        ),
        (list, "which is not a node"),
    ] {
        let here = Place::with(&other);
        here.write("v.csv", &text);
        let refused = here.leafwise(&["run", "scene.toml"]);
        assert_eq!(refused.code, Some(3), "{}", refused.err);
        assert!(refused.err.contains(said), "{}", refused.err);
    }
}

#[test]
fn a_run_is_not_continued_with_other_numbers() {
    let here = Place::with(PENDULUM);
    here.write("v.csv", &csv(&potential()));
    let run = |steps: &str| here.leafwise(&["run", "scene.toml", "--set", steps]);
    assert_eq!(run("run.steps=20").code, Some(0));
    assert_eq!(run("run.steps=30").code, Some(0));
    let mut other = potential();
    other[3] += 1e-6;
    here.write("v.csv", &csv(&other));
    let said = run("run.steps=40");
    assert_eq!(said.code, Some(2), "{}", said.err);
    said.says(&["other numbers in v.csv", "--force"]);
}

/// Each with its place in the scene.
#[test]
fn wrong_tables_are_refused_where_they_stand() {
    let table = "{ file = \"v.csv\", column = \"V\", axes = { q = [\"-pi\", \"pi\"] }, periodic = [\"q\"] }";
    let here = |scene: &str| {
        let here = Place::with(scene);
        here.write("v.csv", &csv(&potential()));
        fs::write(here.path("plane.npy"), npy("(4, 4)", &potential())).expect("a file");
        let mut broken = potential();
        broken[5] = f64::NAN;
        fs::write(here.path("nan.npy"), npy("(16,)", &broken)).expect("a file");
        here
    };
    let axis = "axes = { q = [-3, 3] }";
    for (tables, said) in [
        (
            "{ V = { axes = { q = [-3, 3] } } }".to_owned(),
            "the table `V` has no numbers",
        ),
        (
            format!("{{ V = {{ file = \"no.csv\", {axis} }} }}"),
            "cannot read",
        ),
        (
            format!("{{ V = {{ file = \"v.csv\", {axis} }} }}"),
            "choose one by column",
        ),
        (
            format!("{{ V = {{ file = \"plane.npy\", {axis} }} }}"),
            "have the shape [4, 4], and the table has 1 axis",
        ),
        (
            format!("{{ V = {{ file = \"nan.npy\", {axis} }} }}"),
            "node [5], counted from 0, is NaN",
        ),
        (
            "{ V = { file = \"v.csv\", axes = { q = [3, -3] } } }".to_owned(),
            "the first below the last",
        ),
        (
            format!(
                "{{ V = {{ values = {:?}, axes = {{ q = [\"-pi\", \"pi\"] }}, periodic = [\"q\"] }} }}",
                (0..=16)
                    .map(|k| libm::cos(std::f64::consts::TAU * f64::from(k % 16) / 16.0))
                    .collect::<Vec<f64>>()
            ),
            "leave it out, and take 16 nodes",
        ),
        (
            "{ V = { file = \"v.csv\", axes = { q = [3] } } }".to_owned(),
            "the first and the last node",
        ),
        ("{ V = { file = \"v.csv\" } }".to_owned(), "needs `axes`"),
        (
            format!("{{ V = {{ file = \"v.csv\", {axis}, degree = 12 }} }}"),
            "at most 9",
        ),
        (
            format!("{{ V = {{ file = \"v.csv\", {axis}, periodic = [\"r\"] }} }}"),
            "unknown axis of this table `r`",
        ),
        (
            format!("{{ V = {{ file = \"v.csv\", {axis}, spline = 3 }} }}"),
            "unknown key `spline`",
        ),
        (
            format!("{{ V = {{ values = [1, 2, 3], {axis} }} }}"),
            "takes 6 at least: take more, or degree = 1",
        ),
        (
            format!("{{ V = {{ values = [[1, 2], [3]], {axis} }} }}"),
            "the rows before it",
        ),
        (
            format!("{{ V = {{ values = [1, 2], file = \"v.csv\", {axis} }} }}"),
            "keep one of them",
        ),
        (
            format!("{{ V = {table}, q = {table} }}"),
            "`q` is declared twice",
        ),
        (
            format!("{{ V = {table}, gamma = {table} }}"),
            "`gamma` is reserved",
        ),
    ] {
        let scene = PENDULUM.replace(&format!("{{ V = {table} }}"), &tables);
        assert_ne!(scene, PENDULUM);
        let told = here(&scene).leafwise(&["check", "scene.toml"]);
        assert_eq!(told.code, Some(3), "{tables}: {}", told.err);
        told.says(&[said, "scene.toml:"]);
    }
    for (call, said) in [
        (
            "V(q, p, 1)",
            "`V` is a table of 1 variable, and 3 arguments stand here: write `V(q)`",
        ),
        ("V(q, 0.5)", "the orders of a derivative, whole numbers"),
        ("V*q", "`V` is a table: write its arguments after it"),
        ("W(q)", "unknown function `W`"),
    ] {
        let told = here(&PENDULUM.replace("p^2/2 + V(q)", call)).leafwise(&["check", "scene.toml"]);
        assert_eq!(told.code, Some(3), "{call}: {}", told.err);
        told.says(&[said, "scene.toml:5"]);
    }
}

/// Outside, a run fails by name; a member that comes to the wall inside is lost, not failed.
#[test]
fn members_are_lost_at_a_wall_inside_the_table() {
    let scene = PENDULUM
        .replace(", periodic = [\"q\"]", "")
        .replace("\"-pi\", \"pi\"", "-3, 1.5")
        .replace("steps   = 20", "steps   = 200");
    let ensemble = "[ensemble]\nmembers = 20\ninitial = { ball = 0.3 }\nfinal-states = \"csv\"\n";
    let outcomes = |text: &str| {
        let here = Place::with(&format!("{text}{ensemble}"));
        here.write("v.csv", &csv(&potential()));
        let said = here.leafwise(&["ensemble", "scene.toml"]);
        let states = here.read("runs/scene-ensemble/final_states.csv");
        let count = |word: &str| states.lines().filter(|line| line.contains(word)).count();
        (said, [count("failed"), count("stopped")])
    };
    let (said, [failed, stopped]) = outcomes(&scene);
    assert!(failed > 0 && stopped == 0, "{}", said.err);
    let walled = scene.replace("steps   = 200", "steps   = 200\nstop = \"q > 1.49\"");
    let (said, [still, lost]) = outcomes(&walled);
    // Some turn round between the wall and the end of the table.
    assert!(still == 0 && lost >= failed, "{}", said.err);
}

/// A cubic table under a method of order 6 is warned of; the change that is named cures it.
#[test]
fn a_degree_that_costs_the_order_is_warned_of() {
    let with = |degree: &str| {
        let scene = PENDULUM.replace("periodic =", &format!("{degree}periodic ="));
        let here = Place::with(&scene.replace("order = 4", "order = 6"));
        here.write("v.csv", &csv(&potential()));
        here.leafwise(&["run", "scene.toml"]).err
    };
    let told = with("degree = 3, ");
    assert!(
        told.contains("they reduce the method's order 6 to 3"),
        "{told}"
    );
    assert!(told.contains("degree = 6 in [system.tables]"), "{told}");
    assert!(!with("degree = 6, ").contains("they reduce"));
}

/// Orders hold for smooth formulas: what a table of degree 2 or a seam takes from them breaks no declaration.
#[test]
fn rough_formulas_break_no_declaration() {
    let table = PENDULUM.replace("periodic", "degree = 2, periodic");
    let seam = PENDULUM.replace("V(q)\"\ntables", "if(q > 0.9, 30*(q - 0.9)^2, 0)\"\n#");
    let seam = seam.replace(", \"D(V(q), q)\", \"V(q, 1)\"", "");
    for scene in [table, seam] {
        let here = Place::with(&scene);
        here.write("v.csv", &csv(&potential()));
        let said = here.leafwise(&["verify", "scene.toml", "--json"]);
        assert_eq!(said.code, Some(0), "{}\n{}", said.err, said.out);
        let json = said.json();
        let rows = json["rows"].as_array().expect("rows");
        let undecided = rows
            .iter()
            .filter(|row| row["measured"]["judgements"]["order"] == "undecided");
        assert!(undecided.count() >= 5, "{json}");
        assert!(
            rows.iter()
                .all(|row| row["declared"]["smooth_order"].is_number())
        );
        let said = here.leafwise(&["verify", "scene.toml"]);
        assert!(said.out.contains("seams or tables"), "{}", said.out);
    }
}

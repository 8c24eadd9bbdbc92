//! Figures of runs: `leafwise plot`.

use crate::support::Place;

const BALL: &str = r#"
[system]
variables   = ["q", "p"]
bracket     = "canonical"
hamiltonian = "p^2/2 + q"
[method]
stepper   = "splitting"
time-step = 0.05
[run]
initial = [1, 0]
steps   = 200
section = { at = "q = 0", direction = "down", set = { p = "-0.9*p" } }
"#;

#[test]
fn runs_become_a_figure() {
    let here = Place::new();
    here.write("ball.toml", BALL);
    for (name, start) in [("low", "0.5"), ("high", "1")] {
        let start = format!("run.initial.q={start}");
        let start = [
            "--set",
            "run.initial={ q = 1, p = 0 }",
            "--set",
            start.as_str(),
        ];
        let run = ["run", "ball.toml", "--out", name];
        let said = here.leafwise(&[&run[..], &start[..]].concat());
        assert_eq!(said.code, Some(0), "{}", said.err);
        said.says(&["each sets p = -0.9*p", "not a Poisson map"]);
    }
    let both = [
        "plot",
        "low",
        "high",
        "--y",
        "q",
        "--y-label",
        "height (mm)",
        "--y-scale",
        "1000",
    ];
    let said = here.leafwise(&[&both[..], &["--json"]].concat());
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    assert_eq!(json["curves"][1]["name"], "high");
    assert_eq!(json["curves"][1]["points"], 201);
    let svg = here.read("plot.svg");
    for part in ["height (mm)", "low", "high", "800"] {
        assert!(svg.contains(part), "{part}");
    }
    let section = [
        "plot",
        "high",
        "--table",
        "section.csv",
        "--y",
        "p",
        "--points",
    ];
    let said = here.leafwise(&[&section[..], &["--out", "p.pdf"]].concat());
    assert_eq!(said.code, Some(0), "{}", said.err);
    let pdf = std::fs::read(here.path("p.pdf")).expect("a file");
    assert!(pdf.starts_with(b"%PDF-"));
    for (arguments, told) in [
        (
            &["plot", "low", "--y", "Q"][..],
            "plot.svg exists and is left as it is",
        ),
        (
            &["plot", "low", "--y", "Q", "--force"],
            "it has no column `Q`",
        ),
        (
            &["plot", "low", "--y", "q", "--out", "a.png"],
            "neither .svg nor .pdf",
        ),
        (&["plot", "none", "--y", "q", "--out", "a.svg"], "none"),
        (
            &[
                "plot", "low", "--y", "q", "--log", "y", "--angle", "y", "--out", "a.svg",
            ],
            "--angle y",
        ),
        (
            &[
                "plot", "low", "--y", "q", "--log", "y", "--equal", "--out", "a.svg",
            ],
            "--equal has no meaning",
        ),
        (
            &[
                "plot",
                "low",
                "--y",
                "q",
                "--y-label",
                "漢",
                "--out",
                "a.pdf",
            ],
            "the fonts of PDF have no",
        ),
    ] {
        let said = here.leafwise(arguments);
        assert_ne!(said.code, Some(0), "{arguments:?}");
        said.says(&[told]);
        assert!(!here.path("a.svg").exists() && !here.path("a.pdf").exists());
    }
}

/// Values without a place, rows of other lengths, names that are alike, files without names.
#[test]
fn what_is_not_drawn_is_told() {
    let here = Place::new();
    here.write("all.csv", "t,y,z,n\n0,-1,1,nan\n1,0,-2,nan\n2,-3,3,nan\n");
    here.write("ragged.csv", "t,y\n0,1\n1\n2,3\n");
    here.write("bare.csv", "0,1\n1,2\n");
    for (arguments, told) in [
        (
            &["all.csv", "--y", "y", "--log", "y"][..],
            "no point of y is shown",
        ),
        (&["all.csv", "--y", "n"], "no point of n is shown"),
        (&["ragged.csv", "--y", "y"], "row 2 has 1 numbers"),
        (&["bare.csv", "--y", "y"], "it has no header line"),
        (
            &["all.csv", "--y", "y", "--y-label", "漢", "--out", "a.pdf"],
            "the fonts of PDF have no",
        ),
    ] {
        let said = here.leafwise(&[&["plot"][..], arguments].concat());
        assert_eq!(said.code, Some(2), "{arguments:?}: {}", said.err);
        said.says(&[told]);
        assert!(!here.path("plot.svg").exists(), "{arguments:?}");
    }
    let said = here.leafwise(&["plot", "all.csv", "--y", "z", "--log", "y", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["1 of 3 points of z are left out"]);
    assert_eq!(said.json()["curves"][0]["left_out"], 1);
    for folder in ["A/out", "B/out"] {
        std::fs::create_dir_all(here.path(folder)).expect("a folder");
        here.write(&format!("{folder}/samples.csv"), "t,q\n0,1\n1,2\n");
    }
    let said = here.leafwise(&["plot", "A/out", "B/out", "--y", "q", "--force", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    let names: Vec<_> = (0..2)
        .map(|at| json["curves"][at]["name"].clone())
        .collect();
    assert_eq!(names, ["A/out", "B/out"]);
}

const ROTORS: &str = r#"
[system]
families    = { q = [6, 4], p = [6, 4] }
bracket     = "canonical"
hamiltonian = "sum(i, j, p[i,j]^2/2 - cos(q[i+1,j] - q[i,j]) - cos(q[i,j+1] - q[i,j]))"
[method]
stepper   = "splitting"
time-step = 0.1
[run]
initial = { "q[i,j]" = "i + 10*j", "p[i,j]" = 0 }
steps   = 20
"#;

/// A field over a lattice becomes maps at the recorded times nearest to those asked for; what there is none of is told.
#[test]
fn fields_become_maps() {
    let here = Place::new();
    here.write("rotors.toml", ROTORS);
    let run = here.leafwise(&["run", "rotors.toml", "--out", "all"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let said = here.leafwise(&["plot", "all", "--map", "q", "--at", "0,1.04", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let maps = said.json()["maps"].clone();
    assert_eq!(maps[0], "q at t = 0");
    assert_eq!(maps[1], "q at t = 1");
    let svg = here.read("plot.svg");
    assert!(
        svg.contains("q at t = 1") && svg.contains("crispEdges"),
        "{svg}"
    );
    let said = here.leafwise(&["plot", "all", "--map", "p", "--out", "p.pdf"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(
        std::fs::read(here.path("p.pdf"))
            .expect("a file")
            .starts_with(b"%PDF-")
    );
    for (arguments, told) in [
        (&["all", "--map", "Q"][..], "did you mean `q`?"),
        (
            &["all", "--map", "q", "--at", "3"],
            "outside of the recorded times, 0 to 2",
        ),
        (
            &["all", "--map", "q", "--slice", "k=1"],
            "a plane has no slices",
        ),
        (
            &["all", "--map", "q", "--slice", "k"],
            "is no axis with a site",
        ),
        (
            &["all", "all", "--map", "q"],
            "--map draws one run, and 2 are given",
        ),
        (&["none", "--map", "q"], "none holds no run"),
        (
            &["all", "--map", "q", "--y", "q[0,0]"],
            "cannot be used with",
        ),
        (&["all", "--y", "q[0,0]", "--at", "1"], "--map"),
    ] {
        let said = here.leafwise(&[&["plot"][..], arguments, &["--out", "a.svg"]].concat());
        assert_eq!(said.code, Some(2), "{arguments:?}: {}", said.err);
        said.says(&[told]);
        assert!(!here.path("a.svg").exists(), "{arguments:?}");
    }
}

/// Columns along the horizontal axis go with those of the vertical one, in their order.
#[test]
fn curves_have_columns_of_their_own_across() {
    let here = Place::new();
    here.write(
        "two.csv",
        "t,x0,y0,x1,y1\n0,1,0,5,0\n1,2,1,5,nan\n2,3,4,inf,5\n",
    );
    let pairs = ["--x", "x0", "--y", "y0", "--x", "x1", "--y", "y1"];
    let said = here.leafwise(&[&["plot", "two.csv", "--json"][..], &pairs].concat());
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    assert_eq!(json["curves"][0]["left_out"], 0);
    assert_eq!(json["curves"][1]["left_out"], 2);
    let said = here.leafwise(&[&["plot", "two.csv", "--y", "t", "--force"][..], &pairs].concat());
    assert_eq!(said.code, Some(2), "{}", said.err);
    said.says(&["2 columns --x are given for 3 columns --y"]);
}

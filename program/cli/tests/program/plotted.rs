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
        said.says(&["each sets p = -0.9*p", "no Poisson map"]);
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

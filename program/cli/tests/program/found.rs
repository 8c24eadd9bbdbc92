//! Brackets of equations, on the command line and in scenes.

use super::support::Place;

/// A rigid body as equations, DETEST's problem B5.
const BODY: &str = "[system]\nequations = { x = \"y*z\", y = \"-x*z\", z = \"-0.51*x*y\" }\nbracket = \"find\"\n\n[method]\nrealization = \"auto\"\n\
                    dynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.1\n\n[run]\ninitial = [0, 1, 1]\nsteps = 100\n";

/// The scene that is written moves as the equations do, to the bit as the scene that says `find`.
#[test]
fn a_scene_of_equations_is_the_scene_that_is_written() {
    let here = Place::with(BODY);
    let said = here.leafwise(&["find", "scene.toml", "--out", "found.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(said.out.contains("{x, y}     = z\n"), "{}", said.out);
    let text = here.read("found.toml");
    assert!(
        !text.contains("equations") && text.contains("hamiltonian = \"x^2/2 + y^2/2\""),
        "{text}"
    );
    for scene in ["scene.toml", "found.toml"] {
        let said = here.leafwise(&["check", scene]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        for line in [
            "Jacobi identity  proved",
            "x'  = y*z",
            "y'  = -x*z",
            "z'  = -0.51*x*y",
        ] {
            assert!(said.out.contains(line), "{line}: {}", said.out);
        }
    }
    let table = |scene: &str, out: &str| {
        let said = here.leafwise(&["run", scene, "--out", out, "--quiet"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        here.read(&format!("{out}/samples.csv"))
    };
    assert_eq!(table("scene.toml", "a"), table("found.toml", "b"));
    // A file that exists stays.
    let said = here.leafwise(&["find", "scene.toml", "--out", "found.toml"]);
    assert_eq!(said.code, Some(2), "{}", said.err);
    assert_eq!(here.read("found.toml"), text);
}

#[test]
fn equations_of_the_command_line_become_a_scene_that_runs() {
    let here = Place::new();
    let pendulum = [
        "find",
        "-e",
        "q' = p",
        "-e",
        "p' = -k*sin(q)",
        "-p",
        "k=0.5",
        "--out",
        "p.toml",
    ];
    let said = here.leafwise(&pendulum);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(
        said.out.contains("{q, p}  = 1\n") && said.out.contains("p^2/2 - k*cos(q)"),
        "{}",
        said.out
    );
    let said = here.leafwise(&["run", "p.toml", "--set", "run.steps=5", "--quiet"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
}

/// Damping: exit code 5, with the certificate; `run` refuses the scene where it says `find`.
#[test]
fn a_damped_pendulum_has_no_bracket() {
    let here = Place::with(
        &BODY
            .replace("-0.51*x*y", "-0.51*x*y - z")
            .replace("y*z\"", "y*z - x\"")
            .replace("-x*z\"", "-x*z - y\""),
    );
    let said = here.leafwise(&["find", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(5), "{}", said.err);
    let report = said.json();
    assert_eq!(report["outcome"], "none");
    let never = report["never"].as_str().expect("a reason");
    assert!(never.contains("asymptotically stable"), "{never}");
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    assert!(said.err.contains("asymptotically stable"), "{}", said.err);
}

#[test]
fn the_casimirs_of_a_bracket_are_printed_and_written() {
    let text = "[system]\nvariables = [\"x\", \"y\", \"z\"]\nparameters = { a = 2.0 }\nbracket = { \"x,y\" = \"-a*z\", \"y,z\" = \"-x\", \"z,x\" = \"-y\" }\n\
                hamiltonian = \"x^2 + 2*y^2\"\n[method]\nrealization = \"auto\"\ndynamics = \"auto\"\ntime-step = 0.1\n[run]\ninitial = [1, 2, 3]\nsteps = 2\n";
    let here = Place::with(text);
    let said = here.leafwise(&["find", "scene.toml", "--out", "with.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let said = here.leafwise(&["check", "with.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(said.out.contains("Casimir C        proved"), "{}", said.out);
}

#[test]
fn equations_that_cannot_be_read_are_underlined() {
    for (from, to, expected) in [
        ("y*z\"", "y*sn(z)\"", "unknown function `sn`"),
        ("\"find\"", "\"fnd\"", "did you mean `find`?"),
        ("equations", "equation", "did you mean `equations`?"),
        (
            "bracket = \"find\"",
            "bracket = \"find\"\nhamiltonian = \"x\"",
            "cannot be combined with `equations`",
        ),
        (
            "x = \"y*z\"",
            "x = \"1/(y - y)\"",
            "division by an expression that is identically zero",
        ),
        ("x = ", "sin = ", "`sin` cannot name a variable"),
    ] {
        let here = Place::with(&BODY.replacen(from, to, 1));
        let said = here.leafwise(&["check", "scene.toml"]);
        assert_eq!(said.code, Some(3), "{to}: {}", said.err);
        assert!(said.err.contains(expected), "{to}: {}", said.err);
    }
    let here = Place::new();
    let said = here.leafwise(&["find", "-e", "q'"]);
    assert_eq!(said.code, Some(2), "{}", said.err);
}

/// A bracket of three or more variables with `casimirs = "find"`.
fn with_casimirs_to_find(variables: &str, bracket: &str, initial: &str) -> String {
    format!(
        "[system]\nvariables = [{variables}]\nparameters = {{ a = 2 }}\nbracket = {{ {bracket} }}\nhamiltonian = \"x^2/2 + 2*y^2/3\"\ncasimirs = \"find\"\n\n\
         [method]\nrealization = \"auto\"\ndynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\ntime-step = 0.05\n\n\
         [run]\ninitial = {initial}\nsteps = 40\n"
    )
}

/// Casimirs stand in the place of the word: recorded by their names, kept to round-off, proved by `check`; a variable C takes its name from them.
#[test]
fn casimirs_of_a_scene_are_found() {
    let spins = "\"x,y\" = \"-z\", \"y,z\" = \"-x\", \"z,x\" = \"-y\"";
    let four = "\"x,y\" = \"x*y\", \"y,z\" = \"a*y*z\", \"z,w\" = \"z*w\"";
    // Of (x, y, z, w) with neighbours alone the tensor has full rank; with three species ln z + a ln x is a Casimir.
    let three = "\"x,y\" = \"x*y\", \"y,z\" = \"a*y*z\"";
    for (variables, bracket, initial, name) in [
        ("\"x\", \"y\", \"z\"", spins, "[0.3, 0.9, 0.4]", "C"),
        ("\"x\", \"y\", \"z\"", three, "[1, 1.1, 1.2]", "C"),
        (
            "\"x\", \"y\", \"C\"",
            &spins.replace('z', "C"),
            "[0.3, 0.9, 0.4]",
            "K",
        ),
    ] {
        let text = with_casimirs_to_find(variables, bracket, initial);
        let here = Place::with(&format!(
            "{text}record = {{ observables = [\"energy\", \"{name}\"] }}\n"
        ));
        let said = here.leafwise(&["run", "scene.toml", "--out", "out", "--quiet"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let samples = here.read("out/samples.csv");
        let at = samples
            .lines()
            .next()
            .and_then(|names| names.split(',').position(|own| own == name));
        let values: Vec<f64> = (samples.lines().skip(1))
            .map(|row| {
                row.split(',')
                    .nth(at.expect(name))
                    .expect(name)
                    .parse()
                    .expect("a number")
            })
            .collect();
        assert_eq!(values.len(), 41);
        assert!(
            values.iter().all(|c| (c - values[0]).abs() < 1e-13),
            "{values:?}"
        );
        let said = here.leafwise(&["check", "scene.toml"]);
        assert_eq!(said.code, Some(0), "{}{}", said.out, said.err);
        let said = here.leafwise(&["find", "scene.toml"]);
        assert!(
            said.out.contains(&format!("Casimir {name}")),
            "{}",
            said.out
        );
    }
    let full = with_casimirs_to_find("\"x\", \"y\", \"z\", \"w\"", four, "[1, 1, 1, 1]");
    // x³ + y³ + z³ has the degree 3.
    let cubic = "\"x,y\" = \"z^2\", \"y,z\" = \"x^2\", \"z,x\" = \"y^2\"";
    let cubic = with_casimirs_to_find("\"x\", \"y\", \"z\"", cubic, "[0.3, 0.9, 0.4]");
    let wrong = full.replace("a*y*z", "b*y*z");
    for (text, expected) in [
        (&full, "full rank"),
        (&cubic, "none has degree 2 or less"),
        (&wrong, "`b`"),
        (
            &full.replace("casimirs = \"find\"", "casimirs = \"seek\""),
            "\"find\"",
        ),
    ] {
        let here = Place::with(text);
        let said = here.leafwise(&["run", "scene.toml", "--quiet"]);
        assert_eq!(said.code, Some(3), "{expected}: {}{}", said.out, said.err);
        assert!(said.err.contains(expected), "{expected}: {}", said.err);
    }
    let here = Place::with(&cubic.replace("casimirs = \"find\"\n", ""));
    let said = here.leafwise(&["find", "scene.toml", "--degree", "3"]);
    assert!(said.out.contains("x^3"), "{}", said.out);
}

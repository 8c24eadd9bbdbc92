//! What a scene's motion is: `check` and `run --explain` print ẋ, and a sign that turns time round is reported.

use crate::support::{BODY, Place};

const PENDULUM: &str = r#"[system]
variables   = ["q", "p"]
parameters  = { g = 9.81 }
bracket     = { "q,p" = "-1" }
hamiltonian = "p^2/2 - g*cos(q)"
[method]
stepper   = "splitting"
time-step = 0.01
[run]
initial = [1, 0]
steps   = 10
"#;

const CHARGE: &str = r#"[system]
variables   = ["x", "y", "z", "vx", "vy", "vz"]
bracket     = { magnetic-field = ["0", "0", "1 + 0.1*x"] }
convention  = "{H,x}"
hamiltonian = "(vx^2 + vy^2 + vz^2)/2"
[method]
stepper   = "dop853"
time-step = 0.1
[run]
initial = [0, 0, 0, 1, 0, 0]
steps   = 1
"#;

#[test]
fn check_prints_the_motion_of_every_variable() {
    let here = Place::with(BODY);
    let said = here.leafwise(&["check", "scene.toml"]);
    let lines: Vec<&str> = said.out.lines().map(str::trim).collect();
    let expected = [
        "Motion, x' = {H, x}:",
        "x1'  = (1/I2 - 1/I3)*x2*x3",
        "x2'  = (-1/I1 + 1/I3)*x1*x3",
        "x3'  = (1/I1 - 1/I2)*x1*x2",
        "(x1, x2, x3) turns as a spin, s' = s × (-∂H/∂s); by the other convention as a body, m' = m × ω with ω = ∂H/∂m",
    ];
    assert!(lines.ends_with(&expected), "{}", said.out);
    let json = here.leafwise(&["check", "scene.toml", "--json"]).json();
    assert_eq!(json["motion"]["x1"], "(1/I2 - 1/I3)*x2*x3");
    let said = here.leafwise(&["run", "scene.toml", "--explain"]);
    said.says(&expected);
}

/// q' = ∂H/∂p and p' = −∂H/∂q under either convention, for names, families, vectors, summands and pairs written out.
#[test]
fn canonical_pairs_move_by_hamiltons_equations() {
    let many = |letter: &str| {
        format!(
            "{{ components = [\"x\", \"y\"], length = [2, 3] }}, {letter} = {{ components = [\"x\", \"y\"], length = [2, 3] }}"
        )
    };
    let by_word = "bracket = \"canonical\"";
    let at_rest = |variables: &str, count: usize| {
        format!("variables = {variables}\nINITIAL = {:?}", vec![0.5; count])
    };
    let cases = [
        (
            at_rest("[\"p\", \"q\"]", 2),
            by_word,
            "p^2/2 + q^4",
            ["q", "p"],
            ["p", "-4*q^3"],
        ),
        (
            at_rest("[\"x\", \"px\", \"y\", \"py\"]", 4),
            by_word,
            "px*py + x*y",
            ["y", "py"],
            ["px", "-x"],
        ),
        (
            at_rest("[\"r\", \"theta\", \"pr\", \"L\"]", 4),
            by_word,
            "pr^2/2 + L*theta",
            ["theta", "L"],
            ["theta", "-L"],
        ),
        (
            at_rest("[\"θ\", \"J\"]", 2),
            by_word,
            "J^2/2 + θ",
            ["θ", "J"],
            ["J", "-1"],
        ),
        (
            at_rest("[\"x\", \"v\"]", 2),
            "bracket = { canonical = [[\"x\", \"v\"]] }",
            "v^2/2 + x",
            ["x", "v"],
            ["v", "-1"],
        ),
        (
            at_rest("[\"q\", \"m1\", \"m2\", \"m3\", \"p\"]", 5),
            "bracket = { sum = [{ variables = [\"q\", \"p\"], bracket = \"canonical\" }, { variables = [\"m1\", \"m2\", \"m3\"], bracket = { lie-algebra = \"so3\" } }] }",
            "p^2/2 + q*m1",
            ["q", "p"],
            ["p", "-m1"],
        ),
        (
            "families = { q = 4, p = 4 }\nINITIAL = { \"q[i]\" = 1, \"p[i]\" = 2 }".to_owned(),
            by_word,
            "sum(i, p[i]^2/2 + q[i])",
            ["q[2]", "p[2]"],
            ["p[2]", "-1"],
        ),
        (
            format!(
                "families = {{ r = {} }}\nINITIAL = {{ \"r.x[i,j]\" = 1, \"r.y[i,j]\" = 2, \"p.x[i,j]\" = 1, \"p.y[i,j]\" = 2 }}",
                many("p")
            ),
            by_word,
            "sum(i, j, p.y[i,j]*p.x[i,j] + r.y[i,j])",
            ["r.x[1,2]", "p.y[1,2]"],
            ["p.y[1,2]", "-1"],
        ),
    ];
    for (declared, bracket, hamiltonian, names, motion) in cases {
        let (system, initial) = declared.split_once("INITIAL = ").expect("both");
        for convention in ["{H,x}", "{x,H}"] {
            let here = Place::with(&format!(
                "[system]\n{system}{bracket}\nconvention = \"{convention}\"\nhamiltonian = \"{hamiltonian}\"\n[method]\nstepper = \"gauss\"\n\
                 time-step = 0.1\n[run]\nsteps = 1\ninitial = {initial}\n"
            ));
            let said = here.leafwise(&["check", "scene.toml", "--json"]);
            assert_eq!(said.code, Some(0), "{}", said.err);
            let json = said.json();
            for (name, expected) in names.into_iter().zip(motion) {
                assert_eq!(json["motion"][name], expected, "{system}{convention}");
            }
        }
    }
}

/// A variable without a partner, or with two, is named; the way out that the message shows is taken.
#[test]
fn pairs_that_names_do_not_tell_are_asked_for() {
    for (variables, bracket, said) in [
        (
            "[\"x\", \"v\"]",
            "\"canonical\"",
            "no variable is the momentum or the coordinate of `x`",
        ),
        (
            "[\"q\", \"p\", \"z\"]",
            "\"canonical\"",
            "no variable is the momentum or the coordinate of `z`",
        ),
        (
            "[\"theta\", \"phi\", \"L\"]",
            "\"canonical\"",
            "`L` may be paired with `theta` or `phi`",
        ),
        (
            "[\"q\", \"p\"]",
            "\"kanonical\"",
            "did you mean `canonical`?",
        ),
        (
            "[\"q\", \"p\"]",
            "{ canonical = [[\"q\", \"P\"]] }",
            "unknown variable `P`",
        ),
        ("[\"q\", \"p\"]", "{ canonical = [[\"q\"]] }", "has 1 names"),
        (
            "[\"q\", \"p\", \"z\"]",
            "{ canonical = [[\"q\", \"p\"], [\"q\", \"z\"]] }",
            "`q` is declared twice",
        ),
        (
            "[\"q\", \"p\"]",
            "{ canonical = [[\"q\", \"q\"]] }",
            "two variables",
        ),
    ] {
        let here = Place::with(&format!(
            "[system]\nvariables = {variables}\nbracket = {bracket}\nhamiltonian = \"1\"\n[method]\nstepper = \"gauss\"\ntime-step = 0.1\n\
             [run]\nsteps = 1\ninitial = [1, 1]\n"
        ));
        let refused = here.leafwise(&["check", "scene.toml"]);
        assert_eq!(refused.code, Some(3), "{}", refused.err);
        refused.says(&[said]);
    }
}

#[test]
fn the_motion_of_a_lattice_is_that_of_a_site() {
    let chain = "[system]\nfamilies = { q = 400, p = 400 }\n\
                 bracket = { \"q[i],p[i]\" = \"-1\" }\nboundary = \"periodic\"\n\
                 hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2)\"\n[method]\n\
                 realization = \"auto\"\ndynamics = \"auto\"\ntime-step = 0.1\n[run]\nsteps = 1\n\
                 initial = { \"q[i]\" = \"sin(2*pi*i/N)\", \"p[i]\" = \"0\" }\n";
    let here = Place::with(chain);
    let json = here.leafwise(&["check", "scene.toml", "--json"]).json();
    let motion = json["motion"].as_object().expect("an object");
    assert_eq!(motion.keys().collect::<Vec<_>>(), ["q[i]", "p[i]"]);
    assert_eq!(motion["q[i]"], "p[i]");
    assert_eq!(motion["p[i]"], "q[i-1] - 2*q[i] + q[i+1]");
}

/// x'' = v × B: after one step of 0.1 the charge is where a Taylor series of its motion puts it.
#[test]
fn a_charge_turns_as_physics_has_it_under_both_conventions() {
    for convention in ["{H,x}", "{x,H}"] {
        let here = Place::with(&CHARGE.replace("{H,x}", convention));
        let json = here.leafwise(&["run", "scene.toml", "--json"]).json();
        let state: Vec<f64> = json["final_state"]
            .as_array()
            .expect("a list")
            .iter()
            .filter_map(serde_json::Value::as_f64)
            .collect();
        // vx' = vy (1 + x/10), vy' = −vx (1 + x/10) from v = (1, 0, 0): x = t − t³/6 + O(t⁴),
        // y = −t²/2 − t³/60 + O(t⁴), vx = 1 − t²/2 − O(t³), vy = −t − t²/20 + O(t³).
        let t = 0.1;
        let expected = [t - t * t * t / 6.0, -t * t / 2.0 - t * t * t / 60.0];
        for (value, expected) in state.iter().zip(expected) {
            assert!(
                (value - expected).abs() < t * t * t * t,
                "{convention}: {state:?}"
            );
        }
        assert!(
            (state[4] + t + t * t / 20.0).abs() < t * t * t,
            "{convention}: {state:?}"
        );
        let said = here.leafwise(&["check", "scene.toml"]);
        for line in ["x'   = vx", "vx'  = vy + 0.1*vy*x", "vy'  = -vx - 0.1*vx*x"] {
            let found = said.out.lines().any(|other| same_terms(other, line));
            assert!(found, "{line}\n{}", said.out);
        }
    }
}

/// Whether two lines have the same factors and terms, in any order.
fn same_terms(a: &str, b: &str) -> bool {
    let sorted = |line: &str| {
        let mut letters: Vec<char> = line.chars().filter(|c| !c.is_whitespace()).collect();
        letters.sort_unstable();
        letters
    };
    a.split('=').next().map(str::trim) == b.split('=').next().map(str::trim)
        && sorted(a) == sorted(b)
}

#[test]
fn the_old_key_is_refused_with_the_new_one_and_its_force() {
    let here = Place::with(&CHARGE.replace("magnetic-field", "magnetic"));
    let said = here.leafwise(&["check", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&[
        "`magnetic` is now `magnetic-field`",
        "v' = v × B",
        "v' = -v × B",
        "negate B",
    ]);
}

#[test]
fn hamiltons_equations_that_run_backwards_are_reported() {
    let here = Place::with(PENDULUM);
    let said = here.leafwise(&["check", "scene.toml"]);
    assert!(said.out.contains("q'  = p"), "{}", said.out);
    assert!(!said.err.contains("warning"), "{}", said.err);
    for (bracket, convention, other) in [("1", "{H,x}", "{x,H}"), ("-1", "{x,H}", "{H,x}")] {
        let scene = PENDULUM.replace(
            "\"q,p\" = \"-1\" }",
            &format!("\"q,p\" = \"{bracket}\" }}\nconvention = \"{convention}\""),
        );
        let here = Place::with(&scene);
        let said = here.leafwise(&["check", "scene.toml"]);
        assert!(said.out.contains("q'  = -p"), "{}", said.out);
        let change = format!("convention = \"{other}\"");
        said.says(&["backwards in time", &change]);
        let said = here.leafwise(&["run", "scene.toml"]);
        said.says(&["backwards in time", &change]);
        // The change is the cure.
        let cured = Place::with(&scene.replace(convention, other));
        let said = cured.leafwise(&["check", "scene.toml"]);
        assert!(!said.err.contains("backwards"), "{}", said.err);
    }
}

/// Oscillators whose Hamiltonian is a square of the position alone: names and canonical pairs are Hamilton's, whatever H looks like.
#[test]
fn a_square_of_the_position_makes_no_momentum_of_it() {
    let of = |variables: &str, bracket: &str, energy: &str| {
        format!(
            "[system]\nvariables = {variables}\nbracket = {bracket}\nhamiltonian = \"{energy}\"\n[method]\nstepper = \"implicit-midpoint\"\n\
             time-step = 0.1\n[run]\ninitial = [0.4, 0.3]\nsteps = 5\n"
        )
    };
    for (variables, bracket, energy) in [
        ("[\"q\", \"p\"]", "\"canonical\"", "sqrt(1 + p^2) + q^2/2"),
        (
            "[\"a\", \"b\"]",
            "{ canonical = [[\"a\", \"b\"]] }",
            "sqrt(1 + b^2) + a^2/2",
        ),
        (
            "[\"q\", \"p\"]",
            "{ \"q,p\" = -1 }",
            "sqrt(1 + p^2) + q^2/2",
        ),
        ("[\"x\", \"v\"]", "{ \"x,v\" = -1 }", "v^4/4 + x^2/2"),
        (
            "[\"q\", \"p\"]",
            "{ one-form = [\"p\", \"0\"] }",
            "sqrt(1 + p^2) + q^2/2",
        ),
    ] {
        let here = Place::with(&of(variables, bracket, energy));
        let said = here.leafwise(&["check", "scene.toml"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        assert!(!said.err.contains("backwards"), "{bracket}: {}", said.err);
        let (q, p) = (&variables[2..3], &variables[7..8]);
        assert!(
            said.out.contains(&format!("{p}'  = -{q}")),
            "{bracket}: {}",
            said.out
        );
    }
}

const TORQUE: &str = r#"[system]
library = "attitude"
torque = ["0.1", "0", "0.3*cos(t)"]
[method]
realization = "auto"
dynamics = "one-form"
time-step = 0.01
[run]
steps = 200
initial = [1.0, 1.5, -0.7, 0.8, 0.0, 0.6, 0.0]
[run.record]
observables = [
    { space1 = "(q0^2 + q1^2 - q2^2 - q3^2)*m1 + 2*(q1*q2 - q0*q3)*m2 + 2*(q1*q3 + q0*q2)*m3" },
    { space2 = "2*(q1*q2 + q0*q3)*m1 + (q0^2 - q1^2 + q2^2 - q3^2)*m2 + 2*(q2*q3 - q0*q1)*m3" },
    { space3 = "2*(q1*q3 - q0*q2)*m1 + 2*(q2*q3 + q0*q1)*m2 + (q0^2 - q1^2 - q2^2 + q3^2)*m3" },
]
"#;

/// In the body m' gains the components, and q' stays. In space the angular momentum q m q⁻¹ is L(0) + τ t: the method has it to
/// round-off of 200 steps, since η is a constant times a symmetry's.
#[test]
fn a_torque_changes_the_momentum_in_its_frame() {
    let here = Place::with(TORQUE);
    let of_scene = || here.leafwise(&["check", "scene.toml", "--json"]).json()["motion"].clone();
    let motion = of_scene();
    let torque = "torque = [\"0.1\", \"0\", \"0.3*cos(t)\"]\n";
    let free = TORQUE.replace(torque, "");
    here.write("scene.toml", &free.replace("dynamics = \"one-form\"\n", ""));
    let free = of_scene();
    for name in ["q0", "q1", "q2", "q3", "m2"] {
        assert!(
            free[name].is_string() && motion[name] == free[name],
            "{name}"
        );
    }
    assert_eq!(motion["m1"], "0.1 + (-1/I2 + 1/I3)*m2*m3");
    assert_eq!(motion["m3"], "(-1/I1 + 1/I2)*m1*m2 + 0.3*cos(t)");
    let space = "torque = { space = [0.1, \"-0.2\", 0.05] }\n";
    here.write("scene.toml", &TORQUE.replace(torque, space));
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let samples = here.read("runs/scene/samples.csv");
    let numbers = |row: &str| -> Vec<f64> {
        row.split(',')
            .map(|cell| cell.parse().expect("a number"))
            .collect()
    };
    let rows: Vec<Vec<f64>> = samples.lines().skip(1).map(numbers).collect();
    assert_eq!(rows.len(), 201);
    let start = &rows[0];
    for row in &rows {
        for (column, torque) in (row.len() - 3..).zip([0.1, -0.2, 0.05]) {
            let expected = start[column] + torque * row[0];
            assert!((row[column] - expected).abs() < 1e-13, "{row:?}");
        }
    }
}

/// A satellite on a circular orbit, which turns about its third axis, is a pendulum: with ψ the angle between its first axis and
/// the planet, ψ'²/2 − (3/4) n² (I2 − I1)/I3 cos 2ψ keeps its value, to the orders of the methods.
#[test]
fn a_gravity_gradient_by_definitions_is_a_pendulum() {
    let scene = |method: &str, step: f64| {
        format!(
            r#"[system]
library    = "attitude"
parameters = {{ n = 0.8, I1 = 0.5 }}
[system.define]
c  = "cos(n*t)"
s  = "sin(n*t)"
u1 = "(q0^2 + q1^2 - q2^2 - q3^2)*c + 2*(q1*q2 + q0*q3)*s"
u2 = "2*(q1*q2 - q0*q3)*c + (q0^2 - q1^2 + q2^2 - q3^2)*s"
u3 = "2*(q1*q3 + q0*q2)*c + 2*(q2*q3 - q0*q1)*s"
[system.torque]
body = ["3*n^2*(I3 - I2)*u2*u3", "3*n^2*(I1 - I3)*u3*u1", "3*n^2*(I2 - I1)*u1*u2"]
[method]
realization = "auto"
{method}
time-step = {step}
[run]
initial = [0, 0, 0.5, 0.8, 0, 0, 0.6]
steps = {}
[run.record]
observables = [
    {{ balance = "(m3/I3 - n)^2/2 - 3/4*n^2*(I2 - I1)/I3*(u1^2 - u2^2)" }},
    {{ kinetic = "(m3/I3 - n)^2/2" }},
]
"#,
            (8.0 / step).round()
        )
    };
    let error = |method: &str, step: f64| -> f64 {
        let here = Place::with(&scene(method, step));
        let said = here.leafwise(&["run", "scene.toml"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let samples = here.read("runs/scene/samples.csv");
        let column = |back: usize| -> Vec<f64> {
            let rows = samples.lines().skip(1);
            let cell = |row: &str| {
                row.rsplit(',')
                    .nth(back)
                    .expect("a cell")
                    .parse()
                    .expect("a number")
            };
            rows.map(cell).collect()
        };
        let (balance, kinetic) = (column(1), column(0));
        let spread = |values: &[f64]| {
            let sizes = values.iter().map(|value| (value - values[0]).abs());
            sizes.fold(0.0, f64::max)
        };
        // The kinetic part alone does not keep its value.
        assert!(spread(&kinetic) > 1e-3);
        spread(&balance)
    };
    for (method, order) in [("", 2.0), ("composition = \"suzuki-4\"", 4.0)] {
        let (long, short) = (error(method, 0.2), error(method, 0.1));
        let slope = libm::log2(long / short);
        assert!((slope - order).abs() < 0.3, "{method}: {long:e} {short:e}");
        assert!(long < 5e-3, "{method}: {long:e}");
    }
}

/// Definitions beside a library system have names of their own.
#[test]
fn a_definition_beside_a_library_system_takes_no_name_of_it() {
    for (name, said) in [
        ("I1", "declared twice"),
        ("m1", "declared twice"),
        ("c", ""),
    ] {
        let scene = TORQUE.replace(
            "[method]",
            &format!("define = {{ {name} = \"2*m2\" }}\n[method]"),
        );
        let checked = Place::with(&scene).leafwise(&["check", "scene.toml"]);
        assert_eq!(
            checked.code,
            Some(if said.is_empty() { 0 } else { 3 }),
            "{}",
            checked.err
        );
        assert!(checked.err.contains(said), "{}", checked.err);
    }
}

/// Brackets of others, a quaternion of length 0, and vectors of other lengths.
#[test]
fn a_torque_without_an_attitude_is_refused() {
    for (from, to, said) in [
        (
            "library = \"attitude\"",
            "library = \"rigid-body\"",
            "library = \"attitude\"",
        ),
        (
            "0.8, 0.0, 0.6, 0.0",
            "0, 0, 0, 0",
            "a torque needs the bracket of an attitude",
        ),
        (
            "[\"0.1\", \"0\", \"0.3*cos(t)\"]",
            "{ space = [1, 2] }",
            "space has 2 components",
        ),
        (
            "[\"0.1\", \"0\", \"0.3*cos(t)\"]",
            "{}",
            "torque needs `body`",
        ),
    ] {
        assert!(TORQUE.contains(from));
        let scene = TORQUE.replace(from, to);
        let scene = match to.contains("rigid") {
            true => scene
                .split("[run.record]")
                .next()
                .expect("a scene")
                .replace("0.8, 0.0, 0.6, 0.0", "")
                .replace("-0.7, ", "-0.7"),
            false => scene,
        };
        let here = Place::with(&scene);
        let refused = here.leafwise(&["run", "scene.toml"]);
        assert_eq!(refused.code, Some(3), "{to}: {}", refused.err);
        refused.says(&[said]);
    }
    // The coordinates' names alone are not enough.
    let other = "[system]\nvariables = [\"m1\", \"m2\", \"m3\", \"q0\", \"q1\", \"q2\", \"q3\"]\nbracket = { \"m1,q1\" = 1 }\n\
                 hamiltonian = \"m1^2\"\ntorque = [0, 0, 1]\n[method]\ntime-step = 0.1\n[run]\nsteps = 1\ninitial = [1, 1, 1, 1, 0, 0, 0]\n";
    let refused = Place::with(other).leafwise(&["run", "scene.toml"]);
    assert_eq!(refused.code, Some(3), "{}", refused.err);
    refused.says(&["a torque needs the bracket of an attitude"]);
}

/// A scene by vectors has the bits of one by components.
#[test]
fn vectors_have_the_bits_of_their_components() {
    let method = "[method]\nstepper = \"splitting\"\ntime-step = 0.05\n[run]\nsteps = 20\n";
    let kepler = [
        "variables = { r = 3, p = 3 }\nbracket = \"canonical\"\nhamiltonian = \"dot(p, p)/2 - 1/norm(r)\"\n",
        "variables = { r = 3, p = 3 }\nbracket = \"canonical\"\n\
         hamiltonian = \"(p.x*p.x + p.y*p.y + p.z*p.z)/2 - 1/sqrt(r.x*r.x + r.y*r.y + r.z*r.z)\"\n",
    ];
    let spins = |hamiltonian: &str| {
        format!(
            "families = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = 40 }} }}\nbracket = {{ lie-algebra = \"so3\" }}\n\
             hamiltonian = \"-sum(i, {hamiltonian})\"\n"
        )
    };
    let spins = [
        spins("dot(s[i], s[i+1])"),
        spins("s.x[i]*s.x[i+1] + s.y[i]*s.y[i+1] + s.z[i]*s.z[i+1]"),
    ];
    let of_spins = "initial = { \"s.x[i]\" = \"0.6*cos(i)\", \"s.y[i]\" = \"0.6*sin(i)\", \"s.z[i]\" = 0.8 }\n";
    let kepler = kepler.map(str::to_owned);
    for (systems, initial) in [
        (kepler, "initial = [1, 0, 0, 0, 1, 0.2]\n"),
        (spins, of_spins),
    ] {
        let ends = systems.map(|system| {
            let here = Place::with(&format!("[system]\n{system}{method}{initial}"));
            let said = here.leafwise(&["run", "scene.toml", "--json"]);
            assert_eq!(said.code, Some(0), "{}", said.err);
            said.json()["final_state"].clone()
        });
        assert_eq!(ends[0], ends[1]);
        assert!(ends[0].as_array().is_some_and(|state| state.len() >= 6));
    }
}

//! Inputs that newcomers type without thinking, each with the message that it ought to have.

use crate::support::{Place, Said};

/// An input, the exit code, and what the program says.
type Case<'a> = (&'a str, i32, &'a [&'a str]);

const DONE: i32 = 0;
const REFUSED: i32 = 3;

/// A method over a realization.
const PAIR: &str = "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }";

/// An oscillator with this Hamiltonian, method and end.
fn oscillator(hamiltonian: &str, method: &str, end: &str) -> String {
    format!(
        "[system]\nvariables = [\"q\", \"p\"]\nparameters = {{ k = 1 }}\nbracket = {{ \"q,p\" = 1 }}\nconvention = \"{{x,H}}\"\n\
         hamiltonian = \"{hamiltonian}\"\n[method]\n{method}\ntime-step = 0.1\n[run]\ninitial = [1, 0]\n{end}\n"
    )
}

/// A ring of 32 sites with this further term and start.
fn ring(term: &str, initial: &str) -> String {
    format!(
        "[system]\nfamilies = {{ q = 32, p = 32 }}\nbracket = {{ \"q[i],p[i]\" = 1 }}\nconvention = \"{{x,H}}\"\n\
         hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1]-q[i])^2/2){term}\"\n[method]\nstepper = \"splitting\"\ntime-step = 0.1\n\
         [run]\ninitial = {initial}\nsteps = 10\n"
    )
}

/// A rigid body with these moments of inertia.
fn body(moments: &str) -> String {
    format!(
        "[system]\nvariables = [\"m1\", \"m2\", \"m3\"]\nparameters = {{ {moments} }}\nbracket = {{ lie-algebra = \"so3\" }}\n\
         hamiltonian = \"m1^2/(2*I1) + m2^2/(2*I2) + m3^2/(2*I3)\"\n[method]\n{PAIR}\ntime-step = 0.1\n\
         [run]\ninitial = [1, 0.2, 0.3]\nsteps = 10\n"
    )
}

/// The program on a scene.
fn said(scene: &str, options: &[&str]) -> Said {
    let place = Place::with(scene);
    place.leafwise(&[&["run", "scene.toml"], options].concat())
}

/// Judges all cases and returns how many there are.
fn judged(scene: impl Fn(&str) -> String, cases: &[Case<'_>]) -> usize {
    for (input, code, pieces) in cases {
        let said = said(&scene(input), &[]);
        let text = format!("{input}:\n{}", said.err);
        assert_eq!(said.code, Some(*code), "{text}");
        for piece in *pieces {
            assert!(said.err.contains(piece), "`{piece}` is missing of {text}");
        }
    }
    cases.len()
}

/// Functions that formulas have are taken, others are told with what stands for them, never with a neighbour in the alphabet alone.
#[test]
fn functions_are_taken_or_told() {
    let term = |text: &str| oscillator(&format!("p^2/2 + q^2/2 + {text}"), PAIR, "steps = 3");
    let all = "functions: exp, ln, sqrt, sin";
    let count = judged(
        term,
        &[
            ("cot(q)", DONE, &[]),
            ("csc(q)", DONE, &[]),
            ("sec(q)", DONE, &[]),
            ("sign(q)", DONE, &["smooth in pieces"]),
            ("abs(q)", DONE, &["smooth in pieces"]),
            ("min(q, p)", DONE, &["smooth in pieces"]),
            ("max(q, p)", DONE, &["smooth in pieces"]),
            ("mod(q, 2)", DONE, &["smooth in pieces"]),
            ("floor(q/8)", DONE, &["smooth in pieces"]),
            ("ceil(q/8)", DONE, &["smooth in pieces"]),
            ("heaviside(q)", DONE, &["smooth in pieces"]),
            ("if(q > 0, q^2, 0)", DONE, &["smooth in pieces"]),
            ("atan2(p, q)", DONE, &[]),
            ("erf(q)", DONE, &[]),
            ("erfc(q)", DONE, &[]),
            ("gamma(q)", DONE, &[]),
            ("lgamma(q)", DONE, &[]),
            ("j0(q) + j1(q)", DONE, &[]),
            ("ellipk(q/4) + ellipe(q/4)", DONE, &[]),
            ("log10(q)", DONE, &[]),
            ("log2(q)", DONE, &[]),
            ("log(q)", REFUSED, &["did you mean `ln`?", all]),
            ("sinc(q)", REFUSED, &["did you mean `sin(x)/x`?", all]),
            ("pow(q, 2)", REFUSED, &["did you mean `x^y`?", all]),
            (
                "hypot(q, p)",
                REFUSED,
                &["did you mean `sqrt(x^2 + y^2)`?", all],
            ),
            (
                "round(q)",
                REFUSED,
                &["did you mean `floor(x + 1/2)`?", all],
            ),
            ("cbrt(q)", REFUSED, &["did you mean `x^(1/3)`?", all]),
            ("expm1(q)", REFUSED, &["did you mean `exp(x) - 1`?", all]),
            ("log1p(q)", REFUSED, &["did you mean `ln(1 + x)`?", all]),
            ("step(q)", REFUSED, &["did you mean `heaviside`?", all]),
            ("piecewise(q, p)", REFUSED, &["did you mean `if`?", all]),
            (
                "besselj(0, q)",
                REFUSED,
                &["unknown function `besselj`", all],
            ),
            ("foo(q)", REFUSED, &["unknown function `foo`", all]),
        ],
    );
    assert_eq!(count, 33);
}

/// Spellings of numbers and products.
#[test]
fn formulas_say_what_to_write() {
    let of = |text: &str| oscillator(text, PAIR, "steps = 3");
    let count = judged(
        of,
        &[
            ("p**2/2 + .5*q**2", DONE, &[]),
            ("p^2/2 + q^2/2 − 0.1*q", REFUSED, &["did you mean `-`?"]),
            (
                "H = p^2/2 + q^2/2",
                REFUSED,
                &["a formula has no `=`: write only the right-hand side"],
            ),
            (
                "p^2/2 + e^(-q)",
                REFUSED,
                &["unknown name `e`", "e^x is written exp(x)"],
            ),
            ("p^2/2 + 2^q", REFUSED, &["write exp(b*ln(a))"]),
            (
                "p^2/2 + 1e400*q^2",
                REFUSED,
                &["`1e400` is beyond the largest double"],
            ),
            ("p^2/2 + 2q", REFUSED, &["a product is written with `*`"]),
        ],
    );
    let observed = |text: &str| {
        let end = format!("steps = 3\nrecord = {{ every = 1, observables = [\"{text}\"] }}");
        oscillator("p^2/2 + q^2/2", PAIR, &end)
    };
    let product = &["a product is written with `*`"][..];
    let observables = judged(
        observed,
        &[
            ("2*q", DONE, &[]),
            ("atan2(p, q)", DONE, &[]),
            ("abs(q)", DONE, &[]),
            ("mod(q, 2*pi)", DONE, &[]),
            ("2q", REFUSED, product),
            ("1e", REFUSED, product),
            ("2e3q", REFUSED, product),
            (
                "q²",
                REFUSED,
                &["unexpected character `²`", "did you mean `^2`?"],
            ),
            ("π", REFUSED, &["did you mean `pi`?"]),
            ("", REFUSED, &["a number, a name or `(` is expected"]),
        ],
    );
    assert_eq!((count, observables), (7, 10));
}

/// Ends of a run in all the words that people have for them, and numbers of steps.
#[test]
fn ends_and_steps_are_understood() {
    let of = |end: &str| oscillator("p^2/2 + q^2/2", PAIR, end);
    let word = &["`steps` is missing", "or at the time `until`"][..];
    let count = judged(
        of,
        &[
            ("steps = 1e3", DONE, &["done: 1 000 steps to t = 100"]),
            ("steps = 1000.0", DONE, &["done: 1 000 steps to t = 100"]),
            ("steps = 10.5", REFUSED, &["must be a whole number"]),
            ("until = 1", DONE, &["done: 10 steps to t = 1 "]),
            ("until = 1.05", DONE, &["11 in all", "time-step = 0.09545"]),
            ("t_end = 1", REFUSED, word),
            ("tend = 1", REFUSED, word),
            ("t-end = 1", REFUSED, word),
            ("time = 1", REFUSED, word),
            ("duration = 1", REFUSED, word),
        ],
    );
    let said = said(
        &oscillator("p^2/2 + k*q^2/2", PAIR, "steps = 3"),
        &["--set", "system.parameters.k=1e400"],
    );
    assert_eq!(said.code, Some(REFUSED));
    said.says(&["`1e400` is beyond the largest double, 1.8e308"]);
    assert_eq!(count, 10);
}

/// Names of methods from books and other programs.
#[test]
fn steppers_of_other_programs_are_named_here() {
    let of = |name: &str| {
        let method = format!("stepper = \"{name}\"");
        oscillator("p^2/2 + q^2/2", &method, "steps = 3")
    };
    let verlet = &["stepper = \"splitting\" is Störmer and Verlet's method, leapfrog"][..];
    let known = &["known: dop853, dormand-prince45"][..];
    let count = judged(
        of,
        &[
            ("verlet", REFUSED, verlet),
            ("leapfrog", REFUSED, verlet),
            ("stormer-verlet", REFUSED, verlet),
            ("velocity-verlet", REFUSED, verlet),
            ("strang", REFUSED, verlet),
            ("rk45", REFUSED, &["stepper = \"dormand-prince45\""]),
            ("euler", REFUSED, known),
            ("lsoda", REFUSED, known),
            // Its tolerance is the default already: a warning names another method.
            ("taylor", DONE, &["stepper = \"splitting\""]),
        ],
    );
    assert_eq!(count, 9);
}

/// Parameters by formulas, and keys and starts without a value.
#[test]
fn parameters_and_starts_are_judged_before_a_step() {
    let count = judged(
        body,
        &[
            ("I1 = 1, I2 = \"3/4\", I3 = \"I1 + I2\"", DONE, &[]),
            (
                "I1 = 1, I2 = 0, I3 = 2",
                REFUSED,
                &[
                    "the motion has no finite value at the initial state",
                    "where `I2` is 0",
                    "no division by zero",
                ],
            ),
            (
                "Iα = 1.0, I1 = 1, I2 = 1.5, I3 = 2",
                REFUSED,
                &["needs quotes: \"Iα\" = 1.0"],
            ),
            ("\"Iα\" = 1.0, I1 = 1, I2 = 1.5, I3 = 2", DONE, &["`Iα`"]),
        ],
    );
    let of = |term: &str| oscillator(&format!("p^2/2 + {term}"), PAIR, "steps = 3");
    let starts = judged(
        of,
        &[
            (
                "ln(q - 2)",
                REFUSED,
                &[
                    "the energy has no value at the initial state",
                    "no step can be taken",
                ],
            ),
            (
                "sqrt(q - 2)",
                REFUSED,
                &["the energy has no value at the initial state"],
            ),
            (
                "1/(q - 1)",
                REFUSED,
                &["no finite value at the initial state"],
            ),
        ],
    );
    // Nothing was begun.
    let place = Place::with(&of("ln(q - 2)"));
    assert_eq!(place.leafwise(&["run", "scene.toml"]).code, Some(REFUSED));
    assert!(place.is_untouched());
    assert_eq!((count, starts), (4, 3));
}

/// Brackets in the words of textbooks.
#[test]
fn brackets_are_taken_or_told() {
    let plain = oscillator("p^2/2 + q^2/2", PAIR, "steps = 3");
    let of = |bracket: &str| plain.replace("{ \"q,p\" = 1 }", bracket);
    let count = judged(
        of,
        &[
            ("\"canonical\"", DONE, &[]),
            ("{ canonical = [[\"q\", \"p\"]] }", DONE, &[]),
        ],
    );

    let charge = |field: &str| {
        format!(
            "[system]\nvariables = [\"x\", \"y\", \"z\", \"vx\", \"vy\", \"vz\"]\nbracket = {{ magnetic-field = {field} }}\n\
             hamiltonian = \"(vx^2 + vy^2 + vz^2)/2\"\n[method]\n{PAIR}\ntime-step = 0.1\n[run]\ninitial = [1, 0, 0, 0, 1, 0]\nsteps = 3\n"
        )
    };
    let divergence = "the divergence of the magnetic field, dBx/dx + dBy/dy + dBz/dz, is not zero";
    let said_of = said(&charge("[\"x\", \"0\", \"1\"]"), &[]);
    assert_eq!(said_of.code, Some(REFUSED), "{}", said_of.err);
    said_of.says(&[divergence]);
    assert_eq!(said(&charge("[\"0\", \"0\", \"1\"]"), &[]).code, Some(DONE));

    // Pairs that run backwards under the paper's sign, whatever their names.
    for (q, p) in [
        ("q", "p"),
        ("theta", "L"),
        ("phi", "J"),
        ("x", "v"),
        ("u", "w"),
    ] {
        let scene = format!(
            "[system]\nvariables = [\"{q}\", \"{p}\"]\nbracket = {{ \"{q},{p}\" = 1 }}\nhamiltonian = \"{p}^2/2 - cos({q})\"\n\
             [method]\n{PAIR}\ntime-step = 0.1\n[run]\ninitial = [1, 0]\nsteps = 3\n"
        );
        let said = said(&scene, &[]);
        assert_eq!(said.code, Some(DONE));
        said.says(&["run backwards in time", "convention = \"{x,H}\""]);
    }
    assert_eq!(count, 2);
}

/// Single sites, indices as numbers, lists for a family.
#[test]
fn lattices_say_what_stands_for_a_site() {
    let start = "{ \"q[i]\" = \"sin(i)\", \"p[i]\" = 0 }";
    let sites = judged(
        |term| ring(term, start),
        &[
            (" + q[3]^2", DONE, &[]),
            (
                " + sum(i, cos(2*pi*i/N)*q[i]^2)",
                REFUSED,
                &[
                    "an index is allowed only in brackets",
                    "w[i] in the formula, and \"w[i]\" = \"…\" in [system.parameters]",
                ],
            ),
        ],
    );
    let starts = judged(
        |initial| ring("", initial),
        &[
            (
                "{ q = [1, 2, 3], \"p[i]\" = 0 }",
                REFUSED,
                &["under its name with an index: \"q[i]\" = [1, 2, 3]"],
            ),
            (start, DONE, &[]),
        ],
    );
    assert_eq!((sites, starts), (2, 2));
}

/// What is typed at the command line, and directories that hold something.
#[test]
fn the_command_line_says_what_is_there() {
    let scene = oscillator("p^2/2 + k*q^2/2", "stepper = \"splitting\"", "steps = 20");
    let place = Place::with(&scene);
    let said = place.leafwise(&["merge", "nothere", "--out", "y"]);
    said.says(&["cannot read nothere"]);
    let said = place.leafwise(&["reproduce", "--list"]);
    assert_eq!(said.code, Some(DONE));
    assert!(said.out.contains("so3-realization-10"), "{}", said.out);

    // The same numbers in other spellings are the same scene; of another one the reasons alone are told.
    assert_eq!(
        place.leafwise(&["run", "scene.toml", "--out", "run"]).code,
        Some(DONE)
    );
    let spelt = scene
        .replace("k = 1 ", "k = 1.0 ")
        .replace("= 0.1\n", "= 1e-1\n")
        .replace("[1, 0]", "[1.0, 0.0]");
    place.write("spelt.toml", &spelt);
    let said = place.leafwise(&["run", "spelt.toml", "--out", "run"]);
    assert_eq!(said.code, Some(DONE), "{}", said.err);
    said.says(&["it was already complete"]);
    let other = scene
        .replace("k = 1 ", "k = 2 ")
        .replace("steps = 20", "steps = 10");
    place.write("other.toml", &other);
    let said = place.leafwise(&["run", "other.toml", "--out", "run"]);
    assert_eq!(said.code, Some(2));
    said.says(&["system.parameters.k: 1 → 2"]);
    assert!(!said.err.contains("run.steps"), "{}", said.err);

    // Backwards in time the first sample is at 0, not at -0.
    place.write("back.toml", &scene.replace("= 0.1\n", "= -0.1\n"));
    assert_eq!(
        place.leafwise(&["run", "back.toml", "--out", "back"]).code,
        Some(DONE)
    );
    let samples = place.read("back/samples.csv");
    assert!(
        samples
            .lines()
            .nth(1)
            .is_some_and(|row| row.starts_with("0.0,")),
        "{samples}"
    );
}

/// H = T + V over a method that solves equations: one line names the stepper that solves none, and none where it is at work.
#[test]
fn a_sum_of_pieces_is_told_of_splitting_in_one_line() {
    let hint = "stepper = \"splitting\" solves no equations";
    let lines = |hamiltonian: &str, method: &str, end: &str| {
        let said = said(&oscillator(hamiltonian, method, end), &[]);
        assert_eq!(said.code, Some(DONE), "{}", said.err);
        said.err.matches(hint).count()
    };
    let pendulum = "p^2/2 - cos(q)";
    assert_eq!(lines(pendulum, PAIR, "steps = 100"), 1);
    assert_eq!(lines(pendulum, "stepper = \"splitting\"", "steps = 100"), 0);
    assert_eq!(lines(pendulum, "stepper = \"dop853\"", "steps = 100"), 0);
    // No pieces with exact flows, and too few steps to speak of.
    assert_eq!(
        lines("(1 + q^2)*(1 + p^2)/2 + sin(p*q^2)/20", PAIR, "steps = 100"),
        0
    );
    assert_eq!(lines(pendulum, PAIR, "steps = 10"), 0);
}

/// Commands that ask for a Hamiltonian motion name the keys to take out, and `tune` no measure that friction changes.
#[test]
fn friction_is_named_where_it_is_refused() {
    let scene = oscillator("p^2/2 + q^2/2", "stepper = \"gauss\"", "steps = 100");
    let with = |more: &str| {
        let text = scene.replace("[method]", &format!("{more}\n[method]"));
        Place::with(&text)
    };
    let friction = "friction = { p = \"-0.1*p\" }";
    let both = "friction = { p = \"-0.1*p\" }\nforces = { q = \"0.1*p\" }";
    for (more, keys) in [
        (friction, "take system.friction out"),
        (both, "take system.forces and system.friction out"),
        ("damping = { rate = \"0.1\" }", "take system.damping out"),
    ] {
        let place = with(more);
        for command in [
            &["orbit", "scene.toml"][..],
            &["orbit", "scene.toml", "--equilibrium"],
            &["tabulate", "scene.toml", "--steps", "8"],
        ] {
            let said = place.leafwise(command);
            assert_ne!(said.code, Some(DONE), "{command:?}");
            said.says(&[keys]);
        }
    }
    let said = with(friction).leafwise(&["tune", "scene.toml", "--energy", "1e-6"]);
    said.says(&[
        "friction changes the energy and the Casimirs",
        "give only --error 1e-8",
    ]);
    let open = scene.replace("stepper = \"gauss\"", "realization = \"auto\"");
    let place = Place::with(&open.replace("[method]", &format!("{friction}\n[method]")));
    let said = place.leafwise(&["check", "scene.toml"]);
    assert_eq!(said.code, Some(REFUSED));
    said.says(&[
        "no such map follows the `friction` of this system",
        "the steppers",
    ]);
    assert!(!said.err.contains("one-form"), "{}", said.err);
    // Zeros are none.
    let place = Place::with(&open.replace("[method]", "friction = {}\n[method]"));
    assert_eq!(place.leafwise(&["run", "scene.toml"]).code, Some(DONE));
}

/// A parameter of value 0 that the motion is divided by is underlined: of all sites, of one site in a list, by a key of its own or by
/// a formula.
#[test]
fn a_zero_that_is_divided_by_is_underlined() {
    let vortices = |parameters: &str| {
        format!(
            "[system]\nlibrary = \"vortices\"\nfamilies = {{ x = 4, y = 4 }}\nparameters = {{ {parameters} }}\n[method]\n\
             stepper = \"rk4\"\ntime-step = 0.1\n[run]\nsteps = 5\ninitial = {{ \"x[i]\" = \"cos(2*pi*i/N)\", \"y[i]\" = \
             \"sin(2*pi*i/N)\" }}\n"
        )
    };
    let tensor = |parameters: &str| {
        format!(
            "[system]\nvariables = [\"x\", \"y\"]\nparameters = {{ {parameters} }}\nbracket = {{ \"x,y\" = \"1/g\" }}\n\
             hamiltonian = \"x^2 + a*y^2\"\n[method]\nstepper = \"rk4\"\ntime-step = 0.1\n[run]\nsteps = 5\ninitial = [1, 0]\n"
        )
    };
    let chain = |parameters: &str| {
        format!(
            "[system]\nfamilies = {{ q = 600, p = 600 }}\nparameters = {{ {parameters} }}\nboundary = \"periodic\"\n\
             bracket = {{ \"q[i],p[i]\" = \"-1/k[i]\" }}\nhamiltonian = \"sum(i, p[i]^2/(2*g) + q[i]^2)\"\n[method]\n\
             stepper = \"splitting\"\ntime-step = 0.1\n[run]\nsteps = 5\ninitial = {{ \"q[i]\" = \"sin(i)\", \"p[i]\" = 0 }}\n"
        )
    };
    for (scene, zero, value, behind) in [
        (chain("\"k[i]\" = 1, g = 0"), "g", "0", " }"),
        (
            chain("\"k[i]\" = \"i - 3\", g = 1"),
            "k[3]",
            "\"i - 3\"",
            ", g = 1 }",
        ),
        (
            vortices("\"gamma[i]\" = [1, 2, 0, 4]"),
            "gamma[2]",
            "0",
            ", 4] }",
        ),
        (
            vortices("\"gamma[i]\" = 1, \"gamma[2]\" = 0"),
            "gamma[2]",
            "0",
            " }",
        ),
        (
            vortices("\"gamma[i]\" = \"i - 3\""),
            "gamma[3]",
            "\"i - 3\"",
            " }",
        ),
        (tensor("a = 0, g = 0"), "g", "0", " }"),
    ] {
        let here = Place::with(&scene);
        let said = here.leafwise(&["run", "scene.toml"]);
        assert_eq!(said.code, Some(REFUSED), "{}", said.err);
        said.says(&[&format!("where `{zero}` is 0"), "give it another value"]);
        let lines: Vec<&str> = said.err.lines().collect();
        let marks = lines.iter().position(|line| line.contains('^'));
        let marks = marks.unwrap_or_else(|| panic!("{}", said.err));
        let (from, to) = (lines[marks].find('^'), lines[marks].rfind('^'));
        let (from, to) = (from.unwrap_or(0), to.unwrap_or(0) + 1);
        assert_eq!(
            (&lines[marks - 1][from..to], &lines[marks - 1][to..]),
            (value, behind)
        );
        let cured = scene.replace("[1, 2, 0, 4]", "[1, 2, 3, 4]");
        let cured = cured.replace("\"gamma[2]\" = 0", "\"gamma[2]\" = 3");
        let cured = cured.replace("i - 3", "i + 3").replace("g = 0", "g = 1");
        let said = Place::with(&cured).leafwise(&["run", "scene.toml"]);
        assert_eq!(said.code, Some(DONE), "{}", said.err);
    }
}

//! The functions of formulas against values of `data/functions.json`, which mpmath computed at 60 digits, and their
//! derivatives against those of motions, and against differences.

use leafwise::expression::bounded::{Bounded, BoundedNumbers};
use leafwise::expression::series::{Tape, TaylorState};
use leafwise::expression::syntax::{Formula, Scope};
use leafwise::expression::{Expression, Graph, Kernel, Ring, Term};
use leafwise_tests::scenes::{composed, end};
use serde_json::Value;

/// The formula of x and y that a text is.
fn formula(text: &str) -> Expression {
    let scope = Scope::new()
        .with_variables(&["x", "y"])
        .with_parameters(&["a", "b"]);
    let parsed = Formula::parse(text).expect(text);
    parsed.resolve(&scope, None).expect(text).expect(text)
}

/// The value and the two derivatives by code, those of the second by reverse mode.
fn by_code(formula: &Expression, state: [f64; 2]) -> [f64; 5] {
    code_of(formula)(state)
}

/// Code that gives them at any state.
fn code_of(formula: &Expression) -> impl FnMut([f64; 2]) -> [f64; 5] + use<> {
    let mut graph = Graph::new();
    let code = formula.evaluate_in(&mut graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)));
    let code = code.expect("code");
    let slopes = [0, 1].map(|at| graph.derivative(&code, at).expect("a derivative"));
    let gradient = graph.gradient(&code, 2).expect("a gradient");
    let outputs: Vec<Term> = [code].into_iter().chain(slopes).chain(gradient).collect();
    let kernel = Kernel::compile(&graph, &outputs, 0, 2);
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
    move |state| {
        let mut values = [0.0; 5];
        kernel.evaluate(&mut workspace, &state, &mut values);
        values
    }
}

fn data() -> Value {
    serde_json::from_str(include_str!("data/functions.json")).expect("reference values")
}

fn number(value: &Value) -> f64 {
    value
        .as_str()
        .expect("a decimal")
        .parse()
        .expect("a double")
}

/// Most units of 2⁻⁵² by which a derivative may be off, of the value, or of this size where the value is less. The errors
/// of elliptic integrals next to m = 1 are those of the integrals of the second kind there.
fn allowed(name: &str, order: u64, x: f64) -> (f64, f64) {
    let order = order as f64;
    match name {
        "sqrt" => (0.5, 0.0),
        "erf" | "log10" | "log2" | "exp" | "ln" | "sin" | "cos" | "tan" | "asin" | "acos"
        | "atan" => (1.0, 0.0),
        "sinh" | "cosh" | "tanh" | "asinh" | "acosh" | "atanh" => (2.0, 0.0),
        // One over a function, or one over another, each within a unit.
        "sec" | "csc" => (1.5, 0.0),
        "cot" => (2.5, 0.0),
        "erfc" => (1.5, 0.0),
        "gamma" => (4.0, 0.0),
        "lgamma" if order == 0.0 => (4.0, 1e-3),
        "lgamma" => (16.0, 1.0),
        // Of the size of the amplitude.
        "j0" | "j1" => (2.0, if order == 0.0 { 0.3 } else { 1.0 }),
        // A recurrence, each of whose steps subtracts.
        _ if x < -16.0 => (16.0 * libm::exp2(0.5 * order), 0.0),
        _ => (24.0, 0.0),
    }
}

/// The worst errors are printed: read them with --nocapture.
#[test]
#[allow(
    clippy::print_stdout,
    reason = "measured errors, read with --nocapture"
)]
fn functions_have_the_values_of_mpmath() {
    let data = data();
    let mut count = 0;
    for case in data["functions"].as_array().expect("cases") {
        let name = case["function"].as_str().expect("a name");
        let order = case["derivative"].as_u64().expect("an order");
        let of = match order {
            0 => formula(&format!("{name}(x)")),
            _ => formula(&format!("{name}(x, {order})")),
        };
        let mut code = code_of(&of);
        let mut worst = (0.0, 0.0);
        for row in case["values"].as_array().expect("values") {
            let (x, exact) = (number(&row[0]), number(&row[1]));
            let [found, ..] = code([x, 0.0]);
            assert_eq!(found.to_bits(), of.evaluate(&[x, 0.0], &[]).to_bits());
            let (most, least) = allowed(name, order, x);
            let units = match found == exact {
                true => 0.0,
                false => (found - exact).abs() / (f64::EPSILON * exact.abs().max(least)),
            };
            if units > worst.0 {
                worst = (units, x);
            }
            assert!(
                units <= most,
                "{name}^({order})({x}) = {found}, not {exact}: {units:.1}"
            );
            count += 1;
        }
        println!("{name}^({order}): {:.2} units at {}", worst.0, worst.1);
    }
    assert!(count > 10_000, "{count}");
}

/// An angle and an exact remainder, and a sum at most.
#[test]
fn angles_and_remainders_have_the_values_of_mpmath() {
    let data = data();
    for (name, rows) in [("atan2", &data["atan2"]), ("mod", &data["mod"])] {
        let of = formula(&format!("{name}(x, y)"));
        for row in rows.as_array().expect("rows") {
            let (x, y, exact) = (number(&row[0]), number(&row[1]), number(&row[2]));
            let [found, ..] = by_code(&of, [x, y]);
            let off = (found - exact).abs();
            assert!(
                off <= f64::EPSILON * exact.abs(),
                "{name}({x}, {y}) = {found}, not {exact}"
            );
            if name == "mod" {
                assert!(found * y >= 0.0 && found.abs() < y.abs(), "{found} of {y}");
            }
        }
    }
}

fn sign(x: f64) -> f64 {
    f64::from(i8::from(x > 0.0) - i8::from(x < 0.0))
}

/// A function of two numbers.
type OfTwo = fn(f64, f64) -> f64;

/// Functions of pieces have no error at all: at ordinary states, at seams, at ±0, and at the ends of the doubles.
#[test]
fn functions_of_pieces_are_exact() {
    let ends = [
        f64::MAX,
        f64::MIN_POSITIVE,
        5e-324,
        1.0,
        0.5,
        2.5,
        3.0,
        4_503_599_627_370_497.5,
    ];
    let mut places: Vec<f64> = ends
        .iter()
        .flat_map(|x| [*x, -x])
        .chain([0.0, -0.0])
        .collect();
    places.extend((0..40).map(|k| libm::sin(f64::from(k)) * libm::exp2(f64::from(k) - 20.0)));
    let functions: [(&str, OfTwo); 8] = [
        ("abs(x)", |x, _| x.abs()),
        ("floor(x)", |x, _| x.floor()),
        ("ceil(x)", |x, _| x.ceil()),
        ("min(x, y)", f64::min),
        ("max(x, y)", f64::max),
        ("if(x < y, x, y)", |x, y| if x < y { x } else { y }),
        ("if(x > 0 and y > 0, 1, 2)", |x, y| {
            if x > 0.0 && y > 0.0 { 1.0 } else { 2.0 }
        }),
        // The sign of 0 is 0.
        ("sign(x)*sign(y)", |x, y| sign(x) * sign(y)),
    ];
    let mut count = 0;
    for (text, exact) in functions {
        let mut code = code_of(&formula(text));
        for x in &places {
            for y in &places {
                assert_eq!(code([*x, *y])[0], exact(*x, *y), "{text} of {x}, {y}");
                count += 1;
            }
        }
    }
    let mut step = code_of(&formula("heaviside(x)"));
    for x in places.iter().filter(|x| **x != 0.0) {
        assert_eq!(step([*x, 0.0])[0], f64::from(u8::from(*x > 0.0)), "{x}");
    }
    assert!(count > 20_000, "{count}");
}

/// What has derivatives of all orders, and what is smooth in pieces, at states within one.
const FORMULAS: [(&str, [f64; 2]); 30] = [
    ("abs(x)*y^2", [-1.3, 0.7]),
    ("sign(x)*y^3 + x", [-1.3, 0.7]),
    ("min(x^2, sin(y))", [0.4, 2.1]),
    ("max(x^2, sin(y))", [0.4, 2.1]),
    ("mod(x*y, 0.7)", [1.9, 2.2]),
    ("floor(3*x)*y + ceil(y)*x", [1.15, 0.6]),
    ("atan2(y, x)", [0.7, 1.9]),
    ("atan2(y, x)", [-1.7, 0.9]),
    ("atan2(y, x)", [-1.7, -0.9]),
    ("atan2(x*y, x - y)", [0.2, -1.9]),
    ("heaviside(x)*exp(y) + cot(y)", [0.3, 0.9]),
    ("sec(x)*csc(y)", [0.3, 0.9]),
    ("if(x > 0, sqrt(x)*y, x^2)", [0.8, 1.4]),
    ("if(x > 0, sqrt(x)*y, x^2*y)", [-0.8, 1.4]),
    ("if(x < y and y < 2, ln(y - x), ln(x - y))", [0.5, 1.4]),
    ("if(x < y or y < 0, ln(y - x), ln(x - y))", [2.5, 1.4]),
    ("erf(x*y)", [0.8, 0.9]),
    ("erfc(x - y)", [2.8, 0.9]),
    ("gamma(x*y)", [1.8, 2.1]),
    ("gamma(x)/y", [-1.4, 2.1]),
    ("lgamma(x + y^2)", [0.3, 1.2]),
    ("lgamma(x, 1)*y", [2.3, 1.2]),
    ("j0(x*y) + j1(x - y)", [1.3, 2.4]),
    ("j1(x)*j0(y, 2)", [0.0, 2.4]),
    ("ellipk(x*y)", [0.8, 0.9]),
    ("ellipk(x) + ellipe(y)", [0.0, 0.0]),
    ("ellipe(x/y)", [-2.8, 0.9]),
    ("ellipe(x)*ellipk(y, 1)", [0.95, -6.0]),
    ("log10(x)*log2(y)", [0.3, 7.0]),
    ("(max(x, 0)^2 + abs(y)^3)^1.5", [0.9, -0.4]),
];

/// Differences of fourth order have errors of h⁴ and ε/h; `D` is the program's own derivative to the bit.
#[test]
fn derivatives_are_those_of_differences() {
    let h = 1e-3;
    for (text, at) in FORMULAS {
        let of = formula(text);
        let found = by_code(&of, at);
        let value = of.evaluate(&at, &[]);
        assert!(
            (found[0] - value).abs() <= 64.0 * f64::EPSILON * value.abs().max(1.0),
            "{text}: {} for {value}",
            found[0]
        );
        for along in 0..2 {
            let moved = |steps: f64| {
                let mut state = at;
                state[along] += steps * h;
                of.evaluate(&state, &[])
            };
            let difference =
                (8.0 * (moved(1.0) - moved(-1.0)) - moved(2.0) + moved(-2.0)) / (12.0 * h);
            let size = found[1 + along].abs().max(found[0].abs()).max(1.0);
            for slope in [found[1 + along], found[3 + along]] {
                let off = (slope - difference).abs();
                assert!(
                    off <= 1e-8 * size,
                    "{text} along {along}: {slope}, {difference}"
                );
            }
            let name = ["x", "y"][along];
            let [own, ..] = by_code(&formula(&format!("D({text}, {name})")), at);
            assert_eq!(own, found[1 + along], "D({text}, {name})");
        }
        // The exact ring, where it has the formula.
        let mut ring = Ring::new(2);
        let element = of.evaluate_in(&mut ring, &mut |ring: &mut Ring, at| Ok(ring.variable(at)));
        let element = element.expect("an element");
        for along in 0..2 {
            let slope = ring.derivative(&element, along).expect("a derivative");
            let slope = ring.formula(&slope).evaluate(&at, &[]);
            let off = (slope - found[1 + along]).abs();
            assert!(
                off <= 1e-12 * slope.abs().max(1.0),
                "{text} in the ring: {slope}"
            );
        }
    }
}

/// The coefficients of f(x₀ + t) are f⁽ᵏ⁾(x₀)/k!, of special functions by their table and of others by f⁽ᵏ⁾ from D.
#[test]
fn series_are_those_of_the_derivatives() {
    for (text, at) in [
        ("lgamma(x)", 2.7),
        ("j0(x)", 1.9),
        ("j1(x)", 0.0),
        ("ellipk(x)", 0.3),
        ("ellipe(x)", -0.8),
        ("gamma(x)", 1.6),
        ("erf(x)", 0.4),
        ("log10(x)", 2.0),
        ("abs(x)^3", -1.2),
        ("if(x > 0, j1(x^2), sqrt(x))", 1.1),
        ("atan2(x^2, 1 - x)", 1.8),
        ("ellipk(sin(x)^2)", 0.6),
    ] {
        let mut tape = Tape::new();
        let top = tape.record(&formula(text)).expect(text);
        let mut numbers = BoundedNumbers {
            parameters: Vec::new(),
        };
        let mut state = TaylorState::new(&tape);
        let (mut derivative, mut factorial) = (text.to_owned(), 1.0);
        for k in 0..6 {
            let variable = |_: &mut BoundedNumbers, _: usize| {
                Bounded::exact(match k {
                    0 => at,
                    1 => 1.0,
                    _ => 0.0,
                })
            };
            state.extend(&tape, &mut numbers, variable).expect(text);
            let found = state.coefficient(top, k).value;
            let exact = formula(&derivative).evaluate(&[at, 0.0], &[]) / factorial;
            let off = (found - exact).abs();
            assert!(
                off <= 1e-12 * exact.abs().max(1.0),
                "{text}, {k}: {found}, {exact}"
            );
            derivative = format!("D({derivative}, x)");
            factorial *= (k + 1) as f64;
        }
    }
}

/// A ball on a soft floor, H of two pieces: after a fall and a rise, 2√2, and half a turn of the floor's spring it is where it
/// was. `until` is that time. A step across the seam errs by at most h² k, and there are two.
#[test]
fn a_ball_returns_from_a_soft_floor() {
    let root = libm::sqrt(2.0);
    let contact = (std::f64::consts::PI + 2.0 * libm::atan(0.1 / root)) / 10.0;
    let period = 2.0 * root + contact;
    for (method, h) in [
        ("stepper = \"splitting\"", 1e-3),
        (
            "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }",
            1e-3,
        ),
        ("stepper = \"dop853\"", 1e-3),
    ] {
        let text = format!(
            "[system]\nvariables = [\"q\", \"p\"]\nparameters = {{ k = 100, g = \"k/100\" }}\nbracket = {{ \"q,p\" = 1 }}\n\
             convention = \"{{x,H}}\"\nhamiltonian = \"p^2/2 + g*q + if(q < 0, k*q^2/2, 0)\"\n\
             [method]\n{method}\ntime-step = {h}\n[run]\ninitial = [1, 0]\nuntil = {period:?}\n"
        );
        let end = end(&composed(&text));
        let off = (end[0] - 1.0).abs().max(end[1].abs());
        assert!(off <= 4.0 * 100.0 * h * h, "{method}: {end:?}");
    }
}

/// A drive that begins with the run, and one that turns round at a step's end: a coordinate is 0 where its slope jumps.
/// p is −t, and t to ½ and then 1 − t.
#[test]
fn adaptive_steppers_begin_at_a_seam() {
    for (potential, expected) in [
        ("heaviside(t)*q", [-1.0, -2.0]),
        ("sign(t - 1/2)*q", [0.75, -1.0]),
    ] {
        for method in ["dop853", "dormand-prince45", "taylor"] {
            let text = format!(
                "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = 1 }}\nconvention = \"{{x,H}}\"\n\
                 hamiltonian = \"p^2/2 + {potential}\"\n[method]\nstepper = \"{method}\"\ntime-step = 0.1\n\
                 [run]\ninitial = [1, 0]\nsteps = 20\n"
            );
            let end = end(&composed(&text));
            // A substep across a jump is 2⁻⁴⁴ of a step. One with a first stage of the other side errs by 74 times what
            // dormand-prince45 sees, b₁ over b₁ − b̂₁, of 1e-12 in the mean of four coordinates; p moves q for 1.5.
            let off = (end[0] - expected[0])
                .abs()
                .max((end[1] - expected[1]).abs());
            assert!(
                off <= 2.5 * 2.0 * 74.0 * 1e-12,
                "{method}, {potential}: {end:?}"
            );
        }
    }
}

/// Splitting takes each branch's piece where its seam rests, from states of either branch: kicks and drifts, which are
/// turned round by the momenta's sign. Back at the start after as many steps, up to the round-off of all of them.
#[test]
fn splitting_across_seams_is_reversible() {
    for potential in [
        "max(q1, q2)^2",
        "if(q1 > q2, q1^2, 3*q1^2 + q2)",
        "abs(q1 - q2) + min(q1, q2, 0)^2",
        "if(q1 < 0, 50*q1^2, 0) + q1 + q2^2/2",
    ] {
        for start in [[1.0, 0.5, 0.0, 0.3], [0.5, 1.0, 0.0, 0.3]] {
            let steps = 500;
            let run = |initial: &[f64]| {
                composed(&format!(
                    "[system]\nvariables = [\"q1\", \"q2\", \"p1\", \"p2\"]\nconvention = \"{{x,H}}\"\n\
                     bracket = {{ \"q1,p1\" = 1, \"q2,p2\" = 1 }}\nhamiltonian = \"(p1^2 + p2^2)/2 + {potential}\"\n\
                     [method]\nstepper = \"splitting\"\ntime-step = 0.01\n[run]\ninitial = {initial:?}\nsteps = {steps}\n"
                ))
            };
            let turned = |x: &[f64]| vec![x[0], x[1], -x[2], -x[3]];
            let there = end(&run(&start));
            let back = turned(&end(&run(&turned(&there))));
            let off = back.iter().zip(&start).map(|(a, b)| (a - b).abs());
            let off = off.fold(0.0, f64::max);
            // Round-offs of 2·500 steps, spread by at most e⁵ where trajectories part.
            assert!(
                off <= 1e3 * 150.0 * f64::EPSILON,
                "{potential} from {start:?}: {off:e}"
            );
        }
    }
}

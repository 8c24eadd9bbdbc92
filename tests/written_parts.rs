//! Parts that a scene writes as formulas: the built-in ones by hand, to round-off; claims that do not hold.

use leafwise::core::Registry;
use leafwise::scene::compose;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance};
use leafwise_tests::orders::measure;
use leafwise_tests::scenes::{document, end, until};

const BODY: &str = "variables = [\"x\", \"y\", \"z\"]\nparameters = { a = 0.5 }\nhamiltonian = \"a*x^2 + y^2/4 + z^2/6\"\n\
                    bracket = { \"x,y\" = \"-z\", \"y,z\" = \"-x\", \"z,x\" = \"-y\" }";
const BODY_START: &str = "[1.0, 0.5, -0.7]";

/// x × p, component by component.
const CROSS: [&str; 3] = ["(y*p_z - z*p_y)", "(z*p_x - x*p_z)", "(x*p_y - y*p_x)"];
const ALONG: &str = "(p_x*x + p_y*y + p_z*z)";
const NAMES: [&str; 3] = ["x", "y", "z"];

/// A list of TOML of a formula for each coordinate of the body.
fn formulas(each: impl Fn(usize) -> String) -> String {
    let formulas: Vec<String> = (0..3).map(|i| format!("\"{}\"", each(i))).collect();
    format!("[{}]", formulas.join(", "))
}

/// α = x − ½ x×q + ¼ q (q·x), q = εp: Cayley's chart of T*SO(3), the quarter being `factor`.
fn cayley(factor: &str) -> String {
    formulas(|i| {
        let (x, cross) = (NAMES[i], CROSS[i]);
        format!("{x} - epsilon*{cross}/2 + epsilon^2*{factor}*p_{x}*{ALONG}")
    })
}

fn closed_form(alpha: &str, more: &str) -> String {
    format!("{{ name = \"closed-form\", alpha = {alpha}{more} }}")
}

fn method(realization: &str, dynamics: &str) -> String {
    format!("realization = {realization}\ndynamics = {dynamics}")
}

const HAMILTON_JACOBI: &str = "{ name = \"hamilton-jacobi\", order = 4 }";
const ENERGY: &str = "{ name = \"generating-function\", S = [\"H\"] }";

/// What so many steps of a map whose increments are known to a few roundings may differ by.
fn round_off(steps: usize) -> f64 {
    32.0 * UNIT_ROUNDOFF * steps as f64
}

#[test]
fn cayleys_chart_by_hand_is_the_built_in_one() {
    let written = closed_form(&cayley("1/4"), "");
    for dynamics in [HAMILTON_JACOBI, ENERGY] {
        let ends = [written.as_str(), "\"so3-cayley\""].map(|realization| {
            let method = method(realization, dynamics);
            end(&until(BODY, &method, BODY_START, (20.0, 200)))
        });
        let off = distance(&ends[0], &ends[1]);
        assert!(off <= round_off(200), "{dynamics}: {off:e}");
    }
}

/// In this chart the series of α along p(h) is taken from the formulas, at any order.
#[test]
fn cayleys_chart_by_hand_has_the_order_of_the_dynamics() {
    let reference = end(&until(BODY, "stepper = \"dop853\"", BODY_START, (2.0, 400)));
    let written = closed_form(&cayley("1/4"), "");
    for (dynamics, order, steps) in [
        (ENERGY, 2.0, [16, 24, 36, 54, 81]),
        (HAMILTON_JACOBI, 4.0, [16, 24, 36, 54, 81]),
    ] {
        let points: Vec<(f64, f64)> = steps
            .iter()
            .map(|steps| {
                let run = until(BODY, &method(&written, dynamics), BODY_START, (2.0, *steps));
                (2.0 / *steps as f64, distance(&end(&run), &reference))
            })
            .collect();
        let measured = measure(&points, round_off(100), 2.0).expect("errors above round-off");
        assert!(measured.is(order, 1.0), "{measured:?}");
    }
}

/// α = x − ½ ε x×p + ε²/12 (x×p)×p + O(ε³), (x×p)×p = p (x·p) − x |p|².
#[test]
fn karasevs_second_order_by_hand_is_the_built_in_one() {
    let alpha = formulas(|i| {
        let (x, cross) = (NAMES[i], CROSS[i]);
        let even = format!("p_{x}*{ALONG} - {x}*(p_x^2 + p_y^2 + p_z^2)");
        format!("{x} - epsilon*{cross}/2 + epsilon^2/12*({even})")
    });
    let written = closed_form(&alpha, ", order = 2");
    let built_in = "{ name = \"karasev-truncated\", order = 2 }";
    let ends = [written.as_str(), built_in].map(|realization| {
        let method = method(realization, "{ name = \"hamilton-jacobi\", order = 2 }");
        end(&until(BODY, &method, BODY_START, (20.0, 200)))
    });
    let off = distance(&ends[0], &ends[1]);
    assert!(off <= round_off(200), "{off:e}");
}

const OSCILLATOR: &str = "variables = [\"q\", \"p\"]\nparameters = { w = 1.25 }\nbracket = { \"q,p\" = \"1\" }\n\
                          convention = \"{x,H}\"\nhamiltonian = \"w*(q^2 + p^2)/2\"";

/// The generating function of the turn by wh about the midpoint is tan(wh/2) (q² + p²).
const TANGENT: [&str; 3] = [
    "w*(q^2 + p^2)/2",
    "w^3*(q^2 + p^2)/24",
    "w^5*(q^2 + p^2)/240",
];

#[test]
fn generating_functions_by_hand_are_hamilton_jacobis() {
    for count in 1..=3 {
        let written: Vec<String> = TANGENT[..count]
            .iter()
            .map(|s| format!("\"{s}\""))
            .collect();
        let written = format!(
            "{{ name = \"generating-function\", S = [{}] }}",
            written.join(", ")
        );
        let built_in = format!("{{ name = \"hamilton-jacobi\", order = {} }}", 2 * count);
        // ε h is the step: neither factor is 1.
        let ends = [written, built_in].map(|dynamics| {
            let text = format!(
                "[system]\n{OSCILLATOR}\n[method]\nrealization = \"constant\"\ndynamics = {dynamics}\nepsilon = 0.5\n\
                 h = 0.4\n[run]\ninitial = [1.0, 0.0]\nsteps = 100\n"
            );
            end(&leafwise_tests::scenes::composed(&text))
        });
        let off = distance(&ends[0], &ends[1]);
        assert!(off <= round_off(100), "S_{}: {off:e}", 2 * count - 1);
    }
}

/// The turn is known: 2k coefficients give the order 2k.
#[test]
fn generating_functions_by_hand_have_the_order_that_they_claim() {
    for (count, steps) in [(1, [20, 30, 45, 68, 102]), (2, [10, 15, 22, 33, 50])] {
        let written: Vec<String> = TANGENT[..count]
            .iter()
            .map(|s| format!("\"{s}\""))
            .collect();
        let method = method(
            "\"constant\"",
            &format!(
                "{{ name = \"generating-function\", S = [{}] }}",
                written.join(", ")
            ),
        );
        let angle = 1.25 * 2.0;
        let exact = [libm::cos(angle), -libm::sin(angle)];
        let points: Vec<(f64, f64)> = steps
            .iter()
            .map(|steps| {
                let run = until(OSCILLATOR, &method, "[1.0, 0.0]", (2.0, *steps));
                (2.0 / *steps as f64, distance(&end(&run), &exact))
            })
            .collect();
        let measured = measure(&points, round_off(100), 2.0).expect("errors above round-off");
        assert!(measured.is(2.0 * count as f64, 1.0), "{measured:?}");
    }
}

/// The message of a scene that is refused, and what stands from the place on that it names.
fn refused(realization: &str, dynamics: &str) -> (String, String) {
    let text = format!(
        "[system]\n{BODY}\n[method]\n{}\ntime-step = 0.1\n[run]\ninitial = {BODY_START}\nsteps = 1\n",
        method(realization, dynamics)
    );
    let refusal = compose(&document(&text, &[]), &Registry::with_builtin())
        .map(drop)
        .expect_err("a mistake");
    let shown = refusal.to_string();
    let mut place = shown.split(':').skip(1);
    let mut number = || place.next().and_then(|n| n.parse::<usize>().ok());
    let (line, column) = number().zip(number()).expect("a place");
    let line = text.lines().nth(line - 1).expect("a line");
    (refusal.message.clone(), line[column - 1..].to_owned())
}

#[test]
fn mistakes_in_formulas_are_refused_where_they_stand() {
    let exact = closed_form(&cayley("1/4"), "");
    let of = |alpha: &str| refused(&closed_form(alpha, ""), ENERGY).0;
    // Names, lengths, the section, the tensor, the claim.
    assert!(of(&cayley("b")).contains("unknown name `b`"));
    assert!(of("[\"x\", \"y\"]").contains("alpha = [2 formulas]"));
    let off = of(&cayley("1/4").replace("\"y - ", "\"2*y - "));
    assert!(off.contains("alpha(x, 0) must be x"), "{off}");
    let other = of(&cayley("1/4").replace("/2 +", "/3 +"));
    assert!(other.contains("another tensor"), "{other}");
    let inexact = of(&cayley("1/3"));
    assert!(inexact.contains("claims to be exact"), "{inexact}");
    // A claim of what it is, of order 1, is none of exactness.
    let honest = format!(
        "[system]\n{BODY}\n[method]\n{}\ntime-step = 0.1\n[run]\ninitial = {BODY_START}\nsteps = 1\n",
        method(&closed_form(&cayley("1/3"), ", order = 1"), ENERGY)
    );
    assert!(compose(&document(&honest, &[]), &Registry::with_builtin()).is_ok());

    let of = |s: &str| {
        let dynamics = format!("{{ name = \"generating-function\", S = {s} }}");
        refused(&exact, &dynamics)
    };
    let (message, shown) = of("[\"H\", \"x*q\"]");
    assert!(message.contains("unknown name `q`"), "{message}");
    assert!(shown.starts_with("q\"]"), "{shown}");
    assert!(of("[\"2*H\"]").0.contains("another motion"));
    assert!(of("[]").0.contains("it needs `S`"));
    assert!(of("[\"H/0\"]").0.contains("division"));
    let dynamics = "{ name = \"generating-function\", S = [\"H\"], time-step = -0.1 }";
    let (message, _) = refused(&exact, dynamics);
    assert!(
        message.contains("time-step = -0.1 is not allowed"),
        "{message}"
    );
    let (message, _) = refused("{ name = \"closed-form\" }", ENERGY);
    assert!(message.contains("it needs `alpha`"), "{message}");
    let (message, _) = refused(&closed_form(&cayley("1/4"), ", order = -1"), ENERGY);
    assert!(message.contains("order = -1"), "{message}");
}

/// S_1 and H are formulas: what moves the system otherwise is refused, however small, at any value that the algebra
/// tells from 0; what does not is taken, written in whatever way.
#[test]
fn a_first_coefficient_is_the_hamiltonian_up_to_a_casimir() {
    let outcome = |system: &str, realization: &str, start: &str, s: &str| {
        let text = format!(
            "[system]\n{system}\n[method]\nrealization = {realization}\n\
             dynamics = {{ name = \"generating-function\", S = [\"{s}\"] }}\ntime-step = 0.1\n\
             [run]\ninitial = {start}\nsteps = 1\n"
        );
        let composed = compose(&document(&text, &[]), &Registry::with_builtin());
        composed
            .map(drop)
            .map_err(|refusal| refusal.message.clone())
    };
    let pendulum = OSCILLATOR.replace("w*(q^2 + p^2)/2", "p^2/2 + sin(2*q)");
    for exponent in 2..=20 {
        for (term, moved) in [
            ("q^3", "p"),
            ("p*q", "q"),
            ("sin(q)", "p"),
            ("w*exp(p)", "q"),
        ] {
            let s = format!("H + 1e-{exponent}*{term}");
            for system in [OSCILLATOR, &pendulum] {
                let message = outcome(system, "\"constant\"", "[1.0, 0.0]", &s);
                let message = message.expect_err(&s);
                assert!(message.contains("another motion"), "{message}");
                assert!(
                    message.contains(&format!("which moves {moved};")),
                    "{message}"
                );
            }
        }
    }
    for s in ["q*q*w/2 + p^2/2*w", "H + 3", "H + w^2"] {
        let taken = outcome(OSCILLATOR, "\"constant\"", "[1.0, 0.0]", s);
        assert_eq!(taken, Ok(()), "{s}");
    }
    let other = "p^2/2 + 2*sin(q)*cos(q)";
    assert_eq!(
        outcome(&pendulum, "\"constant\"", "[1.0, 0.0]", other),
        Ok(())
    );
    for s in ["H + (x^2 + y^2 + z^2)/7", "H + sqrt(x^2 + y^2 + z^2)"] {
        let exact = closed_form(&cayley("1/4"), "");
        assert_eq!(outcome(BODY, &exact, BODY_START, s), Ok(()), "{s}");
    }
}

/// A chart that ends where `domain` comes to 1, and β written beside α.
#[test]
fn the_domain_and_beta_are_the_scenes_too() {
    let beta = cayley("1/4").replace("- epsilon", "+ epsilon");
    let both = closed_form(&cayley("1/4"), &format!(", beta = {beta}"));
    // With its own beta a chart is not known to have odd generating functions.
    let collective = "\"collective\"";
    let ends = [both.as_str(), "\"so3-cayley\""].map(|realization| {
        let method = method(realization, collective);
        end(&until(BODY, &method, BODY_START, (5.0, 50)))
    });
    let off = distance(&ends[0], &ends[1]);
    // Each solve ends within a few roundings.
    assert!(off <= 8.0 * round_off(50), "{off:e}");

    let reach = "epsilon*sqrt(p_x^2 + p_y^2 + p_z^2)";
    let bounded = |radius: f64| {
        let domain = format!(", domain = \"{reach}/{radius:?}\"");
        let method = method(&closed_form(&cayley("1/4"), &domain), ENERGY);
        let run = until(BODY, &method, BODY_START, (0.1, 1));
        let mut walk = run.walk();
        walk.step()
    };
    assert!(bounded(1.0).is_ok());
    let error = bounded(0.01).expect_err("outside the chart").to_string();
    assert!(error.contains("chart"), "{error}");
}

/// A power of q − 1000 whose expansion cancels is taken as it is written: a quartic well about 1000 moves as about 0, to the round-off of q, 1e-13, and what a
/// hundred steps of 0.1 make of it: at most a hundred times as much each, for its frequency is below 1.
#[test]
fn a_well_far_from_zero_moves_as_about_zero() {
    let moved = |middle: f64| {
        let text = format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\nhamiltonian = \"p^2/2 + (q - {middle:?})^6/6\"\n\
             [method]\nrealization = \"constant\"\ndynamics = {{ name = \"generating-function\", S = [\"H\"] }}\ntime-step = 0.1\n\
             [run]\ninitial = [{:?}, 0]\nsteps = 100\n",
            middle + 0.5
        );
        let run = compose(&document(&text, &[]), &Registry::with_builtin()).expect("a run");
        let mut walk = run.walk();
        walk.advance(100).expect("steps");
        [walk.state()[0] - middle, walk.state()[1]]
    };
    let (near, far) = (moved(0.0), moved(1000.0));
    for (a, b) in near.iter().zip(far) {
        assert!((a - b).abs() < 1e-9, "{near:?} {far:?}");
    }
}

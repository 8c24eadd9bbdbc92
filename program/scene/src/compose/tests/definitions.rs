//! Names for formulas: what they stand for, and where a wrong one is underlined.

use std::fmt::Write as _;

use leafwise_core::Registry;
use leafwise_expression::syntax::DEPTH_LIMIT;

use super::{compose_system, document, refusal};
use crate::document::{SceneDocument, SceneProblemCause};

const PLANE: &str = "variables = [\"q\", \"p\"]\nparameters = { m = 2.0 }\n\
                     bracket = { \"q,p\" = \"-1\" }\n";
const START: &str = "initial = [0.5, 0.25]";

/// The piece of the scene that is underlined, and the message.
fn refused(system: &str, run: &str) -> (String, String) {
    let diagnostic = refusal(system, run);
    let piece = &diagnostic.source_text[diagnostic.span.clone()];
    (piece.to_owned(), diagnostic.message)
}

#[test]
fn a_name_stands_for_its_formula_wherever_formulas_stand() {
    let system = "variables = [\"q\", \"p\"]\nparameters = { m = 2.0 }\n\
                  define = { kinetic = \"p^2/double\", V = \"cos(angle)\", angle = \"q - shift\", \
                             double = \"2*m\", shift = 0.25, unit = \"-m/2\" }\n\
                  bracket = { \"q,p\" = \"unit\" }\n\
                  hamiltonian = \"kinetic - V\"\n\
                  casimirs = { mass = \"double\" }";
    let run = "initial = { q = \"shift + double\", p = \"m/4\" }\n\
               record = { observables = [\"energy\", \"angle\", \"kinetic/V\"] }";
    let composed = compose_system(&document(system, run)).expect("a system");
    assert_eq!(composed.initial, [4.25, 0.5]);
    let formulas = composed.system.expressions().expect("formulas");
    let (x, m) = (&composed.initial, [2.0]);
    assert_eq!(
        formulas.hamiltonian().evaluate(x, &m),
        0.0625 - libm::cos(4.0)
    );
    assert_eq!(formulas.casimirs()[0].expression.evaluate(x, &m), 4.0);
    assert_eq!(formulas.tensor()[&(0, 1)].evaluate(x, &m), -1.0);
    let names: Vec<&str> = composed.observables.iter().map(|o| o.name()).collect();
    assert_eq!(names, ["energy", "angle", "kinetic/V"]);
}

/// Sixty squares of sums: 2⁶⁰ copies of q where a name stood for its text.
#[test]
fn a_name_is_shared_and_not_written_out() {
    let mut define = "f0 = \"q\"".to_owned();
    for n in 1..=60 {
        let before = n - 1;
        write!(define, ", f{n} = \"f{before}^2/2 + f{before}/4 + 1/8\"").expect("a string");
    }
    let system = format!("{PLANE}define = {{ {define} }}\nhamiltonian = \"f60\"");
    let composed = compose_system(&document(&system, START)).expect("a system");
    let formulas = composed.system.expressions().expect("formulas");
    let by_hand = (0..60).fold(0.5, |f: f64, _| f * f / 2.0 + f / 4.0 + 0.125);
    let value = formulas.hamiltonian().evaluate(&composed.initial, &[2.0]);
    // The iteration contracts.
    assert!(
        (value - by_hand).abs() <= 4.0 * f64::EPSILON * by_hand,
        "{value}"
    );
    assert!(formulas.vector_field_kernel().is_ok());
}

#[test]
fn definitions_that_lead_back_to_themselves_are_refused() {
    let of = |define: &str| {
        let system = format!("{PLANE}define = {{ {define} }}\nhamiltonian = \"p^2\"");
        refused(&system, START)
    };
    let (piece, message) = of("a = \"q + a\"");
    assert_eq!(
        (piece.as_str(), message.as_str()),
        ("q + a", "`a` uses itself")
    );
    let (piece, message) = of("first = \"c\", a = \"b*2\", b = \"q + c\", c = \"sin(a)\"");
    assert_eq!(piece, "sin(a)");
    assert_eq!(message, "`c` is defined by itself, through `a`, `b`");
}

#[test]
fn names_that_are_taken_are_refused() {
    let problems = |define: &str| {
        let text = format!(
            "[system]\n{PLANE}define = {{ {define} }}\nhamiltonian = \"p^2\"\n\
             [method]\ntime-step = 0.1\n[run]\nsteps = 1\n{START}\n"
        );
        let errors = SceneDocument::parse("scene.toml", &text, &Registry::empty());
        let problem = errors.expect_err("refused").problems.remove(0);
        (text[problem.place.span.clone()].to_owned(), problem.cause)
    };
    for name in ["q", "m"] {
        let (piece, cause) = problems(&format!("{name} = \"1\""));
        assert_eq!(piece, name);
        assert!(
            matches!(cause, SceneProblemCause::Duplicate { .. }),
            "{cause}"
        );
    }
    let (piece, cause) = problems("\"a b\" = \"1\"");
    assert_eq!(piece, "\"a b\"");
    assert!(matches!(
        cause,
        SceneProblemCause::InvalidName {
            kind: "definition",
            ..
        }
    ));
    let (piece, cause) = problems("B = [1]");
    assert_eq!(piece, "[1]");
    assert!(matches!(cause, SceneProblemCause::WrongType { .. }));

    let of = |define: &str, more: &str| {
        let system = format!("{PLANE}define = {{ {define} }}\nhamiltonian = \"p^2\"\n{more}");
        refused(&system, START)
    };
    for name in ["sin", "pi", "N", "sum"] {
        let (piece, message) = of(&format!("{name} = \"1\""), "");
        assert_eq!(piece, name, "{message}");
        assert!(
            message.contains("reserved") || message.contains("taken"),
            "{message}"
        );
    }
    let (piece, message) = of("energy = \"p\"", "");
    assert_eq!(piece, "energy");
    assert!(
        message.contains("that is the Hamiltonian's value"),
        "{message}"
    );
    let (piece, message) = of("C = \"p\"", "casimirs = { C = \"2*m\" }");
    assert_eq!(piece, "C");
    assert!(message.contains("that is a Casimir"), "{message}");
    // A Casimir of the name, and no other.
    let named = format!(
        "{PLANE}define = {{ C = \"m\" }}\nhamiltonian = \"p^2\"\ncasimirs = {{ C = \"C\" }}"
    );
    compose_system(&document(&named, START)).expect("one meaning");
}

#[test]
fn a_wrong_formula_is_underlined_in_its_definition() {
    let of = |define: &str| {
        let system = format!("{PLANE}define = {{ {define} }}\nhamiltonian = \"p^2 + B\"");
        refused(&system, START)
    };
    let (piece, message) = of("A = \"q*2\", B = \"A + r\"");
    assert_eq!(
        (piece.as_str(), message.as_str()),
        ("r", "unknown name `r`")
    );
    let (piece, _) = of("B = \"q*(2\"");
    assert_eq!(piece, "");
    let (piece, message) = of("B = \"1/(q - q)\"");
    assert_eq!(piece, "1/(q - q)");
    assert!(message.contains("identically zero"), "{message}");
    let (piece, message) = of("A = 2, B = \"A[1]\"");
    assert_eq!(piece, "A[1");
    assert!(message.contains("not a family"), "{message}");
    let misspelt = format!("{PLANE}define = {{ field = \"q\" }}\nhamiltonian = \"p^2 + feild\"");
    let diagnostic = refusal(&misspelt, START);
    assert_eq!(diagnostic.help.as_deref(), Some("did you mean `field`?"));
}

#[test]
fn what_depends_on_the_state_is_no_initial_value() {
    let system = format!("{PLANE}define = {{ B = \"q*2\" }}\nhamiltonian = \"p^2 + B\"");
    let (piece, message) = refused(&system, "initial = { q = 1, p = \"B\" }");
    assert_eq!(piece, "B");
    assert!(message.contains("`B` depends on the state"), "{message}");
    let (piece, message) = refused(&system, "initial = { q = 1, B = 1, p = 2 }");
    assert_eq!(piece, "B");
    assert!(message.contains("not a state variable"), "{message}");
}

#[test]
fn a_definition_has_one_value_on_a_lattice() {
    let lattice = |define: &str, hamiltonian: &str| {
        format!(
            "families = {{ x = 40 }}\nparameters = {{ k = 0.5 }}\ndefine = {{ {define} }}\n\
             bracket = {{ \"x[i],x[i+1]\" = \"c*x[i]*x[i+1]\" }}\nhamiltonian = \"{hamiltonian}\""
        )
    };
    let run = "initial = { \"x[i]\" = \"1 + c\" }";
    let composed = compose_system(&document(&lattice("c = \"2*k\"", "sum(i, c*x[i])"), run));
    assert_eq!(composed.expect("a lattice").initial, vec![2.0; 40]);
    let (piece, message) = refused(&lattice("c = 1, s = \"x[i]^2\"", "s"), run);
    assert_eq!(piece, "x[i]^2");
    assert!(message.contains("another for every `i`"), "{message}");
    let (piece, message) = refused(&lattice("c = 1, s = \"sum(i, x[i] + y)\"", "c"), run);
    assert_eq!(
        (piece.as_str(), message.as_str()),
        ("y", "unknown name `y`")
    );
    let (_, message) = refused(&lattice("c = 1, s = \"x[0] + r\", r = \"s\"", "r"), run);
    assert!(
        message.contains("is defined by itself") || message.contains("uses itself"),
        "{message}"
    );
}

/// Definitions that sum over sites stand for their formulas, through others, under sums and in derivatives.
#[test]
fn definitions_of_families_are_written_out() {
    let lattice = |define: &str, hamiltonian: &str| {
        let scene = format!(
            "families = {{ x = 6 }}\nparameters = {{ k = 0.5 }}\ndefine = {{ {define} }}\n\
             bracket = {{ \"x[i],x[i+1]\" = \"x[i]*x[i+1]\" }}\nhamiltonian = \"{hamiltonian}\""
        );
        let composed = compose_system(&document(&scene, "initial = { \"x[i]\" = \"1 + i/3\" }"));
        let composed = composed.expect("a lattice");
        let formulas = composed.system.expressions().expect("formulas");
        formulas.hamiltonian().evaluate(&composed.initial, &[0.5])
    };
    let define = "mean = \"all/N\", all = \"sum(j, x[j])\", end = \"x[N-1]\"";
    let named = lattice(define, "sum(i, (x[i] - mean)^2) + end*D(mean, x[2])");
    let written = lattice(
        "c = 1",
        "sum(i, (x[i] - sum(j, x[j])/N)^2) + x[N-1]*D(sum(j, x[j])/N, x[2])",
    );
    assert_eq!(named, written);
    // x_i = 1 + i/3: Σ (x − mean)² = 35/18, and the last site is 8/3.
    assert!(
        (named - (35.0 / 18.0 + 8.0 / 18.0)).abs() < 1e-14,
        "{named}"
    );
}

#[test]
fn definitions_nest_as_deep_as_formulas() {
    let chain = |depth: usize| {
        let mut define = "f0 = \"q\"".to_owned();
        for n in 1..=depth {
            write!(define, ", f{n} = \"sin(f{})\"", n - 1).expect("a string");
        }
        format!("{PLANE}define = {{ {define} }}\nhamiltonian = \"p^2 + f{depth}\"")
    };
    compose_system(&document(&chain(DEPTH_LIMIT), START)).expect("deep enough");
    let (piece, message) = refused(&chain(2_000), START);
    assert_eq!(piece, format!("sin(f{DEPTH_LIMIT})"));
    assert!(message.contains("nested more than 200 levels"), "{message}");
}

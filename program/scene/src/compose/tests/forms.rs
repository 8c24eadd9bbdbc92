//! Tensors by forms and constraints against entries written by hand, and what makes none, underlined.

use leafwise_core::diagnostics::Verdict;
use leafwise_core::system::TensorSource;

use super::{TensorShape, compose_system, document, entries, refusal, tensor_shape};
use crate::compose::SceneChecks;

const START: &str = "initial = [0.5, 0.25, -0.7, 1.3]";
const FOUR: &str = "variables = [\"q1\", \"q2\", \"p1\", \"p2\"]\nhamiltonian = \"q1\"\n";

/// The piece of the scene that is underlined, the message and the advice.
fn refused(system: &str, run: &str) -> (String, String, String) {
    let diagnostic = refusal(system, run);
    let piece = &diagnostic.source_text[diagnostic.span.clone()];
    let help = diagnostic.help.unwrap_or_default();
    (piece.to_owned(), diagnostic.message, help)
}

/// {x_i, x_j} at a point.
type Entries = Vec<((usize, usize), f64)>;

/// Of the composed system at its initial state: the tensor's entries, its shape, and what checks say.
fn composed(system: &str, run: &str) -> (Entries, TensorShape, SceneChecks) {
    let composed = compose_system(&document(system, run)).expect("a system");
    let formulas = composed.system.expressions().expect("formulas");
    let x = &composed.initial;
    let values = composed.system.parameter_values();
    let tensor = formulas.tensor().iter();
    let tensor = tensor.map(|(at, entry)| (*at, entry.evaluate(x, &values)));
    let checks = SceneChecks::of(&composed.system, x).expect("derivatives");
    (tensor.collect(), tensor_shape(&composed.system), checks)
}

/// p dq is q' = ∂H/∂p, whichever sign the convention gives a bracket: {q, p} = −1 under ẋ = {H, x}.
#[test]
fn the_canonical_one_form_is_the_canonical_bracket() {
    let canonical = [((0, 2), -1.0), ((1, 3), -1.0)];
    for convention in ["{H,x}", "{x,H}"] {
        for form in [
            "one-form = [\"p1\", \"p2\", 0, 0]",
            // Less the differential of q1 p1 + q2 p2.
            "one-form = [0, 0, \"-q1\", \"-q2\"]",
            // And more that of sin(q1 p2) + q1^3/p1 + exp(q2)*q1.
            "one-form = [\"p1 + p2*cos(q1*p2) + 3*q1^2/p1 + exp(q2)\", \"p2 + exp(q2)*q1\", \
             \"-q1^3/p1^2\", \"q1*cos(q1*p2)\"]",
            "two-form = { \"q1,p1\" = -1, \"p2,q2\" = \"2 - 1\" }",
        ] {
            let text = format!("{FOUR}convention = \"{convention}\"\nbracket = {{ {form} }}");
            let (tensor, shape, checks) = composed(&text, START);
            assert_eq!(tensor, canonical, "{form}");
            assert_eq!(shape, TensorShape::Constant, "{form}");
            assert_eq!(checks.jacobi.verdict, Verdict::ByConstruction);
        }
    }
}

/// ω Π = −1 at a point, with ω differentiated by hand.
#[test]
fn a_dense_two_form_is_inverted() {
    // d of (q2 p1 + q1^2 p2, exp(q1) p2^2, q2^2, q1 q2 p1).
    let text = format!(
        "{FOUR}bracket = {{ one-form = [\"q2*p1 + q1^2*p2\", \"exp(q1)*p2^2\", \"q2^2\", \"q1*q2*p1\"] }}"
    );
    let (tensor, _, _) = composed(&text, START);
    let [q1, q2, p1, p2] = [0.5_f64, 0.25, -0.7, 1.3];
    let e = libm::exp(q1);
    // ω_ij above the diagonal.
    let omega = [
        ((0, 1), e * p2 * p2 - p1),
        ((0, 2), -q2),
        ((0, 3), q2 * p1 - q1 * q1),
        ((1, 2), 2.0 * q2),
        ((1, 3), q1 * p1 - 2.0 * e * p2),
        ((2, 3), q1 * q2),
    ];
    let whole = |above: &[((usize, usize), f64)]| {
        let mut whole = [[0.0; 4]; 4];
        for &((i, j), value) in above {
            (whole[i][j], whole[j][i]) = (value, -value);
        }
        whole
    };
    let (omega, tensor) = (whole(&omega), whole(&tensor));
    for i in 0..4 {
        for j in 0..4 {
            let product: f64 = (0..4).map(|k| omega[i][k] * tensor[k][j]).sum();
            let expected = if i == j { -1.0 } else { 0.0 };
            // Entries below 10, a dozen operations each.
            assert!((product - expected).abs() < 1e-13, "{i}, {j}: {product}");
        }
    }
}

/// dω = 0 of the entries in any order and sign; open ones are named with the component that is not 0.
#[test]
fn a_two_form_must_be_closed() {
    let of = |form: &str| format!("{FOUR}bracket = {{ two-form = {{ {form} }} }}");
    // ω = d(…) of the one-form above, some pairs the other way round.
    let closed = "\"q2,q1\" = \"p1 - exp(q1)*p2^2\", \"p1,q1\" = \"q2\", \"q1,p2\" = \"q2*p1 - q1^2\", \
                  \"q2,p1\" = \"2*q2\", \"q2,p2\" = \"q1*p1 - 2*exp(q1)*p2\", \"p1,p2\" = \"q1*q2\"";
    let (_, _, checks) = composed(&of(closed), START);
    assert_eq!(checks.jacobi.verdict, Verdict::ByConstruction);

    let (piece, message, help) = refused(&of("\"q1,p1\" = \"-1 - q2\", \"q2,p2\" = -1"), START);
    assert_eq!(piece, "\"q1,p1\"");
    assert!(
        message.contains(
            "dq1 ω(q2, p1) + dq2 ω(p1, q1) + dp1 ω(q1, q2) is 1.000e0 and not 0, at q1 = "
        ),
        "{message}"
    );
    assert!(help.contains("one-form"), "{help}");
    // 1 − cos²(q2) − sin²(q2) in a form that the ring does not decide: √(q2²) = q2 for q2 > 0.
    let undecided = of("\"q1,p1\" = \"-1 - (sqrt(q2^2) - q2)\", \"q2,p2\" = -1");
    let system = compose_system(&document(&undecided, START)).expect("closed here");
    let formulas = system.system.expressions().expect("formulas");
    match formulas.source() {
        TensorSource::TwoForm { is_proved } => {
            let checks = SceneChecks::of(&system.system, &system.initial).expect("derivatives");
            let expected = match is_proved {
                true => Verdict::ByConstruction,
                false => Verdict::NumericallyZero,
            };
            assert_eq!(checks.jacobi.verdict, expected);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn forms_of_the_wrong_size_are_refused() {
    let of = |form: &str| format!("{FOUR}bracket = {{ {form} }}");
    let (piece, message, help) = refused(&of("one-form = [\"p1\", \"p2\", 0]"), START);
    assert_eq!(piece, "{ one-form = [\"p1\", \"p2\", 0] }");
    assert!(
        message.contains("4 variables has 4 components, and this one has 3"),
        "{message}"
    );
    assert!(help.contains("q1, q2, p1, p2"), "{help}");
    let three = "variables = [\"x\", \"y\", \"z\"]\nhamiltonian = \"x\"\n";
    for form in [
        "one-form = [\"y\", \"z\", \"x\"]",
        "two-form = { \"x,y\" = 1 }",
    ] {
        let text = format!("{three}bracket = {{ {form} }}");
        let (_, message, _) = refused(&text, "initial = [1, 2, 3]");
        assert!(message.contains("3 variables has no inverse"), "{message}");
    }
    for (form, piece) in [
        ("one-form = [\"p1\", \"p2\", 0, \"q3\"]", "q3"),
        ("two-form = { \"q1,p3\" = 1 }", "p3"),
        ("two-form = { \"q1,p1\" = \"r\" }", "r"),
    ] {
        let (found, message, _) = refused(&of(form), START);
        assert_eq!(found, piece, "{message}");
        assert!(message.contains("unknown name"), "{message}");
    }
    let (piece, message, _) = refused(&of("two-form = { \"q1,q1\" = 1, \"q2,p2\" = 1 }"), START);
    assert_eq!(piece, "q1,q1");
    assert!(message.contains("ω(q1, q1) is not zero"), "{message}");
    let twice = of("two-form = { \"q1,p1\" = 1, \"p1,q1\" = 1, \"q2,p2\" = 1 }");
    let (_, message, _) = refused(&twice, START);
    assert!(
        message.contains("contradict each other about ω(q1, p1)"),
        "{message}"
    );
}

#[test]
fn degenerate_forms_are_refused() {
    let of = |form: &str| format!("{FOUR}bracket = {{ {form} }}");
    for form in [
        "one-form = [\"p1\", 0, 0, 0]",
        "one-form = [\"p1 + p2\", \"p1 + p2\", 0, 0]",
        "two-form = {}",
        // Its Pfaffian is cos² + sin² − 1.
        "two-form = { \"q1,p1\" = \"cos(q1)\", \"q2,p2\" = \"cos(q1)\", \"q1,q2\" = \"sin(q1)\", \
         \"p1,p2\" = \"-sin(q1)\", \"q1,p2\" = 1, \"q2,p1\" = 1 }",
    ] {
        let (piece, message, _) = refused(&of(form), START);
        let is_open = message.contains("not closed");
        assert!(message.contains("identically 0") || is_open, "{message}");
        assert!(
            piece.starts_with(if is_open { '"' } else { '{' }),
            "{piece}"
        );
    }
    let (piece, message, _) = refused(
        &of("one-form = [\"p1*q1\", \"p2\", 0, 0]"),
        "initial = [0, 1, 1, 1]",
    );
    assert_eq!(piece, "[0, 1, 1, 1]");
    assert!(message.contains("its Pfaffian is 0e0 there"), "{message}");
}

/// A pendulum of length 1 in Cartesian coordinates: Dirac's bracket of q² = 1, q·p = 0, by hand
/// {q_i, p_j} = s (δ_ij − q_i q_j/q²), {p_i, p_j} = s (p_i q_j − q_i p_j)/q² for the sign s of {q, p}.
#[test]
fn a_dirac_bracket_projects() {
    let constraints = "constraints = [\"q1^2 + q2^2 - 1\", \"q1*p1 + q2*p2\"]";
    let [q1, q2, p1, p2] = [0.5, 0.25, -0.7, 1.3];
    let square: f64 = q1 * q1 + q2 * q2;
    let expected = |s: f64| {
        [
            ((0, 2), s * (1.0 - q1 * q1 / square)),
            ((0, 3), -s * q1 * q2 / square),
            ((1, 2), -s * q1 * q2 / square),
            ((1, 3), s * (1.0 - q2 * q2 / square)),
            ((2, 3), s * (p1 * q2 - q1 * p2) / square),
        ]
    };
    for bracket in [
        "convention = \"{x,H}\"\nbracket = { \"q1,p1\" = 1, \"q2,p2\" = 1 }",
        "bracket = { \"q1,p1\" = -1, \"q2,p2\" = -1 }",
        "bracket = { one-form = [\"p1\", \"p2\", 0, 0] }",
    ] {
        let (tensor, _, checks) = composed(&format!("{FOUR}{bracket}\n{constraints}"), START);
        // In the paper's convention {q, p} = −1 moves by q' = ∂H/∂p.
        for (found, expected) in tensor.iter().zip(expected(-1.0)) {
            assert_eq!(found.0, expected.0);
            assert!(
                (found.1 - expected.1).abs() < 1e-15,
                "{found:?} {expected:?}"
            );
        }
        assert_eq!(tensor.len(), 5);
        assert_eq!(checks.jacobi.verdict, Verdict::ByConstruction);
        let names: Vec<&str> = checks.casimirs.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["q1^2 + q2^2 - 1", "q1*p1 + q2*p2"]);
        assert!(
            checks
                .casimirs
                .iter()
                .all(|c| c.check.verdict == Verdict::Proved)
        );
    }
}

/// What holds of Dirac's bracket is what holds of the bracket it is made of.
#[test]
fn a_dirac_bracket_of_what_is_none_is_none() {
    let broken =
        "bracket = { \"q1,p1\" = \"-1 - q2\", \"q2,p2\" = -1 }\nconstraints = [\"q1\", \"p1\"]";
    let (_, _, checks) = composed(&format!("{FOUR}{broken}"), START);
    assert_eq!(checks.jacobi.verdict, Verdict::Violated);
    assert!(!checks.pass());
}

#[test]
fn constraints_of_first_class_are_refused() {
    let of = |constraints: &str| {
        let text = format!(
            "{FOUR}bracket = {{ \"q1,p1\" = -1, \"q2,p2\" = -1 }}\nconstraints = [{constraints}]"
        );
        refused(&text, START)
    };
    let (piece, message, _) = of("\"q1\", \"q2\", \"p1\", \"q1^2\"");
    assert_eq!(piece, "\"q2\"");
    assert!(message.contains("of first class"), "{message}");
    let (piece, message, help) = of("\"q1 + q2\", \"p1\", \"p2\"");
    assert_eq!(piece, "\"q1 + q2\"");
    assert!(message.contains("not of second class"), "{message}");
    assert!(help.contains("combination"), "{help}");
    let (piece, _, _) = of("\"q1*(\"");
    assert_eq!(piece, "");
    // {q1, p1 q2} = −q2.
    let text = format!(
        "{FOUR}bracket = {{ \"q1,p1\" = -1, \"q2,p2\" = -1 }}\nconstraints = [\"q1\", \"p1*q2\"]"
    );
    let (piece, message, _) = refused(&text, "initial = [0.5, 0, -0.7, 1.3]");
    assert_eq!(piece, "[0.5, 0, -0.7, 1.3]");
    assert!(
        message.contains("the matrix of the constraints' brackets has no inverse"),
        "{message}"
    );
    let taken = format!("{text}\ncasimirs = {{ q1 = \"q1\" }}");
    let (piece, message, _) = refused(&taken, START);
    assert_eq!(piece, "\"q1\"");
    assert!(message.contains("the name of a Casimir"), "{message}");
}

#[test]
fn long_lattices_have_entries() {
    let text = "families = { x = 1100 }\nhamiltonian = \"sum(i, x[i])\"\n\
                bracket = { \"x[i],x[i+1]\" = \"x[i]*x[i+1]\" }\nconstraints = [\"x[0]\", \"x[1]\"]";
    let (_, message, _) = refused(text, "initial = { \"x[i]\" = 1 }");
    assert!(message.contains("more than 1024 coordinates"), "{message}");
}

/// Families that are written out: a ring of four pairs by the one-form Σ p_i dq_i.
#[test]
fn short_families_have_forms() {
    let zeros = ["0"; 4].join(", ");
    let momenta: Vec<String> = (0..4).map(|i| format!("\"p[{i}]\"")).collect();
    let text = format!(
        "families = {{ q = 4, p = 4 }}\nhamiltonian = \"sum(i, p[i]^2)\"\n\
         bracket = {{ one-form = [{}, {zeros}] }}",
        momenta.join(", ")
    );
    let by_entries = "families = { q = 4, p = 4 }\nhamiltonian = \"sum(i, p[i]^2)\"\n\
                      bracket = { \"q[i],p[i]\" = -1 }";
    let two_form = "families = { q = 4, p = 4 }\nhamiltonian = \"sum(i, p[i]^2)\"\n\
                    bracket = { two-form = { \"q[i],p[i]\" = -1 } }";
    let x = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
    assert_eq!(entries(&text, &x), entries(by_entries, &x));
    assert_eq!(entries(two_form, &x), entries(by_entries, &x));
}

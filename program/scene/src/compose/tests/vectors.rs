//! Families of vectors against families of their components.

use super::{compose_system, document, entries, refusal};
use crate::compose::SceneChecks;
use crate::document::SceneDocument;

const SPINS: &str = "families = { s = { components = [\"x\", \"y\", \"z\"], length = 2 } }\n";
const POINT: [f64; 6] = [0.5, 0.25, -0.7, 1.3, 0.4, 2.0];

/// so(3) at every site is each of its entries at every site; the state holds one component after the other.
#[test]
fn a_lie_algebra_stands_at_every_site() {
    let hamiltonian = "hamiltonian = \"sum(i, s.x[i]*s.y[i+1])\"\n";
    let algebra = format!("{SPINS}{hamiltonian}bracket = {{ lie-algebra = \"so3\" }}");
    let pairs = "{ \"s.x[i],s.y[i]\" = \"-s.z[i]\", \"s.y[i],s.z[i]\" = \"-s.x[i]\", \"s.z[i],s.x[i]\" = \"-s.y[i]\" }";
    let by_pairs = format!("{SPINS}{hamiltonian}bracket = {pairs}");
    assert_eq!(entries(&algebra, &POINT), entries(&by_pairs, &POINT));
    let composed = compose_system(&document(&algebra, &format!("initial = {POINT:?}")));
    let composed = composed.expect("a system");
    let names = ["s.x[0]", "s.x[1]", "s.y[0]", "s.y[1]", "s.z[0]", "s.z[1]"];
    assert_eq!(composed.system.variables(), names);
    assert!(
        SceneChecks::of(&composed.system, &POINT)
            .expect("derivatives")
            .pass()
    );
    let scalars = by_pairs
        .replace(SPINS, "families = { sx = 2, sy = 2, sz = 2 }\n")
        .replace("s.", "s");
    assert_eq!(entries(&by_pairs, &POINT), entries(&scalars, &POINT));
}

/// Vectors are a summand by their name, other families and variables are others.
#[test]
fn vectors_are_a_summand() {
    let scene = "variables = [\"a\"]\nfamilies = { q = 2, s = { components = [\"x\", \"y\", \"z\"], length = 2 }, p = 2 }\n\
                 hamiltonian = \"sum(i, q[i]*s.x[i]) + a\"\n\
                 bracket = { sum = [{ variables = [\"s\"], bracket = { lie-algebra = \"so3\" } }, \
                 { variables = [\"a\", \"p\", \"q\"], bracket = { \"q[i],p[i]\" = \"-1 - a\" } }] }";
    let point: Vec<f64> = (0..11).map(f64::from).collect();
    let found = entries(scene, &point);
    // a = 0, q, s.x at 3 and 4, s.y, s.z at 7 and 8, p at 9 and 10.
    let expected = [
        ((1, 9), -1.0),
        ((2, 10), -1.0),
        ((3, 5), -7.0),
        ((3, 7), 5.0),
        ((4, 6), -8.0),
        ((4, 8), 6.0),
        ((5, 7), -3.0),
        ((6, 8), -4.0),
    ];
    assert_eq!(found, expected);
}

fn refused(system: &str) -> (String, String) {
    let diagnostic = refusal(system, &format!("initial = {POINT:?}"));
    let piece = &diagnostic.source_text[diagnostic.span.clone()];
    (piece.to_owned(), diagnostic.message)
}

#[test]
fn what_does_not_fit_vectors_is_refused_where_it_stands() {
    let hamiltonian = "hamiltonian = \"sum(i, s.x[i])\"\n";
    let with =
        |families: &str| format!("{families}\n{hamiltonian}bracket = {{ lie-algebra = \"so3\" }}");
    let (piece, message) = refused(&with(
        "families = { s = { components = [\"x\", \"y\"], length = 3 } }",
    ));
    assert_eq!(piece, "so3");
    assert_eq!(
        message,
        "`so3` has dimension 3, and the vectors have 2 components"
    );
    let (piece, message) = refused(&with(
        "families = { s = { components = [\"x\", \"y\", \"z\"], length = 1 }, q = 3 }\nboundary = \"open\"",
    ));
    assert_eq!(piece, "q");
    assert!(message.contains("`q` is none"), "{message}");
    let unknown =
        format!("{SPINS}hamiltonian = \"sum(i, s.w[i])\"\nbracket = {{ lie-algebra = \"so3\" }}");
    let (piece, message) = refused(&unknown);
    assert_eq!(
        (piece.as_str(), message.as_str()),
        ("s.w", "unknown name `s.w`")
    );
    for (formula, expected) in [
        (
            "s[0]",
            "its components are s.x, s.y, s.z: write one, such as s.x, or dot(a, b), a number of two vectors, or norm(a)",
        ),
        (
            "s[0].x",
            "`s` is a family of vectors with the components s.x, s.y, s.z: write s.x[i]",
        ),
    ] {
        let scene = unknown.replace("sum(i, s.w[i])", formula);
        let help = refusal(&scene, &format!("initial = {POINT:?}")).help;
        assert_eq!(help.as_deref(), Some(expected), "{formula}");
    }
}

#[test]
fn the_reader_names_what_is_wrong_with_a_family() {
    for (family, piece, message) in [
        ("{ length = 3 }", "{ length = 3 }", "s needs `components`"),
        (
            "{ components = [\"x\", \"x\"], length = 3 }",
            "\"x\"",
            "`x` is declared twice",
        ),
        (
            "{ components = [\"x\", \"1\"], length = 3 }",
            "\"1\"",
            "`1` cannot name a component",
        ),
        (
            "{ components = [], length = 3 }",
            "[]",
            "components has no entry, expected at least one name",
        ),
        (
            "{ components = [\"x\"], length = 0 }",
            "0",
            "`length` must be a whole number of at least 1, found 0",
        ),
        (
            "{ components = [\"x\"], length = 2, sites = 2 }",
            "sites",
            "unknown key `sites` in s",
        ),
    ] {
        let text = format!(
            "[system]\nfamilies = {{ s = {family} }}\nbracket = {{}}\nhamiltonian = \"0\"\n[method]\ntime-step = 0.1\n\
             [run]\nsteps = 1\ninitial = {{}}\n"
        );
        let registry = leafwise_core::Registry::empty();
        let errors = SceneDocument::parse("scene.toml", &text, &registry).expect_err("a problem");
        let found: Vec<(String, String)> = errors
            .diagnostics()
            .into_iter()
            .map(|found| (text[found.span.clone()].to_owned(), found.message))
            .collect();
        let expected = (piece.to_owned(), message.to_owned());
        assert!(found.contains(&expected), "{family}: {found:?}");
    }
}

/// Beside vectors `norm` is the length of one and cannot be the name of anything else; without any it may.
#[test]
fn functions_of_vectors_are_no_names_beside_vectors() {
    for name in ["norm", "dot", "cross"] {
        let scene = format!(
            "{SPINS}parameters = {{ {name} = 2 }}\nhamiltonian = \"sum(i, {name}*s.x[i])\"\nbracket = {{ lie-algebra = \"so3\" }}"
        );
        let (piece, message) = refused(&scene);
        assert_eq!(piece, name);
        assert!(message.contains("reserved"), "{message}");
        let alone = format!(
            "variables = [\"q\", \"p\"]\nparameters = {{ {name} = 2 }}\nhamiltonian = \"p^2 + {name}*q\"\n\
             bracket = {{ \"q,p\" = \"1\" }}"
        );
        assert_eq!(entries(&alone, &[0.0, 1.0]).len(), 1);
    }
}

/// A vector called t hides the time, as a variable does.
#[test]
fn a_vector_may_be_called_t() {
    let of = |name: &str| {
        let scene = format!(
            "variables = {{ {name} = [\"x\", \"y\", \"z\"] }}\nhamiltonian = \"dot({name}, {name})/2 + {name}.x\"\n\
             bracket = {{ lie-algebra = \"so3\" }}"
        );
        entries(&scene, &[0.5, 0.25, -0.75])
    };
    assert_eq!(of("t"), of("s"));
}

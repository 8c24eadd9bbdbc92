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
    assert!(message.contains("`q` is not a vector"), "{message}");
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

/// The magnetization as a definition of a vector is its formula, whatever names it.
#[test]
fn a_definition_may_be_a_vector_of_a_lattice() {
    let scene = |define: &str, hamiltonian: &str| {
        format!(
            "{SPINS}{define}hamiltonian = \"{hamiltonian}\"\nbracket = {{ lie-algebra = \"so3\" }}"
        )
    };
    let value = |scene: &str| {
        let composed = compose_system(&document(scene, &format!("initial = {POINT:?}")));
        let composed = composed.expect("a system");
        let formulas = composed.system.expressions().expect("formulas");
        formulas.hamiltonian().evaluate(&POINT, &[])
    };
    let defined = scene(
        "define = { M = \"sum(i, s[i])\", d = \"s[0] - s[1]\" }\n",
        "dot(M, M)/2 + M.z + norm(d)",
    );
    let [a, b, c] = [0, 2, 4].map(|at| POINT[at] + POINT[at + 1]);
    let distance = [0, 2, 4].map(|at| POINT[at] - POINT[at + 1]);
    let distance = distance.map(|d| d * d);
    let expected = (a * a + b * b + c * c) / 2.0 + c + libm::sqrt(distance.iter().sum());
    assert!((value(&defined) - expected).abs() < 1e-14 * expected);
    let run = format!("initial = {POINT:?}\nrecord = {{ observables = [\"M\"] }}");
    let composed = compose_system(&document(&defined, &run)).expect("a system");
    let names: Vec<&str> = composed.observables.iter().map(|o| o.name()).collect();
    assert_eq!(names, ["M.x", "M.y", "M.z"]);
}

/// Vectors of any number of named components are defined and recorded by their own letters.
#[test]
fn vectors_have_four_components() {
    let scene = "variables = { r = [\"a\", \"b\", \"c\", \"d\"], p = [\"a\", \"b\", \"c\", \"d\"] }\n\
                 define = { s = \"r - 2*p\" }\nbracket = \"canonical\"\nhamiltonian = \"dot(s, s) + s.d\"";
    let run = "initial = { r = [1, 2, 3, 4], p = [5, 6, 7, 8] }\nrecord = { observables = [\"s\", { twice = \"2*r\" }] }";
    let composed = compose_system(&document(scene, run)).expect("a system");
    let formulas = composed.system.expressions().expect("formulas");
    // s = −(9, 10, 11, 12).
    let value = formulas.hamiltonian().evaluate(&composed.initial, &[]);
    assert_eq!(value, 81.0 + 100.0 + 121.0 + 144.0 - 12.0);
    let names: Vec<&str> = composed.observables.iter().map(|o| o.name()).collect();
    assert_eq!(
        names,
        [
            "s.a", "s.b", "s.c", "s.d", "twice.a", "twice.b", "twice.c", "twice.d"
        ]
    );
}

const BODY: &str = "variables = { r = 3, p = 3 }\nbracket = \"canonical\"\nhamiltonian = \"dot(p, p)/2 + dot(r, r)/2\"";
const START: &str = "initial = { r = [1, \"1 + 1\", 3], p = [4, 5, 6] }";

fn problems(system: &str, run: &str) -> Vec<(String, String, Option<String>)> {
    let text = format!(
        "[system]\n{system}\n[method]\nrealization = \"auto\"\ndynamics = \"auto\"\ntime-step = 0.1\n\
         [run]\nsteps = 1\n{run}\n"
    );
    let registry = leafwise_core::Registry::empty();
    let errors = SceneDocument::parse("scene.toml", &text, &registry).expect_err("a problem");
    let told = errors.diagnostics().into_iter().map(|found| {
        (
            text[found.span.clone()].to_owned(),
            found.message,
            found.help,
        )
    });
    told.collect()
}

/// A component beside its whole vector would hide a part of it, of forces and of initial values.
#[test]
fn a_vector_and_one_of_its_components_are_not_both_given() {
    let force = format!("{BODY}\nforces = {{ p = \"-0.1*p\", \"p.x\" = \"1\" }}");
    let sites = format!(
        "{SPINS}bracket = {{ lie-algebra = \"so3\" }}\nhamiltonian = \"sum(i, s.x[i])\"\n\
         forces = {{ \"s.y[ i ]\" = \"1\", \"s[i]\" = \"-s[i]\" }}"
    );
    let twice = "initial = { r = [1, 2, 3], \"r.z\" = 4, p = [4, 5, 6] }";
    for (found, vector, component) in [
        (problems(&force, START), "p", "p.x"),
        (
            problems(&sites, "initial = [1, 2, 3, 4, 5, 6]"),
            "s[i]",
            "s.y[ i ]",
        ),
        (problems(BODY, twice), "r", "r.z"),
    ] {
        let [(piece, message, help)] = &found[..] else {
            panic!("{found:?}");
        };
        assert_eq!(piece.trim_matches('"'), component);
        assert_eq!(
            message,
            &format!("`{component}` cannot be combined with `{vector}`")
        );
        let help = help.as_deref().unwrap_or_default();
        assert!(help.contains(&format!("`{vector}` stands for")), "{help}");
    }
}

/// Vectors of letters that no pair has are named as the scene names them.
#[test]
fn the_message_of_no_pair_names_the_vectors() {
    let scene = "variables = { u = 3, w = 3, q = [\"a\"], p = [\"a\"] }\nbracket = \"canonical\"\nhamiltonian = \"dot(w, w)\"";
    let found = problems(scene, "initial = [1, 2, 3, 4, 5, 6, 7, 8]");
    let [(_, message, help)] = &found[..] else {
        panic!("{found:?}");
    };
    assert_eq!(
        message,
        "no variable is the momentum or the coordinate of `u` by its name"
    );
    let help = help.as_deref().unwrap_or_default();
    assert!(
        help.ends_with("bracket = { canonical = [[\"u\", \"w\"], …] }"),
        "{help}"
    );
}

/// A component is set as a key of its own, in the list of its vector or beside formulas, and at a site.
#[test]
fn components_are_set_by_their_names() {
    let initial = |system: &str, run: &str, set: &[(&str, &str)]| {
        let text = format!(
            "[system]\n{system}\n[method]\nrealization = \"auto\"\ndynamics = \"auto\"\ntime-step = 0.1\n\
             [run]\nsteps = 1\n{run}\n"
        );
        let set: Vec<_> = set
            .iter()
            .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
            .collect();
        let registry = leafwise_core::Registry::empty();
        let document = SceneDocument::parse_with("scene.toml", &text, &set, &registry);
        let document = document.unwrap_or_else(|errors| panic!("{:?}", errors.diagnostics()));
        compose_system(&document).expect("a system").initial
    };
    let set = [("run.initial.r.x", "7"), ("run.initial.p.z", "3/4")];
    assert_eq!(initial(BODY, START, &set), [7.0, 2.0, 3.0, 4.0, 5.0, 0.75]);
    let single = "initial = { \"r.x\" = 1, \"r.y\" = 2, \"r.z\" = 3, p = [4, 5, 6] }";
    assert_eq!(initial(BODY, single, &set), [7.0, 2.0, 3.0, 4.0, 5.0, 0.75]);
    let lattice =
        format!("{SPINS}bracket = {{ lie-algebra = \"so3\" }}\nhamiltonian = \"sum(i, s.x[i])\"");
    let run = "initial = { \"s[i]\" = [1, 2, 3], \"s[1]\" = [4, 5, 6] }";
    let set = [("run.initial.s.y[1]", "7"), ("run.initial.s.z[0]", "8")];
    assert_eq!(initial(&lattice, run, &set), [1.0, 4.0, 2.0, 7.0, 8.0, 6.0]);
}

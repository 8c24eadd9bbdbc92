//! The ways to write a bracket agree, and what contradicts itself is refused where it stands.

mod advice;
mod bodies;
mod columns;
mod definitions;
mod forms;
mod initial;
mod matrices;
mod pairs;
mod planes;
mod sites;
mod sums;
mod vectors;

use super::geometry::geometry;
use leafwise_core::{Evaluator, Registry};
use leafwise_hamilton_jacobi as _;
use leafwise_karasev as _;

use super::{TensorShape, compose, compose_system, instantiate, tensor_shape};
use crate::diagnostic::SceneDiagnostic;
use crate::document::SceneDocument;

fn document(system: &str, run: &str) -> SceneDocument {
    let text = format!(
        "[system]\n{system}\n[method]\nrealization = \"auto\"\ndynamics = \"auto\"\n\
         time-step = 0.1\n[run]\nsteps = 1\n{run}\n"
    );
    SceneDocument::parse("scene.toml", &text, &Registry::empty())
        .unwrap_or_else(|errors| panic!("{:?}", errors.diagnostics()))
}

fn entries(system: &str, point: &[f64]) -> Vec<((usize, usize), f64)> {
    let initial = format!("initial = {point:?}");
    let composed = compose_system(&document(system, &initial)).expect("a system");
    let system = &composed.system;
    system
        .expressions()
        .expect("formulas")
        .tensor()
        .iter()
        .map(|(at, entry)| (*at, entry.evaluate(point, &system.parameter_values())))
        .filter(|(_, value)| *value != 0.0)
        .collect()
}

fn refusal(system: &str, run: &str) -> SceneDiagnostic {
    *compose_system(&document(system, run)).expect_err("a refusal")
}

#[test]
fn named_brackets_are_their_entries() {
    let x = [0.3, 1.7, -2.5];
    let three = "variables = [\"x\", \"y\", \"z\"]\nhamiltonian = \"x\"\n";
    let named = entries(&format!("{three}bracket = {{ lie-algebra = \"so3\" }}"), &x);
    let written = "bracket = { \"x,y\" = \"-z\", \"y,z\" = \"-x\", \"z,x\" = \"-y\" }";
    assert_eq!(named, entries(&format!("{three}{written}"), &x));
    assert_eq!(named, [((0, 1), 2.5), ((0, 2), 1.7), ((1, 2), -0.3)]);

    let named = "bracket = { log-canonical = [[0, 2, 0.5], [-2, 0, -1], [-0.5, 1, 0]] }";
    let written = "bracket = { \"x,y\" = \"2*x*y\", \"x,z\" = \"x*z/2\", \"z,y\" = \"y*z\" }";
    assert_eq!(
        entries(&format!("{three}{named}"), &x),
        entries(&format!("{three}{written}"), &x)
    );
}

/// The paper's Example 3 is the bracket of the field −(y, −z, x²) under its convention.
#[test]
fn a_magnetic_field_is_the_papers_third_example_but_for_its_sign() {
    let six = "variables = [\"x\", \"y\", \"z\", \"px\", \"py\", \"pz\"]\nhamiltonian = \"px\"\n";
    let named = format!("{six}bracket = {{ magnetic-field = [\"-y\", \"z\", \"-x^2\"] }}");
    let written = format!(
        "{six}bracket = {{ \"x,px\" = -1, \"y,py\" = -1, \"z,pz\" = -1, \"px,py\" = \"x^2\", \
         \"px,pz\" = \"z\", \"py,pz\" = \"y\" }}"
    );
    let point = [1.5, -0.5, 2.0, 0.0, 0.0, 0.0];
    assert_eq!(entries(&named, &point), entries(&written, &point));
}

/// x' = v and v' = v × B − ∇V under both conventions, in space and in the plane.
#[test]
fn a_magnetic_field_bends_a_positive_charge_under_both_conventions() {
    for convention in ["{H,x}", "{x,H}"] {
        let field = |text: &str, x: &[f64]| {
            let text = format!("{text}\nconvention = \"{convention}\"");
            let initial = format!("initial = {x:?}");
            let system = compose_system(&document(&text, &initial))
                .expect("a system")
                .system;
            let map = system.field_values().expect("code");
            let mut value = vec![0.0; x.len()];
            map.evaluator(&[], 1.0, 1.0)
                .values(x, &mut value)
                .expect("a value");
            value
        };
        let space = "variables = [\"x\", \"y\", \"z\", \"vx\", \"vy\", \"vz\"]\n\
                     bracket = { magnetic-field = [\"2\", \"3*z\", \"1 + x^2\"] }\n\
                     hamiltonian = \"(vx^2 + vy^2 + vz^2)/2 + 5*x\"";
        let [x, z, vx, vy, vz] = [0.5, -0.25, 1.5, -2.0, 0.75];
        let [bx, by, bz] = [2.0, 3.0 * z, 1.0 + x * x];
        let force = [
            vy * bz - vz * by - 5.0,
            vz * bx - vx * bz,
            vx * by - vy * bx,
        ];
        assert_eq!(
            field(space, &[x, 0.0, z, vx, vy, vz]),
            [[vx, vy, vz], force].concat(),
            "{convention}"
        );
        let plane = "variables = [\"x\", \"y\", \"vx\", \"vy\"]\n\
                     bracket = { magnetic-field = [\"1 + x\"] }\nhamiltonian = \"(vx^2 + vy^2)/2\"";
        assert_eq!(
            field(plane, &[x, 0.0, vx, vy]),
            [vx, vy, vy * (1.0 + x), -vx * (1.0 + x)],
            "{convention}"
        );
    }
}

#[test]
fn antisymmetric_repetition_is_harmless_and_contradiction_names_both_entries() {
    let two = "variables = [\"x\", \"y\"]\nhamiltonian = \"x\"\n";
    let run = "initial = [1, 1]";
    let harmless = "bracket = { \"x,y\" = \"x*(x + y)\", \"y,x\" = \"-x^2 - x*y\" }";
    compose_system(&document(&format!("{two}{harmless}"), run)).expect("consistent");
    let diagnostic = refusal(
        &format!("{two}bracket = {{ \"x,y\" = \"x\", \"y,x\" = \"x\" }}"),
        run,
    );
    assert!(diagnostic.message.contains("`x,y`") && diagnostic.message.contains("`y,x`"));
    assert_eq!(diagnostic.line_column(), (4, 27));
    let diagnostic = refusal(&format!("{two}bracket = {{ \"x,x\" = \"y\" }}"), run);
    assert_eq!(diagnostic.line_column(), (4, 14));
}

#[test]
fn a_matrix_that_is_not_antisymmetric_is_refused_at_its_entry() {
    let two = "variables = [\"x\", \"y\"]\nhamiltonian = \"x\"\n";
    let diagnostic = refusal(
        &format!("{two}bracket = {{ log-canonical = [[0, 2], [2, 0]] }}"),
        "initial = [1, 1]",
    );
    assert_eq!(diagnostic.line_column(), (4, 39));
}

#[test]
fn a_lattice_is_its_template_at_every_site() {
    let lattice = "families = { x = 5 }\nhamiltonian = \"sum(i, x[i])\"\n\
                   bracket = { \"x[i],x[i+1]\" = \"x[i]*x[i+1]\" }\nboundary = \"BOUNDARY\"";
    let initial = "initial = { \"x[i]\" = \"i + N\", \"x[2]\" = \"-1\" }";
    let count = |boundary: &str, lengths: &[usize]| {
        let document = document(&lattice.replace("BOUNDARY", boundary), initial);
        let composed = compose_system(&document).expect("a lattice");
        assert_eq!(composed.initial, [5.0, 6.0, -1.0, 8.0, 9.0]);
        instantiate(&document, &geometry(&document).resized(lengths))
            .expect("a proxy")
            .bracket
            .len()
    };
    assert_eq!(count("periodic", &[5]), 5);
    assert_eq!(count("open", &[5]), 4);
    assert_eq!(count("periodic", &[8]), 8);
    let short = document(&lattice.replace("BOUNDARY", "periodic"), initial);
    let diagnostic = *instantiate(&short, &geometry(&short).resized(&[2]))
        .expect_err("a ring of two meets itself");
    assert!(diagnostic.message.contains("two different values"));
}

#[test]
fn an_initial_field_outside_its_domain_names_the_site() {
    let lattice = "families = { x = 6 }\nhamiltonian = \"sum(i, x[i])\"\n\
                   bracket = { \"x[i],x[i+1]\" = \"x[i]*x[i+1]\" }";
    let diagnostic = refusal(lattice, "initial = { \"x[i]\" = \"ln(3 - i)\" }");
    assert!(
        diagnostic.message.contains("x[3] is infinite"),
        "{}",
        diagnostic.message
    );
    assert_eq!(diagnostic.line_column().0, 11);
    let diagnostic = refusal(lattice, "initial = { \"x[0]\" = 1 }");
    assert!(diagnostic.message.contains("no value for x[1]"));
}

#[test]
fn shapes_are_read_off_the_normal_form() {
    let shape = |bracket: &str| {
        let system = format!(
            "variables = [\"x\", \"y\", \"z\"]\nparameters = {{ a = 2 }}\nhamiltonian = \"x\"\n\
             bracket = {{ \"x,y\" = \"{bracket}\" }}"
        );
        tensor_shape(
            &compose_system(&document(&system, "initial = [1, 1, 1]"))
                .unwrap()
                .system,
        )
    };
    assert_eq!(shape("x - x"), TensorShape::Zero);
    assert_eq!(shape("a^2"), TensorShape::Constant);
    assert_eq!(shape("a*z + (x+1)^2 - x^2 - 1"), TensorShape::Linear);
    assert_eq!(shape("a*x*y"), TensorShape::LogCanonical);
    assert_eq!(shape("x*y + 1"), TensorShape::Polynomial(2));
    assert_eq!(shape("z^3"), TensorShape::Polynomial(3));
    assert_eq!(shape("exp(z)"), TensorShape::General);
    assert_eq!(shape("1/z"), TensorShape::General);
}

#[test]
fn parts_left_open_are_chosen_with_matching_orders() {
    let system = "variables = [\"x\", \"y\"]\nhamiltonian = \"x^2 + y^2\"\n\
                  bracket = { \"x,y\" = \"1\" }";
    let run = compose(
        &document(system, "initial = [1, 1]"),
        &Registry::with_builtin(),
    )
    .expect("a run");
    assert_eq!(run.method.declared_order(), 4);
    assert!(run.plan.parts.iter().all(|part| part.is_automatic));
}

/// so(3) by its structure constants, and acting on vectors by its adjoint representation: the heavy top's bracket.
#[test]
fn structure_constants_and_representations_are_the_named_brackets() {
    let system = |n: usize, algebra: &str| {
        let names: Vec<String> = (0..n).map(|i| format!("\"x{i}\"")).collect();
        let names = names.join(", ");
        format!(
            "variables = [{names}]\nhamiltonian = \"x0\"\nbracket = {{ lie-algebra = {algebra} }}"
        )
    };
    let x = [0.3, 1.7, -2.5, 0.9, -0.4, 1.1];
    let of = |n: usize, algebra: &str| entries(&system(n, algebra), &x[..n]);
    // Pairs in either order, a triple twice, a zero.
    let so3 =
        "structure = [[1, 2, 3, 1], [3, 2, 1, -1.0], [3, 1, 2, 1], [1, 3, 2, -1], [1, 1, 2, 0]]";
    assert_eq!(of(3, &format!("{{ {so3} }}")), of(3, "\"so3\""));
    assert_eq!(of(3, "{ name = \"so3\" }"), of(3, "\"so3\""));
    let adjoint = "representation = [[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]], \
                   [[0, -1, 0], [1, 0, 0], [0, 0, 0]]]";
    assert_eq!(of(6, &format!("{{ {so3}, {adjoint} }}")), of(6, "\"e3\""));
    assert_eq!(
        of(6, &format!("{{ name = \"so3\", {adjoint} }}")),
        of(6, "\"e3\"")
    );
    // The rotations of the plane act on it.
    let plane = "{ structure = [], representation = [[[0, -1], [1, 0]]] }";
    assert_eq!(of(3, plane), of(3, "\"se2\""));
}

#[test]
fn what_is_no_algebra_and_no_representation_is_refused_where_it_stands() {
    let refused = |algebra: &str| {
        let system = format!(
            "variables = [\"x\", \"y\", \"z\"]\nhamiltonian = \"x\"\nbracket = {{ lie-algebra = {algebra} }}"
        );
        let error = refusal(&system, "initial = [1, 2, 3]");
        let place = error.span.clone();
        (
            error.source_text[place].to_owned(),
            error.message,
            error.help,
        )
    };
    let (at, message, _) = refused("{ structure = [[1, 2, 4, 1]] }");
    assert_eq!((&*at, &*message), ("4", "there is no e4 among 3"));
    let (at, message, _) = refused("{ structure = [[1, 1, 2, 1]] }");
    assert_eq!((&*at, &*message), ("[1, 1, 2, 1]", "[e1, e1] is not zero"));
    let (at, message, _) = refused("{ structure = [[1, 2, 3, 1], [2, 1, 3, 1]] }");
    assert_eq!(at, "[2, 1, 3, 1]");
    assert_eq!(
        message,
        "[e1, e2] has two different coefficients of e3: 1 and -1"
    );
    let (at, message, help) = refused("{ name = \"so3\", representation = [[[0]], [[0]], [[0]]] }");
    assert_eq!(at, "so3");
    assert_eq!(
        message,
        "`so3` has dimension 3, acts on 1 coordinates of vectors, and this scene has 3 variables"
    );
    assert_eq!(
        help.as_deref(),
        Some("for example: variables = [\"x1\", \"x2\", \"x3\", \"v1\"]")
    );
    let (at, message, _) = refused("{ structure = [[1, 2, 2, 1]], representation = [[[1]]] }");
    assert_eq!(
        (&*at, &*message),
        ("[[[1]]]", "1 matrices for an algebra of dimension 2")
    );
    let (at, message, _) =
        refused("{ structure = [], representation = [[[1]], [[1, 2], [3, 4]]] }");
    assert_eq!(at, "[[1, 2], [3, 4]]");
    assert_eq!(message, "this matrix has 2 rows, and the first has 1");
    let (at, message, _) =
        refused("{ structure = [[1, 2, 1, 1]], representation = [[[1]], [[1]]] }");
    assert_eq!(at, "[[[1]], [[1]]]");
    assert!(
        message.starts_with("this is not a representation: in row 1, column 1"),
        "{message}"
    );
}

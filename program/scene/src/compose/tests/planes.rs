//! Lattices of several axes: what is read, and what is refused where it stands.

use leafwise_core::Registry;

use super::{compose_system, document, refusal};
use crate::compose::Observable;
use crate::document::SceneDocument;

const INITIAL: &str = "initial = { \"x[i,j]\" = \"10*i + j\", \"x[1,2]\" = -1 }";

fn plane(lengths: &str, boundary: &str, hamiltonian: &str) -> String {
    format!(
        "families = {{ x = {lengths} }}\nboundary = {boundary}\nbracket = {{ \"x[i,j],x[i,j+1]\" = \"1\" }}\n\
         hamiltonian = \"{hamiltonian}\""
    )
}

/// A plane has a bond for each pair of neighbours along an axis; a row closes or ends as it is told.
#[test]
fn a_plane_is_its_template_at_every_site() {
    for (boundary, entries) in [
        ("\"periodic\"", 3 * 5),
        ("[\"open\", \"periodic\"]", 3 * 5),
        ("\"open\"", 3 * 4),
        ("[\"periodic\", \"open\"]", 3 * 4),
    ] {
        let text = plane("[3, 5]", boundary, "sum(i, j, x[i,j]*x[i+1,j])");
        let composed = compose_system(&document(&text, INITIAL)).expect("a plane");
        let formulas = composed.system.expressions().expect("formulas");
        assert_eq!(formulas.tensor().len(), entries, "{boundary}");
        assert_eq!(
            composed.initial[..8],
            [0.0, 1.0, 2.0, 3.0, 4.0, 10.0, 11.0, -1.0]
        );
        assert_eq!(formulas.variables()[7], "x[1,2]");
    }
}

/// One length in a list is a chain.
#[test]
fn a_list_of_one_length_is_a_chain() {
    let text = "families = { x = [6] }\nbracket = { \"x[i],x[i+1]\" = \"1\" }\nhamiltonian = \"sum(i, x[i]/N)\"";
    let composed = compose_system(&document(text, "initial = { \"x[i]\" = \"i\" }"));
    assert_eq!(composed.expect("a chain").initial.len(), 6);
}

#[test]
fn what_does_not_fit_the_axes_is_refused_where_it_stands() {
    let sum = "sum(i, j, x[i,j]^2)";
    for (text, message) in [
        (
            plane("[4, 5]", "\"open\"", "sum(i, x[i]^2)"),
            "`x` has 2 axes, and 1 is written here",
        ),
        (
            plane("[4, 5]", "\"open\"", "sum(i, j, x[i,j])/N"),
            "`N` as a number is the length of a chain",
        ),
        (
            plane("[4, 5]", "\"open\"", "sum(i, j, x[j,i]*x[i,j])"),
            "the index `i` counts along an axis of 5 sites and along one of 4",
        ),
        (
            plane("[4, 5]", "\"open\"", "x[4,0]"),
            "`x` has the sites 0 to 3 along axis 0, not 4",
        ),
    ] {
        let refused = refusal(&text, INITIAL);
        assert!(refused.message.starts_with(message), "{}", refused.message);
    }
    for (text, message) in [
        (plane("[4, 5, 6, 7]", "\"open\"", sum), "1 to 3 axes"),
        (plane("[]", "\"open\"", sum), "the number of sites, as 64"),
        (
            plane("[100000, 100000]", "\"open\"", sum),
            "at most 100000000 sites",
        ),
        (
            plane("[4, 5]", "[\"open\", \"open\", \"open\"]", sum),
            "one for each of the 2",
        ),
        (
            plane("[4, 5], y = [4, 6]", "\"open\"", sum),
            "all families have the same",
        ),
        (
            plane("[4, 5], y = 20", "\"open\"", sum),
            "all families have the same",
        ),
    ] {
        let text = format!(
            "[system]\n{text}\n[method]\nrealization = \"auto\"\ndynamics = \"auto\"\ntime-step = 0.1\n[run]\nsteps = 1\n{INITIAL}\n"
        );
        let errors = SceneDocument::parse("a.toml", &text, &Registry::empty()).expect_err(message);
        let errors = format!("{:?}", errors.diagnostics());
        assert!(errors.contains(message), "{errors}");
    }
}

/// A single coordinate is a column of its own on every lattice that is stepped by templates, also where it is no longer than what is
/// written out of it; what else is recorded are functions.
#[test]
fn single_coordinates_are_columns_on_lattices_of_any_length() {
    let mut found = 0;
    for (lengths, here, sums) in [
        ("9, y = 9, z = 9", "i", "i"),
        ("25", "i", "i"),
        ("1000", "i", "i"),
        ("[5, 6]", "i,j", "i, j"),
        ("[50, 60]", "i,j", "i, j"),
    ] {
        let first = here.replace(['i', 'j'], "1");
        let rest = if lengths.contains('y') {
            format!(" + y[{here}] + z[{here}]")
        } else {
            String::new()
        };
        let text = format!(
            "families = {{ x = {lengths} }}\nbracket = {{ \"x[{here}],x[{}]\" = \"1\" }}\n\
             hamiltonian = \"sum({sums}, x[{here}]^2{rest})\"",
            here.replace('i', "i+1")
        );
        let others = if rest.is_empty() {
            String::new()
        } else {
            format!(", \"y[{here}]\" = 0, \"z[{here}]\" = 0")
        };
        let run = format!(
            "initial = {{ \"x[{here}]\" = \"i\"{others} }}\n\
             record = {{ observables = [\"x[{first}]\", \"sum({sums}, x[{here}])\", \"energy\"] }}"
        );
        let composed = compose_system(&document(&text, &run)).expect("a lattice");
        let [coordinate, sum, energy] = &composed.observables[..] else {
            panic!("three columns");
        };
        assert!(
            matches!(coordinate, Observable::Coordinate { .. }),
            "{lengths}: {coordinate:?}"
        );
        assert!(
            matches!(sum, Observable::Formula { .. })
                && matches!(energy, Observable::Invariant { .. })
        );
        found += 1;
    }
    assert_eq!(found, 5);
}

/// A key with a number along an axis stands for a row; the more indices, the sooner, whatever the order.
#[test]
fn a_key_with_a_number_along_an_axis_is_a_row() {
    for (lengths, row) in [([8, 6], 6), ([6, 8], 8), ([2, 3], 3), ([5, 4], 4)] {
        let [up, across] = lengths;
        let text = plane(&format!("{lengths:?}"), "\"open\"", "sum(i, j, x[i,j]^2)");
        for initial in [
            "\"x[i,j]\" = 7, \"x[1,j]\" = \"j + 1\", \"x[i,1]\" = \"2*i\", \"x[1,0]\" = -1",
            "\"x[1,0]\" = -1, \"x[1,j]\" = \"j + 1\", \"x[i,1]\" = \"2*i\", \"x[i,j]\" = 7",
        ] {
            let initial = format!("initial = {{ {initial} }}");
            let composed = compose_system(&document(&text, &initial)).expect("a plane");
            let expected = (0..up * across).map(|site| match (site / across, site % across) {
                (1, 0) => -1.0,
                (i, 1) => 2.0 * f64::from(i),
                (1, j) => f64::from(j) + 1.0,
                _ => 7.0,
            });
            assert_eq!(
                composed.initial,
                expected.collect::<Vec<_>>(),
                "{lengths:?}"
            );
        }
        let text = text.replace("x[i,j],x[i,j+1]", "x[1,j],x[1,j+1]");
        let composed =
            compose_system(&document(&text, "initial = { \"x[i,j]\" = 0 }")).expect("a plane");
        let formulas = composed.system.expressions().expect("formulas");
        assert_eq!(formulas.tensor().len(), row - 1, "{lengths:?}");
    }
}

/// Indices that are not those of the axes in their order have the meaning that is written, or are refused: never that of others.
#[test]
fn indices_in_another_order_are_no_templates() {
    let field = |lengths: &str, bracket: &str, rest: &str| {
        format!(
            "families = {{ q = {lengths}, p = {lengths} }}\nbracket = {{ {bracket} = \"1\" }}\n\
             hamiltonian = \"sum(i, j, p[i,j]^2/2 + q[i,j]^2/2)\"\n{rest}"
        )
    };
    let initial = "initial = { \"q[i,j]\" = 1, \"p[i,j]\" = 0 }";
    let text = field("[5, 5]", "\"q[i,j],p[j,i]\"", "");
    let composed = compose_system(&document(&text, initial)).expect("written out");
    let formulas = composed.system.expressions().expect("formulas");
    let pairs: Vec<_> = formulas.tensor().keys().copied().collect();
    // {q[0,1], p[1,0]}: 1 and 25 + 5.
    assert!(
        pairs.contains(&(1, 30)) && !pairs.contains(&(1, 26)),
        "{pairs:?}"
    );
    let aligned = "\"q[i,j],p[i,j]\"";
    for (text, message) in [
        (
            field("[6, 5]", "\"q[i,j],p[j,i]\"", ""),
            "the index `j` counts along an axis of 5 sites and along one of 6",
        ),
        (
            field("[100, 100]", "\"q[i,j],p[j,i]\"", ""),
            "a sum within a sum",
        ),
        (
            field("[5, 5]", "\"q[i,i],p[i,i]\"", ""),
            "the index `i` counts along two axes",
        ),
        (
            field("[40, 40]", "\"q[i,i],p[i,i]\"", ""),
            "a sum within a sum",
        ),
        (
            field("[6, 5]", aligned, "forces = { \"q[i,i]\" = \"1\" }"),
            "the index `i` counts along two axes",
        ),
        (
            field(
                "[6, 5]",
                aligned,
                "forces = { \"q[i,j]\" = \"0.3*p[j,i]\" }",
            ),
            "the index `j` counts along an axis of 5 sites and along one of 6",
        ),
        (
            field(
                "[6, 5]",
                aligned,
                "noise = [{ hamiltonian = \"q[i,i]\", strength = \"1\" }]",
            ),
            "the index `i` counts along two axes",
        ),
    ] {
        let refused = refusal(&text, initial);
        assert!(
            refused.message.starts_with(message),
            "{text}: {}",
            refused.message
        );
    }
    let twice = refusal(
        &field("[5, 5]", aligned, ""),
        "initial = { \"q[i,j]\" = 1, \"p[i,j]\" = 0, \"p[i,i]\" = 1 }",
    );
    assert!(
        twice
            .message
            .starts_with("the index `i` counts along two axes"),
        "{}",
        twice.message
    );
}

//! Parameters of every site, and values from lists and files.

use std::fs;

use leafwise_core::Registry;

use super::{compose, compose_system, document, refusal};
use crate::compose::{SceneChecks, check_varied, left_out, state_beside};
use crate::document::SceneDocument;

const CHAIN: &str = "families = { q = 4, p = 4 }\nbracket = { \"q[i],p[i]\" = \"-1\" }\n\
                     hamiltonian = \"sum(i, p[i]^2/2 + J[i]*(q[i+1] - q[i])^2/2)\"\n";
const START: &str = "initial = { \"q[i]\" = [1, 2, 3, 4], \"p[i]\" = \"i/2\" }";

fn chain(parameters: &str) -> String {
    format!("{CHAIN}parameters = {{ {parameters} }}")
}

/// Formulas, lists and single sites give the numbers they say, behind the coordinates; nothing shows them outside.
#[test]
fn parameters_of_sites_stand_behind_the_coordinates() {
    for (parameters, expected) in [
        (
            "a = 0.5, \"J[i]\" = \"1 + a*i/N\"",
            [1.0, 1.125, 1.25, 1.375],
        ),
        (
            "\"J[2]\" = 7, \"J[i]\" = [1, 2, 3, 4]",
            [1.0, 2.0, 7.0, 4.0],
        ),
        ("\"J[i]\" = 2, \"J[N-1]\" = \"pi/pi\"", [2.0, 2.0, 2.0, 1.0]),
    ] {
        let document = document(&chain(parameters), START);
        let run = compose(&document, &Registry::with_builtin()).expect("a run");
        assert_eq!(
            run.plan.initial[..8],
            [1.0, 2.0, 3.0, 4.0, 0.0, 0.5, 1.0, 1.5]
        );
        assert_eq!(run.plan.initial[8..], expected, "{parameters}");
        assert_eq!(run.own(&run.plan.initial).len(), 8);
        assert_eq!(run.names().len(), 8);
        assert_eq!(run.plan.states.width(), 8);
        assert_eq!(run.plan.families.len(), 2);
        let checks = SceneChecks::of(&run.system, &run.near).expect("derivatives");
        assert!(checks.pass());
    }
}

/// Every kind of bracket over families takes them, in its entries and summands too.
#[test]
fn brackets_may_name_parameters_of_sites() {
    let spins = "families = { s = { components = [\"x\", \"y\", \"z\"], length = 2 } }\nhamiltonian = \"sum(i, b[i]*s.z[i])\"\n\
                 parameters = { \"b[i]\" = [3, 5] }\nbracket = ";
    let initial = "initial = [1, 2, 3, 4, 5, 6]";
    let algebra = "{ lie-algebra = \"so3\" }";
    let sum = "{ sum = [{ variables = [\"s\"], bracket = { lie-algebra = \"so3\" } }] }";
    for bracket in [algebra, sum] {
        let composed = compose_system(&document(&format!("{spins}{bracket}"), initial));
        let composed = composed.expect("a system");
        assert_eq!(composed.initial[6..], [3.0, 5.0]);
        let formulas = composed.system.expressions().expect("formulas");
        assert!(formulas.tensor().keys().all(|(i, j)| *i < 6 && *j < 6));
    }
    let scaled = "families = { x = 3 }\nparameters = { \"J[i]\" = [2, 3, 4] }\nhamiltonian = \"sum(i, x[i])\"\nbracket = ";
    let entries = "{ \"x[i],x[i+1]\" = \"J[i]*x[i]*x[i+1]\" }";
    let summand = format!("{{ sum = [{{ variables = [\"x\"], bracket = {entries} }}] }}");
    for bracket in [entries, summand.as_str()] {
        let document = document(&format!("{scaled}{bracket}"), "initial = [1, 1, 1]");
        let run = compose(&document, &Registry::with_builtin()).expect("a run");
        let formulas = run.system.expressions().expect("formulas");
        let value = |at: (usize, usize)| formulas.tensor()[&at].evaluate(&run.plan.initial, &[]);
        assert_eq!(
            [value((0, 1)), value((1, 2)), value((0, 2))],
            [2.0, 3.0, -4.0]
        );
    }
}

#[test]
fn what_does_not_fit_the_sites_is_refused_where_it_stands() {
    for (parameters, run, piece, said) in [
        (
            "\"J[i]\" = [1, 2]",
            START,
            "[1, 2]",
            "2 numbers, and `J` has 4 sites",
        ),
        (
            "\"J[3]\" = [1, 2]",
            START,
            "\"J[3]\"",
            "one site, and these are numbers of many",
        ),
        (
            "\"J[3]\" = 1",
            START,
            "\"J[3]\"",
            "parameters gives no value for J[0]",
        ),
        (
            "\"J[4]\" = 1, \"J[i]\" = 2",
            START,
            "4",
            "`J` has the members J[0] to J[3]",
        ),
        (
            "\"J[i]\" = \"ln(i)\"",
            START,
            "ln(i)",
            "the value of J[0] is infinite",
        ),
        ("\"J[i]\" = \"q[i]\"", START, "q[i", "`q` "),
        (
            "\"J[i]\" = { file = \"none.csv\" }",
            START,
            "\"none.csv\"",
            "cannot read none.csv",
        ),
        (
            "\"J[i]\" = 1",
            "initial = { \"q[i]\" = 1, \"p[i]\" = 0, \"J[i]\" = 2 }",
            "\"J[i]\"",
            "`J` is a parameter of every site",
        ),
        (
            "\"J[i]\" = 1",
            "initial = { \"q[i]\" = [1, 2, 3], \"p[i]\" = 0 }",
            "[1, 2, 3]",
            "3 numbers, and `q` has 4 sites",
        ),
        (
            "a = 1, \"J[i]\" = \"a\"",
            &format!(
                "{START}\n[ensemble]\nmembers = 2\nparameters = {{ a = {{ uniform = [0, 1] }} }}"
            ),
            "a",
            "values of sites are formed once, and `a` varies",
        ),
    ] {
        let diagnostic = refusal(&chain(parameters), run);
        assert!(
            diagnostic.message.contains(said),
            "{parameters}: {}",
            diagnostic.message
        );
        let found = &diagnostic.source_text[diagnostic.span.clone()];
        assert_eq!(found, piece, "{parameters}");
    }
    let one_form = "families = { q = 1, p = 1 }\nhamiltonian = \"J[0]*p[0]^2\"\nbracket = { one-form = [\"p[0]\", 0] }\n\
                    parameters = { \"J[i]\" = 2 }";
    let message = refusal(one_form, "initial = [1, 2]").message;
    assert!(
        message.contains("are not supported with a bracket by a form"),
        "{message}"
    );
}

#[test]
fn wrong_keys_of_sites_are_told_when_a_scene_is_read() {
    for (system, said) in [
        (
            chain("J = [1, 2, 3, 4]"),
            "`J` must be a number, where those of all sites are \"J[i]\", found a list",
        ),
        (
            chain("\"J[i]\" = { fill = \"j.csv\" }"),
            "unknown key `fill` in J[i]",
        ),
        (chain("\"q[i]\" = 1"), "`q` is declared twice"),
        (chain("\"2J[i]\" = 1"), "`2J`"),
        (
            "variables = [\"x\"]\nbracket = {}\nhamiltonian = \"x\"\nparameters = { \"J[i]\" = 1 }"
                .to_owned(),
            "`J[i]` is a parameter of every site, and the system has no families",
        ),
    ] {
        let text =
            format!("[system]\n{system}\n[method]\ntime-step = 0.1\n[run]\nsteps = 1\n{START}\n");
        let errors = SceneDocument::parse("scene.toml", &text, &Registry::empty());
        let errors = errors.expect_err(said).diagnostics();
        assert!(
            errors.iter().any(|error| error.message.contains(said)),
            "{said}: {errors:?}"
        );
    }
}

/// Files lie beside the scene.
#[test]
fn files_give_a_number_a_site() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("j.csv"), "b,J\n1,5\n2,6\n3,7\n4,8\n").expect("written");
    fs::write(folder.path().join("q.json"), "[1, 0, -1, 0.5]").expect("written");
    let of = |column: &str| {
        let system = chain(&format!("\"J[i]\" = {{ file = \"j.csv\"{column} }}"));
        let start = "initial = { \"q[i]\" = { file = \"q.json\" }, \"p[i]\" = 0 }";
        let mut document = document(&system, start);
        document.name = folder.path().join("scene.toml").display().to_string();
        compose_system(&document)
    };
    let composed = of(", column = \"J\"").expect("a system");
    assert_eq!(
        composed.initial,
        [1.0, 0.0, -1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 5.0, 6.0, 7.0, 8.0]
    );
    let message = of("").expect_err("two columns").message;
    assert!(
        message.contains("choose one by column = \"b\""),
        "{message}"
    );
}

/// Values of sites may be formulas of others, in whatever order they stand, and so may initial values.
#[test]
fn values_of_sites_may_name_those_of_others() {
    let parameters = "\"J[i]\" = \"2*w[i] + w[i+1]\", \"w[i]\" = \"m[i]^2 + a\", \"m[i]\" = [1, 2, 3, 4], \"m[2]\" = 5, a = 0.5";
    let start = "initial = { \"q[i]\" = \"J[i] - sum(k, m[k])\", \"p[i]\" = 0 }";
    let composed = compose_system(&document(&chain(parameters), start)).expect("a system");
    let m = [1.0, 2.0, 5.0, 4.0];
    let w = m.map(|m| m * m + 0.5);
    let j = [0, 1, 2, 3].map(|i| 2.0 * w[i] + w[(i + 1) % 4]);
    let initial = composed.initial;
    assert_eq!(initial[..4], j.map(|j| j - 12.0));
    // Behind the coordinates they stand in the order of the scene.
    assert_eq!(initial[8..], [j, w, m].concat());
    // A coordinate is none of them.
    let refused = compose_system(&document(&chain("\"J[i]\" = \"q[i]\""), START));
    let message = refused.expect_err("a coordinate").message;
    assert!(message.contains("`q` depends on the state"), "{message}");
}

#[test]
fn values_that_lead_round_in_a_circle_are_refused() {
    for (parameters, said) in [
        (
            "\"J[i]\" = \"w[i]\", \"w[i]\" = \"m[i]\", \"m[i]\" = \"2*w[i]\"",
            "the values of `w`, `m` are each defined by the next",
        ),
        (
            "\"J[i]\" = \"1 + J[i-1]\"",
            "values of `J` are defined by values of `J`",
        ),
        (
            "\"J[i]\" = 1, \"J[2]\" = \"J[1]\"",
            "values of `J` are defined by values of `J`",
        ),
    ] {
        let refused = compose_system(&document(&chain(parameters), START)).expect_err(said);
        assert!(refused.message.contains(said), "{}", refused.message);
    }
    let open = format!(
        "{}\nboundary = \"open\"",
        chain("\"J[i]\" = \"m[i+1]\", \"m[i]\" = 1")
    );
    let refused = compose_system(&document(&open, START)).expect_err("outside");
    assert!(
        refused
            .message
            .contains("`m[i+1]` lies beyond the open end"),
        "{}",
        refused.message
    );
}

/// Names of indices are free: two keys for one family are one, and neither may win in silence.
#[test]
fn keys_that_give_a_site_two_values_are_refused_by_both_names() {
    let plane = "families = { q = [2, 3], p = [2, 3] }\nbracket = { \"q[i,j],p[i,j]\" = \"-1\" }\n\
                 hamiltonian = \"sum(i, sum(j, p[i,j]^2/2 + q[i,j]^2/2))\"\nparameters = { a = 2 }";
    let start = |keys: &str| document(plane, &format!("initial = {{ \"p[i,j]\" = 0, {keys} }}"));
    for (one, other, values) in [
        ("q[i,j]\" = \"i\"", "q[j,i]\" = \"2*i\"", "q[0, 1]"),
        (
            "q[i,j]\" = \"i\"",
            "q[k,l]\" = [6, 5, 4, 3, 2, 1]",
            "q[0, 0]",
        ),
    ] {
        let refused = compose_system(&start(&format!("\"{one}, \"{other}"))).expect_err(other);
        let key = |text: &str| format!("\"{}\"", text.split('"').next().unwrap_or_default());
        for said in [key(one), key(other)] {
            assert!(refused.message.contains(&said), "{}", refused.message);
        }
        let name = values.replace(' ', "");
        let message = refused.message.replace(' ', "");
        assert!(
            message.contains(&format!("give{name}twovalues")),
            "{message}"
        );
    }
    // Crossing rows with one value at their corner, and rows before the whole, are no contradiction.
    let keys = "\"q[0,j]\" = 0, \"q[i,0]\" = 0, \"q[i,j]\" = \"7\", \"q[1,2]\" = 5";
    let composed = compose_system(&start(keys)).expect("a system");
    assert_eq!(composed.initial[..6], [0.0, 0.0, 0.0, 0.0, 7.0, 5.0]);
    let crossing = "\"q[0,j]\" = 1, \"q[i,0]\" = 0, \"q[i,j]\" = \"7\"";
    let refused = compose_system(&start(crossing)).expect_err("a corner");
    assert!(
        refused.message.contains("two values, 1.0 and 0.0"),
        "{}",
        refused.message
    );
}

/// An ensemble forms values of sites and of pairs once: they name no parameter that differs from member to member, by no definition.
#[test]
fn values_that_would_differ_from_member_to_member_are_refused() {
    let ensemble = "[ensemble]\nmembers = 2\n[ensemble.parameters]\ng = { uniform = [1, 3] }\n";
    for (parameters, define) in [
        ("g = 1, \"J[i]\" = \"g\"", ""),
        ("g = 1, \"J[i]\" = \"2*k\"", "define = { k = \"g + 1\" }"),
        ("g = 1, \"J[i]\" = 1, \"M[i,j]\" = \"g\"", ""),
        (
            "g = 1, \"M[i,j]\" = \"k\"",
            "define = { m = \"g\", k = \"m\" }",
        ),
    ] {
        let system = match parameters.contains("J[i]") {
            true => chain(parameters),
            false => chain(parameters).replace("J[i]*", ""),
        };
        let document = document(
            &format!("{system}\n{define}"),
            &format!("{START}\n{ensemble}"),
        );
        let refusal = compose(&document, &Registry::with_builtin())
            .err()
            .expect(parameters);
        assert!(
            refusal
                .message
                .contains("values of sites are formed once, and `g` varies"),
            "{parameters}: {}",
            refusal.message
        );
    }
}

/// A state beside others has the parameters of sites as they are.
#[test]
fn a_centre_may_name_parameters_of_sites() {
    let document = document(
        &chain("\"J[i]\" = [3, 5, 7, 9]"),
        "initial = { \"q[i]\" = \"J[i]\", \"p[i]\" = 1 }",
    );
    let spec = &document.run.initial;
    let state = state_beside(&document, spec, &[0.0; 8]).expect("a state");
    assert_eq!(state, [3.0, 5.0, 7.0, 9.0, 1.0, 1.0, 1.0, 1.0]);
}

/// Of a force at a site the terms that reach beyond an open end are left out, as of a summand of H, and the others act.
#[test]
fn forces_at_open_ends_keep_what_stands_inside() {
    let text = "families = { q = 5, p = 5 }\nbracket = { \"q[i],p[i]\" = 1 }\nconvention = \"{x,H}\"\nboundary = \"open\"\n\
                hamiltonian = \"sum(i, p[i]^2/2)\"\nforces = { \"q[i]\" = \"0.5*p[i] + 0.25*(p[i] - p[i+1]) + (p[i-1] - p[i+1])^2\" }";
    let document = document(text, "initial = { \"q[i]\" = 0, \"p[i]\" = \"1 + i\" }");
    let system = compose_system(&document).expect("a system").system;
    let formulas = system.formulas("a test").expect("formulas");
    let p = [1.0, 2.0, 3.0, 4.0, 5.0];
    let x: Vec<f64> = [0.0; 5].into_iter().chain(p).collect();
    for (i, force) in formulas.forces().one_form.iter().take(5).enumerate() {
        let square = if (1..4).contains(&i) { 4.0 } else { 0.0 };
        let next = if i < 4 { p[i + 1] } else { 0.0 };
        let expected = 0.5 * p[i] + 0.25 * (p[i] - next) + square;
        assert_eq!(force.evaluate(&x, &[]), expected, "site {i}");
    }
    let said = left_out(&document).expect("formulas");
    let said: Vec<(&str, &str, &[usize])> = said
        .iter()
        .map(|own| (own.of.as_str(), own.term.as_str(), &own.places[0][..]))
        .collect();
    assert_eq!(
        said,
        [
            ("forces of q[i]", "(p[i-1] - p[i+1])^2", &[0, 4][..]),
            ("forces of q[i]", "p[i+1]", &[4][..]),
        ]
    );
}

/// An initial state is formed once: where members begin there it names no parameter that varies.
#[test]
fn initial_states_name_no_parameter_that_varies() {
    let document = document(
        &chain("a = 1, \"J[i]\" = 1"),
        "initial = { \"q[i]\" = \"a\", \"p[i]\" = 0 }",
    );
    let refused = check_varied(&document, &["a"], true).expect_err("formed once");
    assert!(
        refused
            .message
            .contains("the initial state is formed once, and `a` varies")
    );
    assert!(check_varied(&document, &["a"], false).is_ok());
    assert!(check_varied(&document, &["b"], true).is_ok());
}

/// Numbers of sites come in the shape of the lattice, or in one list; other shapes are refused, not read askew.
#[test]
fn numbers_of_sites_have_the_shape_of_the_lattice() {
    let text = "families = { q = [2, 3], p = [2, 3] }\nbracket = { \"q[i,j],p[i,j]\" = 1 }\n\
                hamiltonian = \"sum(i, j, p[i,j]^2/2)\"";
    let initial = |numbers: &str| {
        document(
            text,
            &format!("initial = {{ \"q[i,j]\" = {numbers}, \"p[i,j]\" = 0 }}"),
        )
    };
    for numbers in ["[1, 2, 3, 4, 5, 6]", "[[1, 2, 3], [4, 5, 6]]"] {
        let system = compose_system(&initial(numbers)).expect(numbers);
        assert_eq!(system.initial[..6], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    }
    for (numbers, said) in [
        (
            "[[1, 2], [3, 4], [5, 6]]",
            "the numbers have the shape [3, 2], and the sites of `q[i,j]` have the shape [2, 3]",
        ),
        ("[[1, 2, 3]]", "3 numbers, and `q` has 6 sites"),
    ] {
        let refused = compose_system(&initial(numbers)).expect_err(numbers);
        assert!(refused.message.contains(said), "{}", refused.message);
    }
}

/// Single variables, the time and indicators of chaos have a lattice of up to 1024 coordinates written out.
#[test]
fn lattices_are_written_out_for_what_no_sweep_gives() {
    let lattice = |more: &str, hamiltonian: &str, record: &str| {
        document(
            &format!(
                "families = {{ q = 20, p = 20 }}\nbracket = {{ \"q[i],p[i]\" = 1 }}\nconvention = \"{{x,H}}\"\n{more}\
                 hamiltonian = \"{hamiltonian}\""
            ),
            &format!("initial = {{ \"q[i]\" = 0.5, \"p[i]\" = 0 }}\n{record}"),
        )
    };
    let chain = "sum(i, p[i]^2/2 - cos(q[i+1] - q[i]))";
    for document in [
        lattice("", &format!("{chain} + 0.1*cos(t)*q[0]"), ""),
        lattice("", &format!("{chain} + 0.1*cos(t)*sum(i, q[i])"), ""),
        lattice("", chain, "record = { observables = [\"megno\"] }"),
        lattice("", chain, "record = { observables = [\"shadow-energy\"] }"),
        lattice("forces = { \"q[i]\" = \"0.1*cos(t)\" }\n", chain, ""),
    ] {
        let system = compose_system(&document).expect("written out").system;
        assert!(system.dimension() >= 40, "{}", system.dimension());
    }
}

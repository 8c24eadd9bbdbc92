//! Names of recorded columns: those that are taken, and quantities that no formula computes with.

use super::{compose_system, document, refusal};

const PENDULUM: &str =
    "variables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"-1\" }\nhamiltonian = \"p^2/2 - cos(q)\"";
const BODY: &str = "variables = [\"x\", \"y\", \"z\"]\nbracket = { lie-algebra = \"so3\" }\nhamiltonian = \"x^2 + y^2/2\"\n\
                    casimirs = { spin = \"x^2 + y^2 + z^2\" }";

fn chain(length: usize) -> String {
    format!(
        "families = {{ q = {length}, p = {length} }}\nbracket = {{ \"q[i],p[i]\" = \"-1\" }}\n\
         hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2)\""
    )
}

fn spins(length: usize) -> String {
    format!(
        "families = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {length} }} }}\nboundary = \"periodic\"\n\
         bracket = {{ lie-algebra = \"so3\" }}\nhamiltonian = \"-sum(i, dot(s[i], s[i+1]))\""
    )
}

const SPINS: &str =
    "initial = { \"s.x[i]\" = \"cos(i)\", \"s.y[i]\" = \"sin(i)\", \"s.z[i]\" = 0.5 }\n";
const CHAIN: &str = "initial = { \"q[i]\" = \"cos(i)\", \"p[i]\" = 1 }\n";

/// A column that would be taken for the energy, a Casimir, the time, a coordinate or an indicator is refused by its name, and
/// another name is taken. So is a name with the formula that it has.
#[test]
fn a_column_has_no_name_of_something_else() {
    let (pendulum, body) = ("initial = [1, 0.5]\n", "initial = [1, 0.5, 0.2]\n");
    let (short, long) = (chain(8), chain(700));
    for (system, run, name, formula) in [
        (PENDULUM, pendulum, "energy", "p^2/2"),
        (PENDULUM, pendulum, "t", "p"),
        (PENDULUM, pendulum, "q", "q^2"),
        (PENDULUM, pendulum, "megno", "q*p"),
        (PENDULUM, pendulum, "shadow-energy", "energy"),
        (BODY, body, "spin", "x^2"),
        (BODY, body, "spin-temperature", "x^2"),
        (&short, CHAIN, "q[3]", "p[3]"),
        (&long, CHAIN, "energy", "sum(i, p[i]^2)"),
        (&long, CHAIN, "q[650]", "p[650]"),
    ] {
        let record = |name: &str, formula: &str| {
            format!("{run}record = {{ observables = [{{ \"{name}\" = \"{formula}\" }}] }}")
        };
        let refused = refusal(system, &record(name, formula));
        let said = format!("an observable cannot be called `{name}`");
        assert!(refused.message.contains(&said), "{}", refused.message);
        let underlined = &refused.source_text[refused.span.clone()];
        assert_eq!(underlined.trim_matches('"'), name);
        let help = refused.help.unwrap_or_default();
        let other = help
            .split_once("{ ")
            .and_then(|(_, rest)| rest.split_once(" ="));
        let (other, _) = other.unwrap_or_else(|| panic!("{help}"));
        let composed = compose_system(&document(system, &record(other, formula)));
        let composed = composed.unwrap_or_else(|refused| panic!("{}", refused.message));
        assert_eq!(composed.observables[0].name(), other);
    }
    for (system, run, name, formula) in [
        (PENDULUM, pendulum, "energy", "energy"),
        (PENDULUM, pendulum, "energy", "p^2/2 - cos(q)"),
        (BODY, body, "spin", "x^2 + y^2 + z^2"),
        (PENDULUM, pendulum, "q", "q"),
        (PENDULUM, pendulum, "lyapunov", "lyapunov 1"),
    ] {
        let record = format!("{run}record = {{ observables = [{{ {name} = \"{formula}\" }}] }}");
        assert!(compose_system(&document(system, &record)).is_ok(), "{name}");
    }
}

/// A formula with the name of a column in it is told what to record or to write, which is taken: of a few spins and of many.
#[test]
fn formulas_do_not_compute_with_columns() {
    let energy = "(-sum(i, dot(s[i], s[i+1])))";
    for length in [6, 800] {
        let system = spins(length);
        for (formula, name) in [
            ("2*spin-temperature", "spin-temperature"),
            ("spin-temperature/2 + s.z[0]", "spin-temperature"),
            ("shadow-energy - 1", "shadow-energy"),
            ("2*energy", "energy"),
            ("megno*2", "megno"),
        ] {
            let record =
                |formula: &str| format!("{SPINS}record = {{ observables = [\"{formula}\"] }}");
            let refused = refusal(&system, &record(formula));
            assert_eq!(
                &refused.source_text[refused.span.clone()],
                name,
                "{formula}"
            );
            let said = format!("`{name}` is a column of its own");
            assert!(refused.message.contains(&said), "{}", refused.message);
            let help = refused.help.unwrap_or_default();
            assert!(
                help.contains(&format!("observables = [\"{name}\"]")),
                "{help}"
            );
            // Displacements and shadows are refused of long lattices, in words of their own.
            if !(length == 800 && ["megno", "shadow-energy"].contains(&name)) {
                assert!(
                    compose_system(&document(&system, &record(name))).is_ok(),
                    "{name}"
                );
            }
            if name == "energy" {
                assert!(help.contains(energy), "{help}");
                let written = record(&formula.replace("energy", energy));
                assert!(
                    compose_system(&document(&system, &written)).is_ok(),
                    "{written}"
                );
            }
        }
        for (event, name) in [
            ("stop = \"spin-temperature < 0.1\"", "spin-temperature"),
            (
                "section = { at = \"spin-temperature = 1\" }",
                "spin-temperature",
            ),
            (
                "section = { at = \"s.z[0] = spin-temperature\" }",
                "spin-temperature",
            ),
            ("stop = \"energy > 1e9\"", "energy"),
        ] {
            let refused = refusal(&system, &format!("{SPINS}{event}"));
            assert_eq!(&refused.source_text[refused.span.clone()], name, "{event}");
            let help = refused.help.unwrap_or_default();
            let cured = match name {
                "energy" => format!("{SPINS}{}", event.replace("energy", energy)),
                _ => format!("{SPINS}record = {{ observables = [\"{name}\"] }}"),
            };
            let cure = if name == "energy" {
                energy
            } else {
                "observables = [\"spin-temperature\"]"
            };
            assert!(help.contains(cure), "{help}");
            assert!(
                compose_system(&document(&system, &cured)).is_ok(),
                "{cured}"
            );
        }
    }
}

/// The time in a formula of a long lattice: each is told what serves in its place.
#[test]
fn the_time_on_a_long_lattice_is_told_what_serves() {
    let system = chain(700);
    for (run, cure) in [
        (
            "record = { observables = [\"t*q[3]\"] }",
            "the first column of samples.csv",
        ),
        (
            "record = { observables = [\"sum(i, t*q[i])\"] }",
            "the first column of samples.csv",
        ),
        ("stop = \"t > 1\"", "`until` in the place of `steps`"),
        (
            "section = { at = \"t = 1\" }",
            "record = { times = [1, 2.5] }",
        ),
    ] {
        let refused = refusal(&system, &format!("{CHAIN}{run}"));
        assert_eq!(&refused.source_text[refused.span.clone()], "t", "{run}");
        let help = refused.help.unwrap_or_default();
        assert!(help.contains(cure), "{run}: {help}");
        assert!(help.contains("leave t out"), "{run}: {help}");
    }
    let times = format!("{CHAIN}record = {{ times = [1, 2.5] }}");
    assert!(compose_system(&document(&system, &times)).is_ok());
}

/// Observables of many sites that are no numbers, or sums of products of sites far apart: what is told is recorded.
#[test]
fn observables_of_all_sites_are_told_how_they_are_written() {
    let system = chain(700);
    for (observable, help, cures) in [
        (
            "sum(i, j, q[i]*p[j])",
            "sum(i, q[i])*sum(i, p[i])",
            &["sum(i, q[i])*sum(i, p[i])"][..],
        ),
        (
            "sum(i<j, q[i]*q[j])",
            "(sum(i, q[i])^2 - sum(i, q[i]^2))/2",
            &["(sum(i, q[i])^2 - sum(i, q[i]^2))/2"],
        ),
        (
            "sum(i, q[3]*q[i])",
            "q[3]*sum(i, q[i])",
            &["q[3]*sum(i, q[i])"],
        ),
        ("q[i]^2", "sum(i, q[i]^2)", &["sum(i, q[i]^2)"]),
        ("q", "states = [\"q\"]", &[]),
    ] {
        let record = |observable: &str| {
            format!("{CHAIN}record = {{ states = [\"q\"], observables = [\"{observable}\"] }}")
        };
        let refused = refusal(&system, &record(observable));
        let said = refused.help.unwrap_or_default();
        assert!(said.contains(help), "{observable}: {said}");
        for cure in cures {
            let composed = compose_system(&document(&system, &record(cure)));
            composed.unwrap_or_else(|refused| panic!("{cure}: {}", refused.message));
        }
    }
}

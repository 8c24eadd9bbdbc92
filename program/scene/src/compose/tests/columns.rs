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

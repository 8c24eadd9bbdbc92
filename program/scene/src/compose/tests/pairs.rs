//! Sums over pairs of many sites beside what no loop takes.

use leafwise_core::Registry;

use super::{compose, document};

/// Noise, damping and forces that look at other sites are written out beside a sum over pairs, up to 1024 coordinates; beyond, the formula
/// that is in the way is underlined, with what to do.
#[test]
fn what_stands_beside_many_pairs_is_refused_where_it_stands() {
    let system = |sites: usize, more: &str| {
        format!(
            "families = {{ q = {sites}, p = {sites} }}\nbracket = {{ \"q[i],p[i]\" = \"-1\" }}\n\
             hamiltonian = \"sum(i, p[i]^2/2) - sum(i<j, cos(q[i] - q[j]))/N\"\n{more}"
        )
    };
    let start = "initial = { \"q[i]\" = 0, \"p[i]\" = 1 }";
    for (more, piece, said) in [
        (
            "noise = [{ hamiltonian = \"q[i]*q[i+1]\", strength = \"0.1\" }]",
            "q[i]*q[i+1]",
            "`noise`",
        ),
        ("damping = { rate = \"q[0]^2\" }", "q[0]^2", "`damping`"),
        (
            "forces = { \"p[i]\" = \"-p[i+1]/7\" }",
            "-p[i+1]/7",
            "`forces`",
        ),
    ] {
        let registry = Registry::with_builtin();
        let refusal = compose(&document(&system(600, more), start), &registry);
        let refusal = refusal.map(|_| ()).expect_err(more);
        assert!(refusal.message.contains(said), "{}", refusal.message);
        assert!(
            refusal.message.contains("1024 coordinates"),
            "{}",
            refusal.message
        );
        assert_eq!(&refusal.source_text[refusal.span.clone()], piece);
        let help = refusal.help.clone().unwrap_or_default();
        assert!(help.contains("--set system.families.q="), "{help}");
    }
}

//! Sums over pairs of many sites beside what no loop takes.

use leafwise_core::Registry;

use super::{compose, document};

/// Noise, damping and forces together with a sum over pairs are written out up to 1024 coordinates; beyond, the formula that is in the
/// way is underlined, with what to do.
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
            "noise = [{ hamiltonian = \"q[i]\", strength = \"0.1\" }]",
            "q[i]",
            "`noise`",
        ),
        ("damping = { rate = \"0.25\" }", "0.25", "`damping`"),
        ("forces = { \"p[i]\" = \"-p[i]/7\" }", "-p[i]/7", "`forces`"),
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

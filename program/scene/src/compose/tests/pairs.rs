//! Sums over pairs of many sites beside what no loop takes.

use leafwise_core::Registry;
use leafwise_reference as _;

use super::{compose, document};
use crate::document::SceneDocument;

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

/// A force, a rate or an entry of a metric that is of sums over all sites: above 1024 coordinates it is underlined, beside a sum over
/// pairs and beside none, and what is advised is taken.
#[test]
fn mean_field_forces_are_told_what_serves() {
    let scene = |sites: usize, hamiltonian: &str, more: &str| {
        let text = format!(
            "[system]\nfamilies = {{ q = {sites}, p = {sites} }}\nbracket = {{ \"q[i],p[i]\" = \"-1\" }}\n\
             hamiltonian = \"sum(i, p[i]^2/2 - cos(q[i])){hamiltonian}\"\n{more}\n[method]\nstepper = \"rk4\"\n\
             time-step = 0.1\n[run]\nsteps = 1\ninitial = {{ \"q[i]\" = \"sin(i)\", \"p[i]\" = 1 }}\n"
        );
        let registry = Registry::with_builtin();
        let document = SceneDocument::parse("scene.toml", &text, &registry);
        let document = document.unwrap_or_else(|errors| panic!("{:?}", errors.diagnostics()));
        compose(&document, &registry).map(|_| ())
    };
    let mean = "sum(j, p[j]^2)/N";
    for pairs in ["", " - sum(i<j, cos(q[i] - q[j]))/N"] {
        for (more, piece, cure) in [
            (
                format!("forces = {{ \"p[i]\" = \"{mean}\" }}"),
                "sum(j",
                "potential",
            ),
            (
                format!("damping = {{ rate = \"{mean}\" }}"),
                "sum(j",
                "shorten",
            ),
            (
                format!("damping = {{ rate = \"0.1\", metric = {{ \"p[i]\" = \"{mean}\" }} }}"),
                "sum(j",
                "shorten",
            ),
        ] {
            let refused = scene(600, pairs, &more).expect_err("too many");
            let said = format!("{}\n{}", refused.message, refused.help.unwrap_or_default());
            let underlined = &refused.source_text[refused.span.clone()];
            assert!(underlined.contains(piece), "{underlined}: {said}");
            assert!(
                said.contains("1024 coordinates") && said.contains(cure),
                "{said}"
            );
            assert_eq!(said.contains("sum over pairs"), !pairs.is_empty(), "{said}");
            // Shorter chains are written out.
            scene(8, pairs, &more).expect("a short chain");
        }
        let potential = format!("{pairs} - sum(i, cos(q[i]))^2/N");
        scene(600, &potential, "").expect("functions of sums in loops");
    }
}

//! Indicators of chaos in directories.

use std::fs;

use super::{Prepared, SCENE, StopAfter, attempt};
use crate::{MotionKind, Quiet, RunOutcome};

/// The vectors are in the checkpoint: pieces have the bits of the whole, also where a run becomes longer.
#[test]
fn an_interrupted_run_has_the_indicators_of_a_whole_one() {
    let scene = SCENE.replace(
        "observables = [\"energy\", \"x1*x2\"]",
        "observables = [\"megno\", \"energy\", \"lyapunov 1\", \"x1*x2\", \"sali\"]",
    );
    let root = tempfile::tempdir().expect("a directory");
    let (whole, pieces) = (root.path().join("whole"), root.path().join("pieces"));
    let reference = attempt(&scene, &whole, false, &mut Quiet).expect("a run");
    let verdict = reference.chaos.expect("MEGNO is recorded");
    assert_eq!(verdict.motion, MotionKind::Regular);
    let shorter = scene.replace("steps   = 20000", "steps   = 9999");
    let report = attempt(&shorter, &pieces, false, &mut StopAfter(2)).expect("a session");
    assert_eq!(report.outcome, RunOutcome::Interrupted);
    attempt(&shorter, &pieces, false, &mut Quiet).expect("the shorter run");
    let resumed = attempt(&scene, &pieces, false, &mut Quiet).expect("the longer run");
    assert_eq!(resumed.outcome, RunOutcome::Done);
    assert_eq!(resumed.chaos, reference.chaos);
    let read = |directory: &std::path::Path| fs::read(directory.join("samples.csv"));
    assert!(read(&whole).expect("rows") == read(&pieces).expect("rows"));
    let text = fs::read_to_string(whole.join("samples.csv")).expect("rows");
    let heading = text.lines().next().expect("a line");
    assert_eq!(heading, "t,x1,x2,x3,megno,energy,lyapunov 1,x1*x2,sali");
}

/// A pendulum at its saddle, a pendulum that leaves it, and an oscillator with friction, forwards and backwards: in two
/// dimensions nothing is chaotic. Ȳ is about λt/2 with λ = 1 and λ = −0.3/2.
#[test]
fn no_motion_in_two_dimensions_is_chaotic() {
    let scene = |hamiltonian: &str, forces: &str, step: f64, initial: &str| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"{hamiltonian}\"\n{forces}[method]\nstepper = \"gauss\"\ntime-step = {step}\n\
             [run]\ninitial = {initial}\nsteps = 1000\nrecord = {{ every = 10, observables = [\"megno\"] }}\n"
        )
    };
    let pendulum = "p^2/2 + cos(q)";
    let friction = "forces = [\"0.3*p\", 0]\n";
    let oscillator = "p^2/2 + q^2/2";
    for (text, motion, growth) in [
        (
            scene(pendulum, "", 0.02, "[0, 0]"),
            MotionKind::Unstable,
            10.0,
        ),
        (
            scene(pendulum, "", 0.02, "[1e-10, 0]"),
            MotionKind::Unstable,
            10.0,
        ),
        (
            scene(oscillator, friction, -0.1, "[1, 0]"),
            MotionKind::Unstable,
            7.5,
        ),
        (
            scene(oscillator, friction, 0.1, "[1, 0]"),
            MotionKind::Regular,
            -7.5,
        ),
    ] {
        let root = tempfile::tempdir().expect("a directory");
        let prepared = Prepared::new(&text);
        let report = prepared.attempt(&root.path().join("run"), false, &mut Quiet);
        let verdict = report.expect("a run").chaos.expect("MEGNO is recorded");
        let verdict = verdict.of(&prepared.composed);
        assert_eq!(verdict.motion, motion, "{text}{verdict:?}");
        assert_eq!(verdict.e_folding_time, None);
        // ln |v| = λt + c(t), hence Ȳ − λt/2 is the mean of 2(c − mean of c). At the saddle c tends to a constant as e^{−2t}. Of
        // the oscillator |c| ≤ ln √(1.15/0.85) = 0.15, from its eigenvectors: four times that is below 1.
        assert!((verdict.megno - growth).abs() < 1.0, "{text}{verdict:?}");
    }
    // Where H names the time it may be.
    let driven = Prepared::new(&scene("p^2/2 + cos(q) + q*cos(t)", "", 0.1, "[0, 0]"));
    assert_eq!(driven.composed.is_planar(), Ok(false));
    // Leaves of so(3)* are spheres.
    assert_eq!(Prepared::new(SCENE).composed.is_planar(), Ok(true));
}

/// Steps that keep the energy take multiples of Casimirs of their own: there is no flow whose tangent an indicator follows, and the scene
/// says what to take out.
#[test]
fn indicators_beside_exact_energy_are_refused_with_what_to_take_out() {
    let registry = leafwise_core::Registry::with_builtin();
    let observed = SCENE.replace("[\"energy\", \"x1*x2\"]", "[\"energy\", \"megno\"]");
    let exact = observed
        .replace("{ name = \"karasev-truncated\", order = 4 }", "\"auto\"")
        .replace("[run]", "energy = \"exact\"\n[run]");
    let compose = |text: &str| {
        let document =
            leafwise_scene::SceneDocument::parse("top.toml", text, &registry).expect("a scene");
        leafwise_scene::compose::compose(&document, &registry).err()
    };
    let refusal = compose(&exact).expect("refused");
    assert!(
        refusal.message.starts_with("`megno` is not offered with"),
        "{refusal}"
    );
    let help = refusal.help.as_deref().unwrap_or_default();
    assert!(help.contains("remove `energy` from [method]"), "{help}");
    assert!(compose(&exact.replace("energy = \"exact\"\n", "")).is_none());
    assert!(compose(&exact.replace("megno", "x1")).is_none());
}

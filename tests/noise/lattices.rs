//! Noise and damping on lattices that are stepped by templates, against the same systems with every site written out.

use std::fmt::Write as _;

use leafwise_tests::numbers::distance;
use leafwise_tests::scenes::{composed, document};

use super::{compose, noisy};

/// Sites of a chain of spins whose 27 coordinates are stepped by templates.
const SITES: usize = 9;

/// H_k and σ_k, for all sites at once with an index of its own or as a sum.
const CHANNELS: [(&str, &str); 3] = [
    ("s.x[i]", "0.3"),
    ("s.y[i]*s.z[i+1]", "k"),
    ("sum(i, s.z[i])", "0.2"),
];

/// The end of a chain by templates.
fn by_templates(boundary: &str, way: &str, damping: &str, channels: &[(&str, &str)]) -> String {
    let listed = channels.iter().map(|(hamiltonian, strength)| {
        format!("{{ hamiltonian = \"{hamiltonian}\", strength = \"{strength}\" }}")
    });
    let noise: Vec<String> = listed.collect();
    format!(
        "[system]\nfamilies = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {SITES} }} }}\nboundary = \"{boundary}\"\n\
         bracket = {{ lie-algebra = \"so3\" }}\nparameters = {{ k = 0.4 }}\n\
         hamiltonian = \"-sum(i, s.x[i]*s.x[i+1] + 0.5*s.z[i]*s.z[i+1])\"\n{damping}\nnoise = [{}]\n[method]\nnoise = \"{way}\"\n\
         time-step = 0.05\n[run]\nseed = 7\nsteps = 20\n[run.initial]\n\
         \"s.x[i]\" = \"0.6*cos(i)\"\n\"s.y[i]\" = \"0.6*sin(i)\"\n\"s.z[i]\" = \"0.8\"\n",
        noise.join(", ")
    )
}

/// The same with single variables; a template's channels are those of its sites in their order.
fn written_out(boundary: &str, way: &str, damping: &str, channels: &[(&str, &str)]) -> String {
    let is_ring = boundary == "periodic";
    let at = |template: &str, site: usize| -> Option<String> {
        let next = match (site + 1 < SITES, is_ring) {
            (true, _) => Some(site + 1),
            (false, true) => Some(0),
            (false, false) => None,
        };
        let mut text = template.to_owned();
        for c in ["x", "y", "z"] {
            if text.contains(&format!("s.{c}[i+1]")) {
                text = text.replace(&format!("s.{c}[i+1]"), &format!("{c}{}", next?));
            }
            text = text.replace(&format!("s.{c}[i]"), &format!("{c}{site}"));
        }
        Some(text)
    };
    let sum = |template: &str| -> String {
        let terms: Vec<String> = (0..SITES).filter_map(|site| at(template, site)).collect();
        terms.join(" + ")
    };
    let mut noise = Vec::new();
    for (hamiltonian, strength) in channels {
        let all = match hamiltonian.strip_prefix("sum(i, ") {
            Some(body) => vec![sum(body.trim_end_matches(')'))],
            None => (0..SITES)
                .filter_map(|site| at(hamiltonian, site))
                .collect(),
        };
        let all = all
            .iter()
            .map(|text| format!("{{ hamiltonian = \"{text}\", strength = \"{strength}\" }}"));
        noise.extend(all);
    }
    let (mut names, mut bracket, mut initial) = (Vec::new(), String::new(), Vec::new());
    for c in ["x", "y", "z"] {
        names.extend((0..SITES).map(|site| format!("\"{c}{site}\"")));
    }
    for site in 0..SITES {
        for (a, b, c) in [("x", "y", "z"), ("y", "z", "x"), ("z", "x", "y")] {
            let _ = writeln!(bracket, "\"{a}{site},{b}{site}\" = \"-{c}{site}\"");
        }
    }
    let angle = |site: usize| site as f64;
    initial.extend((0..SITES).map(|site| 0.6 * libm::cos(angle(site))));
    initial.extend((0..SITES).map(|site| 0.6 * libm::sin(angle(site))));
    initial.extend([0.8; SITES]);
    format!(
        "[system]\nvariables = [{}]\nparameters = {{ k = 0.4 }}\nhamiltonian = \"-({}) - 0.5*({})\"\n{damping}\nnoise = [{}]\n\
         [system.bracket]\n{bracket}[method]\nnoise = \"{way}\"\ntime-step = 0.05\n[run]\nseed = 7\nsteps = 20\n\
         initial = {initial:?}\n",
        names.join(", "),
        sum("s.x[i]*s.x[i+1]"),
        sum("s.z[i]*s.z[i+1]"),
        noise.join(", ")
    )
}

fn end(text: &str) -> Vec<f64> {
    let run = composed(text);
    let mut walk = run.walk();
    walk.advance(20).expect("steps");
    walk.last(0).1
}

/// By templates and written out a chain draws the same numbers and goes the same way, to what the two solvers leave: rings and
/// chains, with H in one step and as flows between two halves, with damping and without.
#[test]
fn a_lattice_draws_and_moves_as_the_system_written_out() {
    let damping = "damping = { rate = \"k\" }";
    let mut compared = 0;
    for boundary in ["periodic", "open"] {
        for (way, damping, channels) in [
            ("joint", damping, &CHANNELS[..]),
            ("joint", "", &CHANNELS[..2]),
            // One template whose neighbours do not commute has no exact flow.
            ("split", damping, &CHANNELS[..1]),
            ("split", "", &[CHANNELS[0], CHANNELS[2]]),
        ] {
            let text = by_templates(boundary, way, damping, channels);
            assert!(composed(&text).method.lattice().is_some());
            let (swept, written) = (
                end(&text),
                end(&written_out(boundary, way, damping, channels)),
            );
            // 20 steps of solvers that stop at round-off of states of size 1.
            let apart = distance(&swept, &written);
            assert!(apart < 1e-12, "{boundary} {way} {damping}: {apart:e}");
            let still = text.replace(
                "noise = [{",
                "noise = [{ hamiltonian = \"s.x[i]\", strength = 0.7 }, {",
            );
            assert!(distance(&end(&still), &swept) > 1e-3, "noise moves nothing");
            compared += 1;
        }
    }
    assert_eq!(compared, 8);
}

/// Sublattices of an open chain are the same two by templates and written out. There the flows sweep over one set of fields,
/// and are one kernel and flows of their own here.
#[test]
fn sublattices_of_a_lattice_draw_and_move_as_those_written_out() {
    for (damping, channels) in [
        ("damping = { rate = \"k\" }", &CHANNELS[..1]),
        ("", &[CHANNELS[0], CHANNELS[2]]),
        ("damping = { rate = \"k\" }", &[CHANNELS[2]]),
    ] {
        let by_sublattices =
            |text: String| text.replace("[method]\n", "[method]\nstepper = \"sublattices\"\n");
        let text = by_sublattices(by_templates("open", "split", damping, channels));
        assert!(composed(&text).method.lattice().is_some());
        let written = by_sublattices(written_out("open", "split", damping, channels));
        assert!(composed(&written).method.lattice().is_none());
        // 20 steps whose flows round states of size 1 in another order.
        let apart = distance(&end(&text), &end(&written));
        assert!(apart < 1e-13, "{damping}: {apart:e}");
        let other = text.replace("stepper = \"sublattices\"\n", "");
        let between = distance(&end(&text), &end(&other));
        assert!(between > 1e-6 && between < 1e-2, "{between:e}");
    }
}

/// A resumed walk draws on where it stood, and lengths of spins stay.
#[test]
fn a_lattice_goes_on_with_the_numbers_of_the_next_step() {
    let text = by_templates("periodic", "joint", "damping = { rate = \"k\" }", &CHANNELS);
    let run = composed(&text);
    let mut whole = run.walk();
    whole.advance(20).expect("steps");
    let mut first = run.walk();
    first.advance(7).expect("steps");
    let mut rest = run.walk();
    rest.restore(&first.checkpoint())
        .expect("a memory of the same walk");
    rest.advance(13).expect("steps");
    assert_eq!(whole.last(0).1, rest.last(0).1);
    let state = whole.last(0).1;
    for site in 0..SITES {
        let length: f64 = (0..3)
            .map(|c| state[c * SITES + site] * state[c * SITES + site])
            .sum();
        assert!((length - 1.0).abs() < 1e-13, "{length}");
    }
    assert_eq!(noisy(&run).channels(), 2 * SITES + 1);
}

/// Formulas that couple all sites have no templates, and the message says so.
#[test]
fn channels_that_couple_all_sites_are_refused() {
    let text = by_templates("periodic", "joint", "", &[("sum(i, s.x[i])^2", "0.1")]);
    let rate = by_templates(
        "periodic",
        "joint",
        "damping = { rate = \"sum(i, s.x[i]^2)\" }",
        &CHANNELS[..1],
    );
    let registry = leafwise::core::Registry::with_builtin();
    for (text, says) in [(text, "sums over sites"), (rate, "sum")] {
        let long = text.replace("length = 9", "length = 1000");
        let refusal = compose(&document(&long, &[]), &registry).err();
        let message = refusal.expect("refused").message;
        assert!(message.contains(says), "{message}");
    }
}

/// Flows of sites that meet do not commute, and cannot be one flow of a split step.
#[test]
fn a_split_channel_whose_sites_do_not_commute_is_refused() {
    let text = by_templates("periodic", "split", "", &CHANNELS[1..2]);
    let registry = leafwise::core::Registry::with_builtin();
    let refusal = compose(&document(&text, &[]), &registry).err();
    let refusal = refusal.expect("refused");
    assert!(
        refusal.message.contains("do not commute"),
        "{}",
        refusal.message
    );
    let joint = text.replace("noise = \"split\"", "noise = \"joint\"");
    composed(&joint);
}

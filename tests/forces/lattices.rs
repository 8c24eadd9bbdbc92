//! Forces and damping on lattices that are stepped by templates.

use leafwise::core::{Registry, Structure};
use leafwise::scene::compose;
use leafwise_tests::numbers::distance;
use leafwise_tests::scenes::{composed, document};

/// q[i]″ = q[i+1] − 2 q[i] + q[i−1] − g q[i]′ on a ring of 1000 sites, friction by a formula for every site.
fn friction_on_a_ring(step: f64, steps: u64) -> String {
    format!(
        "[system]\nfamilies = {{ q = 1000, p = 1000 }}\nbracket = {{ \"q[i],p[i]\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
         hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2)\"\nparameters = {{ g = 0.3 }}\nforces = {{ \"q[i]\" = \"g*p[i]\" }}\n\
         [method]\ntime-step = {step:?}\n[run]\nsteps = {steps}\n[run.initial]\n\"q[i]\" = \"cos(2*pi*250*i/N)\"\n\"p[i]\" = 0\n"
    )
}

/// Against the mode of wave number π/2, ω² = 2: of order 2 on a lattice of any length, and the chain that is written out goes
/// the same way.
#[test]
fn friction_by_templates_follows_a_mode_of_a_long_ring() {
    let t = 3.0;
    let (fall, rate) = (0.15, libm::sqrt(2.0 - 0.15 * 0.15));
    let exact = libm::exp(-fall * t) * (libm::cos(rate * t) + fall / rate * libm::sin(rate * t));
    let mut errors = Vec::new();
    for steps in [30, 60, 120] {
        let run = composed(&friction_on_a_ring(t / steps as f64, steps));
        assert_eq!(
            run.method.lattice().map(|lattice| lattice.length()),
            Some(1000)
        );
        assert_eq!(run.method.map().properties().structure, Structure::Leaves);
        let mut walk = run.walk();
        walk.advance(steps).expect("steps");
        let state = walk.last(0).1;
        let error = (0..1000).step_by(4).map(|site| (state[site] - exact).abs());
        errors.push(error.fold(0.0, f64::max));
    }
    for pair in errors.windows(2) {
        let order = libm::log2(pair[0] / pair[1]);
        assert!((order - 2.0).abs() < 0.05, "{errors:?}");
    }
    let ends = [
        friction_on_a_ring(0.05, 40).replace("1000", "16"),
        friction_on_a_ring(0.05, 40).replace("1000", "8"),
    ];
    let ends = ends.map(|text| {
        let text = text.replace("250*i/N", "i/4");
        let run = composed(&text);
        let mut walk = run.walk();
        walk.advance(40).expect("steps");
        (run.method.lattice().is_some(), walk.last(0).1[..8].to_vec())
    });
    assert!(ends[0].0 && !ends[1].0);
    assert!(distance(&ends[0].1, &ends[1].1) < 1e-13);
}

/// On a long lattice forces repeat from site to site, and what cannot is refused with what to write.
#[test]
fn forces_that_do_not_repeat_are_refused_on_long_lattices() {
    let registry = Registry::with_builtin();
    let text = friction_on_a_ring(0.1, 1);
    let cases = [
        ("system.forces", "[\"p[0]\"]", "one by one"),
        ("system.damping", "{ rate = \"p[0]\" }", "p[0]"),
        ("system.damping", "{ rate = \"sum(i, p[i]^2)\" }", "sum"),
        (
            "system.damping",
            "{ rate = 0.1, metric = [1] }",
            "one by one",
        ),
        (
            "system.damping",
            "{ rate = -0.1 }",
            "must be finite and not negative",
        ),
        (
            "system.damping",
            "{ rate = 0.1, metric = { \"p[i]\" = \"-1\" } }",
            "eigenvalue -1",
        ),
        ("system.forces", "{ \"p[3]\" = \"1\" }", "p[3]"),
        ("system.forces", "{ \"p[i]\" = \"q[3]\" }", "q[3]"),
        ("system.forces", "{ \"r[i]\" = \"1\" }", "r"),
        (
            "method.dynamics",
            "\"hamilton-jacobi\"",
            "this system has forces",
        ),
        ("method.stepper", "\"splitting\"", "this system has forces"),
    ];
    for (key, value, says) in cases {
        let refusal = compose(&document(&text, &[(key, value)]), &registry).err();
        let message = refusal.unwrap_or_else(|| panic!("{key} = {value}")).message;
        assert!(message.contains(says), "{key} = {value}: {message}");
    }
}

/// A metric that is negative at one site of many would feed energy there.
#[test]
fn a_metric_is_judged_at_every_site() {
    let text = friction_on_a_ring(0.1, 1);
    let damping = "damping = { rate = 0.1, metric = { \"p[i]\" = \"a[i]\" } }";
    let text = text.replace("forces = { \"q[i]\" = \"g*p[i]\" }", damping);
    let at = |value: &str| {
        let parameters = format!("g = 0.3, \"a[i]\" = 1, \"a[500]\" = {value} ");
        let text = text.replace("g = 0.3 ", &parameters);
        compose(&document(&text, &[]), &Registry::with_builtin())
    };
    assert!(at("0").is_ok());
    let refusal = at("-1e-3").err().expect("refused");
    assert!(
        refusal.message.contains("-0.001 at p[500]"),
        "{}",
        refusal.message
    );
}

//! Guiding centres in Boozer coordinates: closed forms of transits and bounces, the tokamak of the library, the axis.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::f64::consts::PI;
use std::fs;

use leafwise::core::Registry;
use leafwise::equilibrium::{Boozer, BoozerData, Ions, Species, written_in_boozer};
use leafwise::scene::{ComposedRun, SceneDocument, compose};
use leafwise_tests::numbers::distance;
use leafwise_tests::scenes::{composed, end};

/// |B| of s, θ and ζ.
type Strength = fn(f64, f64, f64) -> f64;

/// Numbers on surfaces, as another program would have them.
struct Sampled {
    periods: u32,
    edge_flux: f64,
    surfaces: usize,
    nodes: [usize; 2],
    profiles: [fn(f64) -> f64; 3],
    strength: Strength,
}

impl Sampled {
    fn field(&self) -> Boozer {
        let at = |k: usize| k as f64 / (self.surfaces - 1) as f64;
        let s: Vec<f64> = (0..self.surfaces).map(at).collect();
        let [iota, g, i] = self.profiles.map(|f| s.iter().map(|s| f(*s)).collect());
        let [along_theta, along_zeta] = self.nodes;
        let mut strength = Vec::new();
        for s in &s {
            for j in 0..along_theta {
                for l in 0..along_zeta {
                    let theta = 2.0 * PI * j as f64 / along_theta as f64;
                    let turn = along_zeta as f64 * f64::from(self.periods);
                    strength.push((self.strength)(*s, theta, 2.0 * PI * l as f64 / turn));
                }
            }
        }
        let data = BoozerData {
            periods: self.periods,
            edge_flux: self.edge_flux,
            s,
            iota,
            g,
            i,
            nodes: self.nodes,
            strength,
        };
        Boozer::new(data).expect("a field")
    }

    /// The scene that is written, with other keys.
    fn run(&self, nodes: usize, overrides: &[(&str, String)]) -> ComposedRun {
        let ions = Ions {
            species: Species::Proton,
            energy: 10.0,
            pitch: 0.5,
            surface: 0.5,
            members: 0,
            seed: 1,
        };
        let written = written_in_boozer(&self.field(), &ions, (nodes, 5), "test.json");
        let written = written.expect("a scene");
        let place = tempfile::tempdir().expect("a directory");
        for (name, content) in &written.files {
            fs::write(place.path().join(name), content).expect("a file");
        }
        let overrides: Vec<(String, String)> = overrides
            .iter()
            .map(|(key, value)| ((*key).to_owned(), value.clone()))
            .collect();
        let name = place.path().join("scene.toml");
        let registry = Registry::with_builtin();
        let name = name.to_string_lossy();
        let document = SceneDocument::parse_with(&name, &written.scene, &overrides, &registry);
        let document = document.unwrap_or_else(|errors| panic!("{errors}"));
        compose(&document, &registry).unwrap_or_else(|refusal| panic!("{refusal}"))
    }
}

/// Large aspect ratio: B = 2 (1 − 0.3 √s cos θ).
const TOKAMAK: Sampled = Sampled {
    periods: 1,
    edge_flux: 0.4,
    surfaces: 9,
    nodes: [8, 1],
    profiles: [|_| 0.6, |_| 3.2, |_| 0.0],
    strength: |s, theta, _| 2.0 * (1.0 - 0.3 * libm::sqrt(s) * libm::cos(theta)),
};

/// Keys of a run from s = 0.49, θ = 0 with u and μ, whose q/m makes the orbit so thin as 1/q.
fn orbit((u, mu, ratio): (f64, f64, f64), step: f64, steps: usize) -> Vec<(&'static str, String)> {
    // B = 2 (1 − 0.21) there.
    let state = format!("[0.7, 0, 0, {:?}]", u / 1.58);
    vec![
        ("run.initial", state),
        ("run.steps", steps.to_string()),
        ("method.time-step", format!("{step:?}")),
        ("system.parameters.mu", format!("{mu:?}")),
        ("system.parameters.charge_to_mass", format!("{ratio:?}")),
    ]
}

/// The times at which a coordinate rises through 0, by the polynomial of time through six samples about each.
fn rises(run: &ComposedRun, coordinate: usize, step: f64) -> Vec<f64> {
    let mut walk = run.walk();
    let mut seen = vec![run.own(walk.state())[coordinate]];
    for _ in 0..run.plan.steps {
        walk.step().expect("a step");
        seen.push(run.own(walk.state())[coordinate]);
    }
    let mut times = Vec::new();
    for k in 3..seen.len() - 2 {
        if seen[k - 1] < 0.0 && seen[k] >= 0.0 {
            let nodes: Vec<usize> = (k - 3..k + 3).collect();
            let part = |&at: &usize| {
                let others = nodes.iter().filter(|other| **other != at);
                let weight = others.fold(1.0, |product, &other| {
                    product * seen[other] / (seen[other] - seen[at])
                });
                weight * step * at as f64
            };
            times.push(nodes.iter().map(part).sum());
        }
    }
    times
}

/// ∮ G dθ/(ι B u) along a thin orbit with v² = u² + 2μB, between the turning points of θ = θ_b sin φ, twice.
fn bounce(u: f64, mu: f64) -> f64 {
    let strength = |theta: f64| 2.0 * (1.0 - 0.21 * libm::cos(theta));
    let energy = u * u / 2.0 + mu * strength(0.0);
    // μ B(θ_b) = E.
    let cosine = (1.0 - energy / (2.0 * mu)) / 0.21;
    let tip = libm::acos(cosine);
    let count = 400;
    let parts = (0..count).map(|k| {
        let phi = PI * (f64::from(k) + 0.5) / f64::from(count) - PI / 2.0;
        let theta = tip * libm::sin(phi);
        // E − μB = 2·0.21 μ (cos θ − cos θ_b) = 4·0.21 μ sin((θ_b + θ)/2) sin((θ_b − θ)/2).
        let left =
            4.0 * 0.21 * mu * libm::sin((tip + theta) / 2.0) * libm::sin((tip - theta) / 2.0);
        3.2 / (0.6 * strength(theta) * libm::sqrt(2.0 * left)) * tip * libm::cos(phi)
    });
    2.0 * parts.sum::<f64>() * PI / f64::from(count)
}

/// A thin orbit passes around in 2πG/(ι B₀ u √(1 − ε²)) and bounces in the integral above. The width falls as 1/q, and so does the
/// difference of the periods.
#[test]
fn transits_and_bounces_have_their_closed_forms() {
    // All speed along B.
    let u = 1.0;
    let transit = 2.0 * PI * 3.2 / (0.6 * 2.0 * u * libm::sqrt(1.0 - 0.21 * 0.21));
    let step = transit / 400.0;
    let mut off = Vec::new();
    for ratio in [1e4, 2e4] {
        let run = TOKAMAK.run(33, &orbit((u, 0.0, ratio), step, 850));
        // From θ = 0 on; the second rise is a transit after the first.
        let times = rises(&run, 1, step);
        off.push((times[1] - times[0]) / transit - 1.0);
    }
    println!("transit off by {off:?}");
    assert!(
        off[0].abs() < 1e-3 && (off[0] / off[1] - 2.0).abs() < 0.1,
        "{off:?}"
    );

    let (u, mu) = (0.3, 0.3);
    let period = bounce(u, mu);
    let step = period / 400.0;
    let mut off = Vec::new();
    for ratio in [1e4, 2e4] {
        let run = TOKAMAK.run(33, &orbit((u, mu, ratio), step, 850));
        let times = rises(&run, 1, step);
        off.push((times[1] - times[0]) / period - 1.0);
    }
    println!("bounce off by {off:?}");
    assert!(
        off[0].abs() < 1e-3 && (off[0] / off[1] - 2.0).abs() < 0.1,
        "{off:?}"
    );
}

/// ρG − (q/m)χ on a coarse table, over wide orbits.
#[test]
fn an_axisymmetric_field_keeps_the_toroidal_momentum() {
    for u in [1.0, 0.3] {
        let (ratio, step) = (40.0, 0.05);
        let run = TOKAMAK.run(17, &orbit((u, 0.3, ratio), step, 2000));
        let mut walk = run.walk();
        let momentum = |x: &[f64]| 3.2 * x[3] - ratio * 0.4 * 0.6 * (x[0] * x[0] + x[1] * x[1]);
        let size = ratio * 0.4;
        let first = momentum(run.own(walk.state()));
        let (mut moved, mut width) = (0.0_f64, [1.0_f64, 0.0]);
        for _ in 0..2000 {
            walk.step().expect("a step");
            let x = run.own(walk.state());
            moved = moved.max((momentum(x) - first).abs() / size);
            let s = x[0] * x[0] + x[1] * x[1];
            width = [width[0].min(s), width[1].max(s)];
        }
        println!(
            "u = {u}: s from {:.3} to {:.3}, momentum off by {moved:.1e}",
            width[0], width[1]
        );
        assert!(width[1] - width[0] > 0.01);
        assert!(moved < 1e-13, "{moved:e}");
    }
}

/// The tokamak of the library's `guiding-centre`, F = 1, q₀ = 2, in Boozer coordinates: ψ = 1 − √(1 − r²), χ = −r²/4,
/// tan(θ/2) = √((1 − r)/(1 + r)) tan(ϑ/2), so that B = √(1 + r²/4) (1 − r cos θ)/(1 − r²). G = 1 and I = −r²/2/√(1 − r²), with angles that
/// turn from Z to R. The edge is r = 0.2.
const LIBRARY: Sampled = Sampled {
    periods: 1,
    edge_flux: 0.020_204_102_886_728_76,
    surfaces: 17,
    nodes: [8, 1],
    profiles: [
        |s| -(1.0 - s * LIBRARY.edge_flux) / 2.0,
        |_| 1.0,
        |s| {
            let psi = s * LIBRARY.edge_flux;
            -(2.0 * psi - psi * psi) / 2.0 / (1.0 - psi)
        },
    ],
    strength: |s, theta, _| {
        let psi = s * LIBRARY.edge_flux;
        let square = 2.0 * psi - psi * psi;
        libm::sqrt(1.0 + square / 4.0) * (1.0 - libm::sqrt(square) * libm::cos(theta))
            / (1.0 - square)
    },
};

/// Bounces of the library's banana, in both coordinates. What differs is ρ B_ψ dψ, which Boozer's one-form leaves out: it moves the
/// orbit by the square of its width, which falls with the speed.
#[test]
fn the_tokamak_of_the_library_has_the_same_bounces() {
    let mut off = Vec::new();
    for slower in [1.0, 2.0, 4.0] {
        let (u, mu) = (4.306e-4 / slower, 2.250e-6 / (slower * slower));
        let (step, steps) = (125.0 * slower, 800);
        let library = composed(&format!(
            "[system]\nlibrary = \"guiding-centre\"\nparameters = {{ mu = {mu:?} }}\n[method]\ndynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\n\
             time-step = {step:?}\n[run]\ninitial = [1.05, 0, 0, {u:?}]\nsteps = {steps}\n"
        ));
        let radius = 0.05_f64;
        let psi = 1.0 - libm::sqrt(1.0 - radius * radius);
        let strength = libm::sqrt(1.0 + radius * radius / 4.0) / 1.05;
        let x = libm::sqrt(psi / LIBRARY.edge_flux);
        let boozer = LIBRARY.run(
            65,
            &[
                ("run.initial", format!("[{x:?}, 0, 0, {:?}]", u / strength)),
                ("run.steps", steps.to_string()),
                ("method.time-step", format!("{step:?}")),
                ("system.parameters.mu", format!("{mu:?}")),
                ("system.parameters.charge_to_mass", "1".to_owned()),
            ],
        );
        let [here, there] = [rises(&boozer, 1, step), rises(&library, 1, step)];
        let [here, there] = [here[1] - here[0], there[1] - there[0]];
        off.push(here / there - 1.0);
        println!(
            "slower by {slower}: {here} and {there}, off by {:.2e}",
            here / there - 1.0
        );
    }
    assert!(off[0].abs() < 1e-5, "{off:?}");
    for pair in off.windows(2) {
        assert!((pair[0] / pair[1] - 4.0).abs() < 0.2, "{off:?}");
    }
}

/// Orbits through the axis: the table's field and the field's formula, which is smooth there in x and y, go the same way.
#[test]
fn orbits_pass_the_axis() {
    let stellarator = Sampled {
        periods: 5,
        nodes: [8, 8],
        strength: |s, theta, zeta| {
            2.0 - 0.3 * libm::sqrt(s) * libm::cos(theta)
                + 0.2 * s * libm::cos(2.0 * theta - 5.0 * zeta)
        },
        ..TOKAMAK
    };
    let mut off = Vec::new();
    for nodes in [17, 33, 65] {
        let keys = [
            ("run.initial", "[0.02, 0, 0, 0.2]".to_owned()),
            ("run.steps", "600".to_owned()),
            ("method.time-step", "0.02".to_owned()),
            ("system.parameters.mu", "0.3".to_owned()),
            ("system.parameters.charge_to_mass", "20.0".to_owned()),
        ];
        let table = stellarator.run(nodes, &keys);
        let mut all = keys.to_vec();
        let field = "2 - 0.3*x + 0.2*((x^2 - y^2)*cos(5*zeta) + 2*x*y*sin(5*zeta))";
        all.push(("system.define.B", format!("\"{field}\"")));
        let formula = stellarator.run(17, &all);
        let [table, formula] = [table, formula].map(|run| end(&run));
        off.push(distance(&table, &formula));
    }
    println!("off by {off:?} with 17, 33, 65 nodes");
    // Splines of degree 5 meet the quadratic in x and y up to s = 1. Where the table goes on beyond, they ring, and that falls by 0.43
    // from node to node: by 6 nodes from x = 0.2 to the edge with the first table, by 12 and 24 with the others. What is left is the
    // error of 16 nodes of ζ.
    let fall = libm::pow(0.43, 5.8);
    assert!(off[0] < fall * 2e-5, "{off:?}");
    assert!(
        off[1] < 2.0 * fall * off[0] && off[2] < off[1] / 2.0,
        "{off:?}"
    );
}

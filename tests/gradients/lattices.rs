//! Derivatives on lattices that are stepped by templates: against the same systems with every site written out, of tangents
//! against covectors, and against differences of whole runs.

use std::fmt::Write as _;

use leafwise::core::Differential;
use leafwise::core::gradient::{Plan, Way};
use leafwise::scene::ComposedRun;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::scenes::composed;

use super::{cotangents, differences, dot, trajectory};

/// A lattice of families by templates.
struct Lattice {
    families: &'static [&'static str],
    sites: usize,
    /// How many sites the first family lacks; open chains alone have any.
    lacks: usize,
    /// {a, b} = entry at every site.
    bracket: &'static [(&'static str, &'static str, &'static str)],
    /// Terms of H at every site.
    hamiltonian: &'static [&'static str],
    parameters: &'static str,
    /// What else stands in `[system]`.
    more: &'static str,
    /// Of coordinate k at site i, written with both.
    initial: fn(usize, f64) -> f64,
}

const VOLTERRA: Lattice = Lattice {
    families: &["x"],
    sites: 30,
    lacks: 0,
    bracket: &[("x[i]", "x[i+1]", "k*x[i]*x[i+1]")],
    hamiltonian: &["c*x[i]"],
    parameters: "{ k = 0.8, c = 1.3 }",
    more: "",
    initial: |_, i| 1.0 + 0.3 * libm::sin(1.7 * i),
};

const SPRINGS: Lattice = Lattice {
    families: &["q", "p"],
    sites: 14,
    lacks: 0,
    bracket: &[("q[i]", "p[i]", "1")],
    hamiltonian: &[
        "p[i]^2/2",
        "c*(q[i+1] - q[i])^2/2 + a*(q[i+1] - q[i])^3",
        "-cos(q[i])",
    ],
    parameters: "{ c = 1.1, a = 0.2 }",
    more: "",
    initial: |k, i| 0.4 * libm::cos(1.3 * i + k as f64),
};

/// Its pieces are the same however it is written: kinetic and potential energy.
const ROTORS: Lattice = Lattice {
    hamiltonian: &["p[i]^2/2", "-c*cos(q[i+1] - q[i])", "-a*cos(q[i])"],
    ..SPRINGS
};

const TODA: Lattice = Lattice {
    families: &["a", "b"],
    sites: 14,
    lacks: 1,
    bracket: &[("a[i]", "b[i]", "-a[i]"), ("a[i]", "b[i+1]", "a[i]")],
    hamiltonian: &["b[i]^2/2", "c*a[i]^2"],
    parameters: "{ c = 1.2 }",
    more: "",
    initial: |k, i| [1.0, 0.0][k] + 0.3 * libm::sin(1.7 * i + k as f64),
};

const SPINS: Lattice = Lattice {
    families: &["x", "y", "z"],
    sites: 9,
    lacks: 0,
    bracket: &[
        ("x[i]", "y[i]", "-z[i]"),
        ("y[i]", "z[i]", "-x[i]"),
        ("z[i]", "x[i]", "-y[i]"),
    ],
    hamiltonian: &["-J*(x[i]*x[i+1] + y[i]*y[i+1] + z[i]*z[i+1])", "-B*z[i]"],
    parameters: "{ J = 0.9, B = 0.4 }",
    more: "",
    initial: |k, i| match k {
        0 => 0.6 * libm::cos(0.9 * i),
        1 => 0.6 * libm::sin(0.9 * i),
        _ => 0.8,
    },
};

/// Likewise: spins turn about z, then about x.
const TURNING: Lattice = Lattice {
    hamiltonian: &["J*z[i]*z[i+1]", "B*x[i]"],
    ..SPINS
};

const DAMPED: Lattice = Lattice {
    parameters: "{ J = 0.9, B = 0.4, g = 0.1 }",
    more: "damping = { rate = \"g\" }",
    ..SPINS
};

/// Spins that turn apart: the field at each depends on no other.
const APART: Lattice = Lattice {
    hamiltonian: &["-B*z[i]"],
    ..SPINS
};

/// `hamilton-jacobi` of an order.
const SECOND: &str = "dynamics = { name = \"hamilton-jacobi\", order = 2 }";
const FOURTH: &str = "dynamics = { name = \"hamilton-jacobi\", order = 4 }";
const TRUNCATED_SECOND: &str = "realization = { name = \"karasev-truncated\", order = 4 }\ndynamics = { name = \"hamilton-jacobi\", order = 2 }";
const TRUNCATED_FOURTH: &str = "realization = { name = \"karasev-truncated\", order = 4 }\ndynamics = { name = \"hamilton-jacobi\", order = 4 }";
const SPLITTING: &str = "stepper = \"splitting\"";
const SUBLATTICES: &str = "stepper = \"sublattices\"";
const COMPOSED: &str = "stepper = \"splitting\"\ncomposition = \"kahan-li-6\"";
const FACTORS: &str = "stepper = \"splitting\"\ncomposition = \"blanes-moan-4\"";

impl Lattice {
    fn scene(&self, system: &str, initial: &str, method: &str, convention: &str) -> String {
        format!(
            "[system]\n{system}parameters = {}\nconvention = \"{convention}\"\n{}\n[method]\n{method}\ntime-step = 0.05\n[run]\nsteps = 1\n\
             initial = {initial}\n",
            self.parameters, self.more
        )
    }

    fn by_templates(&self, sites: usize, boundary: &str, method: &str) -> ComposedRun {
        let families: Vec<String> = (self.families.iter().enumerate())
            .map(|(family, name)| format!("{name} = {}", self.length(family, sites)))
            .collect();
        let bracket: Vec<String> = (self.bracket.iter())
            .map(|(a, b, entry)| format!("\"{a},{b}\" = \"{entry}\""))
            .collect();
        let sums: Vec<String> = (self.hamiltonian.iter())
            .map(|term| format!("sum(i, {term})"))
            .collect();
        let system = format!(
            "families = {{ {} }}\nboundary = \"{boundary}\"\nbracket = {{ {} }}\nhamiltonian = \"{}\"\n",
            families.join(", "),
            bracket.join(", "),
            sums.join(" + ")
        );
        let zeros: Vec<String> = (self.families.iter())
            .map(|name| format!("\"{name}[i]\" = \"1\""))
            .collect();
        let initial = format!("{{ {} }}", zeros.join(", "));
        let run = composed(&self.scene(&system, &initial, method, "{H,x}"));
        assert!(run.method.lattice().is_some(), "{system}");
        run
    }

    fn length(&self, family: usize, sites: usize) -> usize {
        sites - if family == 0 { self.lacks } else { 0 }
    }

    /// The same with single variables.
    fn written_out(&self, boundary: &str, method: &str) -> ComposedRun {
        let sites = self.sites;
        let at = |template: &str, site: usize| -> Option<String> {
            let mut text = template.to_owned();
            for (family, name) in self.families.iter().enumerate() {
                let length = self.length(family, sites);
                for (behind, place) in [(1, "[i+1]"), (0, "[i]")] {
                    let place = format!("{name}{place}");
                    if !text.contains(&place) {
                        continue;
                    }
                    let stands = match boundary {
                        "periodic" => (site + behind) % length,
                        _ => Some(site + behind).filter(|at| *at < length)?,
                    };
                    text = text.replace(&place, &format!("{name}{stands}"));
                }
            }
            Some(text)
        };
        let (mut names, mut bracket, mut terms) = (Vec::new(), String::new(), Vec::new());
        for (family, name) in self.families.iter().enumerate() {
            names.extend((0..self.length(family, sites)).map(|site| format!("\"{name}{site}\"")));
        }
        for site in 0..sites {
            for (a, b, entry) in self.bracket {
                if let (Some(a), Some(b), Some(entry)) = (at(a, site), at(b, site), at(entry, site))
                {
                    let _ = write!(bracket, "\"{a},{b}\" = \"{entry}\", ");
                }
            }
            terms.extend(self.hamiltonian.iter().filter_map(|term| at(term, site)));
        }
        let system = format!(
            "variables = [{}]\nbracket = {{ {} }}\nhamiltonian = \"{}\"\n",
            names.join(", "),
            bracket.trim_end_matches(", "),
            terms.join(" + ")
        );
        let initial = format!("{:?}", vec![1.0; names.len()]);
        composed(&self.scene(&system, &initial, method, "{H,x}"))
    }

    fn initial(&self, sites: usize) -> Vec<f64> {
        let families = 0..self.families.len();
        let of_family = |k| {
            let sites = 0..self.length(k, sites);
            sites.map(move |i| (self.initial)(k, i as f64))
        };
        families.flat_map(of_family).collect()
    }
}

/// Numbers of no symmetry, of size 1.
fn vector(length: usize, phase: f64) -> Vec<f64> {
    (0..length)
        .map(|i| libm::sin(phase + 0.7 * i as f64))
        .collect()
}

/// A step from x: its differential, and its increment.
fn stepped(run: &ComposedRun, parameters: &[f64], x: &[f64]) -> (Box<dyn Differential>, Vec<f64>) {
    let map = run.method.map();
    let mut differential = map.differential(parameters, run.plan.epsilon, run.plan.h);
    let (low, mut increment) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    let step = differential.step(x, &low, &mut increment);
    step.expect("a step");
    (differential, increment)
}

/// DΦ v + ∂_λΦ μ; DΦᵀw and ∂_λΦᵀw; DΦ⁻ᵀw and less ∂_λΦᵀ of it.
fn applied(differential: &mut dyn Differential, d: usize, parameters: usize) -> [Vec<f64>; 3] {
    let (mut tangents, mu) = (vector(2 * d, 0.3), vector(2 * parameters, 0.9));
    differential.push(&mut tangents, &mu).expect("tangents");
    let [pulled, returned] = [false, true].map(|is_inverse| {
        let (mut covector, mut gradient) = (vector(d, 1.4), vector(parameters, 0.1));
        let outcome = match is_inverse {
            false => differential.pull(&mut covector, &mut gradient),
            true => differential.pull_inverse(&mut covector, &mut gradient),
        };
        outcome.expect("a covector");
        [covector, gradient].concat()
    });
    [tangents, pulled, returned]
}

/// Both are exact for the same map, whose ends two solvers find to round-off of states of size 1: some tens of roundings, and in
/// gradients by parameters those of a sum over 30 sites.
#[test]
fn a_lattice_has_the_differential_of_the_system_written_out() {
    for (lattice, methods) in [
        (
            &VOLTERRA,
            &[
                TRUNCATED_SECOND,
                TRUNCATED_FOURTH,
                SPLITTING,
                COMPOSED,
                FACTORS,
            ][..],
        ),
        (&SPRINGS, &[SECOND, FOURTH]),
        (&ROTORS, &[SPLITTING]),
        (&TODA, &[TRUNCATED_SECOND, SPLITTING]),
        (
            &SPINS,
            &[SECOND, FOURTH, "stepper = \"spherical-midpoint\""],
        ),
        (&TURNING, &[SPLITTING, FACTORS]),
        (&DAMPED, &["dynamics = \"one-form\""]),
    ] {
        let cases = methods.iter().flat_map(|method| {
            let boundaries = ["periodic", "open"].into_iter();
            boundaries.flat_map(move |boundary| [1.0, 4.0].map(|longer| (method, boundary, longer)))
        });
        for (method, boundary, longer) in cases {
            if lattice.lacks > 0 && boundary == "periodic" {
                continue;
            }
            let swept = lattice.by_templates(lattice.sites, boundary, method);
            let written = lattice.written_out(boundary, method);
            let parameters = swept.system.parameter_values();
            assert_eq!(parameters, written.system.parameter_values());
            let x = lattice.initial(lattice.sites);
            let [mut found, mut expected] = [swept, written].map(|mut run| {
                run.plan.h *= longer;
                stepped(&run, &parameters, &x)
            });
            assert!(found.0.knows_parameters(), "{method}");
            // Of stages that solve, the one written out knows no derivatives by parameters.
            let count = match expected.0.knows_parameters() {
                true => parameters.len(),
                false => 0,
            };
            let [found, expected] = [&mut found, &mut expected].map(|(differential, increment)| {
                let [pushed, pulled, returned] = applied(differential.as_mut(), x.len(), count);
                [std::mem::take(increment), pushed, pulled, returned]
            });
            for (found, expected) in found.iter().zip(&expected) {
                let error = distance(found, expected) / largest(expected);
                println!(
                    "{:?} {boundary} {method} {longer}: {error:.1e}",
                    lattice.families
                );
                assert!(error <= 1e-13, "{found:?}\n{expected:?}");
            }
        }
    }
}

/// Lattices and methods on a thousand sites.
const LONG: [(&Lattice, &str, &str); 9] = [
    (&VOLTERRA, TRUNCATED_FOURTH, "periodic"),
    (&VOLTERRA, COMPOSED, "open"),
    (&SPRINGS, FOURTH, "periodic"),
    (&SPRINGS, SPLITTING, "open"),
    (&SPINS, SECOND, "open"),
    (&DAMPED, "dynamics = \"one-form\"", "periodic"),
    (&APART, SUBLATTICES, "periodic"),
    (&SPINS, SUBLATTICES, "periodic"),
    (&DAMPED, SUBLATTICES, "open"),
];

const SITES: usize = 1000;

/// w·(DΦ v + ∂_λΦ μ) = DΦᵀw·v + ∂_λΦᵀw·μ, and DΦ⁻ᵀDΦᵀw = w with as much taken from the gradient by parameters as was
/// added. Every component is right to some tens of roundings of its neighbours; products of random signs add up to the root of
/// their number.
#[test]
fn covectors_are_the_transpose_of_tangents_on_a_thousand_sites() {
    for (lattice, method, boundary) in LONG {
        let run = lattice.by_templates(SITES, boundary, method);
        let parameters = run.system.parameter_values();
        let x = lattice.initial(SITES);
        let (d, count) = (x.len(), parameters.len());
        let (mut differential, _) = stepped(&run, &parameters, &x);
        let (v, mu, w) = (vector(d, 0.3), vector(count, 0.9), vector(d, 1.4));
        let mut tangent = v.clone();
        differential.push(&mut tangent, &mu).expect("a tangent");
        let (mut covector, mut gradient) = (w.clone(), vec![0.0; count]);
        let pulled = differential.pull(&mut covector, &mut gradient);
        pulled.expect("a covector");
        let pairings = [dot(&w, &tangent), dot(&covector, &v) + dot(&gradient, &mu)];
        let size = libm::sqrt(dot(&w, &w) * dot(&tangent, &tangent));
        let apart = (pairings[0] - pairings[1]).abs() / size;
        let added = largest(&gradient);
        let returned = differential.pull_inverse(&mut covector, &mut gradient);
        returned.expect("a covector");
        let (away, left) = (distance(&covector, &w), largest(&gradient) / added);
        println!(
            "{:?} {method}: {apart:.1e}, {away:.1e}, {left:.1e}",
            lattice.families
        );
        assert!(apart <= 64.0 * UNIT_ROUNDOFF && pairings[0].abs() > 1e-3 * size);
        assert!(away <= 64.0 * UNIT_ROUNDOFF, "{away:e}");
        assert!(
            left <= 16.0 * libm::sqrt(d as f64) * UNIT_ROUNDOFF,
            "{left:e}"
        );
    }
}

/// Along a direction of the initial state and the parameters phases turn by about r = 2 in a unit of time: differences of order
/// 6 with δ = 0.004 are wrong by (2rδ)⁶/30 = 5e-13, and by the run's rounding over rδ, 1e-14.
#[test]
fn gradients_on_a_thousand_sites_are_those_of_differences_after_twenty_steps() {
    let plan = Plan {
        steps: 20,
        every: 5,
    };
    for (lattice, method, boundary) in LONG {
        let run = lattice.by_templates(SITES, boundary, method);
        let values = run.system.parameter_values();
        let x = lattice.initial(SITES);
        let (v, mu) = (vector(x.len(), 0.3), vector(values.len(), 0.9));
        let moved = |from: &[f64], along: &[f64], s: f64| -> Vec<f64> {
            let pairs = from.iter().zip(along);
            pairs.map(|(from, along)| from + s * along).collect()
        };
        let weights = cotangents(plan, x.len());
        let function = |s: &[f64]| {
            let values = moved(&values, &mu, s[0]);
            let reached = trajectory(&run, &values).run(&moved(&x, &v, s[0]), plan);
            dot(&reached.expect("a run").samples, &weights)
        };
        let expected = differences(&[0.0], 0.004, function)[0];
        let at = trajectory(&run, &values);
        let reached = at.run(&x, plan).expect("a run");
        for way in [Way::Back, Way::Checkpoints] {
            let is_back = way == Way::Back;
            if is_back && run.method.map().properties().self_adjoint != Some(true) {
                continue;
            }
            let gradient = at.pull(&x, &reached, &weights, plan, (true, Some(way)));
            let gradient = gradient.expect("a gradient");
            let found = dot(&gradient.initial, &v) + dot(&gradient.parameters, &mu);
            let size = libm::sqrt(dot(&gradient.initial, &gradient.initial) * dot(&v, &v));
            let error = (found - expected).abs() / size;
            let mut walk = run.walk();
            walk.advance(plan.steps).expect("a run");
            let forward = walk.statistics().operations.expect("they are counted");
            let ratio = gradient.operations.expect("they are counted") as f64 / forward as f64;
            println!(
                "{:?} {method} {way:?}: {error:.1e} of {size:.1e}, miss {:.1e}, {:.1} runs",
                lattice.families,
                gradient.miss,
                1.0 + ratio
            );
            assert!(
                error <= 1e-11 && found.abs() > 0.1 * size,
                "{found} {expected}"
            );
        }
    }
}

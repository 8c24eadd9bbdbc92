//! Many bodies: sums over pairs in loops have the motion of the system written out, and of closed forms.

mod beside;
mod derivatives;
mod shadow;
mod taylor;
mod turning;
mod verified;

use std::fmt::Write as _;

use leafwise::core::Registry;
use leafwise::core::StepError;
use leafwise::scene::ComposedRun;
use leafwise::scene::compose::compose;
use leafwise_tests::scenes::{composed, document, end};

/// A composed scene whose pairs are in loops: its system is one of numbers.
fn in_loops(text: &str) -> ComposedRun {
    let run = composed(text);
    assert!(run.system.opaque().is_some(), "pairs in loops");
    run
}

/// A ring of N vortices of strength 1 turns at Ω = (N − 1)/(4πR²). The step's own error is below (Ωh)⁷ of the radius, and
/// round-off in R grows by e^{σt} with σ ≤ N Ω/4, the rate of the ring's instability (Havelock, Phil. Mag. 11 (1931)).
#[test]
fn rings_of_vortices_turn_at_their_rate() {
    for (sites, angle, steps) in [
        (16, 0.02, 20),
        (33, 0.01, 20),
        (100, 0.004, 10),
        (1000, 5e-4, 4),
    ] {
        let n = f64::from(sites);
        let rate = (n - 1.0) / (4.0 * std::f64::consts::PI * 4.0);
        let time_step = angle / rate;
        let run = in_loops(&format!(
            "[system]\nfamilies = {{ x = {sites}, y = {sites} }}\nbracket = {{ \"x[i],y[i]\" = \"1/g[i]\" }}\n\
             parameters = {{ \"g[i]\" = 1 }}\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"-sum(i<j, g[i]*g[j]*ln((x[i] - x[j])^2 + (y[i] - y[j])^2))/(4*pi)\"\n\
             [method]\nstepper = {{ name = \"gauss\", stages = 3 }}\ntime-step = {time_step:e}\n[run]\nsteps = {steps}\n\
             [run.initial]\n\"x[i]\" = \"2*cos(2*pi*i/N)\"\n\"y[i]\" = \"2*sin(2*pi*i/N)\"\n"
        ));
        assert_eq!(
            run.method.map().properties().structure,
            leafwise::core::Structure::Exact
        );
        let x = end(&run);
        let rows = x.split_at(sites as usize);
        let centre = [rows.0, &rows.1[..sites as usize]].map(|row| row.iter().sum::<f64>());
        let squares: f64 = x[..2 * sites as usize].iter().map(|x| x * x).sum();
        assert!(
            centre.iter().all(|sum| sum.abs() <= 1e-13 * n) && (squares / n - 4.0).abs() <= 1e-13,
            "{sites}: {centre:?} {squares}"
        );
        let turned = angle * f64::from(steps);
        let grown = libm::exp(n * turned / 4.0);
        let allowed = 4e-15 * grown * f64::from(steps) + 2.0 * turned * libm::pow(angle, 6.0);
        for i in 0..sites as usize {
            let at = 2.0 * std::f64::consts::PI * i as f64 / n + turned;
            let expected = [2.0 * libm::cos(at), 2.0 * libm::sin(at)];
            for (found, expected) in [x[i], x[sites as usize + i]].iter().zip(expected) {
                assert!(
                    (found - expected).abs() <= allowed,
                    "{sites} {i}: {found} {expected} {allowed:e}"
                );
            }
        }
    }
}

const METHODS: [&str; 6] = [
    "stepper = \"rk4\"",
    "stepper = { name = \"gauss\", stages = 3 }",
    "stepper = \"implicit-midpoint\"",
    "stepper = \"splitting\"",
    "stepper = \"splitting\"\ncomposition = \"suzuki-4\"",
    "stepper = \"splitting\"\ncomposition = \"nystrom-6-long\"",
];

fn start(i: usize) -> [f64; 6] {
    let i = i as f64;
    [
        libm::sin(1.3 * i),
        libm::cos(2.1 * i),
        libm::sin(0.7 * i + 1.0),
        0.2 * libm::cos(1.1 * i),
        0.2 * libm::sin(3.1 * i),
        0.1 * libm::cos(i),
    ]
}

fn mass(i: usize, sites: usize) -> f64 {
    (1.0 + 0.5 * libm::sin(i as f64)) / sites as f64
}

const STARTS: &str = "[run.initial]\n\"x[i]\" = \"sin(1.3*i)\"\n\"y[i]\" = \"cos(2.1*i)\"\n\"z[i]\" = \"sin(0.7*i + 1)\"\n\
     \"u[i]\" = \"0.2*cos(1.1*i)\"\n\"v[i]\" = \"0.2*sin(3.1*i)\"\n\"w[i]\" = \"0.1*cos(i)\"\n";

/// Gravity softened at 0.1 of bodies of different masses, in the coordinates x, y, z and velocities u, v, w.
fn gravity(sites: usize, method: &str) -> String {
    format!(
        "[system]\nfamilies = {{ x = {sites}, y = {sites}, z = {sites}, u = {sites}, v = {sites}, w = {sites} }}\n\
         parameters = {{ \"m[i]\" = \"(1 + 0.5*sin(i))/N\", e = 0.1 }}\nconvention = \"{{x,H}}\"\n\
         bracket = {{ \"x[i],u[i]\" = \"1/m[i]\", \"y[i],v[i]\" = \"1/m[i]\", \"z[i],w[i]\" = \"1/m[i]\" }}\n\
         hamiltonian = \"sum(i, m[i]*(u[i]^2 + v[i]^2 + w[i]^2)/2) - \
         sum(i<j, m[i]*m[j]/sqrt((x[i] - x[j])^2 + (y[i] - y[j])^2 + (z[i] - z[j])^2 + e^2))\"\n\
         [method]\n{method}\ntime-step = 0.02\n[run]\nsteps = 10\n{STARTS}"
    )
}

/// The same with every variable and every pair written out.
fn written_out(sites: usize, method: &str) -> String {
    let names =
        |family: &str| -> Vec<String> { (0..sites).map(|i| format!("{family}{i}")).collect() };
    let all: Vec<String> = ["x", "y", "z", "u", "v", "w"]
        .iter()
        .flat_map(|f| names(f))
        .collect();
    let quoted: Vec<String> = all.iter().map(|name| format!("\"{name}\"")).collect();
    let (mut bracket, mut energy) = (String::new(), String::from("0"));
    for i in 0..sites {
        let m = mass(i, sites);
        for (q, p) in [("x", "u"), ("y", "v"), ("z", "w")] {
            let _ = write!(bracket, "\"{q}{i},{p}{i}\" = \"1/{m:e}\", ");
            let _ = write!(energy, " + {m:e}*{p}{i}^2/2");
        }
        for j in i + 1..sites {
            let mm = m * mass(j, sites);
            let _ = write!(
                energy,
                " - {mm:e}/sqrt((x{i} - x{j})^2 + (y{i} - y{j})^2 + (z{i} - z{j})^2 + 0.01)"
            );
        }
    }
    let initial: Vec<String> = (0..6)
        .flat_map(|c| (0..sites).map(move |i| format!("{:e}", start(i)[c])))
        .collect();
    format!(
        "[system]\nvariables = [{}]\nconvention = \"{{x,H}}\"\nbracket = {{ {} }}\nhamiltonian = \"{energy}\"\n\
         [method]\n{method}\ntime-step = 0.02\n[run]\nsteps = 10\ninitial = [{}]\n",
        quoted.join(", "),
        bracket.trim_end_matches(", "),
        initial.join(", ")
    )
}

fn energy(run: &ComposedRun, x: &[f64]) -> f64 {
    let parameters = run.system.parameter_values();
    let mut invariants =
        leafwise::core::system::SystemInvariants::new(&run.system, &parameters).expect("code");
    let mut values = [0.0];
    invariants.evaluate(x, &mut values);
    values[0]
}

/// Energy and ten steps of 20 bodies are those of the system written out by single variables: velocities below 1, ten steps of
/// at most 20 terms each, and stages solved to a few units in the last place.
#[test]
fn gravity_in_loops_is_gravity_written_out() {
    let sites = 20;
    for method in METHODS {
        let (run, whole) = (
            in_loops(&gravity(sites, method)),
            composed(&written_out(sites, method)),
        );
        let initial = [&run, &whole].map(|run| energy(run, &run.plan.initial));
        assert!(
            (initial[0] - initial[1]).abs() <= 1e-13,
            "{method}: {initial:?}"
        );
        let (found, expected) = (end(&run), end(&whole));
        for (at, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!(
                (found - expected).abs() <= 1e-13,
                "{method} {at}: {found} {expected}"
            );
        }
    }
}

/// Charges on a line that run into each other: the step that would take one through another is refused, with both names, in
/// loops as written out. In a plane r² has no sign to change, and nothing is looked at.
#[test]
fn steps_through_another_body_are_refused_by_name() {
    let line = |sites: usize, method: &str| {
        format!(
            "[system]\nfamilies = {{ q = {sites}, p = {sites} }}\nbracket = \"canonical\"\n\
             hamiltonian = \"sum(i, p[i]^2/2) + sum(i<j, 1/(q[i] - q[j])^3)\"\n[method]\n{method}\ntime-step = 0.02\n\
             [run]\nsteps = 20\ninitial = {{ \"q[i]\" = \"i\", \"p[i]\" = \"3*sin(3*i)\", \"p[7]\" = -2 }}\n"
        )
    };
    for method in [
        "stepper = \"rk4\"",
        "stepper = \"splitting\"",
        "stepper = \"splitting\"\ncomposition = \"suzuki-4\"",
    ] {
        let first = |run: &ComposedRun| {
            let mut walk = run.walk();
            let failed = (0..20).find_map(|at| walk.step().err().map(|error| (at, error)));
            let (at, error) = failed.expect("a pole");
            let StepError::Pole { denominator, .. } = error else {
                panic!("{method}: {error}");
            };
            (at, denominator)
        };
        let few = first(&composed(&line(8, method)));
        let many = first(&in_loops(&line(40, method)));
        // Those before go on along the line: the first to meet are other bodies, at another time perhaps.
        for (_, denominator) in [&few, &many] {
            let names = denominator.split(" - ").collect::<Vec<_>>();
            assert!(
                names.len() == 2 && names.iter().all(|name| name.starts_with("q[")),
                "{denominator}"
            );
        }
        assert!(many.0 <= few.0, "{method}: {few:?} {many:?}");
    }
}

/// Ten steps of Störmer and Verlet of many bodies, against loops written here.
#[test]
fn many_bodies_move_as_by_loops_written_by_hand() {
    for sites in [16_usize, 100, 1000] {
        let run = in_loops(&gravity(sites, METHODS[3]));
        let t = 0.02;
        let mut q: Vec<[f64; 3]> = (0..sites).map(|i| [0, 1, 2].map(|c| start(i)[c])).collect();
        let mut v: Vec<[f64; 3]> = (0..sites).map(|i| [3, 4, 5].map(|c| start(i)[c])).collect();
        let between = |q: &[[f64; 3]], i: usize, j: usize| {
            let d = [0, 1, 2].map(|c| q[j][c] - q[i][c]);
            (d, d.iter().map(|d| d * d).sum::<f64>() + 0.01)
        };
        let mut whole = 0.0;
        for i in 0..sites {
            whole += mass(i, sites) * v[i].iter().map(|v| v * v).sum::<f64>() / 2.0;
            for j in 0..i {
                whole -= mass(i, sites) * mass(j, sites) / libm::sqrt(between(&q, i, j).1);
            }
        }
        let found = energy(&run, &run.plan.initial);
        assert!((found - whole).abs() <= 1e-13, "{sites}: {found} {whole}");
        let drift = |q: &mut Vec<[f64; 3]>, v: &[[f64; 3]]| {
            for (q, v) in q.iter_mut().zip(v) {
                (0..3).for_each(|c| q[c] += t / 2.0 * v[c]);
            }
        };
        for _ in 0..10 {
            drift(&mut q, &v);
            for i in 0..sites {
                for j in (0..sites).filter(|j| *j != i) {
                    let (d, square) = between(&q, i, j);
                    let pull = t * mass(j, sites) / (square * libm::sqrt(square));
                    (0..3).for_each(|c| v[i][c] += pull * d[c]);
                }
            }
            drift(&mut q, &v);
        }
        let x = end(&run);
        for i in 0..sites {
            for c in 0..3 {
                for (found, expected) in [
                    (x[c * sites + i], q[i][c]),
                    (x[(c + 3) * sites + i], v[i][c]),
                ] {
                    assert!(
                        (found - expected).abs() <= 1e-13,
                        "{sites} {i}: {found} {expected}"
                    );
                }
            }
        }
    }
}

/// Rotors whose pairs are a mean field: (N² − (Σcos q)² − (Σsin q)²)/2N. By pairs and by sums of all sites they move alike,
/// however many they are.
#[test]
fn mean_fields_move_as_their_pairs() {
    for sites in [20, 600] {
        for method in METHODS {
            let [by_pairs, by_field] = [
                "sum(i<j, 1 - cos(q[i] - q[j]))/N",
                "(N^2 - sum(i, cos(q[i]))^2 - sum(i, sin(q[i]))^2)/(2*N)",
            ]
            .map(|potential| {
                let run = in_loops(&format!(
                    "[system]\nfamilies = {{ q = {sites}, p = {sites} }}\nbracket = {{ \"q[i],p[i]\" = \"-1\" }}\n\
                     hamiltonian = \"sum(i, p[i]^2/2) + {potential}\"\n[method]\n{method}\ntime-step = 0.05\n[run]\nsteps = 10\n\
                     initial = {{ \"q[i]\" = \"sin(1.3*i)\", \"p[i]\" = \"0.3*cos(0.7*i)\" }}\n"
                ));
                let x = end(&run);
                let energies = [energy(&run, &run.plan.initial), energy(&run, &x)];
                (x, energies)
            });
            let apart = by_pairs
                .0
                .iter()
                .zip(&by_field.0)
                .map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) <= 1e-12, "{sites} {method}");
            for (a, b) in by_pairs.1.iter().zip(&by_field.1) {
                assert!((a - b).abs() <= 1e-15 * f64::from(sites * sites), "{a} {b}");
            }
        }
    }
}

/// Beyond a thousand coordinates, and of an order above 2 from 24 sites on, realizations are refused with what serves.
#[test]
fn what_needs_pairs_written_out_is_refused_with_what_does_not() {
    let fourth = "dynamics = { name = \"hamilton-jacobi\", order = 4 }";
    for (sites, method) in [
        (200, ""),
        (200, fourth),
        (200, "stepper = \"sublattices\""),
        (30, fourth),
        (30, ""),
    ] {
        let text = gravity(sites, METHODS[0]).replace(METHODS[0], method);
        let refusal = compose(&document(&text, &[]), &Registry::with_builtin());
        let refusal = refusal.map(|_| ()).expect_err("too many pairs");
        let help = refusal.help.clone().unwrap_or_default();
        assert!(
            help.contains("splitting") && help.contains("gauss"),
            "{method}: {help}"
        );
    }
}

/// Recorded sums over pairs, sums over sites, functions of them and single coordinates have the values of loops written here.
#[test]
fn recorded_sums_over_pairs_are_those_of_the_state() {
    for sites in [40_usize, 500] {
        let recorded = "steps = 10\nrecord = { observables = [\"energy\", \"sum(i<j, m[i]*m[j]/((x[i] - x[j])^2 + e^2))\", \
                        \"u[3]\", \"sum(i, m[i]*(x[i]*v[i] - y[i]*u[i]))\", \"sqrt(sum(i, sum(j, x[i]*x[j]))) + 1\", \"y[0]^2\"] }";
        let text = gravity(sites, METHODS[0]).replace("steps = 10", recorded);
        let run = in_loops(&text);
        let x = run.plan.initial.clone();
        let functions = run.recorded_functions().expect("code");
        let mut values = functions
            .values(1, &run.system.parameter_values())
            .expect("code");
        let values = values.at(&x);
        let (mut pairs, mut spin, mut sum) = (0.0, 0.0, 0.0);
        for i in 0..sites {
            let own = start(i);
            spin += mass(i, sites) * (own[0] * own[4] - own[1] * own[3]);
            sum += own[0];
            for j in 0..i {
                let d = own[0] - start(j)[0];
                pairs += mass(i, sites) * mass(j, sites) / (d * d + 0.01);
            }
        }
        let expected = [
            pairs,
            start(3)[3],
            spin,
            sum.abs() + 1.0,
            start(0)[1] * start(0)[1],
        ];
        // √(Σ Σ x_i x_j) loses half of the digits of N terms.
        let allowed = [1e-12, 0.0, 1e-14, 1e-6, 1e-15];
        for ((found, expected), allowed) in values.iter().zip(expected).zip(allowed) {
            assert!(
                (found - expected).abs() <= allowed,
                "{sites}: {found} {expected}"
            );
        }
    }
}

/// Kepler's flow of every planet stays where `bodies = "whole"` asks for it, however many planets there are: the error of energy
/// per planet does not jump where other systems go in loops.
#[test]
fn whole_bodies_are_not_taken_in_a_loop() {
    let drift = |planets: usize| {
        let sites = format!("families = {{ q = {planets}, p = {planets} }}");
        let scene = format!(
            "[system]\nlibrary = \"planets\"\n{sites}\nparameters = {{ G = 1, m0 = 2, \"m[i]\" = \"0.001/(i + 1)^2\" }}\n\
             [method]\nstepper = {{ name = \"splitting\", bodies = \"whole\" }}\ntime-step = 0.1\n\
             [run]\nsteps = 40\ninitial = {{ \"q.x[i]\" = \"1 + 0.3*i\", \"q.y[i]\" = 0, \"q.z[i]\" = 0, \"p.x[i]\" = 0, \
             \"p.y[i]\" = \"0.001/(i + 1)^2*sqrt(2/(1 + 0.3*i))\", \"p.z[i]\" = 0 }}\n"
        );
        let run = composed(&scene);
        let mut walk = run.walk();
        let first = energy(&run, walk.state());
        (0..40).for_each(|_| walk.step().expect("a step"));
        (energy(&run, walk.state()) / first - 1.0).abs()
    };
    let (few, many) = (drift(15), drift(16));
    assert!(many < 2.0 * few, "{few:e} {many:e}");
}

/// A number between −1 and 1 for every two sites, without symmetry.
fn coupling(i: usize, j: usize) -> f64 {
    let at = libm::sin(12.9898 * i as f64 + 78.233 * j as f64) * 43758.5453;
    2.0 * (at - libm::floor(at)) - 1.0
}

/// Rotors with a coupling of every two: H, with the sums by indices or term by term.
fn glass(sites: usize, method: &str, is_written: bool) -> String {
    let rows = |i: usize| -> String {
        let row = (0..sites).map(|j| format!("{:e}", coupling(i, j)));
        format!("[{}]", row.collect::<Vec<_>>().join(", "))
    };
    let matrix: Vec<String> = (0..sites).map(rows).collect();
    if !is_written {
        return format!(
            "[system]\nfamilies = {{ q = {sites}, p = {sites} }}\nbracket = {{ \"q[i],p[i]\" = \"-1\" }}\n\
             parameters = {{ \"J[i,j]\" = [{}] }}\n\
             hamiltonian = \"sum(i, p[i]^2/2) - sum(i<j, J[i,j]*cos(q[i] - q[j]))/N + sum(i, j, J[i,j]*sin(q[i] + 2*q[j]))/N\"\n\
             [method]\n{method}\ntime-step = 0.05\n[run]\nsteps = 10\n\
             record = {{ observables = [\"energy\", \"sum(i<j, J[j,i]*q[i]*p[j])\", \"sum(i, J[i,i]*p[i])\"] }}\n\
             initial = {{ \"q[i]\" = \"sin(1.3*i)\", \"p[i]\" = \"0.3*cos(0.7*i)\" }}\n",
            matrix.join(", ")
        );
    }
    let mut energy = String::from("0");
    let mut bracket = String::new();
    for i in 0..sites {
        let _ = write!(bracket, "\"q{i},p{i}\" = \"-1\", ");
        let _ = write!(energy, " + p{i}^2/2");
        for j in 0..sites {
            let weight = coupling(i, j);
            let _ = write!(energy, " + ({weight:e})*sin(q{i} + 2*q{j})/{sites}");
            if i < j {
                let _ = write!(energy, " - ({weight:e})*cos(q{i} - q{j})/{sites}");
            }
        }
    }
    let families = ["q", "p"].into_iter();
    let names: Vec<String> = families
        .flat_map(|family| (0..sites).map(move |i| format!("\"{family}{i}\"")))
        .collect();
    let start = |i: usize| [libm::sin(1.3 * i as f64), 0.3 * libm::cos(0.7 * i as f64)];
    let initial: Vec<String> = (0..2)
        .flat_map(|c| (0..sites).map(move |i| format!("{:e}", start(i)[c])))
        .collect();
    format!(
        "[system]\nvariables = [{}]\nbracket = {{ {} }}\nhamiltonian = \"{energy}\"\n\
         [method]\n{method}\ntime-step = 0.05\n[run]\nsteps = 10\ninitial = [{}]\n",
        names.join(", "),
        bracket.trim_end_matches(", "),
        initial.join(", ")
    )
}

/// Couplings J_ij of few rotors are written out, and of many stand in loops: energy, field and ten steps are those of the
/// system without a matrix, to a few roundings of N terms a site.
#[test]
fn couplings_of_every_two_sites_move_as_written_out() {
    let gauss = "stepper = { name = \"gauss\", stages = 3 }";
    for (sites, method) in [
        (8, "stepper = \"splitting\"\ncomposition = \"suzuki-4\""),
        (8, gauss),
        (40, "stepper = \"rk4\""),
        (40, gauss),
        (40, "stepper = \"splitting\""),
        (40, "stepper = \"splitting\"\ncomposition = \"suzuki-4\""),
    ] {
        let run = composed(&glass(sites, method, false));
        let whole = composed(&glass(sites, method, true));
        assert_eq!(run.system.opaque().is_some(), sites == 40);
        let initial = [&run, &whole].map(|run| energy(run, &run.plan.initial));
        assert!(
            (initial[0] - initial[1]).abs() <= 1e-13,
            "{sites} {method}: {initial:?}"
        );
        let (found, expected) = (end(&run), end(&whole));
        for (at, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!(
                (found - expected).abs() <= 1e-13,
                "{sites} {method} {at}: {found} {expected}"
            );
        }
        let functions = run.recorded_functions().expect("code");
        let mut values = functions.values(1, &[]).expect("code");
        let x = run.plan.initial.clone();
        let values = values.at(&x);
        let (q, p) = x.split_at(sites);
        let (mut of_pairs, mut of_sites) = (0.0, 0.0);
        for j in 0..sites {
            of_sites += coupling(j, j) * p[j];
            for i in 0..j {
                of_pairs += coupling(j, i) * q[i] * p[j];
            }
        }
        for (found, expected) in values.iter().zip([of_pairs, of_sites]) {
            assert!(
                (found - expected).abs() <= 1e-13,
                "{sites}: {found} {expected}"
            );
        }
    }
}

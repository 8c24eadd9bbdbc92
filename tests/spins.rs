//! Chains of spins: families of vectors by closed forms and splittings, in O(N) a step, against exact motions.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::f64::consts::PI;

use leafwise::core::{Registry, StepError};
use leafwise::scene::compose;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance};
use leafwise_tests::orders::measure;
use leafwise_tests::scenes::{document, end, until};

const SPLITTING: &str = "stepper = \"splitting\"\ncomposition = \"suzuki-4\"";

const MIDPOINT: &str = "stepper = \"spherical-midpoint\"";

fn hamilton_jacobi(order: usize) -> String {
    format!("realization = \"auto\"\ndynamics = {{ name = \"hamilton-jacobi\", order = {order} }}")
}

/// so(3) at every site, H = −J Σ s_i·s_{i+1} on a ring.
fn heisenberg(sites: usize) -> String {
    format!(
        "families = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {sites} }} }}\nparameters = {{ J = 0.8 }}\n\
         bracket = {{ lie-algebra = \"so3\" }}\n\
         hamiltonian = \"-J*sum(i, s.x[i]*s.x[i+1] + s.y[i]*s.y[i+1] + s.z[i]*s.z[i+1])\""
    )
}

/// The same in a field b_i along z, a family that rests.
fn heisenberg_in_a_field(sites: usize) -> String {
    format!(
        "families = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {sites} }}, b = {sites} }}\nparameters = {{ J = 0.8 }}\n\
         bracket = {{ sum = [{{ variables = [\"s\"], bracket = {{ lie-algebra = \"so3\" }} }}, \
         {{ variables = [\"b\"], bracket = {{}} }}] }}\n\
         hamiltonian = \"sum(i, b[i]*s.z[i] - J*(s.x[i]*s.x[i+1] + s.y[i]*s.y[i+1] + s.z[i]*s.z[i+1]))\""
    )
}

const WAVE: &str =
    "{ \"s.x[i]\" = \"0.6*cos(6*pi*i/N)\", \"s.y[i]\" = \"0.6*sin(6*pi*i/N)\", \"s.z[i]\" = 0.8 }";

/// s_i = (a cos φ, a sin φ, c) with φ = k i − 2 J c (1 − cos k) t: a spin wave of any amplitude
/// (M. Lakshmanan, Physica A 84, 577 (1976), on the lattice).
fn wave_at(sites: usize, time: f64) -> Vec<f64> {
    let k = 6.0 * PI / sites as f64;
    let rate = 2.0 * 0.8 * 0.8 * (1.0 - libm::cos(k));
    let angle = |i: usize| k * i as f64 - rate * time;
    let x = (0..sites).map(|i| 0.6 * libm::cos(angle(i)));
    let y = (0..sites).map(|i| 0.6 * libm::sin(angle(i)));
    x.chain(y).chain((0..sites).map(|_| 0.8)).collect()
}

/// A ring that repeats itself every few sites is a short ring: the sweeps over the long one make the steps of the dense solve
/// over the short one, whose code is another. A site without a spin rests.
#[test]
fn sweeps_of_the_spherical_midpoint_are_its_dense_steps() {
    let field = ", \"b[i]\" = \"0.3 + 0.6*sin(pi*i/3)\"";
    assert_sweeps_are_dense_steps(8, heisenberg, "");
    assert_sweeps_are_dense_steps(6, heisenberg_in_a_field, field);
}

fn assert_sweeps_are_dense_steps(period: usize, system: fn(usize) -> String, field: &str) {
    let ring = 4 * period;
    let state = |sites: usize| {
        let rests = (3..sites).step_by(period);
        let rests: String = rests
            .map(|i| format!(", \"s.x[{i}]\" = 0, \"s.y[{i}]\" = 0, \"s.z[{i}]\" = 0"))
            .collect();
        format!(
            "{{ \"s.x[i]\" = \"0.3 + 0.2*cos(2*pi*i/{period})\", \"s.y[i]\" = \"0.4*sin(2*pi*i/{period}) + 0.1*sin(4*pi*i/{period})\", \
             \"s.z[i]\" = \"0.5 - 0.3*cos(6*pi*i/{period})\"{rests}{field} }}"
        )
    };
    let steps = 200;
    let ran = |sites| {
        let run = until(&system(sites), MIDPOINT, &state(sites), (40.0, steps));
        assert_eq!(run.method.lattice().is_some(), sites > period);
        (end(&run), run.plan.initial.clone())
    };
    let ((short, _), (long, initial)) = (ran(period), ran(ring));
    let lengths = |state: &[f64], i: usize| {
        (0..3)
            .map(|c| state[ring * c + i] * state[ring * c + i])
            .sum::<f64>()
    };
    for i in 0..ring {
        for c in 0..3 {
            // Both solve to round-off, which the motion magnifies little.
            let apart = (long[ring * c + i] - short[period * c + i % period]).abs();
            assert!(
                apart <= 16.0 * steps as f64 * UNIT_ROUNDOFF,
                "{c}, {i}: {apart:e}"
            );
        }
        let drift = (lengths(&long, i) - lengths(&initial, i)).abs();
        assert!(
            drift <= 4.0 * steps as f64 * UNIT_ROUNDOFF,
            "{i}: {drift:e}"
        );
    }
    assert_eq!(lengths(&long, 3 + period), 0.0);
    assert_eq!(long[3 * ring..], initial[3 * ring..], "what rests");
}

#[test]
fn a_spin_wave_is_met_with_the_declared_order() {
    let time = 4.0;
    for (sites, method, order, steps) in [
        (6, hamilton_jacobi(4), 4.0, [16, 23, 32, 45]),
        (6, MIDPOINT.to_owned(), 2.0, [40, 57, 80, 113]),
        (30, MIDPOINT.to_owned(), 2.0, [40, 57, 80, 113]),
        (30, hamilton_jacobi(2), 2.0, [40, 57, 80, 113]),
        (30, hamilton_jacobi(4), 4.0, [16, 23, 32, 45]),
        (30, SPLITTING.to_owned(), 4.0, [16, 23, 32, 45]),
    ] {
        let exact = wave_at(sites, time);
        let error = |steps: &usize| {
            let run = until(&heisenberg(sites), &method, WAVE, (time, *steps));
            (time / *steps as f64, distance(&end(&run), &exact))
        };
        let points: Vec<_> = steps.iter().map(error).collect();
        let found = measure(&points, 100.0 * UNIT_ROUNDOFF, 2.0).expect("errors above round-off");
        println!("{sites} sites, {method}: {found}, {points:?}");
        assert!(found.is(order, 2.0), "{sites} sites, {method}: {found}");
    }
}

/// Every |s_i| is kept to round-off by either way, and the total spin, whose symmetry the closed form shares, by Hamilton–Jacobi.
#[test]
fn lengths_are_kept_to_round_off() {
    let sites = 30;
    let start =
        "{ \"s.x[i]\" = \"sin(1 + i^2)\", \"s.y[i]\" = \"cos(3*i)\", \"s.z[i]\" = \"sin(2*i)/2\" }";
    for (method, steps, kept) in [
        (hamilton_jacobi(2), 1000_u32, sites + 3),
        (SPLITTING.to_owned(), 2000, sites),
    ] {
        let time = 0.05 * f64::from(steps);
        let run = until(&heisenberg(sites), &method, start, (time, steps as usize));
        let invariants = |x: &[f64]| {
            let spin = |i: usize| [x[i], x[sites + i], x[2 * sites + i]];
            let squares = (0..sites).map(|i| spin(i).iter().map(|v| v * v).sum());
            let totals = (0..3).map(|c| (0..sites).map(|i| spin(i)[c]).sum());
            squares.chain(totals).collect::<Vec<f64>>()
        };
        let before = invariants(run.walk().state());
        let after = invariants(&end(&run));
        let off = distance(&before[..kept], &after[..kept]);
        println!("{method}: {off:e}");
        // A random walk of roundings, some a step.
        let allowed = 16.0 * UNIT_ROUNDOFF * libm::sqrt(f64::from(steps));
        assert!(off <= allowed, "{method}: {off:e}");
    }
}

/// Over a million steps every |s_i| stays to 1e-14: a flow turns by one rounded angle, and its increment, h|ẋ| = 0.1 in size, is
/// rounded alone. Some units of that a step, at random, are √10⁶ of them at the end.
#[test]
fn lengths_stay_over_a_million_steps() {
    let sites = 6;
    let start =
        "{ \"s.x[i]\" = \"sin(1 + i^2)\", \"s.y[i]\" = \"cos(3*i)\", \"s.z[i]\" = \"sin(2*i)/2\" }";
    let run = until(
        &heisenberg(sites),
        "stepper = \"splitting\"",
        start,
        (5e4, 1_000_000),
    );
    let length = |x: &[f64], i: usize| {
        libm::sqrt(
            [0, 1, 2]
                .iter()
                .map(|c| x[c * sites + i] * x[c * sites + i])
                .sum::<f64>(),
        )
    };
    let (before, after) = (run.walk().state().to_vec(), end(&run));
    for i in 0..sites {
        let off = length(&after, i) - length(&before, i);
        println!("{i}: {off:e}");
        assert!(off.abs() <= 1e-14, "{i}: {off:e}");
    }
}

/// One site is so(3) itself: the same bits.
#[test]
fn a_single_site_is_so3_to_the_bit() {
    let site = "families = { s = { components = [\"x\", \"y\", \"z\"], length = 1 } }\nbracket = { lie-algebra = \"so3\" }\n\
                hamiltonian = \"sum(i, s.x[i]^2/2 + s.y[i]^2/3 + s.z[i]^2/5)\"";
    let alone = "variables = [\"x\", \"y\", \"z\"]\nbracket = { lie-algebra = \"so3\" }\n\
                 hamiltonian = \"x^2/2 + y^2/3 + z^2/5\"";
    for method in [hamilton_jacobi(2), hamilton_jacobi(6), SPLITTING.to_owned()] {
        let of = |system: &str| {
            let run = until(system, &method, "[0.8, 0.5, -0.6]", (50.0, 500));
            end(&run).into_iter().map(f64::to_bits).collect::<Vec<_>>()
        };
        assert_eq!(of(site), of(alone), "{method}");
    }
}

/// A family that no bracket moves is a parameter of each site: spins in a field b_i along z turn by b_i t.
#[test]
fn a_resting_family_is_a_field_of_its_own_at_every_site() {
    let system = |sites: usize| {
        format!(
            "families = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {sites} }}, b = {sites} }}\n\
             bracket = {{ sum = [{{ variables = [\"s\"], bracket = {{ lie-algebra = \"so3\" }} }}, \
             {{ variables = [\"b\"], bracket = {{}} }}] }}\nhamiltonian = \"sum(i, b[i]*s.z[i])\""
        )
    };
    // An impurity at the site 3.
    let initial = "{ \"s.x[i]\" = 0.6, \"s.y[i]\" = \"0.1*i/N\", \"s.z[i]\" = 0.8, \"b[i]\" = \"sin(2*pi*i/N)\", \"b[3]\" = 2.5 }";
    for sites in [5, 30] {
        for method in [hamilton_jacobi(2), SPLITTING.to_owned()] {
            let (time, steps) = (3.0, 30);
            let run = until(&system(sites), &method, initial, (time, steps));
            let found = end(&run);
            let field = |i: usize| match i {
                3 => 2.5,
                _ => libm::sin(2.0 * PI * i as f64 / sites as f64),
            };
            for i in 0..sites {
                let (sin, cos) = (libm::sin(field(i) * time), libm::cos(field(i) * time));
                let y = 0.1 * i as f64 / sites as f64;
                let exact = [0.6 * cos - y * sin, 0.6 * sin + y * cos, 0.8, field(i)];
                let state = [0, 1, 2, 3].map(|c| found[c * sites + i]);
                // H is linear in the spins: the step is the flow.
                assert!(
                    distance(&state, &exact) < 1e-14,
                    "{method}: {i}: {state:?} {exact:?}"
                );
            }
        }
    }
}

/// A step that turns a spin further than the chart reaches is refused on a long lattice, as it is on a short one.
#[test]
fn the_end_of_a_chart_is_seen_on_a_lattice() {
    let system = |sites: usize| {
        format!(
            "families = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {sites} }} }}\nbracket = {{ lie-algebra = \"so3\" }}\n\
             hamiltonian = \"sum(i, s.z[i])\""
        )
    };
    let initial = "{ \"s.x[i]\" = 0, \"s.y[i]\" = 0, \"s.z[i]\" = 1 }";
    for sites in [2, 30] {
        let run = until(&system(sites), &hamilton_jacobi(2), initial, (7.0, 1));
        let refused = run.walk().step().expect_err("beyond the wall");
        assert!(
            matches!(refused, StepError::LeftChart { .. }),
            "{sites}: {refused:?}"
        );
        let run = until(&system(sites), &hamilton_jacobi(2), initial, (6.0, 1));
        run.walk().step().expect("inside");
    }
}

/// All pairs of spins couple: written out up to the size where that is honest, refused beyond.
#[test]
fn sums_over_pairs_couple_all_spins() {
    let system = |sites: usize| {
        format!(
            "families = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {sites} }} }}\nbracket = {{ lie-algebra = \"so3\" }}\n\
             hamiltonian = \"sum(i<j, s.x[i]*s.x[j] + s.y[i]*s.y[j] + s.z[i]*s.z[j])\""
        )
    };
    // H = (|S|² − Σ|s_i|²)/2: every spin turns about S = Σ s_i, which rests; {H, s} = S × s in the paper's sign.
    let initial = "{ \"s.x[i]\" = \"sin(1 + i)/2\", \"s.y[i]\" = \"cos(2*i)/2\", \"s.z[i]\" = \"sin(5*i)/2\" }";
    let sites = 5;
    let run = until(&system(sites), &hamilton_jacobi(6), initial, (1.0, 100));
    let start = run.walk().state().to_vec();
    let found = end(&run);
    let spin = |x: &[f64], i: usize| [x[i], x[sites + i], x[2 * sites + i]];
    let total: Vec<f64> = (0..3)
        .map(|c| (0..sites).map(|i| spin(&start, i)[c]).sum())
        .collect();
    let rate = libm::sqrt(total.iter().map(|v| v * v).sum());
    let n: Vec<f64> = total.iter().map(|v| v / rate).collect();
    let (sin, cos) = (libm::sin(rate), libm::cos(rate));
    for i in 0..sites {
        let x = spin(&start, i);
        let along: f64 = n.iter().zip(&x).map(|(n, x)| n * x).sum();
        let cross = [
            n[1] * x[2] - n[2] * x[1],
            n[2] * x[0] - n[0] * x[2],
            n[0] * x[1] - n[1] * x[0],
        ];
        let exact: Vec<f64> = (0..3)
            .map(|c| x[c] * cos + cross[c] * sin + n[c] * along * (1.0 - cos))
            .collect();
        assert!(distance(&spin(&found, i), &exact) < 1e-10, "{i}: {exact:?}");
    }
    let text = format!(
        "[system]\n{}\n[method]\n{}\ntime-step = 0.1\n[run]\ninitial = {initial}\nsteps = 1\n",
        system(1000),
        hamilton_jacobi(2)
    );
    let refusal = compose(&document(&text, &[]), &Registry::with_builtin())
        .err()
        .expect("all sites couple");
    println!("{refusal}");
    assert!(refusal.to_string().contains("sites"), "{refusal}");
}

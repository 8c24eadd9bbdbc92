//! Lattices whose templates look far: every offset means the site that it names, at every length, by every method.

use leafwise::core::Registry;
use leafwise::scene::compose::{Motion, Stepping, compose};
use leafwise_tests::scenes::{composed, document, end, until};
use nalgebra::{DMatrix, DVector};

const PAIRS: &str = "bracket = { \"q[i],p[i]\" = \"-1\" }";

const START: &str = "{ \"q[i]\" = \"sin(1.3*i) + 0.2*cos(i^2)\", \"p[i]\" = \"0.3*cos(0.7*i)\" }";

/// H = Σ p_i²/2 + (q_{i+k} − q_i)²/2.
fn springs(sites: usize, offset: usize, boundary: &str) -> String {
    format!(
        "families = {{ q = {sites}, p = {sites} }}\n{PAIRS}\nboundary = \"{boundary}\"\n\
         hamiltonian = \"sum(i, p[i]^2/2 + (q[i+{offset}] - q[i])^2/2)\""
    )
}

/// q(t) and p(t) of q'' = −K q with K = Σ_pairs (e_i − e_j)(e_i − e_j)ᵀ, by the eigenvectors of K.
fn exact(sites: usize, offset: usize, is_ring: bool, (q, p): (&[f64], &[f64]), t: f64) -> Vec<f64> {
    let mut stiffness = DMatrix::zeros(sites, sites);
    for i in 0..sites {
        let j = i + offset;
        if is_ring || j < sites {
            let j = j % sites;
            for (a, b, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
                stiffness[(a, b)] += sign;
            }
        }
    }
    let modes = stiffness.symmetric_eigen();
    let [q, p] = [q, p].map(|v| modes.eigenvectors.tr_mul(&DVector::from_column_slice(v)));
    let (mut after, mut speed) = (q.clone(), p.clone());
    for (k, square) in modes.eigenvalues.iter().enumerate() {
        let omega = libm::sqrt(square.max(0.0));
        let (sine, cosine) = (libm::sin(omega * t), libm::cos(omega * t));
        let over = if omega > 1e-6 { sine / omega } else { t };
        after[k] = cosine * q[k] + over * p[k];
        speed[k] = cosine * p[k] - omega * sine * q[k];
    }
    let [q, p] = [after, speed].map(|modes_of| &modes.eigenvectors * modes_of);
    q.iter().chain(p.iter()).copied().collect()
}

const SPLITTING: &str = "stepper = \"splitting\"";
const SECOND: &str = "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }";
const FOURTH: &str = "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }";
const TRUNCATED: &str = "realization = { name = \"karasev-truncated\", order = 2 }\ndynamics = { name = \"hamilton-jacobi\", order = 2 }";
const GAUSS: &str = "stepper = { name = \"gauss\", stages = 2 }";
const MIDPOINT: &str = "stepper = \"implicit-midpoint\"";
const RUNGE_KUTTA: &str = "stepper = \"rk4\"";

/// A step of size h errs by less than |ωh|^{p+1} of each mode, ω ≤ 2, so that the end is off by less than 2 (2h)ᵖ of the state after
/// t = 1, and by the round-off of 20 steps.
fn check_springs(
    sites: usize,
    offset: usize,
    boundary: &str,
    (method, order): (&str, i32),
) -> bool {
    let (time, steps) = (1.0, 20);
    let run = until(
        &springs(sites, offset, boundary),
        method,
        START,
        (time, steps),
    );
    let (q, p) = run.plan.initial.split_at(sites);
    let expected = exact(sites, offset, boundary == "periodic", (q, p), time);
    let state = end(&run);
    let norm = |v: &[f64]| libm::sqrt(v.iter().map(|x| x * x).sum::<f64>());
    let apart: Vec<f64> = state.iter().zip(&expected).map(|(a, b)| a - b).collect();
    let h = time / steps as f64;
    let bound = (2.0 * libm::pow(2.0 * h, f64::from(order)) + 1e-12) * norm(&run.plan.initial);
    let error = norm(&apart);
    assert!(
        error <= bound,
        "offset {offset} on {sites} sites, {boundary}, {method}: {error:.1e} off, not {bound:.1e}"
    );
    match &run.method {
        Stepping::Lattice(lattice) => lattice.base.map().proxy_geometry.length() < sites,
        _ => false,
    }
}

#[test]
fn springs_of_every_length_move_as_their_modes() {
    let mut by_templates = 0;
    for offset in 1..=40 {
        for (sites, boundary) in [(97, "periodic"), (98, "open")] {
            for method in [(SPLITTING, 2), (SECOND, 2)] {
                by_templates += usize::from(check_springs(sites, offset, boundary, method));
            }
        }
    }
    assert_eq!(by_templates, 160, "steps of these are by templates");
}

#[test]
fn springs_move_as_their_modes_by_every_method() {
    for (at, offset) in [5, 6, 7, 11, 20, 33, 40].into_iter().enumerate() {
        // Short ones, of which every site is written out, and longer ones.
        for (sites, boundary) in [(29 + at, "open"), (86 + at, "periodic"), (87 + at, "open")] {
            for method in [(TRUNCATED, 2), (MIDPOINT, 2), (RUNGE_KUTTA, 4)] {
                check_springs(sites, offset, boundary, method);
            }
        }
        check_springs(44.max(2 * offset) + at, offset, "periodic", (GAUSS, 4));
        check_springs(6 * offset + 8, offset, "open", (FOURTH, 4));
    }
}

/// The end of a lattice by this method and by dop853, which writes out every site.
fn agrees_with_every_site_written_out(system: &str, start: &str, method: &str, bound: f64) {
    let all = "stepper = { name = \"dop853\", tolerance = 1e-13 }";
    let [own, expected] = [method, all].map(|method| end(&until(system, method, start, (1.0, 50))));
    let apart = own.iter().zip(&expected).map(|(a, b)| (a - b).abs());
    let error = apart.fold(0.0, f64::max);
    assert!(error <= bound, "{system}\n{method}: {error:.1e} off");
}

/// Pieces that repeat every second or fourth site end in any of them: each length has its own remainder. Steps of h = 0.02 of order 2
/// err by less than 10 h² here, where a term that is missing, or is there beyond the end, moves a site by a tenth and more.
#[test]
fn pieces_end_with_a_lattice_of_any_remainder() {
    for sites in 25..=44 {
        let volterra = format!(
            "families = {{ x = {sites} }}\nbracket = {{ \"x[i],x[i+2]\" = \"x[i]*x[i+2]\" }}\nboundary = \"open\"\n\
             hamiltonian = \"sum(i, x[i])\""
        );
        let chain = format!(
            "families = {{ q = {sites}, p = {sites} }}\n{PAIRS}\nboundary = \"open\"\n\
             hamiltonian = \"sum(i, p[i]^2/2 + 0.3*p[i]*p[i-1] + cos(q[i+1] - q[i]) + 0.3*q[i]*p[i+1])\""
        );
        let populations = "{ \"x[i]\" = \"1 + 0.5*sin(2*i)\" }";
        for method in [SPLITTING, SECOND] {
            agrees_with_every_site_written_out(&volterra, populations, method, 4e-3);
            agrees_with_every_site_written_out(&chain, START, method, 4e-3);
        }
    }
}

/// Brackets, parameters of sites and observables name far sites too.
#[test]
fn far_sites_in_brackets_and_parameters_are_those_that_are_named() {
    for boundary in ["periodic", "open"] {
        let spins = format!(
            "families = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = 90 }} }}\n\
             parameters = {{ a = 0.3, b = 0.7, c = 0.5, \"w[i]\" = \"sin(i)\" }}\nbracket = {{ lie-algebra = \"so3\" }}\n\
             boundary = \"{boundary}\"\n\
             hamiltonian = \"sum(i, a*s.x[i]*s.x[i+17] + b*s.y[i-6]*s.y[i+2] + c*s.z[i] + w[i+9]*s.z[i-3])\""
        );
        let start =
            "{ \"s.x[i]\" = \"0.6*cos(i)\", \"s.y[i]\" = \"0.6*sin(i)\", \"s.z[i]\" = 0.8 }";
        for method in [SPLITTING, SECOND, "stepper = \"spherical-midpoint\""] {
            agrees_with_every_site_written_out(&spins, start, method, 4e-3);
        }
        let populations = format!(
            "families = {{ x = 100 }}\nparameters = {{ \"w[i]\" = \"1 + 0.3*cos(i)\" }}\nboundary = \"{boundary}\"\n\
             bracket = {{ \"x[i+3],x[i+16]\" = \"w[i-5]*x[i+3]*x[i+16]\" }}\nhamiltonian = \"sum(i, x[i] + 0.1*x[i]*x[i+7])\""
        );
        let start = "{ \"x[i]\" = \"1 + 0.3*sin(1.3*i)\" }";
        let karasev = TRUNCATED.replace(
            "realization = { name = \"karasev-truncated\", order = 2 }",
            "realization = { name = \"karasev-truncated\", order = 3 }",
        );
        agrees_with_every_site_written_out(&populations, start, &karasev, 4e-3);
    }
}

/// Σ x_i x_{i+r} is that of the state for every r, and so are functions of sums and of single sites, which are written out.
#[test]
fn what_is_recorded_is_that_of_the_state() {
    let text = "[system]\nfamilies = { q = 90, p = 90 }\nbracket = { \"q[i],p[i]\" = \"-1\" }\nboundary = \"BOUNDARY\"\n\
                hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2)\"\n[method]\nMETHOD\ntime-step = 0.1\n[run]\n\
                initial = { \"q[i]\" = \"sin(1.3*i) + 0.2*cos(i^2)\", \"p[i]\" = \"0.1\" }\nsteps = 1\n\
                record = { observables = [\"sum(i, q[i]*q[i+6])\", \"sum(i, q[i]*q[i+24])\", \"sum(i, q[i-33]*q[i+40])\", \
                \"sum(i, q[i])^2\", \"sum(i<j, q[i]*q[j])\", \"q[50]*q[3]\"] }\n";
    for boundary in ["periodic", "open"] {
        for method in [SPLITTING, SECOND] {
            let run = composed(&text.replace("BOUNDARY", boundary).replace("METHOD", method));
            let Stepping::Lattice(lattice) = &run.method else {
                panic!("it is stepped by templates");
            };
            let mut values = [0.0; 6];
            let mut formulas = lattice.formulas.clone();
            formulas.evaluate(&run.plan.initial, &mut values);
            let q = |i: i64| -> Option<f64> {
                let i = if boundary == "periodic" {
                    i.rem_euclid(90)
                } else {
                    i
                };
                usize::try_from(i)
                    .ok()
                    .filter(|i| *i < 90)
                    .map(|i| run.plan.initial[i])
            };
            let product = |a: i64, b: i64| -> f64 {
                (0..90).filter_map(|i| Some(q(i + a)? * q(i + b)?)).sum()
            };
            let sum: f64 = (0..90).filter_map(q).sum();
            let squares = product(0, 0);
            let expected = [
                product(0, 6),
                product(0, 24),
                product(-33, 40),
                sum * sum,
                (sum * sum - squares) / 2.0,
                run.plan.initial[50] * run.plan.initial[3],
            ];
            for (value, expected) in values.iter().zip(expected) {
                // At most 4005 products of size 1.44.
                assert!(
                    (value - expected).abs() <= 1e-11,
                    "{boundary}, {method}: {values:?} {expected}"
                );
            }
        }
    }
}

/// The motion that is told is that of the offsets that are written; where no site is away from the ends, every site has its own.
#[test]
fn the_motion_is_told_with_the_offsets_that_are_written() {
    let motion = |sites: usize, boundary: &str, method: &str| {
        Motion::of(&until(
            &springs(sites, 20, boundary),
            method,
            START,
            (0.1, 1),
        ))
        .expect("a motion")
    };
    for (sites, boundary) in [(64, "periodic"), (64, "open")] {
        for method in [SPLITTING, SECOND] {
            let Motion::Site(rows) = motion(sites, boundary, method) else {
                panic!("one site stands for all");
            };
            let force = rows
                .iter()
                .find(|row| row.0 == "p[i]")
                .and_then(|row| row.1.clone());
            let named = "q[i-20] - 2*q[i] + q[i+20]";
            let sorted = |text: &str| {
                let mut parts: Vec<String> = text
                    .replace("- ", "+ -")
                    .split(" + ")
                    .map(str::to_owned)
                    .collect();
                parts.sort();
                parts
            };
            assert_eq!(
                sorted(&force.expect("a formula")),
                sorted(named),
                "{sites} {boundary} {method}"
            );
        }
    }
    let Motion::Formulas(rows) = motion(30, "open", SPLITTING) else {
        panic!("no site of thirty sees twenty to both sides");
    };
    assert_eq!(rows.len(), 60);
}

/// What couples all sites is written out up to a thousand coordinates, by every method. Beyond, pairs and mean fields are
/// taken in loops by steppers that do so, and all else is refused by its name.
#[test]
fn pairs_mean_fields_and_single_sites_are_written_out() {
    let rotors = |sites: usize, potential: &str| {
        format!(
            "families = {{ q = {sites}, p = {sites} }}\n{PAIRS}\nboundary = \"open\"\n\
             hamiltonian = \"sum(i, p[i]^2/2) + {potential}\""
        )
    };
    let pairs = "sum(i<j, 1 - cos(q[i] - q[j]))/N";
    let field = "(N^2 - sum(i, cos(q[i]))^2 - sum(i, sin(q[i]))^2)/(2*N)";
    for method in [SPLITTING, GAUSS, SECOND] {
        let [by_pairs, by_field] = [pairs, field]
            .map(|potential| end(&until(&rotors(20, potential), method, START, (1.0, 20))));
        let apart = by_pairs.iter().zip(&by_field).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) <= 1e-12, "{method}");
        agrees_with_every_site_written_out(
            &rotors(20, "q[3]^2 + sum(i, q[i]*q[0])/9"),
            START,
            method,
            4e-3,
        );
    }
    for (sites, potential, method, said) in [
        (513, pairs, SECOND, "`hamilton-jacobi` needs every pair"),
        (600, field, SECOND, "`hamilton-jacobi` needs every pair"),
        (
            2000,
            "q[3]^2",
            SPLITTING,
            "not a combination of sums over sites",
        ),
        (
            2000,
            "sum(i, q[i]*q[0])",
            SPLITTING,
            "`q[0]` is a single site",
        ),
    ] {
        let text = format!(
            "[system]\n{}\n[method]\n{method}\ntime-step = 0.1\n[run]\ninitial = {START}\nsteps = 1\n",
            rotors(sites, potential)
        );
        let refusal = compose(&document(&text, &[]), &Registry::with_builtin());
        let refusal = refusal.map(|_| ()).expect_err("too many");
        let has = format!("has {}", 2 * sites);
        for part in [said, "at most 1024 coordinates", &has] {
            assert!(refusal.message.contains(part), "{}", refusal.message);
        }
    }
}

/// A template that would take too much memory is refused with how far it looks.
#[test]
fn what_looks_too_far_is_refused_with_its_distance() {
    let text = format!(
        "[system]\n{}\n[method]\n{FOURTH}\ntime-step = 0.1\n[run]\ninitial = {START}\nsteps = 1\n",
        springs(100_000, 3000, "periodic")
    );
    let refusal = compose(&document(&text, &[]), &Registry::with_builtin());
    let message = refusal.map(|_| ()).expect_err("too far").message.clone();
    assert!(
        message.contains("3000 sites away") || message.contains("9000 sites away"),
        "{message}"
    );
}

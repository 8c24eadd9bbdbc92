//! Periodic orbits: closed forms, known orbits of three bodies, multipliers of normal modes.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::f64::consts::TAU;

use leafwise::core::gradient::{Plan, Trajectory};
use leafwise::orbit::{Hold, OrbitError, PeriodicOrbit, close};
use leafwise_tests::scenes::until;

fn orbit(
    system: &str,
    method: &str,
    initial: &str,
    (period, steps): (f64, usize),
    hold: Hold,
) -> PeriodicOrbit {
    let run = until(system, method, initial, (period, steps));
    let orbit = close(&run, (period, steps as u64), hold).unwrap_or_else(|error| panic!("{error}"));
    println!("{orbit:?}");
    orbit
}

/// Columns of DΦᴺ of the orbit of a scene.
fn monodromy(system: &str, method: &str, found: &PeriodicOrbit) -> Vec<Vec<f64>> {
    let d = found.state.len();
    let run = until(
        system,
        method,
        &format!("{:?}", found.state),
        (found.period, found.steps as usize),
    );
    let trajectory = Trajectory {
        map: run.method.map(),
        parameters: &run.system.parameter_values(),
        epsilon: run.plan.epsilon,
        h: found.period / (found.steps as f64 * run.plan.epsilon),
        goes_on: &|| true,
    };
    let mut unit = vec![0.0; d * d];
    (0..d).for_each(|i| unit[i * d + i] = 1.0);
    let plan = Plan {
        steps: found.steps,
        every: found.steps,
    };
    let pushed = trajectory.push(&found.state, (&unit, &[]), plan);
    let tangents = pushed.expect("a turn").tangents;
    tangents[d * d..]
        .chunks_exact(d)
        .map(<[f64]>::to_vec)
        .collect()
}

fn size<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> f64 {
    libm::sqrt(numbers.into_iter().map(|x| x * x).sum())
}

const ORDER_8: &str =
    "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 8 }";

/// T = 4 K(sin²(q₀/2)), by the arithmetic-geometric mean.
#[test]
fn a_pendulum_has_the_period_of_the_closed_form() {
    let system =
        "variables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 - cos(q)\"";
    let found = orbit(system, ORDER_8, "[2.0, 0]", (8.5, 200), Hold::Energy);
    let (mut a, mut b) = (1.0_f64, libm::cos(1.0));
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), libm::sqrt(a * b));
    }
    let exact = TAU / a;
    assert!(
        (found.period - exact).abs() < 1e-9,
        "{} {exact}",
        found.period
    );
    assert!(found.closure <= 1e-12, "{:e}", found.closure);
    assert_eq!((found.trivial, found.multipliers.len()), (2, 0));
    // With the period held the amplitude is found.
    let held = orbit(system, ORDER_8, "[1.9, 0]", (exact, 200), Hold::Period);
    assert_eq!(held.period.to_bits(), exact.to_bits());
    let energy = 0.5 * held.state[1] * held.state[1] - libm::cos(held.state[0]);
    assert!((energy + libm::cos(2.0)).abs() < 1e-8, "{energy}");
}

/// The second mode turns by 2π√2 in a period of the first.
#[test]
fn multipliers_of_a_normal_mode_are_those_of_the_other() {
    let system = "variables = [\"q1\", \"q2\", \"p1\", \"p2\"]\nbracket = \"canonical\"\n\
        hamiltonian = \"(p1^2 + p2^2)/2 + q1^2/2 + q2^2 + q1^4/8\"";
    let found = orbit(system, ORDER_8, "[1, 0, 0, 0]", (5.4, 200), Hold::Energy);
    assert!(found.closure <= 1e-12, "{:e}", found.closure);
    assert_eq!((found.trivial, found.multipliers.len()), (2, 2));
    assert!(found.is_stable());
    assert!(found.pairing <= 1e-10, "{:e}", found.pairing);
    let angle = found.multipliers[0].argument().abs();
    let turns = libm::sqrt(2.0) * found.period;
    assert!((libm::cos(angle) - libm::cos(turns)).abs() < 1e-8);
}

/// In leaves of two dimensions all multipliers are 1: of the time, the energy and the Casimir.
#[test]
fn a_rigid_body_comes_back_in_its_leaf() {
    let found = orbit(
        "library = \"rigid-body\"",
        ORDER_8,
        "[1, 3, 3]",
        (6.1, 200),
        Hold::Energy,
    );
    assert!(found.closure <= 1e-12, "{:e}", found.closure);
    assert_eq!((found.trivial, found.multipliers.len()), (3, 0));
    let spin: f64 = found.state.iter().map(|x| x * x).sum();
    assert!((spin - 19.0).abs() < 1e-12, "{spin}");
}

/// R. Arenstorf's orbit about the earth and the moon, as E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential
/// Equations I*, (II.0.1), has it.
#[test]
fn arenstorfs_orbit_closes() {
    let system = "variables = [\"x\", \"y\", \"px\", \"py\"]\nparameters = { mu = 0.012277471 }\nbracket = \"canonical\"\n\
        hamiltonian = \"(px^2 + py^2)/2 + y*px - x*py - (1 - mu)/sqrt((x + mu)^2 + y^2) - mu/sqrt((x - 1 + mu)^2 + y^2)\"";
    let initial = format!("[0.994, 0, 0, {:?}]", 0.994 - 2.001_585_106_379_082_5);
    let method = "stepper = { name = \"gauss\", stages = 8 }";
    let found = orbit(
        system,
        method,
        &initial,
        (17.065_216_560_157_96, 6000),
        Hold::Energy,
    );
    let columns = monodromy(system, method, &found);
    let growth = size(columns.iter().flatten());
    let trace: f64 = (0..4).map(|i| columns[i][i]).sum();
    println!("growth {growth:e} trace {trace}");
    // A turn past the moon makes changes |DΦᴺ| = 2.4e6 times as large. x is known to a half of ε |x|, and the closest of all such x
    // may be off by as much times |DΦᴺ|: 4e-10. As much again is allowed for the round-off of steps.
    let round_off = f64::EPSILON * growth;
    assert!(
        found.closure <= round_off * size(&found.state),
        "{:e} {round_off:e}",
        found.closure
    );
    assert!(
        (found.period - 17.065_216_560_158).abs() < 1e-6,
        "{}",
        found.period
    );
    assert!(!found.is_stable());
    assert_eq!((found.trivial, found.multipliers.len()), (2, 2));
    let [large, small] = [0, 1].map(|at| found.multipliers[at].re);
    // DOP853 at a tolerance of 1e-13, with the variational equations written out, has 285.4036.
    assert!((large - 285.4036).abs() < 1e-3, "{large}");
    // DΦᴺ ≈ μ x yᵀ/(yᵀx) has |DΦᴺ| = μ κ, with κ = |x| |y|/|yᵀx| the condition of μ and of 1/μ. Its round-off ε |DΦᴺ| moves both by
    // ε |DΦᴺ| κ = ε |DΦᴺ|²/μ = 5e-6, next to 1/μ by a part of ε |DΦᴺ|² = 1e-3.
    let moved = round_off * growth / large;
    assert!((large + small - (trace - 2.0)).abs() <= moved);
    assert!(found.pairing <= moved * large, "{:e}", found.pairing);
}

/// The figure eight of A. Chenciner and R. Montgomery, whose multipliers turn by 0.00842272 and 0.29809253 of a turn (C. Simó,
/// *Dynamical properties of the figure eight solution*, Contemporary Mathematics 292 (2002)).
#[test]
fn the_figure_eight_closes_and_is_stable() {
    let names = "\"x1\", \"y1\", \"x2\", \"y2\", \"x3\", \"y3\", \"px1\", \"py1\", \"px2\", \"py2\", \"px3\", \"py3\"";
    let system = format!(
        "variables = [{names}]\nbracket = \"canonical\"\n\
         hamiltonian = \"(px1^2 + py1^2 + px2^2 + py2^2 + px3^2 + py3^2)/2 - 1/sqrt((x1 - x2)^2 + (y1 - y2)^2) \
         - 1/sqrt((x1 - x3)^2 + (y1 - y3)^2) - 1/sqrt((x2 - x3)^2 + (y2 - y3)^2)\""
    );
    let initial = "[0.97000436, -0.24308753, -0.97000436, 0.24308753, 0, 0, \
        0.466203685, 0.43236573, 0.466203685, 0.43236573, -0.93240737, -0.86473146]";
    let found = orbit(
        &system,
        "stepper = { name = \"gauss\", stages = 6 }",
        initial,
        (6.325_913_98, 400),
        Hold::Period,
    );
    assert!(found.closure <= 1e-12, "{:e}", found.closure);
    assert!(found.is_stable());
    assert!(found.pairing <= 1e-10, "{:e}", found.pairing);
    assert_eq!((found.trivial, found.multipliers.len()), (8, 4));
    let mut turns: Vec<f64> = found
        .multipliers
        .iter()
        .map(|of| of.argument().abs() / TAU)
        .collect();
    turns.sort_by(f64::total_cmp);
    for (turn, known) in turns
        .iter()
        .zip([0.008_422_72, 0.008_422_72, 0.298_092_53, 0.298_092_53])
    {
        assert!((turn - known).abs() < 1e-6, "{turns:?}");
    }
}

/// Units of length, momentum and energy change neither a period over the unit of time nor a multiplier: in powers of two they
/// change no bit of a step but by the solver's stop, which is a small part of the state.
#[test]
fn orbits_know_no_units() {
    let in_units = |length: f64, mass: f64, time: f64| {
        let momentum = mass * length / time;
        let system = format!(
            "variables = [\"x\", \"y\", \"px\", \"py\"]\nbracket = \"canonical\"\n\
             parameters = {{ L = {length:e}, m = {mass:e}, T = {time:e} }}\n\
             hamiltonian = \"(px^2 + py^2)/(2*m) + m/T^2*((x^2 + y^2)/2 + (x^2*y - y^3/3)/L)\""
        );
        let start = format!("[0, {:e}, {:e}, 0]", 0.3 * length, 0.4 * momentum);
        let method = "stepper = \"splitting\"\ncomposition = \"suzuki-4\"";
        orbit(&system, method, &start, (6.0 * time, 120), Hold::Energy)
    };
    let two = |n: f64| libm::exp2(n);
    let own = in_units(1.0, 1.0, 1.0);
    // A Hénon–Heiles orbit that another program closes at 6.0878888.
    assert!((own.period - 6.0879).abs() < 1e-3 && own.is_stable());
    for (length, mass, time) in [
        (-37.0, 0.0, 0.0),
        (20.0, 3.0, -10.0),
        (-33.0, -90.0, -47.0),
        (100.0, 60.0, 30.0),
    ] {
        let found = in_units(two(length), two(mass), two(time));
        let period = found.period / two(time);
        assert!(
            (period - own.period).abs() < 1e-9 * own.period,
            "{length} {mass} {time}: {period}"
        );
        assert_eq!(found.multipliers.len(), own.multipliers.len());
        for (a, b) in found.multipliers.iter().zip(&own.multipliers) {
            assert!(
                (a.re - b.re).abs() < 1e-6 && (a.im.abs() - b.im.abs()).abs() < 1e-6,
                "{a:?} {b:?}"
            );
        }
    }
}

#[test]
fn what_has_no_orbits_is_refused() {
    let damped = "variables = [\"q\", \"p\", \"s\"]\nbracket = \"contact\"\nhamiltonian = \"p^2/2 + q^2/2 + 0.2*s\"";
    let run = until(damped, ORDER_8, "[1, 0, 0]", (6.0, 60));
    let refused = close(&run, (6.0, 60), Hold::Energy);
    assert!(matches!(refused, Err(OrbitError::NotOffered { .. })));
    let free = "variables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2\"";
    // It moves on: with the energy held its period falls to 0, with the period held its momentum.
    for momentum in [1.0, 1e-3, 1e-8] {
        let run = until(free, ORDER_8, &format!("[1, {momentum:?}]"), (6.0, 60));
        let refused = close(&run, (6.0, 60), Hold::Energy);
        let is_told = match &refused {
            Err(OrbitError::Shrinks { first, period, .. }) => *first == 6.0 && *period < 6e-3,
            Err(OrbitError::Equilibrium { moved, .. }) => *moved <= 6.0 * momentum,
            _ => false,
        };
        assert!(is_told, "{momentum:e}: {refused:?}");
        let refused = close(&run, (6.0, 60), Hold::Period);
        assert!(
            matches!(refused, Err(OrbitError::Equilibrium { moved, .. }) if moved <= 6e-3 * momentum),
            "{momentum:e}: {refused:?}"
        );
    }
    let pendulum =
        "variables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 - cos(q)\"";
    for (initial, hold) in [("[0, 0]", Hold::Energy), ("[0, 0]", Hold::Period)] {
        let run = until(pendulum, ORDER_8, initial, (6.0, 60));
        let refused = close(&run, (6.0, 60), hold);
        assert!(
            matches!(refused, Err(OrbitError::Equilibrium { moved: 0.0, .. })),
            "{refused:?}"
        );
    }
    // Its periods are longer than 2π.
    let run = until(pendulum, ORDER_8, "[0.3, 0]", (5.0, 60));
    let refused = close(&run, (5.0, 60), Hold::Period);
    assert!(refused.is_err(), "{refused:?}");
    for period in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
        let refused = close(&run, (period, 60), Hold::Energy);
        assert!(matches!(refused, Err(OrbitError::NotOffered { .. })));
    }
}

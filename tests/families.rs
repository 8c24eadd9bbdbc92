//! Families of periodic orbits: closed forms, quadratures, Hill's equation and the restricted problem written out.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::f64::consts::{FRAC_PI_2, SQRT_2, TAU};

use leafwise::orbit::{Along, Ends, Following, Hold, Mark, OrbitError, OrbitFamily, follow};
use leafwise_tests::scenes::until;

const ORDER_8: &str =
    "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 8 }";
const GAUSS: &str = "stepper = { name = \"gauss\", stages = 6 }";

fn followed(
    scene: (&str, &str),
    initial: &str,
    turn: (f64, usize),
    hold: Hold,
    along: (Along, f64),
) -> OrbitFamily {
    followed_by(scene, initial, turn, hold, (along, None))
}

/// The family of an orbit, or that which comes through at a branch point.
fn followed_by(
    (system, method): (&str, &str),
    initial: &str,
    (period, steps): (f64, usize),
    hold: Hold,
    ((along, to), branch): ((Along, f64), Option<i64>),
) -> OrbitFamily {
    let run = until(system, method, initial, (period, steps));
    let following = Following {
        along,
        to,
        most: 200,
        branch,
    };
    let family = follow(&run, (period, steps as u64), hold, &following);
    let family = family.unwrap_or_else(|error| panic!("{error}"));
    for member in &family.members {
        let orbit = &member.orbit;
        println!(
            "{:.9} T {:.9} E {:.9} {:?} {} {:?}",
            member.value,
            orbit.period,
            orbit.energy,
            member.mark,
            orbit.is_stable(),
            orbit.multipliers.first()
        );
    }
    println!("{:?}", family.ends);
    family
}

fn marks(family: &OrbitFamily) -> Vec<(Mark, f64)> {
    let members = family.members.iter();
    members
        .filter_map(|member| member.mark.map(|mark| (mark, member.value)))
        .collect()
}

/// The mean of arithmetic and geometric means.
fn mean(mut a: f64, mut b: f64) -> f64 {
    for _ in 0..10 {
        (a, b) = (0.5 * (a + b), libm::sqrt(a * b));
    }
    a
}

/// A zero between two places, by halving.
fn zero(mut f: impl FnMut(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let below = f(a) < 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        if (f(middle) < 0.0) == below {
            a = middle;
        } else {
            b = middle;
        }
    }
    0.5 * (a + b)
}

/// T = 2π/(√a M(1, cos(A/2))) of p²/2 − a cos q with the amplitude A.
fn pendulums(a: f64, amplitude: f64) -> f64 {
    TAU / (libm::sqrt(a) * mean(1.0, libm::cos(0.5 * amplitude)))
}

#[test]
fn the_pendulums_periods_are_those_of_the_closed_form() {
    let system = "variables = [\"q\", \"p\"]\nparameters = { a = 1.0 }\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 - a*cos(q)\"";
    let scene = (system, ORDER_8);
    let family = followed(
        scene,
        "[1, 0]",
        (6.7, 200),
        Hold::Energy,
        (Along::Energy, 0.5),
    );
    assert!(matches!(family.ends, Ends::Reached));
    assert!(marks(&family).is_empty() && family.members.len() > 10);
    for member in &family.members {
        let exact = pendulums(1.0, libm::acos(-member.value));
        assert!(
            (member.orbit.period - exact).abs() < 1e-8,
            "{}",
            member.value
        );
    }
    // With the energy held along a: the amplitude falls.
    let along = Along::Parameter("a".to_owned());
    let family = followed(scene, "[1, 0]", (6.7, 200), Hold::Energy, (along, 2.0));
    let last = family.members.last().expect("an orbit");
    assert_eq!(last.value, 2.0);
    let energy = -libm::cos(1.0);
    assert!((last.orbit.energy - energy).abs() < 1e-9);
    let exact = pendulums(2.0, libm::acos(-energy / 2.0));
    assert!((last.orbit.period - exact).abs() < 1e-8);
    // With the period held the amplitude grows as a does.
    let along = Along::Parameter("a".to_owned());
    let family = followed(scene, "[1, 0]", (6.7, 200), Hold::Period, (along, 1.3));
    let last = family.members.last().expect("an orbit");
    let energy = last.orbit.energy;
    let exact = pendulums(1.3, libm::acos(-energy / 1.3));
    assert!((exact - 6.7).abs() < 1e-8, "{exact}");
    // Smaller orbits end at the equilibrium of the energy −1.
    let family = followed(
        scene,
        "[0.3, 0]",
        (6.3, 100),
        Hold::Energy,
        (Along::Energy, -1.5),
    );
    assert!(
        matches!(family.ends, Ends::Equilibrium),
        "{:?}",
        family.ends
    );
}

/// T(A) = 4 ∫₀^{π/2} A cos θ/√(2(V(A) − V(A sin θ))) dθ of V = q²/2 + q⁴/4 − q⁶/8 falls and rises again: at its least the family
/// turns back. The integrand is even and has the period π: equal weights converge exponentially.
#[test]
fn a_fold_in_the_period_is_that_of_the_quadrature() {
    let system = "variables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 + q^2/2 + q^4/4 - q^6/8\"";
    let period = |amplitude: f64| {
        // (V(A) − V(A s))/(A² cos²) with s = sin θ, without the difference.
        let a2 = amplitude * amplitude;
        let n = 200;
        let sum: f64 = (0..n)
            .map(|k| {
                let s = libm::sin(FRAC_PI_2 * (f64::from(k) + 0.5) / f64::from(n));
                let s2 = s * s;
                let rest = 0.5 + 0.25 * a2 * (1.0 + s2) - 0.125 * a2 * a2 * (1.0 + s2 + s2 * s2);
                1.0 / libm::sqrt(2.0 * rest)
            })
            .sum();
        4.0 * FRAC_PI_2 * sum / f64::from(n)
    };
    let slope = |amplitude: f64| period(amplitude + 1e-5) - period(amplitude - 1e-5);
    let least = zero(slope, 0.3, 1.0);
    let family = followed(
        (system, ORDER_8),
        "[0.3, 0]",
        (period(0.3), 200),
        Hold::Energy,
        (Along::Period, period(least) - 0.1),
    );
    assert!(matches!(family.ends, Ends::Returned), "{:?}", family.ends);
    let marks = marks(&family);
    assert_eq!(marks.len(), 1, "{marks:?}");
    assert_eq!(marks[0].0, Mark::Fold);
    println!("{:?} and {} at {least}", marks, period(least));
    assert!((marks[0].1 - period(least)).abs() < 1e-8);
}

/// x' = f(x) over a time by the classical Runge–Kutta method.
fn runge_kutta<const N: usize>(
    field: impl Fn([f64; N]) -> [f64; N],
    mut x: [f64; N],
    (time, steps): (f64, u32),
) -> [f64; N] {
    let h = time / f64::from(steps);
    let along =
        |x: [f64; N], k: [f64; N], part: f64| std::array::from_fn(|i| x[i] + part * h * k[i]);
    for _ in 0..steps {
        let one = field(x);
        let two = field(along(x, one, 0.5));
        let three = field(along(x, two, 0.5));
        let four = field(along(x, three, 1.0));
        x = std::array::from_fn(|i| {
            x[i] + h / 6.0 * (one[i] + 2.0 * two[i] + 2.0 * three[i] + four[i])
        });
    }
    x
}

/// The mode q₂ = 0 of H = |p|²/2 + (q₁² + ω²q₂²)/2 + q₁⁴/4 + c q₁q₂² has neighbours by Hill's equation q₂″ = −(ω² + 2c q₁)q₂: its
/// trace over a period is 2 where another family branches off, and −2 where one of twice the period does.
#[test]
fn marks_of_a_mode_are_those_of_hills_equation() {
    let (omega2, c) = (1.5, 1.0);
    let system = format!(
        "variables = [\"q1\", \"q2\", \"p1\", \"p2\"]\nbracket = \"canonical\"\n\
         hamiltonian = \"(p1^2 + p2^2)/2 + q1^2/2 + {omega2}*q2^2/2 + q1^4/4 + {c}*q1*q2^2\""
    );
    let trace = |energy: f64| {
        let a2 = libm::sqrt(1.0 + 4.0 * energy) - 1.0;
        // T = 4 K(m)/√(1 + A²), m = A²/(2(1 + A²)).
        let period =
            TAU / (libm::sqrt(1.0 + a2) * mean(1.0, libm::sqrt(1.0 - 0.5 * a2 / (1.0 + a2))));
        let field = |[q, p, a, b]: [f64; 4]| [p, -q - q * q * q, b, -(omega2 + 2.0 * c * q) * a];
        let from = |a: f64, b: f64| runge_kutta(field, [libm::sqrt(a2), 0.0, a, b], (period, 2000));
        from(1.0, 0.0)[2] + from(0.0, 1.0)[3]
    };
    let (begin, end) = (0.05, 4.0);
    let mut expected = Vec::new();
    for k in 0..400 {
        let [a, b] = [0.0, 1.0].map(|part| begin + (end - begin) * (f64::from(k) + part) / 400.0);
        for (mark, level) in [(Mark::Branch, 2.0), (Mark::Doubling, -2.0)] {
            if (trace(a) - level) * (trace(b) - level) < 0.0 {
                expected.push((mark, zero(|energy| trace(energy) - level, a, b)));
            }
        }
    }
    expected.sort_by(|a, b| a.1.total_cmp(&b.1));
    let family = followed(
        (&system, GAUSS),
        &format!("[0, 0, {:?}, 0]", libm::sqrt(2.0 * begin)),
        (6.1, 60),
        Hold::Energy,
        (Along::Energy, end),
    );
    let found = marks(&family);
    println!("{found:?}\n{expected:?}");
    assert!(expected.len() >= 3, "{expected:?}");
    assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(found.0, expected.0);
        assert!(
            (found.1 - expected.1).abs() < 1e-6,
            "{found:?} {expected:?}"
        );
    }
}

/// Earth and moon.
const MU: f64 = 0.012_150_585_609_624;

/// Planar motion in the turning frame with its velocities, and a vertical neighbour z, z'.
fn restricted([x, y, u, v, z, w]: [f64; 6]) -> [f64; 6] {
    let cube = |x: f64| {
        let square = x * x + y * y;
        square * libm::sqrt(square)
    };
    let (a, b) = ((1.0 - MU) / cube(x + MU), MU / cube(x - 1.0 + MU));
    [
        u,
        v,
        2.0 * v + x - a * (x + MU) - b * (x - 1.0 + MU),
        -2.0 * u + y - (a + b) * y,
        w,
        -(a + b) * z,
    ]
}

/// H of the restricted problem, half the Jacobi constant with the other sign.
fn energy(x: f64, v: f64) -> f64 {
    0.5 * v * v - 0.5 * x * x - (1.0 - MU) / (x + MU).abs() - MU / (x - 1.0 + MU).abs()
}

/// The speed and the period of the Lyapunov orbit that crosses y = 0 at a right angle left of L₁: by halving, on the second crossing.
fn lyapunov(x: f64, guess: f64) -> (f64, f64) {
    let steps = 2000;
    // From one crossing to the next, with the last step by Newton's method in its length.
    let half = |v: f64| {
        let h = 1.6 / f64::from(steps);
        let (mut state, mut time) = ([x, 0.0, 0.0, v, 0.0, 0.0], 0.0);
        loop {
            let next = runge_kutta(restricted, state, (h, 1));
            if time > 10.0 * h && next[1] * v < 0.0 {
                break;
            }
            (state, time) = (next, time + h);
        }
        let mut rest = 0.5 * h;
        for _ in 0..8 {
            let end = runge_kutta(restricted, state, (rest, 1));
            rest -= end[1] / end[3];
        }
        (runge_kutta(restricted, state, (rest, 1))[2], time + rest)
    };
    let v = zero(|v| half(v).0, guess * 0.8, guess * 1.2);
    (v, 2.0 * half(v).1)
}

/// Lyapunov orbits about L₁ in space: the vertical multipliers are 1 where halo orbits branch off. Known for the earth and the moon:
/// at a Jacobi constant of 3.1743 and a period of 2.743 (K. Howell, Celestial Mechanics 32 (1984); the catalogue of three-body orbits
/// of the Jet Propulsion Laboratory). Here it is found with the variational equation written out.
#[test]
fn halo_orbits_branch_off_where_the_vertical_equation_says() {
    let system = format!(
        "variables = [\"x\", \"y\", \"z\", \"px\", \"py\", \"pz\"]\nparameters = {{ mu = {MU} }}\nbracket = \"canonical\"\n\
         hamiltonian = \"(px^2 + py^2 + pz^2)/2 + y*px - x*py - (1 - mu)/sqrt((x + mu)^2 + y^2 + z^2) \
         - mu/sqrt((x - 1 + mu)^2 + y^2 + z^2)\""
    );
    let l1 = zero(|x| restricted([x, 0.0, 0.0, 0.0, 0.0, 0.0])[2], 0.8, 0.9);
    println!("L1 at {l1}");
    // Twice the trace of the vertical motion.
    let vertical = |x: f64| {
        let (v, period) = lyapunov(x, 8.4 * (l1 - x));
        let from = |z: f64, w: f64| runge_kutta(restricted, [x, 0.0, 0.0, v, z, w], (period, 4000));
        (from(1.0, 0.0)[4] + from(0.0, 1.0)[5], v, period)
    };
    let x = zero(|x| vertical(x).0 - 2.0, l1 - 0.02, l1 - 0.008);
    let (_, v, period) = vertical(x);
    let known = energy(x, v);
    println!("halo at x {x}, C {}, T {period}", -2.0 * known);
    let begin = l1 - 0.005;
    let (v, turn) = lyapunov(begin, 8.4 * 0.005);
    let family = followed(
        (&system, GAUSS),
        &format!("[{begin:?}, 0, 0, 0, {:?}, 0]", v + begin),
        (turn, 100),
        Hold::Energy,
        (Along::Energy, -1.58),
    );
    let marks = marks(&family);
    println!("{marks:?}, C {}", -2.0 * marks[0].1);
    assert_eq!(marks[0].0, Mark::Branch);
    assert!((marks[0].1 - known).abs() < 1e-8, "{} {known}", marks[0].1);
    assert!((-2.0 * marks[0].1 - 3.1743).abs() < 1e-4);
    let halo = &family.members.iter().find(|member| member.mark.is_some());
    let found = halo.expect("a mark").orbit.period;
    assert!((found - period).abs() < 1e-6, "{found} {period}");
    // The planar pair is far from 1 throughout.
    assert!(
        family
            .members
            .iter()
            .all(|member| !member.orbit.is_stable())
    );
}

/// Periods of halo orbits about L₁ at Jacobi constants −2H, by shooting with SciPy's DOP853 at a tolerance of 3e-14 from y = 0 to the
/// next crossing, and Brent's method in z. The Lyapunov family has the branch point, from where the other family is followed:
/// at right angles to the plane, to both of its sides.
#[test]
fn halo_orbits_have_the_periods_of_another_program() {
    let system = format!(
        "variables = [\"x\", \"y\", \"z\", \"px\", \"py\", \"pz\"]\nparameters = {{ mu = {MU} }}\nbracket = \"canonical\"\n\
         hamiltonian = \"(px^2 + py^2 + pz^2)/2 + y*px - x*py - (1 - mu)/sqrt((x + mu)^2 + y^2 + z^2) \
         - mu/sqrt((x - 1 + mu)^2 + y^2 + z^2)\""
    );
    let l1 = zero(|x| restricted([x, 0.0, 0.0, 0.0, 0.0, 0.0])[2], 0.8, 0.9);
    let begin = l1 - 0.005;
    let (v, turn) = lyapunov(begin, 8.4 * 0.005);
    let initial = format!("[{begin:?}, 0, 0, 0, {:?}, 0]", v + begin);
    for (branch, constant, period) in [
        (1, 3.15, 2.761_405_245_584),
        (-1, 3.10, 2.786_506_126_877),
        (1, 3.05, 2.760_497_271_677),
    ] {
        let along = (Along::Energy, -0.5 * constant);
        let family = followed_by(
            (&system, GAUSS),
            &initial,
            (turn, 100),
            Hold::Energy,
            (along, Some(branch)),
        );
        assert!(matches!(family.ends, Ends::Reached), "{:?}", family.ends);
        let last = family.members.last().expect("an orbit");
        assert!((last.orbit.energy + 0.5 * constant).abs() < 1e-9);
        assert!(
            (last.orbit.period - period).abs() < 1e-7,
            "{} {period}",
            last.orbit.period
        );
        // It is off the plane; before the branch point none is.
        assert!(last.orbit.state[2].abs().max(last.orbit.state[5].abs()) > 0.01);
        assert!(family.members[0].orbit.state[2].abs() < 1e-9);
    }
}

/// Beside an oscillator of its own, (x, y) is the motion about the triangular points with U = x²/8 − 5y²/8 − κxy: its two frequencies,
/// of opposite signature, meet at κ² = 23/16, as at Routh's value. Multipliers of the oscillator's orbit meet there and leave the
/// circle.
#[test]
fn multipliers_of_opposite_signature_collide_at_rouths_value() {
    let system = "variables = [\"u\", \"x\", \"y\", \"pu\", \"px\", \"py\"]\nparameters = { k = 1.25 }\nbracket = \"canonical\"\n\
        hamiltonian = \"pu^2/2 + u^2/2 + u^4/4 + (px^2 + py^2)/2 + y*px - x*py + x^2/8 - 5*y^2/8 - k*x*y\"";
    let along = (Along::Parameter("k".to_owned()), 1.12);
    let family = followed(
        (system, ORDER_8),
        "[1, 0, 0, 0, 0, 0]",
        (4.8, 120),
        Hold::Energy,
        along,
    );
    let found = marks(&family);
    println!("{found:?}");
    let exact = 0.25 * libm::sqrt(23.0);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].0, Mark::Krein);
    assert!((found[0].1 - exact).abs() < 1e-8, "{} {exact}", found[0].1);
    let [first, last] = [
        &family.members[0],
        &family.members[family.members.len() - 1],
    ];
    assert!(first.orbit.is_stable() && !last.orbit.is_stable());
}

#[test]
fn a_branch_that_is_not_there_is_told() {
    let system =
        "variables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 - cos(q)\"";
    let along = (Along::Energy, 0.2);
    let family = followed_by(
        (system, ORDER_8),
        "[1, 0]",
        (6.7, 100),
        Hold::Energy,
        (along, Some(1)),
    );
    assert!(matches!(family.ends, Ends::NoBranch), "{:?}", family.ends);
}

#[test]
fn what_is_no_family_is_refused() {
    let system =
        "variables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 - cos(q)\"";
    let run = until(system, ORDER_8, "[1, 0]", (6.7, 100));
    let refused = |along, to| {
        let following = Following {
            along,
            to,
            most: 10,
            branch: None,
        };
        follow(&run, (6.7, 100), Hold::Energy, &following).expect_err("a refusal")
    };
    let named = refused(Along::Parameter("a".to_owned()), 1.0);
    assert!(matches!(named, OrbitError::NoParameter { .. }));
    for to in [f64::NAN, f64::INFINITY] {
        assert!(matches!(
            refused(Along::Energy, to),
            OrbitError::NotOffered { .. }
        ));
    }
}

const HENON_HEILES: &str = "variables = [\"x\", \"y\", \"px\", \"py\"]\nbracket = \"canonical\"\n\
    hamiltonian = \"(px^2 + py^2 + x^2 + y^2)/2 + x^2*y - y^3/3\"";

/// A family that passes monotonically through energies down to 0.004 has no fold at any of them where it is told to end there.
#[test]
fn values_where_a_family_ends_are_no_folds() {
    for to in [0.017, 0.014, 0.011, 0.01] {
        let family = followed(
            (HENON_HEILES, ORDER_8),
            "[0, 0.3, 0.4, 0]",
            (6.0, 120),
            Hold::Energy,
            (Along::Energy, to),
        );
        assert!(matches!(family.ends, Ends::Reached), "{:?}", family.ends);
        let folds = marks(&family);
        assert!(
            folds.iter().all(|(mark, _)| *mark != Mark::Fold),
            "{to}: {folds:?}"
        );
        assert!(family.members.len() > 2, "{to}");
    }
}

/// The energy is least at the centre of Lotka's populations, H(1, 2) = 3 − 2 ln 2, and at the origin of Hénon's and Heiles': families
/// come to an equilibrium there, and do not fold.
#[test]
fn families_that_shrink_end_at_an_equilibrium() {
    let populations = "variables = [\"x\", \"y\"]\nbracket = { log-canonical = [[0, 1], [-1, 0]] }\n\
        hamiltonian = \"x - ln(x) + y - 2*ln(y)\"";
    let cases = [
        (HENON_HEILES, "[0, 0.3, 0.4, 0]", (6.0, 120), 0.0, TAU),
        (populations, "[0.5, 1.5]", (4.6, 92), 0.7, TAU / SQRT_2),
    ];
    for (system, initial, turn, to, period) in cases {
        let along = (Along::Energy, to);
        let family = followed((system, ORDER_8), initial, turn, Hold::Energy, along);
        assert!(
            matches!(family.ends, Ends::Equilibrium),
            "{:?}",
            family.ends
        );
        let folds = marks(&family);
        assert!(
            folds.iter().all(|(mark, _)| *mark != Mark::Fold),
            "{folds:?}"
        );
        let last = family.members.last().expect("an orbit");
        assert!(
            (last.orbit.period - period).abs() < 1e-2,
            "{}",
            last.orbit.period
        );
    }
}

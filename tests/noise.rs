//! Noise: moments and orders against closed forms, by quadrature where that takes the place of samples; Casimirs and the
//! tensor at round-off; the same bits however steps are taken.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

mod chains;
mod equilibrium;
mod lattices;

use std::sync::Arc;

use leafwise::core::diagnostics::{TensorDefect, fit_slope};
use leafwise::core::noise::{NoisyMap, Normals, Seed, normals_of};
use leafwise::core::{Registry, StepMap, Walk};
use leafwise::scene::{ComposedRun, compose};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance};
use leafwise_tests::scenes::{composed, document};
use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen, Vector3};

/// A spin about z, {m_x, m_y} = −m_z, so that m' = {−B m_z, m}.
const SPIN: &str = "variables = [\"x\", \"y\", \"z\"]\nbracket = { lie-algebra = \"so3\" }\nparameters = { B = 1.0, s = 0.5 }\n\
                    hamiltonian = \"-B*z\"\ncasimirs = { length = \"x^2 + y^2 + z^2\" }";

const ONE: &str = "{ hamiltonian = \"x\", strength = \"s\" }";
const TWO: &str =
    "{ hamiltonian = \"x\", strength = \"s\" }, { hamiltonian = \"y\", strength = \"s\" }";
const THREE: &str = "{ hamiltonian = \"x\", strength = \"s\" }, { hamiltonian = \"y\", strength = \"s\" }, \
                     { hamiltonian = \"z\", strength = \"s\" }";

/// Of order 2, over an exact realization.
const HAMILTON_JACOBI: &str = "dynamics = { name = \"hamilton-jacobi\", order = 2 }";

const START: [f64; 3] = [0.6, 0.0, 0.8];

fn scene(channels: &str, method: &str, step: f64) -> String {
    format!(
        "[system]\n{SPIN}\nnoise = [{channels}]\n[method]\n{method}\ntime-step = {step:?}\n[run]\ninitial = {START:?}\nsteps = 100\n"
    )
}

fn spin(channels: &str, method: &str, step: f64) -> ComposedRun {
    composed(&scene(channels, method, step))
}

fn noisy(run: &ComposedRun) -> &NoisyMap {
    run.method.noisy().expect("noise")
}

/// Members side by side after so many steps from one state.
fn moved(
    run: &ComposedRun,
    map: &dyn StepMap,
    members: u64,
    (from, steps): (&[f64], u64),
) -> Vec<Vec<f64>> {
    let lanes = members as usize;
    let each = |values: &[f64]| -> Vec<f64> {
        let rows = values.iter();
        rows.flat_map(|value| vec![*value; lanes]).collect()
    };
    let parameters = each(&run.system.parameter_values());
    let (epsilon, h) = (run.plan.epsilon, run.plan.h);
    let mut all = Walk::side_by_side(map, lanes, (&parameters, &each(from)), epsilon, h);
    for _ in 0..steps {
        all.step().expect("a step");
    }
    (0..lanes).map(|lane| all.last(lane).1).collect()
}

/// The same from the initial state.
fn after(run: &ComposedRun, map: &dyn StepMap, members: u64, steps: u64) -> Vec<Vec<f64>> {
    moved(run, map, members, (&run.plan.initial, steps))
}

/// A stepper that is kept for other members has made no step of theirs.
#[test]
fn a_walk_that_starts_again_draws_from_the_first_step() {
    let run = spin(THREE, HAMILTON_JACOBI, 0.3);
    let parameters = run.system.parameter_values();
    let map = run.method.map();
    let new = || Walk::new(map, &parameters, 1.0, 0.3, &START);
    let (mut kept, mut fresh) = (new(), new());
    kept.follow(&[5]);
    kept.advance(7).expect("steps");
    kept.start_again(map, (&parameters, &START));
    for walk in [&mut kept, &mut fresh] {
        walk.follow(&[9]);
        walk.advance(7).expect("steps");
    }
    assert_eq!(kept.checkpoint(), fresh.checkpoint());
    assert_eq!(kept.statistics(), fresh.statistics());
}

/// The matrix of m ↦ {m_k, m}.
fn generator(k: usize) -> Matrix3<f64> {
    let fields = [
        [[0., 0., 0.], [0., 0., -1.], [0., 1., 0.]],
        [[0., 0., 1.], [0., 0., 0.], [-1., 0., 0.]],
        [[0., -1., 0.], [1., 0., 0.], [0., 0., 0.]],
    ];
    Matrix3::from_fn(|i, j| fields[k][i][j])
}

/// e^A v by its series, for a small A.
fn exponential(a: &DMatrix<f64>, v: DVector<f64>) -> DVector<f64> {
    let (mut term, mut sum) = (v.clone(), v);
    for k in 1..40 {
        term = a * term / f64::from(k);
        sum += &term;
    }
    sum
}

/// E[m(t)]' = (A + ½ Σ σ² A_k²) E[m(t)], and the same of m ⊗ m, for channels x, y, z in this order.
fn moments(channels: usize, t: f64) -> [DVector<f64>; 2] {
    let square = |a: Matrix3<f64>| DMatrix::from_column_slice(3, 3, a.as_slice());
    let one = DMatrix::identity(3, 3);
    let second = |a: &DMatrix<f64>| a.kronecker(&one) + one.kronecker(a);
    let mut first = square(-generator(2));
    let mut both = second(&first);
    for k in 0..channels {
        let a = square(generator(k) * 0.5);
        first += 0.5 * &a * &a;
        let a = second(&a);
        both += 0.5 * &a * &a;
    }
    let start = DVector::from_column_slice(&START);
    let pairs = start.kronecker(&start);
    [
        exponential(&(first * t), start),
        exponential(&(both * t), pairs),
    ]
}

/// Gauss's nodes and weights of sum 1, from the recurrence of the orthonormal polynomials (Golub, Welsch 1969).
fn gauss(count: usize, off_diagonal: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let jacobi = DMatrix::from_fn(count, count, |i, j| {
        if i.abs_diff(j) == 1 {
            off_diagonal(i.max(j) as f64)
        } else {
            0.0
        }
    });
    let found = SymmetricEigen::new(jacobi);
    let weight = |k: usize| found.eigenvectors[(0, k)] * found.eigenvectors[(0, k)];
    (0..count)
        .map(|k| (found.eigenvalues[k], weight(k)))
        .collect()
}

/// For a standard normal number.
fn hermite(count: usize) -> Vec<(f64, f64)> {
    gauss(count, libm::sqrt)
}

/// Members are points of the product rule, and the passes of the flows.
struct Nodes {
    rule: Vec<(f64, f64)>,
    channels: u32,
}

impl Nodes {
    fn members(&self) -> u64 {
        2 * (self.rule.len() as u64).pow(self.channels)
    }

    fn node(&self, member: u64, channel: u32) -> (f64, f64) {
        let count = self.rule.len() as u64;
        self.rule[(member / count.pow(channel) % count) as usize]
    }

    fn weight(&self, member: u64) -> f64 {
        (0..self.channels).fold(0.5, |weight, k| weight * self.node(member, k).1)
    }
}

fn normals(nodes: &Arc<Nodes>) -> Normals {
    let nodes = Arc::clone(nodes);
    normals_of(move |member, channel, _| match channel == nodes.channels {
        true if member < nodes.members() / 2 => 1.0,
        true => -1.0,
        false => nodes.node(member, channel).0,
    })
}

/// How far means of m and m ⊗ m are off after one step.
fn one_step(channels: u32, method: &str, step: f64) -> f64 {
    let list = [ONE, TWO, THREE][channels as usize - 1];
    let run = spin(list, method, step);
    let nodes = Arc::new(Nodes {
        rule: hermite(10),
        channels,
    });
    let map = noisy(&run).with_normals(normals(&nodes));
    let members = after(&run, &map, nodes.members(), 1);
    let (mut first, mut second) = (vec![0.0; 3], vec![0.0; 9]);
    for (member, m) in members.iter().enumerate() {
        let weight = nodes.weight(member as u64);
        for i in 0..3 {
            first[i] += weight * m[i];
            for j in 0..3 {
                second[3 * i + j] += weight * m[i] * m[j];
            }
        }
    }
    let [exact, exact_second] = moments(channels as usize, step);
    distance(&first, exact.as_slice()).max(distance(&second, exact_second.as_slice()))
}

/// The one-step error of means is of order p + 1, exactly: no sample is drawn.
#[test]
fn means_are_of_weak_order_one_and_split_of_two() {
    let cases = [
        (2, HAMILTON_JACOBI, 1.0),
        (2, "stepper = \"splitting\"", 1.0),
        (3, HAMILTON_JACOBI, 1.0),
        (2, "stepper = \"rk4\"", 1.0),
        (
            1,
            "dynamics = { name = \"hamilton-jacobi\", order = 2 }\nnoise = \"split\"",
            2.0,
        ),
        (
            2,
            "dynamics = { name = \"hamilton-jacobi\", order = 2 }\nnoise = \"split\"",
            2.0,
        ),
        (2, "stepper = \"splitting\"\nnoise = \"split\"", 2.0),
        (3, "stepper = \"gauss\"\nnoise = \"split\"", 2.0),
    ];
    for (channels, method, order) in cases {
        let steps = [0.2, 0.1, 0.05, 0.025];
        let points: Vec<_> = steps
            .iter()
            .map(|h| (*h, one_step(channels, method, *h)))
            .collect();
        let slope = fit_slope(&points, 1e-14).expect("errors above round-off");
        println!(
            "{channels} channels, {}: order {:.3} {points:?}",
            method.replace('\n', ", "),
            slope.exponent - 1.0
        );
        assert!(
            (slope.exponent - 1.0 - order).abs() < 0.15,
            "{channels} channels, {method}: {slope:?} {points:?}"
        );
    }
}

/// Coarse increments are sums of `each` fine ones.
fn path(fine: Seed, each: u64) -> Normals {
    normals_of(move |member, channel, step| {
        let from = step * each;
        let fine = (from..from + each).map(|at| fine.normal(member, channel, at));
        fine.sum::<f64>() / libm::sqrt(each as f64)
    })
}

/// Root mean squares over 400 members of the distance from steps 64 times finer than the finest here; their own error of
/// 3.5 % moves a slope over three halvings by less than 0.05.
#[test]
fn paths_are_of_strong_order_one_half_and_of_one_with_one_channel() {
    // Beside a slow precession what two channels leave of order 1 is small.
    let cases = [
        (ONE, HAMILTON_JACOBI, "B = 1.0", 1.0),
        (TWO, HAMILTON_JACOBI, "B = 0.1", 0.5),
        (TWO, "stepper = \"splitting\"", "B = 0.1", 0.5),
    ];
    let finest = 4096;
    for (channels, method, field, order) in cases {
        let ends = |steps: u64| {
            let text = scene(channels, method, 1.0 / steps as f64);
            let run = composed(&text.replace("B = 1.0", field));
            let path = path(Seed { seed: 11, first: 0 }, finest / steps);
            let map = noisy(&run).with_normals(path);
            after(&run, &map, 400, steps)
        };
        let exact = ends(finest);
        let points: Vec<(f64, f64)> = [8, 16, 32, 64]
            .iter()
            .map(|&steps| {
                let coarse = ends(steps);
                let pairs = coarse.iter().zip(&exact);
                let squares: f64 = pairs.map(|(a, b)| distance(a, b) * distance(a, b)).sum();
                (1.0 / steps as f64, libm::sqrt(squares / 400.0))
            })
            .collect();
        let slope = fit_slope(&points, 0.0).expect("four points");
        println!(
            "{channels}, {method}: strong order {:.3} {points:?}",
            slope.exponent
        );
        assert!(
            (slope.exponent - order).abs() < 0.1,
            "{channels}, {method}: {slope:?}"
        );
    }
}

/// Under −B z and noise of z a spin turns by Bt + σW: E[m_⊥] = e^{−σ²t/2} of what it was, here within three standard errors
/// of 8192 members.
#[test]
fn precession_with_noise_about_its_axis_decays_as_the_characteristic_function() {
    let channel = "{ hamiltonian = \"z\", strength = \"s\" }";
    for method in [
        HAMILTON_JACOBI,
        "stepper = \"splitting\"\nnoise = \"split\"",
    ] {
        let run = spin(channel, method, 0.1);
        let (members, steps) = (8192, 40);
        let states = after(&run, run.method.map(), members, steps);
        let t = 0.1 * steps as f64;
        let (turn, decay) = (t, libm::exp(-0.125 * t));
        // The turned-back component along the start, and across it.
        let (sin, cos) = (libm::sin(turn), libm::cos(turn));
        let along: Vec<f64> = states
            .iter()
            .map(|m| (m[0] * cos - m[1] * sin) / 0.6)
            .collect();
        let mean = along.iter().sum::<f64>() / members as f64;
        let squares: f64 = along.iter().map(|v| (v - mean) * (v - mean)).sum();
        let error = libm::sqrt(squares / members as f64 / members as f64);
        println!("{method}: {mean} for {decay} +- {error}");
        assert!(
            (mean - decay).abs() < 3.0 * error,
            "{mean} for {decay} ± {error}"
        );
        assert!(
            states
                .iter()
                .all(|m| (m[2] - 0.8).abs() < 100.0 * UNIT_ROUNDOFF)
        );
    }
}

/// A million steps. What a solved step rounds adds up as a random walk, of which this is twice the deviation where each errs by
/// u; the seven flows of a split step round by a bias too, of less than a hundredth of u a step.
#[test]
fn casimirs_stay_at_round_off_over_a_million_noisy_steps() {
    let steps = 1_000_000;
    let cases = [
        (HAMILTON_JACOBI, 2.0 * 1e3),
        ("stepper = \"splitting\"\nnoise = \"split\"", 0.01 * 1e6),
    ];
    for (method, units) in cases {
        let run = spin(THREE, method, 0.1);
        let mut walk = run.walk();
        walk.advance(steps).expect("every step");
        let length: f64 = walk.state().iter().map(|m| m * m).sum();
        println!("{method}: {:e}", length - 1.0);
        let allowed = units * UNIT_ROUNDOFF;
        assert!(
            (length - 1.0).abs() < allowed,
            "{method}: {:e}",
            length - 1.0
        );
    }
}

/// DΦ Π DΦᵀ = Π∘Φ at what is drawn, whatever it is.
#[test]
fn a_step_is_a_poisson_map_at_its_noise() {
    let methods = [
        "dynamics = { name = \"hamilton-jacobi\", order = 4 }",
        "realization = \"lie-poisson\"",
        "realization = \"karasev-collocated\"",
        "stepper = \"splitting\"",
        "composition = \"suzuki-4\"",
        "dynamics = { name = \"hamilton-jacobi\", order = 2 }\nnoise = \"split\"",
    ];
    for method in methods {
        for seed in 0..8 {
            let run = spin(THREE, method, 0.3);
            let map = noisy(&run).with_normals(Seed { seed, first: 0 }.into());
            let values = run.system.parameter_values();
            let mut defect =
                TensorDefect::new(&run.system, &map, &values, 1.0, 0.3).expect("a tensor");
            let defect = defect.measure(&START).expect("a step");
            let relative = defect.relative().expect("a tensor");
            assert!(
                relative < leafwise::core::diagnostics::Defect::ROUND_OFF,
                "{method}: {relative:e}"
            );
        }
    }
}

/// What a member draws depends on the seed and its number: not on its neighbours, nor on where a run was cut.
#[test]
fn steps_have_the_same_bits_in_any_company_and_after_any_interruption() {
    let methods = [
        "dynamics = { name = \"hamilton-jacobi\", order = 4 }",
        "dynamics = { name = \"hamilton-jacobi\", order = 2 }\nnoise = \"split\"",
        "stepper = \"splitting\"",
        "stepper = \"gauss\"",
        "realization = \"karasev-collocated\"",
        "composition = \"kahan-li-6\"",
    ];
    for method in methods {
        let run = spin(THREE, method, 0.1);
        let together = after(&run, run.method.map(), 11, 50);
        for member in 0..11_u64 {
            let parameters = run.system.parameter_values();
            let mut one = Walk::new(run.method.map(), &parameters, 1.0, 0.1, &START);
            one.follow(&[member]);
            (0..50).for_each(|_| one.step().expect("a step"));
            assert_eq!(
                one.last(0).1,
                together[member as usize],
                "{method}: member {member}"
            );
            let earlier = &together[..member as usize];
            assert!(
                earlier
                    .iter()
                    .all(|other| distance(other, &together[member as usize]) > 1e-3)
            );
        }
        let mut through = run.walk();
        through.advance(50).expect("every step");
        assert_eq!(through.state(), together[0], "{method}");
        let mut first = run.walk();
        first.advance(23).expect("every step");
        let mut second = run.walk();
        second
            .restore(&first.checkpoint())
            .expect("its own checkpoint");
        second.advance(27).expect("every step");
        assert_eq!(second.state(), through.state(), "{method}");
        assert_eq!(second.compensation(), through.compensation(), "{method}");
    }
}

/// The seed is that of the scene.
#[test]
fn other_seeds_draw_other_numbers() {
    let text = scene(TWO, "stepper = \"splitting\"", 0.1);
    let end = |seed: &str| {
        let document = document(&text, &[("run.seed", seed)]);
        let run = compose(&document, &Registry::with_builtin()).expect("a run");
        leafwise_tests::scenes::end(&run)
    };
    assert_eq!(end("0"), leafwise_tests::scenes::end(&composed(&text)));
    assert!(distance(&end("0"), &end("1")) > 1e-3);
}

/// H_w = H + w σ H_1 for a step: the bits of a scene with that Hamiltonian, as near as kernels round alike.
#[test]
fn a_step_is_that_of_the_hamiltonian_it_draws() {
    for method in [
        "dynamics = { name = \"hamilton-jacobi\", order = 4 }",
        "stepper = \"gauss\"",
        "stepper = \"dop853\"",
    ] {
        let run = spin(ONE, method, 0.25);
        let map = noisy(&run).with_normals(normals_of(|_, _, _| 0.7));
        let values = run.system.parameter_values();
        let mut drawn = Walk::new(&map, &values, 1.0, 0.25, &START);
        // w = ξ/√t = 1.4, σ = 0.5.
        let text = SPIN.replace("-B*z", "-B*z + 1.4*0.5*x");
        let text = format!(
            "[system]\n{text}\n[method]\n{method}\ntime-step = 0.25\n[run]\ninitial = {START:?}\nsteps = 1\n"
        );
        let fixed = composed(&text);
        let mut fixed = fixed.walk();
        for _ in 0..20 {
            drawn.step().expect("a step");
            fixed.step().expect("a step");
        }
        assert!(distance(drawn.state(), fixed.state()) < 1e-13, "{method}");
    }
}

/// Damping is of H alone whatever the noise is, in the field of any stepper and in the one-form's steps.
#[test]
fn damping_does_not_follow_the_noise() {
    let damped = format!("{SPIN}\ndamping = {{ rate = \"0.4\" }}");
    let text = |method: &str| {
        format!(
            "[system]\n{damped}\nnoise = [{ONE}]\n[method]\n{method}\ntime-step = 0.001\n[run]\ninitial = {START:?}\nsteps = 1\n"
        )
    };
    // −Π(dH + λ ẋ_H) + w σ {m_x, m} over a step.
    let w = 5.0 / libm::sqrt(0.001);
    let m = Vector3::from(START);
    let free = -generator(2) * m;
    let damping = 0.4 * (m.cross(&Vector3::z()).cross(&m));
    let field = free + damping + generator(0) * m * (0.5 * w);
    for method in ["realization = \"auto\"", "stepper = \"rk4\""] {
        let run = composed(&text(method));
        let map = noisy(&run).with_normals(normals_of(|_, _, _| 5.0));
        let moved = after(&run, &map, 1, 1);
        let moved = (Vector3::from_column_slice(&moved[0]) - m) / 0.001;
        // The noise moves by 0.08, and the next order is half of its square.
        let second = generator(0) * generator(0) * m * (0.25 * w * w * 0.0005);
        let left = (moved - field - second).norm();
        assert!(
            left < 0.05 * field.norm(),
            "{method}: {left} of {}",
            field.norm()
        );
        let component = (moved - field - second)[0];
        assert!(component.abs() < 0.1, "{method}: {component}");
    }
}

//! Bodies about centres as pieces.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use crate::common::{Problem, canonical, distance, gauss, largest, run, step, whole};
use leafwise_core::diagnostics::TensorDefect;
use leafwise_core::solver::StepMap;
use proptest::prelude::*;

/// A body of mass m about a centre, q₁, p₁, q₂, p₂, …; μ = k/m.
fn body(dimension: usize, [m, k]: [f64; 2], state: &[f64]) -> Problem {
    let name = |letter: &str, at: usize| format!("{letter}{at}");
    let pairs: Vec<_> = (1..=dimension)
        .map(|at| [name("q", at), name("p", at)])
        .collect();
    let squares = |of: usize| {
        let squares = pairs.iter().map(|pair| format!("{}^2", pair[of]));
        squares.collect::<Vec<_>>().join(" + ")
    };
    let hamiltonian = format!("({})/(2*m) - k/sqrt({})", squares(1), squares(0));
    canonical(&pairs, &[("m", m), ("k", k)], hamiltonian, state.to_vec())
}

/// The mass of the bodies here: μ = k/m = 1.
const MASS: f64 = 2.0;

fn one_map(dimension: usize) -> Arc<dyn StepMap> {
    static MAPS: std::sync::OnceLock<[Arc<dyn StepMap>; 2]> = std::sync::OnceLock::new();
    let form = |dimension: usize| {
        let state: Vec<f64> = (0..2 * dimension).map(|at| 0.3 + 0.1 * at as f64).collect();
        whole(&body(dimension, [MASS, MASS], &state).system()).expect("a body about a centre")
    };
    let maps = MAPS.get_or_init(|| [form(2), form(3)]);
    Arc::clone(&maps[dimension - 2])
}

/// A conic of μ = 1 with its pericentre along the first axis: an ellipse or a hyperbola with half axis 1, a parabola with parameter 1.
#[derive(Clone, Copy, Debug)]
struct Conic {
    eccentricity: f64,
}

/// A point of a conic: the time from the pericentre, the distance, place and velocity in the plane.
struct Point {
    time: f64,
    distance: f64,
    place: [f64; 2],
    velocity: [f64; 2],
}

impl Conic {
    /// At the eccentric anomaly E, or H, or the tangent of half of the angle: ds = dt/r.
    fn at(self, s: f64) -> Point {
        let e = self.eccentricity;
        let (time, distance, place, slope) = if e < 1.0 {
            let (sin, cos, b) = (
                libm::sin(s),
                libm::cos(s),
                libm::sqrt((1.0 - e) * (1.0 + e)),
            );
            (
                s - e * sin,
                1.0 - e * cos,
                [cos - e, b * sin],
                [-sin, b * cos],
            )
        } else if e == 1.0 {
            let square = s * s;
            let time = s / 2.0 + square * s / 6.0;
            (
                time,
                (1.0 + square) / 2.0,
                [(1.0 - square) / 2.0, s],
                [-s, 1.0],
            )
        } else {
            let (sinh, cosh, b) = (
                libm::sinh(s),
                libm::cosh(s),
                libm::sqrt((e - 1.0) * (e + 1.0)),
            );
            (
                e * sinh - s,
                e * cosh - 1.0,
                [e - cosh, b * sinh],
                [-sinh, b * cosh],
            )
        };
        let velocity = slope.map(|v| v / distance);
        Point {
            time,
            distance,
            place,
            velocity,
        }
    }
}

impl Point {
    /// q and m v, in a plane of space that is turned by an orthonormal pair.
    fn state(&self, dimension: usize) -> Vec<f64> {
        let axes: [[f64; 3]; 2] = match dimension {
            2 => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            _ => [
                [2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0],
                [-1.0 / 3.0, 2.0 / 3.0, -2.0 / 3.0],
            ],
        };
        let along = |v: &[f64; 2], at: usize| v[0] * axes[0][at] + v[1] * axes[1][at];
        (0..dimension)
            .flat_map(|at| [along(&self.place, at), MASS * along(&self.velocity, at)])
            .collect()
    }
}

fn places(state: &[f64]) -> Vec<f64> {
    state.iter().step_by(2).copied().collect()
}

fn velocities(state: &[f64]) -> Vec<f64> {
    state.iter().skip(1).step_by(2).map(|p| p / MASS).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn length(x: &[f64]) -> f64 {
    libm::sqrt(dot(x, x))
}

/// Energy, angular momentum, and Laplace's vector v × L − x/r in the plane or in space, of unit mass.
fn invariants(state: &[f64]) -> Vec<f64> {
    let (x, v) = (places(state), velocities(state));
    let r = length(&x);
    let (square, along) = (dot(&v, &v), dot(&x, &v));
    let mut all = vec![square / 2.0 - 1.0 / r];
    for i in 0..x.len() {
        all.extend((i + 1..x.len()).map(|j| x[i] * v[j] - x[j] * v[i]));
    }
    // v × (x × v) = v²x − (x·v)v.
    all.extend((0..x.len()).map(|i| (square - 1.0 / r) * x[i] - along * v[i]));
    all
}

/// Every conic in every step from one point to another, and in sixteen steps, in the plane and in space.
///
/// A unit of r₀ and |v₀|² is (2/r₀ + v₀²) units of β, and ∂t/∂β = s²t/6 or so; times come with units of their own, and
/// motion takes a unit of the time to |v| of the place. Sixteen steps each round, and where they end close to the centre a
/// unit of the place is more of the distance. Sums of a few terms each, some larger than what is left: sixteen units.
#[test]
fn conics_are_followed_exactly() {
    let mut most = 0.0_f64;
    let mut count = 0;
    for eccentricity in [0.0, 0.5, 0.99, 1.0, 2.0] {
        let conic = Conic { eccentricity };
        for from in [-2.5, -1.0, -0.2, 0.0, 0.5, 3.0] {
            for to in [-3.0, -1.4, -0.1, 0.01, 0.3, 1.0, 2.2] {
                let (start, end) = (conic.at(from), conic.at(to));
                let time = end.time - start.time;
                for (dimension, steps) in [(2, 1), (3, 1), (2, 16)] {
                    let problem = body(dimension, [MASS, MASS], &start.state(dimension));
                    let map = one_map(dimension);
                    let found = run(
                        &problem.system(),
                        map.as_ref(),
                        &problem.initial,
                        time,
                        steps,
                    );
                    let found =
                        found.unwrap_or_else(|error| panic!("{eccentricity} {from} {to}: {error}"));
                    let (s, r) = (to - from, start.distance);
                    let speed = length(&start.velocity);
                    let share = 1.0 + (2.0 / r + speed * speed) * s * s / 6.0;
                    let nearest = match from * to < 0.0 {
                        true => conic.at(0.0).distance,
                        false => r.min(end.distance),
                    };
                    let share = match steps {
                        1 => share,
                        _ => share * (1.0 + r.max(end.distance) / nearest),
                    };
                    let lag = (time.abs() + start.time.abs() + end.time.abs()) * share;
                    let units = |value: f64, rate: f64, sizes: f64| {
                        value / (steps as f64 * f64::EPSILON * (rate * lag + sizes))
                    };
                    let exact = end.state(dimension);
                    let of_place = units(
                        distance(&places(&found), &places(&exact)),
                        length(&end.velocity),
                        r + end.distance,
                    );
                    let of_velocity = units(
                        distance(&velocities(&found), &velocities(&exact)),
                        1.0 / (end.distance * end.distance),
                        (speed + length(&end.velocity)) * (1.0 + r / end.distance),
                    );
                    most = most.max(of_place).max(of_velocity);
                    count += 1;
                    assert!(
                        of_place <= 16.0 && of_velocity <= 16.0,
                        "{eccentricity} {from} {to} {steps}: {of_place} {of_velocity}"
                    );
                }
            }
        }
    }
    println!("{count} flows, at most {most:.2} units");
}

/// Ellipses over a hundred periods of 64 steps, the parabola and a hyperbola forth and back as often: energy, angular momentum and Laplace's
/// vector change by what rounding x and v to a few units makes of them step by step, and the ellipses close.
#[test]
fn energy_angular_momentum_and_laplace_vector_stay_at_round_off() {
    for eccentricity in [0.0, 0.5, 0.99, 1.0, 2.0] {
        for dimension in [2, 3] {
            let conic = Conic { eccentricity };
            let is_bound = eccentricity < 1.0;
            let start = conic.at(if is_bound { std::f64::consts::PI } else { -2.0 });
            let initial = start.state(dimension);
            let parameters = [MASS, MASS];
            let h = match is_bound {
                true => 2.0 * std::f64::consts::PI / 64.0,
                false => -2.0 * start.time / 64.0,
            };
            let map = one_map(dimension);
            let mut walks = [h, -h].map(|h| map.stepper(1, &parameters, 1.0, h));
            let before = invariants(&initial);
            let mut state = initial.clone();
            let mut bounds = vec![0.0_f64; before.len()];
            let mut worst = vec![0.0_f64; before.len()];
            for at in 0..6400 {
                let back = !is_bound && (at / 64) % 2 == 1;
                let next = step(walks[usize::from(back)].as_mut(), &state).expect("no collision");
                let (x, v) = (places(&next), velocities(&next));
                let (r, speed) = (length(&x), length(&v));
                let change = |of: fn(&[f64]) -> Vec<f64>| distance(&of(&next), &of(&state));
                // Units of x and of v, of their changes, and of what r, a sum of terms of that size, is known to.
                let of_place = f64::EPSILON * (r + change(places));
                let of_velocity =
                    f64::EPSILON * (speed + change(velocities)) * (1.0 + change(places) / r);
                let momenta = dimension * (dimension - 1) / 2;
                for (k, bound) in bounds.iter_mut().enumerate() {
                    *bound += match k {
                        0 => of_place / (r * r) + speed * of_velocity,
                        k if k <= momenta => speed * of_place + r * of_velocity,
                        _ => (speed * speed + 2.0 / r) * of_place + 3.0 * r * speed * of_velocity,
                    };
                }
                state = next;
                for (worst, (now, before)) in
                    worst.iter_mut().zip(invariants(&state).iter().zip(&before))
                {
                    *worst = worst.max((now - before).abs());
                }
            }
            println!(
                "e = {eccentricity}, d = {dimension}: {:.1e} of {:.1e}",
                largest(&worst),
                largest(&bounds)
            );
            for (worst, bound) in worst.iter().zip(&bounds) {
                assert!(
                    worst <= bound,
                    "{eccentricity} {dimension}: {worst:e} > {bound:e}"
                );
            }
            if is_bound {
                // δT/T = 3/2 δE/E, of all energies on the way.
                let closing = distance(&places(&state), &places(&initial));
                let lag = 600.0 * std::f64::consts::PI * bounds[0];
                let bound = length(&start.velocity) * lag + 4.0 * bounds[1] + largest(&bounds[2..]);
                println!("closes to {closing:.1e} of {bound:.1e}");
                assert!(closing <= bound, "{eccentricity}: {closing:e} > {bound:e}");
            }
        }
    }
}

/// DΦ Π DΦᵀ = Π on every conic, over up to a radian.
#[test]
fn flows_are_symplectic_to_a_thousand_units() {
    for eccentricity in [0.0, 0.5, 0.99, 1.0, 2.0] {
        for dimension in [2, 3] {
            let conic = Conic { eccentricity };
            let (start, end) = (conic.at(1.0), conic.at(2.0));
            let problem = body(dimension, [MASS, MASS], &start.state(dimension));
            let map = one_map(dimension);
            let (system, time) = (problem.system(), end.time - start.time);
            let mut instrument = TensorDefect::new(&system, map.as_ref(), &[MASS, MASS], 1.0, time)
                .expect("a tensor");
            let defect = instrument.measure(&problem.initial).expect("finite");
            println!("e = {eccentricity}, d = {dimension}: {:.1e}", defect.norm);
            assert!(defect.norm <= 1e-13, "{eccentricity}: {:e}", defect.norm);
        }
    }
}

/// A state near a centre, or far; β of either sign, or next to 0.
#[derive(Clone, Debug)]
struct Case {
    dimension: usize,
    state: Vec<f64>,
    time: f64,
}

fn case() -> impl Strategy<Value = Case> {
    let direction =
        || prop::array::uniform3(-1.0_f64..1.0).prop_filter("a direction", |x| length(x) > 0.1);
    let energy = prop_oneof![
        -1.9_f64..3.0,
        (0_i32..50, prop::bool::ANY).prop_map(|(digits, sign)| {
            let small = libm::scalbn(1.0, -digits);
            if sign { small } else { -small }
        }),
    ];
    (
        2_usize..4,
        direction(),
        direction(),
        energy,
        0.01_f64..3.0,
        prop::bool::ANY,
    )
        .prop_map(|(dimension, x, v, energy, time, back)| {
            let (x, v) = (&x[..dimension], &v[..dimension]);
            let (r, size) = (length(x), length(v).max(0.01));
            // v² = (2 + energy)/r.
            let speed = libm::sqrt((2.0 + energy) / r);
            let state = x
                .iter()
                .zip(v)
                .flat_map(|(x, v)| [*x, MASS * v * speed / size]);
            let time = time * r * libm::sqrt(r);
            Case {
                dimension,
                state: state.collect(),
                time: if back { -time } else { time },
            }
        })
}

impl Case {
    /// Longer than a period, or through the centre.
    fn may_be_refused(&self) -> bool {
        let (x, v) = (places(&self.state), velocities(&self.state));
        let beta = 2.0 / length(&x) - dot(&v, &v);
        let period = 2.0 * std::f64::consts::PI / (beta.max(0.0) * libm::sqrt(beta.max(0.0)));
        self.time.abs() > 0.999 * period || self.growth(&self.state) > 1e10
    }

    /// The farthest that the start is from what the motion depends on: the pericentre's and the end's distances.
    fn growth(&self, end: &[f64]) -> f64 {
        let (x, v) = (places(&self.state), velocities(&self.state));
        let (r, speed) = (length(&x), length(&v));
        let momentum = r * r * speed * speed - dot(&x, &v) * dot(&x, &v);
        let beta = 2.0 / r - speed * speed;
        let pericentre = momentum / (1.0 + libm::sqrt((1.0 - beta * momentum).max(0.0)));
        (r / pericentre.max(f64::MIN_POSITIVE))
            .max(r / length(&places(end)))
            .max(1.0)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// φ_s ∘ φ_t = φ_{s+t}, and tangents for Π. A unit at the start grows as the tangent does, and by (r₀/r)² in what a step rounds on its way.
    /// What is refused is more than a period, or so close a passage that a unit of the start is all of it.
    #[test]
    fn flows_are_a_group_of_poisson_maps(case in case(), part in 0.05_f64..0.95) {
        let map = one_map(case.dimension);
        let flow = |time: f64, x: &[f64]| step(map.stepper(1, &[MASS, MASS], 1.0, time).as_mut(), x);
        let whole = flow(case.time, &case.state);
        if whole.is_err() {
            prop_assert!(case.may_be_refused(), "{:?}", whole);
            return Ok(());
        }
        let whole = whole.expect("it is no error");
        let first = flow(part * case.time, &case.state).expect("a part of a flow that is one");
        let second = flow(case.time - part * case.time, &first).expect("as well");
        let back = flow(-case.time, &whole).expect("as far back");
        let problem = body(case.dimension, [MASS, MASS], &case.state);
        let system = problem.system();
        let mut instrument = TensorDefect::new(&system, map.as_ref(), &[MASS, MASS], 1.0, case.time)
            .expect("a tensor");
        let defect = instrument.measure(&case.state).expect("finite");
        let near = case.growth(&whole).max(case.growth(&first));
        let growth = largest(&defect.tangent).max(1.0) * near * near;
        let size = largest(&case.state).max(largest(&whole));
        let error = distance(&second, &whole).max(distance(&back, &case.state));
        prop_assert!(error <= 64.0 * f64::EPSILON * growth * size, "{:e} of {:e}", error, growth);
        let bound = 64.0 * f64::EPSILON * defect.scale * growth * largest(&defect.tangent).max(1.0);
        prop_assert!(defect.norm <= bound, "{:e} > {:e}", defect.norm, bound);
    }
}

/// Tangents by central differences, good to (10⁻⁵)² and 10⁻¹¹ of what a unit becomes.
#[test]
fn the_tangent_is_that_of_the_flow() {
    for eccentricity in [0.5, 1.0, 2.0] {
        let conic = Conic { eccentricity };
        let start = conic.at(-1.0);
        let (time, initial) = (conic.at(0.7).time - start.time, start.state(3));
        let map = one_map(3);
        let mut stepper = map.stepper(1, &[MASS, MASS], 1.0, time);
        step(stepper.as_mut(), &initial).expect("finite");
        let tangent = stepper.tangent(0).expect("a tangent");
        let size = largest(&tangent);
        for j in 0..6 {
            let moved = |by: f64| {
                let mut x = initial.clone();
                x[j] += by;
                step(map.stepper(1, &[MASS, MASS], 1.0, time).as_mut(), &x).expect("finite")
            };
            let (more, less) = (moved(1e-5), moved(-1e-5));
            for i in 0..6 {
                let difference = (more[i] - less[i]) / 2e-5;
                let error = (tangent[i * 6 + j] - difference).abs();
                assert!(
                    error <= 2e-9 * size * size,
                    "{eccentricity} {i} {j}: {error:e}"
                );
            }
        }
    }
}

/// ⟨w, Φ⟩ by state, mass and attraction: pulled back, by central differences, and pulled back through a step of −h from the end.
#[test]
fn gradients_by_state_and_parameters_are_those_of_the_flow() {
    for eccentricity in [0.5, 1.0, 2.0] {
        let conic = Conic { eccentricity };
        let start = conic.at(-1.0);
        let (time, initial) = (conic.at(0.7).time - start.time, start.state(3));
        let (map, weights) = (one_map(3), [0.3, -1.0, 0.7, 0.2, -0.4, 0.9]);
        let zero = [0.0; 6];
        let mut increment = [0.0; 6];
        let mut forth = map.differential(&[MASS, MASS], 1.0, time);
        let (mut covector, mut gradient) = (weights, [0.0; 2]);
        forth.step(&initial, &zero, &mut increment).expect("finite");
        forth
            .pull(&mut covector, &mut gradient)
            .expect("a gradient");
        let found = [&covector[..], &gradient].concat();
        let value = |at: usize, by: f64| {
            let (mut x, mut parameters) = (initial.clone(), [MASS; 2]);
            match at.checked_sub(6) {
                None => x[at] += by,
                Some(at) => parameters[at] += by,
            }
            let end = step(map.stepper(1, &parameters, 1.0, time).as_mut(), &x);
            dot(&end.expect("finite"), &weights)
        };
        let size = largest(&found);
        for (at, found) in found.iter().enumerate() {
            let difference = (value(at, 1e-5) - value(at, -1e-5)) / 2e-5;
            let error = (found - difference).abs();
            assert!(
                error <= 2e-9 * size * size,
                "{eccentricity} {at}: {error:e}"
            );
        }
        let end: Vec<f64> = initial
            .iter()
            .zip(&increment)
            .map(|(x, by)| x + by)
            .collect();
        let mut back = map.differential(&[MASS, MASS], 1.0, -time);
        let (mut covector, mut gradient) = (weights, [0.0; 2]);
        back.step_and_pull_inverse([&end, &zero], &mut increment, &mut covector, &mut gradient)
            .expect("a gradient");
        let error = distance(&[&covector[..], &gradient].concat(), &found);
        assert!(
            error <= 256.0 * f64::EPSILON * size * size,
            "{eccentricity}: {error:e}"
        );
    }
}

/// A repelled body, by Gauss's method.
#[test]
fn repulsion_is_another_sign() {
    for state in [[1.0, -2.0, 0.2, 0.3], [-0.5, 0.1, 0.5, 1.0]] {
        let problem = body(2, [MASS, -1.5], &state);
        let system = problem.system();
        let map = whole(&system).expect("a body about a centre");
        assert_eq!(map.pieces(), 1);
        for time in [0.5, 1.5, -2.0] {
            let end = run(&system, map.as_ref(), &state, time, 1).expect("finite");
            let exact = gauss(&system, &state, time, 400);
            let error = distance(&end, &exact) / largest(&exact);
            assert!(error <= 64.0 * f64::EPSILON, "{time}: {error:e}");
        }
    }
}

/// A fall ends at the centre, a step within a period; what passes close by goes on.
#[test]
fn collisions_and_steps_that_are_too_long_are_refused() {
    // From rest at 1 the fall takes π/√8.
    for (state, time, expected) in [
        ([1.0, 0.0, 0.0, 0.0], 1.0, true),
        ([1.0, 0.0, 0.0, 0.0], 1.2, false),
        ([1.0, 0.0, 0.0, 0.0], -1.2, false),
        ([0.6, 0.0, 0.8, 0.0], 1.2, false),
        ([1.0, 0.0, 0.0, 1e-3], 1.2, true),
        ([0.0, 1.0, 0.0, 0.0], 0.1, false),
        ([1.0, 0.0, 0.0, 2.0], 6.2, true),
        ([1.0, 0.0, 0.0, 2.0], 9.0, false),
        ([1.0, 0.0, 0.0, 8.0], 1e5, false),
        ([f64::NAN, 0.0, 0.0, 2.0], 0.1, false),
    ] {
        let end = step(
            one_map(2).stepper(1, &[MASS, MASS], 1.0, time).as_mut(),
            &state,
        );
        assert_eq!(end.is_ok(), expected, "{state:?} {time}: {end:?}");
    }
}

#[test]
fn lanes_have_the_bits_they_have_alone() {
    let map = one_map(3);
    let initial = Conic { eccentricity: 0.5 }.at(1.0).state(3);
    for lanes in [2, 8, 11] {
        let many = [vec![MASS; lanes], vec![MASS; lanes]].concat();
        let mut wide = map.stepper(lanes, &many, 1.0, 0.4);
        let x: Vec<f64> = (0..6 * lanes)
            .map(|at| initial[at / lanes] + (at % lanes) as f64 / 16.0)
            .collect();
        let (mut increment, mut outcome) = (vec![0.0; 6 * lanes], vec![Ok(()); lanes]);
        wide.increment(&x, &vec![0.0; 6 * lanes], &mut increment, &mut outcome);
        for lane in 0..lanes {
            let own: Vec<f64> = x.iter().skip(lane).step_by(lanes).copied().collect();
            let mut alone = map.stepper(1, &[MASS, MASS], 1.0, 0.4);
            let end = step(alone.as_mut(), &own).expect("finite");
            for i in 0..6 {
                let at = i * lanes + lane;
                assert_eq!((x[at] + increment[at]).to_bits(), end[i].to_bits());
            }
            assert_eq!(alone.tangent(0), wide.tangent(lane));
        }
    }
}

/// Operations of one body's step in space.
#[test]
fn the_flow_takes_so_many_operations() {
    let map = one_map(3);
    let (_, kernel) = map.abilities().kernels[0];
    let count = kernel.step_operations();
    println!("{count:?}");
    assert_eq!(count.total(), 1305);
}

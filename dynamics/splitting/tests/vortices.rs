//! Pairs of point vortices in the plane and on the sphere, and quadratic pieces: motions that turn.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::{Problem, distance, largest, run, splitting, step};
use leafwise_composition::{Composed, Scheme};
use leafwise_core::solver::StepMap;
use leafwise_core::{Convention, PartParameters, Walk};

/// N point vortices in the plane, x₁, y₁, x₂, y₂, ….
fn vortices(circulations: &[f64], initial: Vec<f64>) -> Problem {
    let n = circulations.len();
    let mut terms = Vec::new();
    for i in 0..n {
        terms.extend((0..i).map(|j| format!("g{i}*g{j}*ln((x{i} - x{j})^2 + (y{i} - y{j})^2)")));
    }
    Problem {
        id: "vortices",
        variables: (0..n)
            .flat_map(|i| [format!("x{i}"), format!("y{i}")])
            .collect(),
        parameters: circulations
            .iter()
            .enumerate()
            .map(|(i, g)| (format!("g{i}"), *g))
            .collect(),
        bracket: (0..n)
            .map(|i| (format!("x{i}"), format!("y{i}"), format!("1/g{i}")))
            .collect(),
        hamiltonian: format!("-({})/(4*pi)", terms.join(" + ")),
        casimirs: Vec::new(),
        convention: Convention::HamiltonianSecond,
        initial,
        time_step: 0.1,
    }
}

fn map_of(problem: &Problem) -> Arc<dyn StepMap> {
    splitting(&problem.system(), &PartParameters::new()).expect("it splits")
}

/// Both turn about their centre by (Γ₁ + Γ₂)t/(2πd²), or go on straight by Γ₂t/(2πd) across their distance: a few units of the way.
#[test]
fn a_pair_of_vortices_turns_about_its_centre_or_goes_straight() {
    let initial = [0.3, -0.2, 1.1, 0.4];
    let shift = [initial[2] - initial[0], initial[3] - initial[1]];
    let square = shift[0] * shift[0] + shift[1] * shift[1];
    for circulations in [[1.0, 1.0], [1.0, 0.25], [2.0, -0.5], [1.5, -1.5]] {
        let problem = vortices(&circulations, initial.to_vec());
        let map = map_of(&problem);
        assert_eq!(map.pieces(), 1);
        let [one, other] = circulations;
        for time in [0.1, 3.0, -20.0] {
            let end = run(&problem.system(), map.as_ref(), &initial, time, 1).expect("finite");
            let total = one + other;
            let exact = if total == 0.0 {
                // z₁′ = i Γ₂ (z₁ − z₂)/(2πd²).
                let by = other * time / (2.0 * PI * square);
                let way = [by * shift[1], -by * shift[0]];
                [
                    initial[0] + way[0],
                    initial[1] + way[1],
                    initial[2] + way[0],
                    initial[3] + way[1],
                ]
            } else {
                let centre = [0, 1].map(|k| (one * initial[k] + other * initial[2 + k]) / total);
                let angle = total * time / (2.0 * PI * square);
                let (sin, cos) = (libm::sin(angle), libm::cos(angle));
                let turned = |k: usize| {
                    let [x, y] = [initial[k] - centre[0], initial[k + 1] - centre[1]];
                    [centre[0] + cos * x - sin * y, centre[1] + sin * x + cos * y]
                };
                let [a, b] = [turned(0), turned(2)];
                [a[0], a[1], b[0], b[1]]
            };
            let error = distance(&end, &exact);
            let way = largest(exact).max(1.0) * (1.0 + time.abs());
            assert!(
                error <= 8.0 * f64::EPSILON * way,
                "{circulations:?} {time}: {error:e}"
            );
        }
    }
}

/// A ring of N equal vortices turns at (N − 1)Γ/(4πR²) (J. J. Thomson, 1883), to the order of the composition and the roundings of its steps;
/// ΣΓz and ΣΓ|z|² to those, of N − 1 flows a vortex in each of 15 stages forth and back.
#[test]
fn rings_of_vortices_turn_at_their_rate() {
    for n in [2, 3, 4, 5, 6] {
        let (gamma, radius) = (1.5, 0.8);
        let initial: Vec<f64> = (0..n)
            .flat_map(|i| {
                let angle = 2.0 * PI * i as f64 / n as f64;
                [radius * libm::cos(angle), radius * libm::sin(angle)]
            })
            .collect();
        let problem = vortices(&vec![gamma; n], initial.clone());
        let system = problem.system();
        let scheme = Scheme::find("suzuki-umeno-8").expect("a scheme");
        let map = Composed::new(map_of(&problem), scheme).expect("self-adjoint");
        let rate = (n - 1) as f64 * gamma / (4.0 * PI * radius * radius);
        // A quarter of a turn.
        let steps = 200;
        let mut walk = Walk::new(
            &map,
            &system.parameter_values(),
            1.0,
            PI / 2.0 / rate / steps as f64,
            &initial,
        );
        walk.advance(steps).expect("finite");
        let end = walk.state().to_vec();
        let turned: Vec<f64> = initial.chunks(2).flat_map(|z| [-z[1], z[0]]).collect();
        let error = distance(&end, &turned);
        let flows = steps as f64 * 30.0 * (n - 1) as f64;
        let sums = |z: &[f64]| {
            let of = |f: fn(&[f64]) -> f64| z.chunks(2).map(f).sum::<f64>() * gamma;
            [
                of(|z| z[0]),
                of(|z| z[1]),
                of(|z| z[0] * z[0] + z[1] * z[1]),
            ]
        };
        let drift = distance(&sums(&end), &sums(&initial));
        println!("{n}: off by {error:.1e}, sums by {drift:.1e}");
        assert!(error <= 1e-11, "{n}: {error:e}");
        // Angles of a hundredth or so: units of them.
        assert!(drift <= flows * f64::EPSILON * 0.1, "{n}: {drift:e}");
    }
}

/// All pairs are N − 1 rounds of disjoint ones of an even number N, and N of an odd one: as few pieces as there may be, since
/// no two pairs of a vortex have a flow together. They are found without trying every pair with every piece.
#[test]
fn pairs_of_vortices_are_as_few_pieces_as_their_rounds() {
    for (n, pieces) in [(3, 3), (4, 3), (5, 5), (6, 5), (7, 7), (12, 11), (24, 23)] {
        let initial = (0..n).flat_map(|i| [0.3 * i as f64, libm::sin(1.7 * i as f64)]);
        let circulations: Vec<f64> = (0..n).map(|i| 1.0 + 0.1 * i as f64).collect();
        let problem = vortices(&circulations, initial.collect());
        let begun = std::time::Instant::now();
        assert_eq!(map_of(&problem).pieces(), pieces, "{n}");
        println!("{n}: {:.2} s", begun.elapsed().as_secs_f64());
    }
}

/// A mean field of spins with the Casimir of each, or with one of all: H as it is written is two pieces, and no multiple of a
/// Casimir makes fewer. What would be more is given up as soon as it is.
#[test]
fn a_mean_field_beside_casimirs_is_two_pieces() {
    for (n, is_each) in [(3, true), (3, false), (10, true), (10, false)] {
        let spin = |i: usize| ["x", "y", "z"].map(|c| format!("{c}{i}"));
        let sum = |c: &str| {
            (0..n)
                .map(|i| format!("{c}{i}"))
                .collect::<Vec<_>>()
                .join(" + ")
        };
        let square = |i: usize| format!("x{i}^2 + y{i}^2 + z{i}^2");
        let casimirs: Vec<String> = match is_each {
            true => (0..n).map(square).collect(),
            false => vec![(0..n).map(square).collect::<Vec<_>>().join(" + ")],
        };
        let problem = Problem {
            id: "spins",
            variables: (0..n).flat_map(spin).collect(),
            parameters: Vec::new(),
            bracket: (0..n)
                .flat_map(|i| {
                    let [x, y, z] = spin(i);
                    [
                        (x.clone(), y.clone(), z.clone()),
                        (y, z.clone(), x.clone()),
                        {
                            let [x, y, z] = spin(i);
                            (z, x, y)
                        },
                    ]
                })
                .collect(),
            hamiltonian: format!("-({})^2/{} - 0.3*({})", sum("z"), 2 * n, sum("x")),
            casimirs,
            convention: Convention::HamiltonianSecond,
            initial: (0..3 * n).map(|at| libm::cos(1.3 * at as f64)).collect(),
            time_step: 0.1,
        };
        let begun = std::time::Instant::now();
        assert_eq!(map_of(&problem).pieces(), 2, "{n} {is_each}");
        println!("{n} {is_each}: {:.2} s", begun.elapsed().as_secs_f64());
    }
}

/// p²/2m ± kq²/2 are one piece, which turns or grows by its closed form.
#[test]
fn oscillators_turn_and_saddles_grow_by_their_closed_forms() {
    let pair = |hamiltonian: &str| Problem {
        id: "oscillator",
        variables: ["q", "p"].map(str::to_owned).to_vec(),
        parameters: vec![("m".to_owned(), 2.0), ("k".to_owned(), 3.0)],
        bracket: vec![("q".to_owned(), "p".to_owned(), "1".to_owned())],
        hamiltonian: hamiltonian.to_owned(),
        casimirs: Vec::new(),
        convention: Convention::HamiltonianSecond,
        initial: vec![0.7, -0.4],
        time_step: 0.1,
    };
    let (rate, size) = (libm::sqrt(1.5), libm::sqrt(6.0));
    for (hamiltonian, even, odd, sign) in [
        (
            "p^2/(2*m) + k*q^2/2",
            libm::cos as fn(f64) -> f64,
            libm::sin as fn(f64) -> f64,
            -1.0,
        ),
        ("p^2/(2*m) - k*q^2/2", libm::cosh, libm::sinh, 1.0),
    ] {
        let problem = pair(hamiltonian);
        let map = map_of(&problem);
        assert_eq!(map.pieces(), 1, "{hamiltonian}");
        for time in [0.1, 1.0, -3.0] {
            let (even, odd) = (even(rate * time), odd(rate * time));
            let [q, p] = [0.7, -0.4];
            let exact = [even * q + odd * p / size, even * p + sign * odd * size * q];
            let mut stepper = map.stepper(1, &[2.0, 3.0], 1.0, time);
            let end = step(stepper.as_mut(), &problem.initial).expect("finite");
            let error = distance(&end, &exact);
            let growth = (even.abs() + odd.abs() * size) * (1.0 + rate * time.abs());
            assert!(
                error <= 4.0 * f64::EPSILON * growth,
                "{hamiltonian} {time}: {error:e}"
            );
        }
    }
}

/// Of the distance of two vortices on a sphere.
#[derive(Clone, Copy)]
enum Distance {
    /// 1 − x·y, half its square.
    ByProduct,
    /// |x − y|².
    OfChord,
}

/// N point vortices on the unit sphere, x₀, y₀, z₀, x₁, …; the circulations are coordinates at rest behind these.
fn on_a_sphere(circulations: &[f64], positions: Vec<f64>, distance: Distance) -> Problem {
    let n = circulations.len();
    let mut terms = Vec::new();
    for i in 0..n {
        terms.extend((0..i).map(|j| {
            let square = match distance {
                Distance::ByProduct => format!("1 - x{i}*x{j} - y{i}*y{j} - z{i}*z{j}"),
                Distance::OfChord => {
                    format!("(x{i} - x{j})^2 + (y{i} - y{j})^2 + (z{i} - z{j})^2")
                }
            };
            format!("g{i}*g{j}*ln({square})")
        }));
    }
    let names = |i: usize| ["x", "y", "z"].map(|c| format!("{c}{i}"));
    let entries = |i: usize| {
        [0, 1, 2].map(|k| {
            let [one, other, third] = [0, 1, 2].map(|by| names(i)[(k + by) % 3].clone());
            (one, other, format!("{third}/g{i}"))
        })
    };
    let circulation = |i: usize| format!("g{i}");
    Problem {
        id: "sphere-vortices",
        variables: (0..n)
            .flat_map(names)
            .chain((0..n).map(circulation))
            .collect(),
        parameters: Vec::new(),
        bracket: (0..n).flat_map(entries).collect(),
        hamiltonian: format!("-({})/(4*pi)", terms.join(" + ")),
        casimirs: (0..n)
            .map(|i| format!("x{i}^2 + y{i}^2 + z{i}^2"))
            .collect(),
        convention: Convention::HamiltonianSecond,
        initial: [&positions[..], circulations].concat(),
        time_step: 0.1,
    }
}

/// Σ Γ x and the |x|² of vortices on a sphere.
fn moment_and_lengths(state: &[f64], n: usize) -> Vec<f64> {
    let (positions, circulations) = state.split_at(3 * n);
    let sites = || positions.chunks(3).zip(circulations);
    let moment = (0..3).map(|k| sites().map(|(x, g)| g * x[k]).sum());
    let lengths = positions.chunks(3).map(|x| x.iter().map(|x| x * x).sum());
    moment.chain(lengths).collect()
}

/// v turned about an axis by an angle: O. Rodrigues' formula (1840).
fn turned(v: [f64; 3], axis: [f64; 3], angle: f64) -> [f64; 3] {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let along = (0..3).map(|k| axis[k] * v[k]).sum::<f64>();
    [0, 1, 2].map(|k| {
        let [next, other] = [(k + 1) % 3, (k + 2) % 3];
        let cross = axis[next] * v[other] - axis[other] * v[next];
        cos * v[k] + sin * cross + (1.0 - cos) * along * axis[k]
    })
}

/// Both turn about M = Γ₁x₁ + Γ₂x₂ by |M|t/(4π(1 − x₁·x₂)) (Newton, *The N-Vortex Problem*, section 4.2), or rest where M = 0: a few
/// units, and those of the angle. Lengths and M are kept to a few units, far turns and all.
#[test]
fn a_pair_on_a_sphere_turns_about_its_centre_of_vorticity() {
    let (x, y) = ([0.8, 0.0, 0.6], [0.0, -0.6, 0.8]);
    let opposite = [-0.8, 0.0, -0.6];
    for (circulations, y) in [
        ([1.0, 1.0], y),
        ([1.0, 0.25], y),
        ([2.0, -0.5], y),
        ([1.5, -1.5], y),
        ([1.0, 1.0], opposite),
    ] {
        let moment = [0, 1, 2].map(|k| circulations[0] * x[k] + circulations[1] * y[k]);
        let length = libm::sqrt(moment.iter().map(|m| m * m).sum());
        let inner: f64 = (0..3).map(|k| x[k] * y[k]).sum();
        let rate = length / (4.0 * PI * (1.0 - inner));
        let axis = moment.map(|m| if length == 0.0 { 0.0 } else { m / length });
        for distance in [Distance::ByProduct, Distance::OfChord] {
            let problem = on_a_sphere(&circulations, [x, y].concat(), distance);
            let map = map_of(&problem);
            assert_eq!(map.pieces(), 1);
            for time in [0.1, 3.0, -20.0, 300.0] {
                let end = run(&problem.system(), map.as_ref(), &problem.initial, time, 1);
                let end = end.expect("finite");
                let exact = [x, y].map(|v| match length == 0.0 {
                    true => v,
                    false => turned(v, axis, rate * time),
                });
                let error = self::distance(&end[..6], &exact.concat());
                let bound = 8.0 * f64::EPSILON * (1.0 + (rate * time).abs());
                assert!(error <= bound, "{circulations:?} {time}: {error:e}");
                let kept = [&end, &problem.initial].map(|state| moment_and_lengths(state, 2));
                let drift = self::distance(&kept[0], &kept[1]);
                assert!(
                    drift <= 16.0 * f64::EPSILON,
                    "{circulations:?} {time}: {drift:e}"
                );
            }
        }
    }
}

/// A ring of N equal vortices at colatitude θ turns at (N − 1)Γ cos θ/(4π sin² θ) (L. M. Polvani, D. G. Dritschel, J. Fluid Mech. 255
/// (1993)), in as few rounds as all pairs have; to the order of the composition and the roundings of its steps.
#[test]
fn rings_on_a_sphere_turn_at_their_rate() {
    for (n, pieces) in [(2, 1), (3, 3), (4, 3), (5, 5), (6, 5)] {
        let (gamma, theta) = (1.5, 0.7);
        let (sin, cos) = (libm::sin(theta), libm::cos(theta));
        let ring = |turn: f64| -> Vec<f64> {
            let at = |i: usize| turn + 2.0 * PI * i as f64 / n as f64;
            (0..n)
                .flat_map(|i| [sin * libm::cos(at(i)), sin * libm::sin(at(i)), cos])
                .collect()
        };
        let problem = on_a_sphere(&vec![gamma; n], ring(0.0), Distance::OfChord);
        let map = map_of(&problem);
        assert_eq!(map.pieces(), pieces, "{n}");
        let scheme = Scheme::find("suzuki-umeno-8").expect("a scheme");
        let composed = Composed::new(map, scheme).expect("self-adjoint");
        let rate = (n - 1) as f64 * gamma * cos / (4.0 * PI * sin * sin);
        // A quarter of a turn.
        let steps = 200;
        let time = PI / 2.0 / rate;
        let end = run(&problem.system(), &composed, &problem.initial, time, steps).expect("finite");
        let error = distance(&end[..3 * n], &ring(PI / 2.0));
        let kept = [&end, &problem.initial].map(|state| moment_and_lengths(state, n));
        let drift = distance(&kept[0], &kept[1]);
        println!("{n}: off by {error:.1e}, kept to {drift:.1e}");
        assert!(error <= 1e-11, "{n}: {error:e}");
        // Angles of a hundredth or so: units of them, in 30 flows a step of N − 1 pairs each.
        let flows = steps as f64 * 30.0 * (n - 1) as f64;
        assert!(drift <= flows * f64::EPSILON * 0.1, "{n}: {drift:e}");
    }
}

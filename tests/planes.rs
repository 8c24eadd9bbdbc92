//! Lattices of two and three axes, stepped by templates, against the same systems with every site written out.

use std::cell::Cell;
use std::fmt::Write as _;

use leafwise::scene::ComposedRun;
use leafwise::scene::compose::Stepping;
use leafwise_tests::numbers::{distance, largest};
use leafwise_tests::scenes::composed;
use proptest::prelude::*;

/// A field q, p on a torus, or on one with ends along some axes. The pieces of its splitting have one order: by cost a lattice and
/// the system written out may choose different ones, which differ by h³.
#[derive(Clone, Debug)]
struct Field {
    lengths: Vec<usize>,
    periodic: Vec<bool>,
    /// Couplings: a (q − q')^power at so far an offset.
    couplings: Vec<(Vec<i64>, u32)>,
    method: &'static str,
}

const INDICES: [&str; 3] = ["i", "j", "k"];

impl Field {
    fn sites(&self) -> usize {
        self.lengths.iter().product()
    }

    fn place(&self, site: usize) -> Vec<usize> {
        let (mut place, mut rest) = (vec![0; self.lengths.len()], site);
        for axis in (0..self.lengths.len()).rev() {
            place[axis] = rest % self.lengths[axis];
            rest /= self.lengths[axis];
        }
        place
    }

    /// The site so far from another one; `None` beyond an end.
    fn beside(&self, site: usize, offset: &[i64]) -> Option<usize> {
        let mut number = 0;
        for (axis, at) in self.place(site).into_iter().enumerate() {
            let (length, at) = (self.lengths[axis] as i64, at as i64 + offset[axis]);
            let at = match self.periodic[axis] {
                true => at.rem_euclid(length),
                false if (0..length).contains(&at) => at,
                false => return None,
            };
            number = number * length + at;
        }
        Some(number as usize)
    }

    fn initial(&self) -> Vec<f64> {
        let angle = |site: usize| 0.7 * site as f64;
        let q = (0..self.sites()).map(|site| 0.4 * libm::sin(angle(site)));
        let p = (0..self.sites()).map(|site| 0.3 * libm::cos(angle(site)));
        q.chain(p).collect()
    }

    fn tail(&self) -> String {
        format!(
            "[method]\n{}\ntime-step = 0.05\n[run]\nsteps = 10\n",
            self.method
        )
    }

    /// The scene by templates.
    fn by_templates(&self) -> String {
        let axes = self.lengths.len();
        let here = INDICES[..axes].join(",");
        let there = |offset: &[i64]| -> String {
            let sites = INDICES.iter().zip(offset).map(|(index, by)| match by {
                0 => (*index).to_owned(),
                by => format!("{index}{by:+}"),
            });
            sites.collect::<Vec<_>>().join(",")
        };
        let mut terms = format!("p[{here}]^2/2 + a*q[{here}]^4");
        for (offset, power) in &self.couplings {
            let _ = write!(terms, " + a*(q[{here}] - q[{}])^{power}", there(offset));
        }
        let ends: Vec<&str> = (self.periodic.iter())
            .map(|periodic| {
                if *periodic {
                    "\"periodic\""
                } else {
                    "\"open\""
                }
            })
            .collect();
        let sums = INDICES[..axes].join(", ");
        format!(
            "[system]\nfamilies = {{ q = {:?}, p = {:?} }}\nboundary = [{}]\nparameters = {{ a = 0.25 }}\n\
             bracket = {{ \"p[{here}],q[{here}]\" = \"1\" }}\nhamiltonian = \"sum({sums}, {terms})\"\n{}[run.initial]\n\
             \"q[{here}]\" = \"0.4*sin(0.7*({number}))\"\n\"p[{here}]\" = \"0.3*cos(0.7*({number}))\"\n",
            self.lengths,
            self.lengths,
            ends.join(", "),
            self.tail(),
            number = self.number(),
        )
    }

    /// The number of a site by its indices.
    fn number(&self) -> String {
        let mut text = "0".to_owned();
        for (index, length) in INDICES.iter().zip(&self.lengths) {
            text = format!("({text})*{length} + {index}");
        }
        text
    }

    /// The scene with single variables.
    fn written_out(&self) -> String {
        let sites = 0..self.sites();
        let names =
            |c: &str| -> Vec<String> { sites.clone().map(|at| format!("\"{c}{at}\"")).collect() };
        let (mut terms, mut bracket) = (Vec::new(), String::new());
        for site in sites.clone() {
            terms.push(format!("p{site}^2/2 + a*q{site}^4"));
            for (offset, power) in &self.couplings {
                let other = self.beside(site, offset);
                terms.extend(other.map(|other| format!("a*(q{site} - q{other})^{power}")));
            }
            let _ = writeln!(bracket, "\"p{site},q{site}\" = \"1\"");
        }
        let variables = [names("q"), names("p")].concat();
        format!(
            "[system]\nvariables = [{}]\nparameters = {{ a = 0.25 }}\nhamiltonian = \"{}\"\n[system.bracket]\n{bracket}{}\
             initial = {:?}\n",
            variables.join(", "),
            terms.join(" + "),
            self.tail(),
            self.initial(),
        )
    }
}

/// The energy, the state after ten steps, and the first step's differential: DΦ v, then DΦᵀw.
fn end(run: &ComposedRun) -> (f64, Vec<f64>, Vec<f64>) {
    let mut energy = [0.0];
    let mut invariants = run.invariants().expect("an energy");
    invariants.evaluate(&run.plan.initial, &mut energy);
    let mut walk = run.walk();
    walk.advance(10).expect("steps");
    let x = &run.plan.initial;
    let vector = |phase: f64| (0..x.len()).map(move |i| libm::sin(phase + 0.7 * i as f64));
    let (mut tangent, mut covector): (Vec<f64>, Vec<f64>) =
        (vector(0.3).collect(), vector(1.4).collect());
    let (map, parameters) = (run.method.map(), run.system.parameter_values());
    let mut differential = map.differential(&parameters, run.plan.epsilon, run.plan.h);
    let step = differential.step(x, &vec![0.0; x.len()], &mut vec![0.0; x.len()]);
    step.expect("a step");
    differential.push(&mut tangent, &[]).expect("a tangent");
    differential
        .pull(&mut covector, &mut [])
        .expect("a covector");
    (energy[0], walk.last(0).1, [tangent, covector].concat())
}

/// Whether code is written on a lattice that is shorter along an axis.
fn is_cut(run: &ComposedRun) -> bool {
    match &run.method {
        Stepping::Lattice(lattice) => {
            lattice.base.map().proxy_geometry != lattice.base.map().geometry
        }
        _ => false,
    }
}

fn fields() -> impl Strategy<Value = Field> {
    let short = (1_usize..=4, any::<bool>());
    let middle = (4_usize..=8, any::<bool>());
    let long = (12_usize..=14, any::<bool>());
    // Long axes are cut at most offsets, short ones wrap at some.
    let axes = prop_oneof![
        2 => (long.clone(), middle.clone()).prop_map(|(a, b)| vec![a, b]),
        2 => (middle.clone(), long.clone()).prop_map(|(a, b)| vec![a, b]),
        2 => (short.clone(), long.clone()).prop_map(|(a, b)| vec![a, b]),
        1 => (middle.clone(), middle).prop_map(|(a, b)| vec![a, b]),
        2 => (short.clone(), short, long).prop_map(|(a, b, c)| vec![a, b, c]),
    ];
    let method = prop_oneof![
        3 => Just("stepper = { name = \"splitting\", pieces = \"1 2\" }"),
        1 => Just("realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }"),
    ];
    let offset = prop::collection::vec(-2_i64..3, 3);
    let couplings = prop::collection::vec((offset, prop_oneof![Just(3_u32), Just(4)]), 1..4);
    (axes, couplings, method).prop_map(|(axes, couplings, method)| {
        let (lengths, periodic): (Vec<_>, Vec<_>) = axes.into_iter().unzip();
        let cut = |(mut offset, power): (Vec<i64>, u32)| {
            offset.truncate(lengths.len());
            // Half of a ring at most.
            for ((by, length), is_ring) in offset.iter_mut().zip(&lengths).zip(&periodic) {
                if *is_ring {
                    let half = (length / 2) as i64;
                    *by = (*by).clamp(-half, half);
                }
            }
            (offset, power)
        };
        let couplings = couplings.into_iter().map(cut);
        Field {
            couplings: couplings
                .filter(|(offset, _)| offset.iter().any(|by| *by != 0))
                .collect(),
            lengths: lengths.clone(),
            periodic,
            method,
        }
    })
}

/// Whatever the offsets, the ends and the method: energies, ten steps and the differential of a step are those of the system
/// written out, to 1e-13.
#[test]
fn planes_move_as_the_systems_written_out() {
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(24)
    };
    let (swept, cut) = (Cell::new(0), Cell::new(0));
    proptest!(config, |(field in fields())| {
        let run = composed(&field.by_templates());
        swept.update(|swept| swept + usize::from(run.method.lattice().is_some()));
        cut.update(|cut| cut + usize::from(is_cut(&run)));
        let (energy, state, differential) = end(&run);
        let (expected, written, slopes) = end(&composed(&field.written_out()));
        prop_assert!((energy - expected).abs() <= 1e-13 * expected.abs(), "{energy} {expected}");
        let apart = distance(&state, &written);
        prop_assert!(apart <= 1e-13, "{apart:e}");
        let apart = distance(&differential, &slopes) / largest(&slopes);
        prop_assert!(apart <= 1e-13, "differential: {apart:e}");
    });
    let (swept, cut) = (swept.get(), cut.get());
    assert!(
        swept >= 20 && cut >= 12,
        "of 24 {swept} are swept, {cut} of them by a shorter lattice"
    );
}

/// A spiral of spins along the second axis of a torus, with k = π/8 on 16 sites.
fn spiral(step: f64, steps: u64) -> Vec<f64> {
    let text = format!(
        "[system]\nfamilies = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = [5, 16] }} }}\n\
         bracket = {{ lie-algebra = \"so3\" }}\nhamiltonian = \"-sum(i, j, s.x[i,j]*(s.x[i+1,j] + s.x[i,j+1]) + \
         s.y[i,j]*(s.y[i+1,j] + s.y[i,j+1]) + s.z[i,j]*(s.z[i+1,j] + s.z[i,j+1]))\"\n\
         [method]\nstepper = \"splitting\"\ncomposition = \"suzuki-4\"\ntime-step = {step}\n[run]\nsteps = {steps}\n\
         [run.initial]\n\"s.x[i,j]\" = \"0.6*cos(pi*j/8)\"\n\"s.y[i,j]\" = \"0.6*sin(pi*j/8)\"\n\"s.z[i,j]\" = 0.8\n"
    );
    let run = composed(&text);
    assert!(run.method.lattice().is_some());
    let mut walk = run.walk();
    walk.advance(steps).expect("steps");
    walk.last(0).1
}

/// The exact spiral turns about z at −2Jc(1 − cos k), here −0.121792748, whatever its amplitude; spins along the other axis are parallel.
#[test]
fn a_spiral_on_a_torus_turns_at_the_exact_rate() {
    let rate = -2.0 * 0.8 * (1.0 - libm::cos(std::f64::consts::PI / 8.0));
    assert!((rate + 0.121_792_748).abs() < 5e-10, "{rate}");
    let time = 8.0;
    let apart = |steps: u64| {
        let state = spiral(time / steps as f64, steps);
        let sites = state.len() / 3;
        let expected = |site: usize| {
            let angle = std::f64::consts::PI * (site % 16) as f64 / 8.0 + rate * time;
            [0.6 * libm::cos(angle), 0.6 * libm::sin(angle), 0.8]
        };
        let mut farthest = 0.0_f64;
        for site in 0..sites {
            let spin = [state[site], state[sites + site], state[2 * sites + site]];
            let length: f64 = spin.iter().map(|x| x * x).sum();
            assert!((length - 1.0).abs() < 1e-13, "|s|² = {length}");
            let pairs = spin.iter().zip(expected(site));
            farthest = pairs.fold(farthest, |most, (a, b)| most.max((a - b).abs()));
        }
        farthest
    };
    let [coarse, fine] = [100, 200].map(apart);
    let order = libm::log2(coarse / fine);
    assert!(
        (order - 4.0).abs() < 0.2 && fine < 1e-5,
        "order {order}, {fine:e} apart"
    );
}

/// The same spiral on a box of 16³ spins, with k along the first axis: measured over t = 2, the rate is exact to the error of the
/// method of order 4, 8e-6 at h = 0.05 and 1.2e-6 here.
#[test]
fn a_spiral_on_a_box_turns_at_the_exact_rate() {
    let bonds = ["x", "y", "z"]
        .map(|c| format!("s.{c}[i,j,k]*(s.{c}[i+1,j,k] + s.{c}[i,j+1,k] + s.{c}[i,j,k+1])"));
    let run = composed(&format!(
        "[system]\nfamilies = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = [16, 16, 16] }} }}\n\
         bracket = {{ lie-algebra = \"so3\" }}\nhamiltonian = \"-sum(i, j, k, {})\"\n\
         [method]\nstepper = \"splitting\"\ncomposition = \"suzuki-4\"\ntime-step = 0.025\n[run]\nsteps = 80\n\
         [run.initial]\n\"s.x[i,j,k]\" = \"0.6*cos(pi*i/8)\"\n\"s.y[i,j,k]\" = \"0.6*sin(pi*i/8)\"\n\"s.z[i,j,k]\" = 0.8\n",
        bonds.join(" + ")
    ));
    assert!(run.method.lattice().is_some());
    let mut walk = run.walk();
    walk.advance(80).expect("steps");
    let state = walk.last(0).1;
    let sites = 4096;
    for site in 0..sites {
        let angle = std::f64::consts::PI * (site / 256) as f64 / 8.0;
        let [x, y] = [state[site], state[sites + site]];
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let rate = libm::atan2(y * cosine - x * sine, x * cosine + y * sine) / 2.0;
        assert!((rate + 0.121_792_748).abs() <= 2e-6, "{site}: {rate}");
    }
}

//! Offsets of any length on rings, tori and boxes, in H, brackets and observables, against loops written here.

use std::cell::Cell;

use leafwise::core::Registry;
use leafwise::scene::ComposedRun;
use leafwise::scene::compose::compose;
use leafwise_tests::numbers::distance;
use leafwise_tests::scenes::document;
use proptest::prelude::*;

const INDICES: [&str; 3] = ["i", "j", "k"];
const STEP: f64 = 0.05;
const STEPS: u64 = 10;

/// H = Σ p²/2 + p p'/5 + q⁴/10 − cos(q'' − q) with {q''', p} = −1, each prime a site at so far an offset, and a recorded sum of
/// products of sites that are as far apart as those of H.
#[derive(Clone, Debug)]
struct Lattice {
    lengths: Vec<usize>,
    periodic: Vec<bool>,
    /// Offsets of H's q, of its p, of the bracket.
    offsets: [Vec<i64>; 3],
}

impl Lattice {
    fn sites(&self) -> usize {
        self.lengths.iter().product()
    }

    /// The site so far from another one; `None` beyond an end.
    fn beside(&self, site: usize, offset: &[i64]) -> Option<usize> {
        let (mut rest, mut number, mut stride) = (site, 0, 1);
        for axis in (0..self.lengths.len()).rev() {
            let length = self.lengths[axis] as i64;
            let at = (rest % self.lengths[axis]) as i64 + offset[axis];
            rest /= self.lengths[axis];
            let at = match self.periodic[axis] {
                true => at.rem_euclid(length),
                false if (0..length).contains(&at) => at,
                false => return None,
            };
            number += at as usize * stride;
            stride *= self.lengths[axis];
        }
        Some(number)
    }

    fn scene(&self) -> String {
        let axes = self.lengths.len();
        let at = |offset: &[i64]| -> String {
            let sites = INDICES.iter().zip(offset).map(|(index, by)| match by {
                0 => (*index).to_owned(),
                by => format!("{index}{by:+}"),
            });
            sites.collect::<Vec<_>>().join(",")
        };
        let here = INDICES[..axes].join(",");
        let [of_q, of_p, of_bracket] = self.offsets.each_ref().map(|offset| at(offset));
        let sums = INDICES[..axes].join(", ");
        let ends = self.periodic.iter();
        let ends: Vec<&str> = ends
            .map(|own| if *own { "\"periodic\"" } else { "\"open\"" })
            .collect();
        let mut number = "0".to_owned();
        for (index, length) in INDICES.iter().zip(&self.lengths) {
            number = format!("({number})*{length} + {index}");
        }
        format!(
            "[system]\nfamilies = {{ q = {lengths:?}, p = {lengths:?} }}\nboundary = [{}]\n\
             bracket = {{ \"q[{of_bracket}],p[{here}]\" = \"-1\" }}\n\
             hamiltonian = \"sum({sums}, p[{here}]^2/2 + p[{here}]*p[{of_p}]/5 + q[{here}]^4/10 - cos(q[{of_q}] - q[{here}]))\"\n\
             [method]\nstepper = {{ name = \"splitting\", pieces = \"1 2\" }}\ntime-step = {STEP}\n\
             [run]\nsteps = {STEPS}\nrecord = {{ observables = [\"sum({sums}, q[{here}]*p[{of_q}])\"] }}\n[run.initial]\n\
             \"q[{here}]\" = \"0.4*sin(0.7*({number}))\"\n\"p[{here}]\" = \"0.3*cos(1.1*({number}))\"\n",
            ends.join(", "),
            lengths = self.lengths,
        )
    }

    fn initial(&self) -> [Vec<f64>; 2] {
        let sites = || (0..self.sites()).map(|site| site as f64);
        let q = sites().map(|site| 0.4 * libm::sin(0.7 * site));
        [
            q.collect(),
            sites().map(|site| 0.3 * libm::cos(1.1 * site)).collect(),
        ]
    }

    /// The energy and Σ q p'.
    fn sums(&self, [q, p]: &[Vec<f64>; 2]) -> [f64; 2] {
        let [of_q, of_p, _] = &self.offsets;
        let (mut energy, mut sum) = (0.0, 0.0);
        for site in 0..self.sites() {
            energy += p[site] * p[site] / 2.0 + libm::pow(q[site], 4.0) / 10.0;
            if let Some(other) = self.beside(site, of_p) {
                energy += p[site] * p[other] / 5.0;
            }
            if let Some(other) = self.beside(site, of_q) {
                energy -= libm::cos(q[other] - q[site]);
                sum += q[site] * p[other];
            }
        }
        [energy, sum]
    }

    /// Moves q by ∂H/∂p for a time, or p by −∂H/∂q.
    fn flow(&self, [q, p]: &mut [Vec<f64>; 2], time: f64, moves_q: bool) {
        let [of_q, of_p, of_bracket] = &self.offsets;
        let mut slope = vec![0.0; self.sites()];
        for site in 0..self.sites() {
            if moves_q {
                slope[site] += p[site];
                if let Some(other) = self.beside(site, of_p) {
                    slope[site] += p[other] / 5.0;
                    slope[other] += p[site] / 5.0;
                }
            } else {
                slope[site] += 0.4 * q[site] * q[site] * q[site];
                if let Some(other) = self.beside(site, of_q) {
                    let force = libm::sin(q[other] - q[site]);
                    slope[other] += force;
                    slope[site] -= force;
                }
            }
        }
        for site in 0..self.sites() {
            if let Some(other) = self.beside(site, of_bracket) {
                match moves_q {
                    true => q[other] += time * slope[site],
                    false => p[site] -= time * slope[other],
                }
            }
        }
    }

    /// Ten steps that begin and end with half a flow of q, or of p.
    fn steps(&self, first_moves_q: bool) -> Vec<f64> {
        let mut state = self.initial();
        for _ in 0..STEPS {
            self.flow(&mut state, STEP / 2.0, first_moves_q);
            self.flow(&mut state, STEP, !first_moves_q);
            self.flow(&mut state, STEP / 2.0, first_moves_q);
        }
        state.concat()
    }

    /// Energy, recorded sum and ten steps against loops; `false` where the scene is refused for how far it looks.
    fn check(&self) -> bool {
        let scene = document(&self.scene(), &[]);
        let run = match compose(&scene, &Registry::with_builtin()) {
            Ok(run) => run,
            Err(refusal) => {
                let named = [
                    "coordinates",
                    "sites away",
                    "an axis of",
                    "beyond half of a ring",
                ];
                let is_named = named.iter().any(|part| refusal.message.contains(part));
                assert!(is_named, "{self:?}: {refusal}");
                return false;
            }
        };
        self.check_run(&run);
        true
    }

    fn check_run(&self, run: &ComposedRun) {
        let sums = self.sums(&self.initial());
        let mut energy = [0.0];
        let mut invariants = run.invariants().expect("an energy");
        invariants.evaluate(&run.plan.initial, &mut energy);
        let functions = run.recorded_functions().expect("code");
        let parameters = run.system.parameter_values();
        let mut values = functions.values(1, &parameters).expect("code");
        // Sums of so many terms of size 1.
        let allowed = 1e-13 * self.sites() as f64;
        for (found, expected) in [
            (energy[0], sums[0]),
            (values.at(&run.plan.initial)[0], sums[1]),
        ] {
            assert!(
                (found - expected).abs() <= allowed,
                "{self:?}: {found} {expected}"
            );
        }
        let mut walk = run.walk();
        walk.advance(STEPS).expect("steps");
        let state = walk.last(0).1;
        // A splitting begins with the flow of fewer operations.
        let apart = [true, false].map(|first| distance(&state, &self.steps(first)));
        let apart = apart[0].min(apart[1]);
        assert!(apart <= 1e-13, "{self:?}: {apart:e}");
    }
}

/// A ring or an open chain whose H, bracket and recorded sum look so far.
fn chain(sites: usize, offset: usize, is_ring: bool) -> Lattice {
    let offset = offset as i64;
    Lattice {
        lengths: vec![sites],
        periodic: vec![is_ring],
        // The bracket looks less far, and the other way on every second chain.
        offsets: [
            offset,
            -(offset / 3),
            if offset % 2 == 0 { offset / 2 } else { -1 },
        ]
        .map(|o| vec![o]),
    }
}

/// Every offset 1 … 100 on rings and chains of 50 … 4096 sites: three lengths each, which change from one to the next.
#[test]
fn every_offset_means_its_site_on_rings_of_any_length() {
    let (short, middle, long) = (
        [50, 51, 57, 64, 75, 99],
        [101, 128, 150, 200, 201, 203],
        [300, 512, 777, 1000, 1024, 2048, 4096],
    );
    let (mut taken, mut beyond) = (0, 0);
    for offset in 1..=100 {
        let own = [
            short[offset % short.len()],
            middle[offset % middle.len()],
            long[offset % long.len()],
        ];
        for sites in own {
            for is_ring in [true, false] {
                let is_taken = chain(sites, offset, is_ring).check();
                if is_ring && 2 * offset > sites {
                    assert!(!is_taken, "{offset} on {sites} sites");
                    beyond += 1;
                } else {
                    taken += usize::from(is_taken);
                }
            }
        }
    }
    let all = 600 - beyond;
    assert!(
        beyond > 50 && 6 * taken >= 5 * all,
        "of {all} chains {taken} are taken, {beyond} rings look beyond their half"
    );
}

fn lattices() -> impl Strategy<Value = Lattice> {
    let axis = |from: usize, to: usize| (from..=to, any::<bool>());
    let shapes = prop_oneof![
        6 => (axis(7, 20), axis(9, 20)).prop_map(|(a, b)| (vec![a, b], [5, 5, 1])),
        1 => (axis(20, 64), axis(20, 64)).prop_map(|(a, b)| (vec![a, b], [3, 3, 1])),
        4 => (axis(5, 8), axis(6, 9), axis(7, 10)).prop_map(|(a, b, c)| (vec![a, b, c], [2, 1, 1])),
        1 => (axis(9, 16), axis(9, 16), axis(9, 16)).prop_map(|(a, b, c)| (vec![a, b, c], [1, 1, 1])),
    ];
    let offset = || prop::collection::vec(-1.0..1.0_f64, 3);
    (shapes, [offset(), offset(), offset()]).prop_map(|((axes, most), parts)| {
        let (lengths, periodic): (Vec<usize>, Vec<bool>) = axes.into_iter().unzip();
        let offset = |(at, part): (usize, Vec<f64>)| -> Vec<i64> {
            let own = part.iter().zip(&lengths);
            let own = own
                .map(|(part, length)| {
                    let most = f64::from(most[at]).min((length / 2) as f64);
                    libm::round(part * (most + 0.49)) as i64
                })
                .collect::<Vec<_>>();
            // H has no term of a site with itself.
            match own.iter().all(|by| *by == 0) && at < 2 {
                true => lengths
                    .iter()
                    .enumerate()
                    .map(|(axis, _)| i64::from(axis == 0))
                    .collect(),
                false => own,
            }
        };
        Lattice {
            offsets: {
                let [a, b, c] = parts;
                [offset((0, a)), offset((1, b)), offset((2, c))]
            },
            lengths,
            periodic,
        }
    })
}

/// Random offsets on tori from 7 × 9 to 64 × 64 and boxes from 5 × 6 × 7 to 16 × 16 × 16, with ends along some axes.
#[test]
fn random_offsets_mean_their_sites_on_tori_and_boxes() {
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(24)
    };
    let taken = Cell::new(0);
    proptest!(config, |(lattice in lattices())| {
        taken.update(|taken| taken + usize::from(lattice.check()));
    });
    assert!(
        taken.get() >= 20,
        "of 24 lattices {} are taken",
        taken.get()
    );
}

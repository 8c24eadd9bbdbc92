//! Structure factors of recorded states, for pictures alone: the sines of this transform are the platform's.

use leafwise_core::lattice::LatticeGeometry;
use leafwise_report::StructureFactor;
use leafwise_scene::compose::Sites;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;

/// The fewest sites along an axis that is worth a picture.
const SHORTEST: usize = 4;

/// [`StructureFactor`] of the first family, or the sum of those of the components of its vector. Of three axes it is that
/// in the plane q_k = 0. The run has recorded `recorded` samples.
///
/// There is none where sites are no lattice, an axis has ends or few sites, or there are no states.
pub(super) fn structure(
    sites: &Sites,
    states: &[(f64, Vec<f64>)],
    recorded: u64,
) -> Option<StructureFactor> {
    let geometry = &sites.geometry;
    let is_wide = geometry.axes.iter().all(|axis| axis.length >= SHORTEST);
    if !sites.has_neighbours || !geometry.is_periodic() || !is_wide || states.is_empty() {
        return None;
    }
    let first = &geometry.families.first()?.0;
    let name = first
        .split_once('.')
        .map_or(first.as_str(), |(vector, _)| vector);
    let is_own = |family: &usize| {
        let other = &geometry.families[*family].0;
        other
            .split_once('.')
            .map_or(other.as_str(), |(vector, _)| vector)
            == name
    };
    let families: Vec<usize> = (0..geometry.families.len()).filter(is_own).collect();
    let mut sum = vec![0.0; geometry.length()];
    let mut transform = Transform::of(geometry);
    for (_, state) in states {
        for family in &families {
            for (sum, power) in sum
                .iter_mut()
                .zip(transform.power(&state[sites.coordinates(*family)]))
            {
                *sum += power;
            }
        }
    }
    let over = (geometry.length() * states.len()) as f64;
    sum.iter_mut().for_each(|value| *value /= over);
    let mut lengths = geometry.lengths();
    if let [_, _, depth] = lengths[..] {
        sum = sum.into_iter().step_by(depth).collect();
        lengths.truncate(2);
    }
    Some(StructureFactor {
        name: name.to_owned(),
        lengths,
        values: sum,
        states: [states.len() as u64, recorded],
    })
}

/// Fourier transforms over all axes of a lattice.
struct Transform {
    planner: FftPlanner<f64>,
    lengths: Vec<usize>,
    values: Vec<Complex64>,
    row: Vec<Complex64>,
}

impl Transform {
    fn of(geometry: &LatticeGeometry) -> Self {
        Self {
            planner: FftPlanner::new(),
            lengths: geometry.lengths(),
            values: Vec::new(),
            row: Vec::new(),
        }
    }

    /// |Σ_r s(r) exp(−i q·r)|² at every q, in the order of the sites.
    fn power(&mut self, field: &[f64]) -> impl Iterator<Item = f64> + '_ {
        self.values.clear();
        self.values
            .extend(field.iter().map(|value| Complex64::new(*value, 0.0)));
        let mut stride = 1;
        for length in self.lengths.iter().rev() {
            let fft = self.planner.plan_fft_forward(*length);
            for block in self.values.chunks_exact_mut(stride * length) {
                for at in 0..stride {
                    self.row.clear();
                    self.row.extend(block[at..].iter().step_by(stride));
                    fft.process(&mut self.row);
                    let places = block[at..].iter_mut().step_by(stride);
                    places
                        .zip(&self.row)
                        .for_each(|(place, value)| *place = *value);
                }
            }
            stride *= length;
        }
        self.values.iter().map(Complex64::norm_sqr)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use leafwise_core::lattice::Axis;

    use super::*;

    fn sites(names: &[&str], lengths: &[usize]) -> Sites {
        let axes = lengths.iter().map(|length| Axis {
            length: *length,
            periodic: true,
        });
        Sites {
            geometry: LatticeGeometry::along(
                names.iter().map(|name| (*name).to_owned()),
                axes.collect(),
            ),
            first: 0,
            has_neighbours: true,
            plane: None,
            spins: None,
        }
    }

    /// Numbers without a pattern.
    fn noise(count: usize, seed: u64) -> Vec<f64> {
        let number = |k: u64| {
            let mixed = (seed + k).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            (mixed >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
        };
        (0..count as u64).map(number).collect()
    }

    /// The definition, term by term, at wave numbers 2π m/L.
    fn direct(lengths: &[usize], field: &[f64], m: [usize; 3]) -> f64 {
        let [a, b, c] = [0, 1, 2].map(|axis| lengths.get(axis).copied().unwrap_or(1));
        let (mut real, mut imaginary) = (0.0, 0.0);
        for i in 0..a {
            for j in 0..b {
                for k in 0..c {
                    let turns = (m[0] * i) as f64 / a as f64
                        + (m[1] * j) as f64 / b as f64
                        + (m[2] * k) as f64 / c as f64;
                    let (sine, cosine) = libm::sincos(2.0 * PI * turns);
                    let value = field[(i * b + j) * c + k];
                    real += value * cosine;
                    imaginary -= value * sine;
                }
            }
        }
        (real * real + imaginary * imaginary) / (a * b * c) as f64
    }

    /// Chains, planes and boxes have the sum of the definition, of all components and in the mean over states.
    #[test]
    fn a_structure_factor_is_its_definition() {
        for lengths in [&[12][..], &[7], &[4, 6], &[5, 8], &[4, 5, 6]] {
            let sites = sites(&["s.x", "s.y", "m"], lengths);
            let count = sites.geometry.length();
            let states: Vec<(f64, Vec<f64>)> =
                (0..3).map(|k| (0.0, noise(3 * count, 1000 * k))).collect();
            let factor = structure(&sites, &states, 9).expect("a lattice");
            assert_eq!((factor.name.as_str(), factor.states), ("s", [3, 9]));
            let rest: usize = lengths.iter().skip(1).take(1).product();
            for (at, value) in factor.values.iter().enumerate() {
                let m = match lengths.len() {
                    1 => [at, 0, 0],
                    _ => [at / rest, at % rest, 0],
                };
                let own = states.iter().map(|(_, state)| {
                    let component =
                        |c: usize| direct(lengths, &state[c * count..(c + 1) * count], m);
                    component(0) + component(1)
                });
                let expected = own.sum::<f64>() / 3.0;
                // Sums of at most 120 terms of at most a half: their round-off, squared over N terms.
                let tolerance = 120.0 * 120.0 * f64::EPSILON;
                assert!(
                    (value - expected).abs() < tolerance,
                    "{m:?}: {value} {expected}"
                );
            }
        }
    }

    /// Open ends, few sites, and families whose sites are not next to each other have none.
    #[test]
    fn what_is_no_periodic_lattice_has_none() {
        let states = vec![(0.0, noise(64, 1))];
        let periodic = sites(&["q"], &[8, 8]);
        assert!(structure(&periodic, &states, 1).is_some());
        assert!(structure(&periodic, &[], 1).is_none());
        let mut open = periodic.clone();
        open.geometry.axes[1].periodic = false;
        let mut apart = periodic.clone();
        apart.has_neighbours = false;
        for sites in [open, apart, sites(&["q"], &[32, 2])] {
            assert!(structure(&sites, &states, 1).is_none());
        }
    }
}

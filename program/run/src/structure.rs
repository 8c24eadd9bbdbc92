//! Structure factors of recorded states, for pictures alone: the sines of this transform are the platform's.

use leafwise_core::lattice::LatticeGeometry;
use leafwise_expression::words::counted;
use leafwise_report::StructureFactor;
use leafwise_scene::compose::{SiteField, Sites};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;

use super::planes::{LETTERS, shown_fields};

/// The fewest sites along an axis that is worth a picture.
const SHORTEST: usize = 4;

/// [`StructureFactor`] of each field that is shown, of a vector the sum of those of its components. The run has recorded
/// `recorded` samples.
///
/// It is over the first two axes that are periodic and have no few sites; along the others q is 0. There is none where
/// there is no such axis, sites are no lattice, or there are no states.
pub(super) fn structure(
    sites: &Sites,
    states: &[(f64, Vec<f64>)],
    recorded: u64,
) -> Vec<StructureFactor> {
    let geometry = &sites.geometry;
    let (own, notes) = axes(geometry);
    if !sites.has_neighbours || own.is_empty() || states.is_empty() {
        return Vec::new();
    }
    let mut transform = Transform::of(geometry);
    let over = (geometry.length() * states.len()) as f64;
    let factor = |field: SiteField| {
        let mut sum = vec![0.0; geometry.length()];
        for (_, state) in states {
            for family in &field.families {
                let power = transform.power(&state[sites.coordinates(*family)]);
                sum.iter_mut()
                    .zip(power)
                    .for_each(|(sum, power)| *sum += power);
            }
        }
        // Sites are numbered along the last axis first, and so are those of the axes that are left.
        let is_own = |site: &usize| {
            let mut place = geometry.place(*site).into_iter().enumerate();
            place.all(|(axis, at)| at == 0 || own.contains(&axis))
        };
        let kept = (0..geometry.length()).filter(is_own);
        StructureFactor {
            name: field.name,
            axes: match geometry.axes.len() {
                1 => Vec::new(),
                _ => own.iter().map(|axis| LETTERS[*axis].to_owned()).collect(),
            },
            lengths: own.iter().map(|axis| geometry.axes[*axis].length).collect(),
            values: kept.map(|site| sum[site] / over).collect(),
            states: [states.len() as u64, recorded],
            notes: notes.clone(),
        }
    };
    shown_fields(sites).into_iter().map(factor).collect()
}

/// The axes that a picture shows, two at most, and in words why q is 0 along the others.
fn axes(geometry: &LatticeGeometry) -> (Vec<usize>, Vec<String>) {
    let (mut own, mut notes) = (Vec::new(), Vec::new());
    for (at, axis) in geometry.axes.iter().enumerate() {
        let zero = format!("q = 0 along {}", LETTERS[at]);
        match (axis.periodic, axis.length >= SHORTEST) {
            (false, _) => notes.push(format!("{zero}, which has ends.")),
            (_, false) => notes.push(format!("{zero}: of {} only.", counted(axis.length, "site"))),
            _ if own.len() == 2 => notes.push(format!("{zero}.")),
            _ => own.push(at),
        }
    }
    (own, notes)
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
            spins: Vec::new(),
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
            let factors = structure(&sites, &states, 9);
            let names: Vec<&str> = factors.iter().map(|factor| factor.name.as_str()).collect();
            assert_eq!(names, ["s", "m"]);
            let factor = &factors[0];
            assert_eq!(factor.states, [3, 9]);
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

    /// Along axes with ends or few sites q is 0: the sum over the sites there is a field on the others.
    #[test]
    fn axes_with_ends_or_few_sites_are_left_out() {
        for (lengths, open, own, note) in [
            (
                &[8, 3][..],
                None,
                &[0][..],
                "q = 0 along j: of 3 sites only.",
            ),
            (&[2, 9], None, &[1], "q = 0 along i: of 2 sites only."),
            (&[8, 6], Some(1), &[0], "q = 0 along j, which has ends."),
            (&[5, 3, 6], None, &[0, 2], "q = 0 along j: of 3 sites only."),
            (&[4, 5, 6], None, &[0, 1], "q = 0 along k."),
        ] {
            let mut sites = sites(&["q"], lengths);
            if let Some(axis) = open {
                sites.geometry.axes[axis].periodic = false;
            }
            let count = sites.geometry.length();
            let state = noise(count, 5);
            let factor = structure(&sites, &[(0.0, state.clone())], 1).remove(0);
            assert_eq!(factor.notes, [note]);
            let letters: Vec<&str> = own.iter().map(|axis| LETTERS[*axis]).collect();
            assert_eq!(factor.axes, letters);
            let of: Vec<usize> = own.iter().map(|axis| lengths[*axis]).collect();
            assert_eq!(factor.lengths, of);
            let last = of.get(1).copied().unwrap_or(1);
            for (at, value) in factor.values.iter().enumerate() {
                let mut m = [0; 3];
                m[own[0]] = at / last;
                if let Some(second) = own.get(1) {
                    m[*second] = at % last;
                }
                let expected = direct(lengths, &state, m);
                // A sum of at most 120 terms of at most a half: its round-off, squared over N terms.
                let tolerance = 120.0 * 120.0 * f64::EPSILON;
                assert!(
                    (value - expected).abs() < tolerance,
                    "{lengths:?} {m:?}: {value} {expected}"
                );
            }
        }
    }

    /// Chains with ends, few sites along all axes, and families whose sites are not next to each other have none.
    #[test]
    fn what_is_no_periodic_lattice_has_none() {
        let states = vec![(0.0, noise(64, 1))];
        let periodic = sites(&["q"], &[8, 8]);
        assert_eq!(structure(&periodic, &states, 1).len(), 1);
        assert!(structure(&periodic, &[], 1).is_empty());
        let mut open = sites(&["q"], &[64]);
        open.geometry.axes[0].periodic = false;
        let mut apart = periodic.clone();
        apart.has_neighbours = false;
        for sites in [open, apart, sites(&["q"], &[3, 3])] {
            assert!(structure(&sites, &states, 1).is_empty());
        }
    }
}

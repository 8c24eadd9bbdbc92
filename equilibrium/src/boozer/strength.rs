//! The field strength between surfaces and nodes.

use std::f64::consts::PI;

use super::data::BoozerData;
use super::surfaces::Surfaces;

/// |B| by harmonics of θ and ζ on each surface. An odd harmonic of θ is √s times a smooth function of s.
#[derive(Clone, Debug)]
pub(super) struct Strength {
    periods: f64,
    nodes: [usize; 2],
    /// [surface][harmonic of θ][harmonic of ζ], those of odd θ divided by √s.
    harmonics: Vec<f64>,
}

impl Strength {
    pub(super) fn new(data: &BoozerData, surfaces: &Surfaces) -> Self {
        let [along_theta, along_zeta] = data.nodes;
        let each = along_theta * along_zeta;
        let mut harmonics = Vec::with_capacity(data.strength.len());
        for (s, numbers) in surfaces.s().iter().zip(data.strength.chunks(each)) {
            let rows: Vec<f64> = numbers.chunks(along_zeta).flat_map(analysed).collect();
            let mut own = vec![0.0; each];
            for l in 0..along_zeta {
                let column: Vec<f64> = (0..along_theta).map(|j| rows[j * along_zeta + l]).collect();
                for (a, harmonic) in analysed(&column).into_iter().enumerate() {
                    let harmonic = match (order(a) % 2, *s > 0.0) {
                        (0, _) => harmonic,
                        (_, true) => harmonic / libm::sqrt(*s),
                        (_, false) => 0.0,
                    };
                    own[a * along_zeta + l] = harmonic;
                }
            }
            harmonics.extend(own);
        }
        Self {
            periods: data.periods.into(),
            nodes: data.nodes,
            harmonics,
        }
    }

    /// |B| at one place.
    pub(super) fn at(&self, surfaces: &Surfaces, s: f64, theta: f64, zeta: f64) -> f64 {
        let [_, along_zeta] = self.nodes;
        let along = self.along_zeta(surfaces, s, theta);
        let basis = basis(along_zeta, self.periods * zeta);
        along
            .iter()
            .zip(basis)
            .map(|(own, value)| own * value)
            .sum()
    }

    /// |B| at so many nodes of a field period.
    pub(super) fn line(&self, surfaces: &Surfaces, s: f64, theta: f64, count: usize) -> Vec<f64> {
        let [_, along_zeta] = self.nodes;
        let along = self.along_zeta(surfaces, s, theta);
        let at = |l: usize| {
            let basis = basis(along_zeta, 2.0 * PI * l as f64 / count as f64);
            along
                .iter()
                .zip(basis)
                .map(|(own, value)| own * value)
                .sum()
        };
        (0..count).map(at).collect()
    }

    /// The harmonics of ζ at one s and θ.
    fn along_zeta(&self, surfaces: &Surfaces, s: f64, theta: f64) -> Vec<f64> {
        let [along_theta, along_zeta] = self.nodes;
        let each = along_theta * along_zeta;
        let (even, odd) = (surfaces.parts(false, s), surfaces.parts(true, s));
        let basis = basis(along_theta, theta);
        let root = libm::sqrt(s);
        let mut along = vec![0.0; along_zeta];
        let parts = even.each().iter().zip(odd.each());
        for (numbers, (even, odd)) in self.harmonics.chunks(each).zip(parts) {
            for (a, (row, value)) in numbers.chunks(along_zeta).zip(&basis).enumerate() {
                let factor = value
                    * match order(a) % 2 {
                        0 => *even,
                        _ => odd * root,
                    };
                for (sum, harmonic) in along.iter_mut().zip(row) {
                    *sum += factor * harmonic;
                }
            }
        }
        along
    }
}

/// The order m of the function number a: 1, cos x, sin x, cos 2x, ….
fn order(a: usize) -> usize {
    a.div_ceil(2)
}

/// 1, cos x, sin x, …, as many functions as there are nodes.
fn basis(count: usize, x: f64) -> Vec<f64> {
    let function = |a: usize| {
        let angle = order(a) as f64 * x;
        match a {
            0 => 1.0,
            _ if a % 2 == 1 => libm::cos(angle),
            _ => libm::sin(angle),
        }
    };
    (0..count).map(function).collect()
}

/// The coefficients of the functions that take these numbers at nodes x = 2πj/n.
fn analysed(numbers: &[f64]) -> Vec<f64> {
    let count = numbers.len();
    let mut sums = vec![0.0; count];
    for (j, number) in numbers.iter().enumerate() {
        let values = basis(count, 2.0 * PI * j as f64 / count as f64);
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += number * value;
        }
    }
    for (a, sum) in sums.iter_mut().enumerate() {
        // The last cosine of an even number of nodes is ±1 at each.
        let is_alone = a == 0 || 2 * order(a) == count;
        *sum *= if is_alone { 1.0 } else { 2.0 } / count as f64;
    }
    sums
}

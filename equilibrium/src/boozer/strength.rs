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
                    let harmonic = match (order(a), *s > 0.0) {
                        (0, _) => harmonic,
                        // |B| on the axis has one value at each ζ.
                        (_, false) => 0.0,
                        (order, true) if order % 2 == 1 => harmonic / libm::sqrt(*s),
                        (_, true) => harmonic,
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
        let own = self.on_surface(surfaces, s);
        let [_, along_zeta] = self.nodes;
        sum(
            &self.along_zeta(&own, theta),
            &basis(along_zeta, self.periods * zeta),
        )
    }

    /// |B| at so many nodes of a field period.
    pub(super) fn line(&self, surfaces: &Surfaces, s: f64, theta: f64, count: usize) -> Vec<f64> {
        let along = self.along_zeta(&self.on_surface(surfaces, s), theta);
        let bases = self.bases(count);
        bases.iter().map(|basis| sum(&along, basis)).collect()
    }

    /// The least and the largest |B| at one s, of twice the nodes.
    pub(super) fn range(&self, surfaces: &Surfaces, s: f64) -> [f64; 2] {
        let own = self.on_surface(surfaces, s);
        let [along_theta, along_zeta] = self.nodes.map(|nodes| 2 * nodes);
        let bases = self.bases(along_zeta);
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for j in 0..along_theta {
            let along = self.along_zeta(&own, 2.0 * PI * j as f64 / along_theta as f64);
            for basis in &bases {
                let strength = sum(&along, basis);
                range = [range[0].min(strength), range[1].max(strength)];
            }
        }
        range
    }

    /// The functions of ζ at so many nodes of a field period.
    fn bases(&self, count: usize) -> Vec<Vec<f64>> {
        let at = |l: usize| basis(self.nodes[1], 2.0 * PI * l as f64 / count as f64);
        (0..count).map(at).collect()
    }

    /// The harmonics at one s.
    fn on_surface(&self, surfaces: &Surfaces, s: f64) -> Vec<f64> {
        let [along_theta, along_zeta] = self.nodes;
        let each = along_theta * along_zeta;
        let (even, odd) = (surfaces.parts(false, s), surfaces.parts(true, s));
        let root = libm::sqrt(s);
        let mut own = vec![0.0; each];
        let parts = even.each().iter().zip(odd.each());
        for (numbers, (even, odd)) in self.harmonics.chunks(each).zip(parts) {
            let rows = own
                .chunks_mut(along_zeta)
                .zip(numbers.chunks(along_zeta))
                .enumerate();
            for (a, (sums, row)) in rows {
                let factor = if order(a).is_multiple_of(2) {
                    *even
                } else {
                    odd * root
                };
                for (sum, harmonic) in sums.iter_mut().zip(row) {
                    *sum += factor * harmonic;
                }
            }
        }
        own
    }

    /// The harmonics of ζ at one θ, of those at one s.
    fn along_zeta(&self, own: &[f64], theta: f64) -> Vec<f64> {
        let [along_theta, along_zeta] = self.nodes;
        let mut along = vec![0.0; along_zeta];
        for (row, value) in own.chunks(along_zeta).zip(basis(along_theta, theta)) {
            for (sum, harmonic) in along.iter_mut().zip(row) {
                *sum += value * harmonic;
            }
        }
        along
    }
}

fn sum(harmonics: &[f64], basis: &[f64]) -> f64 {
    let terms = harmonics.iter().zip(basis);
    terms.map(|(own, value)| own * value).sum()
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

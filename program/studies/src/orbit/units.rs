//! Units of coordinates and time in which a linearized motion and its tensor have entries next to 1.
//!
//! With powers of two s_i, τ and a the logarithms of |Π_ij| a/(s_i s_j) and of |Df_ij| τ s_j/s_i have the least sum of squares. Cf.
//! A. Curtis, J. Reid, J. Inst. Maths Applics 10 (1972). In other units of a scene these are others by as much: matrices over them
//! stay. Where these leave units open, as of a motion that is nilpotent, coordinates over them are as large as each other.

use super::linear::{Columns, SingularValues};

/// Entries below this part of the largest one, in units, are round-off: they do not count.
const COUNTS: f64 = 1e-12;

/// Times that units are found without those that do not count, at most.
const TIMES: usize = 4;

/// Singular values of the equations of the logarithms that are no zeros, over the largest.
const PART: f64 = 1e-9;

/// The weight of the sizes of coordinates beside the entries.
const OF_SIZES: f64 = 1e-3;

/// The largest logarithm of a unit.
const LARGEST: f64 = 300.0;

/// Units: powers of two.
#[derive(Clone, Debug)]
pub(super) struct Units {
    /// s_i.
    pub coordinates: Vec<f64>,
    /// τ.
    pub time: f64,
    /// a.
    pub action: f64,
}

/// An entry that is to be next to 1: its sum of logarithms over places.
struct Logarithm {
    size: f64,
    /// Signs of the logarithms, at places of s_0 … s_{d−1}, τ, a, and of what all coordinates are over their units.
    places: [(usize, f64); 3],
    weight: f64,
}

impl Logarithm {
    fn logarithm(&self, units: &[f64]) -> f64 {
        let places = self.places.iter();
        libm::log2(self.size) + places.map(|(at, sign)| sign * units[*at]).sum::<f64>()
    }
}

impl Units {
    /// Of columns of a tensor and of the derivatives of its motion, and of sizes of the coordinates.
    pub fn of(tensor: &Columns, motion: &Columns, sizes: &[f64]) -> Self {
        let d = sizes.len();
        let mut all = Vec::new();
        for j in 0..d {
            for i in 0..d {
                let of_time = [(i, -1.0), (j, 1.0), (d, 1.0)];
                let of_action = [(i, -1.0), (j, -1.0), (d + 1, 1.0)];
                for (size, places) in [(motion[j][i], of_time), (tensor[j][i], of_action)] {
                    let size = size.abs();
                    if size > 0.0 && size.is_finite() {
                        let weight = 1.0;
                        all.push(Logarithm {
                            size,
                            places,
                            weight,
                        });
                    }
                }
            }
        }
        let of_sizes = sizes.iter().enumerate().filter(|(_, size)| **size > 0.0);
        all.extend(of_sizes.map(|(i, size)| Logarithm {
            size: *size,
            places: [(i, -1.0), (d + 2, 1.0), (d, 0.0)],
            weight: OF_SIZES,
        }));
        let mut found = vec![0.0; d + 3];
        for _ in 0..TIMES {
            found = least_squares(&all, d + 3);
            let entries = all.iter().filter(|entry| entry.weight == 1.0);
            let largest = entries.map(|entry| entry.logarithm(&found));
            let least = largest.fold(f64::NEG_INFINITY, f64::max) + libm::log2(COUNTS);
            let before = all.len();
            all.retain(|entry| entry.weight < 1.0 || entry.logarithm(&found) > least);
            if all.len() == before {
                break;
            }
        }
        let unit = |at: usize| libm::exp2(libm::round(found[at].clamp(-LARGEST, LARGEST)));
        Self {
            coordinates: (0..d).map(unit).collect(),
            time: unit(d),
            action: unit(d + 1),
        }
    }

    /// A state in these units.
    pub fn inside(&self, state: &[f64]) -> Vec<f64> {
        let pairs = state.iter().zip(&self.coordinates);
        pairs.map(|(x, unit)| x / unit).collect()
    }

    /// A state in these units as the scene has it.
    pub fn outside(&self, x: &[f64]) -> Vec<f64> {
        let pairs = x.iter().zip(&self.coordinates);
        pairs.map(|(x, unit)| x * unit).collect()
    }

    /// A velocity.
    pub fn velocity(&self, f: &[f64]) -> Vec<f64> {
        self.inside(f).iter().map(|f| f * self.time).collect()
    }

    /// A gradient.
    pub fn gradient(&self, g: &[f64]) -> Vec<f64> {
        self.outside(g)
    }

    /// Columns of derivatives of the motion.
    pub fn motion(&self, columns: &Columns) -> Columns {
        let pairs = columns.iter().zip(&self.coordinates);
        pairs
            .map(|(column, unit)| self.velocity(column).iter().map(|f| f * unit).collect())
            .collect()
    }

    /// Columns of a tensor.
    pub fn tensor(&self, columns: &Columns) -> Columns {
        let pairs = columns.iter().zip(&self.coordinates);
        pairs
            .map(|(column, unit)| {
                let own = self.inside(column);
                own.iter().map(|p| p * self.action / unit).collect()
            })
            .collect()
    }
}

/// The logarithms that make the sum of the squares of the entries' least; of these the smallest.
fn least_squares(entries: &[Logarithm], count: usize) -> Vec<f64> {
    let mut normal: Columns = vec![vec![0.0; count]; count];
    let mut right = vec![0.0; count];
    for entry in entries {
        let logarithm = libm::log2(entry.size);
        let square = entry.weight * entry.weight;
        for (at, sign) in entry.places {
            right[at] -= square * sign * logarithm;
            for (other, factor) in entry.places {
                normal[other][at] += square * sign * factor;
            }
        }
    }
    SingularValues::of(&normal).solve(&right, PART)
}

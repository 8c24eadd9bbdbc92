//! A field in Boozer coordinates, and starts of particles in it.

use std::f64::consts::PI;

use leafwise_core::random::Random;

use super::data::{BoozerData, check};
use super::strength::Strength;
use super::surfaces::Surfaces;
use crate::error::EquilibriumError;
use crate::ions::{Ions, Start};

/// A field in Boozer coordinates.
#[derive(Clone, Debug)]
pub struct Boozer {
    data: BoozerData,
    surfaces: Surfaces,
    strength: Strength,
    repeated: [bool; 2],
    departures: Vec<Departure>,
}

/// A place where a table leaves the range of the numbers on the surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Departure {
    /// `|B|`, `iota` or `G`.
    pub name: &'static str,
    /// The surface.
    pub s: f64,
    /// Its number there.
    pub value: f64,
    /// The least and the largest of the numbers on the surfaces.
    pub range: [f64; 2],
    /// Where s lies among the surfaces, in words.
    pub place: String,
}

/// The part of the range of numbers by which their table may leave it, and the part of their size that nobody sees.
///
/// A harmonic that is linear in s leaves it by 0.2 at the end of the tables, s = 1.2, where the last surface is the edge.
const BEYOND: f64 = 0.5;
const SEEN: f64 = 1e-6;

/// The part of the smallest |B| between nodes below which draws of starts take it to be.
const BELOW: f64 = 0.95;

/// Draws of one member until one is taken, far beyond any that is needed.
const DRAWS: usize = 10_000;

/// The stream of numbers of starts.
const STREAM: u32 = 0;

impl Boozer {
    /// The field of these numbers.
    ///
    /// # Errors
    /// [`EquilibriumError::Odd`] for numbers that are no field.
    pub fn new(data: BoozerData) -> Result<Self, EquilibriumError> {
        let (data, repeated) = data.without_repeats();
        check(&data, repeated).map_err(EquilibriumError::Odd)?;
        let surfaces = Surfaces::new(&data.s);
        let strength = Strength::new(&data, &surfaces);
        let mut field = Self {
            data,
            surfaces,
            strength,
            repeated,
            departures: Vec::new(),
        };
        field.departures = field.departed()?;
        Ok(field)
    }

    /// Whether the numbers had a last node of θ, and of ζ, that repeats the first one and was left out.
    pub fn repeated(&self) -> [bool; 2] {
        self.repeated
    }

    /// Where the tables of |B|, ι and G leave the range of the numbers by most, of each that leaves it by more than half.
    pub fn departures(&self) -> &[Departure] {
        &self.departures
    }

    /// Those departures, from the axis to the end of the tables.
    ///
    /// # Errors
    /// [`EquilibriumError::Odd`] where |B| is not above 0, or G + ιI changes its sign.
    fn departed(&self) -> Result<Vec<Departure>, EquilibriumError> {
        let mut found: [Option<Departure>; 3] = [None, None, None];
        let own = [
            ("|B|", self.range()),
            ("iota", range_of(&self.data.iota)),
            ("G", range_of(&self.data.g)),
        ];
        let along = |s: f64| self.g(s) + self.iota(s) * self.i_over_s(s) * s;
        let outer = along(self.data.s[self.data.s.len() - 1]);
        for s in self.surfaces.places() {
            let strength = self.strength.range(&self.surfaces, s);
            let place = || self.surfaces.place(s);
            if strength[0].is_nan() || strength[0] <= 0.0 {
                return Err(EquilibriumError::Odd(format!(
                    "the table of |B| would have {:.3e} T at s = {s:.3}, {}: give surfaces there",
                    strength[0],
                    place()
                )));
            }
            if (along(s) * outer).is_nan() || along(s) * outer <= 0.0 {
                return Err(EquilibriumError::Odd(format!(
                    "G + iota I would change its sign before s = {s:.3}, {}: give surfaces there",
                    place()
                )));
            }
            let numbers = [strength, [self.iota(s); 2], [self.g(s); 2]];
            for ((worst, (name, range)), [least, most]) in found.iter_mut().zip(own).zip(numbers) {
                let margin = beyond(range, range[0].abs().max(range[1].abs()));
                for value in [least, most] {
                    let off = (range[0] - value).max(value - range[1]);
                    let so_far = worst.as_ref().map_or(margin, |worst| {
                        (worst.range[0] - worst.value).max(worst.value - worst.range[1])
                    });
                    if off > so_far {
                        *worst = Some(Departure {
                            name,
                            s,
                            value,
                            range,
                            place: place(),
                        });
                    }
                }
            }
        }
        Ok(found.into_iter().flatten().collect())
    }

    /// The numbers.
    pub fn data(&self) -> &BoozerData {
        &self.data
    }

    /// |B| at s, θ and ζ, in T.
    pub fn strength(&self, s: f64, theta: f64, zeta: f64) -> f64 {
        self.strength.at(&self.surfaces, s, theta, zeta)
    }

    /// |B| at s and θ, at so many nodes of a field period of ζ.
    pub(super) fn strength_along_zeta(&self, s: f64, theta: f64, count: usize) -> Vec<f64> {
        self.strength.line(&self.surfaces, s, theta, count)
    }

    /// ι at s.
    pub fn iota(&self, s: f64) -> f64 {
        self.surfaces.between(&self.data.iota, s)
    }

    /// G at s, in T·m.
    pub fn g(&self, s: f64) -> f64 {
        self.surfaces.between(&self.data.g, s)
    }

    /// I/s at s, in T·m: I vanishes on the axis.
    pub fn i_over_s(&self, s: f64) -> f64 {
        match self.data.i.is_empty() {
            true => 0.0,
            false => self.surfaces.between_over(&self.data.i, 1.0, s),
        }
    }

    /// Whether |B| is the same at every ζ, up to the round-off of a sum of so many harmonics as there are nodes.
    pub fn is_axisymmetric(&self) -> bool {
        let [along_theta, along_zeta] = self.data.nodes;
        let tolerance = (along_theta * along_zeta) as f64 * f64::EPSILON;
        let mut rows = self.data.strength.chunks(along_zeta);
        rows.all(|row| {
            let mut off = row.iter().map(|b| (b - row[0]).abs());
            off.all(|off| off <= tolerance * row[0])
        })
    }

    /// The least and the largest |B| of the numbers, in T.
    pub fn range(&self) -> [f64; 2] {
        range_of(&self.data.strength)
    }

    /// The single particle: at θ = 0 and ζ = 0 of the surface. States are x, y, ζ and ρ.
    ///
    /// # Errors
    /// [`EquilibriumError`] for an energy, a pitch or a surface out of range.
    pub fn start(&self, ions: &Ions) -> Result<Start, EquilibriumError> {
        let (speed, s) = (ions.checked_speed()?, ions.checked_surface()?);
        Ok(self.start_at([s, 0.0, 0.0], speed, ions.pitch))
    }

    /// The particles of the ensemble: uniform in the volume of a thin shell about the surface and in u/v.
    ///
    /// The volume of dθ dζ is in proportion to 1/B².
    ///
    /// # Errors
    /// [`EquilibriumError`] for an energy or a surface out of range.
    pub fn starts(&self, ions: &Ions) -> Result<Vec<Start>, EquilibriumError> {
        let (speed, s) = (ions.checked_speed()?, ions.checked_surface()?);
        let period = 2.0 * PI / f64::from(self.data.periods);
        let [along_theta, along_zeta] = self.data.nodes.map(|nodes| 2 * nodes);
        let mut least = f64::INFINITY;
        for j in 0..along_theta {
            for l in 0..along_zeta {
                let theta = 2.0 * PI * j as f64 / along_theta as f64;
                let zeta = period * l as f64 / along_zeta as f64;
                least = least.min(self.strength(s, theta, zeta));
            }
        }
        let least = BELOW * least;
        let drawn = (0..ions.members).map(|member| {
            let mut random = Random::new(ions.seed, u64::from(member), STREAM);
            let mut place = [s, 0.0, 0.0];
            for _ in 0..DRAWS {
                place = [s, 2.0 * PI * random.uniform(), period * random.uniform()];
                let part = least / self.strength(place[0], place[1], place[2]);
                if random.uniform() <= part * part {
                    break;
                }
            }
            self.start_at(place, speed, 2.0 * random.uniform() - 1.0)
        });
        Ok(drawn.collect())
    }

    fn start_at(&self, [s, theta, zeta]: [f64; 3], speed: f64, pitch: f64) -> Start {
        let strength = self.strength(s, theta, zeta);
        let radius = libm::sqrt(s);
        Start {
            state: [
                radius * libm::cos(theta),
                radius * libm::sin(theta),
                zeta,
                speed * pitch / strength,
            ],
            moment: speed * speed * (1.0 - pitch * pitch) / (2.0 * strength),
        }
    }
}

fn range_of(numbers: &[f64]) -> [f64; 2] {
    let all = || numbers.iter().copied();
    [
        all().fold(f64::INFINITY, f64::min),
        all().fold(f64::NEG_INFINITY, f64::max),
    ]
}

/// By how much a table may leave a range of numbers of this size.
fn beyond([least, most]: [f64; 2], size: f64) -> f64 {
    (BEYOND * (most - least)).max(SEEN * size)
}

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
}

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
        check(&data).map_err(EquilibriumError::Odd)?;
        let surfaces = Surfaces::new(&data.s);
        let strength = Strength::new(&data, &surfaces);
        Ok(Self {
            data,
            surfaces,
            strength,
        })
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

    /// Whether |B| is the same at every ζ.
    pub fn is_axisymmetric(&self) -> bool {
        let [_, along_zeta] = self.data.nodes;
        let mut rows = self.data.strength.chunks(along_zeta);
        rows.all(|row| row.iter().all(|b| *b == row[0]))
    }

    /// The least and the largest |B| of the numbers, in T.
    pub fn range(&self) -> [f64; 2] {
        let all = || self.data.strength.iter().copied();
        [
            all().fold(f64::INFINITY, f64::min),
            all().fold(0.0, f64::max),
        ]
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

//! Particles of a kind and an energy on a surface.

use std::f64::consts::PI;

use leafwise_core::random::Random;

use crate::equilibrium::Equilibrium;
use crate::error::EquilibriumError;
use crate::surface::Surface;

/// A kind of charged particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Species {
    /// H⁺.
    Proton,
    /// ²H⁺.
    Deuteron,
    /// ³H⁺.
    Triton,
    /// ⁴He²⁺.
    Alpha,
    /// e⁻.
    Electron,
}

/// The elementary charge, in C.
const CHARGE: f64 = 1.602_176_634e-19;

/// The stream of numbers of starts.
const STREAM: u32 = 0;

/// The speed of light, in m/s.
const LIGHT: f64 = 299_792_458.0;

impl Species {
    /// All kinds.
    pub const ALL: [Self; 5] = [
        Self::Proton,
        Self::Deuteron,
        Self::Triton,
        Self::Alpha,
        Self::Electron,
    ];

    /// The English word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Proton => "proton",
            Self::Deuteron => "deuteron",
            Self::Triton => "triton",
            Self::Alpha => "alpha",
            Self::Electron => "electron",
        }
    }

    /// The mass in kg (CODATA 2022).
    pub fn mass(self) -> f64 {
        match self {
            Self::Proton => 1.672_621_925_95e-27,
            Self::Deuteron => 3.343_583_776_8e-27,
            Self::Triton => 5.007_356_751_2e-27,
            Self::Alpha => 6.644_657_345_0e-27,
            Self::Electron => 9.109_383_713_9e-31,
        }
    }

    /// The charge in C.
    pub fn charge(self) -> f64 {
        match self {
            Self::Proton | Self::Deuteron | Self::Triton => CHARGE,
            Self::Alpha => 2.0 * CHARGE,
            Self::Electron => -CHARGE,
        }
    }

    /// The speed at a kinetic energy in keV, in m/s.
    ///
    /// # Errors
    /// [`EquilibriumError::Odd`] for an energy below 0, and speeds above a tenth of light's: the guiding centre of this crate is
    /// not relativistic.
    pub fn speed(self, energy: f64) -> Result<f64, EquilibriumError> {
        let speed = libm::sqrt(2.0 * energy * 1e3 * CHARGE / self.mass());
        if energy > 0.0 && speed <= 0.1 * LIGHT {
            return Ok(speed);
        }
        let name = self.name();
        Err(EquilibriumError::Odd(match energy > 0.0 {
            true => format!(
                "at {energy} keV a particle of the kind {name} moves at the speed of light times {:.2}, and the equations are not relativistic: take an energy below {:.3} keV",
                speed / LIGHT,
                0.005 * self.mass() * LIGHT * LIGHT / (1e3 * CHARGE)
            ),
            false => format!("the energy is {energy} keV: give one above 0"),
        }))
    }
}

/// The state of a guiding centre, with its magnetic moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// R, Z and φ, in m and rad, and u, the velocity along B, in m/s; in Boozer coordinates x, y, ζ and ρ = u/B.
    pub state: [f64; 4],
    /// μ = v_⊥²/(2B), in m²/(s²·T).
    pub moment: f64,
}

/// Particles of one kind and energy.
#[derive(Clone, Debug)]
pub struct Ions {
    /// The kind.
    pub species: Species,
    /// The kinetic energy in keV.
    pub energy: f64,
    /// u/v of the single particle.
    pub pitch: f64,
    /// The normalized flux of the surface where they start.
    pub surface: f64,
    /// The number of particles of an ensemble.
    pub members: u32,
    /// The seed of their draws.
    pub seed: u64,
}

impl Ions {
    /// The single particle: on the surface at the height of the axis, on its outer side, at φ = 0.
    ///
    /// # Errors
    /// [`EquilibriumError`] for an open surface, an energy or a pitch out of range.
    pub fn start(&self, equilibrium: &Equilibrium) -> Result<Start, EquilibriumError> {
        let speed = self.checked_speed()?;
        let point = self.surface_of(equilibrium)?.points[0];
        Ok(start(equilibrium, point, 0.0, speed, self.pitch))
    }

    /// The particles of the ensemble: uniform in the volume of a thin shell about the surface, in φ and in u/v.
    ///
    /// # Errors
    /// [`EquilibriumError`] for an open surface and an energy out of range.
    pub fn starts(&self, equilibrium: &Equilibrium) -> Result<Vec<Start>, EquilibriumError> {
        let speed = self.checked_speed()?;
        let surface = self.surface_of(equilibrium)?;
        let drawn = (0..self.members).map(|member| {
            let mut random = Random::new(self.seed, u64::from(member), STREAM);
            let point = surface.at_part(random.uniform());
            let turn = 2.0 * PI * random.uniform();
            let pitch = 2.0 * random.uniform() - 1.0;
            start(equilibrium, point, turn, speed, pitch)
        });
        Ok(drawn.collect())
    }

    fn surface_of(&self, equilibrium: &Equilibrium) -> Result<Surface, EquilibriumError> {
        Surface::of(equilibrium, self.checked_surface()?)
    }

    /// The speed in m/s, of a pitch that is one.
    pub(crate) fn checked_speed(&self) -> Result<f64, EquilibriumError> {
        if self.pitch.is_nan() || self.pitch.abs() > 1.0 {
            let message = format!("the pitch u/v is {}: it lies from -1 to 1", self.pitch);
            return Err(EquilibriumError::Odd(message));
        }
        self.species.speed(self.energy)
    }

    /// The surface, between axis and edge.
    pub(crate) fn checked_surface(&self) -> Result<f64, EquilibriumError> {
        if !(self.surface > 0.0 && self.surface < 1.0) {
            let message = format!(
                "the surface is s = {}: it lies between the axis, 0, and the edge, 1",
                self.surface
            );
            return Err(EquilibriumError::Odd(message));
        }
        Ok(self.surface)
    }
}

fn start(equilibrium: &Equilibrium, [r, z]: [f64; 2], turn: f64, speed: f64, pitch: f64) -> Start {
    let strength = equilibrium.strength([r, z]);
    Start {
        state: [r, z, turn, speed * pitch],
        moment: speed * speed * (1.0 - pitch * pitch) / (2.0 * strength),
    }
}

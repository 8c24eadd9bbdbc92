//! Fields in Boozer coordinates: surfaces of stellarators and tokamaks, their field strength, guiding centres in them.
//!
//! B = ∇ψ × ∇θ + ι ∇ζ × ∇ψ = G ∇ζ + I ∇θ, with the toroidal flux 2πψ (A. Boozer, Phys. Fluids 24, 1999, 1981). Its vector
//! potential is A = ψ ∇θ − χ ∇ζ with χ′ = ι. A guiding centre of charge q and mass m has ρ = u/B and H = ρ²B²/2 + μB. Its
//! one-form is
//!
//! ((q/m) ψ + ρ I) dθ + (ρ G − (q/m) χ) dζ.
//!
//! An angle θ has no value on the axis. The coordinates are x = √s cos θ and y = √s sin θ with s = ψ/ψ_edge. There
//! s dθ = x dy − y dx is regular. So is the field strength, whose harmonics cos mθ fall as s^(m/2).
//!
//! - Module `surfaces`: numbers between surfaces and beyond the last one.
//! - Module `field`: |B| anywhere, by harmonics of the angles on each surface.
//! - Module `scene`: the scene, and the files of its tables.

mod field;
mod scene;
mod surfaces;

use std::f64::consts::PI;

use crate::error::EquilibriumError;
use crate::ions::{Ions, Start};

use leafwise_core::random::Random;

pub use scene::written_in_boozer;

use field::Strength;
use surfaces::Surfaces;

/// Numbers of a field in Boozer coordinates, on K surfaces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoozerData {
    /// Field periods in a turn of ζ.
    pub periods: u32,
    /// ψ at s = 1, the toroidal flux over 2π, in Wb/rad.
    pub edge_flux: f64,
    /// s = ψ/ψ_edge of the surfaces, rising, from 0 to 1.
    pub s: Vec<f64>,
    /// ι on each surface.
    pub iota: Vec<f64>,
    /// G on each surface, in T·m.
    pub g: Vec<f64>,
    /// I on each surface, in T·m; empty where there is no toroidal current.
    pub i: Vec<f64>,
    /// Nodes of θ over a turn, and of ζ over a field period, the first at 0 and the last one before the period's end.
    pub nodes: [usize; 2],
    /// |B| in T, of surface after surface, and on each of θ after θ.
    pub strength: Vec<f64>,
}

/// A field in Boozer coordinates.
#[derive(Clone, Debug)]
pub struct Boozer {
    data: BoozerData,
    surfaces: Surfaces,
    strength: Strength,
}

/// The fewest surfaces, and nodes of an angle, that make a field.
const FEWEST: usize = 4;

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

fn check(data: &BoozerData) -> Result<(), String> {
    let surfaces = data.s.len();
    let [along_theta, along_zeta] = data.nodes;
    if data.periods == 0 {
        return Err("`periods` is 0: a torus has 1 field period at least".to_owned());
    }
    if surfaces < FEWEST {
        return Err(format!(
            "`s` has {surfaces} surfaces: {FEWEST} are needed at least"
        ));
    }
    for (name, numbers) in [("iota", &data.iota), ("G", &data.g), ("I", &data.i)] {
        if numbers.len() != surfaces && !(name == "I" && numbers.is_empty()) {
            return Err(format!(
                "`{name}` has {} numbers where `s` has {surfaces} surfaces",
                numbers.len()
            ));
        }
    }
    let count = surfaces
        .checked_mul(along_theta)
        .and_then(|count| count.checked_mul(along_zeta));
    if count != Some(data.strength.len()) {
        return Err(format!(
            "`B` has {} numbers where {surfaces} surfaces with {along_theta} × {along_zeta} nodes of theta and zeta have another \
             count",
            data.strength.len()
        ));
    }
    if along_theta < FEWEST || along_zeta == 0 || (2..FEWEST).contains(&along_zeta) {
        return Err(format!(
            "`B` has {along_theta} nodes of theta and {along_zeta} of zeta: {FEWEST} of each are needed at least, or 1 of zeta in \
             an axisymmetric field"
        ));
    }
    if let Some(at) = (0..surfaces).find(|&at| {
        let s = data.s[at];
        !(0.0..=1.0).contains(&s) || (at > 0 && s <= data.s[at - 1])
    }) {
        return Err(format!(
            "`s` is {} at surface {} of {surfaces}: it rises from 0, the axis, to 1, the edge",
            data.s[at],
            at + 1
        ));
    }
    if data.s[surfaces - 1] < 0.5 {
        return Err(format!(
            "`s` ends at {}: without surfaces near the edge, s = 1, the field there would be a guess",
            data.s[surfaces - 1]
        ));
    }
    let profiles = data.iota.iter().chain(&data.g).chain(&data.i);
    if profiles.chain([&data.edge_flux]).any(|x| !x.is_finite()) {
        return Err("`iota`, `G`, `I` or `psi` has a number that is not finite".to_owned());
    }
    if data.edge_flux == 0.0 {
        return Err("`psi`, the toroidal flux at the edge over 2 pi, is 0".to_owned());
    }
    if let Some(at) = data
        .strength
        .iter()
        .position(|b| !(*b > 0.0 && b.is_finite()))
    {
        let (surface, node) = (
            at / (along_theta * along_zeta),
            at % (along_theta * along_zeta),
        );
        return Err(format!(
            "`B` is {} on surface {}, at the node {} of theta and {} of zeta: it is a field strength, above 0",
            data.strength[at],
            surface + 1,
            node / along_zeta + 1,
            node % along_zeta + 1
        ));
    }
    let current = |at: usize| data.i.get(at).copied().unwrap_or(0.0);
    let along = |at: usize| data.g[at] + data.iota[at] * current(at);
    if let Some(at) = (0..surfaces).find(|&at| along(at) * along(0) <= 0.0) {
        return Err(format!(
            "`G + iota I` is {} on surface {} and {} on the first: the volume B² dtheta dzeta keeps one sign",
            along(at),
            at + 1,
            along(0)
        ));
    }
    if data.s[0] == 0.0 && current(0) != 0.0 {
        return Err(format!(
            "`I` is {} on the axis, s = 0, where no current is enclosed: it must be 0 there",
            current(0)
        ));
    }
    Ok(())
}

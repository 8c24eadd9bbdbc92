//! Closed surfaces of constant flux.

use std::f64::consts::PI;

use crate::equilibrium::Equilibrium;
use crate::error::EquilibriumError;

/// A closed curve of constant ψ about the axis, by its distance from the axis at equal angles.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    /// R and Z.
    pub points: Vec<[f64; 2]>,
    /// ρ/(∂ψ/∂ρ), ρ the distance from the axis: R times it is the volume of a thin shell an angle.
    widths: Vec<f64>,
    /// F at the points.
    f: Vec<f64>,
}

/// Angles of a surface.
const ANGLES: usize = 512;

/// Steps along a ray until it meets the surface, as parts of the grid's width.
const RAY: f64 = 1.0 / 256.0;

/// The normalized flux of a surface next to the edge.
const NEXT_TO_EDGE: f64 = 0.99;

/// Halvings of the step that meets it.
const HALVINGS: usize = 60;

impl Surface {
    /// The surface of the normalized flux s.
    ///
    /// # Errors
    /// [`EquilibriumError::Open`] where a ray from the axis leaves the grid first.
    pub fn of(equilibrium: &Equilibrium, surface: f64) -> Result<Self, EquilibriumError> {
        let open = || EquilibriumError::Open { surface };
        let [r, z] = equilibrium.axis();
        let [left, right] = equilibrium.file().r;
        let (mut points, mut widths, mut f) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..ANGLES {
            let (sine, cosine) = libm::sincos(2.0 * PI * k as f64 / ANGLES as f64);
            let at = |distance: f64| [r + distance * cosine, z + distance * sine];
            let beyond = |distance: f64| {
                let flux = equilibrium.flux(at(distance));
                (!flux.is_nan()).then_some(flux >= surface)
            };
            let mut within = 0.0;
            let mut outside = RAY * (right - left);
            while !beyond(outside).ok_or_else(open)? {
                within = outside;
                outside += RAY * (right - left);
            }
            for _ in 0..HALVINGS {
                let middle = f64::midpoint(within, outside);
                match beyond(middle).ok_or_else(open)? {
                    true => outside = middle,
                    false => within = middle,
                }
            }
            let point = at(outside);
            let [along_r, along_z] = equilibrium.slopes(point);
            points.push(point);
            widths.push(outside / (along_r * cosine + along_z * sine));
            f.push(equilibrium.field(point)[2] * point[0]);
        }
        Ok(Self { points, widths, f })
    }

    /// q = (1/2π) ∮ F ρ/(R ∂ψ/∂ρ) dθ; the sum over equal angles converges like a power of a number below 1.
    pub fn safety_factor(&self) -> f64 {
        let terms = self.points.iter().zip(&self.widths).zip(&self.f);
        let sum: f64 = terms.map(|(([r, _], width), f)| f * width / r).sum();
        sum.abs() * self.f[0].signum() / ANGLES as f64
    }

    /// The point at a part of the volume of a thin shell, from 0 to 1 around the axis.
    pub fn at_part(&self, part: f64) -> [f64; 2] {
        let weights = self.points.iter().zip(&self.widths);
        let weights: Vec<f64> = weights.map(|([r, _], width)| (r * width).abs()).collect();
        let mut rest = part * weights.iter().sum::<f64>();
        for (k, weight) in weights.iter().enumerate() {
            if rest < *weight || k + 1 == ANGLES {
                let [a, b] = [self.points[k], self.points[(k + 1) % ANGLES]];
                let u = (rest / weight).min(1.0);
                return [a[0] + u * (b[0] - a[0]), a[1] + u * (b[1] - a[1])];
            }
            rest -= weight;
        }
        self.points[0]
    }
}

impl Equilibrium {
    /// The safety factor of the surface of normalized flux s, field lines' turns the long way around for one the short way.
    ///
    /// # Errors
    /// [`EquilibriumError::Open`] for a surface that is not closed within the grid.
    pub fn safety_factor(&self, surface: f64) -> Result<f64, EquilibriumError> {
        match surface > 0.0 {
            true => Ok(Surface::of(self, surface)?.safety_factor()),
            false => Ok(self.axis_safety_factor()),
        }
    }

    /// Whether particles are lost at the edge before they leave the grid.
    pub fn has_edge(&self) -> bool {
        Surface::of(self, NEXT_TO_EDGE).is_ok()
    }
}

//! How far α̂ is from a Poisson map, and α̂, β̂ from a dual pair.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::differences::jacobian_by_differences;
use crate::chart::{ChartMaps, ChartWorker};
use crate::code_workers::RealizationMaps;
use crate::error::{BuildError, StepError};
use crate::realization::{Ends, RealizationData, RealizationWorker};
use crate::system::{PoissonSystem, TensorMatrix};

/// ε Π(α̂) − {α̂, α̂}_ω and {α̂_i, β̂_j}_ω at points χ(x, p) of a cotangent chart about the section, from
/// the exact tangents of both maps; or, marked as such, by differences where a realization offers none.
///
/// On T*M with ω = dp_i ∧ dx^i the bracket is {f, g}_ω = Σ_k ∂f/∂x^k ∂g/∂p_k − ∂f/∂p_k ∂g/∂x^k; where
/// points of S are not pairs (x, p) it is taken of α̂∘χ and β̂∘χ, χ being symplectic.
pub struct RealizationInstrument {
    maps: RealizationMaps,
    chart: ChartMaps,
    space: usize,
    tensor: TensorMatrix,
    parameters: Vec<f64>,
}

/// The errors at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RealizationError {
    /// (Σ_{i<j} (ε Π_ij(α̂) − {α̂_i, α̂_j}_ω)²)^{1/2}, the paper's realization error.
    pub source: f64,
    /// (Σ_{i<j} (ε Π_ij(β̂) + {β̂_i, β̂_j}_ω)²)^{1/2}: β̂ as an anti-Poisson map.
    pub target: f64,
    /// (Σ_{ij} {α̂_i, β̂_j}_ω²)^{1/2}.
    pub dual_pair: f64,
    /// The size of the largest brackets, to tell round-off.
    pub scale: f64,
    /// The same of the sums Σ_k |∂f/∂x^k ∂g/∂p_k| + |∂f/∂p_k ∂g/∂x^k| that cancel in them, at least
    /// `scale`.
    pub terms: f64,
    /// Where tangents were taken by differences, what these may put into any of the errors; `None`
    /// where they are exact.
    pub floor: Option<f64>,
}

/// Dα̂ and Dβ̂ in the chart's coordinates, d × 2d, and what they may be wrong by.
struct Tangents {
    source: DMatrix<f64>,
    target: DMatrix<f64>,
    errors: Option<[DMatrix<f64>; 2]>,
}

/// Both maps through the chart.
struct Charted {
    realization: Box<dyn RealizationWorker>,
    chart: Box<dyn ChartWorker>,
    z: Vec<f64>,
    ends: Ends,
}

impl RealizationInstrument {
    /// The instrument for a realization whose space has a symplectic chart about the section.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization has no such chart or offers neither code
    /// nor numbers, [`BuildError::Algebra`] where a derivative has no code.
    pub fn new(
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
        parameters: &[f64],
    ) -> Result<Self, BuildError> {
        let chart = ChartMaps::of(realization, parameters.len())?;
        let chart = chart.ok_or_else(|| BuildError::Incompatible {
            dynamics: "the realization error".to_owned(),
            realization: realization.describe(),
            reason: "it offers no maps on T*M and no chart to see its own through".to_owned(),
        })?;
        Ok(Self {
            maps: RealizationMaps::new(realization, parameters)?,
            chart,
            space: realization.space_dimension(),
            tensor: TensorMatrix::new(system, parameters)?,
            parameters: parameters.to_vec(),
        })
    }

    /// The errors at χ(x, p) for this ε.
    ///
    /// # Errors
    /// The realization's [`StepError`], such as [`StepError::LeftChart`].
    pub fn measure(
        &mut self,
        epsilon: f64,
        x: &[f64],
        p: &[f64],
    ) -> Result<RealizationError, StepError> {
        let d = x.len();
        let mut charted = Charted {
            realization: self.maps.worker(&self.parameters, epsilon),
            chart: self.chart.worker(&self.parameters, epsilon),
            z: vec![0.0; self.space],
            ends: Ends::new(d),
        };
        let (mut alpha, mut beta) = (vec![0.0; d], vec![0.0; d]);
        charted.ends(x, p, &mut alpha, &mut beta)?;
        let Tangents {
            source,
            target,
            errors,
        } = charted.tangents(x, p)?;
        let own = [bracket(&source, &source), bracket(&target, &target)];
        let tensors = [
            self.tensor.at(&alpha)? * epsilon,
            self.tensor.at(&beta)? * -epsilon,
        ];
        let all = own.iter().chain(&tensors);
        let scale = all.map(largest).fold(0.0, f64::max);
        let sizes = [source.abs(), target.abs()];
        let [f, g] = &sizes;
        let cancelled = [sums(f, f), sums(g, g), sums(f, g)];
        let terms = cancelled.iter().map(largest).fold(scale, f64::max);
        // {f, g} with f off by e and g by e' is off by |e||g| + |f||e'|, entry by entry.
        let floor = errors.map(|[ef, eg]| {
            let off = [
                sums(&ef, f) + sums(f, &ef),
                sums(&eg, g) + sums(g, &eg),
                sums(&ef, g) + sums(f, &eg),
            ];
            off.iter().map(norm).fold(0.0, f64::max)
        });
        // Antisymmetric matrices hold every pair twice.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        Ok(RealizationError {
            source: half * norm(&(&tensors[0] - &own[0])),
            target: half * norm(&(&tensors[1] - &own[1])),
            dual_pair: norm(&bracket(&source, &target)),
            scale,
            terms,
            floor,
        })
    }
}

impl Charted {
    /// α̂ and β̂ at χ(x, p).
    fn ends(
        &mut self,
        x: &[f64],
        p: &[f64],
        alpha: &mut [f64],
        beta: &mut [f64],
    ) -> Result<(), StepError> {
        self.chart.point(x, p, &mut self.z)?;
        self.realization.ends(&self.z, &mut self.ends)?;
        for i in 0..x.len() {
            beta[i] = self.ends.base[i] + self.ends.offset[i];
            alpha[i] = beta[i] + self.ends.increment[i];
        }
        Ok(())
    }

    /// Both tangents at χ(x, p), where the maps were evaluated last.
    fn tangents(&mut self, x: &[f64], p: &[f64]) -> Result<Tangents, StepError> {
        let (d, space) = (x.len(), self.z.len());
        if !(self.realization.has_tangents() && self.chart.has_tangent()) {
            return self.differences(x, p);
        }
        let mut chart = vec![0.0; space * 2 * d];
        self.chart.tangent(x, p, &mut chart)?;
        let mut target = vec![0.0; d * space];
        let mut increment = vec![0.0; d * space];
        self.realization.tangents(&mut target, &mut increment)?;
        let chart = DMatrix::from_row_slice(space, 2 * d, &chart);
        let in_chart = |rows: &[f64]| DMatrix::from_row_slice(d, space, rows) * &chart;
        let target = in_chart(&target);
        Ok(Tangents {
            source: &target + in_chart(&increment),
            target,
            errors: None,
        })
    }

    fn differences(&mut self, x: &[f64], p: &[f64]) -> Result<Tangents, StepError> {
        let d = x.len();
        let found = jacobian_by_differences(&[x, p].concat(), 2 * d, |at, out| {
            let (x, p) = at.split_at(d);
            let (alpha, beta) = out.split_at_mut(d);
            self.ends(x, p, alpha, beta)
        })?;
        let halves = |m: &DMatrix<f64>| [0, d].map(|first| m.rows(first, d).into_owned());
        let [source, target] = halves(&found.jacobian);
        Ok(Tangents {
            source,
            target,
            errors: Some(halves(&found.error)),
        })
    }
}

/// ({f_i, g_j}_ω) of two maps from their tangents.
fn bracket(f: &DMatrix<f64>, g: &DMatrix<f64>) -> DMatrix<f64> {
    let d = f.nrows();
    f.columns(0, d) * g.columns(d, d).transpose() - f.columns(d, d) * g.columns(0, d).transpose()
}

/// The same of sizes, with nothing cancelled.
fn sums(f: &DMatrix<f64>, g: &DMatrix<f64>) -> DMatrix<f64> {
    let d = f.nrows();
    f.columns(0, d) * g.columns(d, d).transpose() + f.columns(d, d) * g.columns(0, d).transpose()
}

fn largest(m: &DMatrix<f64>) -> f64 {
    m.iter().fold(0.0, |largest, v| v.abs().max(largest))
}

fn norm(m: &DMatrix<f64>) -> f64 {
    libm::sqrt(m.iter().map(|v| v * v).sum())
}

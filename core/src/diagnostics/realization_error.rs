//! How far α̂ is from a Poisson map, and α̂, β̂ from a dual pair.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::differences::jacobian_by_differences;
use super::round_off;
use crate::chart::ChartMaps;
use crate::code_evaluators::RealizationMaps;
use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::realization::{Ends, RealizationData};
use crate::system::{PoissonSystem, TensorMatrix};

/// ε Π(α̂) − {α̂, α̂}_ω and {α̂_i, β̂_j}_ω at points χ(x, p) of a cotangent chart about the section. Derivatives are
/// the exact tangents of both maps. Where a realization offers none, they are taken by differences, and the errors
/// are marked as such.
///
/// On T*M with ω = dp_i ∧ dx^i the bracket is {f, g}_ω = Σ_k ∂f/∂x^k ∂g/∂p_k − ∂f/∂p_k ∂g/∂x^k. Where points of S are
/// not pairs (x, p), the bracket is taken of α̂∘χ and β̂∘χ, χ being symplectic.
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
    /// The size of the largest brackets.
    pub scale: f64,
    /// Where tangents were taken by differences, what these may put into any of the errors; `None`
    /// where they are exact.
    pub floor: Option<f64>,
    /// The three errors, entry by entry in units of what round-off may put into it, u b_ij. The bound b_ij holds
    /// Σ_k |∂f_i/∂x^k ∂g_j/∂p_k| + |∂f_i/∂p_k ∂g_j/∂x^k| and what the arguments put into ε Π_ij. Each of the two
    /// derivatives is known to u times its whole row. No units of the coordinates change the errors.
    pub relative: Relative,
    /// [`floor`](Self::floor) in these units; 0 for exact tangents.
    pub relative_floor: f64,
}

/// The errors of a [`RealizationError`] in units of their terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relative {
    /// Of ε Π(α̂) − {α̂, α̂}_ω.
    pub source: f64,
    /// Of ε Π(β̂) + {β̂, β̂}_ω.
    pub target: f64,
    /// Of {α̂, β̂}_ω.
    pub dual_pair: f64,
}

/// Dα̂ and Dβ̂ in the chart's coordinates, d × 2d, and what they may be wrong by.
struct Tangents {
    source: DMatrix<f64>,
    target: DMatrix<f64>,
    errors: Option<[DMatrix<f64>; 2]>,
}

/// Both maps through the chart.
struct Charted {
    realization: Box<dyn Evaluator>,
    chart: Box<dyn Evaluator>,
    has_tangents: bool,
    z: Vec<f64>,
    /// Base, offset and increment.
    values: Vec<f64>,
}

impl RealizationInstrument {
    /// Instrument for a realization whose space has a symplectic chart about the section.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization has no such chart or offers neither code nor numbers. Also
    /// [`BuildError::Algebra`] where a derivative has no code.
    pub fn new(
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
        parameters: &[f64],
    ) -> Result<Self, BuildError> {
        let chart = ChartMaps::of(realization.as_ref(), parameters.len())?;
        let chart = chart.ok_or_else(|| BuildError::Incompatible {
            dynamics: "the realization error".to_owned(),
            realization: realization.describe(),
            reason: "it offers neither maps on T*M nor a chart that expresses its own maps there"
                .to_owned(),
        })?;
        Ok(Self {
            maps: RealizationMaps::new(realization.as_ref(), parameters.len())?,
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
            has_tangents: self.maps.has_jacobian() && self.chart.has_jacobian(),
            realization: self.maps.evaluator(&self.parameters, epsilon),
            chart: self.chart.evaluator(&self.parameters, epsilon),
            z: vec![0.0; self.space],
            values: vec![0.0; 3 * d],
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
        let off = [
            &tensors[0] - &own[0],
            &tensors[1] - &own[1],
            bracket(&source, &target),
        ];
        // Antisymmetric matrices hold every pair twice.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let parts = [half, half, 1.0];
        let sizes: Vec<f64> = (0..d)
            .map(|i| x[i].abs().max(alpha[i].abs()).max(beta[i].abs()))
            .collect();
        let momenta = p.iter().map(|p| p.abs());
        let arguments: Vec<f64> = sizes.iter().copied().chain(momenta).collect();
        let [f, g] = [&source, &target].map(|tangent| OfRows {
            sizes: tangent.abs(),
            rows: round_off::of_rows(tangent, &sizes, &arguments),
        });
        let of_tensor = |tensor: &mut TensorMatrix, at| {
            Ok::<_, StepError>(tensor.sizes(at, &sizes)? * epsilon.abs())
        };
        let bounds = [
            f.bracket(&f) + of_tensor(&mut self.tensor, &alpha)?,
            g.bracket(&g) + of_tensor(&mut self.tensor, &beta)?,
            f.bracket(&g),
        ];
        let relative: Vec<f64> = (0..3)
            .map(|k| parts[k] * round_off::relative(&off[k], &bounds[k]).unwrap_or(0.0))
            .collect();
        // {f, g} with f off by e and g by e' is off by |e||g| + |f||e'|, entry by entry.
        let floors = errors.map(|[ef, eg]| {
            let (f, g) = (&f.sizes, &g.sizes);
            [
                sums(&ef, f) + sums(f, &ef),
                sums(&eg, g) + sums(g, &eg),
                sums(&ef, g) + sums(f, &eg),
            ]
        });
        let floor = floors
            .as_ref()
            .map(|floors| floors.iter().map(norm).fold(0.0, f64::max));
        let relative_floor = floors.map_or(0.0, |floors| {
            let each = floors.iter().zip(&bounds);
            let each = each.filter_map(|(floor, bounds)| round_off::relative(floor, bounds));
            each.fold(0.0, f64::max)
        });
        Ok(RealizationError {
            source: half * norm(&off[0]),
            target: half * norm(&off[1]),
            dual_pair: norm(&off[2]),
            scale,
            floor,
            relative: Relative {
                source: relative[0],
                target: relative[1],
                dual_pair: relative[2],
            },
            relative_floor,
        })
    }
}

/// A tangent's sizes, and round-off in units of u.
struct OfRows {
    sizes: DMatrix<f64>,
    rows: DMatrix<f64>,
}

impl OfRows {
    /// Round-off that the rows of either tangent may put into a bracket, entry by entry in units of u.
    fn bracket(&self, other: &Self) -> DMatrix<f64> {
        sums(&self.rows, &other.sizes) + sums(&self.sizes, &other.rows)
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
        self.chart.values(&[x, p].concat(), &mut self.z)?;
        self.realization.values(&self.z, &mut self.values)?;
        let ends = Ends::of(&self.values);
        for i in 0..x.len() {
            beta[i] = ends.target(i);
            alpha[i] = ends.source(i);
        }
        Ok(())
    }

    /// Both tangents at χ(x, p), where the maps were evaluated last.
    fn tangents(&mut self, x: &[f64], p: &[f64]) -> Result<Tangents, StepError> {
        let (d, space) = (x.len(), self.z.len());
        if !self.has_tangents {
            return self.differences(x, p);
        }
        let mut chart = vec![0.0; space * 2 * d];
        self.chart.jacobians(&[x, p].concat(), &mut chart)?;
        let mut both = vec![0.0; 2 * d * space];
        self.realization.jacobians(&self.z, &mut both)?;
        let (target, increment) = both.split_at(d * space);
        let chart = DMatrix::from_row_slice(space, 2 * d, &chart);
        let in_chart = |rows: &[f64]| DMatrix::from_row_slice(d, space, rows) * &chart;
        let target = in_chart(target);
        Ok(Tangents {
            source: &target + in_chart(increment),
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

//! How far α̂ is from a Poisson map, and α̂, β̂ from a dual pair.

use std::sync::Arc;

use nalgebra::DMatrix;

use crate::code_workers::CodeRealization;
use crate::error::{BuildError, StepError};
use crate::realization::{Ends, RealizationData, RealizationWorker};
use crate::system::{PoissonSystem, TensorMatrix};

/// ε Π(α̂) − {α̂, α̂}_ω and {α̂_i, β̂_j}_ω at points of a cotangent chart, from the exact tangents of
/// both maps.
///
/// On T*M with ω = dp_i ∧ dx^i the bracket is {f, g}_ω = Σ_k ∂f/∂x^k ∂g/∂p_k − ∂f/∂p_k ∂g/∂x^k.
pub struct RealizationInstrument {
    realization: Arc<dyn RealizationData>,
    code: Option<CodeRealization>,
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
}

impl RealizationInstrument {
    /// The instrument for a realization whose space is T*M in coordinates (x, p).
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization has another space or offers neither code
    /// nor numbers, [`BuildError::Algebra`] where a derivative has no code.
    pub fn new(
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
        parameters: &[f64],
    ) -> Result<Self, BuildError> {
        let d = system.dimension();
        let missing = || BuildError::Incompatible {
            dynamics: "the realization error".to_owned(),
            realization: realization.describe(),
            reason: "it offers no maps on T*M".to_owned(),
        };
        if realization.space_dimension() != 2 * d {
            return Err(missing());
        }
        let code = match realization.code() {
            Some(code) => Some(CodeRealization::compile(code, d, 2 * d, parameters.len())?),
            None => {
                realization.worker(parameters, 1.0).ok_or_else(missing)?;
                None
            }
        };
        Ok(Self {
            realization: Arc::clone(realization),
            code,
            tensor: TensorMatrix::new(system, parameters)?,
            parameters: parameters.to_vec(),
        })
    }

    fn worker(&self, epsilon: f64) -> Box<dyn RealizationWorker> {
        match &self.code {
            Some(code) => code.worker(&self.parameters, epsilon),
            None => self
                .realization
                .worker(&self.parameters, epsilon)
                .expect("a worker was offered when the instrument was made"),
        }
    }

    /// The errors at (x, p) for this ε.
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
        let z: Vec<f64> = x.iter().chain(p).copied().collect();
        let mut worker = self.worker(epsilon);
        let mut ends = Ends::new(d);
        worker.ends(&z, &mut ends)?;
        let mut target = vec![0.0; 2 * d * d];
        let mut increment = vec![0.0; 2 * d * d];
        worker.tangents(&mut target, &mut increment)?;
        let target = DMatrix::from_row_slice(d, 2 * d, &target);
        let source = &target + DMatrix::from_row_slice(d, 2 * d, &increment);
        let beta: Vec<f64> = ends
            .base
            .iter()
            .zip(&ends.offset)
            .map(|(b, o)| b + o)
            .collect();
        let alpha: Vec<f64> = beta
            .iter()
            .zip(&ends.increment)
            .map(|(b, i)| b + i)
            .collect();
        let bracket = |f: &DMatrix<f64>, g: &DMatrix<f64>| {
            f.columns(0, d) * g.columns(d, d).transpose()
                - f.columns(d, d) * g.columns(0, d).transpose()
        };
        let own = [bracket(&source, &source), bracket(&target, &target)];
        let tensors = [
            self.tensor.at(&alpha)? * epsilon,
            self.tensor.at(&beta)? * -epsilon,
        ];
        let scale = own
            .iter()
            .chain(&tensors)
            .flat_map(|m| m.iter())
            .fold(0.0_f64, |largest, v| largest.max(v.abs()));
        let norm = |m: DMatrix<f64>| libm::sqrt(m.iter().map(|v| v * v).sum());
        // Antisymmetric matrices hold every pair twice.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        Ok(RealizationError {
            source: half * norm(&tensors[0] - &own[0]),
            target: half * norm(&tensors[1] - &own[1]),
            dual_pair: norm(bracket(&source, &target)),
            scale,
        })
    }
}

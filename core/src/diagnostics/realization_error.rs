//! How far α̂ is from a Poisson map, and α̂, β̂ from a dual pair.

use leafwise_expression::{Arithmetic, Graph, Kernel, Rational, StepSize, Term, Workspace};

use crate::error::BuildError;
use crate::realization::RealizationData;
use crate::system::PoissonSystem;

/// ε Π(α̂) − {α̂, α̂}_ω and {α̂_i, β̂_j}_ω at points of a cotangent chart, with exact derivatives.
///
/// On T*M with ω = dp_i ∧ dx^i the bracket is {f, g}_ω = Σ_k ∂f/∂x^k ∂g/∂p_k − ∂f/∂p_k ∂g/∂x^k.
#[derive(Debug)]
pub struct RealizationInstrument {
    kernel: Kernel,
    workspace: Workspace,
    parameters: Vec<f64>,
    dimension: usize,
    values: Vec<f64>,
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
    /// Compiles the instrument for a realization whose space is T*M in coordinates (x, p).
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization has no code or another space,
    /// [`BuildError::Algebra`] where a derivative has no code.
    pub fn new(
        system: &PoissonSystem,
        realization: &dyn RealizationData,
        parameters: &[f64],
    ) -> Result<Self, BuildError> {
        let d = system.dimension();
        let code = realization
            .code()
            .filter(|_| realization.space_dimension() == 2 * d);
        let code = code.ok_or_else(|| BuildError::Incompatible {
            dynamics: "the realization error".to_owned(),
            realization: realization.describe(),
            reason: "it offers no code for its maps on T*M".to_owned(),
        })?;
        let mut graph = Graph::new();
        let z: Vec<Term> = (0..2 * d).map(|i| graph.input(i)).collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        let ends = code.source_and_target(&mut graph, &epsilon, &z)?;
        let beta: Vec<Term> = (0..d)
            .map(|i| graph.add(&ends.base[i], &ends.offset[i]))
            .collect();
        let alpha: Vec<Term> = (0..d)
            .map(|i| graph.add(&beta[i], &ends.increment[i]))
            .collect();
        let mut outputs = Vec::new();
        for (map, sign) in [(&alpha, 1), (&beta, -1)] {
            for i in 0..d {
                for j in i + 1..d {
                    let tensor = match system.tensor().get(&(i, j)) {
                        None => graph.zero(),
                        Some(entry) => {
                            entry.evaluate_in(&mut graph, &mut |_, at| Ok(map[at].clone()))?
                        }
                    };
                    let tensor = graph.multiply(&epsilon, &tensor);
                    let bracket = canonical_bracket(&mut graph, &map[i], &map[j], d)?;
                    outputs.push(graph.scale(&Rational::from_integer(sign), &tensor));
                    outputs.push(bracket);
                }
            }
        }
        for i in 0..d {
            for j in 0..d {
                outputs.push(canonical_bracket(&mut graph, &alpha[i], &beta[j], d)?);
            }
        }
        let kernel = Kernel::compile(&graph, &outputs, parameters.len(), 2 * d);
        let workspace = kernel.workspace(1);
        let values = vec![0.0; outputs.len()];
        Ok(Self {
            kernel,
            workspace,
            parameters: parameters.to_vec(),
            dimension: d,
            values,
        })
    }

    /// The errors at (x, p) for this ε.
    ///
    /// # Panics
    /// When `x` or `p` does not have the system's dimension.
    pub fn measure(&mut self, epsilon: f64, x: &[f64], p: &[f64]) -> RealizationError {
        let d = self.dimension;
        assert_eq!((x.len(), p.len()), (d, d), "one coordinate a variable");
        self.kernel
            .prepare(&mut self.workspace, &self.parameters, &[epsilon], &[1.0]);
        let z: Vec<f64> = x.iter().chain(p).copied().collect();
        self.kernel
            .evaluate(&mut self.workspace, &z, &mut self.values);
        let pairs = d * (d - 1) / 2;
        let mut scale = 0.0_f64;
        let mut difference = |pairs: &[f64]| {
            let mut sum = 0.0;
            for pair in pairs.chunks_exact(2) {
                scale = scale.max(pair[0].abs()).max(pair[1].abs());
                sum += (pair[0] - pair[1]) * (pair[0] - pair[1]);
            }
            libm::sqrt(sum)
        };
        let source = difference(&self.values[..2 * pairs]);
        let target = difference(&self.values[2 * pairs..4 * pairs]);
        let dual_pair = libm::sqrt(self.values[4 * pairs..].iter().map(|v| v * v).sum());
        RealizationError {
            source,
            target,
            dual_pair,
            scale,
        }
    }
}

fn canonical_bracket(graph: &mut Graph, f: &Term, g: &Term, d: usize) -> Result<Term, BuildError> {
    let mut terms = Vec::with_capacity(2 * d);
    for k in 0..d {
        let (fx, gp) = (graph.derivative(f, k)?, graph.derivative(g, d + k)?);
        terms.push((Rational::one(), graph.multiply(&fx, &gp)));
        let (fp, gx) = (graph.derivative(f, d + k)?, graph.derivative(g, k)?);
        terms.push((-Rational::one(), graph.multiply(&fp, &gx)));
    }
    Ok(graph.combine(&terms))
}

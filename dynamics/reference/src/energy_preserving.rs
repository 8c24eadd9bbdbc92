//! Cohen and Hairer's energy-preserving collocation: the part `energy-preserving`.

use std::sync::Arc;

use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters};
use leafwise_core::quadrature::{GaussLegendre, legendre};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator, Tableau};
use leafwise_core::solver::iteration::Verdict;
use leafwise_core::solver::{
    Anderson, CorrectionSize, LinearIteration, elimination_operations, substitution_operations,
};
use leafwise_core::{BuildError, MapProperties, PoissonSystem, StepError, StepMap, Structure};
use nalgebra::{DMatrix, DVector};

use crate::one_step::{OneStep, ReferenceMap, larger, reach, relative};

pub(crate) static INFO: PartInfo = PartInfo {
    name: "energy-preserving",
    kind: PartKind::Stepper,
    summary: "collocation with averaged gradients: the energy is kept to round-off",
    declares: "order 2 or 4; self-adjoint; keeps H and quadratic Casimirs; not a Poisson map; \
               exact tangent",
    domain: "any system, of formulas or of numbers; polynomial H of degree up to 32 (order 2) or 16 \
             (order 4), other H as far as 16 quadrature nodes resolve it within a step",
    literature: "D. Cohen, E. Hairer, Linear energy-preserving integrators for Poisson systems, \
                 BIT 51 (2011)",
    parameters: &[ParameterInfo {
        name: "order",
        summary: "the order, 2 or 4: one or two stages",
        default: ParameterDefault::Integer(2),
    }],
};

/// Nodes of the averages: exact to degree 31.
const QUADRATURE: usize = 16;
/// Budget of one solve by Newton's iteration, and of one without derivatives.
const MOST_EVALUATIONS: usize = 50;
const MOST_ACCELERATED: usize = 100;

/// U(τ) = x + t Σ_j K_j ∫₀^τ ℓ_j with K_i = −Π(U(c_i)) ∫₀¹ ℓ_i(τ)/b_i ∇H(U(τ)) dτ and
/// x⁺ = U(1), for Gauss nodes c_i: the energy changes by
/// t Σ b_i W_i·K_i = −t Σ b_i W_iᵀ Π(U(c_i)) W_i = 0.
struct EnergyPreserving {
    /// (u, w) ↦ −Π(u) w and x ↦ ∇H(x).
    tensor: SmoothMapEvaluator,
    gradient: SmoothMapEvaluator,
    time_step: f64,
    tableau: Tableau,
    quadrature: GaussLegendre,
    /// ℓ_i(τ_q)/b_i and ∫₀^{τ_q} ℓ_j, one node after the other.
    averages: Vec<f64>,
    integrals: Vec<f64>,
    /// x of the last step and K.
    start: Vec<f64>,
    slopes: Vec<f64>,
    /// −Π(U(c_i)) W_i and its derivatives by K and by x, stages × stages and stages × 1 blocks.
    values: DVector<f64>,
    by_slopes: DMatrix<f64>,
    by_start: DMatrix<f64>,
    /// Σ_k |Π_ck W_k| at each stage.
    reaches: Vec<f64>,
    /// For systems without derivatives.
    anderson: Option<Anderson>,
    /// Operations of the averages, the stages and the solves.
    linear: u64,
    /// Those of one iteration.
    work: u64,
}

/// At each node the place, the averages and their two derivatives; at each stage the place, two
/// products of matrices and what enters the slopes; the solve. Without derivatives the places and
/// the averages.
fn iteration_operations(d: usize, s: usize, is_exact: bool) -> u64 {
    if !is_exact {
        return (QUADRATURE * 4 * d * s + 2 * d * s * s) as u64;
    }
    let node = 2 * d * s + s * (2 * d + 2 * d * d * (1 + s));
    let stage = 2 * d * s + 2 * d * d * d * (s + 1) + 2 * d * d * (s + 1);
    let solve = elimination_operations(s * d) + substitution_operations(s * d);
    (QUADRATURE * node + s * stage) as u64 + solve
}

impl EnergyPreserving {
    fn new(maps: &[SmoothMap; 2], stages: usize, parameters: &[f64], time_step: f64) -> Self {
        let [tensor, gradient] = maps
            .each_ref()
            .map(|map| map.evaluator(parameters, 1.0, 1.0));
        let d = gradient.map().inputs();
        let tableau = Tableau::gauss(stages);
        let quadrature = GaussLegendre::new(QUADRATURE);
        let (mut averages, mut integrals) = (Vec::new(), Vec::new());
        for tau in &quadrature.nodes {
            let here = legendre(stages, 2.0 * tau - 1.0);
            for (c, b) in tableau.nodes.iter().zip(&tableau.weights) {
                // ℓ_j = b_j Σ_k (2k+1) P̃_k(c_j) P̃_k, and its antiderivative as in `Tableau::gauss`.
                let there = legendre(stages, 2.0 * c - 1.0);
                averages.push(
                    (0..stages)
                        .map(|k| (2.0 * k as f64 + 1.0) * there[k] * here[k])
                        .sum(),
                );
                let rest: f64 = (1..stages)
                    .map(|k| there[k] * (here[k + 1] - here[k - 1]))
                    .sum();
                integrals.push(b * (tau + 0.5 * rest));
            }
        }
        let size = stages * d;
        let is_exact = tensor.map().has_jacobian() && gradient.map().has_jacobian();
        Self {
            tensor,
            gradient,
            time_step,
            tableau,
            quadrature,
            averages,
            integrals,
            start: vec![0.0; d],
            slopes: vec![0.0; size],
            values: DVector::zeros(size),
            by_slopes: DMatrix::zeros(size, size),
            by_start: DMatrix::zeros(size, d),
            reaches: vec![0.0; size],
            anderson: (!is_exact).then(|| Anderson::new(size)),
            linear: 0,
            work: iteration_operations(d, stages, is_exact),
        }
    }

    /// x + t Σ_j a_j K_j.
    fn place(&self, coefficients: &[f64]) -> Vec<f64> {
        let d = self.start.len();
        (0..d)
            .map(|c| {
                let sum: f64 = coefficients
                    .iter()
                    .zip(self.slopes.chunks(d))
                    .map(|(a, slope)| a * slope[c])
                    .sum();
                self.start[c] + self.time_step * sum
            })
            .collect()
    }

    /// Evaluates the stages at the current K, and their derivatives where the system has them.
    fn evaluate(&mut self) -> Result<(), StepError> {
        let is_exact = self.anderson.is_none();
        let (d, s) = (self.start.len(), self.tableau.stages());
        let mut averaged = vec![vec![0.0; d]; s];
        // ∂W_i/∂K_j and ∂W_i/∂x.
        let mut by_slope = vec![DMatrix::<f64>::zeros(d, s * d); s];
        let mut by_start = vec![DMatrix::<f64>::zeros(d, d); s];
        let (mut gradient, mut hessian) = (vec![0.0; d], vec![0.0; d * d]);
        for q in 0..QUADRATURE {
            let integrals = &self.integrals[q * s..][..s];
            let u = self.place(integrals);
            self.gradient.value(&u, &mut gradient)?;
            let weight = |i: usize| self.quadrature.weights[q] * self.averages[q * s + i];
            for (i, averaged) in averaged.iter_mut().enumerate() {
                for (sum, g) in averaged.iter_mut().zip(&gradient) {
                    *sum += weight(i) * g;
                }
            }
            if !is_exact {
                continue;
            }
            self.gradient.jacobian(&u, &mut hessian)?;
            let hessian = DMatrix::from_row_slice(d, d, &hessian);
            for i in 0..s {
                let weight = weight(i);
                by_start[i] += &hessian * weight;
                for (j, integral) in integrals.iter().enumerate() {
                    let mut block = by_slope[i].columns_mut(j * d, d);
                    block += &hessian * (weight * integral * self.time_step);
                }
            }
        }
        let mut value = vec![0.0; d];
        let mut jacobian = vec![0.0; 2 * d * d];
        for i in 0..s {
            let row = self.tableau.matrix[i * s..][..s].to_vec();
            let uw = [self.place(&row), averaged[i].clone()].concat();
            self.tensor.value(&uw, &mut value)?;
            self.values.rows_mut(i * d, d).copy_from_slice(&value);
            if !is_exact {
                continue;
            }
            self.tensor.jacobian(&uw, &mut jacobian)?;
            let both = DMatrix::from_row_slice(d, 2 * d, &jacobian);
            let (by_u, by_w) = (both.columns(0, d), both.columns(d, d));
            let mut slopes = by_w * &by_slope[i];
            for (j, a) in row.iter().enumerate() {
                let mut block = slopes.columns_mut(j * d, d);
                block += by_u * (a * self.time_step);
            }
            self.by_slopes.rows_mut(i * d, d).copy_from(&slopes);
            let start = by_u + by_w * &by_start[i];
            self.by_start.rows_mut(i * d, d).copy_from(&start);
            for c in 0..d {
                self.reaches[i * d + c] = reach(&jacobian[c * 2 * d + d..][..d], &averaged[i]);
            }
        }
        Ok(())
    }

    fn matrix(&self) -> DMatrix<f64> {
        DMatrix::identity(self.slopes.len(), self.slopes.len()) - &self.by_slopes
    }

    /// Newton's iteration for K.
    fn newton(&mut self) -> Result<usize, StepError> {
        let d = self.start.len();
        let mut iteration = LinearIteration::new(MOST_EVALUATIONS);
        loop {
            self.evaluate()?;
            self.linear += self.work;
            let mut correction = &self.values - DVector::from_column_slice(&self.slopes);
            if !self.matrix().lu().solve_mut(&mut correction) {
                return Err(StepError::NonFinite {
                    what: "a correction of the stages",
                });
            }
            let mut size = 0.0;
            for (at, slope) in self.slopes.iter_mut().enumerate() {
                *slope += correction[at];
                let t = self.time_step.abs();
                let scale = self.start[at % d].abs() + t * self.reaches[at];
                size = larger(relative(t * correction[at], scale), size);
            }
            if iteration.judge(size)? == Verdict::Converged {
                return Ok(iteration.evaluations());
            }
        }
    }

    /// K ← −Π(U) W with Anderson's acceleration, for systems without derivatives.
    fn accelerate(&mut self) -> Result<usize, StepError> {
        let d = self.start.len();
        let t = self.time_step.abs();
        let mut iteration = LinearIteration::new(MOST_ACCELERATED);
        let mut scales = vec![0.0; self.slopes.len()];
        if let Some(anderson) = &mut self.anderson {
            anderson.clear();
        }
        loop {
            self.evaluate()?;
            self.linear += self.work;
            let mut correction = &self.values - DVector::from_column_slice(&self.slopes);
            let mut size = CorrectionSize::default();
            for (at, scale) in scales.iter_mut().enumerate() {
                *scale = self.start[at % d].abs() + t * self.values[at].abs();
                size.take(t * correction[at], *scale);
            }
            if let Some(anderson) = &mut self.anderson {
                anderson.correct(correction.as_mut_slice(), &scales);
            }
            for (at, slope) in self.slopes.iter_mut().enumerate() {
                *slope += correction[at];
                size.take(t * correction[at], scales[at]);
            }
            if iteration.judge_correction(&size)? == Verdict::Converged {
                // The energy is kept as far as K is −Π(U) W: once more, without acceleration.
                self.evaluate()?;
                self.linear += self.work;
                self.slopes.copy_from_slice(self.values.as_slice());
                return Ok(iteration.evaluations() + 1);
            }
        }
    }
}

impl OneStep for EnergyPreserving {
    fn increment(&mut self, x: &[f64], increment: &mut [f64]) -> Result<usize, StepError> {
        self.start.copy_from_slice(x);
        let evaluations = if self.anderson.is_none() {
            self.newton()?
        } else {
            self.accelerate()?
        };
        for (c, increment) in increment.iter_mut().enumerate() {
            let sum: f64 = self
                .tableau
                .weights
                .iter()
                .zip(self.slopes.chunks(x.len()))
                .map(|(b, slope)| b * slope[c])
                .sum();
            *increment = self.time_step * sum;
        }
        Ok(evaluations)
    }

    fn operations(&self) -> Option<u64> {
        Some(self.tensor.operations()? + self.gradient.operations()? + self.linear)
    }

    fn tangent(&mut self) -> Option<DMatrix<f64>> {
        let d = self.start.len();
        if self.anderson.is_some() {
            return None;
        }
        self.evaluate().ok()?;
        let mut slopes = self.by_start.clone();
        if !self.matrix().lu().solve_mut(&mut slopes) {
            return None;
        }
        let mut tangent = DMatrix::identity(d, d);
        for (j, b) in self.tableau.weights.iter().enumerate() {
            tangent += slopes.rows(j * d, d) * (self.time_step * b);
        }
        Some(tangent)
    }

    fn restart(&mut self) {
        self.slopes.fill(0.0);
    }

    fn memory(&self) -> Vec<f64> {
        self.slopes.clone()
    }

    fn restore(&mut self, memory: &[f64]) {
        self.slopes.copy_from_slice(memory);
    }
}

struct Part;

impl StepperPart for Part {
    fn info(&self) -> &'static PartInfo {
        &INFO
    }

    fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        let order = parameters.get(&INFO, "order")?;
        let stages = match order {
            2 => 1,
            4 => 2,
            _ => {
                return Err(BuildError::Parameter {
                    part: INFO.name,
                    parameter: "order".to_owned(),
                    value: order.to_string(),
                    expected: "the order is 2 or 4".to_owned(),
                });
            }
        };
        let maps = [system.tensor_map()?, system.gradient_map()?];
        Ok(Arc::new(ReferenceMap {
            dimension: system.dimension(),
            properties: MapProperties {
                order: 2 * stages,
                structure: Structure::None,
                self_adjoint: Some(true),
            },
            description: format!("{} order = {order}", INFO.name),
            make: Box::new(move |parameters, time_step| {
                Box::new(EnergyPreserving::new(&maps, stages, parameters, time_step))
            }),
        }))
    }
}

leafwise_core::built_in!(Stepper, Part);

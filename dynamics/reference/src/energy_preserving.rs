//! Cohen and Hairer's energy-preserving collocation: the part `energy-preserving`.

use std::sync::Arc;

use leafwise_core::part::{
    ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters, ServesNumbers,
};
use leafwise_core::quadrature::{GaussLegendre, legendre};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator, Tableau};
use leafwise_core::solver::judge::reach;
use leafwise_core::solver::{StepReport, Trajectories, check_equations};
use leafwise_core::{
    BuildError, Evaluator, MapProperties, PoissonSystem, StepError, StepMap, Structure,
};
use nalgebra::DMatrix;

use crate::reference_map::{ReferenceMap, row_major};
use crate::step_equation::{StepEquation, StepSolve};

static INFO: PartInfo = PartInfo {
    name: "energy-preserving",
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
    serves_numbers: Some(ServesNumbers { rank: 6, limit: "" }),
    surveyed: &[
        &[("order", ParameterDefault::Integer(2))],
        &[("order", ParameterDefault::Integer(4))],
    ],
    ..PartInfo::of(PartKind::Stepper)
};

/// Nodes of the averages: exact to degree 31.
const QUADRATURE: usize = 16;

/// U(τ) = x + t Σ_j K_j ∫₀^τ ℓ_j and x⁺ = U(1), for Gauss nodes c_i: the stages of an
/// energy-preserving step. With W_i = ∫₀¹ ℓ_i(τ)/b_i ∇H(U(τ)) dτ the slopes are
/// K_i = −Π(U(c_i)) W_i. The energy changes by t Σ b_i W_i·K_i = −t Σ b_i W_iᵀ Π(U(c_i)) W_i = 0.
struct AveragedStages {
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
    /// −Π(U(c_i)) W_i and its derivatives by K and by x, row-major.
    values: Vec<f64>,
    by_slopes: Vec<f64>,
    by_start: Vec<f64>,
    /// Σ_k |Π_ck W_k| + |∂K_c/∂x_k x_k| at each stage.
    reaches: Vec<f64>,
    averages_of_gradient: Averages,
    /// U at a node or stage, with W after it; a value there and its derivatives.
    place: Vec<f64>,
    value: Vec<f64>,
    slope: Vec<f64>,
    /// Whether the last evaluation was with derivatives.
    is_exact: bool,
    /// Operations of the averages and the stages.
    averaged: u64,
}

/// W_i, ∂W_i/∂K (d × sd) and ∂W_i/∂x (d × d), one stage after the other.
struct Averages {
    values: Vec<f64>,
    by_slopes: Vec<f64>,
    by_start: Vec<f64>,
}

/// Where the coefficients a_j of a place come from.
#[derive(Clone, Copy)]
enum Coefficients {
    /// ∫₀^τ ℓ_j at a quadrature node.
    Node,
    /// a_ij at a stage.
    Stage,
}

/// At each node the place, the averages and their two derivatives; at each stage the place, two
/// products of matrices and what enters the slopes. Without derivatives the places and the averages.
fn evaluation_operations(d: usize, s: usize, is_exact: bool) -> u64 {
    if !is_exact {
        return (QUADRATURE * 4 * d * s + 2 * d * s * s) as u64;
    }
    let node = 2 * d * s + s * (2 * d + 2 * d * d * (1 + s));
    let stage = 2 * d * s + 2 * d * d * d * (s + 1) + 2 * d * d * (s + 1);
    (QUADRATURE * node + s * stage) as u64
}

impl AveragedStages {
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
            values: vec![0.0; size],
            by_slopes: vec![0.0; size * size],
            by_start: vec![0.0; size * d],
            reaches: vec![0.0; size],
            averages_of_gradient: Averages {
                values: vec![0.0; size],
                by_slopes: vec![0.0; size * size],
                by_start: vec![0.0; size * d],
            },
            place: vec![0.0; 2 * d],
            value: vec![0.0; d],
            slope: vec![0.0; 2 * d * d],
            is_exact: false,
            averaged: 0,
        }
    }

    /// Whether the system has derivatives.
    fn has_jacobian(&self) -> bool {
        self.tensor.map().has_jacobian() && self.gradient.map().has_jacobian()
    }

    /// Writes x + t Σ_j a_j K_j into the first half of `place`.
    fn place(&mut self, coefficients: Coefficients, at: usize) {
        let (d, s) = (self.start.len(), self.tableau.stages());
        let rows = match coefficients {
            Coefficients::Node => &self.integrals,
            Coefficients::Stage => &self.tableau.matrix,
        };
        let row = &rows[at * s..][..s];
        for c in 0..d {
            let slopes = self.slopes.chunks_exact(d);
            let sum: f64 = row.iter().zip(slopes).map(|(a, slope)| a * slope[c]).sum();
            self.place[c] = self.start[c] + self.time_step * sum;
        }
    }

    /// The averaged gradients at the current K, and their derivatives where they are wanted.
    fn average(&mut self) -> Result<(), StepError> {
        let (d, s) = (self.start.len(), self.tableau.stages());
        let averages = &mut self.averages_of_gradient;
        averages.values.fill(0.0);
        if self.is_exact {
            averages.by_slopes.fill(0.0);
            averages.by_start.fill(0.0);
        }
        for q in 0..QUADRATURE {
            self.place(Coefficients::Node, q);
            self.gradient.values(&self.place[..d], &mut self.value)?;
            let averages = &mut self.averages_of_gradient;
            let weight = |i: usize| self.quadrature.weights[q] * self.averages[q * s + i];
            for (i, sums) in averages.values.chunks_exact_mut(d).enumerate() {
                let weight = weight(i);
                for (sum, value) in sums.iter_mut().zip(&self.value) {
                    *sum += weight * value;
                }
            }
            if !self.is_exact {
                continue;
            }
            let hessian = &mut self.slope[..d * d];
            self.gradient.jacobians(&self.place[..d], hessian)?;
            for row in 0..s * d {
                let (weight, hessian) = (weight(row / d), &hessian[row % d * d..][..d]);
                let by_start = &mut averages.by_start[row * d..][..d];
                for (sum, h) in by_start.iter_mut().zip(hessian) {
                    *sum += weight * h;
                }
                let by_slopes = &mut averages.by_slopes[row * s * d..][..s * d];
                let integrals = &self.integrals[q * s..][..s];
                for (sums, integral) in by_slopes.chunks_exact_mut(d).zip(integrals) {
                    let factor = weight * integral * self.time_step;
                    for (sum, h) in sums.iter_mut().zip(hessian) {
                        *sum += factor * h;
                    }
                }
            }
        }
        Ok(())
    }

    /// Evaluates the stages at K, and their derivatives where they are wanted.
    fn evaluate(&mut self, slopes: &[f64], is_exact: bool) -> Result<(), StepError> {
        self.slopes.copy_from_slice(slopes);
        self.is_exact = is_exact;
        let (d, s) = (self.start.len(), self.tableau.stages());
        self.averaged += evaluation_operations(d, s, is_exact);
        self.average()?;
        for i in 0..s {
            self.place(Coefficients::Stage, i);
            let own = i * d..(i + 1) * d;
            self.place[d..].copy_from_slice(&self.averages_of_gradient.values[own.clone()]);
            self.tensor.values(&self.place, &mut self.values[own])?;
            if self.is_exact {
                self.tensor.jacobians(&self.place, &mut self.slope)?;
                self.differentiate(i);
            }
        }
        Ok(())
    }

    /// The derivatives of −Π(U(c_i)) W_i from those of the tensor's map at that stage.
    fn differentiate(&mut self, i: usize) {
        let (d, s) = (self.start.len(), self.tableau.stages());
        let averages = &self.averages_of_gradient;
        for c in 0..d {
            let (by_u, by_w) = self.slope[c * 2 * d..][..2 * d].split_at(d);
            let row = i * d + c;
            let of_slopes = &averages.by_slopes[i * d * s * d..];
            let by_slopes = &mut self.by_slopes[row * s * d..][..s * d];
            combine(by_w, of_slopes, by_slopes);
            for (j, by_slope) in by_slopes.chunks_exact_mut(d).enumerate() {
                let a = self.tableau.matrix[i * s + j];
                for (entry, by_u) in by_slope.iter_mut().zip(by_u) {
                    *entry += a * self.time_step * by_u;
                }
            }
            let by_start = &mut self.by_start[row * d..][..d];
            combine(by_w, &averages.by_start[i * d * d..], by_start);
            for (entry, by_u) in by_start.iter_mut().zip(by_u) {
                *entry += by_u;
            }
            // The averages are sums whose terms may cancel.
            self.reaches[row] = reach(by_w, &self.place[d..]) + reach(by_start, &self.start);
        }
    }

    /// t Σ_i b_i K_i for the K of `slopes`.
    fn increment(&self, slopes: &[f64], increment: &mut [f64]) {
        let d = self.start.len();
        for (c, increment) in increment.iter_mut().enumerate() {
            let terms = self.tableau.weights.iter().zip(slopes.chunks(d));
            let sum: f64 = terms.map(|(b, slope)| b * slope[c]).sum();
            *increment = self.time_step * sum;
        }
    }
}

impl StepEquation for AveragedStages {
    fn time_step(&mut self) -> &mut f64 {
        &mut self.time_step
    }

    /// −Π(U) W − K and 1 − ∂(−ΠW)/∂K.
    fn linearize(
        &mut self,
        slopes: &[f64],
        residual: &mut [f64],
        matrix: &mut [f64],
    ) -> Result<(), StepError> {
        self.evaluate(slopes, !matrix.is_empty())?;
        for (at, residual) in residual.iter_mut().enumerate() {
            *residual = self.values[at] - slopes[at];
        }
        let size = slopes.len();
        for (at, entry) in matrix.iter_mut().enumerate() {
            let unit = if at / size == at % size { 1.0 } else { 0.0 };
            *entry = unit - self.by_slopes[at];
        }
        Ok(())
    }

    fn change(&self, row: usize) -> f64 {
        self.unit() * self.values[row]
    }

    fn measure(&self, row: usize) -> (f64, f64, f64) {
        let state = self.start[row % self.start.len()];
        match self.is_exact {
            true => (state, 0.0, self.unit() * self.reaches[row]),
            false => (state, self.unit() * self.values[row], 0.0),
        }
    }

    fn unit(&self) -> f64 {
        self.time_step.abs()
    }
}

/// The equation of a step and its solve.
struct EnergyPreserving {
    stages: AveragedStages,
    solve: StepSolve,
}

impl EnergyPreserving {
    fn advance(&mut self, x: &[f64], increment: &mut [f64]) -> Result<usize, StepError> {
        let (stages, solve) = (&mut self.stages, &mut self.solve);
        stages.start.copy_from_slice(x);
        let mut evaluations = solve.solve(stages, x)?;
        if solve.is_by_residuals() {
            // The energy is kept as far as K is −Π(U) W: once more, without acceleration.
            stages.evaluate(&solve.unknowns, false)?;
            solve.unknowns.copy_from_slice(&stages.values);
            evaluations += 1;
        }
        stages.increment(&solve.unknowns, increment);
        Ok(evaluations)
    }
}

impl Trajectories for EnergyPreserving {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let step = self.advance(x, increment);
        taken[0].take(step, self.solve.is_rounded());
    }

    fn operations(&self) -> Option<u64> {
        let stages = &self.stages;
        let kernels = stages.tensor.operations()? + stages.gradient.operations()?;
        Some(kernels + stages.averaged + self.solve.operations())
    }

    fn tangent(&mut self, _: usize) -> Option<Vec<f64>> {
        let stages = &mut self.stages;
        let d = stages.start.len();
        if !self.solve.factor(stages) {
            return None;
        }
        let mut tangent = DMatrix::identity(d, d);
        for column in 0..d {
            let slopes = stages.by_start.iter().skip(column).step_by(d);
            let mut slopes: Vec<f64> = slopes.copied().collect();
            self.solve.factors.solve(&mut slopes);
            for (row, slope) in slopes.iter().enumerate() {
                let weight = stages.tableau.weights[row / d] * stages.time_step;
                tangent[(row % d, column)] += weight * slope;
            }
        }
        Some(row_major(&tangent))
    }

    fn restart(&mut self, _: usize) {
        self.solve.restart();
    }

    fn memory(&self, _: usize) -> Vec<f64> {
        self.solve.memory()
    }

    fn restore(&mut self, _: usize, memory: &[f64]) {
        self.solve.restore(memory);
    }
}

/// Σ_k w_k · (row k of a matrix), into `out`.
fn combine(weights: &[f64], matrix: &[f64], out: &mut [f64]) {
    // The neutral element of sums: −0 + a is a, to the bit.
    out.fill(-0.0);
    for (weight, row) in weights.iter().zip(matrix.chunks_exact(out.len())) {
        for (sum, entry) in out.iter_mut().zip(row) {
            *sum += weight * entry;
        }
    }
}

fn build(
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
    if system.expressions().is_some() {
        check_equations(stages * system.dimension())?;
    }
    let maps = [system.tensor_map()?, system.gradient_map()?];
    Ok(Arc::new(ReferenceMap {
        dimension: system.dimension(),
        properties: MapProperties {
            order: 2 * stages,
            structure: Structure::None,
            self_adjoint: Some(true),
        },
        description: format!("{} order = {order}", INFO.name),
        together: 1,
        kept_signs: Vec::new(),
        make: Box::new(move |parameters, time_step, _| {
            let stages = AveragedStages::new(&maps, stages, parameters, time_step);
            let solve = StepSolve::new(stages.slopes.len(), stages.has_jacobian());
            let solve = solve.plainly_first();
            Box::new(EnergyPreserving { stages, solve })
        }),
    }))
}

leafwise_core::built_in!(StepperPart::new(&INFO, build));

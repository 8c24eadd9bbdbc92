//! Cohen and Hairer's energy-preserving collocation: the part `energy-preserving`.

use std::sync::Arc;

use leafwise_core::part::{
    ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters, ServesNumbers,
};
use leafwise_core::quadrature::{GaussLegendre, legendre};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator, Tableau};
use leafwise_core::solver::judge::{Allowed, Verdict, Watch, largest, reach};
use leafwise_core::solver::{
    Anderson, CorrectionSize, DenseFactors, LinearIteration, StepReport, Trajectories,
    check_equations, elimination_operations, substitution_operations,
};
use leafwise_core::{
    BuildError, Evaluator, MapProperties, PoissonSystem, StepError, StepMap, Structure,
};
use nalgebra::DMatrix;

use crate::connected::{Connected, StepEquation};
use crate::reference_map::{ReferenceMap, row_major};

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
    /// −Π(U(c_i)) W_i and its derivatives by K and by x, row-major.
    values: Vec<f64>,
    by_slopes: Vec<f64>,
    by_start: Vec<f64>,
    /// Σ_k |Π_ck W_k| at each stage.
    reaches: Vec<f64>,
    averages_of_gradient: Averages,
    /// U at a node or stage, with W after it; a value there and its derivatives.
    place: Vec<f64>,
    value: Vec<f64>,
    slope: Vec<f64>,
    /// 1 − ∂(−ΠW)/∂K, its factors, and a correction of K with its scale.
    matrix: Vec<f64>,
    factors: DenseFactors,
    correction: Vec<f64>,
    scales: Vec<f64>,
    /// Whether it is not plain that K is the solution that is connected with a step of size 0; room
    /// for the path to that.
    watch: Watch,
    is_rounded: bool,
    connected: Option<Box<Connected>>,
    /// For systems without derivatives.
    anderson: Option<Anderson>,
    /// Operations of the averages, the stages and the solves.
    linear: u64,
    /// Those of one iteration.
    work: u64,
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
            matrix: vec![0.0; size * size],
            factors: DenseFactors::new(size),
            correction: vec![0.0; size],
            scales: vec![0.0; size],
            watch: Watch::NEW,
            is_rounded: false,
            connected: is_exact.then(|| Box::new(Connected::new(size))),
            anderson: (!is_exact).then(|| Anderson::new(size)),
            linear: 0,
            work: iteration_operations(d, stages, is_exact),
        }
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

    /// The averaged gradients at the current K, and their derivatives where the system has them.
    fn average(&mut self) -> Result<(), StepError> {
        let (d, s) = (self.start.len(), self.tableau.stages());
        let averages = &mut self.averages_of_gradient;
        averages.values.fill(0.0);
        averages.by_slopes.fill(0.0);
        averages.by_start.fill(0.0);
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
            if self.anderson.is_some() {
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

    /// Evaluates the stages at the current K, and their derivatives where the system has them.
    fn evaluate_stages(&mut self) -> Result<(), StepError> {
        let (d, s) = (self.start.len(), self.tableau.stages());
        self.average()?;
        for i in 0..s {
            self.place(Coefficients::Stage, i);
            let own = i * d..(i + 1) * d;
            self.place[d..].copy_from_slice(&self.averages_of_gradient.values[own.clone()]);
            self.tensor.values(&self.place, &mut self.values[own])?;
            if self.anderson.is_none() {
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
            self.reaches[row] = reach(by_w, &self.place[d..]);
        }
    }

    /// 1 − ∂(−ΠW)/∂K.
    fn assemble(&mut self) {
        let size = self.slopes.len();
        for (at, entry) in self.matrix.iter_mut().enumerate() {
            let unit = if at / size == at % size { 1.0 } else { 0.0 };
            *entry = unit - self.by_slopes[at];
        }
    }

    /// Factors it; `false` where it is singular.
    fn factor(&mut self) -> bool {
        self.assemble();
        self.factors.factor(&self.matrix)
    }

    /// −Π(U) W − K.
    fn residual(&mut self) {
        for (at, residual) in self.correction.iter_mut().enumerate() {
            *residual = self.values[at] - self.slopes[at];
        }
    }

    /// K ← −Π(U) W with Anderson's acceleration, for systems without derivatives.
    fn accelerate(&mut self) -> Result<usize, StepError> {
        let d = self.start.len();
        let t = self.time_step.abs();
        let mut iteration = LinearIteration::new(MOST_ACCELERATED);
        let mut allowed = Allowed::new(largest(&self.start) + t * largest(&self.slopes));
        if let Some(anderson) = &mut self.anderson {
            anderson.clear();
        }
        loop {
            self.evaluate_stages()?;
            self.linear += self.work;
            self.residual();
            let mut size = CorrectionSize::default();
            allowed.take(t * largest(&self.values));
            for (at, scale) in self.scales.iter_mut().enumerate() {
                *scale = self.start[at % d].abs() + allowed.scale(t * self.values[at]);
                size.take(t * self.correction[at], *scale);
            }
            if let Some(anderson) = &mut self.anderson {
                anderson.correct(&mut self.correction, &self.scales);
            }
            for (at, slope) in self.slopes.iter_mut().enumerate() {
                *slope += self.correction[at];
                size.take(t * self.correction[at], self.scales[at]);
            }
            if iteration.judge_correction(&size)? == Verdict::Converged {
                self.is_rounded = iteration.is_rounded();
                // The energy is kept as far as K is −Π(U) W: once more, without acceleration.
                self.evaluate_stages()?;
                self.linear += self.work;
                self.slopes.copy_from_slice(&self.values);
                return Ok(iteration.evaluations() + 1);
            }
        }
    }
}

impl StepEquation for EnergyPreserving {
    fn unknowns(&mut self) -> &mut [f64] {
        &mut self.slopes
    }

    fn time_step(&mut self) -> &mut f64 {
        &mut self.time_step
    }

    fn linearize(&mut self) -> Result<(&[f64], &[f64]), StepError> {
        self.evaluate_stages()?;
        self.residual();
        self.assemble();
        Ok((&self.correction, &self.matrix))
    }

    fn solve(&mut self) -> Result<usize, StepError> {
        let (d, t) = (self.start.len(), self.time_step.abs());
        let mut iteration = LinearIteration::new(MOST_EVALUATIONS);
        let mut allowed = Allowed::new(largest(&self.start) + t * largest(&self.slopes));
        loop {
            self.evaluate_stages()?;
            self.linear += self.work;
            self.residual();
            if !self.factor() {
                return Err(StepError::NonFinite {
                    what: "a correction of the stages",
                });
            }
            self.watch.take(!self.factors.is_near_identity());
            self.factors.solve(&mut self.correction);
            allowed.take(t * largest(&self.reaches));
            let mut size = CorrectionSize::default();
            for (at, slope) in self.slopes.iter_mut().enumerate() {
                let correction = self.correction[at];
                *slope += correction;
                let scale = self.start[at % d].abs() + allowed.scale(t * self.reaches[at]);
                size.take(t * correction, scale);
                size.take_way(t * *slope, scale);
            }
            self.watch.take_correction(&size);
            if iteration.judge_correction(&size)? == Verdict::Converged {
                self.is_rounded = iteration.is_rounded();
                self.watch.take_end(&size);
                return Ok(iteration.evaluations());
            }
        }
    }
}

impl EnergyPreserving {
    fn advance(&mut self, x: &[f64], increment: &mut [f64]) -> Result<usize, StepError> {
        self.start.copy_from_slice(x);
        self.watch.begin();
        let mut solved = if self.anderson.is_none() {
            self.solve()
        } else {
            self.accelerate()
        };
        let is_plain = solved.is_ok() && !self.watch.wanders();
        if let Some(mut connected) = self.connected.take_if(|_| !is_plain) {
            // K is measured against x/t.
            for (at, scale) in self.scales.iter_mut().enumerate() {
                *scale = x[at % x.len()].abs() / self.time_step.abs();
            }
            let sizes = std::mem::take(&mut self.scales);
            solved = connected.settle(solved, &sizes, self);
            (self.scales, self.connected) = (sizes, Some(connected));
        }
        let evaluations = solved?;
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
}

impl Trajectories for EnergyPreserving {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let step = self.advance(x, increment);
        taken[0].take(step, self.is_rounded);
    }

    fn operations(&self) -> Option<u64> {
        Some(self.tensor.operations()? + self.gradient.operations()? + self.linear)
    }

    fn tangent(&mut self, _: usize) -> Option<Vec<f64>> {
        let d = self.start.len();
        if self.anderson.is_some() {
            return None;
        }
        self.evaluate_stages().ok()?;
        if !self.factor() {
            return None;
        }
        let mut tangent = DMatrix::identity(d, d);
        for column in 0..d {
            let slopes = self.by_start.iter().skip(column).step_by(d);
            let mut slopes: Vec<f64> = slopes.copied().collect();
            self.factors.solve(&mut slopes);
            for (row, slope) in slopes.iter().enumerate() {
                let weight = self.tableau.weights[row / d] * self.time_step;
                tangent[(row % d, column)] += weight * slope;
            }
        }
        Some(row_major(&tangent))
    }

    fn restart(&mut self, _: usize) {
        self.slopes.fill(0.0);
        self.watch = Watch::NEW;
    }

    fn memory(&self, _: usize) -> Vec<f64> {
        [&[self.watch.memory()], self.slopes.as_slice()].concat()
    }

    fn restore(&mut self, _: usize, memory: &[f64]) {
        self.watch.restore(memory[0]);
        self.slopes.copy_from_slice(&memory[1..]);
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
        make: Box::new(move |parameters, time_step, _| {
            Box::new(EnergyPreserving::new(&maps, stages, parameters, time_step))
        }),
    }))
}

leafwise_core::built_in!(StepperPart::new(&INFO, build));

//! The vector field of the collective Hamiltonian over a realization that computes numbers.

use leafwise_core::evaluator::{Evaluator, one_by_one};
use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::{ChartMaps, Ends, RealizationMaps, StepError};

/// (x, p) ↦ (−∂K/∂p, ∂K/∂x) for K = H∘α̂_ε∘χ, from ∇K = (Dα̂ Dχ)ᵀ ∇H; `space` is the number of
/// coordinates of a point of S.
///
/// Its Jacobian, where `has_jacobian`, is J D²K with D²K = (Dα̂)ᵀ D²H Dα̂ + D²(λ·α̂), λ = ∇H. Such a Jacobian needs
/// points that are pairs (x, p) and parts that offer both second derivatives.
pub fn collective_numbers(
    gradient: SmoothMap,
    maps: RealizationMaps,
    chart: ChartMaps,
    space: usize,
    has_jacobian: bool,
) -> SmoothMap {
    let d = gradient.inputs();
    SmoothMap::from_numbers(2 * d, 2 * d, has_jacobian, move |parameters, epsilon, h| {
        Box::new(NumericField {
            maps: maps.evaluator(parameters, epsilon),
            chart: chart.evaluator(parameters, epsilon),
            has_pairs: chart.has_pairs(),
            gradient: gradient.evaluator(parameters, epsilon, h),
            ends: vec![0.0; 3 * d],
            point: vec![0.0; space],
            alpha: vec![0.0; d],
            slope: vec![0.0; d],
            tangents: vec![0.0; 2 * d * space],
            of_chart: vec![0.0; if chart.has_pairs() { 0 } else { space * 2 * d }],
            source: vec![0.0; d * 2 * d],
            of_energy: vec![0.0; if has_jacobian { d * d } else { 0 }],
            of_source: vec![0.0; if has_jacobian { 4 * d * d } else { 0 }],
            image: vec![0.0; d],
            linear: 0,
        })
    })
    // Curves start from those before.
    .for_one_trajectory()
}

struct NumericField {
    maps: Box<dyn Evaluator>,
    chart: Box<dyn Evaluator>,
    has_pairs: bool,
    /// ∇H and D²H.
    gradient: SmoothMapEvaluator,
    /// χ(x, p), base, offset and increment, α̂ and ∇H there, Dβ̂ and D(α̂ − β̂).
    point: Vec<f64>,
    ends: Vec<f64>,
    alpha: Vec<f64>,
    slope: Vec<f64>,
    tangents: Vec<f64>,
    /// Dχ, and D(α̂∘χ), d × 2d.
    of_chart: Vec<f64>,
    source: Vec<f64>,
    /// D²H, D²(λ·α̂), and a column of D²H Dα̂.
    of_energy: Vec<f64>,
    of_source: Vec<f64>,
    image: Vec<f64>,
    /// Operations of the products.
    linear: u64,
}

impl NumericField {
    /// Evaluates α̂, ∇H and D(α̂∘χ) at (x, p).
    fn evaluate(&mut self, z: &[f64]) -> Result<(), StepError> {
        let (d, space) = (self.alpha.len(), self.point.len());
        self.chart.values(z, &mut self.point)?;
        self.maps.values(&self.point, &mut self.ends)?;
        self.maps.jacobians(&self.point, &mut self.tangents)?;
        let ends = Ends::of(&self.ends);
        for (i, alpha) in self.alpha.iter_mut().enumerate() {
            *alpha = ends.source(i);
        }
        self.gradient.values(&self.alpha, &mut self.slope)?;
        self.linear += (d * space + 4 * d * d) as u64;
        // Dα̂ = Dβ̂ + D(α̂ − β̂), in place of the first.
        let (target, increment) = self.tangents.split_at_mut(d * space);
        for (target, increment) in target.iter_mut().zip(increment) {
            *target += *increment;
        }
        if self.has_pairs {
            self.source.copy_from_slice(target);
            return Ok(());
        }
        self.chart.jacobians(z, &mut self.of_chart)?;
        self.linear += 4 * (d * d * space) as u64;
        for (at, entry) in self.source.iter_mut().enumerate() {
            let row = &target[at / (2 * d) * space..][..space];
            let column = self.of_chart.iter().skip(at % (2 * d)).step_by(2 * d);
            *entry = row.iter().zip(column).map(|(a, b)| a * b).sum();
        }
        Ok(())
    }
}

/// Component k of Mᵀ v for a row-major matrix M of so many columns.
fn transposed(matrix: &[f64], columns: usize, vector: &[f64], k: usize) -> f64 {
    let column = matrix.iter().skip(k).step_by(columns);
    column.zip(vector).map(|(m, v)| m * v).sum()
}

impl NumericField {
    /// J ∇K.
    fn value(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.evaluate(z)?;
        let d = self.alpha.len();
        for i in 0..d {
            out[i] = -transposed(&self.source, 2 * d, &self.slope, d + i);
            out[d + i] = transposed(&self.source, 2 * d, &self.slope, i);
        }
        Ok(())
    }

    /// J D²K.
    fn jacobian(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.evaluate(z)?;
        let d = self.alpha.len();
        self.gradient.jacobians(&self.alpha, &mut self.of_energy)?;
        self.maps
            .hessian(&self.point, &self.slope, &mut self.of_source)?;
        self.linear += (12 * d * d * d) as u64;
        for k in 0..2 * d {
            // A column of D²H Dα̂, then of D²K.
            for (i, image) in self.image.iter_mut().enumerate() {
                let row = &self.of_energy[i * d..][..d];
                let column = self.source.iter().skip(k).step_by(2 * d);
                *image = row.iter().zip(column).map(|(a, b)| a * b).sum();
            }
            let second = |row: usize| {
                let own = transposed(&self.source, 2 * d, &self.image, row);
                own + self.of_source[row * 2 * d + k]
            };
            for i in 0..d {
                out[i * 2 * d + k] = -second(d + i);
                out[(d + i) * 2 * d + k] = second(i);
            }
        }
        Ok(())
    }
}

impl Evaluator for NumericField {
    fn values(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        one_by_one(2 * self.alpha.len(), z, out, |z, out| self.value(z, out))
    }

    fn jacobians(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        one_by_one(2 * self.alpha.len(), z, out, |z, out| self.jacobian(z, out))
    }

    fn restart(&mut self) {
        self.maps.restart();
    }

    fn memory(&self) -> Vec<f64> {
        self.maps.memory()
    }

    fn restore(&mut self, memory: &[f64]) {
        self.maps.restore(memory);
    }

    fn operations(&self) -> Option<u64> {
        let maps = self.maps.operations()? + self.chart.operations()?;
        Some(maps + self.gradient.operations()? + self.linear)
    }
}

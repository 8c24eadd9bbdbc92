//! The vector field of the collective Hamiltonian over a realization that computes numbers.

use leafwise_core::runge_kutta::{MapWorker, SmoothMap, SmoothMapEvaluator};
use leafwise_core::{ChartMaps, ChartWorker, Ends, RealizationMaps, RealizationWorker, StepError};
use nalgebra::{DMatrix, DVector};

/// (x, p) ↦ (−∂K/∂p, ∂K/∂x) for K = H∘α̂_ε∘χ, from ∇K = (Dα̂ Dχ)ᵀ ∇H; `space` is the number of
/// coordinates of a point of S.
///
/// Its Jacobian, where `has_jacobian`, is J D²K with D²K = (Dα̂)ᵀ D²H Dα̂ + D²(λ·α̂), λ = ∇H: for points
/// that are pairs (x, p) and parts that offer both second derivatives.
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
            maps: maps.worker(parameters, epsilon),
            chart: chart.worker(parameters, epsilon),
            has_pairs: chart.has_pairs(),
            gradient: gradient.evaluator(parameters, epsilon, h),
            ends: Ends::new(d),
            point: vec![0.0; space],
            alpha: vec![0.0; d],
            slope: vec![0.0; d],
            target: vec![0.0; d * space],
            increment: vec![0.0; d * space],
            linear: 0,
        })
    })
}

struct NumericField {
    maps: Box<dyn RealizationWorker>,
    chart: Box<dyn ChartWorker>,
    has_pairs: bool,
    /// ∇H and D²H.
    gradient: SmoothMapEvaluator,
    ends: Ends,
    /// χ(x, p), α̂ and ∇H there, Dβ̂ and D(α̂ − β̂).
    point: Vec<f64>,
    alpha: Vec<f64>,
    slope: Vec<f64>,
    target: Vec<f64>,
    increment: Vec<f64>,
    /// Operations of the products.
    linear: u64,
}

impl NumericField {
    /// Evaluates α̂, ∇H and D(α̂∘χ), d × 2d, at (x, p).
    fn evaluate(&mut self, z: &[f64]) -> Result<DMatrix<f64>, StepError> {
        let (d, space) = (self.alpha.len(), self.point.len());
        let (x, p) = z.split_at(d);
        self.chart.point(x, p, &mut self.point)?;
        self.maps.ends(&self.point, &mut self.ends)?;
        self.maps.tangents(&mut self.target, &mut self.increment)?;
        for (i, alpha) in self.alpha.iter_mut().enumerate() {
            *alpha = self.ends.base[i] + self.ends.offset[i] + self.ends.increment[i];
        }
        self.gradient.value(&self.alpha, &mut self.slope)?;
        let source = DMatrix::from_fn(d, space, |i, k| {
            self.target[i * space + k] + self.increment[i * space + k]
        });
        self.linear += (d * space + 4 * d * d) as u64;
        if self.has_pairs {
            return Ok(source);
        }
        let mut entries = vec![0.0; space * 2 * d];
        self.chart.tangent(&mut entries)?;
        self.linear += 4 * (d * d * space) as u64;
        Ok(source * DMatrix::from_row_slice(space, 2 * d, &entries))
    }
}

impl MapWorker for NumericField {
    fn value(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let source = self.evaluate(z)?;
        let slope = source.transpose() * DVector::from_column_slice(&self.slope);
        let d = self.alpha.len();
        for i in 0..d {
            out[i] = -slope[d + i];
            out[d + i] = slope[i];
        }
        Ok(())
    }

    fn jacobian(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let source = self.evaluate(z)?;
        let d = self.alpha.len();
        let mut entries = vec![0.0; d * d];
        self.gradient.jacobian(&self.alpha, &mut entries)?;
        let of_energy = DMatrix::from_row_slice(d, d, &entries);
        let mut entries = vec![0.0; 4 * d * d];
        self.maps.source_hessian(&self.slope, &mut entries)?;
        let of_source = DMatrix::from_row_slice(2 * d, 2 * d, &entries);
        let hessian = source.transpose() * of_energy * &source + of_source;
        self.linear += (12 * d * d * d) as u64;
        for i in 0..d {
            for k in 0..2 * d {
                out[i * 2 * d + k] = -hessian[(d + i, k)];
                out[(d + i) * 2 * d + k] = hessian[(i, k)];
            }
        }
        Ok(())
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

//! Both ends of a realization's points (y, p), and the tensor, as numbers.

use leafwise_core::{
    ChartMaps, Ends, Evaluator, PoissonSystem, RealizationData, StepError, realization_evaluator,
};
use nalgebra::DMatrix;

use crate::error::LearnError;

/// Singular values of Π(y) below this part of the largest are 0.
const RANK: f64 = 1e-10;

/// α̂, β̂ and Π for fixed parameters and ε.
pub(crate) struct Geometry {
    chart: Box<dyn Evaluator>,
    maps: Box<dyn Evaluator>,
    tensor: Box<dyn Evaluator>,
    epsilon: f64,
    dimension: usize,
    space: usize,
}

/// α̂ − β̂ and (α̂ + β̂)/2.
pub(crate) struct EndPair {
    pub increment: Vec<f64>,
    pub mean: Vec<f64>,
}

/// −εΠ(y), and an orthonormal basis of its range, d × r.
pub(crate) struct TensorAt {
    pub matrix: DMatrix<f64>,
    pub range: DMatrix<f64>,
}

impl Geometry {
    pub fn new(
        system: &PoissonSystem,
        realization: &dyn RealizationData,
        epsilon: f64,
    ) -> Result<Self, LearnError> {
        let parameters = system.parameter_values();
        let no_chart = || LearnError::NoChart {
            realization: realization.describe(),
        };
        if realization.abilities().ends.is_none() {
            return Err(no_chart());
        }
        let chart = ChartMaps::of(realization, parameters.len())?.ok_or_else(no_chart)?;
        Ok(Self {
            chart: chart.evaluator(&parameters, epsilon),
            maps: realization_evaluator(realization, &parameters, epsilon)?,
            tensor: Box::new(system.tensor_map()?.evaluator(&parameters, 1.0, 1.0)),
            epsilon,
            dimension: system.dimension(),
            space: realization.space_dimension(),
        })
    }

    /// Both ends of (y, p).
    pub fn ends(&mut self, y: &[f64], p: &[f64]) -> Result<EndPair, StepError> {
        let d = self.dimension;
        let point: Vec<f64> = y.iter().chain(p).copied().collect();
        let mut z = vec![0.0; self.space];
        self.chart.values(&point, &mut z)?;
        let mut values = vec![0.0; 3 * d];
        self.maps.values(&z, &mut values)?;
        let ends = Ends::of(&values);
        let mean = (0..d).map(|i| ends.base[i] + (ends.offset[i] + ends.increment[i] / 2.0));
        Ok(EndPair {
            mean: mean.collect(),
            increment: ends.increment.to_vec(),
        })
    }

    /// The tensor at y.
    pub fn tensor(&mut self, y: &[f64]) -> Result<TensorAt, StepError> {
        let d = self.dimension;
        let mut matrix = DMatrix::zeros(d, d);
        for j in 0..d {
            let mut point = y.to_vec();
            point.resize(2 * d, 0.0);
            point[d + j] = self.epsilon;
            self.tensor
                .values(&point, matrix.column_mut(j).as_mut_slice())?;
        }
        let singular = matrix.clone().svd(true, false);
        let largest = singular.singular_values.max();
        let directions: Vec<_> = (0..d)
            .filter(|k| singular.singular_values[*k] > RANK * largest)
            .collect();
        let range = match &singular.u {
            Some(u) => u.select_columns(&directions),
            None => DMatrix::zeros(d, 0),
        };
        Ok(TensorAt { matrix, range })
    }
}

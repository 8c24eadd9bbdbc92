//! Contact maps, by steps of a homogeneous Hamiltonian seen where the scale is 1.
//!
//! The motion is q' = ∂H/∂p, p' = −∂H/∂q − p ∂H/∂s, s' = p·∂H/∂p − H.
//!
//! These are the motion of K(q, P, s, r) = r H(q, P/r, s) over the one-form P·dq − r ds, seen at p = P/r. K is homogeneous in
//! P and r. A Poisson map that is homogeneous too descends to (q, p, s) as a contact map. From r = 1 it multiplies the contact
//! form ds − p·dq by the inverse of the r that it leads to.
//!
//! Cf. A. Bravetti, H. Cruz, D. Tapias, *Contact Hamiltonian mechanics*, Annals of Physics 376 (2017).

use std::sync::Arc;

use crate::error::StepError;
use crate::solver::{
    Differential, MapAbilities, MapProperties, Setting, SolverStatistics, StepMap, Stepper,
    Structure,
};

/// Coordinates of the homogeneous system that are p and r.
#[derive(Clone, Debug, PartialEq)]
pub struct Homogeneous {
    /// The coordinates P.
    pub momenta: Vec<usize>,
    /// The coordinate r.
    pub scale: usize,
}

/// Steps of a homogeneous map from r = 1, with P and r divided by the r that they lead to: states are (q, p, s) with 1 behind
/// them.
pub struct ContactMap {
    map: Arc<dyn StepMap>,
    of: Arc<Homogeneous>,
}

impl ContactMap {
    /// The contact map of a map that commutes with multiples of (P, r), as maps over a constant tensor do that are made of H
    /// alone.
    pub fn new(map: Arc<dyn StepMap>, of: Homogeneous) -> Self {
        let of = Arc::new(of);
        Self { map, of }
    }
}

impl StepMap for ContactMap {
    fn dimension(&self) -> usize {
        self.map.dimension()
    }

    fn properties(&self) -> MapProperties {
        let properties = self.map.properties();
        MapProperties {
            structure: match properties.structure {
                Structure::Exact => Structure::Contact,
                _ => Structure::None,
            },
            ..properties
        }
    }

    fn describe(&self) -> String {
        format!("{} of the homogeneous system", self.map.describe())
    }

    fn abilities(&self) -> MapAbilities<'_> {
        self.map.abilities().kernels_alone()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        Box::new(ContactStepper {
            stepper: self.map.stepper(lanes, parameters, epsilon, h),
            of: Arc::clone(&self.of),
            ends: vec![End::default(); lanes],
        })
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        Box::new(ContactDifferential {
            inner: self.map.differential(parameters, epsilon, h),
            of: Arc::clone(&self.of),
            dimension: self.dimension(),
            start: Vec::new(),
            end: End::default(),
        })
    }
}

/// Where the last step of a trajectory has led to.
#[derive(Clone, Default)]
struct End {
    /// p.
    momenta: Vec<f64>,
    /// r, from 1.
    scale: f64,
}

impl End {
    /// Divides the step's end by its r.
    ///
    /// Places are those of one lane of a structure of arrays.
    fn divide(
        &mut self,
        of: &Homogeneous,
        (x, low, increment): (&[f64], &[f64], &mut [f64]),
        place: impl Fn(usize) -> usize,
    ) -> Result<(), StepError> {
        let scale = place(of.scale);
        let change = (x[scale] - 1.0) + low[scale] + increment[scale];
        self.scale = 1.0 + change;
        // No number is not positive either.
        if !(self.scale > 0.0 && self.scale.is_finite()) {
            return Err(StepError::NonFinite {
                what: "the scale r of the contact form",
            });
        }
        self.momenta.clear();
        for momentum in of.momenta.iter().map(|momentum| place(*momentum)) {
            let start = x[momentum] + low[momentum];
            increment[momentum] = (increment[momentum] - start * change) / self.scale;
            self.momenta.push(start + increment[momentum]);
        }
        increment[scale] = 1.0 - x[scale] - low[scale];
        Ok(())
    }

    /// v ← of (q, p, s) at r = 1, of a vector at the undivided end.
    fn project(&self, of: &Homogeneous, vector: &mut [f64]) {
        let along = vector[of.scale];
        for (momentum, p) in of.momenta.iter().zip(&self.momenta) {
            vector[*momentum] = (vector[*momentum] - p * along) / self.scale;
        }
        vector[of.scale] = 0.0;
    }

    /// The transpose of [`project`](Self::project).
    fn lift(&self, of: &Homogeneous, covector: &mut [f64]) {
        let mut along = 0.0;
        for (momentum, p) in of.momenta.iter().zip(&self.momenta) {
            covector[*momentum] /= self.scale;
            along -= p * covector[*momentum];
        }
        covector[of.scale] = along;
    }
}

struct ContactStepper {
    stepper: Box<dyn Stepper>,
    of: Arc<Homogeneous>,
    /// One a lane.
    ends: Vec<End>,
}

impl Stepper for ContactStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        self.stepper.increment(x, low, increment, outcome);
        let lanes = self.ends.len();
        for (lane, end) in self.ends.iter_mut().enumerate() {
            if outcome[lane].is_err() {
                continue;
            }
            let place = |coordinate: usize| coordinate * lanes + lane;
            let divided = end.divide(&self.of, (x, low, &mut *increment), place);
            if divided.is_err() {
                let places = increment.iter_mut().skip(lane).step_by(lanes);
                places.for_each(|place| *place = 0.0);
            }
            outcome[lane] = divided;
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        self.stepper.solution(lane)
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let mut matrix = self.stepper.tangent(lane)?;
        let (of, end) = (&self.of, &self.ends[lane]);
        let d = (1..=matrix.len()).find(|d| d * d == matrix.len())?;
        for column in 0..d {
            let mut vector: Vec<f64> = matrix.iter().skip(column).step_by(d).copied().collect();
            end.project(of, &mut vector);
            let places = matrix.iter_mut().skip(column).step_by(d);
            places.zip(vector).for_each(|(place, entry)| *place = entry);
        }
        Some(matrix)
    }

    fn restart(&mut self) {
        self.stepper.restart();
    }

    fn set(&mut self, setting: Setting<'_>) -> bool {
        self.stepper.set(setting)
    }

    fn statistics(&self) -> SolverStatistics {
        self.stepper.statistics()
    }

    fn memory(&self) -> Vec<f64> {
        self.stepper.memory()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        self.stepper.restore(memory)
    }
}

/// Differential of a contact map by that of the homogeneous one.
struct ContactDifferential {
    inner: Box<dyn Differential>,
    of: Arc<Homogeneous>,
    dimension: usize,
    /// p where the step begins.
    start: Vec<f64>,
    end: End,
}

impl Differential for ContactDifferential {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        let momenta = self.of.momenta.iter();
        self.start = momenta.map(|at| x[*at] + low[*at]).collect();
        self.inner.step(x, low, increment)?;
        self.end
            .divide(&self.of, (x, low, increment), |coordinate| coordinate)
    }

    fn push(&mut self, tangents: &mut [f64], parameters: &[f64]) -> Result<(), StepError> {
        let d = self.dimension;
        tangents
            .chunks_exact_mut(d)
            .for_each(|vector| vector[self.of.scale] = 0.0);
        self.inner.push(tangents, parameters)?;
        tangents
            .chunks_exact_mut(d)
            .for_each(|vector| self.end.project(&self.of, vector));
        Ok(())
    }

    fn pull(&mut self, covector: &mut [f64], gradient: &mut [f64]) -> Result<(), StepError> {
        self.end.lift(&self.of, covector);
        self.inner.pull(covector, gradient)?;
        covector[self.of.scale] = 0.0;
        Ok(())
    }

    /// Of the covectors at the start that are 0 along (P, r), the step makes those at its end.
    fn pull_inverse(
        &mut self,
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        let start = self.of.momenta.iter().zip(&self.start);
        covector[self.of.scale] = -start.map(|(at, p)| covector[*at] * p).sum::<f64>();
        self.inner.pull_inverse(covector, gradient)?;
        for momentum in &self.of.momenta {
            covector[*momentum] *= self.end.scale;
        }
        covector[self.of.scale] = 0.0;
        Ok(())
    }

    fn knows_parameters(&self) -> bool {
        self.inner.knows_parameters()
    }

    fn operations(&self) -> Option<u64> {
        self.inner.operations()
    }
}

//! The Taylor coefficients of a motion, in loops as its field.
//!
//! x(t) = Σ x_k tᵏ with x_{k+1} = f_k/(k + 1). Here f_k is the coefficient of the field along x_0, …, x_k: code of a site and
//! of a pair of so many times the families, one for each order. A pair keeps nothing between two orders, and forms lower
//! coefficients anew. So an order p costs p³/6 products for each product of the field, where a formula that is written out
//! takes p²/2 and room for every pair.

use std::sync::Arc;

use leafwise_expression::Expression;

use super::curve::CurveOfSites;
use super::system::BodySystem;
use super::values::{Slopes, SlopesCode};
use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::runge_kutta::SmoothMap;
use crate::system::Jet;

impl BodySystem {
    /// The coefficients of the motion to order p.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no series, or one that is too long.
    pub(super) fn jet(&self, order: usize) -> Result<Jet, BuildError> {
        let moving = self.moving();
        // A metric that moves multiplies every coefficient of the gradient.
        let is_constant = self.rests(&moving) && self.forces.damping.is_none();
        let orders = (0..order).map(|k| {
            let curve = CurveOfSites::new(&self.shape, k, &moving);
            // A tensor at rest takes the last coefficient of the gradient alone.
            let from = if is_constant { k } else { 0 };
            let code = SlopesCode::along(
                &self.hamiltonian,
                (&curve, from),
                &moving,
                self.parameters.len(),
                |graph, x, gradient| self.velocities(graph, x, gradient),
            )?;
            Ok(Arc::new(code))
        });
        let orders: Vec<Arc<SlopesCode>> = orders.collect::<Result<_, BuildError>>()?;
        let d = self.shape.dimension();
        let sums = self.hamiltonian.sums.iter();
        let mut formulas = sums
            .flat_map(|sum| [&sum.site, &sum.pair])
            .chain(self.bracket.iter().map(|(_, entry)| entry))
            .chain(self.forces.formulas())
            .chain([&self.hamiltonian.outer]);
        Ok(Jet {
            has_seams: formulas.any(Expression::has_seams),
            rounding: self.bounds()?,
            map: SmoothMap::from_numbers(d, order * d, false, move |parameters, epsilon, h| {
                let slopes = orders.iter().map(|code| Slopes::new(code, 1, parameters));
                Box::new(JetOfBodies {
                    slopes: slopes.collect(),
                    work: orders.iter().map(|code| code.work()).sum(),
                    unit: epsilon * h,
                    coefficients: vec![0.0; (orders.len() + 1) * d],
                    field: vec![0.0; d],
                    operations: 0,
                })
            }),
        })
    }
}

/// One thread's coefficients of a motion.
struct JetOfBodies {
    /// f_0, f_1, ….
    slopes: Vec<Slopes>,
    /// Operations of all, and of all evaluations so far.
    work: u64,
    operations: u64,
    /// The unit of time h: coefficients are those of (t/h)ᵏ.
    unit: f64,
    /// x_0, x_1, …, and a coefficient of the field.
    coefficients: Vec<f64>,
    field: Vec<f64>,
}

impl Evaluator for JetOfBodies {
    fn values(&mut self, points: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let d = self.field.len();
        let size = self.slopes.len() * d;
        for (point, out) in points.chunks_exact(d).zip(out.chunks_exact_mut(size)) {
            self.coefficients[..d].copy_from_slice(point);
            for (k, slopes) in self.slopes.iter_mut().enumerate() {
                let (known, next) = self.coefficients.split_at_mut((k + 1) * d);
                slopes.evaluate(known, &mut self.field);
                let share = self.unit / (k + 1) as f64;
                for (next, f) in next.iter_mut().zip(&self.field) {
                    *next = share * f;
                }
            }
            out.copy_from_slice(&self.coefficients[d..]);
            self.operations += self.work;
        }
        Ok(())
    }

    fn jacobians(&mut self, _points: &[f64], _out: &mut [f64]) -> Result<(), StepError> {
        Err(StepError::NoTangent)
    }

    fn operations(&self) -> Option<u64> {
        Some(self.operations)
    }
}

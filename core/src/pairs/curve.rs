//! Taylor coefficients of the code of sites and pairs along a curve.

use leafwise_expression::series::along_curve;
use leafwise_expression::{Arithmetic, Graph, Term};

use super::BodyShape;
use crate::error::BuildError;

/// x(t) = x_0 + x_1 t + … + x_k tᵏ: its coefficients stand one after the other, as families of one longer shape.
#[derive(Clone, Debug)]
pub(super) struct CurveOfSites {
    /// The shape of x.
    pub(super) shape: BodyShape,
    /// k.
    pub(super) order: usize,
    /// Whether each family moves: of those at rest x_1, x_2, … are 0.
    moving: Vec<bool>,
}

impl CurveOfSites {
    /// A point, the curve of order 0.
    pub(super) fn point(shape: &BodyShape) -> Self {
        Self::new(shape, 0, &[])
    }

    /// A curve along which these families move.
    pub(super) fn new(shape: &BodyShape, order: usize, moving: &[usize]) -> Self {
        Self {
            order,
            moving: (0..shape.families).map(|f| moving.contains(&f)).collect(),
            shape: shape.clone(),
        }
    }

    /// The shape of all coefficients.
    pub(super) fn whole(&self) -> BodyShape {
        BodyShape {
            families: self.shape.families * (self.order + 1),
            ..self.shape.clone()
        }
    }

    /// The coefficients of the coordinates of a site by orders, of rows of all.
    pub(super) fn coordinates(&self, graph: &mut Graph, rows: &[Term]) -> Vec<Vec<Term>> {
        let zero = graph.zero();
        let of_order = |(order, own): (usize, &[Term])| {
            let own = own.iter().zip(&self.moving);
            let of_family = |(row, moves): (&Term, &bool)| match order == 0 || *moves {
                true => row.clone(),
                false => zero.clone(),
            };
            own.map(of_family).collect()
        };
        let orders = rows.chunks_exact(self.shape.families).enumerate();
        orders.map(of_order).collect()
    }

    /// Puts numbers that rest behind the coefficients of others.
    pub(super) fn add_resting(
        &self,
        graph: &mut Graph,
        coefficients: &mut [Vec<Term>],
        resting: &[Term],
    ) {
        let zero = graph.zero();
        for (order, own) in coefficients.iter_mut().enumerate() {
            match order {
                0 => own.extend_from_slice(resting),
                _ => own.extend(resting.iter().map(|_| zero.clone())),
            }
        }
    }

    /// The coefficients, order after order, of code that `write` writes of inputs; `inputs` are theirs.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a function has no series; those of `write`.
    pub(super) fn coefficients(
        &self,
        graph: &mut Graph,
        inputs: &[Vec<Term>],
        write: impl FnOnce(&mut Graph, &[Term]) -> Result<Vec<Term>, BuildError>,
    ) -> Result<Vec<Vec<Term>>, BuildError> {
        if self.order == 0 {
            return Ok(vec![write(graph, &inputs[0])?]);
        }
        let mut code = Graph::compilable();
        let x: Vec<Term> = (0..inputs[0].len()).map(|at| code.input(at)).collect();
        let terms = write(&mut code, &x)?;
        code.unless_refused(())?;
        Ok(along_curve(graph, (&code, &terms), inputs)?)
    }
}

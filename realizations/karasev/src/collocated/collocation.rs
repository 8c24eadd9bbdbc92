//! A tensor's field with the nodes at which curves are collocated.

use leafwise_expression::Kernel;

use super::curve::Curve;
use super::evaluator::FEWEST_POINTS;
use super::field::Field;

/// Where the automatic choice gives up: the curve is then too long for its chart.
const MOST_POINTS: usize = 24;

/// Curves at `points` nodes, or at as many as the step needs.
#[derive(Clone, Debug)]
pub(super) struct Collocation {
    pub(super) field: Field,
    pub(super) points: Option<usize>,
}

impl Collocation {
    pub(super) fn dimension(&self) -> usize {
        self.field.dimension
    }

    pub(super) fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        self.field.kernels()
    }

    /// A curve, at first at its fewest nodes.
    pub(super) fn curve(&self, parameters: &[f64]) -> Curve {
        let points = self.points.unwrap_or(FEWEST_POINTS);
        Curve::new(&self.field, parameters, points)
    }

    /// How many nodes may be added, where their number is open.
    pub(super) fn most_points(&self) -> Option<usize> {
        match self.points {
            Some(_) => None,
            None => Some(MOST_POINTS),
        }
    }
}

//! The Cayley chart R = (1 − ½\[q\]×)⁻¹(1 + ½\[q\]×), q = εp: rational, for every q.

use leafwise_core::BuildError;
use leafwise_core::realization::{SourceRecursion, SourceSeriesIn};
use leafwise_expression::{
    AlgebraError, Arithmetic, DifferentialAlgebra, Function, Graph, Rational, Term,
};

use crate::tensor::RotationTensor;
use crate::vector::{cross, dot, times};

/// The part of α even in q without x: ¼ q (q·x).
pub(crate) fn even_part(graph: &mut Graph, x: &[Term], q: &[Term]) -> Vec<Term> {
    let along = dot(graph, q, x);
    let quarter = graph.scale(&Rational::new(1, 4), &along);
    times(graph, &quarter, q)
}

/// (1, q/2)/√(1 + θ²/4), the quaternion of the Cayley map.
pub(crate) fn quaternion(graph: &mut Graph, q: &[Term]) -> Result<Vec<Term>, AlgebraError> {
    let square = dot(graph, q, q);
    let one = graph.one();
    let norm = graph.combine(&[
        (Rational::one(), one.clone()),
        (Rational::new(1, 4), square),
    ]);
    let norm = graph.apply(Function::Sqrt, &norm)?;
    let scalar = graph.divide(&one, &norm)?;
    let half = graph.scale(&Rational::new(1, 2), &scalar);
    let mut quaternion = vec![scalar];
    quaternion.extend(times(graph, &half, q));
    Ok(quaternion)
}

/// The coefficients of hᵏ in α = x − ½ x×q + ¼ q (q·x) along q(h) = λ p(h): a finite convolution.
#[derive(Clone, Debug)]
pub struct CayleySeries {
    tensor: RotationTensor,
}

impl CayleySeries {
    /// The series for a tensor of so(3)*.
    pub fn new(tensor: RotationTensor) -> Self {
        Self { tensor }
    }
}

impl<A: DifferentialAlgebra> SourceSeriesIn<A> for CayleySeries {
    fn start(&self, algebra: &mut A) -> Result<Box<dyn SourceRecursion<A>>, BuildError> {
        let mut factor = algebra.formed(3, |ring| {
            Ok::<_, BuildError>(vec![self.tensor.factor(ring)?])
        })?;
        Ok(Box::new(Recursion {
            factor: factor.swap_remove(0),
            x: (0..3).map(|i| algebra.coordinate(i)).collect(),
            q: Vec::new(),
            along: Vec::new(),
        }))
    }
}

struct Recursion<E> {
    /// λ.
    factor: E,
    x: Vec<E>,
    /// q_1, q_2, …
    q: Vec<Vec<E>>,
    /// q_1·x, q_2·x, …
    along: Vec<E>,
}

impl<A: DifferentialAlgebra> SourceRecursion<A> for Recursion<A::Element> {
    fn push(&mut self, algebra: &mut A, p: Vec<A::Element>) -> Result<Vec<A::Element>, BuildError> {
        let q = times(algebra, &self.factor, &p);
        self.along.push(dot(algebra, &q, &self.x));
        let moment = cross(algebra, &self.x, &q);
        self.q.push(q);
        let orders = self.q.len();
        let mut alpha = Vec::with_capacity(3);
        for i in 0..3 {
            let mut terms = vec![(Rational::new(-1, 2), moment[i].clone())];
            // q_a (q_b·x) with a + b = k; both lists start at order 1.
            for a in 0..orders.saturating_sub(1) {
                let product = algebra.multiply(&self.q[a][i], &self.along[orders - 2 - a]);
                terms.push((Rational::new(1, 4), product));
            }
            alpha.push(algebra.combine(&terms));
        }
        Ok(alpha)
    }
}

//! The Taylor coefficients of a system's motion as one kernel.

use leafwise_expression::graph::lift;
use leafwise_expression::series::jet;
use leafwise_expression::{Arithmetic, DifferentialAlgebra, Graph, Kernel, Rational, Ring, Term};

use super::agreement::Agreement;
use super::rounding::FieldRounding;
use super::{PoissonSystem, SystemFormulas};
use crate::error::BuildError;
use crate::runge_kutta::SmoothMap;

/// Products of terms that expanding a field may take.
const MOST_PRODUCTS: u64 = 1 << 16;

/// The order at which two forms of the field are compared.
const TRIED: usize = 4;

/// The motion's Taylor series, and its field in the same form.
pub struct MotionSeries {
    /// x ↦ (x_1, …, x_p) with x(t) = Σ x_k (t/h)ᵏ the motion through x, x_k after x_{k−1}; h is the evaluator's.
    pub jet: SmoothMap,
    /// x ↦ ẋ.
    pub field: SmoothMap,
    /// Its rounding errors.
    pub rounding: FieldRounding,
    /// Whether the field may jump.
    pub has_seams: bool,
}

impl PoissonSystem {
    /// Taylor series of the motion to order p: of formulas, or of numbers that offer them.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or a derivative has no code. A jet longer than a kernel gives the same
    /// error. [`BuildError::NotOffered`] for numbers without series: it names `part`.
    pub fn motion_series(
        &self,
        part: &'static str,
        order: usize,
    ) -> Result<MotionSeries, BuildError> {
        match self.opaque().and_then(|system| system.numbers.jets()) {
            None => self.formulas(part)?.motion_series(order),
            Some(make) => {
                let jet = make(order)?;
                Ok(MotionSeries {
                    jet: jet.map,
                    field: self.field_map()?,
                    rounding: jet.rounding,
                    has_seams: jet.has_seams,
                })
            }
        }
    }
}

impl SystemFormulas {
    /// Taylor series of the motion to order p. The field is taken as written or expanded in exact algebra, whichever
    /// has the shorter jet.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or a derivative has no code. A jet longer than a kernel gives the same
    /// error.
    fn motion_series(&self, order: usize) -> Result<MotionSeries, BuildError> {
        let mut graph = Graph::compilable();
        let x: Vec<Term> = (0..self.dimension()).map(|i| graph.input(i)).collect();
        let mut field = self.vector_field(&mut graph, &x)?;
        graph.unless_refused(())?;
        if let Some(expanded) = self.expanded_field(&mut graph)
            && self.agreement(&graph, &expanded, &field) == Agreement::Same
            && self.jet_work(&graph, &expanded)? < self.jet_work(&graph, &field)?
        {
            field = expanded;
        }
        let parameters = self.parameters().len();
        let rounding = FieldRounding::of(&graph, &field);
        let jet = jet(&mut graph, &field, order)?.concat();
        let compile =
            |terms: &[Term]| SmoothMap::compile_values(&graph, terms, parameters, x.len());
        Ok(MotionSeries {
            jet: compile(&jet),
            field: compile(&field),
            rounding,
            has_seams: self.has_seams(),
        })
    }

    /// The field by way of the exact ring, where it is short enough.
    fn expanded_field(&self, graph: &mut Graph) -> Option<Vec<Term>> {
        let d = self.dimension();
        let mut ring = Ring::limited(d, MOST_PRODUCTS);
        let x: Vec<_> = (0..d).map(|i| ring.coordinate(i)).collect();
        let hamiltonian = self.hamiltonian();
        let energy = hamiltonian.evaluate_in(&mut ring, &mut |_, at| Ok(x[at].clone()));
        let gradient = ring.gradient(&energy.ok()?).ok()?;
        let field = self.motion_reversed(&mut ring, &x, gradient).ok()?;
        let minus = graph.constant(&-Rational::one());
        let outputs: Vec<_> = field
            .into_iter()
            .map(|f| vec![(minus.clone(), f)])
            .collect();
        let x: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        lift(graph, &ring, &outputs, &x).ok()
    }

    /// Operations of a short jet of a field.
    fn jet_work(&self, graph: &Graph, field: &[Term]) -> Result<u64, BuildError> {
        let mut graph = graph.clone();
        let jet = jet(&mut graph, field, TRIED)?.concat();
        let kernel = Kernel::compile(&graph, &jet, self.parameters().len(), field.len());
        Ok(kernel.step_operations().work())
    }
}

//! Shadow Hamiltonian of a step map: the one whose flow the map is.
//!
//! Let Φ_t = exp(t L_{H̃}) be the map, with L_F = {F, ·} and t = εh. The shadow H̃ = F_1 + t F_2 + t² F_3 + … with
//! F_1 = H is a formal series. Steps keep its first terms far better than H (E. Hairer, C. Lubich, G. Wanner,
//! *Geometric Numerical Integration*, section IX.3, for canonical tensors). Even F_k vanish where Φ is self-adjoint; of
//! a map of order m, F_2 … F_m do.

mod numbers;
mod product;
mod words;

pub use numbers::{MakeShadowEnergy, shadow_of_shears};

use leafwise_expression::graph::lift;
use leafwise_expression::{
    AlgebraError, Arithmetic, Expression, Graph, Polynomial, Rational, Ring, Term,
};

/// F_1, F_2, …: the first terms of H̃.
#[derive(Clone, Debug)]
pub struct Shadow {
    code: Code,
}

#[derive(Clone, Debug)]
enum Code {
    /// Expanded.
    Ring(Box<Ring>, Vec<Polynomial>),
    /// Straight-line code, where expanding takes too long; its inputs are the coordinates.
    Graph(Box<Graph>, Vec<Term>),
}

impl Shadow {
    /// F_1, F_2, … as elements of a ring, whose first variables are the coordinates.
    pub fn expanded(ring: Ring, coefficients: Vec<Polynomial>) -> Self {
        Self {
            code: Code::Ring(Box::new(ring), coefficients),
        }
    }

    /// The same as code.
    pub fn code(graph: Graph, coefficients: Vec<Term>) -> Self {
        Self {
            code: Code::Graph(Box::new(graph), coefficients),
        }
    }

    /// How many F_k are known.
    pub fn len(&self) -> usize {
        match &self.code {
            Code::Ring(_, coefficients) => coefficients.len(),
            Code::Graph(_, coefficients) => coefficients.len(),
        }
    }

    /// Whether none is.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The same without the F_k that are known to be 0 where the coefficients of a composition are rounded.
    #[must_use]
    pub fn keeping(mut self, keeps: impl Fn(usize) -> bool) -> Self {
        match &mut self.code {
            Code::Ring(_, coefficients) => {
                let dropped = (1..).zip(coefficients).filter(|(k, _)| !keeps(*k));
                dropped.for_each(|(_, f)| *f = Polynomial::zero());
            }
            Code::Graph(graph, coefficients) => {
                let zero = graph.zero();
                let dropped = (1..).zip(coefficients).filter(|(k, _)| !keeps(*k));
                dropped.for_each(|(_, f)| *f = zero.clone());
            }
        }
        self
    }

    /// The k whose F_k are not 0.
    pub fn terms(&self) -> Vec<usize> {
        let is_zero: Vec<bool> = match &self.code {
            Code::Ring(_, coefficients) => coefficients.iter().map(Polynomial::is_zero).collect(),
            Code::Graph(graph, coefficients) => {
                coefficients.iter().map(|f| graph.is_zero(f)).collect()
            }
        };
        let numbered = is_zero.into_iter().enumerate();
        numbered
            .filter(|(_, is_zero)| !is_zero)
            .map(|(at, _)| at + 1)
            .collect()
    }

    /// F_k as a formula; `None` where it is code of more than `most` parts.
    pub fn formula(&self, k: usize, most: usize) -> Option<Expression> {
        match &self.code {
            Code::Ring(ring, coefficients) => Some(ring.formula(coefficients.get(k - 1)?)),
            Code::Graph(graph, coefficients) => graph.formula(coefficients.get(k - 1)?, most),
        }
    }

    /// Σ_k t^{k−1} F_k over the terms up to k = `last`, in few operations.
    ///
    /// # Errors
    /// [`AlgebraError`] where an adjoined function has no code.
    pub fn value(&self, t: f64, last: usize) -> Result<Option<Expression>, AlgebraError> {
        let power = |k: usize| {
            let power = (0..k).fold(1.0, |power, _| power * t);
            Rational::from_f64(power)
        };
        let mut graph = Graph::new();
        let term = match &self.code {
            Code::Ring(ring, coefficients) => {
                let variables: Vec<Term> = (0..ring.variables()).map(|i| graph.input(i)).collect();
                let mut parts = Vec::new();
                for (k, f) in coefficients.iter().enumerate().take(last) {
                    let Some(power) = power(k) else {
                        return Ok(None);
                    };
                    parts.push((graph.constant(&power), f.clone()));
                }
                lift(&mut graph, ring, &[parts], &variables)?
            }
            Code::Graph(code, coefficients) => {
                graph = code.as_ref().clone();
                let mut parts = Vec::new();
                for (k, f) in coefficients.iter().enumerate().take(last) {
                    let Some(power) = power(k) else {
                        return Ok(None);
                    };
                    parts.push((power, f.clone()));
                }
                vec![graph.combine(&parts)]
            }
        };
        let formulas = graph.shared_formulas(&term);
        Ok(formulas.and_then(|formulas| formulas.into_iter().next()))
    }

    /// F_1, F_2, … as elements of another ring; `None` where they are code.
    fn elements_in(&self, other: &mut Ring) -> Result<Option<Vec<Polynomial>>, AlgebraError> {
        let Code::Ring(ring, coefficients) = &self.code else {
            return Ok(None);
        };
        let elements = coefficients.iter().map(|f| {
            let formula = ring.formula(f);
            formula.evaluate_in(other, &mut |ring: &mut Ring, at| Ok(ring.variable(at)))
        });
        elements.collect::<Result<_, _>>().map(Some)
    }
}

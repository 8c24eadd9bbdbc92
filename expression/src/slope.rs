//! Derivatives of formulas, again as formulas.

use crate::arithmetic::AlgebraError;
use crate::expression::Expression;
use crate::graph::Graph;
use crate::operators::Quantity;
use crate::shared::Known;

impl Expression {
    /// The exact derivative by a variable or a parameter: that of straight-line code, as it is taken in motions.
    ///
    /// ```
    /// use leafwise_expression::Quantity;
    ///
    /// let x = Quantity::Variable(0);
    /// let slope = x.pow(3).derivative(x).expect("a derivative");
    /// assert_eq!(slope.written(&["x".to_owned()], &[]), "3*x^2");
    /// ```
    ///
    /// # Errors
    /// [`AlgebraError`] where the formula has no code, such as 1/0, or its exponents depend on variables. Also where
    /// the derivative is longer than code may be.
    pub fn derivative(&self, by: Quantity) -> Result<Self, AlgebraError> {
        // A parameter becomes a variable behind all others, and one again.
        let last = self.variables().last().map_or(0, |last| last + 1);
        let (formula, input) = match by {
            Quantity::Variable(index) => (self.clone(), index),
            Quantity::Parameter(index) => {
                let part = |part: &Self| match part {
                    Self::Parameter(own) if *own == index => Self::Variable(last),
                    other => other.clone(),
                };
                (self.replaced(&part, &mut Known::default()), last)
            }
        };
        let mut graph = Graph::compilable();
        let code =
            formula.evaluate_in(&mut graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)))?;
        let slope = graph.derivative(&code, input)?;
        let formulas = graph.shared_formulas(&[slope]);
        let slope = formulas.and_then(|formulas| formulas.into_iter().next());
        let slope = slope.ok_or(AlgebraError::NoSeries)?;
        Ok(match by {
            Quantity::Variable(_) => slope,
            Quantity::Parameter(index) => {
                let part = |part: &Self| match part {
                    Self::Variable(own) if *own == last => Self::Parameter(index),
                    other => other.clone(),
                };
                slope.replaced(&part, &mut Known::default())
            }
        })
    }
}

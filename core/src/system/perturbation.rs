//! Hamiltonians beside H, and parameters behind a system's own: what noise makes of a system.

use leafwise_expression::{Expression, Graph, Term};

use super::{Forces, Parameter, SystemFormulas};
use crate::error::BuildError;

impl SystemFormulas {
    /// The same system with further parameters behind its own.
    pub fn with_parameters(&self, further: impl IntoIterator<Item = Parameter>) -> Self {
        let mut system = self.clone();
        system.parameters.extend(further);
        system
    }

    /// The same system with H + N in place of H: ẋ = −Π(dH + η + dN). Damping is of H all the same.
    ///
    /// # Errors
    /// [`BuildError::Dimension`] where N uses an index out of range. Beside forces, an N without a derivative gives
    /// [`BuildError::Algebra`].
    pub fn with_perturbation(&self, n: Expression) -> Result<Self, BuildError> {
        if self.forces().is_empty() {
            return self.with_hamiltonian(Expression::Sum(vec![self.hamiltonian().clone(), n]));
        }
        // N names what H may name.
        self.with_hamiltonian(n.clone())?;
        let d = self.dimension();
        let mut graph = Graph::new();
        let x: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let value = n.evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone()))?;
        let mut forces: Forces = self.forces().clone();
        forces.one_form.resize(d, 0.into());
        for (i, force) in forces.one_form.iter_mut().enumerate() {
            let slope = graph.derivative(&value, i)?;
            let slope = graph.formula(&slope, usize::MAX);
            let slope = slope.expect("a formula of any length");
            *force = Expression::Sum(vec![force.clone(), slope]);
        }
        self.with_forces(forces)
    }
}

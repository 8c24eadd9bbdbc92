//! Which systems live on so(3)*, and the constant factor of their tensor.

use leafwise_core::{BuildError, PoissonSystem, SystemFormulas};
use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Graph, Polynomial, Ring, Term};

use crate::vector::times;

/// Πp = λ x × p, λ a number or a function of the system's parameters: {x1,x2} = −λ x3, {x2,x3} =
/// −λ x1, {x3,x1} = −λ x2.
///
/// The realization of λπ at p is that of π at λp (Karasev's rescaling, paper, section 3.1), so the
/// textbooks' {x1,x2} = x3 is λ = −1.
#[derive(Clone, Debug)]
pub struct RotationTensor {
    part: &'static str,
    system: SystemFormulas,
}

impl RotationTensor {
    /// The tensor of `system`, proved in exact algebra to be that of so(3)* up to a constant.
    ///
    /// # Errors
    /// Returns [`BuildError::DoesNotFit`] with the entry that differs. Returns
    /// [`BuildError::Algebra`] for an entry that has no value at all.
    pub fn new(part: &'static str, system: &PoissonSystem) -> Result<Self, BuildError> {
        let system = system.formulas(part)?;
        let tensor = Self {
            part,
            system: system.clone(),
        };
        tensor.factor(&mut Ring::new(system.dimension()))?;
        Ok(tensor)
    }

    /// The system.
    pub fn system(&self) -> &SystemFormulas {
        &self.system
    }

    /// λ as a constant of `ring`.
    ///
    /// # Errors
    /// Those of [`RotationTensor::new`].
    pub fn factor(&self, ring: &mut Ring) -> Result<Polynomial, BuildError> {
        let misfit = |reason: String| BuildError::DoesNotFit {
            part: self.part,
            reason,
        };
        let names = self.system.variables();
        if names.len() != 3 {
            return Err(misfit(format!(
                "it has {} variables; so(3)* has 3",
                names.len()
            )));
        }
        let x: Vec<Polynomial> = (0..3).map(|i| ring.variable(i)).collect();
        let mut factor: Option<Polynomial> = None;
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (0, 2, 1)] {
            let entry = match self.system.tensor().get(&(i, j)) {
                None => Polynomial::zero(),
                Some(entry) => entry.evaluate_in(ring, &mut |_, at| Ok(x[at].clone()))?,
            };
            // {x1,x3} stands above the diagonal with the other sign.
            let entry = if (i, j) == (0, 2) {
                entry
            } else {
                ring.negate(&entry)
            };
            let entry_name = format!("{{{}, {}}}", names[i], names[j]);
            match &factor {
                None => {
                    let ratio = ring.divide(&entry, &x[k])?;
                    if ratio.is_zero() || ratio.as_constant().is_none() {
                        return Err(misfit(format!(
                            "so(3)* needs {entry_name} to be a constant multiple of {}, not 0",
                            names[k]
                        )));
                    }
                    factor = Some(ratio);
                }
                Some(factor) => {
                    let expected = ring.multiply(factor, &x[k]);
                    if !ring.subtract(&entry, &expected).is_zero() {
                        return Err(misfit(format!(
                            "with {{{0}, {1}}} as it is, so(3)* needs {entry_name} to be the same \
                             multiple of {2}{3}",
                            names[0],
                            names[1],
                            if (i, j) == (0, 2) { "-" } else { "" },
                            names[k],
                        )));
                    }
                }
            }
        }
        Ok(factor.expect("three entries were read"))
    }

    /// q = ελp, with which every formula of this crate is written.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where λ has no code.
    pub fn scaled_momentum(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        p: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let mut ring = Ring::new(3);
        let factor = self.factor(&mut ring)?;
        let code = lift(graph, &ring, &[vec![(epsilon.clone(), factor)]], &[])?;
        Ok(times(graph, &code[0], p))
    }
}

//! Jacobians that are differentiated and compiled when the first one is asked for.

use std::sync::{Arc, OnceLock};

use leafwise_expression::{Graph, Kernel, Term};

use crate::error::BuildError;
use leafwise_solver::check_variables;

/// DF of code for F, which all evaluators share. Explicit methods, and Gauss methods whose plain iteration converges, never
/// ask for it: differentiation takes longer than all else that a long system is built by.
pub(super) struct Jacobian {
    graph: Arc<Graph>,
    outputs: Vec<Term>,
    parameters: usize,
    inputs: usize,
    /// `Some(None)` where it is refused.
    kernel: OnceLock<Option<Arc<Kernel>>>,
}

impl Jacobian {
    /// The Jacobian of `outputs` by the first `inputs` inputs, not yet formed.
    pub(super) fn new(
        graph: Arc<Graph>,
        outputs: &[Term],
        parameters: usize,
        inputs: usize,
    ) -> Self {
        Self {
            graph,
            outputs: outputs.to_vec(),
            parameters,
            inputs,
            kernel: OnceLock::new(),
        }
    }

    /// Makes sure that the kernel can be formed: forms it where only that tells.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a derivative is too long, [`BuildError::TooManyVariables`].
    pub(super) fn proven(self) -> Result<Self, BuildError> {
        self.graph.unless_refused(())?;
        if !self.is_certain() {
            let formed = self.form()?;
            self.kernel.get_or_init(|| Some(Arc::new(formed)));
        }
        Ok(self)
    }

    /// Functions of formulas have derivatives: length alone refuses any.
    fn is_certain(&self) -> bool {
        let is_narrow = check_variables(self.outputs.len().min(self.inputs)).is_ok();
        is_narrow && self.graph.has_room_for_slopes(&self.outputs, self.inputs)
    }

    /// The kernel, formed where that was not tried before; `None` where it is refused.
    pub(super) fn kernel(&self) -> Option<&Arc<Kernel>> {
        let form = || self.form().ok().map(Arc::new);
        self.kernel.get_or_init(form).as_ref()
    }

    /// Whether it was formed or tried already.
    #[cfg(test)]
    pub(super) fn is_formed(&self) -> bool {
        self.kernel.get().is_some()
    }

    fn form(&self) -> Result<Kernel, BuildError> {
        check_variables(self.outputs.len().min(self.inputs))?;
        let mut graph = (*self.graph).clone();
        let mut entries = Vec::with_capacity(self.outputs.len() * self.inputs);
        for output in &self.outputs {
            for k in 0..self.inputs {
                entries.push(graph.derivative(output, k)?);
            }
        }
        graph.unless_refused(())?;
        Ok(Kernel::compile(
            &graph,
            &entries,
            self.parameters,
            self.inputs,
        ))
    }
}

//! Graphs of one-forms given by code, as bisections.

use std::sync::Arc;

use leafwise_expression::{Graph, Term};

use crate::bisection::{LagrangianBisection, PointCode};
use crate::chart::ChartMaps;
use crate::error::BuildError;
use crate::evaluator::Evaluator;
use crate::generating_function::Generating;
use crate::one_form::{CodeOneForm, GraphOfOneForm};
use crate::realization::RealizationData;

/// θ_{ε,h} on M, given by code.
#[derive(Clone, Debug)]
pub enum OneForm {
    /// dŜ_{ε,h}: closed, and its graph Lagrangian.
    Differential(Generating),
    /// Any other, whose graph maps along leaves.
    Code {
        /// The code; its inputs are the coordinates of M, and it may use ε and h.
        graph: Graph,
        /// d components.
        components: Vec<Term>,
    },
}

impl OneForm {
    /// θ_{ε,h}(y) as code.
    fn code(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        h: &Term,
        y: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        match self {
            Self::Differential(generating) => generating.differential(graph, epsilon, h, y),
            Self::Code {
                graph: own,
                components,
            } => Ok(graph.import(own, components, y)?),
        }
    }
}

/// y ↦ χ(y, θ_{ε,h}(y)), χ the realization's chart about σ; (y, θ(y)) itself on T*M.
#[derive(Clone, Debug)]
pub struct GraphBisection {
    form: OneForm,
    realization: Arc<dyn RealizationData>,
    /// θ and χ as numbers, where χ has no code.
    numbers: Option<(CodeOneForm, ChartMaps)>,
}

impl GraphBisection {
    /// Bisection of a one-form over a realization, for a system with this number of parameters. Messages call the
    /// approximation `dynamics`.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization has no chart about its section, or one in which β̂(x, p) is
    /// not α̂(x, −p). Only with β̂(x, p) = α̂(x, −p) are maps of forms odd in h self-adjoint (paper, Proposition 1). A
    /// derivative without code gives [`BuildError::Algebra`].
    pub fn new(
        form: OneForm,
        realization: &Arc<dyn RealizationData>,
        parameters: usize,
        dynamics: &str,
    ) -> Result<Self, BuildError> {
        let missing = |reason: &str| BuildError::Incompatible {
            dynamics: dynamics.to_owned(),
            realization: realization.describe(),
            reason: reason.to_owned(),
        };
        if !realization.is_reversible() {
            return Err(missing(
                "beta(x, p) is not alpha(x, -p) there, so that even coefficients of S do not vanish",
            ));
        }
        let has_code = realization.points_are_pairs() || realization.chart().is_some();
        let numbers = if has_code {
            None
        } else {
            let chart = ChartMaps::of(realization, parameters)?
                .ok_or_else(|| missing("it has no symplectic chart about its section"))?;
            let d = realization.dimension();
            let numbers = CodeOneForm::compile(d, parameters, |graph, epsilon, h, y| {
                form.code(graph, epsilon, h, y)
            })?;
            Some((numbers, chart))
        };
        Ok(Self {
            form,
            realization: Arc::clone(realization),
            numbers,
        })
    }
}

impl LagrangianBisection for GraphBisection {
    fn code(&self) -> Option<PointCode<'_>> {
        if self.numbers.is_some() {
            return None;
        }
        Some(Box::new(|graph, epsilon, h, y| {
            let p = self.form.code(graph, epsilon, h, y)?;
            match self.realization.chart() {
                None => Ok(y.iter().cloned().chain(p).collect()),
                Some(chart) => chart(graph, epsilon, y, &p),
            }
        }))
    }

    fn evaluator(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn Evaluator>> {
        let (form, chart) = self.numbers.as_ref()?;
        Some(Box::new(GraphOfOneForm::new(
            form.evaluator(parameters, epsilon, h),
            chart.evaluator(parameters, epsilon),
            self.realization.dimension(),
            self.realization.space_dimension(),
        )))
    }

    fn one_form_code(&self) -> Option<PointCode<'_>> {
        Some(Box::new(|graph, epsilon, h, y| {
            self.form.code(graph, epsilon, h, y)
        }))
    }

    fn generating_function(&self) -> Option<&Generating> {
        match &self.form {
            OneForm::Differential(generating) => Some(generating),
            OneForm::Code { .. } => None,
        }
    }
}

//! graph(dŜ) as a Lagrangian bisection.

use std::sync::Arc;

use crate::bisection::{LagrangianBisection, PointCode};
use crate::chart::ChartMaps;
use crate::error::BuildError;
use crate::evaluator::Evaluator;
use crate::generating_function::Generating;
use crate::one_form::{CodeOneForm, GraphOfOneForm};
use crate::realization::RealizationData;

/// y ↦ χ(y, dŜ_{ε,h}(y)), χ the realization's chart about σ; (y, dŜ(y)) itself on T*M.
#[derive(Clone, Debug)]
pub struct GraphOfDifferential {
    generating: Generating,
    realization: Arc<dyn RealizationData>,
    /// dŜ and χ as numbers, where χ has no code.
    numbers: Option<(CodeOneForm, ChartMaps)>,
}

impl GraphOfDifferential {
    /// The bisection of a generating function over a realization, for a system with this number of
    /// parameters; `dynamics` is what messages call the approximation.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization has no chart about its section, or one in
    /// which β̂(x, p) is not α̂(x, −p): even coefficients of S vanish only there (paper,
    /// Proposition 1). [`BuildError::Algebra`] where a derivative has no code.
    pub fn new(
        generating: Generating,
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
            let form = CodeOneForm::compile(d, parameters, |graph, epsilon, h, y| {
                generating.differential(graph, epsilon, h, y)
            })?;
            Some((form, chart))
        };
        Ok(Self {
            generating,
            realization: Arc::clone(realization),
            numbers,
        })
    }
}

impl LagrangianBisection for GraphOfDifferential {
    fn code(&self) -> Option<PointCode<'_>> {
        if self.numbers.is_some() {
            return None;
        }
        Some(Box::new(|graph, epsilon, h, y| {
            let p = self.generating.differential(graph, epsilon, h, y)?;
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

    fn generating_function(&self) -> Option<&Generating> {
        Some(&self.generating)
    }
}

//! A realization by formulas in a cotangent chart.

use leafwise_expression::{AlgebraError, Arithmetic, Expression, Graph, Term};

use crate::closed_form::{ChartPoint, ClosedForm, FormProperties};
use crate::lattice::StageEnds;
use crate::realization::Accuracy;

/// α̂, β̂ and the domain by formulas of x_1 … x_d, p_1 … p_d and ε, which are their variables in this order, and of
/// the system's parameters.
#[derive(Clone, Debug)]
pub struct RealizationFormulas {
    /// α̂, d formulas.
    pub alpha: Vec<Expression>,
    /// β̂, d formulas; absent where β̂(x, p) = α̂(x, −p).
    pub beta: Option<Vec<Expression>>,
    /// Less than 1 inside the chart; absent where it is everything.
    pub domain: Option<Expression>,
}

/// (T*M ⊃ U, ω, α̂, β̂, σ) by formulas, σ(x) = (x, 0).
#[derive(Clone, Debug)]
pub struct FormulaRealization {
    formulas: RealizationFormulas,
    properties: FormProperties,
}

impl FormulaRealization {
    /// The realization of these formulas, of the accuracy that is claimed; `is_reversible` says that a given β̂(x, p) is
    /// α̂(x, −p). At `parameters` it is seen, by samples, whether ε enters as a factor of p alone.
    pub fn new(
        formulas: RealizationFormulas,
        accuracy: Accuracy,
        is_reversible: bool,
        parameters: &[f64],
    ) -> Self {
        Self {
            properties: FormProperties {
                accuracy,
                is_reversible: is_reversible || formulas.beta.is_none(),
                has_series: scales(&formulas.alpha, parameters),
            },
            formulas,
        }
    }

    /// The first formula of α̂ or β̂ whose value at (x, 0) is another than x, at a sample state or at one that is `near`.
    pub fn off_section(&self, near: &[f64], parameters: &[f64]) -> Option<OffSection> {
        let d = self.formulas.alpha.len();
        let states = [sample_state(d), near.to_vec()];
        let states: Vec<&Vec<f64>> = states.iter().filter(|x| x.len() == d).collect();
        let ends = [
            (false, Some(&self.formulas.alpha)),
            (true, self.formulas.beta.as_ref()),
        ];
        for (is_target, formulas) in ends {
            for (position, formula) in formulas.into_iter().flatten().enumerate() {
                for &x in &states {
                    let mut at = x.clone();
                    at.resize(2 * d, 0.0);
                    at.push(SAMPLES[0].1);
                    let value = formula.evaluate(&at, parameters);
                    let expected = x[position];
                    if (value - expected).abs() > ROUND_OFF * (1.0 + expected.abs()) {
                        return Some(OffSection {
                            is_target,
                            position,
                            expected,
                            value,
                        });
                    }
                }
            }
        }
        None
    }
}

/// Where α̂(x, 0) = β̂(x, 0) = x fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffSection {
    /// Whether it is β̂'s formula.
    pub is_target: bool,
    /// Which coordinate's, from 0.
    pub position: usize,
    /// The coordinate of x.
    pub expected: f64,
    /// The formula's value there.
    pub value: f64,
}

/// A momentum and an ε at which formulas are compared.
const SAMPLES: [(f64, f64); 3] = [(0.1, 0.5), (-0.07, 0.25), (0.03, 2.0)];

/// Largest difference that round-off leaves between equal values a and b of two formulas, in units of 1 + |a|.
const ROUND_OFF: f64 = 1e-12;

/// A state that many domains contain: positive, all coordinates different.
fn sample_state(d: usize) -> Vec<f64> {
    (0..d).map(|i| 0.7 + 0.2 * i as f64).collect()
}

/// Whether α_ε(x, p) = α_1(x, εp), by samples.
fn scales(alpha: &[Expression], parameters: &[f64]) -> bool {
    let d = alpha.len();
    let mut is_seen = false;
    for (size, epsilon) in SAMPLES {
        let x = sample_state(d);
        let p: Vec<f64> = (0..d).map(|i| size / (1.0 + i as f64)).collect();
        let at = |factor: f64, epsilon: f64| -> Vec<f64> {
            let scaled = p.iter().map(|p| factor * p);
            x.iter().copied().chain(scaled).chain([epsilon]).collect()
        };
        let (scaled, own) = (at(epsilon, 1.0), at(1.0, epsilon));
        for formula in alpha {
            let (a, b) = (
                formula.evaluate(&own, parameters),
                formula.evaluate(&scaled, parameters),
            );
            if !a.is_finite() || !b.is_finite() {
                continue;
            }
            is_seen = true;
            if (a - b).abs() > ROUND_OFF * (1.0 + a.abs()) {
                return false;
            }
        }
    }
    is_seen
}

/// Formulas of x, p and ε at a point of the chart.
fn write<A: Arithmetic>(
    formulas: &[Expression],
    algebra: &mut A,
    at: &ChartPoint<'_, A::Element>,
) -> Result<Vec<A::Element>, AlgebraError> {
    let d = at.x.len();
    let mut variables = |_: &mut A, index: usize| {
        Ok(match index {
            index if index < d => at.x[index].clone(),
            index if index < 2 * d => at.p[index - d].clone(),
            _ => at.epsilon.clone(),
        })
    };
    let formulas = formulas.iter();
    formulas
        .map(|formula| formula.evaluate_in(algebra, &mut variables))
        .collect()
}

impl ClosedForm for FormulaRealization {
    fn dimension(&self) -> usize {
        self.formulas.alpha.len()
    }

    fn source<A: Arithmetic>(
        &self,
        algebra: &mut A,
        at: &ChartPoint<'_, A::Element>,
    ) -> Result<Vec<A::Element>, AlgebraError> {
        write(&self.formulas.alpha, algebra, at)
    }

    fn ends(
        &self,
        graph: &mut Graph,
        at: &ChartPoint<'_, Term>,
    ) -> Result<StageEnds, AlgebraError> {
        let alpha = self.source(graph, at)?;
        let beta = match &self.formulas.beta {
            Some(beta) => write(beta, graph, at)?,
            None => {
                let minus: Vec<Term> = at.p.iter().map(|p| graph.negate(p)).collect();
                self.source(graph, &ChartPoint { p: &minus, ..*at })?
            }
        };
        Ok(StageEnds::between(graph, at.x, &alpha, &beta))
    }

    fn guard(
        &self,
        graph: &mut Graph,
        at: &ChartPoint<'_, Term>,
    ) -> Result<Option<(Vec<Term>, Vec<Term>)>, AlgebraError> {
        let Some(domain) = &self.formulas.domain else {
            return Ok(None);
        };
        let reach = write(std::slice::from_ref(domain), graph, at)?;
        let d = self.dimension();
        Ok(Some((vec![graph.one(); d], vec![reach[0].clone(); d])))
    }

    fn properties(&self) -> FormProperties {
        self.properties
    }
}

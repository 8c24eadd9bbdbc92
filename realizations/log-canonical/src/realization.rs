//! x_i exp(∓½ ε Σ_j a_ij x_j p_j).

use leafwise_core::lattice::{RealizationStages, StageBuilder, StageEnds};
use leafwise_core::realization::{
    Accuracy, RealizationCode, RealizationData, SourceSeries, SourceTarget,
};
use leafwise_core::{BuildError, PoissonSystem, SystemFormulas};
use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Function, Graph, Polynomial, Rational, Ring, Term};

use crate::register::INFO;
use crate::series::LogCanonicalSeries;

/// Realization data of {x_i, x_j} = a_ij x_i x_j: α_i = x_i e^{−u_i}, β_i = x_i e^{u_i} with
/// u_i = ½ ε Σ_j a_ij x_j p_j (S. Li, D. Rupel, *Symplectic groupoids for cluster manifolds*,
/// 2018, for the structure; the chart is the one with β(x, p) = α(x, −p)).
///
/// In y_j = x_j p_j the canonical bracket is {x_i, y_j} = δ_ij x_i, so the x_i e^{−u_i} multiply
/// like exponentials of a Heisenberg algebra. A vanishing or negative coordinate is as good as any.
#[derive(Clone, Debug)]
pub struct LogCanonical {
    dimension: usize,
    ring: Ring,
    /// a_ij for i < j, nonzero, free of variables.
    coefficients: Coefficients,
    series: LogCanonicalSeries,
}

impl LogCanonical {
    /// The realization data of a system's tensor.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] with the first entry whose quotient by x_i x_j has a normal form
    /// with variables, [`BuildError::Algebra`] where an entry has no normal form.
    pub fn new(system: &PoissonSystem) -> Result<Self, BuildError> {
        let system = system.formulas(INFO.name)?;
        let mut ring = Ring::new(system.dimension());
        let coefficients = coefficients(system, &mut ring)?;
        Ok(Self {
            dimension: system.dimension(),
            ring,
            coefficients,
            series: LogCanonicalSeries::new(system.clone()),
        })
    }

    /// β − x and α − β as code.
    ///
    /// With s = sinh(u/2) and c = cosh(u/2) the part of α − x that is odd in p is −2 x s c and the
    /// even one 2 x s²: products, so that nothing cancels, and one odd part for both ends.
    fn ends(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        x: &[Term],
        p: &[Term],
    ) -> Result<StageEnds, BuildError> {
        let outputs: Vec<_> = self
            .coefficients
            .iter()
            .map(|(_, a)| vec![(epsilon.clone(), a.clone())])
            .collect();
        let coefficients = lift(graph, &self.ring, &outputs, &[])?;
        let y: Vec<Term> = x.iter().zip(p).map(|(x, p)| graph.multiply(x, p)).collect();
        let quarter = Rational::new(1, 4);
        let mut halves = vec![Vec::new(); self.dimension];
        for (((i, j), _), a) in self.coefficients.iter().zip(&coefficients) {
            halves[*i].push((quarter.clone(), graph.multiply(a, &y[*j])));
            halves[*j].push((-&quarter, graph.multiply(a, &y[*i])));
        }
        let two = Rational::from_integer(2);
        let mut offset = Vec::with_capacity(x.len());
        let mut increment = Vec::with_capacity(x.len());
        for (x, terms) in x.iter().zip(&halves) {
            let half = graph.combine(terms);
            let sinh = graph.apply(Function::Sinh, &half)?;
            let cosh = graph.apply(Function::Cosh, &half)?;
            let scaled = graph.multiply(x, &sinh);
            let odd = graph.multiply(&scaled, &cosh);
            let even = graph.multiply(&scaled, &sinh);
            offset.push(graph.combine(&[(two.clone(), even), (two.clone(), odd.clone())]));
            increment.push(graph.scale(&Rational::from_integer(-4), &odd));
        }
        Ok(StageEnds { offset, increment })
    }
}

/// a_ij by (i, j) with i < j.
pub(crate) type Coefficients = Vec<((usize, usize), Polynomial)>;

/// The nonzero a_ij = {x_i, x_j}/(x_i x_j), i < j, as constants of `ring`.
pub(crate) fn coefficients(
    system: &SystemFormulas,
    ring: &mut Ring,
) -> Result<Coefficients, BuildError> {
    let mut coefficients = Vec::with_capacity(system.tensor().len());
    for (&(i, j), entry) in system.tensor() {
        let value = entry.evaluate_in(ring, &mut |ring, at| Ok(ring.variable(at)))?;
        let (first, second) = (ring.variable(i), ring.variable(j));
        let product = ring.multiply(&first, &second);
        let a = ring.divide(&value, &product)?;
        if a.as_constant().is_none() {
            let [first, second] = [i, j].map(|at| &system.variables()[at]);
            return Err(BuildError::DoesNotFit {
                part: INFO.name,
                reason: format!(
                    "{{{first}, {second}}} is not {first}*{second} times a function of the \
                     parameters"
                ),
            });
        }
        if !a.is_zero() {
            coefficients.push(((i, j), a));
        }
    }
    Ok(coefficients)
}

impl RealizationData for LogCanonical {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn space_dimension(&self) -> usize {
        2 * self.dimension
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }

    fn describe(&self) -> String {
        INFO.name.to_owned()
    }

    fn section(&self, x: &[f64], z: &mut [f64]) {
        z[..x.len()].copy_from_slice(x);
        z[x.len()..].fill(0.0);
    }

    fn code(&self) -> Option<&dyn RealizationCode> {
        Some(self)
    }

    fn stages(&self) -> Option<&dyn RealizationStages> {
        Some(self)
    }

    fn series(&self) -> Option<&dyn SourceSeries> {
        Some(&self.series)
    }
}

impl RealizationCode for LogCanonical {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let (x, p) = z.split_at(self.dimension);
        let StageEnds { offset, increment } = self.ends(graph, epsilon, x, p)?;
        Ok(SourceTarget {
            base: x.to_vec(),
            offset,
            increment,
            guard: None,
        })
    }
}

impl RealizationStages for LogCanonical {
    /// One stage: u_i reads x_j p_j at neighbouring sites.
    fn stages(
        &self,
        builder: &mut StageBuilder,
        epsilon: &Term,
        y: &[Term],
        p: &[Term],
    ) -> Result<StageEnds, BuildError> {
        self.ends(&mut builder.graph, epsilon, y, p)
    }
}

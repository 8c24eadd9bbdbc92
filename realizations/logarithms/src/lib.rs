//! Logarithms as coordinates of a log-canonical Poisson tensor.
//!
//! Where {x_i, x_j} = a_ij x_i x_j, every Lotka–Volterra system among them, y_i = ln |x_i| have the constant tensor a:
//! {y_i, y_j} = a_ij. A Gauss method steps them by a Poisson map. About a state x the coordinates are z_i = y_i −
//! ln |x_i|. The product x_i eᶻ is as good for a coordinate that is negative, and stays 0 for one that is.

use std::sync::Arc;

use leafwise_core::lift::{End, Lift, LiftShape};
use leafwise_core::part::{PartInfo, PartKind, PartParameters};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{
    BuildError, LiftedRealization, PoissonSystem, RealizationData, StepError, SystemFormulas,
};
use leafwise_expression::graph::lift;
use leafwise_expression::pairs::EXPONENTIAL_MINUS_1;
use leafwise_expression::{Arithmetic, Graph, Polynomial, Rational, Ring, Term};
use leafwise_log_canonical::LogCanonical;

static INFO: PartInfo = PartInfo {
    name: "logarithms",
    summary: "ln |x_i| as coordinates of constant brackets a_ij, for {x_i, x_j} = a_ij x_i x_j",
    declares: "exact; self-adjoint",
    domain: "all points, with the dynamics `collective`; a_ij of numbers and parameters",
    literature: "R. McLachlan, K. Modin, O. Verdier, Collective symplectic integrators, Nonlinearity 27 (2014); \
                 Hairer, Lubich, Wanner, Geometric Numerical Integration, section VII.2 and theorem VI.4.3",
    is_lift: true,
    ..PartInfo::of(PartKind::Realization)
};

/// z_i = ln(x_i/x_i⁰), with {z_i, z_j} = a_ij (Hairer, Lubich, Wanner, *Geometric Numerical Integration*,
/// section VII.2).
#[derive(Clone, Debug)]
pub struct Logarithms {
    system: SystemFormulas,
    ring: Ring,
    /// a_ij in the order of the tensor's entries.
    coefficients: Vec<Polynomial>,
}

impl Logarithms {
    /// The coordinates of a system's tensor.
    ///
    /// # Errors
    /// Returns [`BuildError::DoesNotFit`] with the first entry whose quotient by x_i x_j has a normal form with
    /// variables. Returns [`BuildError::Algebra`] where an entry has no normal form.
    pub fn realize(system: &PoissonSystem) -> Result<LiftedRealization, BuildError> {
        let system = system.formulas(INFO.name)?.clone();
        let mut ring = Ring::new(system.dimension());
        let coefficients = LogCanonical::coefficients(&system, &mut ring)?;
        let dimension = system.dimension();
        let lift = Self {
            system,
            ring,
            coefficients,
        };
        Ok(LiftedRealization::new(INFO.name, dimension, lift))
    }
}

impl Lift for Logarithms {
    fn shape(&self) -> LiftShape {
        let d = self.system.dimension();
        LiftShape {
            coordinates: d,
            base: d,
            follows: false,
        }
    }

    fn place(
        &self,
        x: &[f64],
        _low: &[f64],
        _before: Option<End<'_>>,
        base: &mut [f64],
    ) -> Result<(), StepError> {
        base.copy_from_slice(x);
        Ok(())
    }

    /// A change of z is one of x relative to itself.
    fn sizes(&self, _base: &[f64], sizes: &mut [f64]) {
        sizes.fill(1.0);
    }

    /// x_i⁰ e^{z_i}.
    fn image(&self, graph: &mut Graph, z: &[Term], base: &[Term]) -> Result<Vec<Term>, BuildError> {
        let pairs = base.iter().zip(z);
        Ok(pairs.map(|(x, z)| grown(graph, x, z)).collect())
    }

    /// Σ_j a_ij x_j ∂_j H: ∂H holds 1/x where H holds ln x, and x ∂H does not.
    fn covector(
        &self,
        graph: &mut Graph,
        x: &[Term],
        slopes: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let pairs = x.iter().zip(slopes);
        let slopes: Vec<Term> = pairs.map(|(x, g)| graph.multiply_reduced(x, g)).collect();
        let one = graph.one();
        let outputs = self.coefficients.iter();
        let outputs: Vec<_> = outputs.map(|a| vec![(one.clone(), a.clone())]).collect();
        let coefficients = lift(graph, &self.ring, &outputs, x)?;
        let mut rows = vec![Vec::new(); x.len()];
        for ((i, j), a) in self.system.tensor().keys().zip(&coefficients) {
            rows[*i].push((Rational::one(), graph.multiply(a, &slopes[*j])));
            rows[*j].push((-Rational::one(), graph.multiply(a, &slopes[*i])));
        }
        Ok(rows.iter().map(|row| graph.combine(row)).collect())
    }

    /// ż_i = −Σ_j a_ij x_j ∂_j H.
    fn field(
        &self,
        graph: &mut Graph,
        _z: &[Term],
        _base: &[Term],
        covector: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        Ok(covector.iter().map(|row| graph.negate(row)).collect())
    }

    /// x_i⁰ (e^{z_i} − 1).
    fn increment(
        &self,
        graph: &mut Graph,
        z: &[Term],
        base: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let pairs = base.iter().zip(z);
        let changes = pairs.map(|(x, z)| {
            let grown = graph.apply_analytic(EXPONENTIAL_MINUS_1, 0, z);
            graph.multiply(x, &grown)
        });
        Ok(changes.collect())
    }

    /// The base point is x.
    fn slopes_of_base(&self, base: &[f64], slopes: &mut [f64]) {
        slopes.fill(0.0);
        let diagonal = slopes.iter_mut().step_by(base.len() + 1);
        diagonal.for_each(|slope| *slope = 1.0);
    }
}

/// x eᶻ, with eᶻ − 1 = g (g + 2) of g = e^{z/2} − 1, twice. Machine code has e^{z/4} − 1 in line up to |z| = 2.2.
fn grown(graph: &mut Graph, x: &Term, z: &Term) -> Term {
    let quarter = graph.scale(&Rational::new(1, 4), z);
    let mut growth = graph.apply_analytic(EXPONENTIAL_MINUS_1, 0, &quarter);
    let two = graph.constant(&Rational::new(2, 1));
    for _ in 0..2 {
        let beyond = graph.add(&growth, &two);
        growth = graph.multiply(&growth, &beyond);
    }
    let change = graph.multiply(x, &growth);
    graph.add(x, &change)
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    Ok(Arc::new(Logarithms::realize(system)?))
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));

//! The constant realization in Darboux coordinates, in the original ones.

use std::sync::Arc;

use leafwise_core::part::{
    ParameterDefault, ParameterInfo, ParameterSetting, PartInfo, PartKind, PartParameters,
};
use leafwise_core::realization::{
    Accuracy, RealizationCode, RealizationData, SourceSeries, SourceTarget,
};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Expression, Graph, Polynomial, Rational, Ring, Term};

use crate::chart::MagneticChart;
use crate::chart::NAME;
use crate::series::MagneticSeries;

static INFO: PartInfo = PartInfo {
    name: NAME,
    summary: "the constant realization in Darboux coordinates P = p - A(x) of a magnetic bracket",
    declares: "exact; self-adjoint",
    domain: "all points where A is defined; {x_i, p_j} = -delta_ij or +delta_ij, {p_i, p_j} = \
             B_ij(x) with a global vector potential A: P_i = p_i - A_i commute; over a scene's \
             `magnetic-field` B, whose force is v' = v x B, that is curl A = -B",
    literature: "J. E. Marsden, T. S. Ratiu, Introduction to Mechanics and Symmetry (1999), \
                 section 6.7; Cabrera, Martin de Diego, Vaquero, Approximating Symplectic \
                 Realizations (2024), Example 3",
    parameters: &[ParameterInfo {
        name: "potential",
        summary: "the components of A, one formula a position, separated by `;`, such as \
                  \"0; x^3/3; y^2/2 + x*z\"",
        default: ParameterDefault::Text(""),
    }],
    ..PartInfo::of(PartKind::Realization)
};

/// α = Φ⁻¹ ∘ α′ ∘ T*Φ for the Darboux map Φ(x, p) = (x, P = p − A(x)), its cotangent lift T*Φ and
/// the constant realization α′ = X − ½ ε Π′ ξ of Π′ = {X, X}: T*Φ is symplectic and Φ a Poisson
/// isomorphism, so that α is Poisson, and β = α(·, −·) since T*Φ is linear on fibres.
///
/// With covectors (a, b) over (x, p), δ_i = ½ ε s_i b_i and T*Φ: (a, b) ↦ (a + A′ᵀ b, b):
///
/// - α_x = x − δ, β_x = x + δ,
/// - α_p = p + ½ ε s a + G + E, β_p = p − ½ ε s a − G + E with
///   G_i = Σ_j s_i s_j ∂_i A_j δ_j − ½ (A_i(x + δ) − A_i(x − δ)) odd in δ and
///   E_i = ½ (A_i(x + δ) + A_i(x − δ)) − A_i(x) even.
///
/// G and E are formed in exact algebra. For a polynomial A their differences are carried out and
/// nothing cancels; for other functions they carry the round-off of A itself.
#[derive(Clone, Debug)]
pub struct DarbouxMagnetic {
    dimension: usize,
    chart: MagneticChart,
    /// Functions of (x, p) and of δ, one for each variable.
    ring: Ring,
    odd: Vec<Polynomial>,
    even: Vec<Polynomial>,
    series: MagneticSeries,
}

impl DarbouxMagnetic {
    /// The realization data of a system's tensor with the potential A, one formula a position,
    /// separated by `;`.
    ///
    /// # Errors
    /// Those of [`MagneticChart::new`].
    pub fn new(system: &PoissonSystem, potential: &str) -> Result<Self, BuildError> {
        let system = system.formulas(INFO.name)?;
        let chart = MagneticChart::new(system, potential)?;
        let d = system.dimension();
        let mut ring = Ring::new(2 * d);
        let (mut odd, mut even) = (Vec::new(), Vec::new());
        let potentials: Vec<&Expression> = chart.pairs.iter().map(|p| &p.potential).collect();
        let centre = shifted(&mut ring, &potentials, d, 0)?;
        let ahead = shifted(&mut ring, &potentials, d, 1)?;
        let behind = shifted(&mut ring, &potentials, d, -1)?;
        let half = Rational::new(1, 2);
        for (i, pair) in chart.pairs.iter().enumerate() {
            let mut terms = vec![
                (-&half, ahead[i].clone()),
                (half.clone(), behind[i].clone()),
            ];
            for (j, other) in chart.pairs.iter().enumerate() {
                let slope = ring.derivative(&centre[j], pair.position)?;
                let delta = ring.variable(d + other.position);
                terms.push((&pair.sign * &other.sign, ring.multiply(&slope, &delta)));
            }
            odd.push(ring.combine(&terms));
            even.push(ring.combine(&[
                (half.clone(), ahead[i].clone()),
                (half.clone(), behind[i].clone()),
                (-Rational::one(), centre[i].clone()),
            ]));
        }
        Ok(Self {
            dimension: d,
            series: MagneticSeries::new(d, chart.clone()),
            chart,
            ring,
            odd,
            even,
        })
    }

    /// Positions, momenta and potential.
    pub fn chart(&self) -> &MagneticChart {
        &self.chart
    }
}

/// The potentials at x + `steps`·δ.
fn shifted(
    ring: &mut Ring,
    potentials: &[&Expression],
    d: usize,
    steps: i64,
) -> Result<Vec<Polynomial>, BuildError> {
    let steps = Rational::from_integer(steps);
    let mut values = Vec::with_capacity(potentials.len());
    for potential in potentials {
        values.push(potential.evaluate_in(ring, &mut |ring, at| {
            let (x, delta) = (ring.variable(at), ring.variable(d + at));
            Ok(ring.combine(&[(Rational::one(), x), (steps.clone(), delta)]))
        })?);
    }
    Ok(values)
}

impl RealizationData for DarbouxMagnetic {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }

    fn describe(&self) -> String {
        INFO.name.to_owned()
    }

    fn code(&self) -> Option<&dyn RealizationCode> {
        Some(self)
    }

    fn series(&self) -> Option<&dyn SourceSeries> {
        Some(&self.series)
    }
}

impl RealizationCode for DarbouxMagnetic {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let d = self.dimension;
        let (x, covector) = z.split_at(d);
        let half = Rational::new(1, 2);
        let mut half_step = |at: usize, sign: &Rational| {
            let product = graph.multiply(epsilon, &covector[at]);
            graph.scale(&(&half * sign), &product)
        };
        let pairs = &self.chart.pairs;
        let deltas: Vec<Term> = (pairs.iter())
            .map(|pair| half_step(pair.momentum, &pair.sign))
            .collect();
        let drifts: Vec<Term> = (pairs.iter())
            .map(|pair| half_step(pair.position, &pair.sign))
            .collect();
        let mut variables = x.to_vec();
        variables.resize(2 * d, graph.zero());
        for (pair, delta) in pairs.iter().zip(&deltas) {
            variables[d + pair.position] = delta.clone();
        }
        let one = graph.one();
        let outputs: Vec<_> = (self.odd.iter().chain(&self.even))
            .map(|f| vec![(one.clone(), f.clone())])
            .collect();
        let lifted = lift(graph, &self.ring, &outputs, &variables)?;
        let (odd, even) = lifted.split_at(pairs.len());
        let mut offset = vec![graph.zero(); d];
        let mut increment = offset.clone();
        for (i, pair) in pairs.iter().enumerate() {
            increment[pair.position] = graph.scale(&Rational::from_integer(-2), &deltas[i]);
            offset[pair.position] = deltas[i].clone();
            let odd = graph.add(&drifts[i], &odd[i]);
            increment[pair.momentum] = graph.scale(&Rational::from_integer(2), &odd);
            offset[pair.momentum] = graph.subtract(&even[i], &odd);
        }
        Ok(SourceTarget {
            base: x.to_vec(),
            offset,
            increment,
            guard: None,
        })
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    match parameters.setting(&INFO, "potential")? {
        ParameterSetting::Text(potential) => {
            Ok(Arc::new(DarbouxMagnetic::new(system, &potential)?))
        }
        // A single number is a constant component.
        number => Ok(Arc::new(DarbouxMagnetic::new(system, &number.to_string())?)),
    }
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));

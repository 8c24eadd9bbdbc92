//! The exact realization of a magnetic bracket with a given vector potential.
//!
//! Positions x_i and momenta p_i have {x_i, x_j} = 0, {x_i, p_j} = s_i δ_ij, s_i = ±1, and
//! {p_i, p_j} = B_ij(x). A potential A has B_ij = s_j ∂_j A_i − s_i ∂_i A_j, for the paper's s = −1
//! the curl ∂_i A_j − ∂_j A_i. Then P = p − A(x) are Darboux coordinates: {x_i, P_j} = s_i δ_ij,
//! {P_i, P_j} = 0. The constant realization there is carried back to the original coordinates.

mod chart;

use std::sync::Arc;

use leafwise_core::lattice::StageEnds;
use leafwise_core::part::{
    ParameterDefault, ParameterInfo, ParameterSetting, PartInfo, PartKind, PartParameters,
};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{
    BuildError, ChartPoint, ClosedForm, ClosedRealization, PoissonSystem, RealizationData,
};
use leafwise_expression::graph::lift;
use leafwise_expression::{
    AlgebraError, Arithmetic, Expression, Graph, Polynomial, Rational, Ring, Term,
};

use chart::{MagneticChart, NAME};

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
        summary: "the components of A, one formula a position, such as [\"0\", \"x^3/3\", \"y^2/2 + x*z\"]",
        default: ParameterDefault::Formulas(&[]),
    }],
    ..PartInfo::of(PartKind::Realization)
};

/// α = Φ⁻¹ ∘ α′ ∘ T*Φ for the Darboux map Φ(x, p) = (x, P = p − A(x)) and its cotangent lift T*Φ.
/// Here α′ = X − ½ ε Π′ ξ is the constant realization of Π′ = {X, X}. The lift T*Φ is symplectic
/// and Φ a Poisson isomorphism, so that α is Poisson. And β = α(·, −·), since T*Φ is linear on
/// fibres.
///
/// With covectors (a, b) over (x, p), δ_i = ½ ε s_i b_i and T*Φ: (a, b) ↦ (a + A′ᵀ b, b). The
/// components of α and β are:
///
/// - α_x = x − δ.
/// - α_p = p + ½ ε s a + Σ_j s_i s_j ∂_i A_j δ_j + A_i(x − δ) − A_i(x).
/// - With G and E below, α_p = p + ½ ε s a + G + E.
/// - β_p = p − ½ ε s a − G + E.
/// - G_i = Σ_j s_i s_j ∂_i A_j δ_j − ½ (A_i(x + δ) − A_i(x − δ)), odd in δ.
/// - E_i = ½ (A_i(x + δ) + A_i(x − δ)) − A_i(x), even in δ.
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
}

impl DarbouxMagnetic {
    /// The realization data of a system's tensor with the potential A, one formula a position,
    /// separated by `;`.
    ///
    /// # Errors
    /// Returns [`BuildError::DoesNotFit`] when the bracket is not magnetic. Returns it too when a
    /// pair of momenta does not commute. Returns [`BuildError::Parameter`] when the potential is
    /// missing, is no formula or has another number of components. Returns [`BuildError::Algebra`]
    /// where a formula has no normal form.
    pub fn realize(
        system: &PoissonSystem,
        potential: &str,
    ) -> Result<ClosedRealization<Self>, BuildError> {
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
        let form = Self {
            dimension: d,
            chart,
            ring,
            odd,
            even,
        };
        ClosedRealization::new(INFO.name, form)
    }
}

/// ½ ε s times a component of the covector.
fn half_step<A: Arithmetic>(
    algebra: &mut A,
    at: &ChartPoint<'_, A::Element>,
    component: usize,
    sign: &Rational,
) -> A::Element {
    let product = algebra.multiply(at.epsilon, &at.p[component]);
    algebra.scale(&(&Rational::new(1, 2) * sign), &product)
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

impl ClosedForm for DarbouxMagnetic {
    fn dimension(&self) -> usize {
        self.dimension
    }

    /// s_i s_j ∂_i A_j, row by row.
    fn functions(&self, ring: &mut Ring) -> Result<Vec<Polynomial>, BuildError> {
        let pairs = &self.chart.pairs;
        let mut slopes = Vec::with_capacity(pairs.len() * pairs.len());
        for a in pairs {
            for b in pairs {
                let potential = &b.potential;
                let potential =
                    potential.evaluate_in(ring, &mut |ring, at| Ok(ring.variable(at)))?;
                let slope = ring.derivative(&potential, a.position)?;
                slopes.push(ring.scale(&(&a.sign * &b.sign), &slope));
            }
        }
        Ok(slopes)
    }

    fn source<A: Arithmetic>(
        &self,
        algebra: &mut A,
        at: &ChartPoint<'_, A::Element>,
    ) -> Result<Vec<A::Element>, AlgebraError> {
        let pairs = &self.chart.pairs;
        let mut source = at.x.to_vec();
        let mut deltas = Vec::with_capacity(pairs.len());
        for pair in pairs {
            let delta = half_step(algebra, at, pair.momentum, &pair.sign);
            source[pair.position] = algebra.subtract(&at.x[pair.position], &delta);
            deltas.push(delta);
        }
        let moved = source.clone();
        for (i, pair) in pairs.iter().enumerate() {
            let potential = &pair.potential;
            let ahead = potential.evaluate_in(algebra, &mut |_, index| Ok(moved[index].clone()))?;
            let here = potential.evaluate_in(algebra, &mut |_, index| Ok(at.x[index].clone()))?;
            let one = Rational::one();
            let mut terms = vec![
                (one.clone(), at.x[pair.momentum].clone()),
                (
                    one.clone(),
                    half_step(algebra, at, pair.position, &pair.sign),
                ),
                (one.clone(), ahead),
                (-&one, here),
            ];
            for (slope, delta) in at.functions[i * pairs.len()..].iter().zip(&deltas) {
                terms.push((one.clone(), algebra.multiply(slope, delta)));
            }
            source[pair.momentum] = algebra.combine(&terms);
        }
        Ok(source)
    }

    fn ends(
        &self,
        graph: &mut Graph,
        at: &ChartPoint<'_, Term>,
    ) -> Result<StageEnds, AlgebraError> {
        let d = self.dimension;
        let pairs = &self.chart.pairs;
        let mut deltas = Vec::with_capacity(pairs.len());
        let mut drifts = Vec::with_capacity(pairs.len());
        for pair in pairs {
            deltas.push(half_step(graph, at, pair.momentum, &pair.sign));
            drifts.push(half_step(graph, at, pair.position, &pair.sign));
        }
        let mut variables = at.x.to_vec();
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
        Ok(StageEnds { offset, increment })
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    match parameters.setting(&INFO, "potential")? {
        ParameterSetting::Text(potential) => {
            Ok(Arc::new(DarbouxMagnetic::realize(system, &potential)?))
        }
        // A single number is a constant component.
        number => Ok(Arc::new(DarbouxMagnetic::realize(
            system,
            &number.to_string(),
        )?)),
    }
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));

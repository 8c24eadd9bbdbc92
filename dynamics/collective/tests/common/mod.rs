//! Systems, realizations and runs shared by the claims.

use std::collections::BTreeMap;
use std::sync::Arc;

use leafwise_collective::{Collective, SymplecticIntegrator};
use leafwise_core::{
    Abilities, Accuracy, BuildError, Convention, Correction, EndMaps, Method, PoissonSystem,
    RealizationData, SourceTarget, Space, SpaceChart, StepMap, Stepper, Walk,
};
use leafwise_expression::syntax::{Formula, Scope};
use leafwise_expression::{Arithmetic, Expression, Graph, Rational, Term};
use leafwise_karasev::TruncatedKarasev;

/// A system of three variables in the paper's convention, with one Casimir.
fn system(bracket: [&str; 3], hamiltonian: &str, casimir: &str) -> PoissonSystem {
    let scope = Scope::new().with_variables(&["x1", "x2", "x3"]);
    let formula = |text: &str| -> Expression {
        let formula = Formula::parse(text).expect("a formula");
        let resolved = formula.resolve(&scope, None).expect("known names");
        resolved.expect("a formula without sites")
    };
    let casimir = leafwise_core::system::Casimir {
        name: "casimir".to_owned(),
        expression: formula(casimir),
    };
    let entries = [(0, 1), (0, 2), (1, 2)].into_iter();
    let entries: BTreeMap<_, _> = entries.zip(bracket.map(formula)).collect();
    PoissonSystem::new(
        ["x1", "x2", "x3"].map(str::to_owned).to_vec(),
        Vec::new(),
        entries,
        formula(hamiltonian),
        vec![casimir],
        Convention::HamiltonianFirst,
    )
    .expect("a system")
}

/// The paper's Example 1.
pub fn rigid_body() -> PoissonSystem {
    system(
        ["-x3", "x2", "-x1"],
        "x1^2/2 + x2^2/1.5 + x3^2/2.5",
        "x1^2 + x2^2 + x3^2",
    )
}

/// Cohen and Hairer's bounded Lotka–Volterra system.
pub fn lotka_volterra() -> PoissonSystem {
    system(
        ["-x1*x2/2", "x1*x3/2", "-x2*x3"],
        "2*x1 + x2 + 2*x3 + ln(x2) - 2*ln(x3)",
        "2*ln(x1) + ln(x2) + ln(x3)",
    )
}

/// The flows over time 1 from (1, 3, 3) and (1, 1.9, 0.5): Taylor integration at 50 digits.
pub const RIGID_BODY_FLOW: ([f64; 3], [f64; 3]) = (
    [1.0, 3.0, 3.0],
    [3.7894873027779745, 1.9974783461358703, 0.8061428153887003],
);
pub const LOTKA_VOLTERRA_FLOW: ([f64; 3], [f64; 3]) = (
    [1.0, 1.9, 0.5],
    [3.777407973183465, 0.0675783869637859, 0.9852081563067037],
);

/// Karasev's realization of order n.
pub fn karasev(system: &PoissonSystem, order: usize) -> Arc<dyn RealizationData> {
    Arc::new(TruncatedKarasev::new(system, order).expect("an order of at least 1"))
}

fn cross(graph: &mut Graph, a: &[Term], b: &[Term]) -> Vec<Term> {
    [(1, 2), (2, 0), (0, 1)]
        .map(|(i, j)| {
            let (left, right) = (graph.multiply(&a[i], &b[j]), graph.multiply(&a[j], &b[i]));
            graph.subtract(&left, &right)
        })
        .to_vec()
}

fn dot(graph: &mut Graph, a: &[Term], b: &[Term]) -> Term {
    let products: Vec<_> = a
        .iter()
        .zip(b)
        .map(|(a, b)| (Rational::one(), graph.multiply(a, b)))
        .collect();
    graph.combine(&products)
}

/// so(3)* in the Cayley chart, exact: α = x − ½ x×q + ¼ q (q·x) with q = εp, β = α(x, −p).
#[derive(Debug)]
pub struct Cayley;

impl RealizationData for Cayley {
    fn dimension(&self) -> usize {
        3
    }
    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }
    fn describe(&self) -> String {
        "so(3)* in the Cayley chart".to_owned()
    }
    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            ends: Some(EndMaps::Code(Box::new(|graph, epsilon, z| {
                self.source_and_target(graph, epsilon, z)
            }))),
            ..Abilities::default()
        }
    }
}

impl Cayley {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let (x, p) = z.split_at(3);
        let q: Vec<Term> = p.iter().map(|p| graph.multiply(epsilon, p)).collect();
        let turned = cross(graph, x, &q);
        let along = dot(graph, x, &q);
        let mut offset = Vec::new();
        for (turned, q) in turned.iter().zip(&q) {
            let even = graph.multiply(&along, q);
            let parts = [
                (Rational::new(1, 2), turned.clone()),
                (Rational::new(1, 4), even),
            ];
            offset.push(graph.combine(&parts));
        }
        Ok(SourceTarget {
            base: x.to_vec(),
            offset,
            increment: turned.iter().map(|t| graph.negate(t)).collect(),
            guard: None,
        })
    }
}

/// The same on T*SO(3) itself: points (1/(1 + |w|²), w, m), w the Gibbs vector of a rotation R, with
/// α = m and β = Rᵀm; the Cayley chart is χ(x, p) = (…, εp/2, α(x, p)).
#[derive(Debug)]
pub struct Rotations;

impl RealizationData for Rotations {
    fn dimension(&self) -> usize {
        3
    }
    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }
    fn describe(&self) -> String {
        "rotations and momenta".to_owned()
    }
    fn section(&self, x: &[f64], z: &mut [f64]) {
        z[..4].copy_from_slice(&[1.0, 0.0, 0.0, 0.0]);
        z[4..].copy_from_slice(x);
    }
    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            space: Space::Points {
                coordinates: 7,
                chart: Some(SpaceChart::Code(Box::new(|graph, epsilon, x, p| {
                    self.point(graph, epsilon, x, p)
                }))),
            },
            ends: Some(EndMaps::Code(Box::new(|graph, epsilon, z| {
                self.source_and_target(graph, epsilon, z)
            }))),
            ..Abilities::default()
        }
    }
}

impl Rotations {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        _epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let (scale, w, m) = (&z[0], &z[1..4], &z[4..7]);
        // R = 1 + 2 (1 + |w|²)⁻¹ ([w] + [w]²), so m − Rᵀm = 2 (1 + |w|²)⁻¹ (w×m − w×(w×m)).
        let once = cross(graph, w, m);
        let twice = cross(graph, w, &once);
        let mut increment = Vec::new();
        for (once, twice) in once.iter().zip(&twice) {
            let difference = graph.subtract(once, twice);
            let product = graph.multiply(scale, &difference);
            increment.push(graph.scale(&Rational::from_integer(2), &product));
        }
        Ok(SourceTarget {
            base: m.to_vec(),
            offset: increment.iter().map(|i| graph.negate(i)).collect(),
            increment,
            guard: None,
        })
    }
}

impl Rotations {
    fn point(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        x: &[Term],
        p: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let half = graph.scale(&Rational::new(1, 2), epsilon);
        let w: Vec<Term> = p.iter().map(|p| graph.multiply(&half, p)).collect();
        let one = graph.one();
        let square = dot(graph, &w, &w);
        let sum = graph.add(&one, &square);
        let z = [x, p].concat();
        let ends = Cayley.source_and_target(graph, epsilon, &z)?;
        let mut point = vec![graph.divide(&one, &sum)?];
        point.extend(w);
        for i in 0..3 {
            let parts = [&ends.base[i], &ends.offset[i], &ends.increment[i]];
            point.push(graph.combine(&parts.map(|part| (Rational::one(), part.clone()))));
        }
        Ok(point)
    }
}

/// A collective method.
pub fn method(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    integrator: SymplecticIntegrator,
    correction: Correction,
) -> Method {
    let dynamics = Collective::new(integrator, correction).expect("few stages");
    Method::compose(system, Arc::clone(realization), Arc::new(dynamics)).expect("the parts fit")
}

/// The state after `steps` steps of ε h = t.
pub fn run(map: &dyn StepMap, t: f64, steps: usize, initial: &[f64]) -> Vec<f64> {
    let mut integrator = Walk::new(map, &[], 0.5, 2.0 * t, initial);
    for _ in 0..steps {
        integrator.step().expect("a step that converges");
    }
    integrator.state().to_vec()
}

/// One step of a stepper.
pub fn advance(stepper: &mut dyn Stepper, x: &mut [f64; 3]) {
    let mut increment = [0.0; 3];
    let mut outcome = [Ok(())];
    stepper.increment(x, &[0.0; 3], &mut increment, &mut outcome);
    assert_eq!(outcome, [Ok(())]);
    x.iter_mut().zip(increment).for_each(|(x, i)| *x += i);
}

/// The Euclidean distance of two states.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    libm::sqrt(squares.sum())
}

/// Every integrator of order up to 8.
pub const INTEGRATORS: [SymplecticIntegrator; 6] = [
    SymplecticIntegrator::StormerVerlet,
    SymplecticIntegrator::ImplicitMidpoint,
    SymplecticIntegrator::Gauss(1),
    SymplecticIntegrator::Gauss(2),
    SymplecticIntegrator::Gauss(3),
    SymplecticIntegrator::Gauss(4),
];

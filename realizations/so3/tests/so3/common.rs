//! Rigid bodies on so(3)*, the maps of a realization as numbers, and an oracle for the motion.

use std::sync::Arc;

use leafwise_core::part::PartParameters;
use leafwise_core::realization::{Abilities, Accuracy, EndMaps, RealizationData, SourceTarget};
use leafwise_core::system::Parameter;
use leafwise_core::{BuildError, Convention, PoissonSystem, Registry};
use leafwise_expression::{Expression, Graph, Kernel, Rational, StepSize, Term};
use leafwise_so3::{Chart, So3Group};
pub use leafwise_tests::numbers::{UNIT_ROUNDOFF as UNIT, distance, largest};
use proptest::prelude::*;

/// 1, 3/4 and 5/4, the inertia of the paper's body.
pub const INERTIA: [f64; 3] = [1.0, 0.75, 1.25];

pub fn constant(numerator: i64, denominator: i64) -> Expression {
    Expression::Constant(Rational::new(numerator, denominator))
}

pub fn product(factors: Vec<Expression>) -> Expression {
    Expression::Product(factors)
}

/// {x1,x2} = −λ x3 cyclic, as entries above the diagonal.
pub fn bracket(lambda: &Expression) -> Vec<((usize, usize), Expression)> {
    let entry = |sign: i64, k: usize| {
        product(vec![
            constant(sign, 1),
            lambda.clone(),
            Expression::Variable(k),
        ])
    };
    vec![
        ((0, 1), entry(-1, 2)),
        ((1, 2), entry(-1, 0)),
        ((0, 2), entry(1, 1)),
    ]
}

/// A system with the body's Hamiltonian Σ x_i²/2I_i on these entries; one parameter `a` = 3/2.
pub fn system(
    dimension: usize,
    bracket: Vec<((usize, usize), Expression)>,
    convention: Convention,
) -> Result<PoissonSystem, BuildError> {
    let squares = [(1, 2), (2, 3), (2, 5)]
        .into_iter()
        .enumerate()
        .map(|(i, (a, b))| {
            let variable = Expression::Variable(i);
            product(vec![constant(a, b), variable.clone(), variable])
        });
    PoissonSystem::new(
        (1..=dimension).map(|i| format!("x{i}")).collect(),
        vec![Parameter {
            name: "a".to_owned(),
            value: 1.5,
        }],
        bracket,
        Expression::Sum(squares.collect()),
        Vec::new(),
        convention,
    )
}

/// The paper's rigid body.
pub fn body() -> PoissonSystem {
    system(3, bracket(&constant(1, 1)), Convention::HamiltonianFirst).expect("a system")
}

/// A part of this crate by name.
pub fn part(
    system: &PoissonSystem,
    name: &str,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    Registry::with_builtin()
        .realization(name)?
        .build(system, parameters)
}

/// The four realizations of this crate.
pub fn all(system: &PoissonSystem) -> Vec<Arc<dyn RealizationData>> {
    [Chart::Exponential, Chart::Cayley]
        .into_iter()
        .flat_map(|chart| -> [Arc<dyn RealizationData>; 2] {
            [
                chart.realize(system).expect("so(3)*"),
                Arc::new(So3Group::new(system, chart).expect("so(3)*")),
            ]
        })
        .collect()
}

/// α∘χ and β∘χ as a realization on T*M, so that instruments of T*M judge a realization through its
/// chart; and one realization's maps with another's series.
#[derive(Clone, Debug)]
pub struct ThroughChart {
    pub maps: Arc<dyn RealizationData>,
    pub series: Arc<dyn RealizationData>,
}

impl RealizationData for ThroughChart {
    fn dimension(&self) -> usize {
        3
    }
    fn accuracy(&self) -> Accuracy {
        self.maps.accuracy()
    }
    fn describe(&self) -> String {
        format!("{} through its chart", self.maps.describe())
    }
    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            ends: Some(EndMaps::Code(Box::new(|graph, epsilon, z| {
                self.source_and_target(graph, epsilon, z)
            }))),
            series: self.series.abilities().series,
            ..Abilities::default()
        }
    }
}

impl ThroughChart {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let code = self.maps.abilities().code().expect("code");
        match self.maps.abilities().space.chart_code() {
            None => code(graph, epsilon, z),
            Some(chart) => {
                let (x, p) = z.split_at(3);
                let point = chart(graph, epsilon, x, p)?;
                code(graph, epsilon, &point)
            }
        }
    }
}

/// A realization seen from T*M.
pub fn on_cotangent(maps: &Arc<dyn RealizationData>) -> Arc<dyn RealizationData> {
    Arc::new(ThroughChart {
        maps: Arc::clone(maps),
        series: Arc::clone(maps),
    })
}

/// base, offset and increment of a realization's code at z.
pub fn parts_at(realization: &dyn RealizationData, epsilon: f64, z: &[f64]) -> [Vec<f64>; 3] {
    let mut graph = Graph::new();
    let inputs: Vec<Term> = (0..z.len()).map(|i| graph.input(i)).collect();
    let size = graph.step_size(StepSize::Epsilon);
    let code = realization.abilities().code().expect("code");
    let ends = code(&mut graph, &size, &inputs).expect("code");
    let outputs = [ends.base, ends.offset, ends.increment].concat();
    let kernel = Kernel::compile(&graph, &outputs, 1, z.len());
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &[1.5], &[epsilon], &[1.0]);
    let mut values = vec![0.0; 9];
    kernel.evaluate(&mut workspace, z, &mut values);
    [0, 3, 6].map(|from| values[from..from + 3].to_vec())
}

/// (α, β) at z.
pub fn ends_at(realization: &dyn RealizationData, epsilon: f64, z: &[f64]) -> [Vec<f64>; 2] {
    let [base, offset, increment] = parts_at(realization, epsilon, z);
    let target = sum(&base, &offset);
    [sum(&target, &increment), target]
}

pub fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

pub fn norm(v: &[f64]) -> f64 {
    libm::sqrt(v.iter().map(|v| v * v).sum())
}

/// Three numbers of size 0.2 to 2 with any signs.
pub fn state() -> impl Strategy<Value = Vec<f64>> {
    let coordinate =
        (0.2..2.0_f64, any::<bool>()).prop_map(|(v, minus)| if minus { -v } else { v });
    proptest::collection::vec(coordinate, 3)
}

/// A vector of any direction, of length `shortest` to `longest`.
pub fn momentum(shortest: f64, longest: f64) -> impl Strategy<Value = Vec<f64>> {
    (state(), shortest..longest).prop_map(|(direction, length)| {
        let size = norm(&direction);
        direction.iter().map(|v| v * length / size).collect()
    })
}

/// The flow of ẋ = −x × ω, ω_i = x_i/I_i, over `time`: the classical Runge–Kutta method in
/// 6·10⁴ compensated steps, error near 1e-15 a unit of time.
pub fn flow(initial: &[f64], time: f64) -> Vec<f64> {
    const STEPS: usize = 60_000;
    let field = |x: &[f64]| -> Vec<f64> {
        let omega: Vec<f64> = x.iter().zip(INERTIA).map(|(x, i)| x / i).collect();
        (0..3)
            .map(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                x[k] * omega[j] - x[j] * omega[k]
            })
            .collect()
    };
    let ahead = |x: &[f64], v: &[f64], t: f64| -> Vec<f64> {
        x.iter().zip(v).map(|(x, v)| x + t * v).collect()
    };
    let h = time / STEPS as f64;
    let (mut x, mut low) = (initial.to_vec(), vec![0.0; 3]);
    for _ in 0..STEPS {
        let a = field(&x);
        let b = field(&ahead(&x, &a, 0.5 * h));
        let c = field(&ahead(&x, &b, 0.5 * h));
        let d = field(&ahead(&x, &c, h));
        for i in 0..3 {
            let change = low[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]);
            let next = x[i] + change;
            low[i] = change - (next - x[i]);
            x[i] = next;
        }
    }
    x
}

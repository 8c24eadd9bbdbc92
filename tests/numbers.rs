//! Realizations that offer numbers alone, with and without tangents, as pairs (x, p) and through a
//! chart: the steps are those of the same realization with formulas.

use std::sync::Arc;

use leafwise::core::{
    Abilities, Accuracy, BuildError, ChartMaps, DynamicApproximation, DynamicsProperties, EndMaps,
    EndNumbers, Evaluator, LagrangianBisection, Method, PartParameters, PoissonSystem,
    RealizationData, RealizationMaps, Registry, Space, SpaceChart, StepError, StepMap, Structure,
};
use leafwise_tests::library;
use leafwise_tests::numbers::distance;

/// A realization whose formulas are hidden.
#[derive(Debug)]
struct Numbers {
    inner: Arc<dyn RealizationData>,
    maps: RealizationMaps,
    chart: Option<ChartMaps>,
    has_tangents: bool,
    is_reversible: bool,
}

impl Numbers {
    fn of(name: &str, system: &PoissonSystem) -> Self {
        let part = Registry::with_builtin()
            .realization(name)
            .expect("a built-in part");
        let inner = part.build(system, &PartParameters::new()).expect("it fits");
        let values = system.parameter_values();
        Self {
            maps: RealizationMaps::new(inner.as_ref(), values.len()).expect("it has maps"),
            chart: ChartMaps::of(inner.as_ref(), values.len()).expect("it has code"),
            inner,
            has_tangents: true,
            is_reversible: true,
        }
    }
}

impl RealizationData for Numbers {
    fn dimension(&self) -> usize {
        self.inner.dimension()
    }
    fn accuracy(&self) -> Accuracy {
        self.inner.accuracy()
    }
    fn describe(&self) -> String {
        "numbers".to_owned()
    }
    fn section(&self, x: &[f64], z: &mut [f64]) {
        self.inner.section(x, z);
    }
    fn abilities(&self) -> Abilities<'_> {
        let (maps, has_tangents) = (self.maps.clone(), self.has_tangents);
        let space = match (&self.chart, self.inner.abilities().space) {
            (_, Space::Pairs) => Space::Pairs,
            (chart, Space::Points { coordinates, .. }) => Space::Points {
                coordinates,
                chart: match chart {
                    Some(ChartMaps::Map(map)) => Some(SpaceChart::Numbers(map.clone())),
                    _ => None,
                },
            },
        };
        Abilities {
            space,
            is_reversible: self.is_reversible,
            ends: Some(EndMaps::Numbers(EndNumbers::new(
                has_tangents,
                move |parameters, epsilon| {
                    Box::new(InnerEvaluator {
                        inner: maps.evaluator(parameters, epsilon),
                        has_tangents,
                    })
                },
            ))),
            ..Abilities::default()
        }
    }
}

struct InnerEvaluator {
    inner: Box<dyn Evaluator>,
    has_tangents: bool,
}

impl Evaluator for InnerEvaluator {
    fn values(&mut self, z: &[f64], ends: &mut [f64]) -> Result<(), StepError> {
        self.inner.values(z, ends)
    }
    fn jacobians(&mut self, z: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        if !self.has_tangents {
            return Err(StepError::NoTangent);
        }
        self.inner.jacobians(z, tangents)
    }

    fn operations(&self) -> Option<u64> {
        None
    }
}

fn with_hamilton_jacobi(
    system: &PoissonSystem,
    realization: Arc<dyn RealizationData>,
    order: i64,
) -> Result<Method, BuildError> {
    Method::compose(system, realization, hamilton_jacobi(order)?)
}

fn hamilton_jacobi(order: i64) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
    let part = Registry::with_builtin().dynamics("hamilton-jacobi")?;
    part.build(&PartParameters::new().with("order", order))
}

/// Steps, each cold; the tangent of the last.
fn orbit(system: &PoissonSystem, method: &Method, h: f64) -> (Vec<f64>, Option<Vec<f64>>) {
    let mut stepper = method.stepper(1, &system.parameter_values(), 1.0, h);
    let mut x = vec![1.0, 3.0, 3.0];
    let mut increment = vec![0.0; 3];
    let mut outcome = [Ok(())];
    for _ in 0..50 {
        stepper.restart();
        stepper.increment(&x, &[0.0; 3], &mut increment, &mut outcome);
        assert_eq!(outcome, [Ok(())]);
        x.iter_mut().zip(&increment).for_each(|(x, i)| *x += i);
    }
    (x, stepper.tangent(0))
}

/// Fifty steps that agree to a few units of round-off each.
const ROUND_OFF: f64 = 50.0 * 4.0 * f64::EPSILON;

#[test]
fn values_alone_give_the_steps_of_the_formulas() {
    let system = library("rigid-body").system;
    for name in ["so3-exponential", "so3-cayley", "so3-group"] {
        let whole = Numbers::of(name, &system);
        let expected = with_hamilton_jacobi(&system, Arc::clone(&whole.inner), 2);
        let expected = expected.expect("a method");
        let (state, tangent) = orbit(&system, &expected, 0.1);
        let tangent = tangent.expect("code has derivatives");
        for has_tangents in [true, false] {
            let numbers = Numbers {
                has_tangents,
                ..Numbers::of(name, &system)
            };
            let method = with_hamilton_jacobi(&system, Arc::new(numbers), 2).expect("a method");
            assert_eq!(method.path(), "evaluators");
            assert_eq!(method.properties(), expected.properties());
            let (found, own) = orbit(&system, &method, 0.1);
            let error = distance(&found, &state);
            assert!(
                error <= ROUND_OFF * 5.0,
                "{name}, tangents {has_tangents}: {error:e}"
            );
            assert_eq!(own.is_some(), has_tangents);
            let own = own.unwrap_or_else(|| tangent.clone());
            assert!(distance(&own, &tangent) <= ROUND_OFF * 5.0, "{name}");
        }
    }
}

#[test]
fn what_values_cannot_give_is_refused_by_name() {
    let system = library("rigid-body").system;
    let refusal = |change: fn(&mut Numbers), name: &str, order: i64| {
        let mut numbers = Numbers::of(name, &system);
        change(&mut numbers);
        let refused = with_hamilton_jacobi(&system, Arc::new(numbers), order);
        refused.expect_err("it lacks something").to_string()
    };
    let text = refusal(|_| {}, "so3-cayley", 4);
    assert!(
        text.contains("no series of its source map; order 2"),
        "{text}"
    );
    let text = refusal(|n| n.is_reversible = false, "so3-cayley", 2);
    assert!(text.contains("beta(x, p) is not alpha(x, -p)"), "{text}");
    let text = refusal(|n| n.chart = None, "so3-group", 2);
    assert!(text.contains("no symplectic chart"), "{text}");
}

/// Hamilton–Jacobi over one realization, whatever it is combined with; not said to be Lagrangian.
#[derive(Debug)]
struct Careless {
    inner: Arc<dyn DynamicApproximation>,
    over: Arc<dyn RealizationData>,
}

impl DynamicApproximation for Careless {
    fn properties(&self) -> DynamicsProperties {
        DynamicsProperties {
            is_lagrangian: false,
            ..self.inner.properties()
        }
    }
    fn describe(&self) -> String {
        "careless".to_owned()
    }
    fn bisection(
        &self,
        system: &PoissonSystem,
        _: &Arc<dyn RealizationData>,
    ) -> Result<LagrangianBisection, BuildError> {
        self.inner.bisection(system, &self.over)
    }
}

#[test]
fn a_method_promises_no_more_than_its_parts() {
    let system = library("rigid-body").system;
    for is_reversible in [true, false] {
        let mut numbers = Numbers::of("so3-cayley", &system);
        numbers.is_reversible = is_reversible;
        let careless = Careless {
            inner: hamilton_jacobi(2).expect("a built-in part"),
            over: Arc::clone(&numbers.inner),
        };
        let method = Method::compose(&system, Arc::new(numbers), Arc::new(careless));
        let promised = method.expect("a method").properties();
        assert_eq!(promised.structure, Structure::Leaves);
        assert_eq!(promised.self_adjoint, is_reversible.then_some(true));
    }
}

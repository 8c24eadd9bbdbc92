//! Methods and systems of these tests.

use std::sync::Arc;

use leafwise_clebsch::Clebsch;
use leafwise_clebsch::algebras::known;
use leafwise_collective::{Collective, SymplecticIntegrator};
use leafwise_core::{
    BuildError, Correction, LiftedRealization, Method, PoissonSystem, RealizationData, Registry,
    StepMap, Walk,
};
use leafwise_tests::systems::from_formulas;

/// `clebsch` for a system.
pub fn realize(system: &PoissonSystem) -> Result<LiftedRealization, BuildError> {
    Clebsch::realize(system, &Registry::with_builtin())
}

/// A Gauss method of s stages over a realization.
pub fn over(system: &PoissonSystem, realization: LiftedRealization, stages: usize) -> Method {
    let walk = SymplecticIntegrator::Gauss(stages);
    let dynamics = Collective::new(walk, Correction::Bisection).expect("stages");
    let realization: Arc<dyn RealizationData> = Arc::new(realization);
    Method::compose(system, realization, Arc::new(dynamics)).expect("a method")
}

/// A Gauss method of s stages over `clebsch`.
pub fn gauss(system: &PoissonSystem, stages: usize) -> Method {
    over(system, realize(system).expect("an algebra"), stages)
}

/// x1 … xd.
pub fn names(d: usize) -> Vec<String> {
    (1..=d).map(|i| format!("x{i}")).collect()
}

/// A system on the dual of a known algebra, its variables in that order, brackets times a parameter k.
pub fn on_algebra(name: &str, hamiltonian: &str, casimirs: &[(&str, &str)]) -> PoissonSystem {
    let mut algebras = known().iter();
    let known = algebras
        .find(|known| known.algebra.name == name)
        .expect("an algebra");
    let d = known.constants().dimension();
    let names = names(d);
    let mut bracket = Vec::new();
    for i in 0..d {
        for j in i + 1..d {
            let terms = known.constants().bracket(i, j).iter();
            let terms = terms.map(|(k, c)| format!("({c})*x{}", k + 1));
            let terms: Vec<String> = terms.collect();
            if !terms.is_empty() {
                let entry = format!("k*({})", terms.join(" + "));
                bracket.push((format!("x{},x{}", i + 1, j + 1), entry));
            }
        }
    }
    let bracket: Vec<(&str, &str)> = bracket
        .iter()
        .map(|(at, entry)| (at.as_str(), entry.as_str()))
        .collect();
    let variables: Vec<&str> = names.iter().map(String::as_str).collect();
    from_formulas(&variables, &[("k", -1.3)], &bracket, hamiltonian, casimirs)
}

/// One step forth and one back from x: how far from x.
pub fn there_and_back(
    system: &PoissonSystem,
    method: &dyn StepMap,
    time_step: f64,
    x: &[f64],
) -> f64 {
    let parameters = system.parameter_values();
    let mut there = Walk::new(method, &parameters, 1.0, time_step, x);
    there.step().expect("a step");
    let mut back = Walk::new(method, &parameters, 1.0, -time_step, there.state());
    back.step().expect("a step");
    leafwise_tests::numbers::distance(back.state(), x)
}

//! Small systems that parts are tried on, with realizations in closed form.

use std::fmt::Write as _;
use std::sync::Arc;

use leafwise_core::part_description::PartDescription;
use leafwise_core::{PartKind, PartParameters, PoissonSystem, RealizationData};
use leafwise_plugin_abi::{LW_FLAG_COTANGENT_CHART, LW_FLAG_EXACT, LW_FLAG_REVERSIBLE};
use leafwise_scene::compose::system_of_fragment;

use crate::declaration::{Dimensions, Flags, PartDeclaration};
use crate::foreign::HostObjects;
use crate::formulas::FormulaRealizationPart;
use crate::host::HostSystem;

/// A system with an exact realization.
#[derive(Clone, Debug)]
pub(crate) struct TestProblem {
    /// Its name in reports.
    pub name: String,
    /// (M, π, H).
    pub system: PoissonSystem,
    /// An exact realization of it.
    pub realization: Arc<dyn RealizationData>,
}

/// The dimensions tried, beside the smallest that a part serves.
const DIMENSIONS: [usize; 4] = [3, 2, 4, 6];

/// Problems in a few of these dimensions.
pub(crate) fn problems(dimensions: Dimensions) -> Vec<TestProblem> {
    let mut tried: Vec<usize> = DIMENSIONS
        .into_iter()
        .filter(|d| dimensions.contains(*d))
        .collect();
    if !tried.contains(&dimensions.least) && dimensions.least <= 64 {
        tried.push(dimensions.least);
    }
    tried.into_iter().flat_map(of_dimension).collect()
}

/// The system of a problem, lent to an instance.
pub(super) fn lend(problem: &TestProblem) -> Option<HostObjects> {
    let system = HostSystem::new(&problem.system, &problem.system.parameter_values());
    Some(HostObjects {
        system: Some(system.ok()?),
        ..HostObjects::default()
    })
}

fn of_dimension(d: usize) -> Vec<TestProblem> {
    let mut problems = Vec::new();
    if d == 3 {
        problems.push(rotations());
        problems.push(lotka_volterra());
    }
    problems.push(canonical(d));
    problems
}

/// so(3)*, the Cayley chart: α = x − ½ x×q + ¼ q (q·x), q = εp.
fn rotations() -> TestProblem {
    let fragment = "[system]\nvariables = [\"x1\", \"x2\", \"x3\"]\n\
                    bracket = { \"x1,x2\" = \"-x3\", \"x2,x3\" = \"-x1\", \"x3,x1\" = \"-x2\" }\n\
                    hamiltonian = \"x1^2/2 + x2^2 + 3*x3^2/2\"\n\
                    casimirs = { spin = \"x1^2 + x2^2 + x3^2\" }\n";
    let alpha = (0..3).map(|i| {
        let [a, b, c] = [i, (i + 1) % 3, (i + 2) % 3].map(|k| k + 1);
        let cross = format!("epsilon*(x{b}*p{c} - x{c}*p{b})/2");
        format!("x{a} - {cross} + epsilon^2*p{a}*(p1*x1 + p2*x2 + p3*x3)/4")
    });
    problem("so(3)*", fragment, alpha.collect())
}

/// A log-canonical tensor: αᵢ = xᵢ exp(−½ ε Σ aᵢⱼ xⱼ pⱼ).
fn lotka_volterra() -> TestProblem {
    let fragment = "[system]\nvariables = [\"x1\", \"x2\", \"x3\"]\n\
                    bracket = { log-canonical = [[0, 1, 2], [-1, 0, -1], [-2, 1, 0]] }\n\
                    hamiltonian = \"x1 + x2 + x3 - ln(x2)\"\n";
    let sums = ["x2*p2 + 2*x3*p3", "-x1*p1 - x3*p3", "-2*x1*p1 + x2*p2"];
    let alpha = sums
        .iter()
        .enumerate()
        .map(|(i, sum)| format!("x{}*exp(-epsilon*({sum})/2)", i + 1));
    problem("log-canonical", fragment, alpha.collect())
}

/// {x₁, x₂} = {x₃, x₄} = … = 1, a last variable without partner being a Casimir: α = x − ½ ε Π p.
fn canonical(d: usize) -> TestProblem {
    let names: Vec<String> = (1..=d).map(|i| format!("\"x{i}\"")).collect();
    let mut bracket = String::new();
    let mut alpha = Vec::with_capacity(d);
    for i in (1..=d).step_by(2) {
        if i == d {
            alpha.push(format!("x{i}"));
            continue;
        }
        let j = i + 1;
        write!(bracket, "\"x{i},x{j}\" = \"1\", ").expect("a string takes any text");
        alpha.push(format!("x{i} - epsilon*p{j}/2"));
        alpha.push(format!("x{j} + epsilon*p{i}/2"));
    }
    let squares: Vec<String> = (1..=d).map(|i| format!("x{i}^2/2")).collect();
    let fragment = format!(
        "[system]\nvariables = [{}]\nbracket = {{ {} }}\nhamiltonian = \"{} + x1^4/4\"\n",
        names.join(", "),
        bracket.trim_end_matches(", "),
        squares.join(" + ")
    );
    problem(&format!("canonical, d = {d}"), &fragment, alpha)
}

fn problem(name: &str, fragment: &str, alpha: Vec<String>) -> TestProblem {
    let system = system_of_fragment(name, fragment).expect("a test system is well formed");
    let keyed = alpha.into_iter().enumerate();
    let declaration = PartDeclaration {
        description: PartDescription {
            name: format!("the exact realization of {name}"),
            kind: PartKind::Realization,
            summary: String::new(),
            declares: String::new(),
            domain: String::new(),
            literature: String::new(),
            parameters: Vec::new(),
        },
        order: 0,
        structure: 0,
        dimensions: Dimensions {
            least: 1,
            most: None,
        },
        flags: Flags(LW_FLAG_COTANGENT_CHART | LW_FLAG_EXACT | LW_FLAG_REVERSIBLE),
        formulas: keyed
            .map(|(i, alpha)| (format!("alpha.{}", i + 1), alpha))
            .collect(),
        functions: None,
    };
    let part = FormulaRealizationPart::new(&declaration, declaration.info());
    let part = part.expect("a test realization is well formed");
    let realization = part.build(&system, &PartParameters::new());
    TestProblem {
        name: name.to_owned(),
        realization: realization.expect("a test realization fits"),
        system,
    }
}

#[cfg(test)]
mod tests {
    use leafwise_core::diagnostics::{RealizationInstrument, section_defect};

    use super::*;
    use crate::trial_points::{momenta, states};

    /// The oracles that foreign dynamics are tried over are what they say: Poisson maps to round-off.
    #[test]
    fn the_realizations_are_exact() {
        for d in 1..=6 {
            for problem in of_dimension(d) {
                let values = problem.system.parameter_values();
                let realization = &problem.realization;
                let mut instrument =
                    RealizationInstrument::new(&problem.system, realization, &values)
                        .expect("code on T*M");
                for (x, p) in states(d).iter().zip(&momenta(d)) {
                    let error = instrument.measure(0.5, x, p).expect("in the domain");
                    let bound = 64.0 * f64::EPSILON * (1.0 + error.scale);
                    let largest = error.source.max(error.target).max(error.dual_pair);
                    assert!(largest <= bound, "{}: {error:?}", problem.name);
                    let section = section_defect(realization.as_ref(), &values, 0.5, x);
                    assert_eq!(section.expect("maps"), Ok(0.0), "{}", problem.name);
                }
            }
        }
    }
}

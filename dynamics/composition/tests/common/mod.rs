//! Systems from formulas, and an oracle of order 12 that shares nothing with the methods.

use leafwise_core::system::{Casimir, Parameter};
use leafwise_core::{Convention, PoissonSystem, StepError, StepMap, Stepper};
use leafwise_expression::Expression;
use leafwise_expression::syntax::{Formula, Scope};

/// A system in the paper's convention, {H, x}, or in the literature's, {x, H}.
pub fn system(
    variables: &[&str],
    parameters: &[(&str, f64)],
    bracket: &[(&str, &str, &str)],
    hamiltonian: &str,
    casimirs: &[&str],
    convention: Convention,
) -> PoissonSystem {
    let names: Vec<&str> = parameters.iter().map(|p| p.0).collect();
    let scope = Scope::new()
        .with_variables(variables)
        .with_parameters(&names);
    let resolve = |text: &str| -> Expression {
        let formula = Formula::parse(text).unwrap_or_else(|error| panic!("`{text}`: {error}"));
        formula
            .resolve(&scope, None)
            .unwrap_or_else(|error| panic!("`{text}`: {error}"))
            .expect("no free index, no boundary")
    };
    let at = |name: &str| {
        variables
            .iter()
            .position(|v| *v == name)
            .expect("a variable")
    };
    let entries = bracket.iter().map(|&(a, b, text)| {
        let (i, j) = (at(a), at(b));
        let entry = resolve(text);
        if i < j {
            ((i, j), entry)
        } else {
            ((j, i), Expression::Negate(Box::new(entry)))
        }
    });
    let casimirs = casimirs.iter().map(|text| Casimir {
        name: (*text).to_owned(),
        expression: resolve(text),
    });
    let parameters = parameters.iter().map(|&(name, value)| Parameter {
        name: name.to_owned(),
        value,
    });
    PoissonSystem::new(
        variables.iter().map(|v| (*v).to_owned()).collect(),
        parameters.collect(),
        entries.collect::<Vec<_>>(),
        resolve(hamiltonian),
        casimirs.collect(),
        convention,
    )
    .expect("a well-formed system")
}

/// The paper's rigid body (Example 1).
pub fn rigid_body() -> PoissonSystem {
    system(
        &["x1", "x2", "x3"],
        &[("I1", 1.0), ("I2", 0.75), ("I3", 1.25)],
        &[
            ("x1", "x2", "-x3"),
            ("x2", "x3", "-x1"),
            ("x3", "x1", "-x2"),
        ],
        "x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)",
        &["x1^2 + x2^2 + x3^2"],
        Convention::HamiltonianFirst,
    )
}

/// max |a_i − b_i|.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(
        0.0,
        |m, (a, b)| if (a - b).abs() > m { (a - b).abs() } else { m },
    )
}

/// max |a_i|.
pub fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |m, v| v.abs().max(m))
}

/// One step of one lane from `x`.
pub fn step(stepper: &mut dyn Stepper, x: &[f64]) -> Result<Vec<f64>, StepError> {
    let mut increment = vec![0.0; x.len()];
    let mut outcome = [Ok(())];
    stepper.increment(x, &vec![0.0; x.len()], &mut increment, &mut outcome);
    let [outcome] = outcome;
    outcome.map(|()| x.iter().zip(&increment).map(|(x, i)| x + i).collect())
}

/// The state after `steps` compensated steps over `time`.
pub fn run(
    system: &PoissonSystem,
    map: &dyn StepMap,
    initial: &[f64],
    time: f64,
    steps: usize,
) -> Result<Vec<f64>, StepError> {
    let parameters = system.parameter_values();
    let h = time / steps as f64;
    let mut integrator = leafwise_core::Integrator::new(map, &parameters, 1.0, h, initial);
    for _ in 0..steps {
        integrator.step()?;
    }
    Ok(integrator.state().to_vec())
}

/// The values of formulas at `x`.
pub fn observe(system: &PoissonSystem, formulas: &[&Expression], x: &[f64]) -> Vec<f64> {
    use leafwise_core::Observe;
    let parameters = system.parameter_values();
    let mut observables =
        leafwise_core::system::SystemObservables::new(system, formulas, &parameters)
            .expect("formulas with code");
    let mut values = vec![0.0; formulas.len()];
    observables.evaluate(x, &mut values);
    values
}

const STAGES: usize = 6;

/// Gauss collocation with six stages, order 12 (Hairer, Lubich, Wanner, *Geometric Numerical
/// Integration*, section II.1.3), on the compiled vector field, with a compensated update.
pub fn gauss(system: &PoissonSystem, initial: &[f64], time: f64, steps: usize) -> Vec<f64> {
    let (b, a) = tableau();
    let kernel = system
        .expressions()
        .expect("formulas")
        .vector_field_kernel()
        .expect("a vector field");
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &system.parameter_values(), &[1.0], &[1.0]);
    let d = initial.len();
    let h = time / steps as f64;
    let (mut x, mut low) = (initial.to_vec(), vec![0.0; d]);
    let mut fields = vec![vec![0.0; d]; STAGES];
    for _ in 0..steps {
        let mut last = f64::INFINITY;
        for iteration in 0.. {
            assert!(iteration < 100, "the stages of the oracle settle");
            let mut change = 0.0_f64;
            for i in 0..STAGES {
                let stage: Vec<f64> = (0..d)
                    .map(|k| {
                        let sum: f64 = (0..STAGES).map(|j| a[i][j] * fields[j][k]).sum();
                        x[k] + (low[k] + h * sum)
                    })
                    .collect();
                let mut field = vec![0.0; d];
                kernel.evaluate(&mut workspace, &stage, &mut field);
                change = change.max(distance(&field, &fields[i]));
                fields[i] = field;
            }
            if change == 0.0 || (change >= last && iteration > 3) {
                break;
            }
            last = change;
        }
        for k in 0..d {
            let sum: f64 = (0..STAGES).map(|j| b[j] * fields[j][k]).sum();
            let change = low[k] + h * sum;
            let next = x[k] + change;
            low[k] = change - (next - x[k]);
            x[k] = next;
        }
    }
    x
}

/// Weights b and A_ij = ∫_0^{c_i} ℓ_j at the Gauss nodes c.
fn tableau() -> ([f64; STAGES], [[f64; STAGES]; STAGES]) {
    let legendre = |z: f64| {
        let (mut below, mut value) = (1.0, z);
        for k in 2..=STAGES {
            let k = k as f64;
            (below, value) = (value, ((2.0 * k - 1.0) * z * value - (k - 1.0) * below) / k);
        }
        (value, STAGES as f64 * (z * value - below) / (z * z - 1.0))
    };
    let (mut c, mut b) = ([0.0; STAGES], [0.0; STAGES]);
    for i in 0..STAGES {
        let mut z = -libm::cos(std::f64::consts::PI * (i as f64 + 0.75) / (STAGES as f64 + 0.5));
        for _ in 0..10 {
            let (value, slope) = legendre(z);
            z -= value / slope;
        }
        let (_, slope) = legendre(z);
        c[i] = 0.5 * (1.0 + z);
        b[i] = 1.0 / ((1.0 - z * z) * slope * slope);
    }
    let lagrange = |j: usize, at: f64| -> f64 {
        let others = (0..STAGES).filter(|k| *k != j);
        others.map(|k| (at - c[k]) / (c[j] - c[k])).product()
    };
    let mut a = [[0.0; STAGES]; STAGES];
    for i in 0..STAGES {
        for j in 0..STAGES {
            let integral: f64 = (0..STAGES).map(|k| b[k] * lagrange(j, c[i] * c[k])).sum();
            a[i][j] = c[i] * integral;
        }
    }
    (b, a)
}

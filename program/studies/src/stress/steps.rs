//! Steps from 1e-12 to beyond the chart's wall.

use leafwise_core::{PartParameters, Registry, StepError};

use super::attempt::{Attempt, attempt, increment};
use super::case::{Case, Outcome, StressError, StressOptions, Tally};
use super::setup::{UNIT_ROUNDOFF, distance, largest, method, pair};
use super::target::{Answers, Target};
use crate::verify::Problem;

pub(super) const CASES: [Case; 4] = [
    Case {
        family: "steps",
        name: "tiny",
        asked: "one step of t = 1e-12 of five systems, n = 4, m = 4",
        expected: "t X_H(x) within 1e-10 of itself (t^2 |DX X|/2 is 1e-11 of it): the increment is \
                   formed without subtracting states",
        run: tiny,
    },
    Case {
        family: "steps",
        name: "zero",
        asked: "a step of t = 0 of five systems",
        expected: "an increment of exactly 0",
        run: zero,
    },
    Case {
        family: "steps",
        name: "huge",
        asked: "one step of t from 0.3 to 1e308 of five systems, truncated at n = 2 and 6",
        expected: "a typed error, or beta(L(y)) = x within 1e3 u of its own terms; both occur",
        run: huge,
    },
    Case {
        family: "steps",
        name: "wall",
        asked: "the rigid body over the exponential chart and lie-poisson, t from 1e-12 to 1e3 in \
                1000 steps of a geometric grid, m = 2",
        expected: "solved with |t dH(y)| < 2 pi and |x| kept within 8 u |x|, or a typed error; \
                   never a step from beyond the wall",
        run: wall,
    },
];

const SYSTEMS: [&str; 5] = [
    "rigid-body",
    "heavy-top",
    "lotka-volterra-periodic",
    "gradient",
    "magnetic",
];

fn tiny(_: &StressOptions) -> Result<Outcome, StressError> {
    let t = 1e-12;
    let mut tally = Tally::default();
    let mut worst = 0.0_f64;
    for id in SYSTEMS {
        let problem = Problem::of_library(id)?;
        let system = &problem.system;
        let parameters = system.parameter_values();
        let method = method(system, 4, 4)?;
        let found = increment(&method, &parameters, (1.0, t), &problem.initial)?;
        let Some(formulas) = system.expressions() else {
            continue;
        };
        let kernel = formulas.vector_field_kernel().map_err(StressError::Build)?;
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &parameters, &[1.0], &[1.0]);
        let mut field = vec![0.0; problem.initial.len()];
        kernel.evaluate(&mut workspace, &problem.initial, &mut field);
        field.iter_mut().for_each(|f| *f *= t);
        let error = distance(&found, &field) / largest(&field);
        worst = worst.max(error);
        tally.take(error <= 1e-10, || format!("{id}: {error:.1e} relative"));
    }
    Ok(tally.outcome(|count| format!("{count} systems, at most {worst:.1e} relative")))
}

fn zero(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    for id in SYSTEMS {
        let problem = Problem::of_library(id)?;
        let parameters = problem.system.parameter_values();
        let method = method(&problem.system, 4, 4)?;
        let found = increment(&method, &parameters, (1.0, 0.0), &problem.initial)?;
        tally.take(found.iter().all(|i| *i == 0.0), || {
            format!("{id}: {found:?}")
        });
    }
    Ok(tally.outcome(|count| format!("{count} increments of exactly 0")))
}

fn huge(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut answers = Answers::default();
    for id in [
        "rigid-body",
        "lotka-volterra",
        "lotka-volterra-periodic",
        "heavy-top",
        "gradient",
    ] {
        let problem = Problem::of_library(id)?;
        for (n, m) in [(2, 2), (6, 4)] {
            let method = method(&problem.system, n, m)?;
            let Some(target) = Target::new(&problem.system, &method)? else {
                continue;
            };
            for t in [0.3, 1.0, 3.0, 10.0, 100.0, 1e4, 1e8, 1e200, 1e308] {
                answers.take(&target, &method, &problem, t);
            }
        }
    }
    Ok(answers.outcome())
}

fn wall(_: &StressOptions) -> Result<Outcome, StressError> {
    let problem = Problem::of_library("rigid-body")?;
    let parameters = problem.system.parameter_values();
    let inertia = [1.0, 0.75, 1.25];
    let squared = |x: &[f64]| -> f64 { x.iter().map(|v| v * v).sum() };
    let size = squared(&problem.initial);
    let mut tally = Tally::default();
    let (mut last_solved, mut refused, mut unexplained) = (0.0_f64, 0, 0);
    // The exponential chart: of those that fit, whose maps are no step of their own.
    let registry = Registry::with_builtin();
    for (info, _) in registry.exact_realizations() {
        let (realization, defaults) = (info.name, PartParameters::new());
        let part = registry.realization(realization)?;
        let built = part.build(&problem.system, &defaults);
        if !built.is_ok_and(|built| built.abilities().fused.is_none()) {
            continue;
        }
        let method = pair(
            &problem.system,
            (realization, defaults),
            (
                "hamilton-jacobi",
                PartParameters::new().with("order", 2_i64),
            ),
        )?;
        for k in 0..1000 {
            let t = libm::pow(10.0, -12.0 + 15.0 * f64::from(k) / 999.0);
            match attempt(&method, &parameters, (1.0, t), &problem.initial) {
                Attempt::Solved {
                    increment,
                    solution,
                } => {
                    let y = solution.unwrap_or_default();
                    let p: Vec<f64> = y.iter().zip(inertia).map(|(y, i)| t * y / i).collect();
                    let angle = libm::sqrt(squared(&p));
                    let next: Vec<f64> = problem
                        .initial
                        .iter()
                        .zip(&increment)
                        .map(|(x, i)| x + i)
                        .collect();
                    let drift = (squared(&next) - size).abs() / size;
                    last_solved = last_solved.max(t);
                    let inside = angle < 2.0 * std::f64::consts::PI;
                    tally.take(inside && drift <= 16.0 * UNIT_ROUNDOFF, || {
                        format!("{realization}, t = {t:.3e}: angle {angle:.3}, |x|^2 {drift:.1e}")
                    });
                }
                Attempt::Refused(error) => {
                    refused += 1;
                    let is_chart = matches!(
                        error,
                        StepError::LeftChart { .. }
                            | StepError::OtherBranch { .. }
                            | StepError::NoConvergence { .. }
                            | StepError::NonFinite { .. }
                    );
                    unexplained += u32::from(!is_chart);
                    tally.take(is_chart, || format!("{realization}, t = {t:.3e}: {error}"));
                }
                Attempt::Garbage(what) => tally.take(false, || what),
            }
        }
    }
    tally.take(refused > 0 && unexplained == 0, || {
        "nothing was refused".to_owned()
    });
    Ok(tally.outcome(|count| {
        format!("{count} steps: solved up to t = {last_solved:.3}, {refused} refused beyond")
    }))
}

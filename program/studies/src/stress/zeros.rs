//! Coordinates that are zero at the start, stay zero, or are the round-off of larger ones.

use leafwise_core::{PartParameters, StepMap, Walk};

use super::case::{Case, Outcome, StressError, StressOptions, Tally};
use super::setup::{method, pair, problem};
use crate::verify::Problem;

pub(super) const CASES: [Case; 3] = [
    Case {
        family: "zeros",
        name: "any-subset",
        asked: "seven systems of the library, every subset of coordinates set to zero, 30 steps",
        expected: "every step succeeds, with 20 evaluations at most",
        run: any_subset,
    },
    Case {
        family: "zeros",
        name: "through-zero",
        asked: "coordinates that leave zero along an eigenvector: oscillators, a top that falls",
        expected: "200 steps of 0.05 succeed",
        run: through_zero,
    },
    Case {
        family: "zeros",
        name: "every-path",
        asked: "one coordinate alone, over parts that compute numbers: collocation, closed forms, \
                collective",
        expected: "30 steps of 0.05 succeed",
        run: every_path,
    },
];

/// Takes steps of t and tells which fails; the second number bounds the evaluations of a step: of a solve and of four quarters of its
/// path, four each.
fn steps(
    tally: &mut Tally,
    name: &str,
    map: &dyn StepMap,
    parameters: &[f64],
    x: &[f64],
    (count, most): (usize, u64),
) {
    let mut walk = Walk::new(map, parameters, 1.0, 0.05, x);
    let failed = walk.advance(count as u64).err();
    let failed = failed.map(|error| (walk.steps(), error));
    let evaluations = walk.statistics().most_evaluations;
    tally.take(failed.is_none() && evaluations <= most, || match failed {
        Some((step, error)) => format!("{name} from {x:?}, step {step}: {error}"),
        None => format!("{name} from {x:?}: {evaluations} evaluations in one step"),
    });
}

fn any_subset(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    for id in [
        "three-wave",
        "magnetic",
        "so4",
        "heavy-top",
        "gradient",
        "se3",
        "rigid-body",
    ] {
        let problem = Problem::of_library(id)?;
        let parameters = problem.system.parameter_values();
        let method = method(&problem.system, 4, 4)?;
        let d = problem.initial.len();
        for zeros in 0_u32..1 << d {
            let mut x = problem.initial.clone();
            (0..d)
                .filter(|i| zeros >> i & 1 == 1)
                .for_each(|i| x[i] = 0.0);
            steps(&mut tally, id, &method, &parameters, &x, (30, 20));
        }
    }
    Ok(tally.outcome(|count| format!("{count} starts, 30 steps each")))
}

fn through_zero(_: &StressOptions) -> Result<Outcome, StressError> {
    let oscillators = "variables = [\"q\", \"p\", \"r\", \"s\"]\n\
                       bracket = { \"q,p\" = \"-1\", \"r,s\" = \"-1\" }\n\
                       hamiltonian = \"p^2/2 + s^2/2 + (q - r)^2/2\"\n";
    let top = "variables = [\"m1\", \"m2\", \"m3\", \"g1\", \"g2\", \"g3\"]\n\
               bracket = { \"m1,m2\" = \"-m3\", \"m2,m3\" = \"-m1\", \"m3,m1\" = \"-m2\", \
               \"m1,g2\" = \"-g3\", \"m2,g3\" = \"-g1\", \"m3,g1\" = \"-g2\", \
               \"m2,g1\" = \"g3\", \"m3,g2\" = \"g1\", \"m1,g3\" = \"g2\" }\n\
               hamiltonian = \"m1^2/2 + m2^2/1.5 + m3^2/2.5 + 0.3*g1 + 0.6*g2 + 0.9*g3\"\n";
    let mut tally = Tally::default();
    for (system, x) in [
        (oscillators, vec![0.0, 1.0, 0.0, 0.0]),
        (top, vec![0.0, 0.0, 0.0, 0.1, 0.2, 0.3]),
    ] {
        let system = problem(system, &x)?.system;
        let method = method(&system, 2, 2)?;
        steps(
            &mut tally,
            "n = 2, m = 2",
            &method,
            &[],
            &x,
            (200, u64::MAX),
        );
    }
    Ok(tally.outcome(|count| format!("{count} runs of 200 steps")))
}

fn every_path(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    for id in ["heavy-top", "so4", "rigid-body"] {
        let problem = Problem::of_library(id)?;
        let parameters = problem.system.parameter_values();
        for (realization, dynamics) in [
            ("karasev-collocated", "hamilton-jacobi"),
            ("lie-poisson", "hamilton-jacobi"),
            ("karasev-truncated", "collective"),
        ] {
            let defaults = PartParameters::new;
            let method = pair(
                &problem.system,
                (realization, defaults()),
                (dynamics, defaults()),
            )?;
            let name = format!("{id}, {realization} + {dynamics}");
            for kept in 0..problem.initial.len() {
                let mut x = vec![0.0; problem.initial.len()];
                x[kept] = 1.0;
                steps(&mut tally, &name, &method, &parameters, &x, (30, u64::MAX));
            }
        }
    }
    Ok(tally.outcome(|count| format!("{count} starts, 30 steps each")))
}

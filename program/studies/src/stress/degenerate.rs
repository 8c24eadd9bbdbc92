//! Points where the tensor loses rank.

use leafwise_core::Walk;

use super::case::{Case, Outcome, StressError, StressOptions, Tally};
use super::setup::{distance, method};
use super::trivial::rests;
use crate::verify::Problem;

pub(super) const CASES: [Case; 3] = [
    Case {
        family: "degenerate",
        name: "origin",
        asked: "the rigid body and the heavy top at the origin, where Pi = 0",
        expected: "the leaf is a point: ten steps keep every bit",
        run: origin,
    },
    Case {
        family: "degenerate",
        name: "equilibria",
        asked: "the rigid body on its three axes; Lotka-Volterra with one species left or none",
        expected: "Pi dH = 0: ten steps keep every bit",
        run: equilibria,
    },
    Case {
        family: "degenerate",
        name: "coordinate-planes",
        asked: "Lotka-Volterra with one species extinct, 100 steps of 0.02",
        expected: "x_i = 0 stays 0 exactly, and the other two move",
        run: coordinate_planes,
    },
];

fn origin(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    for (id, d) in [("rigid-body", 3), ("heavy-top", 6)] {
        let system = Problem::of_library(id)?.system;
        rests(&mut tally, id, &system, &vec![0.0; d]);
    }
    Ok(tally.outcome(|count| format!("{count} runs at rest to the bit")))
}

fn equilibria(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    let body = Problem::of_library("rigid-body")?.system;
    for x in [[1.7, 0.0, 0.0], [0.0, -0.1, 0.0], [0.0, 0.0, 3.3]] {
        rests(&mut tally, "the rigid body", &body, &x);
    }
    let species = Problem::of_library("lotka-volterra")?.system;
    for x in [[0.0; 3], [1.1, 0.0, 0.0], [0.0, 2.3, 0.0], [0.0, 0.0, 0.7]] {
        rests(&mut tally, "Lotka-Volterra", &species, &x);
    }
    Ok(tally.outcome(|count| format!("{count} runs at rest to the bit")))
}

fn coordinate_planes(_: &StressOptions) -> Result<Outcome, StressError> {
    let system = Problem::of_library("lotka-volterra")?.system;
    let mut tally = Tally::default();
    for (n, m) in [(3, 2), (8, 4)] {
        let method = method(&system, n, m)?;
        for zero in 0..3 {
            let mut x = [0.9, 1.4, 0.6];
            x[zero] = 0.0;
            let mut walk = Walk::new(&method, &[], 0.01, 2.0, &x);
            let mut stays = true;
            walk.watch(100, |walk| {
                stays &= walk.state()[zero] == 0.0;
            })?;
            let moved = distance(walk.state(), &x);
            tally.take(stays && moved > 0.1, || {
                format!("x{} = 0 from {x:?}: {:?}", zero + 1, walk.state())
            });
        }
    }
    Ok(tally.outcome(|count| format!("{count} runs, 100 steps each, in their plane to the bit")))
}

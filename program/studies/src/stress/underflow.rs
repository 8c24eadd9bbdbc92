//! Orbits that run into the smallest numbers.

use leafwise_core::solver::judge::larger;
use leafwise_core::{StepMap, Walk};

use super::case::{Case, Outcome, StressError, StressOptions};
use super::setup::{UNIT_ROUNDOFF, method};
use crate::verify::Problem;

pub(super) const CASES: [Case; 2] = [
    Case {
        family: "underflow",
        name: "relative-accuracy",
        asked: "the paper's Lotka-Volterra orbit from (1, 3, 3) at epsilon = 0.01, h = 2, n = 8, \
                until x1 and x2, which die out like exp(-14 t), are below 1e-100",
        expected: "no component is ever negative; the Casimir x1 x3/x2, which feels the relative \
                   error of each, within 1e-9 of itself: 800 steps of a truncation error \
                   (0.14)^9/9! = 6e-14",
        run: relative_accuracy,
    },
    Case {
        family: "underflow",
        name: "heteroclinic",
        asked: "the same orbit at epsilon = 0.1, 1000 steps, far beyond the smallest numbers",
        expected: "components are positive as long as they are normal numbers, and within 10 units \
                   of 4.9e-324 in the end; x1 + x2 + x3 = 7 within 16 u of itself",
        run: heteroclinic,
    },
];

const START: [f64; 3] = [1.0, 3.0, 3.0];

/// The Casimir's largest relative change until a component is below 1e-100, the smallest component
/// there, and the steps it took.
fn die_out(map: &dyn StepMap) -> Result<(f64, f64, u64), StressError> {
    let mut walk = Walk::new(map, &[], 0.01, 2.0, &START);
    let mut worst = 0.0_f64;
    let smallest = walk.watch_until(u64::MAX, |walk| {
        let x = walk.state();
        let smallest = x.iter().copied().fold(f64::INFINITY, f64::min);
        if smallest <= 1e-100 {
            return Some(smallest);
        }
        let drift = (x[0] * x[2] / x[1] - 1.0).abs();
        worst = larger(worst, drift);
        None
    })?;
    Ok((worst, smallest.unwrap_or(f64::INFINITY), walk.steps()))
}

fn relative_accuracy(_: &StressOptions) -> Result<Outcome, StressError> {
    let problem = Problem::of_library("lotka-volterra")?;
    let (worst, smallest, steps) = die_out(&method(&problem.system, 8, 2)?)?;
    Ok(Outcome {
        is_met: smallest >= 0.0 && worst <= 1e-9,
        measured: format!(
            "Casimir within {worst:.1e} over {steps} steps, smallest component {smallest:.0e}"
        ),
    })
}

fn heteroclinic(_: &StressOptions) -> Result<Outcome, StressError> {
    let problem = Problem::of_library("lotka-volterra")?;
    let method = method(&problem.system, 8, 2)?;
    let mut walk = Walk::new(&method, &[], 0.1, 2.0, &START);
    let mut most_negative = 0.0_f64;
    let mut underflow = None;
    walk.watch(1000, |walk| {
        let x = walk.state();
        most_negative = x.iter().copied().fold(most_negative, f64::min);
        if underflow.is_none() && x.iter().any(|x| *x < f64::MIN_POSITIVE) {
            underflow = Some(walk.steps());
        }
    })?;
    let x = walk.state();
    let energy = (x.iter().sum::<f64>() - 7.0).abs() / 7.0;
    let unit = f64::from_bits(1);
    let rests = x[0].abs() <= 10.0 * unit && x[1].abs() <= 10.0 * unit;
    // What is not a normal number has no relative accuracy, nor a sign that means something.
    let is_met = most_negative >= -10.0 * unit
        && rests
        && energy <= 16.0 * UNIT_ROUNDOFF
        && underflow.is_some();
    Ok(Outcome {
        is_met,
        measured: format!(
            "{}, at the end ({:.0e}, {:.0e}, {:.15}), nothing below {most_negative:.0e}",
            underflow.map_or_else(
                || "no underflow".to_owned(),
                |step| format!("underflow at step {step}")
            ),
            x[0],
            x[1],
            x[2]
        ),
    })
}

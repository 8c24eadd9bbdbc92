//! Starts at the distance 1e-12 from something degenerate.

use leafwise_core::Walk;
use leafwise_core::solver::judge::larger;

use super::case::{Case, Outcome, StressError, StressOptions};
use super::setup::{UNIT_ROUNDOFF, composed, method};
use crate::verify::Problem;

pub(super) const CASES: [Case; 3] = [
    Case {
        family: "nearly-degenerate",
        name: "unstable-axis",
        asked: "the rigid body at 1e-12 from its unstable axis, (1, 1e-12, 0), 200 steps of 0.1, \
                n = 10, m = 8",
        expected: "x2 = 1e-12 cosh(lambda t) with lambda^2 = (1/I1 - 1/I3)(1/I2 - 1/I1), within \
                   1e-11 of itself",
        run: unstable_axis,
    },
    Case {
        family: "nearly-degenerate",
        name: "separatrix",
        asked: "the same start, 10^5 steps of 0.1: along the separatrix to the opposite axis and \
                back, some fifty times",
        expected: "|x|^2 within 1e-13 and H within 1e-8 of themselves, and the body does turn over",
        run: separatrix,
    },
    Case {
        family: "nearly-degenerate",
        name: "coordinate-plane",
        asked: "the periodic Lotka-Volterra system from x1 = 1e-12, 10^4 steps of 0.02 over the \
                closed form, m = 4",
        expected: "x1 > 0 throughout; the Casimir 2 ln x1 + ln x2 + ln x3, which feels the relative \
                   error of x1, within 1e-12 of itself",
        run: coordinate_plane,
    },
];

const NEAR: f64 = 1e-12;

fn unstable_axis(_: &StressOptions) -> Result<Outcome, StressError> {
    let problem = Problem::of_library("rigid-body")?;
    let parameters = problem.system.parameter_values();
    let method = method(&problem.system, 10, 8)?;
    let mut walk = Walk::new(&method, &parameters, 1.0, 0.1, &[1.0, NEAR, 0.0]);
    let (i1, i2, i3) = (1.0, 0.75, 1.25);
    let lambda = libm::sqrt((1.0 / i1 - 1.0 / i3) * (1.0 / i2 - 1.0 / i1));
    let mut worst = 0.0_f64;
    walk.watch(200, |walk| {
        let exact = NEAR * libm::cosh(lambda * 0.1 * walk.steps() as f64);
        let error = (walk.state()[1] - exact).abs() / exact;
        worst = larger(worst, error);
    })?;
    Ok(Outcome {
        is_met: worst <= 1e-11,
        measured: format!(
            "at most {worst:.1e} relative while x2 grows to {:.1e}",
            walk.state()[1]
        ),
    })
}

fn separatrix(_: &StressOptions) -> Result<Outcome, StressError> {
    let problem = Problem::of_library("rigid-body")?;
    let parameters = problem.system.parameter_values();
    let method = method(&problem.system, 10, 8)?;
    let inverse = [1.0, 1.0 / 0.75, 1.0 / 1.25];
    let spin = |x: &[f64]| -> f64 { x.iter().map(|x| x * x).sum() };
    let energy = |x: &[f64]| -> f64 { x.iter().zip(inverse).map(|(x, i)| x * x * i / 2.0).sum() };
    let start = [1.0, NEAR, 0.0];
    let mut walk = Walk::new(&method, &parameters, 1.0, 0.1, &start);
    let (mut of_spin, mut of_energy, mut turns) = (0.0_f64, 0.0_f64, 0);
    let mut sign = 1.0;
    walk.watch(100_000, |walk| {
        let x = walk.state();
        of_spin = of_spin.max((spin(x) - spin(&start)).abs() / spin(&start));
        of_energy = of_energy.max((energy(x) - energy(&start)).abs() / energy(&start));
        if x[0] * sign < -0.5 {
            sign = -sign;
            turns += 1;
        }
    })?;
    let is_finite = walk.state().iter().all(|x| x.is_finite());
    Ok(Outcome {
        is_met: is_finite && of_spin <= 1e-13 && of_energy <= 1e-8 && turns > 10,
        measured: format!("|x|^2 {of_spin:.1e}, H {of_energy:.1e}, turned over {turns} times"),
    })
}

fn coordinate_plane(_: &StressOptions) -> Result<Outcome, StressError> {
    let run = composed(
        "[system]\nlibrary = \"lotka-volterra-periodic\"\n[method]\n\
         realization = \"log-canonical\"\n\
         dynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.02\n\
         [run]\ninitial = [1e-12, 1.9, 0.5]\nsteps = 10_000\n",
    )?;
    let casimir = |x: &[f64]| 2.0 * libm::log(x[0]) + libm::log(x[1]) + libm::log(x[2]);
    let mut walk = run.walk();
    let start = casimir(&run.plan.initial);
    let (mut worst, mut smallest) = (0.0_f64, f64::INFINITY);
    walk.watch(run.plan.steps, |walk| {
        let drift = (casimir(walk.state()) - start).abs();
        worst = larger(worst, drift);
        smallest = smallest.min(walk.state()[0]);
    })?;
    // Relative to its largest logarithm.
    let relative = worst / (2.0 * libm::log(NEAR)).abs();
    Ok(Outcome {
        is_met: smallest > 0.0 && relative <= 1e4 * UNIT_ROUNDOFF,
        measured: format!("Casimir {relative:.1e} relative, x1 not below {smallest:.1e}"),
    })
}

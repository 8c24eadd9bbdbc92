//! Parameters of very different sizes.

use leafwise_core::{Method, Walk};

use super::case::{Case, Outcome, StressError, StressOptions};
use super::setup::{distance, method, problem};
use super::target::{Answers, Target};
use crate::verify::Problem;

pub(super) const CASES: [Case; 2] = [
    Case {
        family: "stiff",
        name: "symmetric-top",
        asked: "a free top with moments of inertia 1, 1 and 1e-6, 10^4 steps of 1e-7 over the \
                truncated realization, n = 10, m = 8",
        expected: "the exact rotation about its axis at the rate x3 (1/I3 - 1/I1): within 1e-10 of \
                   |x| after a turn of a thousand radians",
        run: symmetric_top,
    },
    Case {
        family: "stiff",
        name: "any-step",
        asked: "moments of inertia 1, 1e-3 and 1e-6, t from 1e-10 to 1e2",
        expected: "solved to round-off, or a typed error; both occur",
        run: any_step,
    },
];

fn top(inertia: [f64; 3], initial: &[f64; 3]) -> Result<Problem, StressError> {
    let [i1, i2, i3] = inertia;
    let system = format!(
        "library = \"rigid-body\"\nparameters = {{ I1 = {i1:?}, I2 = {i2:?}, I3 = {i3:?} }}\n"
    );
    problem(&system, initial)
}

/// With I1 = I2 the motion is x1 + i x2 turning at the constant rate ±x3 (1/I3 − 1/I1).
fn symmetric_top(_: &StressOptions) -> Result<Outcome, StressError> {
    let x = [1.0, 0.0, 1.0];
    let (t, steps) = (1e-7, 10_000_u32);
    let problem = top([1.0, 1.0, 1e-6], &x)?;
    let parameters = problem.system.parameter_values();
    let method: Method = method(&problem.system, 10, 8)?;
    let mut walk = Walk::new(&method, &parameters, 1.0, t, &x);
    walk.advance(u64::from(steps))?;
    // ẋ = {H, x} = −x × ω turns (x1, x2) by +x3 (1/I3 − 1/I1) t.
    let angle = x[2] * (1e6 - 1.0) * t * f64::from(steps);
    let exact = [libm::cos(angle), libm::sin(angle), x[2]];
    let mirrored = [exact[0], -exact[1], exact[2]];
    let error = distance(walk.state(), &exact);
    let other = distance(walk.state(), &mirrored);
    Ok(Outcome {
        is_met: error <= 1e-10,
        measured: format!(
            "{error:.1e} off after {angle:.1} radians ({other:.1e} from the opposite turn)"
        ),
    })
}

fn any_step(_: &StressOptions) -> Result<Outcome, StressError> {
    let problem = top([1.0, 1e-3, 1e-6], &[1.0, 1.0, 1.0])?;
    let mut answers = Answers::default();
    for (n, m) in [(2, 2), (8, 6)] {
        let method = method(&problem.system, n, m)?;
        let Some(target) = Target::new(&problem.system, &method)? else {
            continue;
        };
        for k in -40..=8 {
            let t = libm::pow(10.0, f64::from(k) / 4.0);
            answers.take(&target, &method, &problem, t);
        }
    }
    Ok(answers.outcome())
}

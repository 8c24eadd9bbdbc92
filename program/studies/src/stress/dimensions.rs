//! Dimension 1, 2 and 10⁵.

use std::time::Instant;

use leafwise_core::Walk;

use super::attempt::increment;
use super::case::{Case, Outcome, StressError, StressOptions, Tally};
use super::setup::{UNIT_ROUNDOFF, composed, distance, largest, method, problem};
use super::trivial::rests;

pub(super) const CASES: [Case; 3] = [
    Case {
        family: "dimensions",
        name: "one",
        asked: "one coordinate, H = exp(x) + x^3: antisymmetry leaves no tensor",
        expected: "nothing moves by a bit",
        run: one,
    },
    Case {
        family: "dimensions",
        name: "two",
        asked: "a harmonic oscillator, {q, p} = -1, m = 2, t = 0.3, 1000 steps",
        expected: "the rotation by 2 arctan(t/2) of the implicit midpoint rule, within 1e4 u",
        run: two,
    },
    Case {
        family: "dimensions",
        name: "a-hundred-thousand",
        asked: "the Volterra lattice of 10^5 sites, ten steps of 0.05 of m = 4, and the same wave \
                on 10^2 sites",
        expected: "a wave of period 100 is the same on both: sites agree to the bit; time a step \
                   and site does not grow with their number",
        run: lattice,
    },
];

fn one(_: &StressOptions) -> Result<Outcome, StressError> {
    let system = "variables = [\"x\"]\nbracket = {}\nhamiltonian = \"exp(x) + x^3\"\n";
    let mut tally = Tally::default();
    for x in [0.0, -1.5, 1e-300, 700.0] {
        rests(
            &mut tally,
            "one coordinate",
            &problem(system, &[x])?.system,
            &[x],
        );
    }
    Ok(tally.outcome(|count| format!("{count} runs at rest to the bit")))
}

fn two(_: &StressOptions) -> Result<Outcome, StressError> {
    let system = "variables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"-1\" }\n\
                  hamiltonian = \"(q^2 + p^2)/2\"\n";
    let (t, steps, x) = (0.3, 1000_u32, [1.0, 0.0]);
    let system = problem(system, &x)?.system;
    let method = method(&system, 2, 2)?;
    let mut walk = Walk::new(&method, &[], 1.0, t, &x);
    walk.advance(u64::from(steps))?;
    // q̇ = {H, q} = p, ṗ = −q.
    let angle = 2.0 * libm::atan(t / 2.0) * f64::from(steps);
    let exact = [libm::cos(angle), -libm::sin(angle)];
    let error = distance(walk.state(), &exact);
    let first = increment(&method, &[], (1.0, t), &x)?;
    Ok(Outcome {
        is_met: error <= 1e4 * UNIT_ROUNDOFF && largest(&first) > 0.1,
        measured: format!("{error:.1e} off after {angle:.1} radians"),
    })
}

/// The period of the wave, in sites.
const PERIOD: usize = 100;

fn lattice(_: &StressOptions) -> Result<Outcome, StressError> {
    let run = |sites: usize| -> Result<(Vec<f64>, f64, f64), StressError> {
        let run = composed(&format!(
            "[system]\nlibrary = \"volterra-lattice\"\nfamilies = {{ x = {sites} }}\n[method]\n\
             realization = \"log-canonical\"\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\ntime-step = 0.05\n\
             [run]\ninitial = {{ \"x[i]\" = \"1 + 0.1*sin(2*pi*i/{PERIOD})\" }}\nsteps = 10\n"
        ))?;
        let mut walk = run.walk();
        // The sine itself is rounded differently in every period.
        let period: Vec<f64> = run.plan.initial[..PERIOD].to_vec();
        let initial: Vec<f64> = (0..sites).map(|i| period[i % PERIOD]).collect();
        let mut checkpoint = walk.checkpoint();
        checkpoint.state = initial;
        walk.restore(&checkpoint)
            .map_err(|expected| leafwise_core::BuildError::Dimension {
                what: "the solver's memory".to_owned(),
                expected,
                found: sites,
            })?;
        let started = Instant::now();
        walk.advance(run.plan.steps)?;
        let site_steps = (sites as u64 * run.plan.steps) as f64;
        let seconds = started.elapsed().as_secs_f64() / site_steps;
        let operations = walk.statistics().operations;
        let operations = operations.map_or(f64::NAN, |count| count as f64 / site_steps);
        Ok((walk.state().to_vec(), operations, seconds))
    };
    let (few, _, _) = run(PERIOD)?;
    let (thousands, near, _) = run(2_000)?;
    let (many, far, seconds) = run(100_000)?;
    let differing = |state: &[f64]| {
        let sites = state.iter().enumerate();
        sites
            .filter(|(i, x)| x.to_bits() != few[i % PERIOD].to_bits())
            .count()
    };
    let differ = differing(&many) + differing(&thousands);
    let moved = distance(&few, &vec![1.0; PERIOD]) > 0.01;
    // One for a step that is linear in the sites, but for an evaluation more or less; a quadratic one
    // would take fifty times as many.
    let ratio = far / near;
    Ok(Outcome {
        is_met: differ == 0 && moved && ratio < 2.0,
        measured: format!(
            "{differ} sites differ; {far:.0} operations and {:.0} ns a site and step, {ratio:.2} times the \
             operations of 2000 sites",
            seconds * 1e9
        ),
    })
}

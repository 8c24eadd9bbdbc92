//! Chains whose waves start narrow, cross zero, or move little in a step.

use std::f64::consts::PI;

use leafwise_scene::ComposedRun;

use super::case::{Case, Outcome, StressError, StressOptions, Tally};
use super::setup::{UNIT_ROUNDOFF, composed, distance, largest};

pub(super) const CASES: [Case; 3] = [
    Case {
        family: "lattices",
        name: "narrow-wave",
        asked: "a chain of springs on rings of 32, 100, 200 and 1000 sites, a Gaussian of width 10 \
                that is 0 in most sites, 400 steps of 0.1 of m = 2",
        expected: "the implicit midpoint rule's closed form, each mode turning by \
                   2 arctan(t omega/2) a step: within 1e4 u of the wave's height",
        run: narrow_wave,
    },
    Case {
        family: "lattices",
        name: "through-zero",
        asked: "a Fermi-Pasta-Ulam ring of 32 and 100 sites, a sine at rest, t = 0.1, m = 2 and 4, \
                to t = 100",
        expected: "every step succeeds; the momentum, 0, within 1e4 u; the energy error of m = 2 \
                   and 4 below t^m",
        run: through_zero,
    },
    Case {
        family: "lattices",
        name: "fine-steps",
        asked: "the Toda lattice of 200 sites, a bump of width 10 on sites at rest, t = 0.1, 0.025, 0.00625 and \
                0.0015625, 400 steps each, m = 2",
        expected: "every step succeeds; the momentum, 18, within 100 u a site; the energy error \
                   falls with t^2 to round-off",
        run: fine_steps,
    },
];

/// Steps to the end; the largest distance of each invariant from where it began.
fn drifts(run: &ComposedRun) -> Result<(Vec<f64>, Vec<f64>), StressError> {
    let mut walk = run.walk();
    let mut invariants = run.invariants()?;
    let mut first = vec![0.0; invariants.observables()];
    invariants.evaluate(walk.state(), &mut first);
    let (mut values, mut worst) = (first.clone(), vec![0.0; first.len()]);
    walk.watch(run.plan.steps, |walk| {
        invariants.evaluate(walk.state(), &mut values);
        for (worst, (value, first)) in worst.iter_mut().zip(values.iter().zip(&first)) {
            *worst = largest(&[*worst, value - first]);
        }
    })?;
    Ok((walk.state().to_vec(), worst))
}

/// q̈ = −ω² q of each mode e^{ikj}, ω = 2 sin(k/2).
fn narrow_wave(_: &StressOptions) -> Result<Outcome, StressError> {
    let (t, steps) = (0.1, 400_u32);
    let mut tally = Tally::default();
    let mut worst = 0.0_f64;
    for sites in [32_usize, 100, 200, 1000] {
        let run = composed(&format!(
            "[system]\nfamilies = {{ q = {sites}, p = {sites} }}\nbracket = {{ \"q[i],p[i]\" = \"-1\" }}\n\
             hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2)\"\n[method]\nrealization = \"auto\"\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = {t}\n[run]\n\
             initial = {{ \"q[i]\" = \"exp(-((i - 16)/10)^2)\", \"p[i]\" = \"0\" }}\nsteps = {steps}\n"
        ))?;
        let (state, _) = match drifts(&run) {
            Ok(ended) => ended,
            Err(error) => {
                tally.take(false, || format!("{sites} sites: {error}"));
                continue;
            }
        };
        let turned = |mode: usize| {
            let omega = 2.0 * libm::sin(PI * mode as f64 / sites as f64);
            libm::cos(2.0 * f64::from(steps) * libm::atan(t * omega / 2.0))
        };
        let angles: Vec<f64> = (0..sites).map(turned).collect();
        let cosine = |at: usize| libm::cos(2.0 * PI * (at % sites) as f64 / sites as f64);
        let cosines: Vec<f64> = (0..sites).map(cosine).collect();
        // What a wave of height 1 in one site is in another.
        let spread = |away: usize| {
            let modes = angles.iter().enumerate();
            let sum: f64 = modes
                .map(|(k, turn)| turn * cosines[k * away % sites])
                .sum();
            sum / sites as f64
        };
        let spread: Vec<f64> = (0..sites).map(spread).collect();
        let wave = |site: usize| -> f64 {
            let from = run.plan.initial[..sites].iter().enumerate();
            from.map(|(other, q)| q * spread[(site + sites - other) % sites])
                .sum()
        };
        let exact: Vec<f64> = (0..sites).map(wave).collect();
        let error = distance(&state[..sites], &exact);
        worst = worst.max(error);
        tally.take(error <= 1e4 * UNIT_ROUNDOFF, || {
            format!("{sites} sites: {error:.1e} off")
        });
    }
    Ok(tally.outcome(|count| format!("{count} rings, at most {worst:.1e} off")))
}

fn through_zero(_: &StressOptions) -> Result<Outcome, StressError> {
    let t = 0.1_f64;
    let mut tally = Tally::default();
    let mut said = Vec::new();
    for (sites, order) in [(32, 2), (32, 4), (100, 2)] {
        let run = composed(&format!(
            "[system]\nfamilies = {{ q = {sites}, p = {sites} }}\nbracket = {{ \"q[i],p[i]\" = \"-1\" }}\n\
             hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2 + (q[i+1] - q[i])^3/12)\"\n\
             [method]\nrealization = \"auto\"\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\ntime-step = {t}\n[run]\n\
             initial = {{ \"q[i]\" = \"sin(2*pi*i/N)\", \"p[i]\" = \"0\" }}\nsteps = 1000\n"
        ));
        let name = format!("{sites} sites, m = {order}");
        match run.and_then(|run| drifts(&run)) {
            Ok((state, worst)) => {
                let (energy, momentum) = (worst[0], state[sites..].iter().sum::<f64>().abs());
                let is_met =
                    energy <= libm::pow(t, f64::from(order)) && momentum <= 1e4 * UNIT_ROUNDOFF;
                said.push(format!("{energy:.1e}"));
                tally.take(is_met, || {
                    format!("{name}: energy {energy:.1e}, momentum {momentum:.1e}")
                });
            }
            Err(error) => tally.take(false, || format!("{name}: {error}")),
        }
    }
    Ok(tally.outcome(|count| format!("{count} rings, energy within {}", said.join(", "))))
}

fn fine_steps(_: &StressOptions) -> Result<Outcome, StressError> {
    let sites = 200;
    let mut tally = Tally::default();
    let mut last = f64::INFINITY;
    let mut said = Vec::new();
    for k in 0..4 {
        let t = 0.1 / f64::from(1 << (2 * k));
        let run = composed(&format!(
            "[system]\nlibrary = \"toda\"\nfamilies = {{ a = {sites}, b = {sites} }}\n[method]\n\
             realization = {{ name = \"karasev-truncated\", order = 4 }}\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = {t:?}\n[run]\n\
             initial = {{ \"a[i]\" = \"0.5\", \"b[i]\" = \"exp(-((i - 100)/10)^2)\" }}\nsteps = 400\n\
             record = {{ every = 400, observables = [\"energy\", \"momentum\"] }}\n"
        ))?;
        match drifts(&run) {
            Ok((_, worst)) => {
                let (energy, momentum) = (worst[0], worst[1]);
                let round_off = 100.0 * f64::from(sites) * UNIT_ROUNDOFF;
                let falls = energy <= (last / 12.0).max(round_off);
                last = energy;
                said.push(format!("{energy:.1e}"));
                tally.take(falls && momentum <= round_off, || {
                    format!("t = {t}: energy {energy:.1e}, momentum {momentum:.1e}")
                });
            }
            Err(error) => tally.take(false, || format!("t = {t}: {error}")),
        }
    }
    Ok(tally.outcome(|count| format!("{count} steps, energy within {}", said.join(", "))))
}

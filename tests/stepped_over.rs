//! Pulses, switches, hills and walls that lie ahead of a motion at rest or in free flight: no stepper with a tolerance
//! steps over what is there for the time of a step, against closed forms.

use leafwise::core::Registry;
use leafwise::run::advice::{Advice, AdviceKind, JudgedStates, advise, states_ahead};
use leafwise::trade::{Bench, Judged, Reference, Tolerances, TuneOptions, Tuner, parse_method};
use leafwise_tests::scenes::{composed, document, end, until};
use proptest::prelude::*;

/// What lies ahead, with its width in time, when it comes and how strong it is.
#[derive(Clone, Copy, Debug)]
enum Ahead {
    /// Force A exp(−((t − t₀)/w)²) on a free particle.
    Pulse,
    /// The same on an oscillator.
    Kick,
    /// Force A (1 + tanh((t − t₀)/w))/2.
    Switch,
    /// Potential U/cosh²(q/a), which is overcome.
    Hill,
    /// Potential exp(k(q − c)).
    Wall,
}

/// A motion past it: the scene, where it begins and ends, how long it takes.
#[derive(Debug)]
struct Motion {
    hamiltonian: String,
    initial: [f64; 2],
    time: f64,
    end: [f64; 2],
    /// The largest |q| and |p| on the way.
    sizes: [f64; 2],
}

/// What there is to choose: the width in time, the distance in widths, the strength, and a state before.
#[derive(Clone, Copy, Debug)]
struct Choice {
    width: f64,
    distance: f64,
    strength: f64,
    before: [f64; 2],
}

/// exp(−7²) and e⁻⁵⁰ are below round-off of all that comes after.
const GAUSSIAN: f64 = 7.0;
const EXPONENTIAL: f64 = 25.0;

impl Ahead {
    const ALL: [Self; 5] = [
        Self::Pulse,
        Self::Kick,
        Self::Switch,
        Self::Hill,
        Self::Wall,
    ];

    /// Whether it is over after its width in time: what stays is seen in steps of any length.
    fn passes(self) -> bool {
        !matches!(self, Self::Switch | Self::Wall)
    }

    fn motion(self, chosen: Choice) -> Motion {
        let Choice {
            width: w,
            distance,
            strength: a,
            before: [q, p],
        } = chosen;
        let root = libm::sqrt(std::f64::consts::PI);
        match self {
            Self::Pulse => {
                let centre = (GAUSSIAN + distance) * w;
                let time = centre + GAUSSIAN * w;
                let gain = a * w * root;
                let end = [q + p * time + gain * (time - centre), p + gain];
                Motion {
                    hamiltonian: format!("p^2/2 - {a:?}*q*exp(-((t-{centre:?})/{w:?})^2)"),
                    initial: [q, p],
                    time,
                    end,
                    sizes: [q.abs() + (p.abs() + gain) * time, p.abs() + gain],
                }
            }
            Self::Kick => {
                let centre = (GAUSSIAN + distance) * w;
                let time = centre + GAUSSIAN * w;
                let gain = a * w * root * libm::exp(-0.25 * w * w);
                let (sin, cos) = (libm::sin(time), libm::cos(time));
                let since = time - centre;
                let end = [
                    q * cos + p * sin + gain * libm::sin(since),
                    p * cos - q * sin + gain * libm::cos(since),
                ];
                let size = q.abs() + p.abs() + a * w * root;
                Motion {
                    hamiltonian: format!("p^2/2 + q^2/2 - {a:?}*q*exp(-((t-{centre:?})/{w:?})^2)"),
                    initial: [q, p],
                    time,
                    end,
                    sizes: [size, size],
                }
            }
            Self::Switch => {
                let centre = (EXPONENTIAL + distance) * w;
                let time = centre + EXPONENTIAL * w;
                let since = time - centre;
                // ∫ (w/2) ln(1 + exp(2x/w)) dx = x²/2 + π² w²/24 far behind.
                let way = 0.5 * since * since
                    + std::f64::consts::PI * std::f64::consts::PI / 24.0 * w * w;
                let end = [q + p * time + a * way, p + a * since];
                Motion {
                    hamiltonian: format!("p^2/2 - {a:?}*q*(1 + tanh((t-{centre:?})/{w:?}))/2"),
                    initial: [q, p],
                    time,
                    end,
                    sizes: [q.abs() + p.abs() * time + a * way, p.abs() + a * since],
                }
            }
            Self::Hill => {
                // A part of the energy from 0.1 to 0.9, at speed v.
                let v = 0.5 + p.abs();
                let energy = 0.5 * v * v;
                let height = energy * (0.1 + 0.8 * a / (1.0 + a));
                let length = w * v;
                let way = (EXPONENTIAL + distance) * length;
                let s = libm::sqrt(1.0 - height / energy);
                let centre = w * libm::asinh(libm::sinh(way / length) / s);
                let time = 2.0 * way / v;
                let angle = (time - centre) / w;
                let sinh = s * libm::sinh(angle);
                let end = [
                    length * libm::asinh(sinh),
                    v * s * libm::cosh(angle) / libm::sqrt(1.0 + sinh * sinh),
                ];
                Motion {
                    hamiltonian: format!("p^2/2 + {height:?}/cosh(q/{length:?})^2"),
                    initial: [-way, v],
                    time,
                    end,
                    sizes: [way, v],
                }
            }
            Self::Wall => {
                let v = 0.5 + p.abs();
                let energy = 0.5 * v * v;
                let rate = 2.0 / (w * v);
                let wall = 2.0 * (EXPONENTIAL + distance) / rate;
                let turn = (wall + libm::log(4.0 * energy) / rate) / v;
                let time = 2.0 * turn;
                let angle = 0.5 * rate * v * (time - turn);
                let end = [
                    wall + (libm::log(energy) - 2.0 * libm::log(libm::cosh(angle))) / rate,
                    -v * libm::tanh(angle),
                ];
                Motion {
                    hamiltonian: format!("p^2/2 + exp({rate:?}*(q-{wall:?}))"),
                    initial: [0.0, v],
                    time,
                    end,
                    sizes: [wall, v],
                }
            }
        }
    }
}

/// Errors of some hundred substeps, a tolerance each: of a momentum, and of the way it makes.
const SUBSTEPS: f64 = 300.0;

/// Sums of hundreds of substeps, and of the closed form in doubles.
const ROUND_OFF: f64 = 1e-12;

fn check(stepper: &str, ahead: Ahead, chosen: Choice, tolerance: f64, step: f64) {
    let motion = ahead.motion(chosen);
    let step = chosen.width * step;
    let steps = libm::ceil(motion.time / step).max(1.0) as usize;
    let system = format!(
        "variables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\nhamiltonian = \"{}\"",
        motion.hamiltonian
    );
    let method = format!("stepper = {{ name = \"{stepper}\", tolerance = {tolerance:?} }}");
    let initial = format!("{:?}", motion.initial);
    let found = end(&until(&system, &method, &initial, (motion.time, steps)));
    let [way, speed] = motion.sizes;
    let allowed = SUBSTEPS * tolerance + ROUND_OFF;
    let allowed = [allowed * (way + speed * motion.time), allowed * speed];
    for i in 0..2 {
        let error = (found[i] - motion.end[i]).abs();
        assert!(
            error <= allowed[i],
            "{stepper} {tolerance:e}, {steps} steps, {ahead:?} {chosen:?}: {found:?}, {:?} in {motion:?}",
            motion.end
        );
    }
}

fn choices() -> impl Strategy<Value = Choice> {
    let state = prop_oneof![
        Just([0.0, 0.0]),
        [-3.0..3.0, -3.0..3.0].prop_map(|state: [f64; 2]| state)
    ];
    (-4.0..0.7_f64, 0.0..80.0_f64, -2.0..2.0_f64, state).prop_map(
        |(width, distance, strength, before)| Choice {
            width: libm::exp(width),
            distance,
            strength: libm::exp(strength),
            before,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    /// Steps of a twentieth of a width to one, and to twenty of what stays.
    #[test]
    fn nothing_that_is_there_for_a_step_is_stepped_over(
        ahead in prop::sample::select(&Ahead::ALL[..]),
        chosen in choices(),
        stepper in prop::sample::select(vec!["taylor", "dop853", "dormand-prince45"]),
        exponent in 4.0..14.0_f64,
        part in 0.0..1.0_f64,
    ) {
        let longest = if ahead.passes() { 1.0 } else { 20.0 };
        let step = longest * libm::pow(0.05 / longest, part);
        let exponent = if stepper == "dormand-prince45" { exponent.min(10.0) } else { exponent };
        check(stepper, ahead, chosen, libm::pow(10.0, -exponent), step);
    }
}

/// The default tolerances and loose ones, at two steps each.
#[test]
fn each_kind_is_met_at_each_tolerance() {
    let chosen = Choice {
        width: 0.3,
        distance: 10.0,
        strength: 1.0,
        before: [0.0, 0.0],
    };
    for ahead in Ahead::ALL {
        for step in [1.0, 0.1] {
            for tolerance in [1e-15, 1e-10, 1e-8, 1e-6] {
                check("taylor", ahead, chosen, tolerance, step);
            }
            check("dop853", ahead, chosen, 1e-12, step);
            check("dormand-prince45", ahead, chosen, 1e-8, step);
        }
    }
}

/// The motion of [`each_kind_is_met_at_each_tolerance`], to be tuned.
fn scene(ahead: Ahead, stepper: &str, step: f64) -> (String, Motion) {
    let chosen = Choice {
        width: 0.3,
        distance: 10.0,
        strength: 1.0,
        before: [0.0, 0.0],
    };
    let motion = ahead.motion(chosen);
    let steps = libm::ceil(motion.time / step);
    let text = format!(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
         hamiltonian = \"{}\"\n[method]\nstepper = {stepper}\ntime-step = {:?}\n[run]\ninitial = {:?}\nsteps = {steps}\n",
        motion.hamiltonian,
        motion.time / steps,
        motion.initial,
    );
    (text, motion)
}

/// Two methods agree on the motion past each of them, and `tune` finds a Poisson map for it.
#[test]
fn references_and_tuning_see_what_lies_ahead() {
    let registry = Registry::with_builtin();
    for ahead in Ahead::ALL {
        for step in [0.1, 0.03] {
            let (text, motion) = scene(ahead, "\"splitting\"", step);
            let document = document(&text, &[]);
            let bench = Bench::new(&document, &registry, None).expect("a bench");
            let reference = Reference::compute(&bench, Judged::AtTheEnd).expect("a reference");
            for (found, expected) in reference.state.iter().zip(&motion.end) {
                // Sums of thousands of steps.
                let error = (found - expected).abs() / expected.abs().max(1.0);
                assert!(
                    error < 1e-11,
                    "{ahead:?}, {step}: {:?}, {motion:?}",
                    reference.state
                );
            }
            assert!(
                reference.error < 1e-9,
                "{ahead:?}, {step}: {:e}",
                reference.error
            );
            let only = ["kahan-li-8/splitting", "taylor"]
                .map(|method| parse_method(method, &registry).expect("a method"));
            let options = TuneOptions {
                only: only.to_vec(),
                ..TuneOptions::default()
            };
            let tuner = Tuner::new(&bench, &options, &mut |_| true).expect("methods");
            let asked = Tolerances {
                error: Some(1e-4),
                ..Tolerances::default()
            };
            let tuning = tuner.tune(&asked, &mut |_| true).expect("a search");
            assert!(
                tuning.poisson.is_some(),
                "{ahead:?}, {step}: {:?}",
                tuning.limit
            );
            assert_eq!(tuning.horizon, None);
        }
    }
}

/// A hill that is passed within a fiftieth of a step: `taylor` misses it, is told so at any tolerance, and no more once the
/// line that is told has been followed.
#[test]
fn what_is_stepped_over_is_told_and_mended_by_shorter_steps() {
    let text = |stepper: &str, step: f64| {
        format!(
            "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
             hamiltonian = \"p^2/2 + 0.3*exp(-(50*q)^2)\"\n[method]\nstepper = {stepper}\ntime-step = {step:?}\n\
             [run]\ninitial = [-0.48, 1]\nsteps = {}\n",
            libm::round(2.0 / step)
        )
    };
    let told = |text: &str| -> Option<Advice> {
        let run = composed(text);
        let advice = advise(
            &run,
            &Registry::with_builtin(),
            (&states_ahead(&run), JudgedStates::Ahead),
        );
        let mut advice = advice.into_iter();
        advice.find(|advice| advice.kind == AdviceKind::CoarseStep)
    };
    let right = end(&composed(&text("\"taylor\"", 1.0 / 128.0)));
    for stepper in ["\"taylor\"", "{ name = \"taylor\", tolerance = 1e-8 }"] {
        let mut step = 1.0;
        let missed = end(&composed(&text(stepper, step)));
        assert!((missed[0] - right[0]).abs() > 1e-3, "{missed:?} {right:?}");
        while let Some(advice) = told(&text(stepper, step)) {
            step *= 0.5;
            assert!(step > 0.01, "{advice:?}");
            assert_eq!(advice.change, format!("time-step = {step:?}"));
        }
        assert!(step < 1.0, "it was told");
        let found = end(&composed(&text(stepper, step)));
        assert!((found[0] - right[0]).abs() < 1e-5, "{found:?} {right:?}");
    }
}

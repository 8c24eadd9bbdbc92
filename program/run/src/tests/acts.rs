//! Events that change the state, against closed forms: falls, boxes, kicks and mirrors.

use leafwise_scene::compose::ActTensor;
use leafwise_walk::Fault;

use super::{Prepared, StopAfter};
use crate::{Asked, Recorded, RunError, RunOutcome, run_in_memory};

/// A ball of height q, whose flow is a parabola that splitting follows exactly.
fn ball(restitution: &str, more: &str) -> String {
    format!(
        r#"
[system]
variables   = ["q", "p"]
bracket     = "canonical"
hamiltonian = "p^2/2 + q"
[method]
stepper   = "splitting"
time-step = 0.25
[run]
initial = [1, 0]
section = {{ at = "q = 0", direction = "down", set = {{ p = "-{restitution}*p" }} }}
{more}
"#
    )
}

fn recorded(text: &str) -> Result<Recorded, RunError> {
    let Prepared {
        document,
        registry,
        composed,
    } = Prepared::new(text);
    let mut progress = StopAfter(u32::MAX);
    run_in_memory(
        &document,
        &composed,
        &registry,
        Asked::default(),
        &mut progress,
    )
}

fn tensor_of(text: &str) -> ActTensor {
    let events = Prepared::new(text).composed.plan.events;
    events.act_tensor.expect("an act")
}

/// Height and speed at a time between bounces at √2 (1, 3, 5, …): of an elastic ball.
fn falls(t: f64) -> (f64, f64) {
    let half = libm::sqrt(2.0);
    let since = t + half;
    let since = since - 2.0 * half * libm::floor(since / (2.0 * half));
    (half * since - since * since / 2.0, half - since)
}

/// Times, states on the surface, states at steps and between them; round-off adds up over 28 bounces.
#[test]
fn an_elastic_ball_bounces_for_ever() {
    let times =
        "record = { times = [1.3, 1.5, 7.0, 41.75], observables = [\"energy\"] }\nuntil = 80";
    for more in ["steps = 320", times] {
        let run = recorded(&ball("1", more)).expect("a run");
        assert_eq!(run.report.outcome, RunOutcome::Done);
        for row in run.samples.chunks_exact(4) {
            let (q, p) = falls(row[0]);
            assert!((row[1] - q).abs() < 1e-12, "{row:?}");
            assert!((row[2] - p).abs() < 1e-12, "{row:?}");
            assert!((row[3] - 1.0).abs() < 1e-13, "{row:?}");
        }
        let crossings = run.crossings.expect("a section");
        let rows: Vec<&[f64]> = crossings.chunks_exact(4).collect();
        assert_eq!(rows.len(), 28);
        for (count, row) in rows.iter().enumerate() {
            let expected = libm::sqrt(2.0) * (2.0 * count as f64 + 1.0);
            assert!((row[0] - expected).abs() < 1e-13 * expected, "{row:?}");
            // The state before it is turned round.
            assert!(row[1].abs() < 1e-14 && (row[2] + libm::sqrt(2.0)).abs() < 1e-13);
        }
    }
    assert_eq!(tensor_of(&ball("1", "steps = 1")), ActTensor::Kept);
}

/// With restitution e bounces come at √2 (1 + 2 (e + … + eᵏ)), before √2 (1 + 2 e/(1 − e)): where they accumulate, or the motion
/// rests, the run ends as a failure, and never below the floor.
#[test]
fn a_ball_that_comes_to_rest_is_told() {
    for e in [0.8, 0.3, 0.0] {
        let restitution = format!("{e:?}");
        let run = recorded(&ball(&restitution, "steps = 400")).expect("a run");
        let failure = match run.report.outcome {
            RunOutcome::Failed(failure) => failure,
            other => panic!("{e}: {other:?}"),
        };
        assert!(
            failure.message.contains("follow each other without end"),
            "{failure:?}"
        );
        let end = libm::sqrt(2.0) * (1.0 + 2.0 * e / (1.0 - e));
        assert!(
            run.report.time > end - 0.25 && run.report.time < end + 0.5,
            "{e}: {}",
            run.report.time
        );
        let crossings = run.crossings.expect("a section");
        let (mut time, mut way) = (libm::sqrt(2.0), libm::sqrt(2.0));
        // Each is located to round-off of its step.
        for row in crossings.chunks_exact(4).take(5) {
            assert!((row[0] - time).abs() < 1e-11, "{e}: {row:?} for {time}");
            way *= e;
            time += 2.0 * way;
        }
        assert!(run.samples.chunks_exact(4).all(|row| row[1] > -1e-12));
    }
    let stopped = ball("0.8", "steps = 400\nstop = \"p^2/2 + q < 1e-3\"");
    let run = recorded(&stopped).expect("a run");
    // e²ᵏ < 1e-3 from the 16th bounce on.
    assert!(matches!(run.report.outcome, RunOutcome::Stopped(_)));
    assert_eq!(run.crossings.map(|rows| rows.len() / 4), Some(16));
    match tensor_of(&stopped) {
        // det of the map through a bounce: e dp times dq of e.
        ActTensor::Broken(defect) => assert!((0.3..0.4).contains(&defect), "{defect}"),
        other => panic!("{other:?}"),
    }
}

/// Two walls as one surface, and several reflections in one step: x is a triangle wave.
#[test]
fn a_particle_in_a_box_is_folded() {
    for (step, steps) in [(0.1, 400), (0.45, 100), (-0.1, 400)] {
        let text = format!(
            r#"
[system]
variables   = ["q", "p"]
bracket     = "canonical"
hamiltonian = "p^2/2"
[method]
stepper   = "splitting"
time-step = {step:?}
[run]
initial = [0.3, 1.7]
steps   = {steps}
section = {{ at = "q*(1 - q) = 0", direction = "down", set = {{ p = "-p" }} }}
"#
        );
        let run = recorded(&text).expect("a run");
        assert_eq!(run.report.outcome, RunOutcome::Done, "{step}");
        for row in run.samples.chunks_exact(4) {
            let free = 0.3 + 1.7 * row[0];
            let folded = free - 2.0 * libm::floor(free / 2.0);
            let expected = if folded > 1.0 { 2.0 - folded } else { folded };
            assert!(
                (row[1] - expected).abs() < 1e-12,
                "{step}: {row:?} for {expected}"
            );
            assert_eq!(row[2].abs(), 1.7);
        }
        assert_eq!(tensor_of(&text), ActTensor::Kept);
    }
}

/// Kicks at times are the standard map, written out; a kick at a place that changes the energy as the place has it is no Poisson map.
#[test]
fn kicks_are_the_standard_map() {
    let text = r#"
[system]
variables   = ["q", "p"]
parameters  = { K = 0.5 }
bracket     = "canonical"
hamiltonian = "p^2/2 + 0*t"
[method]
stepper   = "splitting"
time-step = 0.3
[run]
initial = [1, 0.3]
until   = 20.5
section = { at = "sin(pi*t) = 0", set = { p = "p + K*sin(q)" } }
record  = { times = [1.5, 5.5, 19.5] }
"#;
    let run = recorded(text).expect("a run");
    let crossings = run.crossings.expect("a section");
    let rows: Vec<&[f64]> = crossings.chunks_exact(4).collect();
    assert_eq!(rows.len(), 20);
    let (mut q, mut p) = (1.3, 0.3);
    for (count, row) in rows.iter().enumerate() {
        let grown = 1e-13 * (1_u64 << count.min(30)) as f64;
        assert!((row[0] - (count as f64 + 1.0)).abs() < 1e-13, "{row:?}");
        assert!(
            (row[1] - q).abs() < grown && (row[2] - p).abs() < grown,
            "{row:?} for {q}, {p}"
        );
        p += 0.5 * libm::sin(q);
        q += p;
    }
    assert_eq!(tensor_of(text), ActTensor::Kept);
    let at_place = text
        .replace("sin(pi*t) = 0", "q = 2")
        .replace("p + K*sin(q)", "p + K");
    assert!(matches!(tensor_of(&at_place), ActTensor::Broken(_)));
    // The same change of the energy in every state on the surface.
    let of_energy = text
        .replace("sin(pi*t) = 0", "q = 2")
        .replace("p + K*sin(q)", "sqrt(p^2 + K)");
    assert_eq!(tensor_of(&of_energy), ActTensor::Kept);
}

/// Kicks of every period against the standard map, whatever part of a step a period is: within steps and at their ends.
#[test]
fn no_kick_is_lost_or_made_twice() {
    let (mut kicks, mut at_ends) = (0, 0);
    for step in [1_u32, 5, 7, 10, 11, 15, 20, 30, 70] {
        for period in [7_u32, 10, 11, 20, 25, 50, 70, 100, 110] {
            // Of steps that are longer the function of the time is not resolved.
            if 3 * step > 2 * period {
                continue;
            }
            // The end is between two kicks.
            let Some(steps) = (280..290).find(|n| (n * step) % period != 0) else {
                continue;
            };
            let end = steps * step;
            for backwards in [1.0, -1.0] {
                let text = format!(
                    r#"
[system]
variables   = ["q", "p"]
parameters  = {{ T = {} }}
bracket     = "canonical"
hamiltonian = "p^2/2 + 0*t"
[method]
stepper   = "splitting"
time-step = {:?}
[run]
initial = [0.3, 0.2]
steps   = {steps}
section = {{ at = "sin(pi*t/T) = 0", set = {{ p = "p + 0.01*sin(q)" }} }}
"#,
                    f64::from(period) / 100.0,
                    backwards * f64::from(step) / 100.0,
                );
                let run = recorded(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
                assert_eq!(run.report.outcome, RunOutcome::Done, "{text}");
                let (mut q, mut p, mut before) = (0.3, 0.2, 0.0);
                let count = (end - 1) / period;
                for k in 1..=count {
                    let t = backwards * f64::from(k * period) / 100.0;
                    q += p * (t - before);
                    p += 0.01 * libm::sin(q);
                    before = t;
                    kicks += 1;
                    at_ends += u32::from((k * period) % step == 0);
                }
                q += p * (backwards * f64::from(end) / 100.0 - before);
                let crossings = run.crossings.expect("a section");
                let times: Vec<f64> = crossings.iter().step_by(4).copied().collect();
                assert_eq!(times.len(), count as usize, "{text}: {times:?}");
                let [.., last_q, last_p] = run.report.final_state[..] else {
                    panic!("two coordinates");
                };
                // Rounding of times and places, a kick each, over times that kicks of 0.01 magnify by less than e^√(0.01 t/T) t.
                let close = 1e-15 * f64::from(count) * f64::from(steps) * (1.0 + q.abs());
                assert!(
                    (last_q - q).abs() < close && (last_p - p).abs() < close,
                    "{text}: {last_q} {last_p} for {q} {p}"
                );
            }
        }
    }
    assert!(kicks > 6000 && at_ends > 2500, "{kicks} {at_ends}");
}

/// Steps that would pass over kicks are refused at the step, and the step that is named makes every kick.
#[test]
fn steps_that_pass_over_kicks_are_refused_with_one_that_does_not() {
    let registry = leafwise_core::Registry::with_builtin();
    let mut refused = 0;
    for key in ["time-step = STEP", "epsilon = 0.5\nh = DOUBLE"] {
        for (step, period) in [
            (0.7, 1.0),
            (1.0, 1.0),
            (1.3, 1.0),
            (-2.0, 1.0),
            (5.0, 0.3),
            (6.1, 0.1),
            (5.0, 0.001),
            (0.68, 1.0),
        ] {
            let end = f64::copysign(20.05 * f64::min(period, 1.0), step);
            let written = key
                .replace("STEP", &format!("{step:?}"))
                .replace("DOUBLE", &format!("{:?}", 2.0 * step));
            let text = format!(
                r#"
[system]
variables   = ["q", "p"]
parameters  = {{ T = {period:?} }}
bracket     = "canonical"
hamiltonian = "p^2/2 + 0*t"
[method]
stepper   = "splitting"
{written}
[run]
initial = [0.3, 0.2]
until   = {end:?}
section = {{ at = "sin(pi*t/T) = 0", set = {{ p = "p + 0.01*sin(q)" }} }}
"#
            );
            let document = leafwise_scene::SceneDocument::parse("kicks.toml", &text, &registry)
                .expect("a scene");
            let refusal = leafwise_scene::compose::compose(&document, &registry)
                .err()
                .unwrap_or_else(|| panic!("{text}"));
            assert!(
                refusal.message.contains("pass over some of it"),
                "{refusal}"
            );
            let help = refusal.help.expect("a cure");
            let line = help.strip_prefix("write ").expect("a line");
            let of_step = written.lines().last().expect("a line");
            let cured = text.replace(of_step, line);
            let run = recorded(&cured).unwrap_or_else(|error| panic!("{cured}: {error}"));
            let times: Vec<f64> = run
                .crossings
                .expect("a section")
                .iter()
                .step_by(4)
                .copied()
                .collect();
            assert_eq!(times.len(), 20, "{cured}");
            for (k, time) in (1_u32..).zip(&times) {
                let expected = (period * f64::from(k)).copysign(step);
                assert!((time - expected).abs() < 1e-10, "{cured}: {times:?}");
            }
            refused += 1;
        }
    }
    assert_eq!(refused, 16);
}

/// A billiard in a circle: the tensor by differences of the whole run, the angular momentum, and the mirror's law against its retro-reflection.
#[test]
fn a_billiard_is_a_poisson_map() {
    let text = |initial: [f64; 4], set: &str| {
        format!(
            r#"
[system]
variables   = {{ r = 2, p = 2 }}
bracket     = "canonical"
hamiltonian = "dot(p, p)/2 + dot(r, r)/4"
[method]
stepper     = "splitting"
time-step   = 0.1
[run]
initial = {initial:?}
steps   = 60
section = {{ at = "dot(r, r) = 1", direction = "up", set = {{ p = "{set}" }} }}
record  = {{ observables = ["energy", "r.x*p.y - r.y*p.x"] }}
"#
        )
    };
    const MIRROR: &str = "p - 2*dot(r, p)*r/dot(r, r)";
    let start = [0.2, -0.1, 0.9, 0.7];
    let ends = |initial: [f64; 4]| {
        let run = recorded(&text(initial, MIRROR)).expect("a run");
        assert!(run.crossings.is_some_and(|rows| rows.len() / 7 >= 3));
        run.report.final_state
    };
    let run = recorded(&text(start, MIRROR)).expect("a run");
    let first = run.samples[6];
    assert!(
        run.samples
            .chunks_exact(7)
            .all(|row| (row[6] - first).abs() < 1e-13)
    );
    const DELTA: f64 = 1e-5;
    let columns: Vec<Vec<f64>> = (0..4)
        .map(|at| {
            let (mut more, mut less) = (start, start);
            more[at] += DELTA;
            less[at] -= DELTA;
            let pairs = ends(more).into_iter().zip(ends(less));
            pairs
                .map(|(more, less)| (more - less) / (2.0 * DELTA))
                .collect()
        })
        .collect();
    // D Ω Dᵀ = Ω, to the differences' error, δ² times third derivatives.
    for i in 0..4 {
        for j in 0..4 {
            let of =
                |a: usize, b: usize| columns[a][i] * columns[b][j] - columns[b][i] * columns[a][j];
            let found = of(0, 2) + of(1, 3);
            let expected = f64::from(i32::from(j == i + 2) - i32::from(i == j + 2));
            assert!((found - expected).abs() < 1e-5, "{i}, {j}: {found}");
        }
    }
    assert_eq!(tensor_of(&text(start, MIRROR)), ActTensor::Kept);
    assert!(matches!(
        tensor_of(&text(start, "-p")),
        ActTensor::Broken(_)
    ));
}

/// A wall that no formula passes: what has no value, and what cannot be combined with it.
#[test]
fn what_cannot_act_is_refused() {
    let run = recorded(&ball("1", "steps = 40").replace("-1*p", "ln(p)")).expect("a run");
    let RunOutcome::Failed(failure) = run.report.outcome else {
        panic!("{:?}", run.report.outcome);
    };
    let told = Fault::Undefined("p = ln(p)".to_owned()).to_string();
    assert!(failure.message.contains(&told), "{failure:?}");
    let refused = |text: &str| {
        let registry = leafwise_core::Registry::with_builtin();
        let document = leafwise_scene::document::SceneDocument::parse("top.toml", text, &registry);
        let document = document.unwrap_or_else(|errors| panic!("{:?}", errors.diagnostics()));
        let refusal = leafwise_scene::compose(&document, &registry).err();
        refusal.expect("a refusal").message
    };
    let paced = ball("1", "until = 3").replace("time-step", "pace = \"1/(1 + q^2)\"\ntime-step");
    let paced = paced.replace(
        "stepper   = \"splitting\"",
        "stepper = \"implicit-midpoint\"",
    );
    assert!(refused(&paced).contains("not offered with a pace"));
    let exact = ball("1", "steps = 9").replace("time-step", "energy = \"exact\"\ntime-step");
    let body = exact.replace(
        "variables   = [\"q\", \"p\"]\nbracket     = \"canonical\"\nhamiltonian = \"p^2/2 + q\"",
        "variables = [\"x1\", \"x2\", \"x3\"]\nbracket = { lie-algebra = \"so3\" }\nhamiltonian = \"x1^2 + x2^2/2 + x3^2/3\"\n\
         casimirs = { size2 = \"x1^2 + x2^2 + x3^2\" }",
    );
    let body = body
        .replace("initial = [1, 0]", "initial = [1, 3, 3]")
        .replace("q = 0", "x1 = 0")
        .replace("p = \"-1*p\"", "x2 = \"-x2\"");
    assert!(
        refused(&body).contains("not offered with exact energy"),
        "{}",
        refused(&body)
    );
    let chaos = ball("1", "steps = 9\nrecord = { observables = [\"megno\"] }");
    assert!(refused(&chaos).contains("not offered with indicators"));
    let unknown = ball("1", "steps = 9").replace("{ p = ", "{ v = ");
    assert!(refused(&unknown).contains("`v`"), "{}", refused(&unknown));
    let none = ball("1", "steps = 9").replace("{ p = \"-1*p\" }", "{}");
    assert_eq!(refused(&none), "`set` changes nothing");
}

/// A change that has no value where the run begins has one on the surface.
#[test]
fn changes_need_values_on_their_surface_alone() {
    let text = ball("1", "steps = 40").replace("-1*p", "sqrt(p^2 - 0.01)");
    let run = recorded(&text).expect("a run");
    assert_eq!(run.report.outcome, RunOutcome::Done);
    assert!(run.crossings.is_some_and(|rows| rows.len() > 4));
}

/// What an event does to the energy is no error of the method, and a parameter that it names is used.
#[test]
fn what_events_do_is_not_warned_of() {
    let text = ball("e", "steps = 60").replace("[method]", "parameters = { e = 0.5 }\n[method]");
    let stopped = text.replace("steps = 60", "steps = 60\nstop = \"q + p^2/2 < 0.1\"");
    let run = recorded(&stopped).expect("a run");
    assert!(matches!(run.report.outcome, RunOutcome::Stopped(_)));
    assert_eq!(run.page.advice, []);
}

/// A ball that falls on a floor and back passes other surfaces twice in each step that bounces: at q = a it has fallen for √(2 (1 − a)), and
/// rises as long after the bounce at √2. Where its speed turns round without a way through zero, p = 0 is crossed at the tops alone.
#[test]
fn other_events_are_seen_before_and_behind_a_bounce() {
    let Prepared {
        document,
        registry,
        composed,
    } = Prepared::new(&ball("1", "steps = 80"));
    let of = |text: &str, direction, last| leafwise_walk::Event {
        section: composed
            .section(&document, text, direction)
            .expect("a section"),
        act: None,
        last,
    };
    let surfaces = [0.004, 0.02, 0.3];
    let both = leafwise_walk::Direction::Both;
    let mut events: Vec<_> = surfaces
        .iter()
        .map(|a| of(&format!("q = {a:?}"), both, None))
        .collect();
    events.push(of("p = 0", both, None));
    let asked = |events| Asked {
        events,
        ..Asked::default()
    };
    let mut progress = StopAfter(u32::MAX);
    let run = run_in_memory(
        &document,
        &composed,
        &registry,
        asked(&events),
        &mut progress,
    );
    let run = run.expect("a run");
    let half = libm::sqrt(2.0);
    for (surface, found) in surfaces.iter().zip(&run.events) {
        let fall = libm::sqrt(2.0 * (1.0 - surface));
        let expected: Vec<f64> = (0..8)
            .flat_map(|k| {
                let top = 2.0 * half * f64::from(k);
                [top + fall, top + 2.0 * half - fall]
            })
            .take_while(|time| *time < 20.0)
            .collect();
        let times: Vec<f64> = found.iter().map(|crossing| crossing.time).collect();
        assert_eq!(
            times.len(),
            expected.len(),
            "{surface}: {times:?} {expected:?}"
        );
        for (time, expected) in times.iter().zip(&expected) {
            // A small height is reached to round-off over the speed there.
            assert!(
                (time - expected).abs() < 1e-12,
                "{surface}: {time} for {expected}"
            );
        }
    }
    let tops: Vec<f64> = run.events[3].iter().map(|crossing| crossing.time).collect();
    assert_eq!(tops.len(), 7, "{tops:?}");
    for (k, time) in tops.iter().enumerate() {
        assert!(
            (time - 2.0 * half * (k + 1) as f64).abs() < 1e-12,
            "{tops:?}"
        );
    }
    // One that ends the run between a crossing and the bounce of the same step.
    let last = [of("q = 0.004", leafwise_walk::Direction::Down, Some(2))];
    let run = run_in_memory(&document, &composed, &registry, asked(&last), &mut progress);
    let run = run.expect("a run");
    let end = 2.0 * half + libm::sqrt(2.0 * 0.996);
    assert!((run.report.time - end).abs() < 1e-12, "{}", run.report.time);
    assert_eq!(run.crossings.map(|rows| rows.len() / 4), Some(1));
}

//! Where members end between two steps, and where they cross a section.

use std::fs;

use super::running::StopAfter;
use super::*;
use crate::{Quiet, RunJob, RunOutcome};
use leafwise_scene::compose::compose;

const FILES: [&str; 6] = [
    "statistics.csv",
    "windows.csv",
    "final_states.csv",
    "losses.csv",
    "section.csv",
    "scene.toml",
];

/// q(t) = q₀ + p t.
const FREE: &str = r#"
[system]
variables   = ["q", "p"]
bracket     = { "q,p" = "1" }
convention  = "{x,H}"
hamiltonian = "p^2/2"
[method]
stepper     = "splitting"
time-step   = 0.25
[run]
initial = [0, 0.5]
steps   = 16
stop    = "q >= 1"
[ensemble]
members = 2000
initial = { box = [0, 0.5] }
record  = { every = 4, observables = ["q"] }
final-states = "csv"
"#;

/// q(t) = √(2E) sin(ωt + φ); the frequency differs from member to member.
const SWING: &str = r#"
[system]
variables   = ["q", "p"]
parameters  = { w = 1 }
bracket     = { "q,p" = "1" }
convention  = "{x,H}"
hamiltonian = "w*(p^2 + q^2)/2"
[method]
METHOD
time-step   = 0.1
[run]
initial = [0, 1]
steps   = 150
stop    = "q + 0.02*p > 0.9"
section = { at = "q = 0.3", direction = "both" }
[ensemble]
members = 90
seed    = 3
initial = { ball = 0.4 }
parameters = { w = { normal = [1, 0.1] } }
record  = { every = 7, observables = ["energy", "q*p"], quantiles = [0.5] }
final-states = "csv"
"#;

fn parsed(text: &str) -> SceneDocument {
    SceneDocument::parse("scene.toml", text, &Registry::empty()).expect("a scene")
}

fn table(directory: &Path, file: &str) -> Vec<Vec<String>> {
    let text = fs::read_to_string(directory.join(file)).expect(file);
    let row = |line: &str| line.split(',').map(str::to_owned).collect();
    text.lines().skip(1).map(row).collect()
}

fn number(cell: &str) -> f64 {
    cell.parse().expect("a number")
}

/// Each member that is fast enough is lost at t = (1 − q)/p, where it is at q = 1; the part of them that is lost by t is
/// that of the speeds beyond 1/t, and lies as the binomial distribution has it about 1 − 1/t.
#[test]
fn free_members_are_lost_when_they_come_to_the_wall() {
    let document = parsed(FREE);
    let ensemble = composed(&document);
    let root = tempfile::tempdir().expect("a directory");
    let report = attempt(&document, root.path(), workforce(2, 16), &mut Quiet).expect("done");
    let mut times = Vec::new();
    for (member, row) in (0..).zip(table(root.path(), "final_states.csv")) {
        let (state, _) = ensemble.population.draw(member).expect("a state");
        let (expected, t) = (1.0 / state[1], number(&row[2]));
        let (q, p) = (number(&row[3]), number(&row[4]));
        assert_eq!(p, state[1]);
        if expected < 4.0 {
            assert_eq!(row[1], "stopped", "{row:?}");
            // The length of the last step is enclosed to round-off, and is a part of t.
            assert!(
                (t - expected).abs() <= 8.0 * f64::EPSILON * expected,
                "{row:?}"
            );
            assert!(q >= 1.0 && q - 1.0 <= 8.0 * f64::EPSILON, "{row:?}");
            times.push(t);
        } else {
            assert_eq!((row[1].as_str(), t), ("done", 4.0), "{row:?}");
            assert_eq!(q, 4.0 * p);
        }
    }
    let all = &report.reductions;
    assert_eq!((all.stopped, all.failed), (times.len() as u64, 0));
    assert_eq!(all.done() + all.stopped, 2000);
    let losses = ensemble.losses(all);
    assert_eq!(losses.len(), 17);
    for (loss, row) in losses.iter().zip(table(root.path(), "losses.csv")) {
        let count = times.iter().filter(|t| **t <= loss.time).count() as u64;
        assert_eq!((loss.stopped, loss.members), (count, 2000));
        assert_eq!(number(&row[3]), count as f64 / 2000.0);
        let p = (1.0 - 1.0 / loss.time).max(0.0);
        let deviation = libm::sqrt(p * (1.0 - p) / 2000.0);
        assert!((loss.fraction - p).abs() <= 4.0 * deviation, "{loss:?}");
        let [low, high] = loss.interval;
        assert!(low <= loss.fraction && loss.fraction <= high);
    }
    // What is recorded at t = 2 is of the members that are there.
    let there = times.iter().filter(|t| **t > 2.0).count() as u64 + all.done();
    assert_eq!(all.summaries[2].count, there);
    assert!(all.summaries[2].maximum.0 < 1.0);
    assert_eq!(all.summaries[4].count, all.done());
}

/// Ellipses of several eccentricities, each at its own pace; a part of them goes out further than allowed.
const PACED: &str = r#"
[system]
variables   = ["q1", "q2", "p1", "p2"]
parameters  = { m = 1 }
bracket     = { "q1,p1" = "1", "q2,p2" = "1" }
convention  = "{x,H}"
hamiltonian = "(p1^2 + p2^2)/2 - m/sqrt(q1^2 + q2^2)"
[method]
METHOD
pace        = "(q1^2 + q2^2)^0.75"
time-step   = 0.1
[run]
initial = [0.5, 0, 0, 1.7]
until   = 12
stop    = "q1^2 + q2^2 > 2.25"
section = { at = "q2 = 0.1", direction = "both" }
[ensemble]
members = 90
seed    = 3
initial = { box = [0.05, 0, 0, 0.15] }
parameters = { m = { normal = [1, 0.02] } }
record  = { interval = 1.7, observables = ["energy", "q1*p2 - q2*p1"], quantiles = [0.5] }
final-states = "csv"
"#;

/// Of systems that a pace makes of them too.
const PACED_METHODS: [&str; 2] = [
    "realization = { name = \"karasev-truncated\", order = 2 }\n\
     dynamics = { name = \"hamilton-jacobi\", order = 4 }",
    "stepper = \"implicit-midpoint\"",
];

/// Scenes with events: of equal steps, also with samples at times between them, and with a pace.
fn scenes() -> impl Iterator<Item = String> {
    let swings = METHODS.map(|method| SWING.replace("METHOD", method));
    let timed = swings[0].replace("every = 7", "times = [0.33, 4.0, 11.05]");
    // Members that stop on the section, and steps that begin and end on it.
    let ending = swings[0].replace("q + 0.02*p > 0.9", "q > 0.85");
    let ending = ending.replace("q = 0.3", "q = 0.85");
    let driven = swings[0].replace("/2\"", "/2 + 0.01*q*cos(20*pi*t)\"");
    let driven = driven.replace("q = 0.3", "sin(10*pi*t) = 0");
    let paced = PACED_METHODS.map(|method| PACED.replace("METHOD", method));
    // Walls that turn the members round, and a condition that some never come to.
    let walls =
        "section = { at = \"q*(0.6 - q) = 0\", direction = \"down\", set = { p = \"-0.999*p\" } }";
    let walls = swings[0].replace(
        "section = { at = \"q = 0.3\", direction = \"both\" }",
        walls,
    );
    let walls = walls
        .replace("initial = [0, 1]", "initial = [0.3, 1]")
        .replace("ball = 0.4", "ball = 0.25");
    let walls = walls.replace("q + 0.02*p > 0.9", "q*p > 0.55");
    let others = [timed, ending, driven, walls].into_iter().chain(paced);
    swings.into_iter().chain(others)
}

#[test]
fn events_depend_neither_on_lanes_nor_on_threads_nor_on_interruptions() {
    for text in scenes() {
        let document = parsed(&text);
        let root = tempfile::tempdir().expect("a directory");
        let mut all = Vec::new();
        let mut take = |directory: &Path, report: EnsembleReport| {
            let mut reductions = report.reductions;
            reductions.statistics = Default::default();
            let files = FILES.map(|file| fs::read(directory.join(file)).expect(file));
            all.push((reductions, report.crossings, files));
        };
        for (threads, lanes) in [(1, 64), (1, 1), (2, 7), (3, 8)] {
            let directory = root.path().join(format!("{threads}-{lanes}"));
            let report = attempt(&document, &directory, workforce(threads, lanes), &mut Quiet);
            take(&directory, report.expect("an ensemble"));
        }
        let pieces = root.path().join("pieces");
        let report = loop {
            let report = attempt(&document, &pieces, workforce(2, 4), &mut StopAfter(3));
            let report = report.expect("a session");
            if report.outcome == RunOutcome::Done {
                break report;
            }
        };
        take(&pieces, report);
        let (reductions, crossings, _) = &all[0];
        assert!(
            reductions.stopped > 10 && reductions.done() > 10,
            "{reductions:?}"
        );
        assert!(crossings.is_some_and(|count| count > 50));
        for other in &all[1..] {
            assert!(other == &all[0], "{text}");
        }
    }
}

#[test]
fn a_member_alone_ends_and_crosses_as_in_the_ensemble() {
    for scene in scenes() {
        let document = parsed(&scene);
        let ensemble = composed(&document);
        let (observables, names) = (ensemble.observables(), ensemble.run.names());
        let quoted = observables
            .iter()
            .map(|name| format!("{name:?}"))
            .collect::<Vec<_>>();
        let quoted = quoted.join(", ");
        let root = tempfile::tempdir().expect("a directory");
        let whole = root.path().join("all");
        attempt(&document, &whole, workforce(2, 16), &mut Quiet).expect("done");
        let crossings = fs::read_to_string(whole.join("section.csv")).expect("crossings");
        let heading = [
            &names.iter().map(String::as_str).collect::<Vec<_>>()[..],
            &observables,
        ]
        .concat();
        assert!(crossings.starts_with(&format!("member,t,{}\n", heading.join(","))));
        for (member, row) in (0..).zip(table(&whole, "final_states.csv")).step_by(6) {
            let text = member_scene(&document, &ensemble, member).expect("a scene");
            let text = text.replace(
                "[run]",
                &format!("[run]\nrecord = {{ observables = [{quoted}] }}"),
            );
            let alone = parsed(&text);
            let composed = match compose(&alone, &Registry::with_builtin()) {
                Ok(composed) => composed,
                Err(refusal) => {
                    assert!(refusal.message.contains("holds at the initial state"));
                    assert_eq!((row[1].as_str(), number(&row[2])), ("stopped", 0.0));
                    continue;
                }
            };
            let directory = root.path().join(format!("{member}"));
            let (registry, options) = (Registry::with_builtin(), options(&directory));
            let job = RunJob::new(&alone, &composed, &registry, &options).expect("a run");
            let report = perform(&job, &mut Quiet).expect("a run");
            assert_eq!(report.outcome.word(), row[1]);
            assert_eq!(format!("{:?}", report.time), row[2]);
            let state: Vec<String> = report
                .final_state
                .iter()
                .map(|x| format!("{x:?}"))
                .collect();
            assert_eq!(row[4..][..state.len()], state, "{scene}, {member}");
            let drift = format!("{:?}", report.invariants[0].maximum);
            assert_eq!(row.last(), Some(&drift), "{scene}, {member}");
            let own = fs::read_to_string(directory.join("section.csv")).expect("crossings");
            let own: Vec<String> = own
                .lines()
                .skip(1)
                .map(|line| format!("{member},{line}"))
                .collect();
            let begin = format!("{member},");
            let listed: Vec<&str> = crossings
                .lines()
                .filter(|line| line.starts_with(&begin))
                .collect();
            assert_eq!(listed, own, "{scene}, {member}");
        }
    }
}

/// More rows than a member holds in memory wait in a file, which is gone at the end.
#[test]
fn many_crossings_are_put_aside() {
    let text = FREE
        .replace("p^2/2\"", "p^2/2 + q^2/2\"")
        .replace(
            "stop    = \"q >= 1\"",
            "section = { at = \"q = 0\", direction = \"up\" }",
        )
        .replace("steps   = 16", "steps   = 20000")
        .replace("members = 2000", "members = 3")
        .replace("every = 4", "every = 20000");
    let document = parsed(&text);
    let root = tempfile::tempdir().expect("a directory");
    let directory = root.path().join("run");
    let report = attempt(&document, &directory, workforce(1, 3), &mut Quiet).expect("done");
    let rows = table(&directory, "section.csv");
    assert_eq!(report.crossings, Some(rows.len() as u64));
    let size = fs::metadata(directory.join("section.csv"))
        .expect("a file")
        .len();
    assert!(size > 3 * (1 << 15), "{size}");
    // The splitting turns by 2 asin(h/2) each step: one crossing in each turn.
    let turn = std::f64::consts::PI / libm::asin(0.125);
    let times: Vec<f64> = rows.iter().map(|row| number(&row[1])).collect();
    for (pair, rows) in times.windows(2).zip(rows.windows(2)) {
        if rows[0][0] == rows[1][0] {
            assert!((pair[1] - pair[0] - 0.25 * turn).abs() < 0.02, "{pair:?}");
        }
        assert!(rows[0][0] <= rows[1][0]);
    }
    let left = fs::read_dir(&directory).expect("files");
    let left = left.filter(|entry| {
        let name = entry.as_ref().expect("a file").file_name();
        name.to_string_lossy().ends_with(".part")
    });
    assert_eq!(left.count(), 0);
}

/// What has no value at a member ends that member alone.
#[test]
fn a_condition_without_a_value_is_a_failure_of_its_member() {
    for (from, to) in [
        ("stop    = \"q >= 1\"", "stop    = \"sqrt(0.5 - q) < -1\""),
        (
            "stop    = \"q >= 1\"",
            "section = { at = \"sqrt(0.5 - q) = 0.65\" }",
        ),
    ] {
        let document = parsed(&FREE.replace(from, to));
        let root = tempfile::tempdir().expect("a directory");
        let report = attempt(&document, root.path(), workforce(2, 16), &mut Quiet).expect("done");
        let all = &report.reductions;
        assert!(all.failed > 1000 && all.done() > 100 && all.stopped == 0);
        let first = &all.failures[0];
        assert!(first.message.contains("sqrt(0.5 - q)"), "{first:?}");
        assert!(first.message.contains("has no finite value at this state"));
        assert!(first.state[0] > 0.5);
        if report.crossings.is_some() {
            // The others cross before they fail, and their rows go with them.
            let rows = table(root.path(), "section.csv");
            assert!(rows.len() > 50);
            assert!(rows.iter().all(|row| number(&row[3]) <= 0.125), "{rows:?}");
        }
    }
}

/// Statistics are of one time: Kepler's ellipses are where their mean anomaly has them, whatever steps a member has made.
#[test]
fn members_with_a_pace_are_at_one_time() {
    let text = PACED
        .replace("METHOD", PACED_METHODS[0])
        .replace("order = 4", "order = 8")
        .replace("time-step   = 0.1", "time-step   = 0.05")
        .replace("stop    = \"q1^2 + q2^2 > 2.25\"\n", "")
        .replace("interval = 1.7", "times = [1, 5]")
        .replace("[\"energy\", \"q1*p2 - q2*p1\"]", "[\"q1\", \"energy\"]");
    let document = parsed(&text);
    let ensemble = composed(&document);
    assert_eq!(ensemble.sampled(), [0.0, 1.0, 5.0, 12.0]);
    let root = tempfile::tempdir().expect("a directory");
    let report = attempt(&document, root.path(), workforce(2, 8), &mut Quiet).expect("done");
    let all = &report.reductions;
    assert_eq!((all.done(), all.failed), (90, 0));
    for (at, time) in ensemble.sampled().into_iter().enumerate() {
        let mut sum = 0.0;
        for member in 0..90 {
            let (state, parameters) = ensemble.population.draw(member).expect("a state");
            sum += kepler(state[0], state[3], parameters[0], time);
        }
        let mean = all.summaries[2 * at].mean;
        // The method's own error over some periods at this step.
        assert!(
            (mean - sum / 90.0).abs() < 2e-8,
            "t = {time}: {mean}, {}",
            sum / 90.0
        );
    }
    assert!(all.whole[0].maximum < 1e-9, "{:?}", all.whole[0]);
}

/// q1(t) from (r, 0) with the velocity (0, v): r − a (e + cos E) is the focus, E − e sin E = n t about the pericentre.
fn kepler(r: f64, v: f64, m: f64, t: f64) -> f64 {
    let a = 1.0 / (2.0 / r - v * v / m);
    let e = 1.0 - r / a;
    let n = libm::sqrt(m / (a * a * a));
    // At the apocentre, where e < 0 by the sign above, the anomaly is counted from there.
    let mut anomaly = n * t;
    for _ in 0..60 {
        let missed = anomaly - e * libm::sin(anomaly) - n * t;
        anomaly -= missed / (1.0 - e * libm::cos(anomaly));
    }
    a * (libm::cos(anomaly) - e)
}

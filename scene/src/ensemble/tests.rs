//! Results depend neither on lanes nor on threads nor on interruptions; a member alone is the member.

use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;

use leafwise_core::Registry;
use leafwise_hamilton_jacobi as _;
use leafwise_karasev as _;
use leafwise_reference as _;
use leafwise_splitting as _;

use super::*;
use crate::compose::compose;
use crate::document::SceneDocument;
use crate::run::{Kind, Manifest, Progress, Quiet, RunError, RunOptions, RunOutcome, Status};

const BODY: &str = r#"
[system]
variables   = ["x1", "x2", "x3"]
parameters  = { I1 = 1.0, I2 = 0.75, I3 = 1.25 }
bracket     = { "x1,x2" = "-x3", "x2,x3" = "-x1", "x3,x1" = "-x2" }
hamiltonian = "x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)"
casimirs    = { spin = "x1^2 + x2^2 + x3^2" }
[method]
METHOD
time-step   = 0.1
[run]
initial = [1, 3, 3]
steps   = 43
[ensemble]
ENSEMBLE
"#;

const METHODS: [&str; 3] = [
    "stepper = \"splitting\"",
    "realization = { name = \"karasev-truncated\", order = 4 }\n\
     dynamics = { name = \"hamilton-jacobi\", order = 2 }",
    "stepper = \"implicit-midpoint\"",
];

const ENSEMBLE: &str = "members = 60\nseed = 5\ninitial = { ball = 0.2 }\n\
    parameters = { I2 = { normal = [0.75, 0.01] }, I3 = { values = [1.25, 1.5, 2] } }\n\
    record = { every = 10, observables = [\"energy\", \"x1*x2\"], quantiles = [0.25, 0.5] }\n\
    final-states = \"csv\"";

fn scene(method: &str, ensemble: &str) -> SceneDocument {
    let text = BODY.replace("METHOD", method).replace("ENSEMBLE", ensemble);
    SceneDocument::parse("body.toml", &text, &Registry::empty()).expect("a scene")
}

fn composed(document: &SceneDocument) -> ComposedEnsemble {
    let registry = Registry::with_builtin();
    compose_ensemble(document, &registry, Path::new("")).expect("an ensemble")
}

fn workforce(threads: usize, lanes: usize) -> Workforce {
    let count = |n| NonZeroUsize::new(n).expect("positive");
    Workforce {
        threads: count(threads),
        lanes: count(lanes),
    }
}

fn options(directory: &Path) -> RunOptions {
    RunOptions {
        checkpoint_every: RunOptions::CHECKPOINT_EVERY,
        directory: directory.to_owned(),
        force: false,
        allow_non_poisson: false,
        command: "leafwise ensemble body.toml".to_owned(),
    }
}

fn attempt(
    document: &SceneDocument,
    directory: &Path,
    force: Workforce,
    progress: &mut dyn Progress,
) -> Result<EnsembleReport, RunError> {
    run_ensemble(
        document,
        &composed(document),
        &options(directory),
        force,
        progress,
    )
}

/// Everything but the work counted, which is summed over blocks.
const FILES: [&str; 4] = [
    "statistics.csv",
    "windows.csv",
    "final_states.csv",
    "scene.toml",
];

#[test]
fn results_depend_neither_on_lanes_nor_on_threads() {
    for method in METHODS {
        let document = scene(method, ENSEMBLE);
        let root = tempfile::tempdir().expect("a directory");
        let mut all = Vec::new();
        for (threads, lanes) in [(1, 1), (1, 64), (2, 7), (3, 8), (2, 32)] {
            let directory = root.path().join(format!("{threads}-{lanes}"));
            let report = attempt(&document, &directory, workforce(threads, lanes), &mut Quiet);
            let mut report = report.expect("an ensemble");
            assert_eq!(report.outcome, RunOutcome::Done);
            report.reductions.statistics = Default::default();
            let files = FILES.map(|file| fs::read(directory.join(file)).expect(file));
            assert!(directory.join("report.html").exists());
            all.push((report.reductions, files));
        }
        assert_eq!(all[0].0.members, 60);
        assert_eq!(all[0].0.failed, 0);
        for other in &all[1..] {
            assert_eq!(other, &all[0], "{method}");
        }
    }
}

#[test]
fn a_member_alone_is_the_member_of_the_ensemble() {
    for method in METHODS {
        let document = scene(method, ENSEMBLE);
        let ensemble = composed(&document);
        let root = tempfile::tempdir().expect("a directory");
        let report = attempt(&document, root.path(), workforce(2, 16), &mut Quiet);
        report.expect("an ensemble");
        let rows = fs::read_to_string(root.path().join("final_states.csv")).expect("states");
        let rows: Vec<&str> = rows.lines().skip(1).collect();
        for member in [0, 17, 59] {
            let text = member_scene(&document, &ensemble, member).expect("a scene");
            let alone =
                SceneDocument::parse("member.toml", &text, &Registry::empty()).expect("a scene");
            assert!(alone.ensemble.is_none());
            let run = compose(&alone, &Registry::with_builtin()).expect("a run");
            let mut integrator = run.integrator();
            for _ in 0..run.plan.steps {
                integrator.step().expect("a step");
            }
            let parameters = run.system.parameter_values();
            let own = parameters[1..].iter().chain(integrator.state());
            let numbers: Vec<String> = own.map(|value| format!("{value:?}")).collect();
            let expected = format!("{member},done,{},", numbers.join(","));
            let row = rows[member as usize];
            assert!(row.starts_with(&expected), "{row}\n{expected}");
        }
    }
}

#[test]
fn reductions_are_those_of_the_members() {
    let document = scene(METHODS[0], ENSEMBLE);
    let ensemble = composed(&document);
    let root = tempfile::tempdir().expect("a directory");
    let report = attempt(&document, root.path(), workforce(2, 16), &mut Quiet).expect("done");
    let all = &report.reductions;
    assert_eq!(ensemble.sampled_steps(), [0, 10, 20, 30, 40, 43]);
    // x1 x2 at t = 2, and the energy's drift, member by member.
    let (mut values, mut drifts) = (Vec::new(), Vec::new());
    for member in 0..60 {
        let text = member_scene(&document, &ensemble, member).expect("a scene");
        let alone =
            SceneDocument::parse("member.toml", &text, &Registry::empty()).expect("a scene");
        let run = compose(&alone, &Registry::with_builtin()).expect("a run");
        let mut invariants = run.invariants().expect("code");
        let mut integrator = run.integrator();
        let mut energy = |state: &[f64]| {
            let mut values = [0.0; 2];
            invariants.evaluate(state, &mut values);
            values[0]
        };
        let (initial, mut drift) = (energy(integrator.state()), 0.0_f64);
        for step in 1..=43 {
            integrator.step().expect("a step");
            drift = drift.max((energy(integrator.state()) - initial).abs());
            if step == 20 {
                values.push(integrator.state()[0] * integrator.state()[1]);
            }
        }
        drifts.push(drift);
    }
    let summary = &all.summaries[2 * 2 + 1];
    let mean = values.iter().sum::<f64>() / 60.0;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / 59.0;
    assert!((summary.mean - mean).abs() <= 60.0 * f64::EPSILON * mean.abs());
    assert!((summary.variance() - variance).abs() <= 1e-12 * variance);
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    assert_eq!(summary.quantiles(&[0.25, 0.5]), [sorted[14], sorted[29]]);
    assert_eq!(
        (summary.minimum.0, summary.maximum.0),
        (sorted[0], sorted[59])
    );
    assert_eq!(values[summary.maximum.1 as usize], sorted[59]);
    let largest = drifts.iter().copied().fold(0.0, f64::max);
    assert_eq!(all.whole[0].maximum, largest);
    assert_eq!(drifts[all.whole[0].member as usize], largest);
    let total: f64 = drifts.iter().sum();
    assert!((all.mean_deviation(&all.whole[0]) - total / 60.0).abs() <= 1e-14 * total);
}

/// Interrupts after a few looks.
struct StopAfter(u32);

impl Progress for StopAfter {
    fn show(&mut self, _status: &Status) {
        self.0 = self.0.saturating_sub(1);
    }

    fn is_interrupted(&self) -> bool {
        self.0 == 0
    }
}

#[test]
fn an_interrupted_ensemble_resumes_to_the_same_bits() {
    let document = scene(
        METHODS[0],
        &ENSEMBLE.replace("members = 60", "members = 3000"),
    );
    let root = tempfile::tempdir().expect("a directory");
    let (whole, pieces) = (root.path().join("whole"), root.path().join("pieces"));
    let reference = attempt(&document, &whole, workforce(1, 64), &mut Quiet).expect("done");
    let mut sessions = 0;
    let resumed = loop {
        let report = attempt(&document, &pieces, workforce(2, 16), &mut StopAfter(3));
        let report = report.expect("a session");
        sessions += 1;
        if report.outcome == RunOutcome::Done {
            break report;
        }
        assert_eq!(report.outcome, RunOutcome::Interrupted);
        assert!(Manifest::read(&pieces).expect("a manifest").is_unfinished());
        // Rows that the checkpoint does not count.
        let states = pieces.join("final_states.csv");
        let text = fs::read_to_string(&states).expect("states") + "7,done,1.5";
        fs::write(&states, text).expect("writable");
    };
    assert!(sessions >= 3, "{sessions} sessions");
    for file in FILES {
        let read = |directory: &Path| fs::read(directory.join(file)).expect(file);
        assert_eq!(read(&whole), read(&pieces), "{file}");
    }
    assert_eq!(resumed.reductions.summaries, reference.reductions.summaries);
    assert_eq!(
        Manifest::read(&pieces).expect("a manifest").kind,
        Kind::Ensemble
    );
    // Its end is told again, and nothing is written.
    let manifest = fs::read(pieces.join("manifest.json")).expect("a manifest");
    let again = attempt(&document, &pieces, workforce(1, 1), &mut Quiet).expect("the end");
    assert!(again.is_repeated && again.outcome == RunOutcome::Done);
    assert!(again.reductions == resumed.reductions);
    assert_eq!(
        fs::read(pieces.join("manifest.json")).expect("a manifest"),
        manifest
    );
}

#[test]
fn a_changed_checkpoint_or_state_of_an_ensemble_is_refused() {
    let small = "members = 3\ninitial = { ball = 0.2 }\nfinal-states = \"csv\"\n\
                 record = { observables = [\"x1\"] }";
    let document = scene(METHODS[0], small);
    let ensemble = composed(&document);
    let root = tempfile::tempdir().expect("a directory");
    let path = root.path();
    let run = || {
        let (options, one) = (options(path), workforce(1, 8));
        run_ensemble(&document, &ensemble, &options, one, &mut Quiet)
    };
    run().expect("an ensemble");
    for (file, step) in [("checkpoint.bin", 7), ("final_states.csv", 1)] {
        let good = fs::read(path.join(file)).expect(file);
        for at in (0..good.len()).step_by(step) {
            let mut flipped = good.clone();
            flipped[at] ^= 1;
            fs::write(path.join(file), &flipped).expect("writable");
            let error = run().expect_err("damage");
            let text = error.to_string();
            assert!(matches!(error, RunError::Damaged { .. }), "{text}");
            assert!(text.contains(file) && text.contains("--force"), "{text}");
        }
        fs::write(path.join(file), &good).expect("writable");
    }
    assert!(run().expect("as it was").is_repeated);
}

/// Every column of the last states has a heading of its own, and holds what it says.
#[test]
fn last_states_stand_beside_initial_ones_and_drifts() {
    let document = scene(
        METHODS[0],
        &ENSEMBLE.replace("\"x1*x2\"", "\"x1\", \"I2*x2\""),
    );
    let ensemble = composed(&document);
    let root = tempfile::tempdir().expect("a directory");
    attempt(&document, root.path(), workforce(2, 16), &mut Quiet).expect("an ensemble");
    let table = fs::read_to_string(root.path().join("final_states.csv")).expect("states");
    let mut lines = table.lines();
    assert_eq!(
        lines.next(),
        Some(
            "member,outcome,I2,I3,x1,x2,x3,energy,x1 (observable),I2*x2,x1_initial,x2_initial,\
             x3_initial,energy_drift,spin_drift"
        )
    );
    for (member, line) in (0..).zip(lines) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |at: usize| -> f64 { cells[at].parse().expect("a number") };
        assert_eq!((number(8), number(9)), (number(4), number(2) * number(5)));
        let (state, _) = ensemble.population.draw(member).expect("a state");
        assert_eq!([number(10), number(11), number(12)], state[..]);
        // The member by itself, at every step.
        let text = member_scene(&document, &ensemble, member).expect("a scene");
        let alone =
            SceneDocument::parse("member.toml", &text, &Registry::empty()).expect("a scene");
        let run = compose(&alone, &Registry::with_builtin()).expect("a run");
        let mut integrator = run.integrator();
        let mut invariants = run.invariants().expect("code");
        let (mut first, mut now, mut largest) = ([0.0; 2], [0.0; 2], [0.0_f64; 2]);
        invariants.evaluate(integrator.state(), &mut first);
        for _ in 0..run.plan.steps {
            integrator.step().expect("a step");
            invariants.evaluate(integrator.state(), &mut now);
            for at in 0..2 {
                largest[at] = largest[at].max((now[at] - first[at]).abs());
            }
        }
        assert_eq!([number(13), number(14)], largest, "member {member}");
    }
}

/// Points of a grid are not held in memory.
#[test]
fn a_grid_larger_than_memory_is_refused_by_its_number_and_read_by_place() {
    let grid = |more: &str| {
        let ranges =
            "{ I1 = { range = [1, 2, 100_000_000] }, I2 = { range = [1, 3, 100_000_001] } }";
        let document = scene(METHODS[0], &format!("parameters = {ranges}\n{more}"));
        compose_ensemble(&document, &Registry::with_builtin(), Path::new(""))
    };
    let refusal = grid("").err().expect("too many");
    assert!(
        refusal
            .message
            .contains("10000000100000000 members, at most"),
        "{}",
        refusal.message
    );
    let refusal = grid("members = 7").err().expect("not the grid");
    assert!(
        refusal.message.contains("do not fill the grid"),
        "{}",
        refusal.message
    );
    let document = scene(
        METHODS[0],
        "parameters = { I1 = { range = [1, 2, 100_000_001] } }",
    );
    let registry = Registry::with_builtin();
    let ensemble = compose_ensemble(&document, &registry, Path::new("")).expect("an ensemble");
    let drawn = |member| ensemble.population.draw(member).expect("a state").1[0];
    assert_eq!(
        [drawn(0), drawn(50_000_000), drawn(100_000_000)],
        [1.0, 1.5, 2.0]
    );
}

#[test]
fn a_member_that_fails_is_named_and_disturbs_no_other() {
    // ln(x3) has no value where x3 < 0: some members start there, others come there in five steps.
    let text = BODY
        .replace("METHOD", METHODS[1])
        .replace("x3^2/(2*I3)\"", "x3^2/(2*I3) + 0.001*ln(x3)\"")
        .replace("[1, 3, 3]", "[1, 2, 0.1]")
        .replace("steps   = 43", "steps   = 5")
        .replace(
            "ENSEMBLE",
            "members = 40\ninitial = { box = [0.1, 0.1, 1] }",
        );
    let document = SceneDocument::parse("body.toml", &text, &Registry::empty()).expect("a scene");
    let ensemble = composed(&document);
    let mut outside = Vec::new();
    for member in 0..40 {
        let (state, _) = ensemble.population.draw(member).expect("a state");
        if state[2] < 0.0 {
            outside.push(member);
        }
    }
    let root = tempfile::tempdir().expect("a directory");
    let report = attempt(&document, root.path(), workforce(2, 8), &mut Quiet);
    let all = report.expect("an ensemble").reductions;
    assert_eq!(all.members, 40);
    let named: Vec<u64> = all.failures.iter().map(|failure| failure.member).collect();
    assert!(
        outside.iter().all(|member| named.contains(member)),
        "{named:?}"
    );
    assert_eq!(all.failed as usize, named.len());
    assert!(all.failed as usize > outside.len() && all.done() > 0);
    for failure in &all.failures {
        let is_outside = outside.contains(&failure.member);
        assert!(
            !is_outside || failure.step == 1 && failure.time == 0.0,
            "{failure:?}"
        );
    }
    assert_eq!(all.summaries[0].count, all.done());
    let rows = fs::read_to_string(root.path().join("failures.csv")).expect("failures");
    assert_eq!(rows.lines().count(), named.len() + 1);
}

#[test]
fn members_are_where_their_distribution_has_them() {
    let norm = |v: &[f64]| libm::sqrt(v.iter().map(|v| v * v).sum());
    let states = |initial: &str| -> Vec<Vec<f64>> {
        let document = scene(METHODS[0], &format!("members = 400\ninitial = {initial}"));
        let population = composed(&document).population;
        let draw = |member| population.draw(member).expect("a state").0;
        (0..population.members()).map(draw).collect()
    };
    let center = [1.0, 3.0, 3.0];
    let away = |state: &[f64]| {
        let difference: Vec<f64> = state.iter().zip(center).map(|(x, c)| x - c).collect();
        norm(&difference)
    };
    let radii: Vec<f64> = states("{ ball = 0.5 }").iter().map(|s| away(s)).collect();
    assert!(radii.iter().all(|r| *r <= 0.5 + 1e-15));
    // (r/R)³ is uniform: its mean over 400 lies within five standard errors of ½.
    let mean = radii.iter().map(|r| 8.0 * r * r * r).sum::<f64>() / 400.0;
    assert!(
        (mean - 0.5).abs() < 5.0 / libm::sqrt(12.0 * 400.0),
        "{mean}"
    );
    for state in states("{ sphere = 2, center = [0, 0, 0] }") {
        assert!((norm(&state) - 2.0).abs() < 1e-15 * 4.0);
    }
    for state in states("{ leaf = 0.3 }") {
        assert!((norm(&state) - libm::sqrt(19.0)).abs() < 4.0 * f64::EPSILON * 4.4);
    }
    for state in states("{ box = [0.1, 0, 2] }") {
        assert!((state[0] - 1.0).abs() <= 0.1 && state[1] == 3.0 && (state[2] - 3.0).abs() <= 2.0);
    }
    assert_ne!(states("{ normal = 0.1 }")[0], states("{ normal = 0.1 }")[1]);
    assert_eq!(states("{ normal = 0.1 }")[7], states("{ normal = 0.1 }")[7]);
}

/// {x, y} = 1 on four coordinates has corank 2; one Casimir does not fix a leaf, z and w do, and neither
/// units nor a function of them change that.
#[test]
fn a_leaf_needs_as_many_casimirs_as_the_corank() {
    let registry = Registry::with_builtin();
    for (casimirs, independent) in [
        ("z = \"z\"", Some(1)),
        ("z = \"z\", square = \"z^2 + 1e30*z\"", Some(1)),
        ("z = \"z\", w = \"1e-30*w\"", None),
    ] {
        let text = format!(
            "[system]\nvariables = [\"x\", \"y\", \"z\", \"w\"]\nbracket = {{ \"x,y\" = \"1e20\" }}\n\
             hamiltonian = \"x^2 + y^2\"\ncasimirs = {{ {casimirs} }}\n[method]\nstepper = \"rk4\"\n\
             time-step = 1e-22\n[run]\ninitial = [1, 2, 3, 4]\nsteps = 1\n[ensemble]\nmembers = 3\n\
             initial = {{ leaf = 0.1 }}\n"
        );
        let document =
            SceneDocument::parse("scene.toml", &text, &Registry::empty()).expect("a scene");
        let composed = compose_ensemble(&document, &registry, Path::new(""));
        match (composed, independent) {
            (Ok(ensemble), None) => {
                let (state, _) = ensemble.population.draw(1).expect("a state");
                assert!((state[2] - 3.0).abs() < 1e-15 && (state[3] - 4.0).abs() < 1e-15);
            }
            (Err(refusal), Some(count)) => {
                let message = &refusal.message;
                let said = format!("{count} independent Casimirs");
                assert!(
                    message.contains("has 2 equations") && message.contains(&said),
                    "{message}"
                );
            }
            (composed, _) => panic!("{casimirs}: {}", composed.is_ok()),
        }
    }
}

#[test]
fn files_and_grids_set_the_number_of_members() {
    let root = tempfile::tempdir().expect("a directory");
    fs::write(root.path().join("states.csv"), "x1,x2,x3\n1,2,3\n4,5,6\n").expect("writable");
    let grid = "initial = { file = \"states.csv\" }\n\
                parameters = { I1 = { range = [1, 2, 3] }, I2 = { values = [0.5, 0.75] } }";
    let document = scene(METHODS[0], grid);
    let ensemble = compose_ensemble(&document, &Registry::with_builtin(), root.path());
    let population = ensemble.expect("an ensemble").population;
    assert_eq!(population.members(), 12);
    let drawn: Vec<_> = (0..12)
        .map(|k| population.draw(k).expect("a state"))
        .collect();
    assert_eq!(drawn[1], (vec![1.0, 2.0, 3.0], vec![1.0, 0.75, 1.25]));
    assert_eq!(drawn[8], (vec![4.0, 5.0, 6.0], vec![1.5, 0.5, 1.25]));
    for (ensemble, said) in [
        ("initial = { ball = 1 }", "[ensemble] needs `members`"),
        (
            "members = 13\ninitial = { file = \"states.csv\" }",
            "13 members, and the file has states for 2",
        ),
        (
            "members = 5\nparameters = { I1 = { values = [1, 2] } }",
            "5 members do not fill the grid of 2",
        ),
        (
            "members = 5\ninitial = { file = \"absent.csv\" }",
            "cannot read",
        ),
        (
            "members = 5\nrecord = { observables = [\"enrgy\"] }",
            "unknown observable `enrgy`",
        ),
    ] {
        let document = scene(METHODS[0], ensemble);
        let refusal = compose_ensemble(&document, &Registry::with_builtin(), root.path());
        let message = refusal.err().expect(ensemble).message;
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn an_invalid_table_is_refused_where_it_stands() {
    for (ensemble, said, place) in [
        ("member = 5", "unknown key `member` in [ensemble]", "member"),
        (
            "members = 0",
            "`members` must be a whole number of at least 1, found 0",
            "0",
        ),
        (
            "members = 5\ninitial = 3",
            "`initial` must be a table such as { ball = 0.1 }, found 3",
            "3",
        ),
        (
            "members = 5\ninitial = { bal = 1 }",
            "unknown key `bal` in initial",
            "bal",
        ),
        (
            "members = 5\ninitial = { ball = 1, box = 1 }",
            "`box` cannot stand beside `ball`",
            "box",
        ),
        (
            "members = 5\ninitial = { ball = -1 }",
            "`ball` must be a positive number, found -1",
            "-1",
        ),
        (
            "members = 5\ninitial = { box = [1, 2] }",
            "box has 2 entries, expected 3, one for each variable",
            "[1, 2]",
        ),
        (
            "members = 5\nparameters = { J = { uniform = [0, 1] } }",
            "unknown parameter of this system `J`",
            "J",
        ),
        (
            "members = 5\nparameters = { I1 = { uniform = [1, 0] } }",
            "uniform has [1.0, 0.0], expected [from, to], the smaller first",
            "[1, 0]",
        ),
        (
            "members = 5\nrecord = { quantiles = [2] }",
            "`quantiles[0]` must be between 0 and 1, found 2",
            "2",
        ),
        (
            "members = 5\nfinal-states = \"cvs\"",
            "unknown form of final states `cvs`",
            "\"cvs\"",
        ),
    ] {
        let text = BODY
            .replace("METHOD", METHODS[0])
            .replace("ENSEMBLE", ensemble);
        let errors =
            SceneDocument::parse("body.toml", &text, &Registry::empty()).expect_err(ensemble);
        let problem = &errors.problems[0];
        assert_eq!(problem.cause.to_string(), said);
        assert_eq!(&text[problem.place.span.clone()], place, "{ensemble}");
    }
}

#[test]
fn a_scene_without_the_table_is_told_so() {
    let text = BODY.replace("METHOD", METHODS[0]);
    let text = text.split("[ensemble]").next().expect("a scene");
    let document = SceneDocument::parse("body.toml", text, &Registry::empty()).expect("a scene");
    let refusal = compose_ensemble(&document, &Registry::with_builtin(), Path::new(""));
    let message = refusal.err().expect("refused").message;
    assert_eq!(message, "the scene has no [ensemble] table");
}

//! Results depend neither on lanes nor on threads nor on interruptions; a member alone is the member.

use std::fs;

use super::*;
use crate::{Kind, Manifest, Quiet, RunJob, RunOutcome, Status};
use leafwise_scene::compose::compose;

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
            let mut walk = run.walk();
            for _ in 0..run.plan.steps {
                walk.step().expect("a step");
            }
            let parameters = run.system.parameter_values();
            let own = parameters[1..].iter().chain(walk.state());
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
    assert_eq!(ensemble.clock.samples, [0.0, 10.0, 20.0, 30.0, 40.0, 43.0]);
    // x1 x2 at t = 2, and the energy's drift, member by member.
    let (mut values, mut drifts) = (Vec::new(), Vec::new());
    for member in 0..60 {
        let text = member_scene(&document, &ensemble, member).expect("a scene");
        let alone =
            SceneDocument::parse("member.toml", &text, &Registry::empty()).expect("a scene");
        let run = compose(&alone, &Registry::with_builtin()).expect("a run");
        let mut invariants = run.invariants().expect("code");
        let mut walk = run.walk();
        let mut energy = |state: &[f64]| {
            let mut values = [0.0; 2];
            invariants.evaluate(state, &mut values);
            values[0]
        };
        let (initial, mut drift) = (energy(walk.state()), 0.0_f64);
        for step in 1..=43 {
            walk.step().expect("a step");
            drift = drift.max((energy(walk.state()) - initial).abs());
            if step == 20 {
                values.push(walk.state()[0] * walk.state()[1]);
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
    let quantiles = summary.quantiles(&[0.25, 0.5]);
    let exact = [sorted[14], sorted[29]].map(|value| Quantile {
        value,
        rank_error: 0.0,
    });
    assert_eq!(quantiles, exact);
    assert_eq!(
        (summary.minimum.0, summary.maximum.0),
        (sorted[0], sorted[59])
    );
    assert_eq!(values[summary.maximum.1 as usize], sorted[59]);
    let largest = drifts.iter().copied().fold(0.0, f64::max);
    assert_eq!(all.whole[0].maximum, largest);
    assert_eq!(drifts[all.whole[0].member as usize], largest);
    let total: f64 = drifts.iter().sum();
    assert!((all.whole[0].mean() - total / 60.0).abs() <= 1e-14 * total);
}

/// Interrupts after a few looks.
pub(super) struct StopAfter(pub u32);

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
    // Its end is reported again, and nothing is written.
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
        let job = EnsembleJob::new(&document, &ensemble, Portion::default(), &options, one)?;
        perform(&job, &mut Quiet)
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

#[test]
fn tables_and_the_page_of_a_finished_ensemble_are_made_anew_or_refused() {
    let small = "members = 40\ninitial = { ball = 0.2 }\nrecord = { observables = [\"x1\"], quantiles = [0.5] }\n\
                 parameters = { I2 = { values = [0.75, 0.0] } }";
    let text = BODY
        .replace("METHOD", METHODS[0])
        .replace("ENSEMBLE", small)
        .replace("steps   = 43", "steps   = 43\nstop    = \"x1 > 1.15\"");
    let document = SceneDocument::parse("body.toml", &text, &Registry::empty()).expect("a scene");
    let ensemble = composed(&document);
    let root = tempfile::tempdir().expect("a directory");
    let path = root.path();
    let run = || {
        let (options, one) = (options(path), workforce(1, 8));
        let job = EnsembleJob::new(&document, &ensemble, Portion::default(), &options, one)?;
        perform(&job, &mut Quiet)
    };
    let report = run().expect("an ensemble");
    assert!(report.reductions.failed > 0 && report.reductions.stopped > 0);
    let files = [
        "statistics.csv",
        "windows.csv",
        "losses.csv",
        "failures.csv",
        "report.html",
    ];
    crate::tests::check_end_files(path, &files, || {
        assert!(run()?.is_repeated);
        Ok(())
    });
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
        let mut walk = run.walk();
        let mut invariants = run.invariants().expect("code");
        let (mut first, mut now, mut largest) = ([0.0; 2], [0.0; 2], [0.0_f64; 2]);
        invariants.evaluate(walk.state(), &mut first);
        for _ in 0..run.plan.steps {
            walk.step().expect("a step");
            invariants.evaluate(walk.state(), &mut now);
            for at in 0..2 {
                largest[at] = largest[at].max((now[at] - first[at]).abs());
            }
        }
        assert_eq!([number(13), number(14)], largest, "member {member}");
    }
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

/// A name of several lines is one cell of every table, in each row that has it.
#[test]
fn names_of_several_lines_are_one_cell() {
    let text = BODY
        .replace("METHOD", METHODS[0])
        .replace("ENSEMBLE", ENSEMBLE)
        .replace("spin =", "\"sp\\nin\" =")
        .replace("\"x1*x2\"", "\"x1\\n*x2\", \"sp\\nin\"");
    let document = SceneDocument::parse("body.toml", &text, &Registry::empty()).expect("a scene");
    let root = tempfile::tempdir().expect("a directory");
    let report = attempt(&document, root.path(), workforce(1, 16), &mut Quiet);
    report.expect("an ensemble");
    let read = |file: &str| fs::read_to_string(root.path().join(file)).expect(file);
    for (file, cells) in [
        (
            "statistics.csv",
            &["energy", "\"x1\n*x2\"", "\"sp\nin\""][..],
        ),
        (
            "windows.csv",
            &["\"sp\nin\"", "\"sp\nin_mean\"", "\"sp\nin_member\""],
        ),
        ("final_states.csv", &["\"x1\n*x2\"", "\"sp\nin\""]),
    ] {
        let table = read(file);
        // Line ends within quotes belong to a cell.
        let mut is_quoted = false;
        let mut rows = vec![vec![String::new()]];
        for c in table.trim_end().chars() {
            is_quoted ^= c == '"';
            match c {
                '\n' if !is_quoted => rows.push(vec![String::new()]),
                ',' if !is_quoted => rows.last_mut().expect("a row").push(String::new()),
                c => rows
                    .last_mut()
                    .and_then(|row| row.last_mut())
                    .expect("a cell")
                    .push(c),
            }
        }
        for row in &rows {
            assert_eq!(row.len(), rows[0].len(), "{file}: {row:?}");
        }
        for cell in cells {
            let holds = rows.iter().flatten().any(|own| own == cell);
            assert!(holds, "{file} has no {cell:?}: {:?}", rows[0]);
        }
    }
}

/// All that a job leaves is in its list: what another job of the same directory replaces by force.
#[test]
fn force_removes_every_file_of_a_job_of_another_kind() {
    let small = "members = 5\ninitial = { ball = 0.2 }\nfinal-states = \"npy\"\n\
                 parameters = { I2 = { values = [0.75, 0.0, 0.8, 0.85, 0.9] } }";
    let text = BODY
        .replace("METHOD", METHODS[0])
        .replace("ENSEMBLE", small)
        .replace(
            "steps   = 43",
            "steps   = 43\nstop    = \"x1 > 9\"\nsection = { at = \"x1 = 1.02\", direction = \"both\" }\n\
             record  = { states = [] }",
        );
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("body.toml", &text, &registry).expect("a scene");
    let ensemble = composed(&document);
    let alone = compose(&document, &registry).expect("a run");
    let root = tempfile::tempdir().expect("a directory");
    let options = |name: &str| RunOptions {
        force: true,
        ..options(&root.path().join(name))
    };
    let one = |name: &str| {
        let options = options(name);
        let job = RunJob::new(&document, &alone, &registry, &options).expect("a job");
        perform(&job, &mut Quiet).expect("a run");
    };
    let many = |name: &str| {
        let (options, all) = (options(name), Portion::default());
        let job = EnsembleJob::new(&document, &ensemble, all, &options, workforce(1, 8));
        let report = perform(&job.expect("a job"), &mut Quiet).expect("an ensemble");
        assert!(report.reductions.failed > 0);
    };
    let left = |name: &str| {
        let entries = fs::read_dir(root.path().join(name)).expect("a directory");
        let names = entries.map(|entry| entry.expect("an entry").file_name());
        names.collect::<std::collections::BTreeSet<_>>()
    };
    one("run");
    many("ensemble");
    one("both");
    assert_eq!(left("both"), left("run"));
    many("both");
    assert_eq!(left("both"), left("ensemble"));
    one("both");
    assert_eq!(left("both"), left("run"));
    assert!(left("run").iter().any(|name| name == "final_state.bin"));
    assert!(left("ensemble").iter().any(|name| name == "failures.csv"));
}

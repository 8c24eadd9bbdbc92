//! The columns of the files.

use std::fs;
use std::path::Path;

use super::{SCENE, StopAfter, attempt, short_scene};
use crate::advice::AdviceKind;
use crate::{Quiet, RunOutcome};

/// The cells of a line of CSV.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut is_quoted) = (vec![String::new()], false);
    for letter in line.chars() {
        match letter {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(String::new()),
            _ => cells.last_mut().expect("a cell").push(letter),
        }
    }
    cells
}

#[test]
fn names_of_several_lines_are_one_heading_and_the_run_ends() {
    let root = tempfile::tempdir().expect("a directory");
    let (whole, path) = (root.path().join("whole"), root.path().join("run"));
    let scene = SCENE
        .replace("spin =", "\"sp\\nin\" =")
        .replace("\"x1*x2\"", "\"x1\\n*x2\", \"sp\\nin\"");
    attempt(&scene, &whole, false, &mut Quiet).expect("a run");
    while attempt(&scene, &path, false, &mut StopAfter(5))
        .expect("a session")
        .outcome
        == RunOutcome::Interrupted
    {}
    for file in ["samples.csv", "windows.csv"] {
        let read = |directory: &Path| fs::read_to_string(directory.join(file)).expect(file);
        assert!(read(&whole) == read(&path), "{file} differs");
    }
    let samples = fs::read_to_string(path.join("samples.csv")).expect("samples");
    let header = "t,x1,x2,x3,energy,\"x1\n*x2\",\"sp\nin\"\n";
    assert!(samples.starts_with(header), "{}", &samples[..100]);
    for row in samples[header.len()..].lines() {
        assert_eq!(row.split(',').count(), 7, "{row}");
    }
    let windows = fs::read_to_string(path.join("windows.csv")).expect("windows");
    assert!(
        windows.starts_with("t_end,energy,\"sp\nin\"\n"),
        "{}",
        &windows[..60]
    );
}

#[test]
fn every_column_has_a_heading_of_its_own_and_none_begins_like_a_formula() {
    let root = tempfile::tempdir().expect("a directory");
    let scene = short_scene()
        .replace("{ spin =", "{ \"=x1\" = \"2*(x1^2 + x2^2 + x3^2)\", x2 =")
        .replace(
            "\"energy\", \"x1*x2\"",
            "\"energy\", \"x1\", \"x2\", \"=x1\", \"-x3\"",
        );
    attempt(&scene, root.path(), false, &mut Quiet).expect("a run");
    let samples = fs::read_to_string(root.path().join("samples.csv")).expect("samples");
    let header = samples.lines().next().expect("a line");
    assert_eq!(
        header,
        "t,x1,x2,x3,energy,x1 (observable),x2 (Casimir),\"=x1\",\"-x3\""
    );
    assert_eq!(cells(header).len(), 9);
    let row: Vec<f64> = cells(samples.lines().last().expect("a row"))
        .iter()
        .map(|cell| cell.parse().expect("a number"))
        .collect();
    assert_eq!((row[5], row[8]), (row[1], -row[3]));
    assert_eq!(row[7], 2.0 * row[6]);
}

#[test]
fn an_observable_without_a_value_is_warned_of() {
    let root = tempfile::tempdir().expect("a directory");
    // x3 is −0.5 first.
    let scene = SCENE.replace("\"x1*x2\"", "\"ln(x3)\", \"x1*x2\"");
    let mut sessions = 0;
    let report = loop {
        let report = attempt(&scene, root.path(), false, &mut StopAfter(5)).expect("a session");
        sessions += 1;
        if report.outcome == RunOutcome::Done {
            break report;
        }
    };
    assert!(sessions > 1);
    let samples = fs::read_to_string(root.path().join("samples.csv")).expect("samples");
    let rows = samples.lines().skip(1);
    let undefined = rows
        .filter(|row| row.split(',').nth(5) == Some("NaN"))
        .count();
    assert!(undefined > 0);
    let of_kind = |advice: &&crate::advice::Advice| advice.kind == AdviceKind::UndefinedObservable;
    let advice: Vec<_> = report.advice.iter().filter(of_kind).collect();
    assert_eq!(advice.len(), 1, "{advice:?}");
    let said = format!(
        "`ln(x3)` has no finite value at {undefined} of {} samples",
        report.samples
    );
    assert!(
        advice[0].message.starts_with(&said),
        "{}\n{said}",
        advice[0].message
    );
}

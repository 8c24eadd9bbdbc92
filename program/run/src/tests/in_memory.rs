//! Runs in memory.

use leafwise_report::render_report;

use super::{Prepared, SCENE, StopAfter};
use crate::csv::numbers;
use crate::{Asked, Recorded, RunError, RunOutcome, run_in_memory};

/// An oscillator in paced steps, with a section and states between steps; q never becomes 2.
const PACED: &str = r#"
[system]
variables   = ["q", "p"]
bracket     = { "q,p" = "-1" }
hamiltonian = "p^2/2 + q^2/2"
[method]
realization = "auto"
dynamics    = { name = "hamilton-jacobi", order = 4 }
time-step   = 0.1
pace        = "1/(1 + q^2)"
[run]
initial = [1, 0]
until   = 40.0
stop    = "q > 2"
section = { at = "q = 0", direction = "up" }
record  = { interval = 0.75, observables = ["energy", "q*p", "ln(q)"] }
"#;

/// A ring whose states are too wide for `samples.csv`.
const WIDE: &str = r#"
[system]
families    = { x = 80 }
boundary    = "periodic"
bracket     = { "x[i],x[i+1]" = "-x[i]*x[i+1]" }
hamiltonian = "sum(i, x[i])"
[method]
stepper   = "splitting"
time-step = 0.05
[run]
initial = { "x[i]" = "1 + 0.1*sin(2*pi*i/N)" }
steps   = 40
record  = { every = 5, states = "all", observables = ["energy"] }
"#;

fn recorded(text: &str, looks: u32) -> Result<Recorded, RunError> {
    let Prepared {
        document,
        registry,
        composed,
    } = Prepared::new(text);
    let mut progress = StopAfter(looks);
    run_in_memory(
        &document,
        &composed,
        &registry,
        Asked::default(),
        &mut progress,
    )
}

/// The rows of a file in a run directory.
fn rows(directory: &std::path::Path, file: &str) -> (Vec<String>, Vec<f64>) {
    let text = std::fs::read_to_string(directory.join(file)).expect("a file");
    let mut lines = text.lines();
    let names = lines.next().expect("headings").split(',');
    let names = names.map(|name| name.trim_matches('"').to_owned());
    (names.collect(), lines.flat_map(numbers).collect())
}

/// All values that are not numbers alike: a file knows no sign of them.
fn bits(values: &[f64]) -> Vec<u64> {
    let bits = |value: &f64| if value.is_nan() { f64::NAN } else { *value }.to_bits();
    values.iter().map(bits).collect()
}

#[test]
fn memory_holds_what_a_directory_would() {
    for text in [SCENE, PACED] {
        let parent = tempfile::tempdir().expect("a directory");
        let directory = parent.path().join("run");
        let written = Prepared::new(text).attempt(&directory, false, &mut StopAfter(u32::MAX));
        let written = written.expect("a run");
        let kept = recorded(text, u32::MAX).expect("a run");
        let (names, samples) = rows(&directory, "samples.csv");
        assert_eq!(kept.columns, names);
        assert_eq!(bits(&kept.samples), bits(&samples));
        assert_eq!(
            kept.samples.len() as u64,
            kept.report.samples * names.len() as u64
        );
        let (names, windows) = rows(&directory, "windows.csv");
        assert_eq!(
            (kept.windows_columns, bits(&kept.windows)),
            (names, bits(&windows))
        );
        if let Some(crossings) = &kept.crossings {
            assert_eq!(bits(crossings), bits(&rows(&directory, "section.csv").1));
            assert!(written.crossings.is_some_and(|count| count > 5));
        }
        let report = kept.report;
        assert_eq!(report.outcome, RunOutcome::Done);
        assert_eq!(report.final_state, written.final_state);
        assert_eq!((report.steps, report.time), (written.steps, written.time));
        assert_eq!(report.invariants, written.invariants);
        let said = |report: &crate::RunReport| -> Vec<String> {
            report.advice.iter().map(|a| a.message.clone()).collect()
        };
        assert_eq!(said(&report), said(&written));
        assert!(render_report(&kept.page).expect("a page").contains("<svg"));
    }
}

#[test]
fn wide_states_are_columns_of_the_samples() {
    let kept = recorded(WIDE, u32::MAX).expect("a run");
    assert_eq!(kept.columns.len(), 82);
    assert_eq!(kept.samples.len(), 9 * 82);
    assert_eq!(
        kept.samples[8 * 82 + 1..9 * 82 - 1],
        kept.report.final_state
    );
}

#[test]
fn what_was_recorded_before_an_interruption_or_a_failure_is_kept() {
    let kept = recorded(SCENE, 1).expect("a run");
    assert_eq!(kept.report.outcome, RunOutcome::Interrupted);
    let steps = kept.report.steps;
    assert!(steps > 0 && steps < 20_000);
    assert_eq!(kept.report.samples, steps / 7 + 1);
    let far = SCENE.replace("time-step   = 0.1", "time-step   = 1000");
    let failed = recorded(&far, u32::MAX).expect("a run");
    assert!(matches!(failed.report.outcome, RunOutcome::Failed(_)));
    assert_eq!(failed.samples.len(), failed.columns.len());
}

#[test]
fn a_tensor_that_is_not_poisson_is_refused() {
    let text = SCENE.replace("\"x1,x2\" = \"-x3\"", "\"x1,x2\" = \"-x3 - x1^2\"");
    let error = recorded(
        &text.replace("casimirs    = { spin = \"x1^2 + x2^2 + x3^2\" }", ""),
        1,
    );
    assert!(matches!(error, Err(RunError::Refused(_))), "{error:?}");
}

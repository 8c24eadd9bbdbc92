//! Runs in a directory of their own, and the tables that they leave there.

use std::collections::BTreeMap;

use leafwise::core::Registry;
use leafwise::run::{Quiet, RunJob, RunOptions, RunReport, perform};
use leafwise::scene::compose;
use leafwise_tests::scenes::document;

/// A table of numbers by the names of its columns.
pub(crate) type Table = BTreeMap<String, Vec<f64>>;

/// Runs a scene with the values of these keys changed: the report, and a reader of the tables.
pub(crate) fn ran(
    text: &str,
    overrides: &[(&str, &str)],
) -> (RunReport, impl Fn(&str) -> Table + use<>) {
    let registry = Registry::with_builtin();
    let document = document(text, overrides);
    let run = compose(&document, &registry).unwrap_or_else(|refusal| panic!("{refusal}\n{text}"));
    let root = tempfile::tempdir().expect("a directory");
    let options = RunOptions::within(root.path().join("run"));
    let job = RunJob::new(&document, &run, &registry, &options);
    let report = job
        .and_then(|job| perform(&job, &mut Quiet))
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    let table = move |name: &str| {
        let text = std::fs::read_to_string(root.path().join("run").join(name)).expect("a table");
        columns(&text)
    };
    (report, table)
}

fn columns(text: &str) -> Table {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a head").split(',').collect();
    let mut columns = vec![Vec::new(); names.len()];
    for line in lines {
        for (column, entry) in columns.iter_mut().zip(line.split(',')) {
            column.push(entry.parse().expect("a number"));
        }
    }
    let names = names.into_iter().map(str::to_owned);
    names.zip(columns).collect()
}

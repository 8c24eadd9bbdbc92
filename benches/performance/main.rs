//! Everything that `docs/performance.md` reports, each ratio from one run.
//!
//! `cargo bench -p leafwise-benches --bench performance` measures all and writes the tables into the
//! page; `-- accuracy` and the other names of [`SECTIONS`] one of them. `-- formulas` writes the formulas by hand that
//! `steps` compares with: once, and after a change of what kernels hold.

#![allow(clippy::print_stdout)]

mod accuracy;
mod building;
mod contestants;
mod document;
mod hand;
mod lattices;
mod long;
mod measure;
mod problems;
mod products;
mod source;
mod steps;
mod walks;

use std::path::Path;

use leafwise::expression::Execution;

use crate::problems::{LotkaVolterra, RigidBody};

/// A part of the page: its name, and what measures it.
type Section = (&'static str, fn() -> String);

const SECTIONS: [Section; 11] = [
    ("steps", steps::table),
    ("walks", walks::table),
    ("products", products::table),
    ("rigid-body", || {
        accuracy::tables::<RigidBody>(&[(1e-4, &[4, 6, 8, 10]), (1e-8, &[6, 8, 10, 12])])
    }),
    ("lotka-volterra", || {
        accuracy::tables::<LotkaVolterra>(&[(1e-4, &[4, 6, 8]), (1e-8, &[4, 6, 8, 10])])
    }),
    ("adaptive", || {
        let tables = [
            accuracy::adaptive::<RigidBody>(),
            accuracy::adaptive::<LotkaVolterra>(),
        ];
        tables.join("\n")
    }),
    ("lifts", || {
        let tables = [
            accuracy::lifts::<RigidBody>(),
            accuracy::lifts::<LotkaVolterra>(),
        ];
        tables.join("\n")
    }),
    ("lattice", lattices::accuracy),
    ("lattice-sizes", lattices::sizes),
    ("long", long::tables),
    ("building", building::table),
];

fn main() {
    Execution::Compiled.set_default_of_process();
    let asked: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with("--"))
        .collect();
    if let [name, sites] = asked.as_slice()
        && name == lattices::SIZE_ARGUMENT
    {
        let numbers = lattices::measure_size(sites.parse().expect("a number of sites"));
        println!("{}", numbers.map(|number| number.to_string()).join(" "));
        return;
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    if asked == ["formulas"] {
        source::write_all(&here.join("performance/formulas"));
        println!("written; the next run of this bench compiles them");
        return;
    }
    let page = here.join("../docs/performance.md");
    for (name, measure) in SECTIONS {
        if asked.is_empty() || asked.iter().any(|a| a == name) {
            if name == "steps" && !cfg!(has_formulas) {
                println!(
                    "steps: no formulas by hand to compare with: run `-- formulas` once, then this again"
                );
                continue;
            }
            let text = measure();
            println!("{text}");
            document::write_section(&page, name, &text);
        }
    }
}

//! Tells whether the formulas by hand are written: `cargo bench -p leafwise-benches --bench performance -- formulas`.

use std::path::Path;

/// Where they are written; nothing of it is in the repository.
const FOLDER: &str = "performance/formulas";

fn main() {
    println!("cargo::rerun-if-changed={FOLDER}");
    println!("cargo::rustc-check-cfg=cfg(has_formulas)");
    if Path::new(FOLDER).join("HeavyTop8.rs").exists() {
        println!("cargo::rustc-cfg=has_formulas");
    }
}

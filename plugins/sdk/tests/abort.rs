//! A plugin that would end its host instead of telling it of a panic is not built at all.

use std::fs;
use std::path::Path;
use std::process::Command;

/// The template, built in a folder of its own with these settings of its release profile.
fn build(settings: &[&str]) -> (bool, String) {
    let kit = Path::new(env!("CARGO_MANIFEST_DIR"));
    let template = kit
        .parent()
        .expect("the folder of plugins")
        .join("template");
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::create_dir(folder.path().join("src")).expect("a writable folder");
    let source = template.join("src/lib.rs");
    fs::copy(source, folder.path().join("src/lib.rs")).expect("the template");
    let manifest = fs::read_to_string(template.join("Cargo.toml")).expect("the template");
    let path = format!("path = {:?}", kit.display().to_string());
    assert!(manifest.contains("path = \"../sdk\""), "{manifest}");
    let manifest = manifest.replace("path = \"../sdk\"", &path);
    fs::write(folder.path().join("Cargo.toml"), manifest).expect("a writable folder");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--release", "--offline", "--target-dir", "target"]);
    for setting in settings {
        cargo.args(["--config", setting]);
    }
    let output = cargo.current_dir(folder.path()).output();
    let output = output.expect("cargo runs");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.success(), said)
}

#[test]
fn panics_that_abort_refuse_to_compile() {
    let (is_built, said) = build(&["profile.release.panic = \"abort\""]);
    assert!(!is_built, "{said}");
    let text =
        "a Leafwise plugin needs panic = \"unwind\": with \"abort\" a panic would end the host";
    assert!(said.contains(text), "{said}");
    // Nothing else is wrong with it.
    let (is_built, said) = build(&["profile.release.panic = \"unwind\""]);
    assert!(is_built, "{said}");
}

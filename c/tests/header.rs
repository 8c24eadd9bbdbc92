//! The committed header is the one that this crate generates, and compiles as C and C++.

mod support;

use std::process::Command;

#[test]
fn the_committed_header_is_the_generated_one() {
    let committed = std::fs::read_to_string(support::committed()).expect("the header is committed");
    assert_eq!(
        committed,
        support::generate(),
        "include/leafwise.h is out of date; run `cargo run -p leafwise-c --example header`"
    );
}

#[test]
#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn the_header_is_c11_and_cpp17() {
    for (compiler, language) in [
        ("cc", ["-std=c11", "-xc"]),
        ("c++", ["-std=c++17", "-xc++"]),
    ] {
        if Command::new(compiler).arg("--version").output().is_err() {
            eprintln!("skipped: there is no `{compiler}` here");
            continue;
        }
        let output = Command::new(compiler)
            .args(language)
            .args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"])
            .arg(support::committed())
            .output()
            .expect("the compiler runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{compiler}: {said}");
    }
}

//! Programs in C and Fortran call the library: its bits are the program's, and misuse ends in codes.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use leafwise::core::Registry;
use leafwise::core::gradient::{Plan, Trajectory};
use leafwise::scene::{SceneDocument, compose};

/// This crate's folder.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The folder of the library that was built for these tests.
fn library_folder() -> PathBuf {
    let own = std::env::current_exe().expect("a program has a file");
    own.parent().expect("a file has a folder").to_owned()
}

#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn has(compiler: &str) -> bool {
    let is_there = Command::new(compiler).arg("--version").output().is_ok();
    if !is_there {
        eprintln!("skipped: there is no `{compiler}` here");
    }
    is_there
}

/// Compiles a program against the library, and runs it.
fn run(compiler: &str, source: &Path, more: &[&str]) -> Output {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let program = folder.path().join("program");
    let built = Command::new(compiler)
        .args(more)
        .arg("-I")
        .arg(root().join("include"))
        .arg(source)
        .arg("-L")
        .arg(library_folder())
        .args(["-lleafwise_c", "-lpthread", "-o"])
        .arg(&program)
        .output()
        .expect("the compiler runs");
    let said = String::from_utf8_lossy(&built.stderr);
    assert!(built.status.success(), "{compiler}: {said}");
    Command::new(&program)
        .env("LD_LIBRARY_PATH", library_folder())
        .output()
        .expect("the program starts")
}

/// Flags of C with sanitizers, where they are installed.
fn checked() -> Vec<&'static str> {
    let strict = [
        "-std=c11",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Werror",
        "-g",
    ];
    let sanitizers = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let empty = folder.path().join("empty.c");
    std::fs::write(&empty, "int main(void) { return 0; }\n").expect("a writable folder");
    let tried = Command::new("cc")
        .args(sanitizers)
        .arg(&empty)
        .arg("-o")
        .arg(folder.path().join("empty"))
        .output();
    match tried {
        Ok(tried) if tried.status.success() => [&strict[..], &sanitizers].concat(),
        _ => strict.to_vec(),
    }
}

fn numbers(line: &str) -> Vec<f64> {
    let words = line.split_whitespace();
    words.map(|word| word.parse().expect("a number")).collect()
}

#[test]
fn the_example_prints_the_bits_of_the_program() {
    if !has("cc") {
        return;
    }
    let source = root().join("examples/rigid_body.c");
    let output = run("cc", &source, &checked());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    let rows: Vec<Vec<f64>> = printed.lines().map(numbers).collect();
    assert_eq!(rows.len(), 6, "{printed}");

    // The scene of the example, taken from its source.
    let text = std::fs::read_to_string(&source).expect("the example is there");
    let scene: String = text
        .lines()
        .filter_map(|line| line.trim().strip_prefix('"')?.split("\\n\"").next())
        .map(|line| format!("{line}\n"))
        .collect();
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("body", &scene, &registry).expect("a scene");
    let composed = compose(&document, &registry).expect("a method");
    let mut walk = composed.walk();
    let parameters = composed.system.parameter_values();
    let mut invariants = composed.invariants().expect("code");
    let mut values = [0.0; 2];
    for row in &rows[..5] {
        walk.advance(200).expect("a regular motion");
        invariants.evaluate(walk.state(), &mut values);
        let wanted = [walk.state(), &values].concat();
        assert_eq!(bits(row), bits(&wanted));
    }
    let trajectory = Trajectory {
        map: composed.method.map(),
        parameters: &parameters,
        epsilon: composed.plan.epsilon,
        h: composed.plan.h,
        goes_on: &|| true,
    };
    let plan = Plan {
        steps: 1000,
        every: 1000,
    };
    let initial = &composed.plan.initial;
    let reached = trajectory.run(initial, plan).expect("a regular motion");
    let cotangents = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    let gradient = trajectory.pull(initial, &reached, &cotangents, plan, (true, None));
    let gradient = gradient.expect("derivatives");
    assert_eq!(
        bits(&rows[5]),
        bits(&[gradient.initial, gradient.parameters].concat())
    );
}

#[test]
fn the_guide_shows_the_example() {
    let page = root().join("../docs/guide/from-c.md");
    let page = std::fs::read_to_string(page).expect("the page is there");
    let shown = page
        .split("```c\n")
        .nth(1)
        .and_then(|rest| rest.split("```").next());
    let source = root().join("examples/rigid_body.c");
    let source = std::fs::read_to_string(source).expect("the example is there");
    let program = source.split_once("*/\n").map(|(_, program)| program);
    assert_eq!(shown, program);
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn misuse_ends_in_codes() {
    if !has("cc") {
        return;
    }
    let source = root().join("tests/programs/misuse.c");
    let output = run("cc", &source, &checked());
    let (out, err) = (
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    );
    assert!(output.status.success(), "{:?}: {out}{err}", output.status);
}

/// Ten steps of 0.1 along the circle: (cos 1, −sin 1).
#[test]
fn fortran_calls_the_library() {
    if !has("gfortran") {
        return;
    }
    let source = root().join("examples/oscillator.f90");
    let output = run("gfortran", &source, &["-ffree-line-length-none"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let end = numbers(&String::from_utf8_lossy(&output.stdout));
    let exact = [0.540_302_305_868_139_8, -0.841_470_984_807_896_5];
    for (value, exact) in end.iter().zip(exact) {
        assert!((value - exact).abs() < 1e-14, "{value} {exact}");
    }
}

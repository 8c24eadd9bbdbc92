//! The committed header is the one this crate generates, and C sees the layout that Rust sees.

mod support;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use leafwise_plugin_abi::{
    LAYOUT, LW_ABI_MAJOR, LW_ABI_MINOR, LW_DISCARD, LW_ENTRY_SYMBOL, LW_ENTRY_SYMBOL_STEM,
    LW_ERROR, LW_FATAL, LW_FLAG_COTANGENT_CHART, LW_FLAG_EXACT, LW_FLAG_NOT_SELF_ADJOINT,
    LW_FLAG_REVERSIBLE, LW_FLAG_SELF_ADJOINT, LW_FLAG_SHAREABLE, LW_FLAG_SYMPLECTIC,
    LW_FLAG_UNCORRECTED, LW_FROZEN_BYTES, LW_KIND_DYNAMICS, LW_KIND_REALIZATION, LW_KIND_STEP_MAP,
    LW_KIND_SYSTEM, LW_MAGIC, LW_OK, LW_SETTING_INTEGER, LW_SETTING_REAL, LW_SETTING_TEXT,
    LW_STRUCTURE_EXACT, LW_STRUCTURE_NONE, LW_UNSUPPORTED,
};

#[test]
fn the_committed_header_is_the_generated_one() {
    let committed = std::fs::read_to_string(support::committed()).expect("the header is committed");
    assert_eq!(
        committed,
        support::generate(),
        "include/leafwise_plugin.h is out of date; run `cargo run -p leafwise-plugin-abi --example \
         header`"
    );
}

#[test]
fn the_entry_symbol_ends_in_the_major_version() {
    let name = LW_ENTRY_SYMBOL.to_str().expect("a name is UTF-8");
    assert_eq!(name, format!("{LW_ENTRY_SYMBOL_STEM}{LW_ABI_MAJOR}"));
}

#[test]
fn c11_sees_the_layout_of_rust() {
    compiles("cc", &["-std=c11", "-x", "c"], "_Static_assert");
}

#[test]
fn cpp17_sees_the_layout_of_rust() {
    compiles("c++", &["-std=c++17", "-x", "c++"], "static_assert");
}

/// Every constant of the header with its value here.
fn constants() -> Vec<(&'static str, i64)> {
    macro_rules! values {
        ($($name:ident),* $(,)?) => { vec![$((stringify!($name), $name as i64)),*] };
    }
    values![
        LW_ABI_MAJOR,
        LW_ABI_MINOR,
        LW_DISCARD,
        LW_ERROR,
        LW_FATAL,
        LW_FLAG_COTANGENT_CHART,
        LW_FLAG_EXACT,
        LW_FLAG_NOT_SELF_ADJOINT,
        LW_FLAG_REVERSIBLE,
        LW_FLAG_SELF_ADJOINT,
        LW_FLAG_SHAREABLE,
        LW_FLAG_SYMPLECTIC,
        LW_FLAG_UNCORRECTED,
        LW_FROZEN_BYTES,
        LW_KIND_DYNAMICS,
        LW_KIND_REALIZATION,
        LW_KIND_STEP_MAP,
        LW_KIND_SYSTEM,
        LW_OK,
        LW_SETTING_INTEGER,
        LW_SETTING_REAL,
        LW_SETTING_TEXT,
        LW_STRUCTURE_EXACT,
        LW_STRUCTURE_NONE,
        LW_UNSUPPORTED,
    ]
}

/// A program that compiles only where C's layout and constants are those of Rust.
fn program(check: &str) -> String {
    let mut text = "#include \"leafwise_plugin.h\"\n".repeat(2);
    let mut line = |condition: String| {
        writeln!(
            text,
            "{check}({condition}, \"{}\");",
            condition.replace('"', "'")
        )
        .expect("a string takes any text");
    };
    for layout in LAYOUT {
        line(format!("sizeof({}) == {}", layout.name, layout.size));
        for (field, offset) in layout.fields {
            line(format!("offsetof({}, {field}) == {offset}", layout.name));
        }
    }
    for (name, value) in constants() {
        line(format!("{name} == {value}"));
    }
    let symbol = LW_ENTRY_SYMBOL.to_str().expect("a name is UTF-8");
    line(format!("sizeof(LW_ENTRY_SYMBOL) == {}", symbol.len() + 1));
    text.push_str(PLUGIN);
    text
}

/// The frame of a plugin: the helpers, the entry and a map are used as an author would.
const PLUGIN: &str = r#"
static LwStatus twice(void *instance, const LwMapCall *call, LwError *err) {
    (void)instance;
    for (size_t i = 0; i < call->count; i++) {
        double x = lw_get(&call->point, i, 0);
        if (!(x < 1e300)) return lw_discard(err, (int64_t)i, 0, "too large");
        lw_put(&call->output, i, 0, 2 * x);
        if (!LW_HAS(call, output) || lw_got(&call->output, i, 0) < x)
            return lw_fail(err, LW_ERROR, (int64_t)i, "negative");
    }
    return LW_OK;
}
LwMapFn twice_as_map = twice;
LwEntryFn entry_as_type = leafwise_plugin_entry_v1;
const LwEntry *leafwise_plugin_entry_v1(void) {
    static const LwEntry entry = {LW_MAGIC, LW_ABI_MAJOR, 0, sizeof(LwEntry), sizeof(double), 0,
                                  NULL, "test", "0.0.0", NULL, NULL};
    return &entry;
}
"#;

#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn compiles(compiler: &str, language: &[&str], check: &str) {
    if Command::new(compiler).arg("--version").output().is_err() {
        eprintln!("skipped: there is no `{compiler}` here");
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let source = folder.path().join("layout.c");
    std::fs::write(&source, program(check)).expect("a writable temporary folder");
    let include = support::committed();
    let output = Command::new(compiler)
        .args(language)
        .args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"])
        .arg("-I")
        .arg(include.parent().unwrap_or(Path::new(".")))
        .arg(&source)
        .output()
        .expect("the compiler runs");
    assert!(
        output.status.success(),
        "{compiler}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn the_header_writes_the_magic_of_rust() {
    let letters: Vec<String> = LW_MAGIC
        .iter()
        .map(|byte| format!("'{}'", char::from(*byte)))
        .collect();
    let line = format!("#define LW_MAGIC {{{}}}\n", letters.join(", "));
    assert!(support::generate().contains(&line));
}

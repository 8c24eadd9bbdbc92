//! The C header, generated from the sources of this crate.

use std::path::{Path, PathBuf};

/// Where the header is committed.
pub fn committed() -> PathBuf {
    root().join("include/leafwise.h")
}

/// This crate's folder.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The header's text.
pub fn generate() -> String {
    let config = cbindgen::Config::from_file(root().join("cbindgen.toml"))
        .expect("cbindgen.toml is a configuration");
    let mut builder = cbindgen::Builder::new().with_config(config);
    for module in ["code", "handle", "scene", "calls"] {
        builder = builder.with_src(root().join(format!("src/{module}.rs")));
    }
    let mut text = Vec::new();
    builder
        .generate()
        .expect("the types have a C layout")
        .write(&mut text);
    let text = String::from_utf8(text).expect("a header is UTF-8");
    // Rust's headings are none in C.
    text.replace("// # Safety\n", "// Pointers:\n")
}

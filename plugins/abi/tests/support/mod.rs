//! The C header, generated from the sources of this crate.

use std::path::{Path, PathBuf};

use leafwise_plugin_abi::{LAYOUT, TypeLayout};

/// Where the header is committed.
pub fn committed() -> PathBuf {
    root().join("include/leafwise_plugin.h")
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The modules with types, in the order of the header.
const MODULES: [&str; 8] = [
    "status",
    "call",
    "instance",
    "dynamics",
    "step_map",
    "expression",
    "part",
    "entry",
];

/// The header's text.
pub fn generate() -> String {
    let config = cbindgen::Config::from_file(root().join("cbindgen.toml"))
        .expect("cbindgen.toml is a configuration");
    let mut builder = cbindgen::Builder::new().with_config(config);
    for module in MODULES {
        builder = builder.with_src(root().join(format!("src/{module}.rs")));
    }
    let mut text = Vec::new();
    builder
        .generate()
        .expect("the types have a C layout")
        .write(&mut text);
    let text = String::from_utf8(text).expect("a header is UTF-8");
    text.replace("LAYOUT\n", &layout())
}

/// An assertion for the size of each struct.
fn layout() -> String {
    let line = |layout: &TypeLayout| {
        let (name, size) = (layout.name, layout.size);
        format!("LW_STATIC_ASSERT(sizeof({name}) == {size}, \"{name} has {size} bytes\");\n")
    };
    LAYOUT.iter().map(line).collect()
}

//! An example plugin: a realization of so(3)* that the program does not have, and a system.
//!
//! Build it with `cargo build --release -p leafwise-example-plugin`; name the library that comes out
//! in a scene, `plugins = ["target/release/libleafwise_example_plugin.so"]`, and use
//! `realization = "example/so3-rodrigues"` or `library = "example/epidemic"`.

mod epidemic;
mod rodrigues;

pub use epidemic::Epidemic;
pub use rodrigues::Rodrigues;

leafwise_plugin_sdk::export_plugin! {
    id: "example", license: "MIT OR Apache-2.0",
    parts: [realization Rodrigues, system Epidemic]
}

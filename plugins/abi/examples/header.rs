//! Writes `include/leafwise_plugin.h`: `cargo run -p leafwise-plugin-abi --example header`.

#[path = "../tests/support/mod.rs"]
mod support;

fn main() -> std::io::Result<()> {
    std::fs::write(support::committed(), support::generate())
}

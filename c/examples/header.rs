//! Writes `include/leafwise.h`: `cargo run -p leafwise-c --example header`.

#[path = "../tests/support/mod.rs"]
mod support;

fn main() -> std::io::Result<()> {
    std::fs::write(support::committed(), support::generate())
}

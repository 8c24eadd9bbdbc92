//! leafwise
fn main() {}

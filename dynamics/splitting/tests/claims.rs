//! Claims about splittings, a module each.

mod common;
mod splits;
mod strang;

//! Claims about splittings, a module each.

mod common;
mod motions;
mod splits;
mod strang;

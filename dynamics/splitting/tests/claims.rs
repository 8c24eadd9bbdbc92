//! Claims about splittings, a module each.

mod arrangements;
mod common;
mod motions;
mod splits;
mod strang;

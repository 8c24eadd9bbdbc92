//! Claims about splittings, a module each.

mod arrangements;
mod bodies;
mod common;
mod kepler;
mod motions;
mod splits;
mod strang;
mod vortices;

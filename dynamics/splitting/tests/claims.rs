//! Claims about splittings, a module each.

mod arrangements;
mod bodies;
mod centres;
mod common;
mod kepler;
mod motions;
mod outer_solar_system;
mod splits;
mod strang;
mod vortices;

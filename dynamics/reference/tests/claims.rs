//! Claims about the baselines, a module each.

mod common;
mod many;
mod orders;
mod parts;
mod structure;
mod taylor;

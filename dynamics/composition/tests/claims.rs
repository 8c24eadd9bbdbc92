//! Claims about compositions, a module each.

mod common;
mod composed;
mod order_conditions;

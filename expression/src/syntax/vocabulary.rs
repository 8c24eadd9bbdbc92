//! The names that formulas have by themselves.

use super::composite::Composite;
use crate::expression::Function;

pub(super) const PI: &str = "pi";
pub(super) const LENGTH: &str = "N";
pub(super) const SUM: &str = "sum";
pub(super) const IF: &str = "if";
pub(super) const DERIVATIVE: &str = "D";

/// a·b.
pub(super) const DOT: &str = "dot";
/// |a|.
pub(super) const NORM: &str = "norm";
/// a × b.
pub(super) const CROSS: &str = "cross";
/// Names of the functions of vectors, a·b, |a| and a × b.
pub const VECTOR_FUNCTIONS: [&str; 3] = [DOT, NORM, CROSS];

pub(super) fn is_reserved(name: &str) -> bool {
    matches!(name, PI | LENGTH | SUM) || Function::NAMES[..Function::RESERVED].contains(&name)
}

/// Every name that a parenthesis may follow.
pub fn function_names() -> impl Iterator<Item = &'static str> {
    let functions = Function::NAMES.into_iter().chain(Composite::names());
    functions
        .chain(VECTOR_FUNCTIONS)
        .chain([IF, SUM, DERIVATIVE])
}

//! Scene formulas: text with byte spans, names resolved in a scope.
//!
//! A [`Formula`] is parsed once, without knowing which names exist. It is then resolved at one
//! site to an [`Expression`](crate::expression::Expression) over numbered variables and
//! parameters, or evaluated as a number. Every error carries the byte range it is about.
//!
//! ```text
//! formula := term (("+" | "-") term)*
//! term    := unary (("*" | "/") unary)*
//! unary   := ("-" | "+") unary | power
//! power   := atom (("^" | "**") unary)?
//! atom    := number | name | name "[" site ("," site)* "]" | function "(" formula ")"
//!          | "sum" "(" (name ("<" name)* ",")+ formula ")" | "(" formula ")"
//!          | "if" "(" condition "," formula "," formula ")" | "D" "(" formula ("," variable)+ ")"
//! condition := all ("or" all)*
//! all     := part ("and" part)*
//! part    := "not" part | "(" condition ")" | formula (("<" | "<=" | ">" | ">=" | "==" | "!=") formula)+
//! site    := sum or difference of integers and at most one of: an index name, N
//! ```
//!
//! A name is a word, or two with a point between. Thus `s.x[i]` is the component x of a vector of the family s. The
//! power sign `^` is right associative and binds tighter than the sign: `-x^2` is `-(x^2)`. The names `pi`, `N` (the
//! length of the longest family), `sum` and those of the functions from `exp` to `atanh` are reserved. Any other function
//! is one where a parenthesis follows; where a scene gives its name to something else, it is refused there.

mod bound;
mod calls;
mod composite;
mod conditions;
mod couplings;
mod density;
mod display;
mod error;
mod formula;
mod lexer;
mod lookups;
mod margin;
mod matrices;
mod offsets;
mod pairs;
mod parser;
mod pattern;
mod place;
mod resolve;
mod scope;
mod site_names;
mod suggestion;
mod sums;
#[cfg(test)]
mod tests;
mod tree;
mod value;
mod vectors;
mod vocabulary;
mod written_out;

pub use bound::At;
pub use density::Density;
pub use error::{SyntaxError, SyntaxErrorKind};
pub use formula::Formula;
pub use margin::EQUAL_MARGIN;
pub use offsets::Offsets;
pub use pairs::{PairSum, PairSums};
pub use parser::{AXES, DEPTH_LIMIT};
pub use pattern::VariablePattern;
pub use resolve::{POWER_LIMIT, TERM_LIMIT};
pub use scope::{Boundary, Scope};
pub use site_names::{INDEX_NAMES, SiteNames};
pub use vectors::{PART_LIMIT, Vector};
pub use vocabulary::{VECTOR_FUNCTIONS, function_names};

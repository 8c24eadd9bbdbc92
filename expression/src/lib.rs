//! leafwise-expression

pub mod expression;
pub mod rational;
pub mod syntax;

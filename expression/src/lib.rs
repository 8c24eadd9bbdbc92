//! leafwise-expression

//! leafwise

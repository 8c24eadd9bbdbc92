//! leafwise-core

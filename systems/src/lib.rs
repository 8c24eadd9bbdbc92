//! leafwise-systems

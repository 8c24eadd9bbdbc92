//! leafwise-cli

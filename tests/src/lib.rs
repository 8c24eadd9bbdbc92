//! leafwise-tests

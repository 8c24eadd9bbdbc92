//! leafwise-benches

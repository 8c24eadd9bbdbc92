//! leafwise-hamilton-jacobi

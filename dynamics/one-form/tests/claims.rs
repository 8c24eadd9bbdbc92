//! What the crate claims.

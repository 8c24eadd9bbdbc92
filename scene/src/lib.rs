//! leafwise-scene

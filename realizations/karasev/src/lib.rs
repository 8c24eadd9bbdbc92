//! leafwise-karasev

//! The flag that Ctrl-C raises, and whether anyone looks at it.

use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a command looks at the flag by now.
static IS_WATCHED: AtomicBool = AtomicBool::new(false);

/// Whether the command is to stop; from the first call on it does so by itself.
pub fn is_raised(flag: &AtomicBool) -> bool {
    IS_WATCHED.store(true, Ordering::Relaxed);
    flag.load(Ordering::Relaxed)
}

/// Whether a command looks at the flag. Before it does, as while a scene is built, there is nothing
/// to save, and the program may be ended.
pub fn is_watched() -> bool {
    IS_WATCHED.load(Ordering::Relaxed)
}

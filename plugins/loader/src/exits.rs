//! A library that ends the process from within a call.

use std::cell::Cell;
use std::sync::Once;

use crate::platform;

thread_local! {
    /// The name of the part that this thread is calling: one word, which every call writes twice.
    static CALLED: Cell<Option<&'static &'static str>> = const { Cell::new(None) };
}

/// Makes a call of the part of this name, which is known to be under way for as long as it lasts.
#[inline(always)]
pub(crate) fn in_call<T>(part: &'static &'static str, call: impl FnOnce() -> T) -> T {
    let before = CALLED.replace(Some(part));
    let result = call();
    CALLED.set(before);
    result
}

/// Guards the process against libraries that end it. From now on a call that ends it (`exit`, Fortran's `STOP`) ends it
/// with code 1 and a message. The code that a library chooses says nothing of the program's own task.
pub(crate) fn guard() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| platform::at_exit(refuse));
}

/// Runs when the process ends, on the thread that ends it.
extern "C" fn refuse() {
    let Ok(Some(part)) = CALLED.try_with(Cell::get) else {
        return;
    };
    platform::end_now(&format!(
        "error: {part} ended the program from within a call (`exit`, or Fortran's `STOP`), and the \
         work in progress is lost: a part must report errors by its status and `LwError`\n"
    ));
}

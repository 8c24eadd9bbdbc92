//! Opening a library and calling its entry function.

use std::path::Path;

use leafwise_plugin_abi::{LW_ABI_MAJOR, LW_ENTRY_SYMBOL, LW_ENTRY_SYMBOL_STEM, LwEntryFn};

use crate::declaration::PluginDeclaration;
use crate::error::Refusal;
use crate::exits::in_call;
use crate::file::{self, CheckedFile};
use crate::floating_point::ControlWord;
use crate::handshake;
use crate::platform;

/// Major versions that are looked for, to say which one a library offers instead.
const OTHER_MAJORS: std::ops::RangeInclusive<u16> = 1..=32;

/// Opens the library for as long as the program runs, and copies what its entry says.
///
/// A library that is refused here stays open too: nothing of it is called again.
pub(crate) fn open(path: &Path, checked: &CheckedFile) -> Result<PluginDeclaration, Refusal> {
    static OPENED: &str = "a library that was opened";
    let control = ControlWord::read();
    let library = in_call(&OPENED, || {
        // SAFETY: the user asked for this library, which is to trust it.
        unsafe { platform::open(path) }
    });
    let control = control.restore("opened");
    // The handle is given up, not closed: code of the library may be referred to from anywhere.
    let library = Box::leak(Box::new(library?));
    control?;
    // What was opened by the path is what was looked at before, if the path still leads there.
    if file::check(path, None)? != *checked {
        return Err(Refusal::Changed);
    }
    // SAFETY: the entry symbol of this version has this type.
    let entry = unsafe { library.get::<LwEntryFn>(LW_ENTRY_SYMBOL) };
    let Some(entry) = entry.ok().and_then(|symbol| *symbol) else {
        let offers = |major: &u16| {
            let name = format!("{LW_ENTRY_SYMBOL_STEM}{major}");
            // SAFETY: the symbol is looked up only.
            *major != LW_ABI_MAJOR && unsafe { library.get::<LwEntryFn>(name) }.is_ok()
        };
        return Err(Refusal::NoEntryPoint {
            offers: OTHER_MAJORS.filter(offers).map(u32::from).collect(),
        });
    };
    let control = ControlWord::read();
    // SAFETY: a function of this type by its name; it may be called once, and is.
    let entry = in_call(&OPENED, || unsafe { entry() });
    control.restore("asked for its entry")?;
    // SAFETY: what the entry function returned, of a library that is never closed.
    unsafe { handshake::read(entry) }
}

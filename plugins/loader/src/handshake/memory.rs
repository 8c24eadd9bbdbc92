//! Copies of what a library's pointers lead to.

use std::ffi::{c_char, c_void};
use std::mem::{MaybeUninit, align_of, size_of};

use leafwise_plugin_abi::{
    LwDynamics, LwEntry, LwExpression, LwParameter, LwPart, LwRealization, LwStepMap, LwSystem,
};

use crate::error::Refusal;

/// Longer texts have no end.
pub(crate) const LONGEST_TEXT: usize = 4096;
/// Longer formulas have no end.
pub(crate) const LONGEST_FORMULA: usize = 1 << 20;
/// Longer lists are a mistake.
pub(crate) const LONGEST_LIST: usize = 4096;

/// A struct whose writer says how much of it there is.
///
/// # Safety
/// Zero is a value of every field. The u32 at `SIZE_AT` states the struct's size.
pub(crate) unsafe trait Growing: Copy {
    /// Its name.
    const NAME: &'static str;
    /// Where the size stands, in bytes from its beginning.
    const SIZE_AT: usize = 0;
    /// The smallest size that makes sense: the fields that are never absent.
    const LEAST: u32;
}

macro_rules! growing {
    ($($name:ident at $at:literal, least $least:literal;)*) => {$(
        // SAFETY: all fields are integers, doubles, raw pointers or optional functions, or structs of
        // such; the offset of `struct_size` is asserted.
        unsafe impl Growing for $name {
            const NAME: &'static str = stringify!($name);
            const SIZE_AT: usize = {
                assert!(std::mem::offset_of!($name, struct_size) == $at);
                $at
            };
            const LEAST: u32 = $least;
        }
    )*};
}

growing! {
    LwEntry at 12, least 48;
    LwPart at 0, least 24;
    LwSystem at 0, least 32;
    LwRealization at 0, least 32;
    LwDynamics at 0, least 32;
    LwStepMap at 0, least 32;
}

fn is_aligned<T>(pointer: *const T) -> bool {
    pointer.addr().is_multiple_of(align_of::<T>())
}

/// A copy of the fields of a struct that its writer knows; the rest is zero.
///
/// # Safety
/// The `pointer` is not NULL. It leads to a struct that can be read up to the size it states.
pub(crate) unsafe fn copy<T: Growing>(pointer: *const T) -> Result<T, Refusal> {
    if !is_aligned(pointer) {
        return Err(Refusal::Misaligned {
            what: T::NAME.to_owned(),
        });
    }
    let bytes = pointer.cast::<u8>();
    // SAFETY: the struct has at least the fields up to its size, which is aligned as a u32.
    let stated = unsafe { bytes.add(T::SIZE_AT).cast::<u32>().read() };
    if stated < T::LEAST || !stated.is_multiple_of(8) {
        return Err(Refusal::StructSize {
            what: T::NAME.to_owned(),
            found: stated,
            least: T::LEAST,
        });
    }
    let known = size_of::<T>().min(stated as usize);
    let mut value = MaybeUninit::<T>::zeroed();
    // SAFETY: the writer states that so many bytes can be read, and there is room for them.
    unsafe { std::ptr::copy_nonoverlapping(bytes, value.as_mut_ptr().cast::<u8>(), known) };
    // SAFETY: every bit pattern that a writer of this interface leaves is a value of the fields, and
    // so is zero.
    Ok(unsafe { value.assume_init() })
}

/// A copy of a list.
///
/// # Safety
/// Where `pointer` is not NULL and `count` is possible, it leads to that many elements.
pub(crate) unsafe fn list<T: Copy>(
    what: impl Fn() -> String,
    pointer: *const T,
    count: usize,
) -> Result<Vec<T>, Refusal> {
    let problem = |problem: String| Refusal::List {
        what: what(),
        problem,
    };
    match count {
        0 => return Ok(Vec::new()),
        _ if count > LONGEST_LIST => {
            return Err(problem(format!(
                "{count} entries are more than {LONGEST_LIST}"
            )));
        }
        _ if pointer.is_null() => return Err(problem(format!("NULL in place of {count} entries"))),
        _ if !is_aligned(pointer) => return Err(Refusal::Misaligned { what: what() }),
        _ => {}
    }
    // SAFETY: the pointer is aligned and leads to `count` elements.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) }.to_vec())
}

/// A string; `None` where the pointer is NULL.
///
/// # Safety
/// Where `pointer` is not NULL, bytes can be read from it up to a NUL or to `longest`.
pub(crate) unsafe fn text(
    what: impl Fn() -> String,
    pointer: *const c_char,
    longest: usize,
) -> Result<Option<String>, Refusal> {
    if pointer.is_null() {
        return Ok(None);
    }
    let problem = |problem: String| Refusal::Text {
        what: what(),
        problem,
    };
    let mut bytes = Vec::new();
    loop {
        // SAFETY: no NUL stood before this byte, and it is not beyond the longest.
        let byte = unsafe { pointer.cast::<u8>().add(bytes.len()).read() };
        if byte == 0 {
            break;
        }
        if bytes.len() == longest {
            return Err(problem(format!("has no end within {longest} bytes")));
        }
        bytes.push(byte);
    }
    let text = String::from_utf8(bytes);
    text.map(Some)
        .map_err(|_| problem("is not UTF-8".to_owned()))
}

/// A string that must be there and not be empty.
///
/// # Safety
/// As for [`text`].
pub(crate) unsafe fn required_text(
    what: impl Fn() -> String,
    pointer: *const c_char,
) -> Result<String, Refusal> {
    // SAFETY: passed on to the caller.
    let found = unsafe { text(&what, pointer, LONGEST_TEXT) }?;
    let problem = match found {
        None => "is NULL",
        Some(text) if text.trim().is_empty() => "is empty",
        Some(text) => return Ok(text),
    };
    Err(Refusal::Text {
        what: what(),
        problem: problem.to_owned(),
    })
}

/// The formulas of a part as pairs of key and text.
///
/// # Safety
/// The list is NULL or leads to `count` formulas, their strings as for [`text`].
pub(crate) unsafe fn formulas(
    part: &str,
    pointer: *const LwExpression,
    count: usize,
) -> Result<Vec<(String, String)>, Refusal> {
    // SAFETY: passed on to the caller.
    let list = unsafe { list(|| format!("part {part}: expressions"), pointer, count) }?;
    let mut formulas: Vec<(String, String)> = Vec::with_capacity(list.len());
    for (place, expression) in list.iter().enumerate() {
        // SAFETY: passed on to the caller.
        let key = unsafe {
            required_text(
                || format!("part {part}: key of formula {place}"),
                expression.key,
            )
        }?;
        let what = || format!("part {part}: formula `{key}`");
        // SAFETY: passed on to the caller.
        let formula = unsafe { text(what, expression.formula, LONGEST_FORMULA) }?;
        let refused = |problem: &str| Refusal::Formula {
            part: part.to_owned(),
            key: key.clone(),
            problem: problem.to_owned(),
        };
        let formula = formula.ok_or_else(|| refused("it is NULL"))?;
        if formulas.iter().any(|(known, _)| *known == key) {
            return Err(refused("this key occurs twice"));
        }
        formulas.push((key, formula));
    }
    Ok(formulas)
}

/// The parameters of a part as they stand there.
///
/// # Safety
/// The list is NULL or leads to `count` parameters.
pub(crate) unsafe fn parameters(
    part: &str,
    pointer: *const LwParameter,
    count: usize,
) -> Result<Vec<LwParameter>, Refusal> {
    // SAFETY: passed on to the caller.
    unsafe { list(|| format!("part {part}: parameters"), pointer, count) }
}

/// A table of functions as its kind's struct.
///
/// # Safety
/// `pointer` is not NULL and leads to a struct of type `T`.
pub(crate) unsafe fn table<T: Growing>(part: &str, pointer: *const c_void) -> Result<T, Refusal> {
    // SAFETY: passed on to the caller.
    unsafe { copy(pointer.cast::<T>()) }.map_err(|refusal| Refusal::Declaration {
        part: part.to_owned(),
        problem: refusal.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_an_older_writer_does_not_know_is_absent() {
        let mut newest = LwStepMap::empty();
        newest.increment = Some(evaluate);
        newest.tangent = Some(evaluate);
        let mut older = newest;
        older.struct_size = 40;
        for (table, has_tangent) in [(newest, true), (older, false)] {
            // SAFETY: a struct of at least the size it states.
            let copy = unsafe { copy(&raw const table) }.expect("a possible size");
            assert!(copy.increment.is_some());
            assert_eq!(copy.tangent.is_some(), has_tangent);
        }
        for size in [0, 24, 44] {
            older.struct_size = size;
            // SAFETY: nothing beyond the size is read.
            let refusal = unsafe { copy(&raw const older) }.expect_err("an impossible size");
            assert!(
                matches!(refusal, Refusal::StructSize { least: 32, .. }),
                "{refusal}"
            );
        }
    }

    unsafe extern "C" fn evaluate(
        _: *mut c_void,
        _: *const leafwise_plugin_abi::LwMapCall,
        _: *mut leafwise_plugin_abi::LwError,
    ) -> i32 {
        0
    }

    #[test]
    fn strings_are_bounded_and_utf8() {
        let read = |bytes: &[u8], longest| {
            let what = || "its name".to_owned();
            // SAFETY: the bytes end with a NUL or are longer than the longest.
            unsafe { text(what, bytes.as_ptr().cast(), longest) }.map_err(|e| e.to_string())
        };
        assert_eq!(read("α̂\0".as_bytes(), 9), Ok(Some("α̂".to_owned())));
        assert_eq!(read(b"abc\0", 3), Ok(Some("abc".to_owned())));
        let endless = "its name has no end within 2 bytes".to_owned();
        assert_eq!(read(b"abc\0", 2), Err(endless));
        assert_eq!(read(b"\xff\0", 9), Err("its name is not UTF-8".to_owned()));
        for (bytes, problem) in [(&b" \0"[..], "is empty"), (b"", "is NULL")] {
            let pointer = if bytes.is_empty() {
                std::ptr::null()
            } else {
                bytes.as_ptr()
            };
            // SAFETY: NULL, or a string with an end.
            let refusal = unsafe { required_text(|| "its id".to_owned(), pointer.cast()) };
            assert_eq!(
                refusal.map_err(|e| e.to_string()),
                Err(format!("its id {problem}"))
            );
        }
    }
}

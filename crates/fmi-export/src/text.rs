//! Functions from text to text beside the standards, by which a library answers questions before there is an FMU.

use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr;

use crate::guard;

/// Export a function `fn(&str, Option<&str>) -> String` under a C name:
/// `export_text!(fmu_scene_check = scene::check_text);`
///
/// `int NAME(const char *text, const char *other, char *buffer, size_t capacity, size_t *needed)` returns 0 if the
/// answer is the function's and 1 if it is an error message; `other` may be NULL. `*needed` is the size of the answer
/// with the final NUL; the answer is written only if the capacity suffices.
#[macro_export]
macro_rules! export_text {
    ($name:ident = $function:expr) => {
        // SAFETY: no other function of the library has this name.
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(
            text: *const ::std::ffi::c_char,
            other: *const ::std::ffi::c_char,
            buffer: *mut ::std::ffi::c_char,
            capacity: usize,
            needed: *mut usize,
        ) -> ::std::ffi::c_int {
            // SAFETY: the caller keeps the precondition of `answer`.
            unsafe { $crate::text::answer($function, [text, other], (buffer, capacity), needed) }
        }
    };
}

/// Answer a question, see [`export_text!`](crate::export_text).
///
/// # Safety
/// The texts are null or null-terminated, `buffer` is null or has room for `capacity` bytes, `needed` is null or valid.
pub unsafe fn answer(
    function: impl FnOnce(&str, Option<&str>) -> String,
    [text, other]: [*const c_char; 2],
    target: (*mut c_char, usize),
    needed: *mut usize,
) -> c_int {
    let answered = guard::catch(|| {
        // SAFETY: the function's precondition.
        let [text, other] = unsafe { [read(text)?, read(other)?] };
        Ok(function(text.ok_or("the text is NULL")?, other))
    });
    // SAFETY: the function's precondition.
    unsafe { write(answered.and_then(|result| result), target, needed) }
}

/// Return the text at a pointer, if it is not null.
///
/// # Safety
/// `pointer` is null or a null-terminated string, which nobody changes during `'a`.
unsafe fn read<'a>(pointer: *const c_char) -> Result<Option<&'a str>, String> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the pointer is not null and the caller vouches for the rest.
    let text = unsafe { CStr::from_ptr(pointer) }.to_str();
    text.map(Some).map_err(|error| format!("the text is not UTF-8: {error}"))
}

/// Write an answer or an error message where there is room for it, and return 0 or 1.
///
/// # Safety
/// `buffer` is null or has room for `capacity` bytes, `needed` is null or valid.
pub(crate) unsafe fn write(
    answer: Result<String, String>,
    (buffer, capacity): (*mut c_char, usize),
    needed: *mut usize,
) -> c_int {
    let code = c_int::from(answer.is_err());
    let text = answer.unwrap_or_else(|message| message);
    let text = CString::new(text.replace('\0', "\u{fffd}")).expect("NUL was replaced");
    let bytes = text.as_bytes_with_nul();
    // SAFETY: pointers that are null are left alone, and no more is written than there is room for.
    unsafe {
        if let Some(needed) = needed.as_mut() {
            *needed = bytes.len();
        }
        if !buffer.is_null() && bytes.len() <= capacity {
            ptr::copy_nonoverlapping(bytes.as_ptr(), buffer.cast(), bytes.len());
        }
    }
    code
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Return code, answer and its size for a buffer of `capacity` bytes.
    fn ask(text: Option<&CStr>, capacity: usize) -> (c_int, String, usize) {
        let function = |text: &str, other: Option<&str>| match text {
            "panic" => panic!("no answer"),
            _ => format!("{text} and {other:?}"),
        };
        let (mut buffer, mut needed) = (vec![0u8; capacity], 0);
        let texts = [text.map_or(ptr::null(), CStr::as_ptr), ptr::null()];
        // SAFETY: the strings are null-terminated, and the buffer has room for `capacity` bytes.
        let code = unsafe { answer(function, texts, (buffer.as_mut_ptr().cast(), capacity), &mut needed) };
        let text = CStr::from_bytes_until_nul(&buffer).map_or(String::new(), |text| text.to_str().unwrap().into());
        (code, text, needed)
    }

    #[test]
    fn an_answer_is_written_where_there_is_room() {
        assert_eq!(ask(Some(c"a"), 100), (0, "a and None".into(), 11));
        assert_eq!(ask(Some(c"a"), 10), (0, String::new(), 11));
        assert_eq!(ask(None, 100).0, 1);
        assert_eq!(ask(Some(c"\xff"), 100).0, 1);
        assert!(ask(Some(c"panic"), 500).1.contains("no answer"));
    }
}

//! Guard of the C interface against panics, without output or backtraces.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::fmt::Write;
use std::hint::black_box;
use std::mem::ManuallyDrop;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

use fpenv::Fast;

// A thread-local with a destructor would keep the shared library loaded, so these have none.
thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
    static LOCATION: RefCell<ManuallyDrop<String>> = const { RefCell::new(ManuallyDrop::new(String::new())) };
}

/// Run `body` in the floating-point modes of [`Fast`]; return a panic as its message and location.
pub(crate) fn catch<T>(body: impl FnOnce() -> T) -> Result<T, String> {
    install_hook();
    let _fast = Fast::enter();
    let before = GUARDED.replace(true);
    // The black boxes keep arithmetic of `body` between the changes of modes.
    let body = black_box(body);
    let result = black_box(panic::catch_unwind(AssertUnwindSafe(body)));
    GUARDED.set(before);
    result.map_err(|payload| {
        let location = LOCATION.with_borrow(|location| location.to_string());
        format!("panic at {location}: {}", text(&*payload))
    })
}

/// Install a panic hook that records the location in guarded threads and calls the present hook in others.
fn install_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let other = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !GUARDED.get() {
                return other(info);
            }
            LOCATION.with_borrow_mut(|location| {
                location.clear();
                if let Some(place) = info.location() {
                    write!(location, "{place}").expect("writing to memory does not fail");
                }
            });
        }));
    });
}

/// Return the message of a panic.
fn text(payload: &(dyn Any + Send)) -> &str {
    let string = payload.downcast_ref::<String>().map(String::as_str);
    string.or_else(|| payload.downcast_ref().copied()).unwrap_or("no message")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_its_message_and_place() {
        let message = catch(|| panic!("n = {}", 3)).unwrap_err();
        assert!(message.contains("n = 3") && message.contains("guard.rs"), "{message}");
        assert_eq!(catch(|| 4), Ok(4));
    }
}

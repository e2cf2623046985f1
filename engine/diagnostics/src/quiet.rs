//! Calls readers of other crates that panic on broken input, and turns the panic into an error.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs `f`; `None` when it panics. Nothing is printed then: the file was wrong, not raxel. Panics on other threads are reported as ever.
pub fn quietly<T>(f: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !QUIET.get() {
                previous(info);
            }
        }));
    });
    let before = QUIET.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(f)).ok();
    QUIET.set(before);
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_nothing_and_ends_in_one() {
        assert_eq!(quietly(|| 7), Some(7));
        let inner = || quietly(|| panic!("never printed")).map_or(2, |()| 1);
        assert_eq!(quietly(inner), Some(2));
        let panics = || {
            inner();
            panic!("never printed either")
        };
        assert_eq!(quietly(panics).map(|()| 1), None);
        assert!(!QUIET.get());
    }
}

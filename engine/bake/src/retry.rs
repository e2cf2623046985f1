//! Tries again what can succeed the next time.

use std::time::Duration;

/// Calls until it succeeds, an error is not passing, or all pauses were made. The last error is returned.
pub(crate) fn retried<T, E>(
    pauses: &[Duration],
    passing: impl Fn(&E) -> bool,
    mut call: impl FnMut() -> Result<T, E>,
) -> Result<T, E> {
    for pause in pauses {
        match call() {
            Err(error) if passing(&error) => std::thread::sleep(*pause),
            result => return result,
        }
    }
    call()
}

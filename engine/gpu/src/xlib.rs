//! The end of an X server, as Xlib reports it.

use std::ffi::{c_int, c_void};
use std::sync::OnceLock;

type OnIoError = unsafe extern "C" fn(display: *mut c_void) -> c_int;
type SetIoErrorHandler = unsafe extern "C" fn(handler: Option<OnIoError>) -> Option<OnIoError>;

/// `RTLD_NOW | RTLD_NOLOAD`.
const LOADED: c_int = 0x2 | 0x4;

static HANDLER: OnceLock<fn() -> !> = OnceLock::new();

/// Has `handler` called when Xlib loses its server. By itself Xlib then writes a line to stderr and ends the process with exit code 1,
/// which a script cannot distinguish from other ends. Nothing happens where Xlib is not loaded; the first handler stays.
pub fn on_lost_x_server(handler: fn() -> !) {
    HANDLER.get_or_init(|| handler);
    // SAFETY: with `RTLD_NOLOAD` nothing is loaded, so that no initialiser runs.
    let Ok(library) = (unsafe { libloading::os::unix::Library::open(Some("libX11.so.6"), LOADED) }) else { return };
    // SAFETY: Xlib.h declares the function so, and `on_io_error` is of the type that it asks for.
    unsafe {
        if let Ok(set) = library.get::<SetIoErrorHandler>(b"XSetIOErrorHandler\0") {
            set(Some(on_io_error));
        }
    }
}

/// Xlib ends the process when this returns, so it does not.
unsafe extern "C" fn on_io_error(_display: *mut c_void) -> c_int {
    match HANDLER.get() {
        Some(handler) => handler(),
        None => 0,
    }
}

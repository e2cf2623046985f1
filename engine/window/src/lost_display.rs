//! The end of the window system under an open window: an X server that is stopped or that closes the connection, a Wayland compositor that ends.
//!
//! winit panics then wherever it next asks for something, and Xlib ends the process by itself. Both come here before anything unwinds: the
//! objects of the window can no longer be taken down in order. No work is lost: an edit is in its journal when it is made, and a changed
//! layout of the panels is soon in its file.

use std::sync::OnceLock;

use raxel_terminal::console::Console;
use raxel_terminal::failure::{Exit, Failure, leave};

/// The console that reports the end.
static CONSOLE: OnceLock<Console> = OnceLock::new();

/// From here on the end of the window system is reported on this console.
pub(super) fn watch(console: &Console) {
    CONSOLE.get_or_init(|| console.clone());
    #[cfg(target_os = "linux")]
    raxel_gpu::on_lost_x_server(|| end("the X server closed the connection"));
}

/// Whether a source file belongs to the crates that talk to the window system.
pub fn is_of_windows(file: &str) -> bool {
    let mut folders = file.split(['/', '\\']);
    folders.any(|folder| ["winit-", "x11rb-", "wayland-"].iter().any(|name| folder.starts_with(name)))
}

/// Its message.
pub(super) fn failure(why: &str) -> Failure {
    Failure::new(Exit::DeviceLost, format!("the window system went away: {why}"))
        .help("edits of the world were saved as they were made; start raxel again to go on with them")
}

/// Tells it, and ends the process at once.
pub fn end(why: &str) -> ! {
    let failure = failure(why);
    match CONSOLE.get() {
        Some(console) => {
            console.failure(&failure);
            console.finish();
        }
        None => eprintln!("error: {}", failure.message.as_deref().unwrap_or_default()),
    }
    // The ends of libraries would talk to the window system.
    leave(failure.exit as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_raxel_is_no_end_of_the_window_system() {
        assert!(is_of_windows("/home/a/.cargo/registry/src/index/winit-0.30.13/src/platform_impl/linux/x11/window.rs"));
        assert!(is_of_windows(r"C:\registry\src\index\x11rb-0.13.2\src\lib.rs"));
        assert!(!is_of_windows("engine/window/src/lib.rs") && !is_of_windows("/home/a/winit/engine/main.rs"));
    }
}

//! A panic is a bug in raxel, never a mistake in an input. It is reported in one line, with what to do about it.

use std::backtrace::{Backtrace, BacktraceStatus};

use raxel_window::lost_display;

/// Replaces the default hook. The exit code of a panic stays 101.
pub(crate) fn install() {
    std::panic::set_hook(Box::new(|info| {
        let place = info.location().map(ToString::to_string).unwrap_or_default();
        let payload = info.payload();
        let message = payload
            .downcast_ref::<&str>()
            .map(|text| (*text).to_owned())
            .or_else(|| payload.downcast_ref::<String>().cloned())
            .unwrap_or_default();
        if info.location().is_some_and(|location| lost_display::is_of_windows(location.file())) {
            lost_display::end(&format!("a library of windows stopped with \"{}\"", message.replace('\n', " ")));
        }
        eprintln!(
            "raxel {}: internal error at {place}: {}; this is a bug in raxel: please report this line with the command and the \
             files (RUST_BACKTRACE=1 adds where it came from)",
            env!("CARGO_PKG_VERSION"),
            message.replace('\n', " ")
        );
        let backtrace = Backtrace::capture();
        if backtrace.status() == BacktraceStatus::Captured {
            eprintln!("{backtrace}");
        }
    }));
}

//! Why a streamed world is not there, for the user.

use raxel_diagnostics::{Diagnostic, codes};
use raxel_worldfile::Streamed;

use crate::StreamError;

fn mebibytes(bytes: u64) -> String {
    // Tenths would make two small amounts that disagree look equal.
    if bytes < 1 << 20 {
        format!("{:.1} KiB", bytes as f64 / 1024.0)
    } else {
        format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
    }
}

pub(super) fn too_small(streamed: &Streamed, needed: u64, bytes: u64) -> Diagnostic {
    let (needed_text, there) = (mebibytes(needed), mebibytes(bytes));
    let diagnostic = Diagnostic::error(
        codes::world::STREAM_BUDGET,
        format!("the world around the camera takes about {needed_text}, and there are {there} for it"),
    )
    .label(streamed.place.clone(), "the tiles of `near` and `far` must fit in `gpu_memory`");
    if bytes < streamed.settings.gpu_memory {
        let wanted = mebibytes(streamed.settings.gpu_memory);
        diagnostic.note(format!("the device has no room for a buffer of {wanted}")).help("lower `near` or `far`")
    } else {
        diagnostic.help("raise `gpu_memory`, or lower `near` or `far`")
    }
}

pub(super) fn too_small_on_host(streamed: &Streamed, needed: u64) -> Diagnostic {
    let (needed, there) = (mebibytes(needed), mebibytes(streamed.settings.cpu_memory));
    let message = format!("the chunks around the camera take about {needed} packed, and `cpu_memory` is {there}");
    Diagnostic::error(codes::world::STREAM_HOST_BUDGET, message)
        .label(streamed.place.clone(), "the tiles of `near` and `far` must fit in `cpu_memory`")
        .help("raise `cpu_memory`, lower `near` or `far`, or keep nothing by `cpu_memory = 0`")
}

/// A thread that loads the world cannot start, or has ended.
pub(super) fn stopped(error: &StreamError) -> Diagnostic {
    let diagnostic = Diagnostic::error(codes::world::STREAM_THREAD, format!("the world is no longer loaded: {error}"));
    if let StreamError::NotStarted { .. } = error {
        return diagnostic.help("set `threads` in `[stream]` lower, or allow the process more threads");
    }
    diagnostic
        .note("the last picture stays; no edit and no move of the camera loads anything")
        .help("this is a bug in raxel: please report it; save the world's file to load the world again")
}

pub(super) fn incomplete(error: &StreamError) -> Diagnostic {
    if let StreamError::NotStarted { .. } | StreamError::Ended { .. } = error {
        return stopped(error);
    }
    if let StreamError::Unavailable { .. } = error {
        let message = format!("the streamed world is not complete: {error}");
        return Diagnostic::error(codes::world::STORE_FAILING, message)
            .help("bake the missing chunks, or wait until the store answers again");
    }
    let message = format!("the streamed world is not complete: {error}");
    if let StreamError::TooManyLamps { .. } = error {
        return Diagnostic::error(codes::world::STREAM_LAMPS, message)
            .help("raise `lamp_memory`, or lower `near` or `far`; half of it is for tables");
    }
    Diagnostic::error(codes::world::STREAM_BUDGET, message).help("raise `gpu_memory`, or lower `near` or `far`")
}

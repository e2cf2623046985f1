//! The long frames of a flight: by part of the path, and one by one with their work.

use std::fmt::Write as _;

use raxel_measure::flight::{Flown, Frame, percentile};

/// Frames that are listed, and passes that are named of each.
const FRAMES: usize = 5;
const PASSES: usize = 4;

/// A line for each part of the path, of the frames while loading and with everything there.
pub(super) fn parts(live: &Flown, resident: &Flown) -> String {
    let both = !resident.frames.is_empty();
    let head = format!("{:>8} {:>8} {:>8} {:>7}", "p50", "p99", "max", "> 2×");
    let mut text = format!("{:<10} {:>8} {head}", "part, ms", "frames");
    if both {
        let _ = write!(text, "  resident {head}");
    }
    text += "\n";
    // Of all frames of the flight that were drawn.
    let limits = [live, resident].map(|flown| 2.0 * flown.percentile(0.5, |frame| frame.milliseconds));
    let row = |frames: &[&Frame], limit: f64| {
        let of = |part| percentile(frames.iter().map(|frame| frame.milliseconds), part);
        let slow = frames.iter().filter(|frame| frame.milliseconds > limit).count();
        format!("{:>8.2} {:>8.2} {:>8.2} {slow:>7}", of(0.5), of(0.99), of(1.0))
    };
    let [parts, others] = [live, resident].map(|flown| {
        let mut parts = flown.parts();
        parts.iter_mut().for_each(|(_, frames)| frames.retain(|frame| frame.is_drawn()));
        parts
    });
    for (index, (part, frames)) in parts.iter().enumerate() {
        let _ = write!(text, "{part:<10} {:>8} {}", frames.len(), row(frames, limits[0]));
        if let Some((_, frames)) = others.get(index) {
            let _ = write!(text, "  {:>8} {}", "", row(frames, limits[1]));
        }
        text += "\n";
    }
    text
}

/// The longest frames: their places, the arrivals in them, and their longest passes on the device, each with its median.
pub(super) fn frames(what: &str, flown: &Flown) -> String {
    if flown.frames.is_empty() {
        return String::new();
    }
    let mut text = format!("longest frames, {what}; in brackets what a pass takes in the median\n");
    text += &format!(
        "{:>8} {:>8} {:>8}  {:<16} {:>8} {:>6} {:>8}  passes, ms\n",
        "ms", "device", "submit", "part, ms in it", "MiB", "tiles", "missing"
    );
    for frame in flown.longest(FRAMES) {
        let device = frame.device.map_or("-".to_owned(), |device| format!("{device:.2}"));
        let place = format!("{} {:.0}", frame.part, frame.since * 1e3);
        let (bytes, missing) = (frame.bytes as f64 / f64::from(1 << 20), frame.missing_in_view);
        text += &format!(
            "{:>8.2} {device:>8} {:>8.2}  {place:<16} {bytes:>8.2} {:>6} {missing:>8}  {}\n",
            frame.milliseconds,
            frame.submitted,
            frame.tiles,
            passes(flown, frame)
        );
    }
    text
}

/// The longest passes of a frame.
fn passes(flown: &Flown, frame: &Frame) -> String {
    let mut passes: Vec<(usize, f64)> = frame.passes.iter().copied().enumerate().collect();
    passes.sort_by(|a, b| b.1.total_cmp(&a.1));
    let named = passes.into_iter().take(PASSES).filter_map(|(index, milliseconds)| {
        let median = flown.percentile(0.5, |frame| frame.passes.get(index).copied().unwrap_or(0.0));
        Some(format!("{} {milliseconds:.2} ({median:.2})", flown.passes.get(index)?))
    });
    named.collect::<Vec<_>>().join(", ")
}

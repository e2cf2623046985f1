//! `raxel bench stream`: a flight through a streamed world.

mod longest;

use std::time::Duration;

use raxel_gpu::DeviceOptions;
use raxel_measure::flight::{
    Arrival, EditLatency, Flight, FlightError, FlightOptions, Flown, Frame, Kept, Rate, SeenIn, fly, percentile,
};
use raxel_terminal::args::{Messages, Size, size};
use raxel_terminal::console::{self, Console, Format, To};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::session::{What, frame_failure, open_failure};
use serde_json::json;

/// Flies through a streamed world twice, while it loads and when all of it is loaded, and prints the frame times of both.
///
/// The path goes straight over new land, half a turn, back, down, and then makes three jumps. At its end, edits are made in view, and it prints the
/// time from an edit to its picture.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: raxel bench stream graphs/bench/first_hit.toml --world worlds/frontier.toml --speed 256 --size 1920x1080"
)]
pub(crate) struct Args {
    #[command(flatten)]
    what: What,

    /// Voxels a second.
    #[arg(long, value_name = "VOXELS", default_value_t = 64.0, value_parser = speed)]
    speed: f64,

    /// Seconds of each of the two straight parts.
    #[arg(long, value_name = "SECONDS", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=3600))]
    seconds: u32,

    /// Edits after the flight: half of them add voxels, the other half remove them again.
    #[arg(long, value_name = "EDITS", default_value_t = 200, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    edits: u32,

    /// Seconds of the way down, and at the place after each jump; a fifth of the straight parts by default.
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u32).range(1..=3600))]
    stay: Option<u32>,

    /// Pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x720")]
    size: Size,

    /// Fly the path once only, while the world loads.
    #[arg(long)]
    once: bool,

    #[command(flatten)]
    pub messages: Messages,
}

fn speed(text: &str) -> std::result::Result<f64, String> {
    let speed = text.parse().ok().filter(|speed: &f64| (0.0..=1e5).contains(speed));
    speed.ok_or_else(|| "a number of voxels from 0 to 100000".to_owned())
}

/// How long the first place may take.
const PATIENCE: Duration = Duration::from_secs(600);

pub(super) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    let mut session = args.what.options(device)?;
    session.size = args.size.0;
    let (seconds, balls) = (f64::from(args.seconds), args.edits / 2);
    let stay = args.stay.map_or(seconds / 5.0, f64::from);
    let options =
        FlightOptions { session, speed: args.speed, seconds, stay, balls, resident: !args.once, patience: PATIENCE };
    let flight = fly(&options).map_err(|error| failure(error, console))?;
    console.diagnostics(&flight.messages.0, &flight.messages.1, To::Stderr);
    if console.format() == Format::Json {
        console::json(&json!({
            "reason": "bench-stream",
            "device": flight.device,
            "size": flight.size,
            "speed": args.speed,
            "first_seconds": flight.first_seconds,
            "pool": [flight.pool.used, flight.pool.peak, flight.pool.capacity],
            "most_written": flight.live.stats.most_written,
            "kept": flight.kept,
            "jumps_at": flight.jumps_at,
            "jumps": flight.jumps,
            "edits": flight.edits,
            "live": flight.live,
            "resident": flight.resident,
        }));
    } else {
        console::data(&table(&flight, args.speed));
    }
    Ok(())
}

fn table(flight: &Flight, speed: f64) -> String {
    let [width, height] = flight.size;
    let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let mut text = format!(
        "{speed} voxels a second, {} frames, {} of them with new work, {width}×{height}, {}\ntiles around the first place resident after {:.2} s\n",
        flight.live.frames.len(),
        flight.live.drawn().count(),
        flight.device,
        flight.first_seconds
    );
    text += &format!(
        "{:<10} {:>8} {:>8} {:>8} {:>8} {:>8}  {:>7} {:>7}\n",
        "frames, ms", "p50", "p95", "p99", "p99.9", "max", "> 1.5×", "> 2×"
    );
    let row = |name: &str, flown: &Flown| {
        let [a, b, c, d, e] =
            [0.5, 0.95, 0.99, 0.999, 1.0].map(|part| flown.percentile(part, |frame| frame.milliseconds));
        let (slow, slower) = (flown.over(1.5), flown.over(2.0));
        format!("{name:<10} {a:>8.2} {b:>8.2} {c:>8.2} {d:>8.2} {e:>8.2}  {slow:>7} {slower:>7}\n")
    };
    text += &row("loading", &flight.live);
    if !flight.resident.frames.is_empty() {
        text += &row("resident", &flight.resident);
    }
    text += &longest::parts(&flight.live, &flight.resident);
    text += &longest::frames("loading", &flight.live);
    text += &longest::frames("resident", &flight.resident);
    let spent = |part: f64| percentile(flight.live.frames.iter().map(|frame| frame.stream_microseconds), part);
    let sum = |of: fn(&Frame) -> u64| flight.live.frames.iter().map(of).sum::<u64>();
    let missing = flight.live.frames.iter().filter(|frame| frame.missing_in_view > 0).count();
    let straight =
        flight.live.frames.iter().filter(|frame| frame.missing_in_view > 0 && frame.time < flight.jumps_at).count();
    let holes = flight.live.frames.iter().filter(|frame| frame.holes_in_view > 0).count();
    let early =
        flight.live.frames.iter().filter(|frame| frame.holes_in_view > 0 && frame.time < flight.jumps_at).count();
    let [used, peak, all] = [flight.pool.used, flight.pool.peak, flight.pool.capacity].map(mebibytes);
    text += &format!(
        "loading on the thread of the frames: p50 {:.0} µs, p99 {:.0} µs, max {:.0} µs\n",
        spent(0.5),
        spent(0.99),
        spent(1.0)
    );
    text += &format!(
        "written {:.1} MiB in {} publications; chunks made {}, dropped {}\n",
        mebibytes(sum(|frame| frame.bytes)),
        flight.live.stats.publications,
        flight.live.stats.made,
        flight.live.stats.dropped
    );
    text += &format!(
        "frames in which a coarser chunk stands in for one in view: {}, {} of them before the jumps; with a hole: {holes}, {early} of them before the jumps\n",
        missing.saturating_sub(holes),
        straight.saturating_sub(early)
    );
    let after = |of: fn(&Arrival) -> Option<f64>| {
        let milliseconds = |time: Option<f64>| time.map_or("never".to_owned(), |time| format!("{time:.0}"));
        flight.jumps.iter().map(|jump| milliseconds(of(jump))).collect::<Vec<_>>().join(", ")
    };
    text += &format!(
        "after a jump, the first picture without a hole after {} ms, the first with everything in view after {} ms, every chunk of single \
         voxels around the camera after {} ms, and everything after {} ms\n",
        after(|jump| jump.whole),
        after(|jump| jump.complete),
        after(|jump| jump.chunks),
        after(|jump| jump.settled)
    );
    if flight.live.stats.lights > 0 {
        text += &format!("{} lamps listed at the end of the flight\n", flight.live.stats.lights);
    }
    text += &format!(
        "pool {used:.1} MiB in use, {peak:.1} at most, of {all:.1}; at most {:.2} MiB written in a frame\n",
        mebibytes(flight.live.stats.most_written)
    );
    let Kept { chunks, bytes, most, found, made } = flight.kept;
    text += &format!(
        "{chunks} chunks on the host in {:.1} of {:.1} MiB; {found} found there, {made} made\n",
        mebibytes(bytes),
        mebibytes(most)
    );
    text += &seen("edits of 6 voxels' radius", &flight.edits.small);
    text += &seen("edits of 64 voxels' radius", &flight.edits.large);
    if let Some(Rate { frames, voxels, chunks, seconds, seen_after, seen_in: SeenIn { median, most } }) =
        flight.edits.many
    {
        text += &format!(
            "{voxels} voxels set in {chunks} chunks in each of {frames} frames: {:.1} frames a second; each seen with all before it after {median:.0} ms in the median, {most:.0} at most, all of them {:.0} ms after the last\n",
            f64::from(frames) / seconds,
            seen_after * 1e3
        );
    }
    text
}

/// A line on the time until edits of one type were seen.
fn seen(what: &str, edits: &[EditLatency]) -> String {
    if edits.is_empty() {
        return String::new();
    }
    let of = |part, of: fn(&EditLatency) -> f64| percentile(edits.iter().map(of), part);
    let [a, b, c] = [0.5, 0.99, 1.0].map(|part| of(part, |edit| f64::from(edit.frames)));
    let [d, e, f] = [0.5, 0.99, 1.0].map(|part| of(part, |edit| edit.milliseconds));
    format!(
        "{} {what}: seen after p50 {a}, p99 {b}, at most {c} frames; p50 {d:.1}, p99 {e:.1}, at most {f:.1} ms\n",
        edits.len()
    )
}

fn failure(error: FlightError, console: &Console) -> Failure {
    match error {
        FlightError::Open(error) => open_failure(error, console),
        FlightError::Frame(error) => frame_failure(error, console),
        FlightError::NotStreamed(_) => {
            Failure::new(Exit::Project, error.to_string()).help("raxel bench stream --world worlds/frontier.toml")
        }
        FlightError::Unsettled { .. } | FlightError::Unseen { .. } => Failure::new(Exit::Check, error.to_string()),
    }
}

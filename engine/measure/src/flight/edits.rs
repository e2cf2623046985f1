//! Measures the delay until edits are seen, and counts the seen edits.

use std::time::{Duration, Instant};

use glam::{DVec3, IVec3};
use raxel_edit::{Brush, Operation};
use raxel_runtime::session::Session;
use serde::Serialize;

use super::{FlightError, FlightOptions, one, percentile, settle};

/// The measurements of edits.
#[derive(Clone, Debug, Serialize)]
pub struct Edits {
    /// Balls of 6 voxels' radius.
    pub small: Vec<EditLatency>,
    /// Balls of 64 voxels' radius.
    pub large: Vec<EditLatency>,
    /// Many single voxels in every frame.
    pub many: Option<Rate>,
}

/// The delay until an edit was seen.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EditLatency {
    /// Frames, the one that shows it included.
    pub frames: u32,
    /// From the call to the end of the picture on the device.
    pub milliseconds: f64,
    /// Chunks that it changed.
    pub chunks: usize,
}

/// Frames that set voxels.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Rate {
    /// Frames.
    pub frames: u32,
    /// Voxels set in each, one by one.
    pub voxels: u32,
    /// Chunks that they lie in.
    pub chunks: usize,
    /// From the first edit to the end of the last of these frames on the device.
    pub seconds: f64,
    /// From the last edit to the end of the first picture that has all of them.
    pub seen_after: f64,
    /// Milliseconds from each of the edits to the end of the first picture that has it and all before it.
    pub seen_in: SeenIn,
}

/// Milliseconds until edits are seen. Files have them as a list.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(into = "[f64; 2]")]
pub struct SeenIn {
    /// The median.
    pub median: f64,
    /// The most.
    pub most: f64,
}

impl From<SeenIn> for [f64; 2] {
    fn from(SeenIn { median, most }: SeenIn) -> Self {
        [median, most]
    }
}

/// Large balls at most, and frames with many edits.
const MOST_LARGE: u32 = 10;
const MOST_FRAMES: u32 = 60;

/// Chunks along x and z that [`many`] sets voxels in, and voxels in each.
const CHUNKS: [i32; 2] = [20, 10];
const VOXELS: i32 = 5;

pub(super) fn measure(session: &mut Session, options: &FlightOptions) -> Result<Edits, FlightError> {
    let small = balls(session, options, 6.0, options.balls)?;
    let large = balls(session, options, 64.0, options.balls.min(MOST_LARGE))?;
    let frames = options.balls.min(MOST_FRAMES);
    let many = if frames > 0 { Some(many(session, options, frames)?) } else { None };
    Ok(Edits { small, large, many })
}

/// A frame of a window while it is edited lasts so long at least.
const EDITED_FRAME: Duration = Duration::from_micros(16_667);

/// Once the world is complete, puts balls of a radius in front of the camera and removes them again. Each edit waits until the one before is seen.
fn balls(
    session: &mut Session,
    options: &FlightOptions,
    radius: f64,
    count: u32,
) -> Result<Vec<EditLatency>, FlightError> {
    settle(session, options.patience)?;
    let camera = *session.camera();
    let middle = camera.position() + camera.rotation() * DVec3::NEG_Z * (42.0 + radius);
    let mut edits = Vec::new();
    for n in 0..2 * count {
        let place = [n / 2 * 37 % 64, n / 2 * 11 % 64, n / 2 * 53 % 64].map(|c| f64::from(c) - 32.0);
        let brush = if n % 2 == 0 { Brush::Add(1) } else { Brush::Subtract };
        let ball = Operation::sphere((middle + DVec3::from_array(place)).to_array(), radius, brush);
        let began = Instant::now();
        let chunks = session.edit(&[ball]).unwrap_or(0);
        // Rock is rock before and after.
        if chunks == 0 {
            continue;
        }
        let mut frames = 0;
        while frames == 0 || !session.stream().is_some_and(|stream| stream.shows_changes()) {
            std::thread::sleep((began + frames * EDITED_FRAME).saturating_duration_since(Instant::now()));
            one(session, camera)?;
            frames += 1;
            if began.elapsed() > options.patience {
                return Err(FlightError::Unseen { seconds: options.patience.as_secs() });
            }
        }
        edits.push(EditLatency { frames, milliseconds: began.elapsed().as_secs_f64() * 1e3, chunks });
    }
    Ok(edits)
}

/// Sets voxels in 200 chunks around the camera in every frame, and runs frames as fast as they come.
fn many(session: &mut Session, options: &FlightOptions, frames: u32) -> Result<Rate, FlightError> {
    settle(session, options.patience)?;
    let camera = *session.camera();
    let corner = (camera.cell & !63) - IVec3::new(32 * CHUNKS[0], 128, 32 * CHUNKS[1]);
    let (began, mut last, mut chunks) = (Instant::now(), Instant::now(), 0);
    let mut seen = Seen::default();
    for frame in 0..frames {
        let voxel = |n: i32| {
            let (chunk, voxel) = (n / VOXELS, n % VOXELS);
            let at = IVec3::new(64 * (chunk % CHUNKS[0]), 0, 64 * (chunk / CHUNKS[0]));
            let inside = IVec3::new(11 * voxel + 3, frame.cast_signed() & 63, 7 * voxel + 20);
            Operation::Set { cell: (corner + at + inside).to_array(), material: 1 + (frame & 1) as u16 }
        };
        let sets: Vec<Operation> = (0..CHUNKS[0] * CHUNKS[1] * VOXELS).map(voxel).collect();
        last = Instant::now();
        chunks = chunks.max(session.edit(&sets).unwrap_or(0));
        seen.edited(session, last);
        one(session, camera)?;
        seen.frame(session);
    }
    let seconds = began.elapsed().as_secs_f64();
    while !session.stream().is_some_and(|stream| stream.shows_changes()) {
        one(session, camera)?;
        seen.frame(session);
        if last.elapsed() > options.patience {
            return Err(FlightError::Unseen { seconds: options.patience.as_secs() });
        }
    }
    let voxels = (CHUNKS[0] * CHUNKS[1] * VOXELS).cast_unsigned();
    let [median, most] = [0.5, 1.0].map(|part| percentile(seen.milliseconds.iter().copied(), part));
    let seen_in = SeenIn { median, most };
    Ok(Rate { frames, voxels, chunks, seconds, seen_after: last.elapsed().as_secs_f64(), seen_in })
}

/// How soon edits are seen that may follow each other faster.
#[derive(Default)]
struct Seen {
    /// Numbers of the edits that are not seen yet, and when they were made.
    waiting: Vec<(u64, Instant)>,
    /// How long the others took.
    milliseconds: Vec<f64>,
}

impl Seen {
    fn edited(&mut self, session: &Session, began: Instant) {
        let number = session.stream().map_or(0, |stream| stream.changes().told);
        self.waiting.push((number, began));
    }

    fn frame(&mut self, session: &Session) {
        let shown = session.stream().map_or(0, |stream| stream.changes().seen);
        let now_seen = self.waiting.extract_if(.., |(number, _)| *number <= shown);
        self.milliseconds.extend(now_seen.map(|(_, began)| began.elapsed().as_secs_f64() * 1e3));
    }
}

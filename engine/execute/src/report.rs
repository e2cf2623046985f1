//! What a frame or a swap did, and the pictures and texels that are read back.

use raxel_graph::checked::PassId;
use raxel_shader::format::Format;
use raxel_shader::interface::ScalarKind;

use super::texel::Decoder;

/// What one frame did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameReport {
    /// Frames the executor has run before this one.
    pub frame: u64,
    /// Dispatches recorded, the display's not counted.
    pub dispatched: u32,
    /// Passes not dispatched since their results are still valid.
    pub skipped: u32,
    /// Passes not dispatched since they were not due (`every`) or are disabled.
    pub idle: u32,
    /// Barriers recorded.
    pub barriers: u32,
    /// Clears recorded.
    pub clears: u32,
    /// Whether the debug target was mapped to a picture again.
    pub displayed: bool,
    /// Nanoseconds of CPU time between the start of the frame and its submission, waiting for the device not counted.
    pub cpu_nanoseconds: u64,
}

/// What a swap did with the resources, by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SwapReport {
    /// Kept their contents.
    pub kept: Vec<String>,
    /// New, or described otherwise than before: start at their `init`.
    pub created: Vec<String>,
    /// No longer there.
    pub dropped: Vec<String>,
}

/// GPU time of one pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassTime {
    /// The pass of the plan's graph: a round of a loop is one of its own.
    pub pass: PassId,
    /// Nanoseconds; `None` when it was not dispatched in that frame.
    pub nanoseconds: Option<f64>,
}

/// GPU times of a frame that the device has finished.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpuTimes<'a> {
    /// Frames the executor ran before it; `None` when no frame has been timed since the plan was swapped in.
    pub frame: Option<u64>,
    /// Nanoseconds from the begin of the first pass to the end of the last, with all that lies between them. `None` when no pass ran, or
    /// the device has no timestamps.
    pub span: Option<f64>,
    /// Each pass; order of the plan's passes.
    pub passes: &'a [PassTime],
}

/// What became of a pass of the plan in the last frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassOutcome {
    /// It was dispatched.
    Dispatched,
    /// It was not dispatched: its results are still valid.
    Skipped,
    /// It was not due (`every`).
    NotDue,
    /// It is switched off since the device was lost while it ran.
    Off,
}

/// The presented picture: 8 bits a channel, sRGB-encoded, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// `width × height × 4` bytes: red, green, blue, alpha.
    pub rgba: Vec<u8>,
}

/// One layer or slice of one mip of a target, as the device holds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texels {
    /// Format.
    pub format: Format,
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// `width × height × format.bytes()` bytes, rows from the top, no padding.
    pub bytes: Vec<u8>,
}

impl Texels {
    /// What the texels hold.
    pub fn scalar(&self) -> ScalarKind {
        self.format.scalar()
    }

    /// The texels as floats: red, green, blue, alpha. Integers are converted; absent channels are 0, absent alpha 1.
    pub fn floats(&self) -> Vec<[f32; 4]> {
        let decoder = Decoder::of(self.format);
        self.chunks().map(|texel| decoder.floats(texel)).collect()
    }

    /// The texels as unsigned integers, signed ones by their bits. `None` for formats of floats.
    pub fn integers(&self) -> Option<Vec<[u32; 4]>> {
        let decoder = Decoder::of(self.format);
        (self.scalar() != ScalarKind::Float).then(|| self.chunks().map(|texel| decoder.integers(texel)).collect())
    }

    /// One texel: its channels as floats, and their bits; absent channels are 0, absent alpha 1. `None` outside.
    pub fn texel(&self, [x, y]: [u32; 2]) -> Option<([f32; 4], [u32; 4])> {
        let index = (x < self.width && y < self.height).then(|| y as usize * self.width as usize + x as usize)?;
        let texel = self.chunks().nth(index)?;
        let decoder = Decoder::of(self.format);
        Some((decoder.floats(texel), decoder.bits(texel)))
    }

    /// One texel as unsigned integers, signed ones by their bits. `None` outside, and for formats of floats.
    pub fn integer(&self, [x, y]: [u32; 2]) -> Option<[u32; 4]> {
        let inside = self.scalar() != ScalarKind::Float && x < self.width && y < self.height;
        let index = inside.then(|| y as usize * self.width as usize + x as usize)?;
        self.chunks().nth(index).map(|texel| Decoder::of(self.format).integers(texel))
    }

    fn chunks(&self) -> std::slice::ChunksExact<'_, u8> {
        self.bytes.chunks_exact(self.format.bytes() as usize)
    }
}

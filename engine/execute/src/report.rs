//! Reports of a frame or a swap, and the pictures and texels that are read back.

use raxel_graph::checked::PassId;
use raxel_shader::format::Format;
use raxel_shader::interface::ScalarKind;

use super::texel::Decoder;

/// The report of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameReport {
    /// Number of frames that the executor ran before this one.
    pub frame: u64,
    /// Recorded dispatches, without that of the display map.
    pub dispatched: u32,
    /// Passes that were skipped because their results are still valid.
    pub skipped: u32,
    /// Passes that did not run because they were not due (`every`) or are switched off.
    pub idle: u32,
    /// Recorded barriers.
    pub barriers: u32,
    /// Recorded clears.
    pub clears: u32,
    /// Whether the display map made a new picture of the debug target.
    pub displayed: bool,
    /// Nanoseconds of CPU time from the start of the frame to its submission, without waits for the device.
    pub cpu_nanoseconds: u64,
}

/// The effect of a swap of plans on the resources, by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SwapReport {
    /// Resources that kept their contents.
    pub kept: Vec<String>,
    /// Resources that start at their `init`: new ones, and those with a changed description.
    pub created: Vec<String>,
    /// Resources that the new plan does not have.
    pub dropped: Vec<String>,
}

/// GPU time of one pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassTime {
    /// The pass of the plan. Each round of a loop is a pass of its own.
    pub pass: PassId,
    /// Nanoseconds, or `None` if the pass did not run in that frame.
    pub nanoseconds: Option<f64>,
}

/// GPU times of a finished frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpuTimes<'a> {
    /// Number of frames that the executor ran before it. `None` if no frame was timed since the plan was swapped in.
    pub frame: Option<u64>,
    /// Nanoseconds from the start of the first pass to the end of the last. `None` if no pass ran, or the device has no timestamps.
    pub span: Option<f64>,
    /// Times of the passes, in the order of the plan's passes.
    pub passes: &'a [PassTime],
}

/// The outcome of a pass of the plan in the last frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassOutcome {
    /// The pass ran.
    Dispatched,
    /// The pass was skipped, because its results are still valid.
    Skipped,
    /// The pass was not due (`every`).
    NotDue,
    /// The pass is switched off, because the device was lost while it ran.
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

/// The texels of one layer (or slice) of one mip of a target, in the format of the target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texels {
    /// Format of the target.
    pub format: Format,
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// `width × height × format.bytes()` bytes, rows from the top, no padding.
    pub bytes: Vec<u8>,
}

impl Texels {
    /// Whether the texels hold floats, signed or unsigned integers.
    pub fn scalar(&self) -> ScalarKind {
        self.format.scalar()
    }

    /// The texels as floats: red, green, blue, alpha. Integers are converted. Missing channels are 0, a missing alpha is 1.
    pub fn floats(&self) -> Vec<[f32; 4]> {
        let decoder = Decoder::of(self.format);
        self.chunks().map(|texel| decoder.floats(texel)).collect()
    }

    /// One channel of the texels as floats, as [`Self::floats`] has it. There are four channels.
    pub fn channel(&self, channel: u32) -> Vec<f32> {
        let (decoder, channel) = (Decoder::of(self.format), channel.min(3) as usize);
        self.chunks().map(|texel| decoder.floats(texel)[channel]).collect()
    }

    /// The texels as unsigned integers; signed integers keep their bits. `None` for float formats.
    pub fn integers(&self) -> Option<Vec<[u32; 4]>> {
        let decoder = Decoder::of(self.format);
        (self.scalar() != ScalarKind::Float).then(|| self.chunks().map(|texel| decoder.integers(texel)).collect())
    }

    /// One texel: its channels as floats, and their bits. Missing channels are 0, a missing alpha is 1. `None` outside of the picture.
    pub fn texel(&self, [x, y]: [u32; 2]) -> Option<([f32; 4], [u32; 4])> {
        let index = (x < self.width && y < self.height).then(|| y as usize * self.width as usize + x as usize)?;
        let texel = self.chunks().nth(index)?;
        let decoder = Decoder::of(self.format);
        Some((decoder.floats(texel), decoder.bits(texel)))
    }

    /// One texel as unsigned integers; signed integers keep their bits. `None` outside of the picture, and for float formats.
    pub fn integer(&self, [x, y]: [u32; 2]) -> Option<[u32; 4]> {
        let inside = self.scalar() != ScalarKind::Float && x < self.width && y < self.height;
        let index = inside.then(|| y as usize * self.width as usize + x as usize)?;
        self.chunks().nth(index).map(|texel| Decoder::of(self.format).integers(texel))
    }

    fn chunks(&self) -> std::slice::ChunksExact<'_, u8> {
        self.bytes.chunks_exact(self.format.bytes() as usize)
    }
}

//! Executes a plan on a device, without a session. It prepares the plan off to the side, and swaps it in at a frame boundary. Each frame walks the
//! plan up to the picture of the debug target, and anything can be read back.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod blocks;
mod capture;
mod counters;
mod device;
mod digest;
mod display;
mod error;
mod executor;
mod fit;
mod frame;
mod heartbeat;
mod inputs;
mod instrumentation;
mod lens;
mod making;
mod memo;
pub mod moment;
mod physical;
mod pipelines;
mod prepare;
mod prints;
mod readback;
mod record;
mod replay;
mod report;
mod retained;
mod rotations;
mod shared;
mod slot;
mod source;
mod texel;
mod texel_trace;
mod thumbnails;
mod ticks;
mod times;
mod told;
mod upload;
mod uses;
mod values;
mod writers;

pub use capture::Captured;
pub use counters::CounterReading;
pub use device::{DeviceMemory, Texture, largest_image, limits, upload_image, vulkan_format};
pub use display::display_of;
pub use error::{ExecuteError, Suspect};
pub use executor::{Executor, ExecutorOptions, FramePicture, Histories, Progress};
pub use fit::{Abilities, OnPaper, unfit};
pub use inputs::{Builtins, FrameInputs, Override};
pub use lens::{Comparison, Mismatch, Reference, ReferenceValues, Region};
pub use making::{Compiling, watched};
pub use prepare::{Builder, Pipelined, Prepared};
pub use prints::{Assertion, Omitted, PassPrints, PrintedLine};
pub use readback::ReadTicket;
pub use replay::{Counts, Recorder, Replay};
pub use report::{FrameReport, GpuTimes, PassOutcome, PassTime, Picture, SwapReport, Texels};
pub use source::{ExternalResource, Sources, WriteError};
pub use texel_trace::{TexelTrace, TexelWrite, TracedTexel};
pub use thumbnails::Thumbnail;
pub use upload::FRAME_BYTES;
pub use uses::{Use, uses};
pub use writers::{InvocationWrite, PassWrites};

/// Target of the `tracing` events, of level `INFO`, that name slow steps: fields `event` (`compiling` or `working`), `seconds` and `pass`
/// (if it is known), of `compiling` also `left`; and a message that can be shown as it is.
pub const SLOW: &str = "raxel::slow";

/// Frames that are recorded while the device still works on earlier ones.
const FRAMES: usize = 2;

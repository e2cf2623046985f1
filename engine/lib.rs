#![doc = include_str!("../README.md")]
//!
//! ## Versions
//!
//! The version of this crate follows its items and those of its modules. The crates that they come from promise nothing by themselves, so a program
//! depends on `raxel` alone.

pub use raxel_diagnostics::{Diagnostic, SourceMap, render};
pub use raxel_execute::{FrameReport, PassTime, Picture, ReadTicket, SwapReport, Texels};
pub use raxel_graph::checked::Value;
pub use raxel_runtime::camera::Camera;
pub use raxel_runtime::debug_target::DebugTarget;
pub use raxel_runtime::present::Presenter;
pub use raxel_runtime::project::Project;
pub use raxel_runtime::reload::ReloadEvent;
pub use raxel_runtime::session::Validation;
pub use raxel_runtime::{EditFailure, FrameError, Observe, OpenError, Options, ReadError, Saves, Session};

/// Compiled shaders and pipelines, kept from one run to the next.
pub use raxel_cache as cache;
/// Edits of worlds, queries of voxels, saves.
pub use raxel_edit as edit;
/// Runs plans on a device: reports of frames, read-back, exact times.
pub use raxel_execute as execute;
/// Generators of voxels: operations, land, scattered models.
pub use raxel_generate as generate;
/// Checked graphs and their plans.
pub use raxel_graph as graph;
/// Graph files: TOML and shaders in, a checked graph out.
pub use raxel_graphfile as graphfile;
/// GPU encodings of voxel worlds.
pub use raxel_layouts as layouts;
/// Benchmarks: bench, stress and light, run time against error.
pub use raxel_measure as measure;
/// The exact tracer and the error metrics.
pub use raxel_oracle as oracle;
/// Writes pictures, frames and films of a session, as `raxel render` does.
pub use raxel_output as output;
/// Rays through voxels, as [`Session::cast`] takes them.
pub use raxel_ray as ray;
/// Layouts of other renderers, to compare with.
pub use raxel_rivals as rivals;
/// Sessions: the items above, and everything else of them.
pub use raxel_runtime as runtime;
/// The shader compiler and its interfaces.
pub use raxel_shader as shader;
/// Streamed worlds: tiles around a camera, in a pool on the device.
pub use raxel_stream as stream;
/// Voxels: chunks, materials, tiles, `.vox` models.
pub use raxel_world as world;
/// World files: TOML in, voxels or a generator out.
pub use raxel_worldfile as worldfile;

/// The Vulkan types for a program with a session: the devices of the machine, the open device, messages of the validation layer, and errors.
/// [`Presenter`] shows pictures in your window, under the triangles of an [`OverlayFrame`](gpu::OverlayFrame).
///
/// Commands, barriers, memory and descriptors are not public, because their callers must order the accesses of the device. Only the executor,
/// which follows a plan, and code that raxel's own tests check call them:
///
/// ```compile_fail
/// use raxel::gpu::CommandBuffer;
/// ```
pub mod gpu {
    #[cfg(target_os = "linux")]
    pub use raxel_gpu::on_lost_x_server;
    pub use raxel_gpu::{
        Candidate, Capabilities, Device, DeviceKind, DeviceOptions, Error, Message, OverlayFrame, OverlayMesh,
        OverlayVertex, Packets, PipelineCounts, Presented, Result, Severity, TexturePatch, TimelineValue, Validation,
        ValidationLog, Verdict, Version, choose, has_abandoned_device,
    };
}

/// The example of the page about edits is compiled.
#[cfg(doctest)]
#[doc = include_str!("../docs/edits.md")]
pub struct PageAboutEdits;

#![doc = include_str!("../README.md")]

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
/// Edits of worlds, queries, saves.
pub use raxel_edit as edit;
/// What a session is executed with: reports of frames, read-back, times without rounding.
pub use raxel_execute as execute;
/// What builds voxels: operations, land, scattered models.
pub use raxel_generate as generate;
/// From a checked graph to its plan.
pub use raxel_graph as graph;
/// Graph files: TOML and shaders in, a checked graph out.
pub use raxel_graphfile as graphfile;
/// GPU encodings of voxel worlds.
pub use raxel_layouts as layouts;
/// Bench and stress: run time against error.
pub use raxel_measure as measure;
/// The exact tracer and the error metrics.
pub use raxel_oracle as oracle;
/// Pictures, frames and films: what `raxel render` writes, from a session of yours.
pub use raxel_output as output;
/// Rays through voxels, as [`Session::cast`] takes them.
pub use raxel_ray as ray;
pub use raxel_rivals as rivals;
/// Everything of a session that is not re-exported here.
pub use raxel_runtime as runtime;
/// The shader compiler and its interfaces.
pub use raxel_shader as shader;
/// Worlds that are loaded around a camera.
pub use raxel_stream as stream;
/// Voxels.
pub use raxel_world as world;
/// World files.
pub use raxel_worldfile as worldfile;

/// Vulkan, as far as a program with a session of its own meets it: the devices there are, the one that is open, messages of the validation
/// layer, and errors. [`Presenter`] shows pictures in a window of yours, under the triangles of an [`OverlayFrame`](gpu::OverlayFrame).
///
/// Commands, barriers, memory and descriptors are not public. They leave the order of the device's accesses to their caller, and the only
/// callers are the executor, which follows a plan, and the code that raxel's own tests check:
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
        ValidationLog, Verdict, choose, has_abandoned_device,
    };
}

/// The example of the page about edits is compiled.
#[cfg(doctest)]
#[doc = include_str!("../docs/edits.md")]
pub struct PageAboutEdits;

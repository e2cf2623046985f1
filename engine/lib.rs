#![doc = include_str!("../README.md")]
//!
//! ## Versions
//!
//! The version of this crate follows its items and those of its modules. The crates that they come from promise nothing by themselves, so a program
//! depends on `raxel` alone. A few methods return types that this crate does not name, such as plans. raxel's own programs use these methods, and
//! they may change in any release.

pub use raxel_diagnostics::{Diagnostic, Severity, SourceMap, render};
pub use raxel_execute::{FrameReport, PassTime, Picture, ReadTicket, SwapReport, Texels};
pub use raxel_graph::checked::Value;
pub use raxel_layouts::Layout;
pub use raxel_runtime::camera::Camera;
pub use raxel_runtime::debug_target::DebugTarget;
pub use raxel_runtime::present::{PresentError, Presenter, Viewport};
pub use raxel_runtime::project::Project;
pub use raxel_runtime::reload::ReloadEvent;
pub use raxel_runtime::session::Validation;
pub use raxel_runtime::{
    EditFailure, FrameError, ManifestDefaults, Observe, OpenError, Options, ReadError, Saves, Session,
};

/// Compiled shaders and pipelines, kept from one run to the next.
pub use raxel_cache as cache;
/// Writes pictures, frames and films of a session, as `raxel render` does.
pub use raxel_output as output;
/// Voxels: chunks, materials, `.vox` models.
pub use raxel_world as world;

/// Edits of a session's world, and queries of its voxels.
pub mod edit {
    pub use raxel_edit::{
        Base, Brush, EditError, EditModel, MOST_CHUNKS, MOST_RADIUS, Operation, Scene, Steps, UNIT, fixed, query,
    };
}

/// What a session reports of its frames, and what it is told for them.
///
/// The executor itself is not public, because a program could break the plans that it follows:
///
/// ```compile_fail
/// use raxel::execute::Executor;
/// ```
pub mod execute {
    pub use raxel_execute::moment::{Fraction, Moment};
    pub use raxel_execute::{
        Assertion, Captured, Comparison, ExecuteError, ExternalResource, FramePicture, GpuTimes, InvocationWrite,
        Mismatch, PassOutcome, PassPrints, PassWrites, PrintedLine, Progress, Reference, ReferenceValues, Region,
        TexelTrace, TexelWrite, Thumbnail, TracedTexel, WriteError,
    };
    pub use raxel_graph::checked::{Display, Param};
    pub use raxel_runtime::clock::Clock;
    pub use raxel_runtime::debug_target::DebugTargetError;
    pub use raxel_runtime::inputs::Inputs;
    pub use raxel_runtime::params::SetError;
    pub use raxel_runtime::take::TakeError;
}

/// Edits of files while a session runs.
pub mod reload {
    pub use raxel_runtime::reload::{Failed, ProjectFile, Rebuilt, Reloaded, Stages, Waker};
}

/// Rays through voxels, as [`Session::cast`] takes them.
pub mod ray {
    pub use raxel_ray::{FACE_INSIDE, FAR, Hit, Ray};
}

/// The compiler of shaders in a child process, so that no shader can end the program.
pub mod shader {
    pub use raxel_shader::worker;
}

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
        OverlayVertex, Packets, PipelineCounts, Place, Presented, Result, Severity, TexturePatch, TimelineValue,
        Validation, ValidationLog, Verdict, Version, choose, has_abandoned_device,
    };
}

/// The example of the page about edits is compiled.
#[cfg(doctest)]
#[doc = include_str!("../docs/edits.md")]
pub struct PageAboutEdits;

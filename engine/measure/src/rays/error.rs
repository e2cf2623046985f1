//! Errors on the way to a list of hits.

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_edit::EditError;
use raxel_layouts::LayoutError;
use raxel_stream::StreamError;

/// Why rays cannot be traced.
#[derive(Debug, thiserror::Error)]
pub enum RayError {
    /// The tracer does not compile: a project's `shaders/include/raxel` overrides a part of it.
    #[error("the tracer does not compile: {}", .diagnostics.first().map_or("", |d| d.message.as_str()))]
    Shader {
        /// Everything found.
        diagnostics: Vec<Diagnostic>,
        /// The texts that they point into.
        texts: SourceMap,
    },
    /// The tracer binds something that no world has.
    #[error("the tracer binds `{name}`, which {why}")]
    Binding {
        /// GLSL name.
        name: String,
        /// The reason.
        why: &'static str,
    },
    /// The world does not fit the layout.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// The world cannot be streamed whole; the reason.
    #[error("{0}")]
    NotStreamed(String),
    /// The streamer of a world that is edited.
    #[error("the world is not streamed: {0}")]
    Stream(#[from] StreamError),
    /// An edit of a world that is streamed.
    #[error("the world is not edited: {0}")]
    Edit(#[from] EditError),
    /// The driver or the device.
    #[error(transparent)]
    Gpu(#[from] raxel_gpu::Error),
}

impl RayError {
    /// Whether the tracer never runs on this device, in any world: it binds something that no world has or more than the device can, or
    /// needs a feature that the device lacks.
    pub(crate) fn is_of_tracer(&self) -> bool {
        use raxel_gpu::Error::{CapabilityMissing, TooManyBindings};
        matches!(self, Self::Binding { .. } | Self::Gpu(CapabilityMissing { .. } | TooManyBindings { .. }))
    }
}

//! Errors of preparing or running a plan.

/// A pass that the device had begun and not finished.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suspect {
    /// Its name; a round of a loop has its number.
    pub pass: String,
    /// The name of the pass of the file.
    pub declared: String,
    /// Its declaration in the files when it was planned, as [`raxel_graph::checked::Graph::declaration`] gives it. The files may have been edited since.
    pub declaration: String,
}

/// An error of the executor.
#[derive(Debug, thiserror::Error)]
pub enum ExecuteError {
    /// The driver or the device.
    #[error(transparent)]
    Gpu(raxel_gpu::Error),
    /// The device is gone or hangs. Nothing more can be run on it: open another [`raxel_gpu::Device`] and a new executor.
    #[error("the device {}{}", if *.timed_out { "did not finish in time" } else { "was lost" }, suspect_text(.suspect.as_ref()))]
    DeviceLost {
        /// The first pass that had begun and not finished, by the crash markers; `None` when there was none, or nothing is known.
        suspect: Option<Suspect>,
        /// The watchdog gave up, rather than the driver.
        timed_out: bool,
    },
    /// A buffer source that is not supplied.
    #[error("nothing supplies `{source_name}`, which buffer `{buffer}` needs")]
    MissingSource {
        /// Name of the buffer.
        buffer: String,
        /// Name of the source.
        source_name: String,
    },
    /// The device cannot make a target of this format with the usages it needs.
    #[error("the device cannot use format `{format}` for target `{target}` as {usage}")]
    Format {
        /// Name of the target.
        target: String,
        /// GLSL name of the format.
        format: &'static str,
        /// The usage of the target.
        usage: String,
    },
    /// A pass needs something the device does not have.
    #[error("the device lacks {lacks}, which the shader of pass `{pass}` needs")]
    Capability {
        /// Name of the pass.
        pass: String,
        /// The missing capability.
        lacks: String,
    },
    /// Nothing was swapped in yet.
    #[error("nothing runs yet: the first frame makes a plan")]
    NoPlan,
    /// No frame has left anything in the resource yet.
    #[error("`{resource}` holds nothing yet; run a frame first")]
    NoFrame {
        /// Name of the resource.
        resource: String,
    },
    /// The resource does not exist in the running plan: nothing presented depends on it.
    #[error("`{resource}` is not part of the running plan; present or pin it to read it from the next frame on")]
    NotLive {
        /// Name of the resource.
        resource: String,
    },
    /// A pass that writes the resource was culled, so it does not hold the graph's result.
    #[error(
        "pass `{pass}`, which writes `{resource}`, was culled, since nothing shown depends on it; present or pin `{resource}` to \
         read it from the next frame on"
    )]
    CulledWriter {
        /// Name of the resource.
        resource: String,
        /// Name of the pass.
        pass: String,
    },
    /// The resource lives within a frame: at the end, its memory may be another's.
    #[error("`{resource}` lives within a frame only; present or pin it to read it from the next frame on")]
    NotKept {
        /// Name of the resource.
        resource: String,
    },
    /// A part of a resource that it does not have.
    #[error("`{resource}` has no {part}")]
    OutOfRange {
        /// Name of the resource.
        resource: String,
        /// The requested part, and the existing one.
        part: String,
    },
    /// The shader that shows the debug target failed to compile.
    #[error("the display shader failed to compile: {0}")]
    Display(String),
}

impl From<raxel_gpu::Error> for ExecuteError {
    fn from(error: raxel_gpu::Error) -> Self {
        match error {
            raxel_gpu::Error::DeviceLost => ExecuteError::DeviceLost { suspect: None, timed_out: false },
            raxel_gpu::Error::TimedOut { .. } => ExecuteError::DeviceLost { suspect: None, timed_out: true },
            error => ExecuteError::Gpu(error),
        }
    }
}

fn suspect_text(suspect: Option<&Suspect>) -> String {
    suspect.map(|suspect| format!("; pass `{}` had begun and not finished", suspect.pass)).unwrap_or_default()
}

//! Why a picture cannot be shown.

/// Why a picture cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum PresentError {
    /// The driver, the device or the window system failed.
    #[error(transparent)]
    Gpu(#[from] raxel_gpu::Error),
    /// The shaders of the overlay do not compile: a bug in raxel.
    #[error("the overlay's shader does not compile: {0}")]
    Shader(String),
}

impl PresentError {
    /// Whether the device is lost. The next frame of the session opens another device, which needs a new presenter.
    pub fn is_device_lost(&self) -> bool {
        matches!(self, Self::Gpu(raxel_gpu::Error::DeviceLost | raxel_gpu::Error::TimedOut { .. }))
    }
}

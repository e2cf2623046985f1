//! One frame as RenderDoc sees it.

use std::path::PathBuf;

use raxel_execute::FrameReport;
use raxel_gpu::RenderDoc;

use super::{FrameError, Session};

/// Why a frame was not captured.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// This process does not run under RenderDoc.
    #[error(
        "this process does not run under RenderDoc; start it by RenderDoc's `Launch Application`, or by `renderdoccmd capture`"
    )]
    NotUnderRenderDoc,
    /// RenderDoc made no capture.
    #[error("RenderDoc made no capture of the frame")]
    NotMade,
    /// The frame did not run.
    #[error(transparent)]
    Frame(#[from] FrameError),
}

impl Session {
    /// Runs the next frame and captures it with the RenderDoc that this process runs under. Returns the report of the frame and the file of
    /// the capture. No pass is skipped: every pass that is due runs, even if its inputs did not change.
    pub fn capture_frame(&mut self) -> Result<(FrameReport, PathBuf), CaptureError> {
        let renderdoc = RenderDoc::find().ok_or(CaptureError::NotUnderRenderDoc)?;
        self.renderer.executor.set_memo(false);
        let (report, file) = renderdoc.capture(|| self.frame());
        self.renderer.executor.set_memo(self.options.memo);
        Ok((report?, file.ok_or(CaptureError::NotMade)?))
    }
}

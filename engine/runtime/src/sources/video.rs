//! Videos that play: a thread decodes ahead, and each frame of the session takes what its time asks for.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::time::Duration;

use raxel_diagnostics::{Diagnostic, codes};
use raxel_execute::ExternalResource;
use raxel_graph::{FileImage, Video};

use super::file::video::{Frames, frame};

/// Frames that are decoded before they are asked for.
const AHEAD: usize = 3;

/// How long a frame is waited for, where every frame has to be right.
const PATIENCE: Duration = Duration::from_secs(30);

/// A video that plays into a source.
#[derive(Debug)]
pub(super) struct Player {
    video: Video,
    /// What decodes; `None` before the first frame that is not the one that the source began with, and after a failure.
    decoded: Option<Receiver<FileImage>>,
    /// The number of the next frame that arrives.
    next: u64,
    /// The number of the frame that the source holds.
    shown: u64,
    /// A frame that found no room in what the next frame uploads.
    unwritten: Option<(u64, FileImage)>,
    ended: bool,
    failed: Option<String>,
}

impl Player {
    /// The source holds the first frame.
    pub(super) fn new(video: &Video) -> Self {
        let video = video.clone();
        Self { video, decoded: None, next: 0, shown: 0, unwritten: None, ended: false, failed: None }
    }

    /// Brings the frame of a time into the source, before the next frame of the session; `waits` until it is decoded, or takes the newest that
    /// is there. At its end, the video begins again.
    pub(super) fn follow(&mut self, seconds: f64, waits: bool, source: &Arc<ExternalResource>) {
        let wanted = self.frame_at(seconds);
        if wanted != self.shown || self.unwritten.is_some() {
            self.decode_to(wanted, waits);
        }
        if let Some((number, image)) = self.unwritten.take() {
            let mips = image.mips.iter().zip(0..);
            let side = |side: u32, mip: u32| (side >> mip).max(1);
            let written = mips.map(|(bytes, mip)| {
                let [width, height, depth] = image.extent;
                let depth = if image.volume { side(depth, mip) } else { 1 };
                source.write_texels(mip, [0; 3], [side(width, mip), side(height, mip), depth], bytes)
            });
            // Where too much waits already, the next frame tries again.
            match written.collect::<Result<Vec<()>, _>>() {
                Ok(_) => self.shown = number,
                Err(_) => self.unwritten = Some((number, image)),
            }
        }
    }

    /// The number of the frame that is shown at a time.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the remainder is below the number of frames"
    )]
    fn frame_at(&self, seconds: f64) -> u64 {
        // A frame begins at its time, whatever the product rounds to.
        let frame = (seconds.max(0.0) * self.video.rate + 1e-6).floor();
        (frame % self.video.frames as f64) as u64
    }

    fn decode_to(&mut self, wanted: u64, waits: bool) {
        if self.failed.is_some() {
            return;
        }
        if wanted < self.next.saturating_sub(1) || (self.decoded.is_none() && !self.ended) {
            self.start();
        }
        while self.next <= wanted && !self.ended {
            let Some(decoded) = &self.decoded else { return };
            let image = if waits {
                decoded.recv_timeout(PATIENCE).ok()
            } else {
                match decoded.try_recv() {
                    Err(TryRecvError::Empty) => return,
                    image => image.ok(),
                }
            };
            let Some(image) = image else {
                // It has fewer frames than its file says: the last one stays.
                self.ended = true;
                if self.next == 0 {
                    self.failed = Some(format!("`{}` can no longer be decoded", self.video.path));
                }
                return;
            };
            self.unwritten = Some((self.next, image));
            self.next += 1;
        }
    }

    /// Decodes from the beginning.
    fn start(&mut self) {
        let (sender, decoded) = sync_channel(AHEAD);
        let video = self.video.clone();
        (self.next, self.ended, self.decoded) = (0, false, Some(decoded));
        let decode = move || {
            let Ok(mut frames) = Frames::decode(&video) else { return };
            while let Ok(Some(rgba)) = frames.next() {
                let Ok(image) = frame(&video, rgba) else { return };
                // Nobody listens once another beginning was made, or the video is gone.
                if sender.send(image).is_err() {
                    return;
                }
            }
        };
        if let Err(error) = std::thread::Builder::new().name("raxel-video".to_owned()).spawn(decode) {
            self.failed = Some(format!("`{}` cannot be played: {error}", self.video.path));
        }
    }

    /// The number of the frame that is shown.
    pub(super) fn shown(&self) -> u64 {
        self.shown
    }

    /// What has gone wrong since the last call.
    pub(super) fn take_problem(&mut self) -> Option<Diagnostic> {
        let message = self.failed.as_mut().filter(|message| !message.is_empty()).map(std::mem::take)?;
        Some(Diagnostic::warning(codes::graph::FILE_SOURCE, message).note("the last frame stays"))
    }
}

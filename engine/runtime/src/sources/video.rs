//! Videos that play: a thread decodes ahead, and each frame of the session takes the video's frame of its time.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, sync_channel};
use std::time::Duration;

use raxel_diagnostics::{Diagnostic, codes};
use raxel_execute::ExternalResource;
use raxel_graph::{FileImage, Video};
use raxel_media::video::{Frames, frame};

use super::on_device::write_image;

/// Frames that are decoded before they are asked for.
const AHEAD: usize = 3;

/// The longest wait for a frame, if every frame has to be right.
const PATIENCE: Duration = Duration::from_secs(30);

/// A video that plays into a source.
#[derive(Debug)]
pub(super) struct Player {
    video: Video,
    /// The decoder; `None` before the first frame that is not the one that the source began with, and after a failure.
    decoded: Option<Receiver<FileImage>>,
    /// The number of the next frame that arrives.
    next: u64,
    /// The number of the frame that the source holds.
    shown: u64,
    /// A frame that found no room in the uploads of the next frame.
    unwritten: Option<(u64, FileImage)>,
    ended: bool,
    /// Nothing more is decoded.
    failed: bool,
    /// It was reported that there are fewer frames than the file claims.
    short: bool,
    /// An error that was not reported yet.
    problem: Option<String>,
}

impl Player {
    /// The source holds the first frame.
    pub(super) fn new(video: &Video) -> Self {
        let video = video.clone();
        Self {
            video,
            decoded: None,
            next: 0,
            shown: 0,
            unwritten: None,
            ended: false,
            failed: false,
            short: false,
            problem: None,
        }
    }

    /// Brings the frame of a time into the source, before the next frame of the session; `waits` until it is decoded, or takes the newest that
    /// is there. At its end, the video begins again.
    pub(super) fn follow(&mut self, seconds: f64, waits: bool, source: &Arc<ExternalResource>) {
        let wanted = self.frame_at(seconds);
        if wanted != self.shown || self.unwritten.is_some() {
            self.decode_to(wanted, waits);
        }
        if let Some((number, image)) = self.unwritten.take() {
            // If too many writes wait already, the next frame tries again.
            if write_image(&image, source) {
                self.shown = number;
            } else {
                self.unwritten = Some((number, image));
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
        // A frame begins at its time, even if the product is rounded down.
        let frame = (seconds.max(0.0) * self.video.rate + 1e-6).floor();
        (frame % self.video.frames as f64) as u64
    }

    fn decode_to(&mut self, wanted: u64, waits: bool) {
        if self.failed {
            return;
        }
        if wanted < self.next.saturating_sub(1) || (self.decoded.is_none() && !self.ended) {
            self.start();
        }
        while self.next <= wanted && !self.ended && !self.failed {
            let Some(decoded) = &self.decoded else { return };
            let received = if waits {
                decoded.recv_timeout(PATIENCE).map_err(|error| error == RecvTimeoutError::Timeout)
            } else {
                match decoded.try_recv() {
                    Err(TryRecvError::Empty) => return,
                    received => received.map_err(|_| false),
                }
            };
            let image = match received {
                Ok(image) => image,
                Err(true) => {
                    let seconds = PATIENCE.as_secs();
                    return self.fail(format!("`{}` brought no frame within {seconds} s", self.video.path));
                }
                Err(false) => return self.end(),
            };
            self.unwritten = Some((self.next, image));
            self.next += 1;
        }
    }

    /// No frame follows. The file's number of them may be wrong.
    fn end(&mut self) {
        self.ended = true;
        let Video { path, frames, .. } = &self.video;
        if self.next == 0 {
            let message = format!("`{path}` can no longer be decoded");
            self.fail(message);
        } else if !std::mem::replace(&mut self.short, true) {
            self.problem = Some(format!("`{path}` ends after {} of {frames} frames", self.next));
        }
    }

    fn fail(&mut self, message: String) {
        self.failed = true;
        self.problem = Some(message);
    }

    /// Decodes from the beginning.
    fn start(&mut self) {
        let (sender, decoded) = sync_channel(AHEAD);
        let video = self.video.clone();
        (self.next, self.ended, self.decoded) = (0, false, Some(decoded));
        let decode = move || {
            let Ok(mut frames) = Frames::decode(&video) else { return };
            while let Ok(Some(rgba)) = frames.next_frame() {
                let Ok(image) = frame(&video, rgba) else { return };
                // The receiver is gone once another beginning was made, or the video is gone.
                if sender.send(image).is_err() {
                    return;
                }
            }
        };
        if let Err(error) = std::thread::Builder::new().name("raxel-video".to_owned()).spawn(decode) {
            self.fail(format!("`{}` cannot be played: {error}", self.video.path));
        }
    }

    /// The number of the frame that is shown.
    pub(super) fn shown(&self) -> u64 {
        self.shown
    }

    /// The error since the last call.
    pub(super) fn take_problem(&mut self) -> Option<Diagnostic> {
        let message = self.problem.take()?;
        Some(Diagnostic::warning(codes::graph::FILE_SOURCE, message).note("the last frame stays"))
    }
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use raxel_graph::ImageRequest;

    use super::*;

    /// Three frames, of a file that claims five.
    fn short(folder: &tempfile::TempDir) -> Player {
        let disk = folder.path().join("a.mkv");
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args([
            "-v",
            "error",
            "-f",
            "lavfi",
            "-i",
            "color=red:size=8x4:rate=10",
            "-frames:v",
            "3",
            "-c:v",
            "png",
        ]);
        assert!(ffmpeg.arg(&disk).status().expect("ffmpeg is installed").success());
        let request = ImageRequest { format: None, mips: 1, slices: None, srgb: false };
        Player::new(&Video { path: "a.mkv".to_owned(), disk, extent: [8, 4], rate: 10.0, frames: 5, request })
    }

    #[test]
    fn a_video_that_ends_too_early_says_so_once_and_keeps_its_last_frame() {
        let folder = tempfile::tempdir().unwrap();
        let mut player = short(&folder);
        player.decode_to(2, true);
        assert!(player.take_problem().is_none());
        for _ in 0..2 {
            player.decode_to(4, true);
        }
        assert_eq!(player.unwritten.as_ref().map(|(number, _)| *number), Some(2));
        assert_eq!(player.take_problem().unwrap().message, "`a.mkv` ends after 3 of 5 frames");
        // At the next turn as well it ends too early.
        player.decode_to(0, true);
        player.decode_to(4, true);
        assert!(player.take_problem().is_none());
    }

    #[test]
    fn a_video_that_is_gone_says_so_and_is_not_decoded_again() {
        let folder = tempfile::tempdir().unwrap();
        let mut player = short(&folder);
        std::fs::remove_file(&player.video.disk).unwrap();
        player.decode_to(1, true);
        assert_eq!(player.take_problem().unwrap().message, "`a.mkv` can no longer be decoded");
        player.decode_to(2, true);
        assert!(player.take_problem().is_none() && player.unwritten.is_none());
    }
}

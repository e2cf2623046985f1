//! A film: frames piped as they are into ffmpeg, which is found on the path and started with nothing that a file says.

use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use raxel_runtime::execute::Picture;

use super::Pending;
use crate::failure::{Exit, Failure, Result};

/// Extensions that make `-o` a film.
pub(crate) const EXTENSIONS: &[&str] = &["mp4", "mkv", "mov", "webm", "gif"];

/// A running ffmpeg.
#[derive(Debug)]
pub(crate) struct Film {
    ffmpeg: Child,
    /// `None` once the film is in place.
    pending: Option<Pending>,
}

/// Whether ffmpeg can be started, and its version.
pub(crate) fn version() -> Option<String> {
    let output = Command::new("ffmpeg").arg("-version").stdin(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().next()?;
    Some(line.split_whitespace().nth(2).unwrap_or(line).to_owned())
}

impl Film {
    /// Starts ffmpeg for frames of a size and a rate (frames a second). Whether the file can be written is said here.
    pub fn start(path: &Path, size: [u32; 2], rate: f64) -> Result<Self> {
        let pending = Pending::new(path)?;
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let mut command = Command::new("ffmpeg");
        command
            .args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgba"])
            .args(["-s", &format!("{}x{}", size[0], size[1]), "-r", &rate.to_string(), "-i", "-"])
            // No dates or versions in the file: equal frames give equal bytes.
            .args(["-fflags", "+bitexact", "-flags:v", "+bitexact"]);
        match extension.as_str() {
            "gif" => command.args(["-vf", "split[a][b];[a]palettegen[p];[b][p]paletteuse"]),
            // Chroma is halved: both sides must be even.
            "webm" => {
                command.args(["-vf", EVEN, "-pix_fmt", "yuv420p", "-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0"])
            }
            _ => command.args([
                "-vf",
                EVEN,
                "-pix_fmt",
                "yuv420p",
                "-c:v",
                "libx264",
                "-crf",
                "18",
                "-movflags",
                "+faststart",
            ]),
        };
        let spawned =
            command.arg(pending.temporary()).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
        let ffmpeg = spawned.map_err(|error| match error.kind() {
            ErrorKind::NotFound => Failure::usage(format!("`{}` needs ffmpeg, which is not installed", path.display()))
                .help("apt-get install ffmpeg, or write numbered frames: -o frames/%04d.png"),
            _ => Failure::usage(format!("ffmpeg cannot be started: {error}")),
        })?;
        Ok(Self { ffmpeg, pending: Some(pending) })
    }

    /// Adds a frame.
    pub fn frame(&mut self, picture: &Picture) -> Result {
        let Some(pipe) = self.ffmpeg.stdin.as_mut() else { return Ok(()) };
        if pipe.write_all(&picture.rgba).is_err() {
            // It has stopped reading: it says why on its stderr.
            return Err(self.failure());
        }
        Ok(())
    }

    /// Waits for ffmpeg and puts the film in place.
    pub fn finish(mut self) -> Result {
        drop(self.ffmpeg.stdin.take());
        match self.ffmpeg.wait() {
            Ok(status) if status.success() => self.pending.take().map_or(Ok(()), Pending::rename),
            _ => Err(self.failure()),
        }
    }

    fn failure(&mut self) -> Failure {
        drop(self.ffmpeg.stdin.take());
        let mut said = String::new();
        if let Some(stderr) = self.ffmpeg.stderr.as_mut() {
            let _ = std::io::Read::read_to_string(stderr, &mut said);
        }
        let _ = self.ffmpeg.wait();
        Failure::new(Exit::Usage, format!("ffmpeg gave up: {}", said.trim().replace('\n', "; ")))
    }
}

impl Drop for Film {
    fn drop(&mut self) {
        // Given up before its end: ffmpeg must not finish half a film.
        if self.pending.is_some() {
            let _ = self.ffmpeg.kill();
            let _ = self.ffmpeg.wait();
        }
    }
}

const EVEN: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2";

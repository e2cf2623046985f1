//! A film: frames piped as they are into ffmpeg, which is found on the path and started without any argument from a file.

use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::Pending;
use super::leftovers::{Listed, on_stop};
use crate::error::{OutputError, Result};

/// Extensions that make `-o` a film.
pub(crate) const EXTENSIONS: &[&str] = &["mp4", "mkv", "mov", "webm", "gif"];

/// A running ffmpeg.
#[derive(Debug)]
pub struct Film {
    ffmpeg: Arc<Mutex<Child>>,
    frames: Option<ChildStdin>,
    /// `None` once the film is in place.
    pending: Option<Pending>,
    _listed: Listed,
}

/// Whether ffmpeg can be started, and its version.
pub fn version() -> Option<String> {
    let output = Command::new("ffmpeg").arg("-version").stdin(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().next()?;
    Some(line.split_whitespace().nth(2).unwrap_or(line).to_owned())
}

impl Film {
    /// Starts ffmpeg for frames of a size and a rate (frames a second). An error has the reason why the file cannot be written.
    pub fn start(path: &Path, size: [u32; 2], rate: f64) -> Result<Self> {
        let pending = Pending::new(path)?;
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let mut command = Command::new("ffmpeg");
        command
            // Without -xerror a disk that is full is no error for some containers.
            .args(["-hide_banner", "-loglevel", "error", "-xerror", "-y", "-f", "rawvideo", "-pix_fmt", "rgba"])
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
        let mut ffmpeg = spawned.map_err(|error| match error.kind() {
            ErrorKind::NotFound => {
                OutputError::new(format!("`{}` needs ffmpeg, which is not installed", path.display()))
                    .help("apt-get install ffmpeg, or write numbered frames: -o frames/%04d.png")
            }
            _ => OutputError::new(format!("ffmpeg cannot be started: {error}")),
        })?;
        let frames = ffmpeg.stdin.take();
        let ffmpeg = Arc::new(Mutex::new(ffmpeg));
        let other = ffmpeg.clone();
        // Left alone, it would finish half a film. When the caller waits for it, it is at its end anyway.
        let listed = on_stop(move || {
            if let Ok(mut ffmpeg) = other.try_lock() {
                let _ = ffmpeg.kill();
            }
        });
        Ok(Self { ffmpeg, frames, pending: Some(pending), _listed: listed })
    }

    /// Adds a frame: width × height × 4 bytes, red, green, blue, alpha.
    pub fn frame(&mut self, rgba: &[u8]) -> Result {
        let Some(pipe) = &mut self.frames else { return Ok(()) };
        if pipe.write_all(rgba).is_err() {
            // It has stopped reading: the reason is on its stderr.
            return Err(self.failure());
        }
        Ok(())
    }

    /// Waits for ffmpeg and puts the film in place.
    pub fn finish(mut self) -> Result {
        drop(self.frames.take());
        let ended = self.child().wait();
        match ended {
            Ok(status) if status.success() => self.pending.take().map_or(Ok(()), Pending::rename),
            _ => Err(self.failure()),
        }
    }

    fn child(&self) -> MutexGuard<'_, Child> {
        self.ffmpeg.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn failure(&mut self) -> OutputError {
        drop(self.frames.take());
        let mut said = String::new();
        let mut ffmpeg = self.child();
        if let Some(stderr) = ffmpeg.stderr.as_mut() {
            let _ = stderr.read_to_string(&mut said);
        }
        let _ = ffmpeg.wait();
        OutputError { ffmpeg: true, ..OutputError::new(format!("ffmpeg gave up: {}", said.trim().replace('\n', "; "))) }
    }
}

impl Drop for Film {
    fn drop(&mut self) {
        // Given up before its end: ffmpeg must not finish half a film.
        if self.pending.is_some() {
            let mut ffmpeg = self.child();
            let _ = ffmpeg.kill();
            let _ = ffmpeg.wait();
        }
    }
}

const EVEN: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2";

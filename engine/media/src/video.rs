//! Video files: ffprobe's description of them, and a process that decodes their frames.

use std::io::{ErrorKind, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use raxel_graph::{Plays, Video};

use crate::ffmpeg::{LOCAL, ends_in, missing, probe as probe_stream};
use crate::texels::Channel;
use crate::{FileImage, Picture, Refusal, check_extent, refused, shape};

/// Names that end so are videos.
const EXTENSIONS: [&str; 6] = ["mp4", "mkv", "mov", "webm", "avi", "gif"];

/// Frames that a video has at most.
const MOST_FRAMES: u64 = 1 << 24;

/// Whether a file is a video, by its name.
pub(crate) fn is_video(path: &str) -> bool {
    ends_in(path, &EXTENSIONS)
}

/// A video with its first frame. `disk` is where the file lies.
pub(crate) fn open(path: &str, disk: &Path, request: &raxel_graph::ImageRequest) -> Result<FileImage, Refusal> {
    let cannot = |reason: String| refused("source", format!("`{path}` cannot be read: {reason}"));
    let (extent, rate, frames) = probe(disk).map_err(cannot)?;
    let video = Video { path: path.to_owned(), disk: disk.to_owned(), extent, rate, frames, request: request.clone() };
    let mut frames = Frames::decode(&video).map_err(cannot)?;
    let first = frames.next_frame().map_err(cannot)?;
    let Some(first) = first else { return Err(cannot("no frame of it can be decoded".to_owned())) };
    let image = frame(&video, first)?;
    Ok(FileImage { plays: Some(Plays::Video(video)), ..image })
}

/// A frame as the graph wants it: bytes of red, green, blue and alpha.
pub fn frame(video: &Video, rgba: Vec<u8>) -> Result<FileImage, Refusal> {
    let picture = Picture { extent: video.extent, channel: Channel::Unorm8, channels: 4, bytes: rgba };
    shape(&video.path, &picture, &video.request)
}

/// Extent, frames a second, and how many.
fn probe(disk: &Path) -> Result<([u32; 2], f64, u64), String> {
    let entries = "stream=width,height,avg_frame_rate,nb_read_packets";
    let said = probe_stream(disk, "v:0", &["-count_packets"], entries)?;
    let value = |key: &str| said.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
    let number = |key: &str| value(key).and_then(|value| value.trim().parse::<u64>().ok());
    let (Some(width), Some(height)) = (number("width"), number("height")) else {
        return Err("it has no video".to_owned());
    };
    let extent = check_extent(width, height, 4)?;
    let rate = value("avg_frame_rate").and_then(|rate| {
        let (frames, seconds) = rate.trim().split_once('/')?;
        let rate = frames.parse::<f64>().ok()? / seconds.parse::<f64>().ok()?;
        (0.001..=1000.0).contains(&rate).then_some(rate)
    });
    // A picture that stands still has no rate.
    Ok((extent, rate.unwrap_or(1.0), number("nb_read_packets").unwrap_or(1).clamp(1, MOST_FRAMES)))
}

/// Frames of a video from its beginning, as bytes of red, green, blue and alpha.
pub struct Frames {
    ffmpeg: Child,
    bytes: usize,
}

impl Frames {
    /// Starts ffmpeg. The error says why it does not start.
    pub fn decode(video: &Video) -> Result<Self, String> {
        let mut command = Command::new("ffmpeg");
        command.args(["-hide_banner", "-loglevel", "quiet", "-nostdin", "-noautorotate"]).args(LOCAL);
        command.arg("-i").arg(&video.disk).args(["-map", "0:v:0", "-fps_mode", "passthrough"]);
        command.args(["-f", "rawvideo", "-pix_fmt", "rgba", "-"]);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
        let ffmpeg = command.spawn().map_err(|error| missing("ffmpeg", &error))?;
        let [width, height] = video.extent.map(|side| side as usize);
        Ok(Self { ffmpeg, bytes: width * height * 4 })
    }

    /// The next frame; `None` after the last.
    ///
    /// # Errors
    /// Why the decoder cannot be read.
    pub fn next_frame(&mut self) -> Result<Option<Vec<u8>>, String> {
        let mut frame = vec![0; self.bytes];
        let Some(pipe) = &mut self.ffmpeg.stdout else { return Ok(None) };
        match pipe.read_exact(&mut frame) {
            Ok(()) => Ok(Some(frame)),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(None),
            Err(error) => Err(error.to_string()),
        }
    }
}

impl Drop for Frames {
    fn drop(&mut self) {
        let _ = self.ffmpeg.kill();
        let _ = self.ffmpeg.wait();
    }
}

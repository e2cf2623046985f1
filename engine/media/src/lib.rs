//! Files that targets and buffers are filled from: PNG, OpenEXR, videos and sounds become texels of a target, everything else bytes of a buffer. Decoded
//! contents are kept as long as a graph uses them, so that an edit of something else does not decode them again.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod exr;
mod ffmpeg;
mod mips;
mod png;
pub mod sound;
mod texels;
pub mod video;

use std::sync::{Arc, Mutex, PoisonError, Weak};

use raxel_diagnostics::{FileError, Files, codes, files, quietly};
use raxel_graph::supply::MICROPHONE;
use raxel_graph::{FileContents, FileImage, ImageRequest, Refusal};

use texels::{Channel, linear};

/// Most texels along a side of a picture.
const MOST_SIDE: u32 = 16384;

/// Most bytes of a decoded picture, mips not counted.
const MOST_BYTES: u64 = 256 << 20;

/// Reads files as sources.
#[derive(Debug, Default)]
pub struct FileSources {
    decoded: Mutex<Vec<Decoded>>,
}

#[derive(Debug)]
struct Decoded {
    path: String,
    request: Option<ImageRequest>,
    hash: blake3::Hash,
    contents: Weak<FileContents>,
}

impl FileSources {
    /// The contents of a file; those that are still in use somewhere if the file has not changed.
    pub fn read(
        &self,
        project: &dyn Files,
        path: &str,
        request: Option<&ImageRequest>,
    ) -> Result<Arc<FileContents>, Refusal> {
        let bytes = bytes(project, path, "")?;
        self.kept(path, request, blake3::hash(&bytes), || match request {
            Some(request) if video::is_video(path) || sound::is_sound(path) => {
                let root = project.root().ok_or_else(|| no_disk(path))?;
                let open = if sound::is_sound(path) { sound::open } else { video::open };
                open(path, &root.join(path), request).map(FileContents::Image)
            }
            Some(request) => image(path, &bytes, request).map(FileContents::Image),
            None => buffer(path, &bytes).map(FileContents::Bytes),
        })
    }

    /// The texels of a microphone; the same each time.
    pub fn microphone(&self, request: &ImageRequest) -> Result<Arc<FileContents>, Refusal> {
        self.kept(MICROPHONE, Some(request), blake3::hash(b""), || sound::microphone(request).map(FileContents::Image))
    }

    /// Contents that are still in use somewhere, or new ones.
    fn kept(
        &self,
        path: &str,
        request: Option<&ImageRequest>,
        hash: blake3::Hash,
        open: impl FnOnce() -> Result<FileContents, Refusal>,
    ) -> Result<Arc<FileContents>, Refusal> {
        let known = |entry: &&Decoded| entry.path == path && entry.request.as_ref() == request && entry.hash == hash;
        let lock = || self.decoded.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(contents) = lock().iter().find(known).and_then(|entry| entry.contents.upgrade()) {
            return Ok(contents);
        }
        let contents = Arc::new(open()?);
        let mut decoded = lock();
        decoded.retain(|entry| entry.contents.strong_count() > 0);
        let (path, request) = (path.to_owned(), request.cloned());
        decoded.push(Decoded { path, request, hash, contents: Arc::downgrade(&contents) });
        Ok(contents)
    }
}

/// A picture as it is in its file.
struct Picture {
    extent: [u32; 2],
    /// How a channel is stored in the file, and in `bytes`.
    channel: Channel,
    /// 1, 2, 3 or 4.
    channels: usize,
    /// Rows from the top, channels next to each other.
    bytes: Vec<u8>,
}

/// The bytes of a file. The help for one that is not there names another relative to the folder `from`.
fn bytes(project: &dyn Files, path: &str, from: &str) -> Result<Arc<[u8]>, Refusal> {
    project.read(path).map_err(|error| {
        let found = match error {
            FileError::NotFound => files::not_found(project, path, None, from),
            error => error.diagnostic(path, None),
        };
        Refusal { code: found.code, key: "source", message: found.message, help: found.help.into_iter().next() }
    })
}

fn no_disk(path: &str) -> Refusal {
    refused("source", format!("ffmpeg reads `{path}`, so it must be a file on disk"))
}

fn buffer(path: &str, bytes: &[u8]) -> Result<Vec<u8>, Refusal> {
    if bytes.is_empty() {
        return Err(refused("source", format!("`{path}` is empty, and a buffer has at least 4 bytes")));
    }
    let mut bytes = bytes.to_vec();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    Ok(bytes)
}

/// Whether a target takes a file, by its name: a picture, a video or a sound.
pub fn has_texels(path: &str) -> bool {
    picture_decoder(path).is_some() || video::is_video(path) || sound::is_sound(path)
}

type Decoder = fn(&[u8]) -> Result<Picture, String>;

/// The decoder of a picture, by the name of its file.
fn picture_decoder(path: &str) -> Option<Decoder> {
    match path.rsplit_once('.')?.1.to_ascii_lowercase().as_str() {
        "png" => Some(png::decode),
        "exr" => Some(exr::decode),
        _ => None,
    }
}

fn image(path: &str, bytes: &[u8], request: &ImageRequest) -> Result<FileImage, Refusal> {
    let Some(decode) = picture_decoder(path) else {
        let message = format!("`{path}` is not a picture that raxel reads");
        let help = "a target takes .png, .exr, videos and sounds; a buffer takes any file as bytes".to_owned();
        return Err(Refusal { help: Some(help), ..refused("source", message) });
    };
    // A decoder that panics on a broken file must not end the thread that waits for its repair.
    let decoded = quietly(|| decode(bytes)).unwrap_or_else(|| Err("it is damaged".to_owned()));
    let picture = decoded.map_err(|reason| refused("source", format!("`{path}` cannot be read: {reason}")))?;
    shape(path, &picture, request)
}

/// Brings a picture into the format and the shape that a graph wants.
fn shape(path: &str, picture: &Picture, request: &ImageRequest) -> Result<FileImage, Refusal> {
    let Picture { extent: [width, height], channel: stored, channels: given, .. } = *picture;
    let channels = if given == 3 { 4 } else { given };
    if request.srgb && !matches!(stored, Channel::Unorm8 | Channel::Unorm16) {
        return Err(refused("encoding", format!("`{path}` holds linear light already")));
    }
    let channel = match request.format {
        None if request.srgb => Channel::Half,
        None => stored,
        Some(format) => {
            let channel = Channel::of(format).filter(|to| format.channels() as usize == channels && fits(stored, *to));
            let float = request.srgb && matches!(channel, Some(Channel::Half | Channel::Float));
            match channel {
                Some(channel) if float || !request.srgb => channel,
                _ => return Err(wrong_format(path, picture, request)),
            }
        }
    };
    let (extent, volume) = match request.slices {
        None => ([width, height, 1], false),
        Some(slices) if height.is_multiple_of(slices) => ([width, height / slices, slices], true),
        Some(slices) => {
            let message = format!("`{path}` has {height} rows, which are not {slices} slices of equal height");
            let help = "the slices of a strip lie below each other".to_owned();
            return Err(Refusal { help: Some(help), ..refused("slices", message) });
        }
    };
    let full = u32::BITS - extent.into_iter().max().unwrap_or(1).max(1).leading_zeros();
    let count = if request.mips == 0 { full } else { request.mips };
    if count > full {
        return Err(refused("mips", format!("`{path}` has {full} mips down to one texel, not {count}")));
    }
    if count > 1 && channel.is_integer() {
        let message = format!("`{path}` becomes integers, which have no mean and so no mips");
        return Err(refused("mips", message));
    }
    let texels = u64::from(width) * u64::from(height);
    let bytes = texels * (channels * channel.bytes()) as u64;
    if bytes > MOST_BYTES {
        return Err(refused("source", format!("`{path}` takes {bytes} bytes, and at most {MOST_BYTES} are loaded")));
    }
    let mut mips = vec![convert(picture, channel, channels, request.srgb)];
    mips::append(&mut mips, extent, channel, channels, count);
    Ok(FileImage { format: channel.format(channels), extent, volume, mips, plays: None })
}

/// Whether a channel of a file loses nothing that matters in a channel of a format: integers take the stored numbers as they are.
fn fits(stored: Channel, to: Channel) -> bool {
    match stored {
        Channel::Unorm8 => true,
        Channel::Unorm16 => !matches!(to, Channel::Unorm8 | Channel::Uint8),
        Channel::Half | Channel::Float => matches!(to, Channel::Half | Channel::Float),
        Channel::Uint8 | Channel::Uint16 | Channel::Uint32 => to == Channel::Uint32,
    }
}

fn convert(picture: &Picture, to: Channel, channels: usize, srgb: bool) -> Vec<u8> {
    let from = picture.channel;
    if from == to && picture.channels == channels {
        return picture.bytes.clone();
    }
    // The number that stands for 1 in the file: a colour without alpha is opaque. Integers keep their stored numbers.
    let scale = match (from, to.is_integer()) {
        (Channel::Unorm8, true) => 255.0,
        (Channel::Unorm16, true) => 65535.0,
        _ => 1.0,
    };
    let texels = picture.extent.map(|side| side as usize).iter().product::<usize>();
    let mut bytes = Vec::with_capacity(texels * channels * to.bytes());
    let alpha = if picture.channels.is_multiple_of(2) { picture.channels - 1 } else { picture.channels };
    for texel in 0..texels {
        for channel in 0..channels {
            let value = if channel < picture.channels {
                from.get(&picture.bytes, texel * picture.channels + channel)
            } else {
                1.0
            };
            to.put(if srgb && channel < alpha { linear(value) } else { value * scale }, &mut bytes);
        }
    }
    bytes
}

fn wrong_format(path: &str, picture: &Picture, request: &ImageRequest) -> Refusal {
    let name = request.format.map_or("", |format| format.name());
    let channels = if picture.channels == 3 { 4 } else { picture.channels };
    let all = [
        Channel::Unorm8,
        Channel::Unorm16,
        Channel::Half,
        Channel::Float,
        Channel::Uint8,
        Channel::Uint16,
        Channel::Uint32,
    ];
    let linear = |channel: &Channel| !request.srgb || matches!(channel, Channel::Half | Channel::Float);
    let fitting = all.iter().filter(|channel| fits(picture.channel, **channel) && linear(channel));
    let names: Vec<&str> = fitting.map(|channel| channel.format(channels).name()).collect();
    let of = match picture.channels {
        1 => "1 channel".to_owned(),
        channels => format!("{channels} channels"),
    };
    let bits = picture.channel.bytes() * 8;
    Refusal {
        help: Some(format!("formats for it: {}", names.join(", "))),
        ..refused("format", format!("`{path}` has {of} of {bits} bits, which `{name}` does not fit"))
    }
}

/// Whether a picture may be decoded at all.
#[expect(clippy::cast_possible_truncation, reason = "longer sides are refused above")]
fn check_extent(width: u64, height: u64, texel_bytes: u64) -> Result<[u32; 2], String> {
    let side = u64::from(MOST_SIDE);
    if width == 0 || height == 0 || width > side || height > side {
        return Err(format!("it is {width}×{height} texels, and a side has 1 to {MOST_SIDE}"));
    }
    let bytes = width * height * texel_bytes;
    if bytes > MOST_BYTES {
        return Err(format!("it takes {bytes} bytes, and at most {MOST_BYTES} are loaded"));
    }
    Ok([width as u32, height as u32])
}

fn refused(key: &'static str, message: String) -> Refusal {
    Refusal { code: codes::graph::FILE_SOURCE, key, message, help: None }
}

#[cfg(test)]
mod tests;

//! Sound files: ffmpeg decodes all of a sound when what names it is loaded.

use std::path::Path;
use std::sync::Arc;

use raxel_diagnostics::Files;
use raxel_graph::supply::{MICROPHONE, SAMPLE_RATE};
use raxel_graph::{ImageRequest, Plays, Sound};
use raxel_shader::format::Format;

use crate::texels::Channel;
use crate::{FileImage, Picture, Refusal, bytes, ffmpeg, no_disk, refused, shape};

/// Texels of a row: frequencies of the spectrum, samples of the waveform.
pub const TEXELS: u32 = 512;

/// Spectrum, then waveform.
const ROWS: u32 = 2;

/// Names that end so are sounds.
const EXTENSIONS: [&str; 12] = ["wav", "mp3", "ogg", "oga", "opus", "flac", "m4a", "aac", "aif", "aiff", "wma", "mka"];

/// Longest sound, in seconds.
const MOST_SECONDS: u64 = 2700;

/// Whether a file is a sound, by its name.
pub(crate) fn is_sound(path: &str) -> bool {
    ffmpeg::ends_in(path, &EXTENSIONS)
}

/// A sound. `disk` is where the file lies.
pub(crate) fn open(path: &str, disk: &Path, request: &ImageRequest) -> Result<FileImage, Refusal> {
    plays(path, request, || samples(path, disk).map(Some))
}

/// What a microphone brings.
pub(crate) fn microphone(request: &ImageRequest) -> Result<FileImage, Refusal> {
    plays(MICROPHONE, request, || Ok(None))
}

/// A row of silence in each.
pub fn silence() -> Vec<f32> {
    [[0.0; TEXELS as usize], [0.5; TEXELS as usize]].concat()
}

/// All samples of a file, as one channel. What named it counts from the folder `from`.
pub fn read(files: &dyn Files, path: &str, from: &str) -> Result<Arc<[i16]>, Refusal> {
    // Reading it tells who watches the files that this one counts.
    bytes(files, path, from)?;
    let root = files.root().ok_or_else(|| no_disk(path))?;
    samples(path, &root.join(path))
}

fn plays(
    path: &str,
    request: &ImageRequest,
    samples: impl FnOnce() -> Result<Option<Arc<[i16]>>, Refusal>,
) -> Result<FileImage, Refusal> {
    if request.srgb {
        return Err(refused("encoding", format!("`{path}` is a sound, and holds no colours")));
    }
    // Filtered everywhere, which `r32f` is not.
    let request = ImageRequest { format: request.format.or(Some(Format::R16f)), ..request.clone() };
    let sound = Sound { path: path.to_owned(), samples: samples()?, request };
    let image = texels(&sound, &silence())?;
    Ok(FileImage { plays: Some(Plays::Sound(sound)), ..image })
}

fn samples(path: &str, disk: &Path) -> Result<Arc<[i16]>, Refusal> {
    decode(disk).map_err(|reason| refused("source", format!("`{path}` cannot be read: {reason}")))
}

/// All samples of a sound, as one channel.
fn decode(disk: &Path) -> Result<Arc<[i16]>, String> {
    if ffmpeg::probe(disk, "a:0", &[], "stream=sample_rate")?.is_empty() {
        return Err("it has no sound".to_owned());
    }
    let rate = SAMPLE_RATE.to_string();
    let form = ["-map", "0:a:0", "-ac", "1", "-ar", &rate, "-f", "s16le"];
    let most = 2 * u64::from(SAMPLE_RATE) * MOST_SECONDS;
    let bytes = ffmpeg::decode(disk, &form, most + 2)?;
    if bytes.len() as u64 > most {
        return Err(format!("it is longer than {} minutes", MOST_SECONDS / 60));
    }
    if bytes.len() < 2 {
        return Err("it has no samples".to_owned());
    }
    Ok(bytes.chunks_exact(2).map(|pair| i16::from_le_bytes([pair[0], pair[1]])).collect())
}

/// Spectrum and waveform as the graph wants them.
pub fn texels(sound: &Sound, values: &[f32]) -> Result<FileImage, Refusal> {
    let bytes = bytemuck::cast_slice(values).to_vec();
    let picture = Picture { extent: [TEXELS, ROWS], channel: Channel::Float, channels: 1, bytes };
    shape(&sound.path, &picture, &sound.request)
}

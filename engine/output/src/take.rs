//! Writes takes as demos of their project.

use std::fs;

use raxel_runtime::inputs::SAMPLE_RATE;
use raxel_runtime::project::Project;
use raxel_runtime::take::Take;

use crate::error::{OutputError, Result};
use crate::pending::Pending;

/// The name for a take: the given one if it is free, else the first of `take`, `take-2`, `take-3`, … that is.
///
/// # Errors
/// The name is no name, or not free. There are 9999 takes.
pub fn take_name(project: &Project, name: Option<&str>) -> Result<String> {
    let Some(name) = name else {
        return std::iter::once("take".to_owned())
            .chain((2..10_000).map(|number| format!("take-{number}")))
            .find(|name| taken(project, name).is_none())
            .ok_or_else(|| OutputError::new("`worlds/` has 9999 takes").help("delete some, or name the take"));
    };
    if name.is_empty() || name.len() > 64 || !name.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c)) {
        return Err(OutputError::new(format!("`{name}` cannot be the name of a take"))
            .help("a name has 1 to 64 letters, digits, `-` and `_`"));
    }
    match taken(project, name) {
        Some(path) => Err(OutputError::new(format!("`{path}` is there already")).help("give the take another name")),
        None => Ok(name.to_owned()),
    }
}

/// The file that would be replaced by a take of this name.
fn taken(project: &Project, name: &str) -> Option<String> {
    [demo_path(name), sound_path(name)].into_iter().find(|path| project.on_disk(path).exists())
}

/// Writes a take that has the name of [`take_name`] to `worlds/NAME.demo.toml` of a project, and its sound to `worlds/NAME.wav`. Returns the
/// project path of the demo. A file that has come there meanwhile stays, and is an error.
pub fn write_take(project: &Project, name: &str, take: &Take) -> Result<String> {
    let path = demo_path(name);
    let demo = Pending::new(&project.on_disk(&path))?;
    // The sound first: the demo names it.
    let sound = take.sound.as_ref().map(|samples| {
        let path = project.on_disk(&sound_path(name));
        Pending::new(&path)?.finish_new(&wav(samples)).map(|()| path)
    });
    let sound = sound.transpose()?;
    let written = demo.finish_new(take.text.as_bytes());
    if let (Err(_), Some(sound)) = (&written, sound) {
        // The error has the reason; the rest has no demo.
        let _ = fs::remove_file(sound);
    }
    written.map(|()| path)
}

/// The project path of the demo of a take.
pub fn demo_path(name: &str) -> String {
    format!("worlds/{name}.demo.toml")
}

fn sound_path(name: &str) -> String {
    format!("worlds/{name}.wav")
}

/// A WAV file of one channel.
fn wav(samples: &[i16]) -> Vec<u8> {
    // A take has at most 10 minutes.
    let bytes = u32::try_from(2 * samples.len()).unwrap_or(u32::MAX - 36);
    let mut file = Vec::with_capacity(44 + 2 * samples.len());
    file.extend(b"RIFF");
    file.extend((36 + bytes).to_le_bytes());
    file.extend(b"WAVEfmt ");
    // The length of the next part, whole numbers, one channel.
    file.extend(16_u32.to_le_bytes());
    file.extend([1_u16, 1].map(u16::to_le_bytes).concat());
    file.extend([SAMPLE_RATE, 2 * SAMPLE_RATE].map(u32::to_le_bytes).concat());
    // Bytes of a sample in all channels, bits in one.
    file.extend([2_u16, 16].map(u16::to_le_bytes).concat());
    file.extend(b"data");
    file.extend(bytes.to_le_bytes());
    file.extend(samples.iter().flat_map(|sample| sample.to_le_bytes()));
    file
}

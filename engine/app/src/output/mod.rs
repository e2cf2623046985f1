//! Where pictures go: one PNG or EXR, numbered frames, or a film. Whether a place can be written is found out before anything is
//! rendered; what is written appears under its name only when it is whole.

mod csv;
mod exr;
mod film;
mod folders;
mod leftovers;
mod pending;
mod png;

use std::path::{Path, PathBuf};

use raxel_runtime::execute::{Picture, Texels};

pub(crate) use self::csv::Table;
pub(crate) use self::film::{Film, version as ffmpeg_version};
pub(crate) use self::folders::{Folders, Scratch};
pub(crate) use self::leftovers::{Listed, on_stop, watch_signals};
pub(crate) use self::pending::Pending;
use crate::failure::{Failure, Result};

/// The form of one picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// 8 bits a channel, as the display map shows it.
    Png,
    /// The texels of the target as they are.
    Exr,
}

/// What `-o` asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Output {
    /// One picture, of the last frame.
    Single(Kind, PathBuf),
    /// One picture a frame.
    Frames(Kind, Pattern),
    /// A film of all frames.
    Film(PathBuf),
}

/// A file name with one number in it, e.g. `frames/%04d.png`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pattern {
    before: String,
    digits: usize,
    after: String,
}

impl Output {
    /// Reads the argument of `-o`.
    pub fn parse(argument: &str) -> Result<Self> {
        let folder = argument.trim_end_matches(['/', '\\']);
        let path = PathBuf::from(argument);
        if argument.ends_with(['/', '\\']) || path.is_dir() {
            // Somebody who writes the name of a picture or a film means no folder of that name.
            if let Some(extension) = written(Path::new(folder)) {
                return Err(Failure::usage(format!("`{argument}` is a folder, and its name is that of a file"))
                    .help(format!("a name that is free, or a number for each frame: {folder}/%04d.png"))
                    .help(format!("`.{extension}` says what to write")));
            }
            let before = if folder.is_empty() { "/".to_owned() } else { format!("{folder}/") };
            return Ok(Output::Frames(Kind::Png, Pattern { before, digits: 4, after: ".png".to_owned() }));
        }
        let kind = match written(&path).as_deref() {
            Some("png") => Kind::Png,
            Some("exr") => Kind::Exr,
            Some(_) => return Ok(Output::Film(path)),
            None => {
                return Err(Failure::usage(format!("`{argument}` does not say what to write")).help(format!(
                    "a name that ends in .png or .exr, one with a number such as frames/%04d.png, a folder (frames/), or a film: .{}",
                    film::EXTENSIONS.join(", .")
                )));
            }
        };
        Ok(match Pattern::parse(argument)? {
            Some(pattern) => Output::Frames(kind, pattern),
            None => Output::Single(kind, path),
        })
    }

    /// Whether raw texels are needed, rather than the displayed picture.
    pub fn wants_texels(&self) -> bool {
        matches!(self, Output::Single(Kind::Exr, _) | Output::Frames(Kind::Exr, _))
    }

    /// The extension in words, for messages.
    pub fn describe(&self) -> String {
        match self {
            Output::Single(_, path) | Output::Film(path) => path.display().to_string(),
            Output::Frames(_, pattern) => pattern.describe(),
        }
    }
}

/// The extension of a name, in lower case, if it says what to write.
fn written(path: &Path) -> Option<String> {
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    (["png", "exr"].contains(&extension.as_str()) || film::EXTENSIONS.contains(&extension.as_str()))
        .then_some(extension)
}

impl Pattern {
    /// `None` when there is no number in the name.
    fn parse(argument: &str) -> Result<Option<Self>> {
        let Some((before, rest)) = argument.split_once('%') else { return Ok(None) };
        let wrong = || Failure::usage(format!("`{argument}` needs one number, written %d or %04d"));
        let (width, after) = rest.split_once('d').ok_or_else(wrong)?;
        let digits = match width {
            "" => 1,
            _ => width
                .strip_prefix('0')
                .and_then(|n| n.parse().ok())
                .filter(|n| (1..=9).contains(n))
                .ok_or_else(wrong)?,
        };
        if after.contains('%') || before.contains('%') {
            return Err(wrong());
        }
        Ok(Some(Self { before: before.to_owned(), digits, after: after.to_owned() }))
    }

    /// The file of a frame.
    pub fn file(&self, frame: u64) -> PathBuf {
        PathBuf::from(format!("{}{frame:0digits$}{}", self.before, self.after, digits = self.digits))
    }

    fn describe(&self) -> String {
        let number = if self.digits > 1 { format!("%0{}d", self.digits) } else { "%d".to_owned() };
        format!("{}{number}{}", self.before, self.after)
    }

    /// Makes the folder that the frames go to and finds out whether files can be made there.
    pub fn prepare(&self, first: u64) -> Result<Folders> {
        let file = self.file(first);
        let folders = Folders::make(file.parent().unwrap_or(Path::new("")))?;
        Pending::new(&file)?;
        Ok(folders)
    }
}

/// Encodes a displayed picture and puts it in place.
pub(crate) fn write_picture(pending: Pending, picture: &Picture) -> Result {
    let bytes = png::encode(picture).map_err(|error| Failure::usage(format!("the PNG could not be made: {error}")))?;
    pending.finish(&bytes)
}

/// Encodes texels and puts them in place.
pub(crate) fn write_texels(pending: Pending, texels: &Texels, name: &str) -> Result {
    let bytes =
        exr::encode(texels, name).map_err(|error| Failure::usage(format!("the EXR could not be made: {error}")))?;
    pending.finish(&bytes)
}

/// A path as a message shows it: absolute, if that can be had.
pub(crate) fn shown(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_told_apart_by_name() {
        assert_eq!(Output::parse("a.PNG").unwrap(), Output::Single(Kind::Png, "a.PNG".into()));
        assert_eq!(Output::parse("b/d.exr").unwrap(), Output::Single(Kind::Exr, "b/d.exr".into()));
        assert_eq!(Output::parse("film.mp4").unwrap(), Output::Film("film.mp4".into()));
        let Output::Frames(Kind::Exr, pattern) = Output::parse("out/f%03d.exr").unwrap() else { panic!() };
        assert_eq!(pattern.file(7), Path::new("out/f007.exr"));
        assert_eq!(pattern.file(12345), Path::new("out/f12345.exr"));
        let Output::Frames(Kind::Png, pattern) = Output::parse("frames/").unwrap() else { panic!() };
        assert_eq!(pattern.file(3), Path::new("frames/0003.png"));
        assert_eq!(pattern.describe(), "frames/%04d.png");
        for wrong in ["o.png/", "o.mkv/", "a/b.EXR/"] {
            assert!(Output::parse(wrong).unwrap_err().message.unwrap().contains("is a folder"), "{wrong}");
        }
        for wrong in ["", "a", "a.jpg", "%d%d.png", "%4d.png", "%x.png", "%0d.png", "%099d.png"] {
            assert!(Output::parse(wrong).is_err(), "{wrong}");
        }
    }
}

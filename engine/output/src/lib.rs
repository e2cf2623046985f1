//! Writes pictures: one file, numbered frames, a film, or stdout. Checks whether the place can be written before anything is rendered. A
//! file appears under its name only when it is complete.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! ```no_run
//! use raxel_output::{Coding, Compression, Layers, Mode, Output, Destination, Shoot};
//! use raxel_runtime::{Options, Session};
//!
//! let demo = Some("worlds/valley.demo.toml".into());
//! let mut session = Session::open(Options { demo, size: [640, 360], step: Some(1.0 / 30.0), ..Options::default() })?;
//! let output = Output::parse("valley.mp4", None)?;
//! let place = Destination::prepare(&output, [640, 360], 30.0, 0)?;
//! let shoot = Shoot {
//!     run: 0..90,
//!     wanted: 0..90,
//!     layers: Layers::Picture,
//!     coding: Coding { kind: output.kind(), compression: Compression::default(), quality: 90 },
//!     captions: None,
//!     samples: 1,
//!     settle: 0,
//!     mode: Mode::AtOnce,
//! };
//! shoot.run::<Box<dyn std::error::Error>>(
//!     &mut session,
//!     place,
//!     |_, frame| Ok(println!("frame {frame}")),
//!     |session| Ok(drop(session.frame()?)),
//! )?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod caption;
mod coding;
mod csv;
mod error;
mod exr;
mod film;
mod folders;
mod frame_list;
mod leftovers;
mod pending;
mod pipeline;
mod place;
mod png;
mod replace;
mod shoot;
mod supersample;
mod take;

use std::path::{Path, PathBuf};

use raxel_execute::Picture;

use self::coding::rgb;
pub use self::coding::{Coding, PictureFormat, Shot};
pub use self::csv::Table;
pub use self::error::{OutputError, Result};
pub use self::film::version as ffmpeg_version;
pub use self::folders::{Folders, Scratch};
pub use self::frame_list::FrameList;
pub use self::leftovers::{Listed, on_stop, watch_signals};
pub use self::pending::Pending;
pub use self::place::Destination;
pub use self::png::Compression;
pub use self::replace::replace;
pub use self::shoot::{Layer, Layers, MOST_LAYERS, Mode, Shoot, Stages};
pub use self::take::{demo_path, take_name, write_take};

/// An output, as `-o` of `raxel render` names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Output {
    /// One picture, of the last frame.
    Single(PictureFormat, PathBuf),
    /// One picture for each frame.
    Frames(PictureFormat, Pattern),
    /// A film of all frames.
    Film(PathBuf),
    /// stdout (`-o -`): frame after frame.
    Stream(PictureFormat),
}

/// A file name with a place for the number of the frame, e.g. `frames/%04d.png`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    before: String,
    digits: usize,
    after: String,
}

impl Output {
    /// Reads the argument of `-o`. `kind` is the form of a picture if the name does not say it.
    pub fn parse(argument: &str, kind: Option<PictureFormat>) -> Result<Self> {
        if argument == "-" {
            return Ok(Output::Stream(kind.unwrap_or(PictureFormat::Png)));
        }
        let folder = argument.trim_end_matches(['/', '\\']);
        let path = PathBuf::from(argument);
        if argument.ends_with(['/', '\\']) || path.is_dir() {
            // A name with the extension of a picture or a film means no folder of that name.
            if let Some((extension, _)) = written(Path::new(folder)) {
                return Err(OutputError::new(format!("`{argument}` is a folder, and its name is that of a file"))
                    .help(format!("a name that is free, or a number for each frame: {folder}/%04d.png"))
                    .help(format!("`.{extension}` says what to write")));
            }
            let before = if folder.is_empty() { "/".to_owned() } else { format!("{folder}/") };
            let kind = kind.unwrap_or(PictureFormat::Png);
            return Ok(Output::Frames(kind, Pattern { before, digits: 4, after: format!(".{}", kind.extension()) }));
        }
        let pattern = Pattern::parse(argument)?;
        let kind = match (written(&path), kind) {
            (Some((_, Some(named))), None) => named,
            (Some((_, Some(named))), Some(kind)) if named == kind => kind,
            (Some((extension, _)), Some(_)) => {
                return Err(OutputError::new(format!(
                    "`--as` and the extension `.{extension}` of `{argument}` both choose the format"
                ))
                .help("remove `--as`, which is for `-o -`, folders and names without an extension"));
            }
            (Some((_, None)), None) => return Ok(Output::Film(path)),
            (None, Some(kind)) if path.extension().is_none() || kind == PictureFormat::Raw => kind,
            (None, _) => {
                let pictures = PictureFormat::EXTENSIONS.map(|(extension, _)| extension).join(", .");
                return Err(OutputError::new(format!("`{argument}` does not say what to write")).help(format!(
                    "a name that ends in .{pictures}, one with a number such as frames/%04d.png, a folder (frames/), `-` for stdout, or a \
                     film: .{}",
                    film::EXTENSIONS.join(", .")
                )));
            }
        };
        Ok(match pattern {
            Some(pattern) => Output::Frames(kind, pattern),
            None => Output::Single(kind, path),
        })
    }

    /// Numbered PNG files for the frames of a film, in a folder beside it: `a.frames/` for `a.mp4`.
    pub fn frames_of(film: &Path) -> Self {
        let before = format!("{}/", film.with_extension("frames").display());
        Output::Frames(PictureFormat::Png, Pattern { before, digits: 5, after: ".png".to_owned() })
    }

    /// Removes the numbered files.
    pub fn clear(&self) -> Result {
        if let Output::Frames(_, pattern) = self { pattern.clear() } else { Ok(()) }
    }

    /// The form of a frame before it goes to the output. A film takes raw frames.
    pub fn kind(&self) -> PictureFormat {
        match self {
            Output::Single(kind, _) | Output::Frames(kind, _) | Output::Stream(kind) => *kind,
            Output::Film(_) => PictureFormat::Raw,
        }
    }

    /// The name of the form, for messages.
    pub fn describe(&self) -> String {
        match self {
            Output::Single(_, path) | Output::Film(path) => path.display().to_string(),
            Output::Frames(_, pattern) => pattern.describe(),
            Output::Stream(_) => "stdout".to_owned(),
        }
    }
}

/// The extension of a name, in lower case, if it is that of an output, with the form of a picture; a film has none.
fn written(path: &Path) -> Option<(String, Option<PictureFormat>)> {
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    let kind = PictureFormat::EXTENSIONS.iter().find(|(known, _)| *known == extension).map(|(_, kind)| *kind);
    (kind.is_some() || film::EXTENSIONS.contains(&extension.as_str())).then_some((extension, kind))
}

impl Pattern {
    /// `None` when there is no number in the name.
    fn parse(argument: &str) -> Result<Option<Self>> {
        let Some((before, rest)) = argument.split_once('%') else { return Ok(None) };
        let wrong = || OutputError::new(format!("`{argument}` needs one number, written %d or %04d"));
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

    /// Removes every file that a frame could have been written to.
    fn clear(&self) -> Result {
        let first = self.file(0);
        let Ok(files) = std::fs::read_dir(first.parent().unwrap_or(Path::new(""))) else { return Ok(()) };
        for path in files.flatten().map(|file| file.path()) {
            let name = path.to_str().and_then(|name| name.strip_prefix(&self.before)?.strip_suffix(&self.after));
            if name.is_some_and(|number| number.parse().is_ok_and(|frame| self.file(frame) == path)) {
                std::fs::remove_file(&path)
                    .map_err(|error| OutputError::new(format!("`{}` cannot be removed: {error}", path.display())))?;
            }
        }
        Ok(())
    }

    fn describe(&self) -> String {
        let number = if self.digits > 1 { format!("%0{}d", self.digits) } else { "%d".to_owned() };
        format!("{}{number}{}", self.before, self.after)
    }

    /// Makes the folder of the frames, and checks whether files can be written there.
    pub fn prepare(&self, first: u64) -> Result<Folders> {
        let file = self.file(first);
        let folders = Folders::make(file.parent().unwrap_or(Path::new("")))?;
        Pending::new(&file)?;
        Ok(folders)
    }
}

/// Writes a displayed picture as PNG.
pub fn write_picture(pending: Pending, picture: &Picture) -> Result {
    let bytes = png::encode(picture, Compression::default());
    pending.finish(&bytes.map_err(|error| OutputError::new(format!("the PNG could not be made: {error}")))?)
}

/// A path as messages show it: absolute, if possible.
pub fn shown(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_told_apart_by_name() {
        let parse = |argument: &str| Output::parse(argument, None);
        assert_eq!(parse("a.PNG").unwrap(), Output::Single(PictureFormat::Png, "a.PNG".into()));
        assert_eq!(parse("b/d.exr").unwrap(), Output::Single(PictureFormat::Exr, "b/d.exr".into()));
        assert_eq!(parse("b/d.jpeg").unwrap(), Output::Single(PictureFormat::Jpg, "b/d.jpeg".into()));
        assert_eq!(parse("film.mp4").unwrap(), Output::Film("film.mp4".into()));
        assert_eq!(parse("-").unwrap(), Output::Stream(PictureFormat::Png));
        assert_eq!(Output::parse("-", Some(PictureFormat::Raw)).unwrap(), Output::Stream(PictureFormat::Raw));
        let Output::Frames(PictureFormat::Exr, pattern) = parse("out/f%03d.exr").unwrap() else { panic!() };
        assert_eq!(pattern.file(7), Path::new("out/f007.exr"));
        assert_eq!(pattern.file(12345), Path::new("out/f12345.exr"));
        let Output::Frames(PictureFormat::Png, pattern) = parse("frames/").unwrap() else { panic!() };
        assert_eq!(pattern.file(3), Path::new("frames/0003.png"));
        assert_eq!(pattern.describe(), "frames/%04d.png");
        let Output::Frames(PictureFormat::Jpg, pattern) = Output::parse("frames/", Some(PictureFormat::Jpg)).unwrap()
        else {
            panic!()
        };
        assert_eq!(pattern.file(3), Path::new("frames/0003.jpg"));
        assert!(
            Output::parse("a.png", Some(PictureFormat::Jpg))
                .unwrap_err()
                .message
                .contains("the extension `.png` of `a.png`")
        );
        for wrong in ["o.png/", "o.mkv/", "a/b.EXR/"] {
            assert!(parse(wrong).unwrap_err().message.contains("is a folder"), "{wrong}");
        }
        for wrong in ["", "a", "a.tga", "%d%d.png", "%4d.png", "%x.png", "%0d.png", "%099d.png"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn frames_are_cleared_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let frames = Output::frames_of(&folder.path().join("film.mp4"));
        // Without the folder there is nothing to do.
        frames.clear().unwrap();
        let Output::Frames(_, pattern) = &frames else { panic!() };
        std::fs::create_dir(folder.path().join("film.frames")).unwrap();
        for frame in [0, 7, 123_456] {
            std::fs::write(pattern.file(frame), "").unwrap();
        }
        for other in ["film.frames/7.png", "film.frames/00007.png.old", "film.frames/notes", "00007.png"] {
            std::fs::write(folder.path().join(other), "").unwrap();
        }
        frames.clear().unwrap();
        let left = std::fs::read_dir(folder.path().join("film.frames")).unwrap().count();
        assert!([0, 7, 123_456].iter().all(|frame| !pattern.file(*frame).exists()) && left == 3);
    }
}

//! Where encoded frames go.

use std::io::{ErrorKind, Write};
use std::path::Path;

use super::film::Film;
use super::folders::Folders;
use super::frame_list::FrameList;
use super::pending::Pending;
use super::{Output, Pattern};
use crate::error::{OutputError, Result};

/// A place that takes encoded frames, in order.
pub enum Destination {
    /// One file. `None` after it is written.
    Single(Option<Pending>),
    /// A file for each frame.
    Frames {
        /// Names of the files.
        pattern: Pattern,
        /// Folders that were made for the files.
        folders: Folders,
        /// Where finished frames are listed.
        list: Option<FrameList>,
    },
    /// ffmpeg, which takes raw frames.
    Film(Film),
    /// stdout: frame after frame.
    Stream,
}

impl Destination {
    /// Checks whether an output can be written, for frames from `first` on. `size` is the extent of a film in pixels, `rate` its frames a
    /// second.
    pub fn prepare(output: &Output, size: [u32; 2], rate: f64, first: u64) -> Result<Self> {
        Ok(match output {
            Output::Single(_, path) => Self::single(path)?,
            Output::Frames(_, pattern) => Self::frames(pattern, first)?,
            Output::Film(path) => Self::Film(Film::start(path, size, rate)?),
            Output::Stream(_) => Self::Stream,
        })
    }

    fn single(path: &Path) -> Result<Self> {
        Ok(Self::Single(Some(Pending::new(path)?)))
    }

    pub(crate) fn frames(pattern: &Pattern, first: u64) -> Result<Self> {
        Ok(Self::Frames { pattern: pattern.clone(), folders: pattern.prepare(first)?, list: None })
    }

    /// Lists each frame when its file is in place.
    #[must_use]
    pub fn listing(mut self, in_list: FrameList) -> Self {
        if let Self::Frames { list, .. } = &mut self {
            *list = Some(in_list);
        }
        self
    }

    /// Writes a frame.
    pub fn write(&mut self, frame: u64, bytes: &[u8]) -> Result {
        match self {
            Self::Single(pending) => pending.take().map_or(Ok(()), |pending| pending.finish(bytes)),
            Self::Frames { pattern, list, .. } => {
                Pending::new(&pattern.file(frame))?.finish(bytes)?;
                list.as_mut().map_or(Ok(()), |list| list.add(frame, bytes))
            }
            Self::Film(film) => film.frame(bytes),
            Self::Stream => {
                let mut out = std::io::stdout().lock();
                out.write_all(bytes).and_then(|()| out.flush()).map_err(|error| {
                    OutputError::new(match error.kind() {
                        ErrorKind::BrokenPipe => "stdout is a pipe without a reader".to_owned(),
                        _ => format!("stdout cannot be written: {error}"),
                    })
                })
            }
        }
    }

    /// Completes the output after the last frame.
    pub fn finish(self) -> Result {
        match self {
            Self::Film(film) => film.finish(),
            Self::Single(_) | Self::Frames { .. } | Self::Stream => Ok(()),
        }
    }
}

//! The list of the frames that a run has finished, so that the run can resume after it was killed. Each frame has the hash of its file: a frame counts
//! only while its file is the one that was written.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::Pattern;
use super::pending::Pending;
use crate::error::{OutputError, Result};

/// An open list. Its first line is the command that it belongs to; each other line has a frame and a hash.
#[derive(Debug)]
pub struct FrameList {
    path: PathBuf,
    file: File,
    /// The lines that it had when it was opened.
    listed: BTreeMap<u64, String>,
}

impl FrameList {
    /// Opens the list of a command, or begins one.
    ///
    /// # Errors
    /// The list is of another command, or cannot be read or written.
    pub fn open(path: &Path, command: &str) -> Result<Self> {
        let fail = |error: std::io::Error| OutputError::new(format!("the list `{}`: {error}", path.display()));
        let command = command.replace(['\n', '\r'], " ");
        // Asked before reading: a device may have no end, and a pipe may have no writer.
        if fs::metadata(path).is_ok_and(|found| !found.is_file()) {
            return Err(fail(std::io::Error::other("it is not a file")).help("name a file, e.g. frames.txt"));
        }
        match fs::read(path) {
            Ok(bytes) => {
                let text = String::from_utf8_lossy(&bytes);
                let mut lines = text.lines();
                let of = lines.next().unwrap_or_default();
                if of != command {
                    let message = format!(
                        "`{}` is not a list of this command's frames: it begins with `{}`",
                        path.display(),
                        beginning(of)
                    );
                    return Err(OutputError::new(message).help("name another file, or remove it to make every frame"));
                }
                // A line that a crash has cut off is no frame.
                let frame = |line: &str| {
                    let (frame, hash) = line.split_once(' ')?;
                    Some((frame.parse().ok()?, hash.to_owned()))
                };
                let listed = lines.filter_map(frame).collect();
                let mut file = File::options().append(true).open(path).map_err(fail)?;
                if !text.ends_with('\n') {
                    file.write_all(b"\n").map_err(fail)?;
                }
                Ok(Self { path: path.to_owned(), file, listed })
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {
                Pending::new(path)?.finish(format!("{command}\n").as_bytes())?;
                let file = File::options().append(true).open(path).map_err(fail)?;
                Ok(Self { path: path.to_owned(), file, listed: BTreeMap::new() })
            }
            Err(error) => Err(fail(error)),
        }
    }

    /// The number of finished frames from the start: they are listed, and their files are as they were written.
    pub fn finished(&self, frames: Range<u64>, pattern: &Pattern) -> u64 {
        let is_finished = |frame: &u64| {
            let hash = self.listed.get(frame);
            hash.is_some_and(|hash| fs::read(pattern.file(*frame)).is_ok_and(|bytes| hash_of(&bytes) == *hash))
        };
        frames.take_while(is_finished).count() as u64
    }

    /// Lists a frame whose file is in place.
    pub(crate) fn add(&mut self, frame: u64, bytes: &[u8]) -> Result {
        // In one write, so that two runs with the same list do not mix lines.
        let line = format!("{frame} {}\n", hash_of(bytes));
        let written = self.file.write_all(line.as_bytes());
        written
            .map_err(|error| OutputError::new(format!("the list `{}` cannot be written: {error}", self.path.display())))
    }
}

/// The beginning of a line of any file, as a message may show it.
fn beginning(line: &str) -> String {
    const MOST: usize = 200;
    let shown = line.chars().take(MOST).map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c });
    let more = if line.chars().nth(MOST).is_some() { "…" } else { "" };
    shown.chain(more.chars()).collect()
}

fn hash_of(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::super::Output;
    use super::*;

    #[test]
    fn only_frames_whose_files_are_as_they_were_written_are_finished() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join("list");
        let output = folder.path().join("%d.png");
        let Output::Frames(_, pattern) = Output::parse(output.to_str().unwrap(), None).unwrap() else { panic!() };
        let put = |frame: u64, bytes: &str| fs::write(pattern.file(frame), bytes).unwrap();
        let open = || FrameList::open(&list, "render a");
        let finished = || open().unwrap().finished(2..6, &pattern);
        put(2, "of an earlier film");
        assert_eq!(finished(), 0);
        let mut first = open().unwrap();
        for frame in 2..6 {
            put(frame, &format!("frame {frame}"));
            first.add(frame, format!("frame {frame}").as_bytes()).unwrap();
        }
        assert_eq!(finished(), 4);
        // Overwritten, cut off, and removed files are no frames of the command.
        put(5, "of another film");
        assert_eq!(finished(), 3);
        put(4, "frame");
        assert_eq!(finished(), 2);
        fs::remove_file(pattern.file(2)).unwrap();
        assert_eq!(finished(), 0);
        put(2, "frame 2");
        // The last line is cut off.
        let text = fs::read_to_string(&list).unwrap();
        let cut = text.find("\n3 ").unwrap() + 20;
        fs::write(&list, &text[..cut]).unwrap();
        assert_eq!(finished(), 1);
        // The next frame stands on a line of its own.
        open().unwrap().add(3, b"frame 3").unwrap();
        assert_eq!(finished(), 2);

        let other = FrameList::open(&list, "render b").unwrap_err();
        assert!(other.message.contains("begins with `render a`"), "{}", other.message);
        // The message stays one line, for any file.
        fs::write(&list, [&[0xff, 0xfe, 0x1b, b'['][..], &[b'a'; 4096]].concat()).unwrap();
        let message = open().unwrap_err().message;
        assert!(message.ends_with("a…`") && message.len() < 400 && !message.contains('\u{1b}'), "{message}");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_or_a_pipe_is_no_list() {
        // It never ends.
        let message = FrameList::open(Path::new("/dev/zero"), "render a").unwrap_err().message;
        assert_eq!(message, "the list `/dev/zero`: it is not a file");
    }
}

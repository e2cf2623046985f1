//! Files that the window writes beside its frames, each by a thread of its own: the text of a large buffer or the coding of a large picture takes
//! longer than a frame may.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use raxel_execute::Captured;
use raxel_output::{Pending, Table, shown};
use raxel_terminal::failure::{Exit, Failure, Result};

use super::Viewer;
use super::elements::Elements;

/// A copy of a whole buffer.
pub struct Whole {
    /// Its name.
    pub(super) name: String,
    pub(super) elements: Elements,
    pub(super) captured: Arc<Captured>,
}

/// The files that are being written.
#[derive(Default)]
pub(super) struct Writings(Vec<Writing>);

struct Writing {
    path: PathBuf,
    thread: JoinHandle<Result>,
}

impl Whole {
    /// Writes the buffer as CSV, with a row for each element.
    fn write(&self, path: &Path) -> Result {
        let Captured::Bytes { total, bytes, .. } = &*self.captured else { return Ok(()) };
        let names = self.elements.names();
        let mut table = Table::new(names.iter().map(String::as_str).collect::<Vec<_>>().iter())?;
        for row in 0..self.elements.count(*total) {
            table.row(self.elements.row(bytes, 0, row).into_iter())?;
        }
        Ok(Pending::new(path)?.finish(&table.finish()?)?)
    }
}

impl Writings {
    /// Writes a file of this name and extension in the current folder that does not exist yet.
    pub(crate) fn write(&mut self, name: &str, extension: &str, write: impl FnOnce(&Path) -> Result + Send + 'static) {
        let path = free(name, extension, |path| self.0.iter().any(|writing| writing.path == path));
        let to = path.clone();
        self.0.push(Writing { path, thread: thread::spawn(move || write(&to)) });
    }

    /// The files that are done; with `all`, waits for the others.
    fn done(&mut self, all: bool) -> Vec<(PathBuf, Result)> {
        let ended = self.0.extract_if(.., |writing| all || writing.thread.is_finished());
        let result = |Writing { path, thread }| {
            // A panic of the thread was shown when it happened.
            let lost = |_| Err(Failure::new(Exit::Usage, format!("`{}` was not written", shown(&path))));
            let result = thread.join().unwrap_or_else(lost);
            (path, result)
        };
        ended.map(result).collect()
    }
}

impl Viewer<'_> {
    /// Writes the buffer that was asked for, once it is there.
    pub(super) fn write_table(&mut self) {
        if let Some(whole) = self.inspector.whole(self.session.graph()) {
            let name = whole.name.clone();
            self.writings.write(&name, "csv", move |path| whole.write(path));
        }
    }

    /// Writes the shown target as PNG.
    pub(super) fn screenshot(&mut self) -> Result {
        let picture = self.session.read_presented()?;
        let frame = self.session.clock().now().map_or(0, |time| time.index);
        let name = format!("{}-{}-{frame:05}", self.session.graph().name, self.target());
        self.writings.write(&name, "png", move |path| Ok(raxel_output::write_picture(Pending::new(path)?, &picture)?));
        Ok(())
    }

    /// Reports the files that are written; with `all`, waits for the others.
    pub(super) fn report_written(&mut self, all: bool) {
        for (path, result) in self.writings.done(all) {
            match result {
                Ok(()) => {
                    self.console.message(&format!("wrote {}", shown(&path)));
                    self.notice(format!("wrote {}", shown(&path)));
                }
                Err(failure) => self.console.failure(&failure),
            }
        }
    }
}

/// A file of that name and extension in the current folder that does not exist yet, and that is not taken.
fn free(name: &str, extension: &str, taken: impl Fn(&Path) -> bool) -> PathBuf {
    let plain = |c: char| if c.is_alphanumeric() || "-_@".contains(c) { c } else { '_' };
    let name: String = name.chars().map(plain).collect();
    let numbered = |n| if n == 1 { format!("{name}.{extension}") } else { format!("{name}-{n}.{extension}") };
    let is_free = |path: &PathBuf| !path.exists() && !taken(path);
    (1..10_000).map(numbered).map(PathBuf::from).find(is_free).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A buffer of this many words.
    fn words(count: u32) -> Whole {
        let bytes: Vec<u8> = (0..count).flat_map(u32::to_le_bytes).collect();
        let captured = Captured::Bytes { start: 0, total: bytes.len() as u64, bytes }.into();
        Whole { name: "words".to_owned(), elements: Elements::of_words(4), captured }
    }

    #[test]
    fn a_table_has_a_row_for_each_element() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        words(3).write(&path).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "[0] u32\n0\n1\n2\n");
        assert!(words(3).write(&folder.path().join("none/a.csv")).is_err());
    }

    #[test]
    fn a_file_that_is_being_written_is_waited_for_at_the_end_alone() {
        let (go, gate) = std::sync::mpsc::channel();
        let thread = thread::spawn(move || {
            let _ = gate.recv();
            Ok(())
        });
        let mut writings = Writings(vec![Writing { path: "a.csv".into(), thread }]);
        assert_eq!(writings.done(false), []);
        go.send(()).unwrap();
        assert_eq!(writings.done(true), [(PathBuf::from("a.csv"), Ok(()))]);
    }
}

//! Decides when an edit is finished, and whether it changed anything.
//!
//! Editors save in many ways: in place, in pieces, by renaming a new file over the old one, by deleting first. A file counts as
//! changed when nothing has touched it for a moment and its bytes differ. If it is missing or empty, it must stay so for
//! longer. Time is given from outside, so that this is a plain function of events.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::recording_files::Content;

/// Quiet time after a file was closed or renamed into place. Short: the file is whole, and only the other files of a "save all" are
/// still to come.
pub(crate) const QUIET_AFTER_CLOSE: Duration = Duration::from_millis(15);

/// Quiet time after a write, where the system does not say when the writer closes the file.
pub(crate) const QUIET_AFTER_WRITE: Duration = Duration::from_millis(50);

/// Quiet time after a write, where the system will say when the writer closes the file.
pub(crate) const QUIET_WHILE_OPEN: Duration = Duration::from_millis(300);

/// The time that an existing file may be missing or empty, as it is between two steps of a save.
pub(crate) const GONE_FOR_A_MOMENT: Duration = Duration::from_millis(250);

/// Longest wait for quiet, however busy the folder.
pub(crate) const LONGEST_WAIT: Duration = Duration::from_millis(1500);

/// The change of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileActivity {
    /// Closed after writing, renamed, deleted: one step of a save is finished.
    Finished,
    /// Written to; the system will say when it is closed.
    Open,
    /// Something, without details from the system.
    Unknown,
}

impl FileActivity {
    fn quiet(self) -> Duration {
        match self {
            FileActivity::Finished => QUIET_AFTER_CLOSE,
            FileActivity::Open => QUIET_WHILE_OPEN,
            FileActivity::Unknown => QUIET_AFTER_WRITE,
        }
    }
}

/// Files that were touched and are waited for, and the contents of all files as last used.
#[derive(Debug, Default)]
pub(crate) struct Debounce {
    touched: BTreeMap<String, ActiveFile>,
    known: BTreeMap<String, Content>,
}

#[derive(Clone, Copy, Debug)]
struct ActiveFile {
    first: Instant,
    due: Instant,
    /// Whether the last that happened to it ended a step of a save.
    is_closed: bool,
}

impl Debounce {
    /// The files that matter from now on, with the contents that were used.
    pub(crate) fn expect(&mut self, files: impl IntoIterator<Item = (String, Content)>) {
        self.known = files.into_iter().collect();
        self.touched.retain(|path, _| self.known.contains_key(path));
    }

    /// Whether a file matters.
    pub(crate) fn matters(&self, path: &str) -> bool {
        self.known.contains_key(path)
    }

    /// Something happened to a file.
    pub(crate) fn touch(&mut self, path: &str, activity: FileActivity, now: Instant) {
        if self.matters(path) {
            let first = self.touched.get(path).map_or(now, |touched| touched.first);
            let due = (now + activity.quiet()).min(first + LONGEST_WAIT);
            let is_closed = activity == FileActivity::Finished;
            self.touched.insert(path.to_owned(), ActiveFile { first, due, is_closed });
        }
    }

    /// When [`Debounce::changed`] is worth calling; `None` while nothing was touched.
    pub(crate) fn due(&self) -> Option<Instant> {
        self.touched.values().map(|touched| touched.due).max()
    }

    /// Whether a touched file already differs from the used one, even if its edit is not finished.
    pub(crate) fn differs(&self, read: impl Fn(&str) -> Content) -> bool {
        self.touched.keys().any(|path| self.known.get(path) != Some(&read(path)))
    }

    /// The files that differ from the used ones, with their contents, if all touched files are whole already: each is closed and none is gone. Only
    /// the other files of the same save are still waited for.
    pub(crate) fn whole(&self, read: impl Fn(&str) -> Content) -> Vec<(String, Content)> {
        if self.touched.values().any(|touched| !touched.is_closed) {
            return Vec::new();
        }
        let mut contents: Vec<(String, Content)> = self.touched.keys().map(|path| (path.clone(), read(path))).collect();
        if contents.iter().any(|(_, content)| matches!(content, Content::Missing | Content::Empty)) {
            return Vec::new();
        }
        contents.retain(|(path, content)| self.known.get(path) != Some(content));
        contents
    }

    /// Once all touched files are quiet: those whose contents differ from the used ones. They count as used from then on.
    pub(crate) fn changed(&mut self, now: Instant, read: impl Fn(&str) -> Content) -> Vec<String> {
        if self.due().is_none_or(|due| due > now) {
            return Vec::new();
        }
        let contents: Vec<(String, Content)> = self.touched.keys().map(|path| (path.clone(), read(path))).collect();
        let mut wait = false;
        for (path, content) in &contents {
            let gone = matches!(content, Content::Missing | Content::Empty);
            let was_there = matches!(self.known.get(path), Some(Content::Bytes(_) | Content::Mixed));
            if gone
                && was_there
                && let Some(touched) = self.touched.get_mut(path)
            {
                let patience = touched.first + GONE_FOR_A_MOMENT;
                if now < patience {
                    touched.due = patience;
                    wait = true;
                }
            }
        }
        if wait {
            return Vec::new();
        }
        self.touched.clear();
        let mut changed = Vec::new();
        for (path, content) in contents {
            if self.known.get(&path) != Some(&content) {
                self.known.insert(path.clone(), content);
                changed.push(path);
            }
        }
        changed
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;

    /// A folder in memory with a clock: `at(ms)` moves the clock.
    struct Folder {
        start: Instant,
        files: RefCell<BTreeMap<String, Vec<u8>>>,
        debounce: Debounce,
    }

    impl Folder {
        fn new(files: &[(&str, &str)]) -> Self {
            let files: BTreeMap<String, Vec<u8>> =
                files.iter().map(|(path, text)| ((*path).to_owned(), text.as_bytes().to_vec())).collect();
            let mut debounce = Debounce::default();
            debounce.expect(files.iter().map(|(path, bytes)| (path.clone(), Content::of(bytes))));
            Self { start: Instant::now(), files: RefCell::new(files), debounce }
        }

        fn write(&mut self, ms: u64, path: &str, text: &str, activity: FileActivity) {
            self.files.borrow_mut().insert(path.to_owned(), text.as_bytes().to_vec());
            self.debounce.touch(path, activity, self.start + Duration::from_millis(ms));
        }

        fn remove(&mut self, ms: u64, path: &str) {
            self.files.borrow_mut().remove(path);
            self.debounce.touch(path, FileActivity::Finished, self.start + Duration::from_millis(ms));
        }

        fn changed(&mut self, ms: u64) -> Vec<String> {
            let files = &self.files;
            self.debounce.changed(self.start + Duration::from_millis(ms), |path| {
                files.borrow().get(path).map_or(Content::Missing, |bytes| Content::of(bytes))
            })
        }
    }

    #[test]
    fn a_plain_save_is_seen_soon_and_once() {
        let mut folder = Folder::new(&[("a", "1"), ("b", "1")]);
        folder.write(0, "a", "", FileActivity::Open);
        folder.write(1, "a", "2", FileActivity::Open);
        folder.write(1, "a", "2", FileActivity::Finished);
        assert!(folder.changed(10).is_empty());
        assert_eq!(folder.changed(17), ["a"]);
        assert!(folder.changed(1000).is_empty());
    }

    #[test]
    fn a_save_without_change_is_none() {
        let mut folder = Folder::new(&[("a", "1")]);
        folder.write(0, "a", "1", FileActivity::Finished);
        assert!(folder.changed(20).is_empty());
        // A file that does not matter is not even waited for.
        folder.write(30, "a~", "1", FileActivity::Finished);
        assert_eq!(folder.debounce.due(), None);
    }

    #[test]
    fn pieces_are_waited_for() {
        let mut folder = Folder::new(&[("a", "whole")]);
        folder.write(0, "a", "", FileActivity::Open);
        folder.write(100, "a", "ne", FileActivity::Open);
        assert!(folder.changed(200).is_empty());
        folder.write(220, "a", "new", FileActivity::Open);
        folder.write(220, "a", "new", FileActivity::Finished);
        assert_eq!(folder.changed(236), ["a"]);
    }

    #[test]
    fn a_file_that_is_gone_for_a_moment_is_no_change() {
        let mut folder = Folder::new(&[("a", "1")]);
        folder.remove(0, "a");
        assert!(folder.changed(20).is_empty());
        folder.write(100, "a", "1", FileActivity::Finished);
        assert!(folder.changed(120).is_empty());
        assert_eq!(folder.debounce.due(), None);
        // One that stays away is.
        folder.remove(1000, "a");
        assert!(folder.changed(1100).is_empty());
        assert_eq!(folder.changed(1300), ["a"]);
        folder.write(2000, "a", "1", FileActivity::Finished);
        assert_eq!(folder.changed(2020), ["a"]);
    }

    #[test]
    fn files_saved_together_change_together() {
        let mut folder = Folder::new(&[("a", "1"), ("b", "1")]);
        folder.write(0, "a", "2", FileActivity::Finished);
        folder.write(10, "b", "2", FileActivity::Finished);
        assert!(folder.changed(16).is_empty());
        assert_eq!(folder.changed(26), ["a", "b"]);
    }

    #[test]
    fn a_closed_file_is_whole_before_it_is_quiet() {
        let mut folder = Folder::new(&[("a", "1"), ("b", "1")]);
        let whole = |folder: &Folder| {
            let read =
                |path: &str| folder.files.borrow().get(path).map_or(Content::Missing, |bytes| Content::of(bytes));
            folder.debounce.whole(read).into_iter().map(|(path, _)| path).collect::<Vec<_>>()
        };
        folder.write(0, "a", "2", FileActivity::Open);
        assert!(whole(&folder).is_empty());
        folder.write(1, "a", "2", FileActivity::Finished);
        assert_eq!(whole(&folder), ["a"]);
        assert!(folder.changed(2).is_empty(), "others of the same save may follow");
        folder.write(3, "b", "2", FileActivity::Unknown);
        assert!(whole(&folder).is_empty(), "nobody says that it is closed");
        folder.write(4, "b", "1", FileActivity::Finished);
        assert_eq!(whole(&folder), ["a"], "the other one is as it was");
        folder.remove(5, "b");
        assert!(whole(&folder).is_empty(), "it may come back");
    }

    #[test]
    fn a_busy_file_is_not_waited_for_forever() {
        let mut folder = Folder::new(&[("a", "0")]);
        let mut seen = 0;
        for ms in (0..4000).step_by(10) {
            folder.write(ms, "a", &ms.to_string(), FileActivity::Finished);
            seen += folder.changed(ms).len();
        }
        assert!(seen >= 2, "{seen}");
    }
}

//! Files that the window writes beside its frames, each by a thread of its own: the text of a large buffer or the coding of a large picture takes
//! longer than a frame may.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use raxel_execute::{Captured, Progress, ReadTicket};
use raxel_output::{Pending, Table, shown, take_name, write_take};
use raxel_panels::view::Shown;
use raxel_runtime::project::Project;
use raxel_runtime::session::{TakeIdentity, TakeSoFar};
use raxel_runtime::{ReadError, Session};
use raxel_terminal::failure::{Exit, Failure, Result};

use super::elements::Elements;
use super::inspector::CopiedFor;
use super::{SLICE, Viewer};

/// Most files that are being written at once. Each holds its contents in memory.
const MOST: usize = 8;

/// Time between two looks at a copy that a thread waits for.
const LOOK: Duration = Duration::from_millis(1);

/// How long the end of the window waits for files before it says so.
const QUIETLY: Duration = Duration::from_secs(2);

/// How long it waits for a device that works on something else.
const DEVICE: Duration = Duration::from_secs(8);

/// A whole buffer as a table.
struct Whole {
    elements: Elements,
    bytes: Vec<u8>,
}

/// The device at the end of a window.
#[derive(Default)]
pub(super) struct Ending {
    /// To wait for a device that was abandoned would open it again.
    abandoned: bool,
}

impl Ending {
    /// Whether the device still works. Waits for it for a moment, unless it was abandoned.
    pub(crate) fn device_works(&self, session: &mut Session) -> bool {
        !self.abandoned && !matches!(session.wait_picture(SLICE), Ok(Progress::Done))
    }

    /// Gives up the work of the device. Copies that it has not made are reported as lost.
    pub(crate) fn abandon(&mut self, session: &mut Session) {
        session.abandon_device();
        self.abandoned = true;
    }
}

/// The files that are being written.
#[derive(Default)]
pub(super) struct Writings {
    running: Vec<Writing>,
    /// The last take could not be written, which was reported: it is not tried again by itself.
    refused_take: bool,
    /// Files that have no contents yet. Only threads look at them: to look whether a file exists may take long.
    places: Arc<Mutex<BTreeSet<PathBuf>>>,
}

struct Writing {
    what: String,
    /// The take that it is.
    take: Option<TakeIdentity>,
    thread: JoinHandle<Result<Written>>,
}

/// Something that was written.
#[derive(Debug, PartialEq, Eq)]
enum Written {
    File(PathBuf),
    /// A take, in words.
    Take(String),
}

/// The place of a file that will be written.
struct Place {
    path: PathBuf,
    places: Arc<Mutex<BTreeSet<PathBuf>>>,
}

impl Place {
    /// A file of this name and extension in the current folder that does not exist yet, and that no other thread writes.
    fn free(name: &str, extension: &str, places: &Arc<Mutex<BTreeSet<PathBuf>>>) -> Self {
        let plain = |c: char| if c.is_alphanumeric() || "-_@".contains(c) { c } else { '_' };
        let name: String = name.chars().map(plain).collect();
        let numbered = |n| if n == 1 { format!("{name}.{extension}") } else { format!("{name}-{n}.{extension}") };
        let mut taken = lock(places);
        let is_free = |path: &PathBuf| !path.exists() && !taken.contains(path);
        let path = (1..10_000).map(numbered).map(PathBuf::from).find(is_free).unwrap_or_default();
        taken.insert(path.clone());
        Self { path, places: places.clone() }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        lock(&self.places).remove(&self.path);
    }
}

fn lock(places: &Mutex<BTreeSet<PathBuf>>) -> MutexGuard<'_, BTreeSet<PathBuf>> {
    // The set is whole after every operation.
    places.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Whole {
    /// Writes the buffer as CSV, with a row for each element.
    fn write(&self, path: &Path) -> Result {
        let names = self.elements.names();
        let mut table = Table::new(names.iter().map(String::as_str).collect::<Vec<_>>().iter())?;
        for row in 0..self.elements.count(self.bytes.len() as u64) {
            table.row(self.elements.row(&self.bytes, 0, row).into_iter())?;
        }
        Ok(Pending::new(path)?.finish(&table.finish()?)?)
    }
}

impl Writings {
    /// Writes contents to a file of this name and extension in the current folder that does not exist yet.
    ///
    /// # Errors
    /// Too many are being written, in one line.
    fn write<T>(
        &mut self,
        name: &str,
        extension: &'static str,
        contents: impl FnOnce() -> Result<T> + Send + 'static,
        write: impl FnOnce(&Path, T) -> Result + Send + 'static,
    ) -> std::result::Result<(), String> {
        let (named, places) = (name.to_owned(), self.places.clone());
        self.begin(format!("{name}.{extension}"), None, move || {
            // First, which ends the ticket of a copy: frames need tickets too, and there are only a few. A disk may take long.
            let contents = contents()?;
            let place = Place::free(&named, extension, &places);
            write(&place.path, contents)?;
            Ok(Written::File(place.path.clone()))
        })
    }

    /// Whether files are being written.
    pub(crate) fn are_running(&self) -> bool {
        !self.running.is_empty()
    }

    /// Whether one more file can be written.
    pub(crate) fn has_room(&self) -> bool {
        self.running.len() < MOST
    }

    fn begin(
        &mut self,
        what: String,
        take: Option<TakeIdentity>,
        write: impl FnOnce() -> Result<Written> + Send + 'static,
    ) -> std::result::Result<(), String> {
        if !self.has_room() {
            return Err(format!("{what} is not written: {MOST} other files are being written"));
        }
        self.running.push(Writing { what, take, thread: thread::spawn(write) });
        Ok(())
    }

    /// The files that are done, each with the take that it is.
    fn done(&mut self) -> Vec<(Option<TakeIdentity>, Result<Written>)> {
        let ended = self.running.extract_if(.., |writing| writing.thread.is_finished());
        let result = |Writing { what, take, thread }| {
            // A panic of the thread was shown when it happened.
            let lost = |_| Err(Failure::new(Exit::Usage, format!("`{what}` was not written")));
            let result = thread.join().unwrap_or_else(lost);
            (take, result)
        };
        ended.map(result).collect()
    }
}

/// A copy, once it has come. A thread that writes it waits here. The ticket ends with it.
#[expect(clippy::needless_pass_by_value, reason = "a ticket that is held keeps others from being made")]
fn awaited<T>(ticket: ReadTicket<T>) -> Result<T> {
    loop {
        match ticket.poll() {
            Ok(Some(copy)) => return Ok(copy),
            Ok(None) => thread::sleep(LOOK),
            Err(error) => return Err(ReadError::from(error).into()),
        }
    }
}

/// Writes a take as a demo of its project. Returns a message.
fn written(project: &Project, take: &TakeSoFar) -> Result<String> {
    let name = take_name(project, None)?;
    let take = take.finish(&name).map_err(|error| Failure::new(Exit::Usage, error.to_string()))?;
    let path = write_take(project, &name, &take)?;
    let why = take.ended.map_or(String::new(), |why| format!("; it ended early, since {why}"));
    Ok(format!("wrote a take of {:.1} s to {path}{why}", take.seconds))
}

impl Viewer<'_> {
    /// Writes the buffer whose rows are shown as CSV, as the last frame left it.
    pub(super) fn write_table(&mut self) {
        let Some((shown, total)) = self.inspector.table() else { return };
        // A copy within a frame has to be made by the next one.
        let at_end = shown.after.is_none() && shown.age == 0;
        match at_end.then(|| self.session.request_buffer(&shown.resource, 0..total)) {
            Some(Ok(ticket)) => {
                let elements = Elements::of(self.session.graph(), &shown.resource);
                self.write_bytes(&shown, elements, move || awaited(ticket));
            }
            Some(Err(_)) | None => self.inspector.copy(CopiedFor::Table, shown),
        }
    }

    /// Writes a copy of a whole buffer that a frame has made.
    pub(super) fn write_copied(&mut self, shown: &Shown, elements: Option<Elements>, copy: Arc<Captured>) {
        self.write_bytes(shown, elements, move || match &*copy {
            Captured::Bytes { bytes, .. } => Ok(bytes.clone()),
            Captured::Texels(_) => Ok(Vec::new()),
        });
    }

    fn write_bytes(
        &mut self,
        shown: &Shown,
        elements: Option<Elements>,
        bytes: impl FnOnce() -> Result<Vec<u8>> + Send + 'static,
    ) {
        let name = &shown.resource;
        let Some(elements) = elements else {
            return self.warn(format!("{name}.csv is not written: the graph has no such buffer"));
        };
        let begun = self.writings.write(name, "csv", bytes, move |path, bytes| Whole { elements, bytes }.write(path));
        self.said(begun);
    }

    /// Writes the shown target as PNG.
    pub(super) fn screenshot(&mut self) -> Result {
        let ticket = self.session.request_picture()?;
        let frame = self.session.clock().now().map_or(0, |time| time.index);
        let name = format!("{}-{}-{frame:05}", self.session.graph().name, self.target());
        let write = |path: &Path, picture| Ok(raxel_output::write_picture(Pending::new(path)?, &picture)?);
        let begun = self.writings.write(&name, "png", move || awaited(ticket), write);
        self.said(begun);
        Ok(())
    }

    /// Writes the take so far. The recording goes on until the file is there: if it cannot be written, nothing is lost.
    fn write_take(&mut self) {
        // A request of the program may write it, too.
        if self.session.is_take_written() {
            return self.notice("the take is being written".to_owned());
        }
        match self.session.take_so_far() {
            Ok(take) => {
                let project = self.session.project().clone();
                let identity = Some(take.identity());
                let write = move || written(&project, &take).map(Written::Take);
                let begun = self.writings.begin("the take".to_owned(), identity, write);
                self.said(begun);
            }
            Err(error) => self.warn(error.to_string()),
        }
    }

    /// Reports the files that are written.
    pub(super) fn report_written(&mut self) {
        for (take, done) in self.writings.done() {
            match done {
                Ok(Written::File(path)) => self.say(format!("wrote {}", shown(&path))),
                Ok(Written::Take(said)) => {
                    if let Some(take) = &take {
                        self.session.stop_recording_of(take);
                    }
                    self.say(said);
                }
                Err(failure) => {
                    self.writings.refused_take |= take.is_some();
                    self.notice(failure.message.clone().unwrap_or_default());
                    self.console.failure(&failure);
                }
            }
        }
    }

    /// Writes a take that has ended by itself. If that fails, the user may press the key again.
    pub(super) fn end_take(&mut self) {
        let ended = self.session.recording().filter(|(_, ended)| ended.is_some());
        match ended {
            // Another take may be written.
            None => self.writings.refused_take = false,
            // It ended before its first frame: there is nothing to write.
            Some((seconds, _)) if seconds <= 0.0 && self.writings.refused_take => self.session.stop_recording(),
            Some(_) => {
                // While too many other files are being written, the take waits.
                if !self.writings.refused_take && !self.session.is_take_written() && self.writings.has_room() {
                    self.write_take();
                }
            }
        }
    }

    /// Writes the take, whether it could be written before or not.
    pub(super) fn write_take_again(&mut self) {
        self.writings.refused_take = false;
        self.write_take();
    }

    /// Says something on the terminal and in the bar.
    fn say(&mut self, text: String) {
        self.console.message(&text);
        self.notice(text);
    }

    /// At the end: waits for the files that are being written.
    pub(super) fn finish_writing(&mut self, ending: &mut Ending) {
        let (began, mut told) = (Instant::now(), false);
        loop {
            self.report_written();
            let mut control = self.control.take();
            let is_writing = control.as_mut().is_some_and(|control| control.is_writing(self));
            self.control = control;
            if !is_writing && self.writings.running.is_empty() {
                return;
            }
            if !told && began.elapsed() > QUIETLY {
                told = true;
                let names: Vec<&str> = self.writings.running.iter().map(|writing| writing.what.as_str()).collect();
                let names = if names.is_empty() { "the program's file".to_owned() } else { names.join(", ") };
                self.console.message(&format!("waits until {names} is written; Ctrl+C gives it up"));
            }
            if ending.device_works(&mut self.session) && began.elapsed() > DEVICE {
                ending.abandon(&mut self.session);
            }
            thread::sleep(LOOK);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panel_data::tests::{FILL, open};

    #[test]
    fn a_device_that_was_abandoned_is_not_opened_again() {
        let folder = tempfile::tempdir().unwrap();
        let graph = "name = \"one\"\npresent = \"a\"\n[targets.a]\nformat = \"r32f\"\n\
            [[passes]]\nname = \"fill\"\nshader = \"fill.comp\"\ndispatch = { threads = \"a\" }\nbind = { c = \"a\" }\n";
        let mut session = open(&folder, &[("graphs/one.toml", graph), ("shaders/fill.comp", FILL)]);
        session.frame().unwrap();
        session.wait().unwrap();
        let (device, mut ending) = (session.device().id(), Ending::default());
        assert!(!ending.device_works(&mut session));
        ending.abandon(&mut session);
        assert!(!ending.device_works(&mut session));
        assert_eq!(session.device().id(), device);
    }

    /// A buffer of this many words.
    fn words(count: u32) -> Whole {
        Whole { elements: Elements::of_words(4), bytes: (0..count).flat_map(u32::to_le_bytes).collect() }
    }

    #[test]
    fn a_table_has_a_row_for_each_element() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        words(3).write(&path).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "[0] u32\n0\n1\n2\n");
        assert!(words(3).write(&folder.path().join("none/a.csv")).is_err());
    }

    /// The disk of the test is as slow as a gate is closed.
    #[test]
    fn files_on_a_slow_disk_are_not_waited_for_and_there_are_not_too_many() {
        let (go, gate) = std::sync::mpsc::channel::<()>();
        let gate = Arc::new(Mutex::new(gate));
        let (mut writings, tickets) = (Writings::default(), Arc::new(()));
        // To look for a free name is slow, too.
        let slow = writings.places.clone();
        let slow = lock(&slow);
        for _ in 0..MOST {
            let (gate, ticket) = (gate.clone(), tickets.clone());
            let contents = move || {
                drop(ticket);
                Ok(())
            };
            let begun = writings.write("a picture", "png", contents, move |_, ()| {
                let _ = gate.lock().map(|gate| gate.recv());
                Ok(())
            });
            assert_eq!(begun, Ok(()));
        }
        let refused = writings.write("b", "csv", || Ok(()), |_, ()| Ok(())).unwrap_err();
        assert_eq!(refused, "b.csv is not written: 8 other files are being written");
        assert!(writings.done().is_empty());
        while Arc::strong_count(&tickets) > 1 {
            thread::sleep(LOOK);
        }
        drop(slow);
        while lock(&writings.places).len() < MOST {
            thread::sleep(LOOK);
        }
        (0..MOST).for_each(|_| go.send(()).unwrap());
        let mut all = Vec::new();
        while all.len() < MOST {
            all.extend(writings.done());
        }
        let paths: BTreeSet<PathBuf> = all
            .into_iter()
            .map(|done| match done {
                (_, Ok(Written::File(path))) => path,
                other => panic!("{other:?}"),
            })
            .collect();
        assert!(paths.len() == MOST && paths.contains(Path::new("a_picture.png")), "each has its own name: {paths:?}");
        assert!(lock(&writings.places).is_empty());
    }
}

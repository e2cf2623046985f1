//! Watches the folders of files. Folders and not files: a save that renames a new file over the old one would lose a watch on the
//! file itself.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use notify::event::{AccessKind, AccessMode, ModifyKind};
use notify::{Event, EventKind, PollWatcher, RecommendedWatcher, RecursiveMode, Watcher as _};

use super::debounce::FileActivity;

/// The interval of looks at files where the system does not report changes.
const POLL: Duration = Duration::from_millis(200);

/// The way in which a [`Watcher`] learns of changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Means {
    /// The system reports changes (inotify, `FSEvents`, `ReadDirectoryChanges`).
    System,
    /// The files are looked at now and then.
    Polling,
}

/// Watches files of a project.
pub(crate) struct Watcher {
    root: PathBuf,
    means: Means,
    inner: Box<dyn notify::Watcher + Send>,
    watched: BTreeSet<PathBuf>,
    names: Arc<Mutex<Names>>,
    tell: Tell,
}

/// The reports of a watcher.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Notice<'p> {
    /// A file, by its project path, was touched.
    File(&'p str, FileActivity),
    /// A folder of files came or went; [`Watcher::renew`] is due.
    Folder,
}

/// Gets the reports, on a thread of the watcher's.
pub(crate) type Tell = Arc<dyn Fn(Notice<'_>) + Send + Sync>;

/// The project paths of a path on disk.
#[derive(Debug, Default)]
struct Names {
    /// Files, also under the names that symbolic links lead to.
    files: BTreeMap<PathBuf, String>,
}

impl Names {
    /// The files that an event at `path` concerns: the file itself, or all below a folder.
    fn concerned(&self, path: &Path) -> Vec<(&str, bool)> {
        match self.files.get(path) {
            Some(name) => vec![(name, true)],
            None => {
                self.files.iter().filter(|(file, _)| file.starts_with(path)).map(|(_, name)| (&**name, false)).collect()
            }
        }
    }
}

impl Watcher {
    /// Watches nothing yet. `poll` asks for polling; it is also the fallback when the system's own means fail.
    pub(crate) fn new(root: &Path, poll: bool, tell: Tell) -> Self {
        let names = Arc::new(Mutex::new(Names::default()));
        let (watcher, means) = if poll { None } else { system(&names, &tell) }
            .map_or_else(|| (polling(&names, &tell), Means::Polling), |watcher| (watcher, Means::System));
        Self { root: root.to_owned(), means, inner: watcher, watched: BTreeSet::new(), names, tell }
    }

    /// Watches exactly these project paths, whether they exist or not.
    pub(crate) fn watch<'p>(&mut self, files: impl Iterator<Item = &'p str>) {
        let mut names = Names::default();
        let mut folders = BTreeSet::from([self.root.clone()]);
        for file in files {
            let path = self.root.join(file);
            // Folders up to the root as well: one of them may be replaced, or not exist yet.
            folders.extend(
                path.ancestors().skip(1).take_while(|folder| folder.starts_with(&self.root)).map(Path::to_owned),
            );
            if let Ok(real) = path.canonicalize()
                && real != path
                && real.starts_with(&self.root)
            {
                folders.extend(real.parent().map(Path::to_owned));
                names.files.insert(real, file.to_owned());
            }
            names.files.insert(path, file.to_owned());
        }
        *self.names.lock().unwrap_or_else(PoisonError::into_inner) = names;
        folders.retain(|folder| folder.is_dir());
        for folder in self.watched.difference(&folders) {
            // It may be gone already.
            let _ = self.inner.unwatch(folder);
        }
        let new: Vec<PathBuf> = folders.difference(&self.watched).cloned().collect();
        self.watched = folders;
        for folder in new {
            if self.inner.watch(&folder, RecursiveMode::NonRecursive).is_err() && self.means == Means::System {
                return self.fall_back();
            }
        }
    }

    /// A folder was created again: watches on the old one are dead.
    pub(crate) fn renew(&mut self) {
        for folder in std::mem::take(&mut self.watched) {
            let _ = self.inner.unwatch(&folder);
        }
        let names = self.names.lock().unwrap_or_else(PoisonError::into_inner);
        let files: BTreeSet<String> = names.files.values().cloned().collect();
        drop(names);
        self.watch(files.iter().map(String::as_str));
    }

    /// The system has no watches left: look at the files instead.
    fn fall_back(&mut self) {
        self.means = Means::Polling;
        self.inner = polling(&self.names, &self.tell);
        for folder in &self.watched {
            let _ = self.inner.watch(folder, RecursiveMode::NonRecursive);
        }
    }
}

fn system(names: &Arc<Mutex<Names>>, tell: &Tell) -> Option<Box<dyn notify::Watcher + Send>> {
    let handler = handler(names, tell, cfg!(target_os = "linux"));
    RecommendedWatcher::new(handler, notify::Config::default()).ok().map(|watcher| Box::new(watcher) as _)
}

fn polling(names: &Arc<Mutex<Names>>, tell: &Tell) -> Box<dyn notify::Watcher + Send> {
    let config = notify::Config::default().with_poll_interval(POLL).with_compare_contents(true);
    match PollWatcher::new(handler(names, tell, false), config) {
        Ok(watcher) => Box::new(watcher),
        // Its constructor only fails when a thread cannot be started; then nothing is watched.
        Err(_) => Box::new(notify::NullWatcher),
    }
}

/// Turns the events of `notify` into file activities. `closes`: the system reports when a writer closes a file.
fn handler(names: &Arc<Mutex<Names>>, tell: &Tell, closes: bool) -> impl FnMut(notify::Result<Event>) + Send + use<> {
    let (names, tell) = (names.clone(), tell.clone());
    move |event| {
        let names = names.lock().unwrap_or_else(PoisonError::into_inner);
        let event = match event {
            Ok(event) if !event.need_rescan() => event,
            // Events were lost: anything may have happened.
            _ => return names.files.values().for_each(|name| tell(Notice::File(name, FileActivity::Unknown))),
        };
        let activity = match event.kind {
            EventKind::Access(AccessKind::Close(AccessMode::Write))
            | EventKind::Remove(_)
            | EventKind::Modify(ModifyKind::Name(_)) => FileActivity::Finished,
            EventKind::Access(_) => return,
            // Rights and times. Polling has no other event for a change of contents.
            EventKind::Modify(ModifyKind::Metadata(_)) if closes => return,
            _ if closes => FileActivity::Open,
            _ => FileActivity::Unknown,
        };
        for path in &event.paths {
            for (name, itself) in names.concerned(path) {
                if itself {
                    tell(Notice::File(name, activity));
                } else {
                    // The change of a folder does not show how its files were written.
                    tell(Notice::File(name, FileActivity::Unknown));
                    tell(Notice::Folder);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::mpsc::{Receiver, channel};
    use std::time::Instant;

    use super::*;

    fn watch(root: &Path, poll: bool, files: &[&str]) -> (Watcher, Receiver<(String, FileActivity)>) {
        let (sender, receiver) = channel();
        let tell: Tell = Arc::new(move |notice| {
            if let Notice::File(name, activity) = notice {
                let _ = sender.send((name.to_owned(), activity));
            }
        });
        let mut watcher = Watcher::new(root, poll, tell);
        watcher.watch(files.iter().copied());
        (watcher, receiver)
    }

    /// Waits for a touch of the file that ends a step of a save.
    fn wait(receiver: &Receiver<(String, FileActivity)>, name: &str, activity: FileActivity) -> bool {
        let end = Instant::now() + Duration::from_secs(5);
        while let Ok(found) = receiver.recv_timeout(end.saturating_duration_since(Instant::now())) {
            if found == (name.to_owned(), activity) {
                return true;
            }
        }
        false
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn every_way_of_saving_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        fs::create_dir(root.join("shaders")).unwrap();
        fs::write(root.join("shaders/a.comp"), "1").unwrap();
        let (mut watcher, receiver) = watch(&root, false, &["shaders/a.comp", "shaders/include/new.glsl"]);
        assert_eq!(watcher.means, Means::System);
        let finished = |what: &str, name: &str| assert!(wait(&receiver, name, FileActivity::Finished), "{what}");

        fs::write(root.join("shaders/a.comp"), "2").unwrap();
        finished("in place", "shaders/a.comp");
        fs::write(root.join("shaders/.a.comp.swp"), "3").unwrap();
        fs::rename(root.join("shaders/.a.comp.swp"), root.join("shaders/a.comp")).unwrap();
        finished("renamed over", "shaders/a.comp");
        fs::write(root.join("shaders/a.comp"), "4").unwrap();
        finished("in place after a rename", "shaders/a.comp");
        fs::remove_file(root.join("shaders/a.comp")).unwrap();
        finished("deleted", "shaders/a.comp");
        fs::write(root.join("shaders/a.comp"), "5").unwrap();
        finished("made again", "shaders/a.comp");

        // A folder that did not exist: the watcher reports its creation, and its files once it is watched.
        fs::create_dir(root.join("shaders/include")).unwrap();
        assert!(wait(&receiver, "shaders/include/new.glsl", FileActivity::Unknown));
        watcher.renew();
        fs::write(root.join("shaders/include/new.glsl"), "").unwrap();
        finished("in a new folder", "shaders/include/new.glsl");
    }

    #[test]
    fn polling_notices_too() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        fs::write(root.join("a"), "1").unwrap();
        let (watcher, receiver) = watch(&root, true, &["a"]);
        assert_eq!(watcher.means, Means::Polling);
        fs::write(root.join("a"), "22").unwrap();
        assert!(wait(&receiver, "a", FileActivity::Unknown));
    }
}

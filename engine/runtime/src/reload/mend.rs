//! Waits for the mend of a project with mistakes. All of its files are looked at now and then, since which of them it needs is not known
//! before they are right.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

use super::Waker;
use crate::manifest;

/// Time between two looks at the files.
const EVERY: Duration = Duration::from_millis(300);

/// Files that are looked at, at most: a folder that holds more is no project.
const MOST: usize = 20_000;

/// A thread that looks at the files of a project.
pub(crate) struct MendWatch {
    root: PathBuf,
    changes: Receiver<Change>,
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// Files that are worth reading again.
pub(crate) struct Change {
    /// The manifest as it was found then.
    manifest: Option<ManifestState>,
}

/// Bytes of a manifest, and when it was written.
type ManifestState = (u64, SystemTime);

impl MendWatch {
    /// Watches the project in the folder `root`. `said` is true if its manifest had text when it was read: now an editor may be saving it.
    /// `waker` is called after each change.
    pub(crate) fn start(root: &Path, said: bool, waker: Option<Waker>) -> std::io::Result<Self> {
        let (sender, changes) = channel();
        let (stop, stopped) = channel();
        let mut files = Files::new(root.to_owned(), said);
        let look = move || {
            while stopped.recv_timeout(EVERY) == Err(RecvTimeoutError::Timeout) {
                if files.changed() {
                    if sender.send(Change { manifest: files.manifest }).is_err() {
                        return;
                    }
                    waker.iter().for_each(|waker| waker());
                }
            }
        };
        let thread = std::thread::Builder::new().name("raxel-mend".to_owned()).spawn(look)?;
        Ok(Self { root: root.to_owned(), changes, stop: Some(stop), thread: Some(thread) })
    }

    /// The newest change since the last call.
    pub(crate) fn poll(&self) -> Option<Change> {
        self.changes.try_iter().last()
    }

    /// The same; waits for it.
    pub(crate) fn wait(&self, timeout: Duration) -> Option<Change> {
        let first = self.changes.recv_timeout(timeout).ok()?;
        Some(self.poll().unwrap_or(first))
    }

    /// Whether the manifest is unchanged since a change, so that the values read since then hold. A session that is open follows all other
    /// files by itself.
    pub(crate) fn manifest_holds(&self, change: &Change) -> bool {
        change.manifest == manifest_state(&self.root)
    }
}

impl Drop for MendWatch {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // A panic of the thread was shown when it happened.
            let _ = thread.join();
        }
    }
}

/// The files of a project, looked at now and then.
struct Files {
    root: PathBuf,
    /// Their hash when they were read last. Before the first look they may have changed since then.
    read: Option<u64>,
    /// Their hash at the last look.
    seen: Option<u64>,
    /// There is a manifest that has had text.
    said: bool,
    /// The manifest when they were read last.
    manifest: Option<ManifestState>,
}

impl Files {
    fn new(root: PathBuf, said: bool) -> Self {
        let said = said || manifest_length(&root) > 0;
        Self { root, read: None, seen: None, said, manifest: None }
    }

    /// Whether they are worth reading: they differ from the last read, nothing has touched them since the last look, and none is being
    /// saved. A manifest that has become empty is being saved: read now, it would open the defaults. Who wants those deletes it.
    fn changed(&mut self) -> bool {
        let signature = Some(signature(&self.root));
        let quiet = std::mem::replace(&mut self.seen, signature) == signature;
        let length = manifest_length(&self.root);
        self.said = manifest_state(&self.root).is_some() && (self.said || length > 0);
        if !quiet || signature == self.read || (self.said && length == 0) {
            return false;
        }
        (self.read, self.manifest) = (signature, manifest_state(&self.root));
        true
    }
}

/// Bytes of the manifest; 0 without one.
fn manifest_length(root: &Path) -> u64 {
    manifest_state(root).map_or(0, |(length, _)| length)
}

/// Bytes of the manifest, and when it was written; `None` without one.
fn manifest_state(root: &Path) -> Option<ManifestState> {
    let found = root.join(manifest::PATH).metadata().ok()?;
    Some((found.len(), found.modified().unwrap_or(SystemTime::UNIX_EPOCH)))
}

/// Changes when a file of the project does.
fn signature(root: &Path) -> u64 {
    let mut hasher = DefaultHasher::new();
    let mut folders = vec![root.to_owned()];
    let mut left = MOST;
    while let Some(folder) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(&folder) else { continue };
        let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        paths.sort();
        for path in paths {
            let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
            let Some(rest) = left.checked_sub(1) else { return hasher.finish() };
            left = rest;
            match path.metadata() {
                Ok(found) if found.is_dir() && !hidden && !path.ends_with("target") => folders.push(path),
                Ok(found) if found.is_file() => {
                    (path, found.len(), found.modified().ok()).hash(&mut hasher);
                }
                _ => {}
            }
        }
    }
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signature_follows_the_files() {
        let project = tempfile::tempdir().unwrap();
        std::fs::create_dir(project.path().join("graphs")).unwrap();
        let file = project.path().join("graphs/a.toml");
        let seen = || signature(project.path());
        let before = seen();
        std::fs::write(&file, "a").unwrap();
        let first = seen();
        assert_ne!(before, first);
        assert_eq!(first, seen());
        std::fs::write(&file, "ab").unwrap();
        assert_ne!(first, seen());
        // raxel's own files beside the project do not count.
        let second = seen();
        std::fs::create_dir(project.path().join(".raxel")).unwrap();
        std::fs::write(project.path().join(".raxel/window.toml"), "x").unwrap();
        assert_eq!(second, seen());
    }

    #[test]
    fn files_are_read_when_they_are_whole() {
        let project = tempfile::tempdir().unwrap();
        let path = project.path().join(manifest::PATH);
        std::fs::write(&path, "wrong").unwrap();
        let mut files = Files::new(project.path().to_owned(), false);
        let mut looks = |expected: [bool; 3]| assert_eq!([(); 3].map(|()| files.changed()), expected);
        // They may have changed before the first look; after the second one only a change counts.
        looks([false, true, false]);
        // Emptied by a save that is not at its end, however long that takes.
        std::fs::write(&path, "").unwrap();
        looks([false, false, false]);
        std::fs::write(&path, "graph = 'a.toml'").unwrap();
        looks([false, true, false]);
        std::fs::remove_file(&path).unwrap();
        looks([false, true, false]);
        // A manifest that had no text before may be empty.
        std::fs::write(&path, "").unwrap();
        looks([false, true, false]);
    }

    #[test]
    fn a_thread_tells_of_changes_and_stops() {
        let project = tempfile::tempdir().unwrap();
        let woken = std::sync::Arc::new(std::sync::atomic::AtomicUsize::new(0));
        let count = woken.clone();
        let waker: Waker = std::sync::Arc::new(move || {
            count.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
        });
        let watch = MendWatch::start(project.path(), false, Some(waker)).unwrap();
        let patience = Duration::from_secs(60);
        watch.wait(patience).expect("what may have changed before the first look");
        std::fs::write(project.path().join(manifest::PATH), "graph = 'a.toml'").unwrap();
        let change = watch.wait(patience).expect("the file");
        assert!(watch.manifest_holds(&change) && woken.load(std::sync::atomic::Ordering::SeqCst) >= 1);
        assert!(watch.poll().is_none());
        drop(watch);
        assert_eq!(std::sync::Arc::strong_count(&woken), 1, "the thread has ended");
    }

    #[test]
    fn a_manifest_that_was_emptied_before_the_first_look_is_waited_for_and_what_changes_meanwhile_is_seen() {
        let project = tempfile::tempdir().unwrap();
        let path = project.path().join(manifest::PATH);
        std::fs::write(&path, "").unwrap();
        let mut files = Files::new(project.path().to_owned(), true);
        assert_eq!([(); 3].map(|()| files.changed()), [false; 3]);
        std::fs::write(&path, "graph = 'a.toml'").unwrap();
        assert_eq!([(); 2].map(|()| files.changed()), [false, true]);
        assert_eq!(files.manifest, manifest_state(project.path()));
        std::fs::write(&path, "").unwrap();
        assert_ne!(files.manifest, manifest_state(project.path()));
    }
}

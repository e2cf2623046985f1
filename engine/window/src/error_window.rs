//! A window over files that are broken: it says what is wrong, and goes on by itself when they are mended.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_gpu::{Device, DeviceOptions};
use raxel_panels::view::Problem;
use raxel_panels::{Action, Panels};
use raxel_runtime::manifest;
use raxel_runtime::present::{Presented, Presenter};
use raxel_terminal::console::Console;
use raxel_terminal::failure::Result;
use winit::window::Window;

use super::GROUND;
use super::editor::Editors;
use super::presenting::Open;
use super::problem_log::problems;

/// Time between two looks at the files.
const EVERY: Duration = Duration::from_millis(300);

/// Files that are looked at, at most: a folder that holds more is no project.
const MOST: usize = 20_000;

/// What a window needs while there is no session.
pub(super) struct ErrorWindow {
    device: Arc<Device>,
    files: Files,
    looked: Instant,
    /// What was found last.
    found: Vec<Diagnostic>,
    problems: Vec<Problem>,
    panels: Panels,
    editors: Editors,
    pub(super) open: Option<Open>,
}

impl ErrorWindow {
    /// For the project at a folder, whose files were found to be wrong.
    pub fn new(root: PathBuf, options: &DeviceOptions, diagnostics: &[Diagnostic], texts: &SourceMap) -> Result<Self> {
        let device = Device::new(options)?;
        let (found, problems) = (diagnostics.to_vec(), problems(diagnostics, texts));
        // What was read then counts: it may be in the middle of a save by now.
        let said = texts.get(manifest::PATH).is_some_and(|text| !text.is_empty());
        let (files, looked) = (Files::new(root, said), Instant::now());
        let (panels, editors) = (Panels::default(), Editors::default());
        Ok(Self { device, files, looked, found, problems, panels, editors, open: None })
    }

    /// The device that the session will have, as far as is known.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// The same, and the one that presents the window.
    pub fn devices(&self) -> impl Iterator<Item = &Arc<Device>> {
        [&self.device].into_iter().chain(self.open.as_ref().map(|open| open.presenter.device()))
    }

    /// Takes the mistakes that are there now. False when they are the same as before.
    pub fn found(&mut self, diagnostics: &[Diagnostic], texts: &SourceMap) -> bool {
        if self.found == diagnostics {
            return false;
        }
        (self.found, self.problems) = (diagnostics.to_vec(), problems(diagnostics, texts));
        true
    }

    /// Whether the files are others than those that were read last, and whole. Looks now and then.
    pub fn changed(&mut self) -> bool {
        if self.looked.elapsed() < EVERY {
            return false;
        }
        self.looked = Instant::now();
        self.files.changed()
    }

    /// Whether nothing has touched the manifest since [`Self::changed`] said yes: what was read of it meanwhile holds.
    pub fn manifest_holds(&self) -> bool {
        self.files.manifest_holds()
    }

    /// Shows what is wrong, and does what is asked for there.
    pub fn draw(&mut self, console: &Console) -> Result {
        let Some(Open { window, presenter, overlay, .. }) = &mut self.open else { return Ok(()) };
        let (panels, found) = (&mut self.panels, &self.problems);
        let title = "The files have mistakes";
        let actions = overlay.draw(window, |context| panels.waiting(context, title, found));
        for action in actions {
            match action {
                Action::Copy(text) => overlay.copy(text),
                Action::Edit(place) => {
                    if let Err(why) = self.editors.open(&self.files.root, &place) {
                        console.message(&format!("warning: {why}"));
                    }
                }
                _ => {}
            }
        }
        match overlay
            .present(presenter, |presenter: &mut Presenter, frame| presenter.present_blank(GROUND, Some(frame)))
        {
            Ok(Presented::Shown | Presented::NoArea | Presented::OutOfDate | Presented::NotReady) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// The window, for the session that shows pictures in it. What it was drawn with is gone.
    pub fn into_window(self) -> Option<Arc<Window>> {
        self.open.map(|open| open.window.clone())
    }
}

/// The files of a project, looked at now and then.
struct Files {
    root: PathBuf,
    /// What they were when they were read last. Before the first look they may have changed since then.
    read: Option<u64>,
    /// What they were at the last look.
    seen: Option<u64>,
    /// There is a manifest that has said something.
    said: bool,
    /// The manifest when they were read last.
    manifest: Option<(u64, SystemTime)>,
}

impl Files {
    fn new(root: PathBuf, said: bool) -> Self {
        let said = said || manifest_length(&root) > 0;
        Self { root, read: None, seen: None, said, manifest: None }
    }

    /// Whether they are worth reading: they differ from what was read last, nothing has touched them since the last look, and none is in the
    /// middle of a save. A manifest that has become empty is in that middle: read, it would open the defaults. Who wants those deletes it.
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

    /// Whether the manifest is still what it was when [`Self::changed`] found it worth reading. A session follows all other files by itself.
    fn manifest_holds(&self) -> bool {
        self.manifest == manifest_state(&self.root)
    }
}

/// Bytes of the manifest; 0 without one.
fn manifest_length(root: &Path) -> u64 {
    manifest_state(root).map_or(0, |(length, _)| length)
}

/// Bytes of the manifest, and when it was written; `None` without one.
fn manifest_state(root: &Path) -> Option<(u64, SystemTime)> {
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
        // What raxel itself keeps beside the project does not count.
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
        // One that said nothing before may be empty.
        std::fs::write(&path, "").unwrap();
        looks([false, true, false]);
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
        assert!(files.manifest_holds());
        std::fs::write(&path, "").unwrap();
        assert!(!files.manifest_holds());
    }
}

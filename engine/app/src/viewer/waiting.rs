//! A window over files that are broken: it says what is wrong, and goes on by itself when they are mended.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_gpu::{Device, DeviceOptions};
use raxel_panels::view::Problem;
use raxel_panels::{Action, Panels};
use raxel_runtime::present::{Presented, Presenter};
use winit::window::Window;

use super::Open;
use super::editor::Editors;
use super::problem_log::problems;
use crate::console::Console;
use crate::failure::Result;

/// Time between two looks at the files.
const EVERY: Duration = Duration::from_millis(300);

/// Files that are looked at, at most: a folder that holds more is no project.
const MOST: usize = 20_000;

/// The ground of the window.
const GROUND: [f32; 3] = [0.078, 0.078, 0.078];

/// What a window needs while there is no session.
pub(super) struct Waiting {
    device: Arc<Device>,
    root: PathBuf,
    /// Of the files, at the last look. Before the first look they may have changed since they were read.
    signature: Option<u64>,
    looked: Instant,
    /// What was found last.
    found: Vec<Diagnostic>,
    problems: Vec<Problem>,
    panels: Panels,
    editors: Editors,
    pub(super) open: Option<Open>,
}

impl Waiting {
    /// For the project at a folder, whose files were found to be wrong.
    pub fn new(root: PathBuf, options: &DeviceOptions, diagnostics: &[Diagnostic], texts: &SourceMap) -> Result<Self> {
        let device = Device::new(options)?;
        let (found, problems) = (diagnostics.to_vec(), problems(diagnostics, texts));
        let (signature, looked) = (None, Instant::now());
        let (panels, editors) = (Panels::default(), Editors::default());
        Ok(Self { device, root, signature, looked, found, problems, panels, editors, open: None })
    }

    /// The device that the window is drawn on.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// Takes the mistakes that are there now. False when they are the same as before.
    pub fn found(&mut self, diagnostics: &[Diagnostic], texts: &SourceMap) -> bool {
        if self.found == diagnostics {
            return false;
        }
        (self.found, self.problems) = (diagnostics.to_vec(), problems(diagnostics, texts));
        true
    }

    /// Whether files have changed since the last look. Looks now and then.
    pub fn changed(&mut self) -> bool {
        if self.looked.elapsed() < EVERY {
            return false;
        }
        self.looked = Instant::now();
        let signature = Some(signature(&self.root));
        std::mem::replace(&mut self.signature, signature) != signature
    }

    /// Shows what is wrong, and does what is asked for there.
    pub fn draw(&mut self, console: &Console) -> Result {
        let Some(Open { window, presenter, overlay }) = &mut self.open else { return Ok(()) };
        let (panels, found) = (&mut self.panels, &self.problems);
        let title = "The files have mistakes";
        let actions = overlay.draw(window, |context| panels.waiting(context, title, found));
        for action in actions {
            match action {
                Action::Copy(text) => overlay.copy(text),
                Action::Edit(place) => {
                    if let Err(why) = self.editors.open(&self.root, &place) {
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
}

//! The layout of the panels, in `.raxel/window.toml` of the project: beside the files of the project, never in them.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use raxel_output::replace;
use raxel_panels::Layout;

/// Where a project's layout is.
pub(crate) struct LayoutFile {
    path: PathBuf,
    /// As it was read, or was to be written last.
    known: Option<Layout>,
    /// At the last look.
    seen: Option<Layout>,
}

impl LayoutFile {
    /// Of the project at a folder.
    pub(crate) fn of(project: &Path) -> Self {
        Self { path: project.join(".raxel/window.toml"), known: None, seen: None }
    }

    /// The layout; the default where there is none, or, with a message, where it cannot be read.
    pub(crate) fn read(&mut self) -> (Layout, Option<String>) {
        let read = match fs::read_to_string(&self.path) {
            Ok(text) => Layout::read(&text),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Layout::default()),
            Err(error) => Err(error.to_string()),
        };
        let (layout, said) = match read {
            Ok(layout) => (layout, None),
            Err(error) => {
                (Layout::default(), Some(format!("{}: {error}; the panels are as at first", self.path.display())))
            }
        };
        self.known = Some(layout.clone());
        (layout, said)
    }

    /// Keeps the layout, if it has not changed since the last look: one that is being dragged is not written at every step.
    pub(crate) fn look(&mut self, layout: &Layout) -> std::io::Result<()> {
        let settled = self.seen.replace(layout.clone()).as_ref() == Some(layout);
        if settled { self.write(layout) } else { Ok(()) }
    }

    /// Keeps the layout, if it differs from the file's. If it cannot be written, raxel tries again only after a change.
    pub(crate) fn write(&mut self, layout: &Layout) -> std::io::Result<()> {
        if self.known.as_ref() == Some(layout) {
            return Ok(());
        }
        self.known = Some(layout.clone());
        if let Some(folder) = self.path.parent() {
            fs::create_dir_all(folder)?;
        }
        replace(&self.path, layout.write().as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use raxel_panels::Panel;

    use super::*;

    #[test]
    fn a_layout_is_kept_and_a_broken_one_is_said() {
        let project = tempfile::tempdir().unwrap();
        let mut file = LayoutFile::of(project.path());
        let (mut layout, said) = file.read();
        assert_eq!((&layout, said), (&Layout::default(), None));
        file.write(&layout).unwrap();
        assert!(!file.path.exists(), "what is as at first needs no file");
        layout.open(Panel::World);
        file.write(&layout).unwrap();
        assert_eq!(LayoutFile::of(project.path()).read(), (layout.clone(), None));
        fs::remove_file(&file.path).unwrap();
        layout.toggle(Panel::World);
        file.look(&layout).unwrap();
        assert!(!file.path.exists(), "it may change again");
        file.look(&layout).unwrap();
        assert_eq!(LayoutFile::of(project.path()).read(), (layout, None));
        fs::write(&file.path, "docks = 7").unwrap();
        let (layout, said) = file.read();
        assert!(layout == Layout::default() && said.is_some_and(|said| said.contains("window.toml")));
    }
}

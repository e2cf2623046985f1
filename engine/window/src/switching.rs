//! Another graph, world or demo of the project replaces the running one.

use raxel_panels::view;
use raxel_panels::view::FileKind;
use raxel_runtime::Session;
use raxel_runtime::reload::ProjectFile;
use raxel_workbench::files;
use raxel_workbench::files::Openable;

use super::Viewer;

/// The files of the project that can be opened, as the panels list them.
pub(super) fn list(session: &Session) -> Vec<view::ProjectFile> {
    let file = |Openable { file, runs }: Openable| {
        let kind = match &file {
            ProjectFile::Demo(_) => FileKind::Demo,
            ProjectFile::World(_) => FileKind::World,
            ProjectFile::Graph(_) => FileKind::Graph,
        };
        view::ProjectFile { kind, path: file.path().to_owned(), runs }
    };
    files::list(session).into_iter().map(file).collect()
}

impl Viewer<'_> {
    /// Opens a file in place of the running one. Until it is right, the last picture stays.
    pub(super) fn open_file(&mut self, kind: FileKind, path: String) {
        self.notice(format!("opens {path}"));
        let file = match kind {
            FileKind::Demo => ProjectFile::Demo(path),
            FileKind::World => ProjectFile::World(path),
            FileKind::Graph => ProjectFile::Graph(path),
        };
        if !self.session.open_file(file) {
            self.warn("files are not watched: nothing else can be opened".to_owned());
        }
    }

    /// Other files run from here on: choices for the old ones do not apply to them.
    pub(super) fn begin_opened(&mut self) {
        self.home = *self.session.camera();
        (self.before_peek, self.looped, self.refused, self.painting) = (None, None, None, None);
        self.written.clear();
        self.recorder.forget();
        self.history.forget_session();
    }
}

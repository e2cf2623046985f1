//! Another graph, world or demo of the project replaces the running one.

use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;

use raxel_panels::view;
use raxel_panels::view::FileKind;
use raxel_runtime::Session;
use raxel_runtime::reload::ProjectFile;
use raxel_workbench::files::{Lister, Openable};

use super::Viewer;

/// The files of the project that can be opened, as they were listed last. A thread lists them: a folder may be on a slow disk.
#[derive(Default)]
pub(super) struct Files {
    listed: Option<Vec<view::ProjectFile>>,
    listing: Option<Receiver<Vec<Openable>>>,
}

impl Files {
    /// Lists them again. A listing that is under way serves, too.
    pub(crate) fn begin(&mut self, session: &Session) {
        self.listed = None;
        if self.listing.is_some() {
            return;
        }
        let lister = Lister::of(session);
        let (send, listing) = channel();
        thread::spawn(move || {
            // A window that was closed does not wait for it.
            let _ = send.send(lister.list());
        });
        self.listing = Some(listing);
    }

    /// Takes the list, once it is there. Whether it is news.
    pub(crate) fn take(&mut self) -> bool {
        let Some(listed) = self.listing.as_ref().map(Receiver::try_recv) else { return false };
        match listed {
            Ok(files) => (self.listed, self.listing) = (Some(files.into_iter().map(file).collect()), None),
            Err(TryRecvError::Empty) => return false,
            // A panic of the thread was shown when it happened.
            Err(TryRecvError::Disconnected) => (self.listed, self.listing) = (Some(Vec::new()), None),
        }
        true
    }

    /// The list; `None` while it is made.
    pub(crate) fn get(&self) -> Option<&[view::ProjectFile]> {
        self.listed.as_deref()
    }
}

/// A file, as the panels list it.
fn file(Openable { file, runs }: Openable) -> view::ProjectFile {
    let kind = match &file {
        ProjectFile::Demo(_) => FileKind::Demo,
        ProjectFile::World(_) => FileKind::World,
        ProjectFile::Graph(_) => FileKind::Graph,
    };
    view::ProjectFile { kind, path: file.path().to_owned(), runs }
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

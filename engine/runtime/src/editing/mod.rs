//! The edits of a session's world: the source below them, the newest voxels, the demo's edits, and the save.

mod saves;

pub(crate) use saves::misplaced;

use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, Severity, codes};
use raxel_edit::save::Save;
use raxel_edit::{Change, EditError, Edits, Operation, Scene, Steps};
use raxel_world::{Chunk, ChunkPos, Unavailable};

pub use saves::Saves;

use crate::world::{SessionWorld, WorldIdentity};

/// The edits of a world's file.
pub(crate) struct Editing {
    /// The world as its file builds it.
    base: Arc<SessionWorld>,
    /// That of the worlds that edits make of it.
    identity: Arc<WorldIdentity>,
    scene: Scene,
    edits: Edits,
    save: Option<Save>,
    /// The demo's edits with their times, in order.
    script: Vec<(f64, Operation)>,
    /// So many of them are made.
    scripted: usize,
    /// The next of them waits for a chunk that is unavailable.
    waiting: bool,
    /// Messages about the save, and about edits that passes write.
    messages: Vec<Diagnostic>,
}

/// The chunks that an edit changed, as positions and contents.
pub(crate) type Changes = Vec<(ChunkPos, Option<Arc<Chunk>>)>;

/// How far the demo's edits came.
#[derive(Default)]
pub(crate) struct Followed {
    /// The changes of each, in order.
    pub(crate) steps: Vec<Changes>,
    /// The chunk that the next edit would change, where the world does not have that.
    pub(crate) unavailable: Option<Unavailable>,
}

impl Editing {
    pub(crate) fn new(base: Arc<SessionWorld>) -> Self {
        let scene = base.scene();
        Self {
            base,
            identity: Arc::default(),
            scene,
            edits: Edits::default(),
            save: None,
            script: Vec::new(),
            scripted: 0,
            waiting: false,
            messages: Vec::new(),
        }
    }

    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Steps that can be undone, and redone.
    pub(crate) fn steps(&self) -> Steps {
        self.edits.steps()
    }

    /// The world after a change of the one before, which is not streamed.
    pub(crate) fn world_after(&self, before: &SessionWorld, changes: &Changes) -> Arc<SessionWorld> {
        Arc::new(before.edited(&self.identity, &self.scene.materials, changes.iter().cloned()))
    }

    /// The base with all edits; `None` when there are none, and when it is streamed: then its tiles have them.
    pub(crate) fn world(&self) -> Option<Arc<SessionWorld>> {
        if let Some(tiles) = self.base.tiles() {
            tiles.replace(&self.edits);
            return None;
        }
        if self.edits.is_empty() {
            return None;
        }
        let base = self.base.base();
        let chunk =
            |pos| self.edits.chunk(pos, base).expect("a whole world has every chunk, and its edits are unpacked");
        let chunks = self.edits.positions().map(|pos| (pos, chunk(pos)));
        Some(self.world_after(&self.base, &chunks.collect()))
    }

    /// Makes an edit, which can be undone.
    pub(crate) fn apply(&mut self, operations: &[Operation]) -> Result<Change, EditError> {
        let change = self.edits.apply(operations, &self.scene, self.base.base())?;
        self.note(&change);
        Ok(change)
    }

    pub(crate) fn undo(&mut self) -> Result<Option<Change>, Unavailable> {
        let change = self.edits.undo(self.base.base())?;
        change.iter().for_each(|change| self.note(change));
        Ok(change)
    }

    /// Takes the newest step back as if it had never been made.
    pub(crate) fn take_back(&mut self) -> Result<Option<Change>, Unavailable> {
        let change = self.edits.take_back(self.base.base())?;
        change.iter().for_each(|change| self.note(change));
        Ok(change)
    }

    pub(crate) fn redo(&mut self) -> Result<Option<Change>, Unavailable> {
        let change = self.edits.redo(self.base.base())?;
        change.iter().for_each(|change| self.note(change));
        Ok(change)
    }

    /// The tiles of a streamed world follow an edit.
    fn note(&self, change: &Change) {
        if let Some(tiles) = self.base.tiles() {
            tiles.change(change);
        }
    }

    /// Positions of all chunks that are edited.
    pub(crate) fn positions(&self) -> Vec<ChunkPos> {
        self.edits.positions().collect()
    }

    /// Saves the step of [`Editing::apply`]. A fault of the save is reported once.
    pub(crate) fn commit(&mut self, operations: &[Operation], change: &Change) {
        if let Some(save) = &mut self.save
            && let Err(error) = save.commit(operations, change)
        {
            let failing = saves::failing(&error.to_string(), self.base.loaded());
            if !self.messages.contains(&failing) {
                self.messages.push(failing);
            }
        }
    }

    /// Does the due work for the save. To be called once a frame.
    pub(crate) fn poll_save(&mut self) {
        if let Some(save) = &mut self.save {
            let events = save.poll(&self.edits);
            self.messages.extend(events.iter().filter_map(|event| saves::message(event, self.base.loaded())));
        }
    }

    /// Reports once that edits of the demo wait for a chunk, until they wait no longer.
    pub(crate) fn say_waiting(&mut self, unavailable: Option<&Unavailable>) {
        if let Some(unavailable) = unavailable.filter(|_| !self.waiting) {
            let message = format!("edits of the demo wait for the world: {unavailable}");
            self.messages.push(Diagnostic::warning(codes::world::STORE_FAILING, message));
        }
        self.waiting = unavailable.is_some();
    }

    /// Adds a message.
    pub(crate) fn say(&mut self, message: Diagnostic) {
        self.messages.push(message);
    }

    /// The messages since the last call.
    pub(crate) fn take_messages(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.messages)
    }

    /// Writes everything into a checkpoint now.
    pub(crate) fn checkpoint(&mut self) {
        if let Some(save) = &mut self.save {
            let events = save.checkpoint(&self.edits);
            self.messages.extend(events.iter().filter_map(|event| saves::message(event, self.base.loaded())));
        }
    }

    /// Another demo, or none: its edits start over.
    pub(crate) fn set_script(&mut self, script: Vec<(f64, Operation)>) {
        if self.script == script {
            return;
        }
        self.script = script;
        if self.scripted > 0 {
            // More than there are: everything is taken back when the next time comes.
            self.scripted = usize::MAX;
        }
    }

    /// Brings the demo's edits to a time. The edits at a time are all with that time or an earlier one, in order, independent of the times
    /// shown before. Those of chunks that are unavailable stay due: the next call tries them again.
    pub(crate) fn follow_script(&mut self, time: f64) -> Followed {
        let due = self.script.partition_point(|(at, _)| *at <= time);
        let mut followed = Followed::default();
        if due != self.scripted {
            followed.unavailable = self.bring_script(due, &mut followed.steps).err();
            followed.steps.retain(|changes| !changes.is_empty());
        }
        followed
    }

    /// Makes the first `due` edits of the demo, and adds to `steps` the chunks that changed.
    fn bring_script(&mut self, due: usize, steps: &mut Vec<Changes>) -> Result<(), Unavailable> {
        let base = self.base.clone();
        let base = base.base();
        let mut step = |editing: &Self, change: Change| {
            editing.note(&change);
            steps.push(change.after().collect());
        };
        if due < self.scripted {
            let change = self.edits.clear(base)?;
            step(self, change);
            self.scripted = 0;
        }
        let operations: Vec<Operation> = self.script[self.scripted..due].iter().map(|(_, edit)| edit.clone()).collect();
        // Each was checked by itself when the demo was read. If they are too many for one step, they are made one by one.
        match self.edits.replay(&operations, &self.scene, base) {
            Ok(change) => step(self, change),
            Err(EditError::Unavailable(unavailable)) => return Err(unavailable),
            Err(_) => {
                for operation in operations {
                    match self.edits.replay(&[operation], &self.scene, base) {
                        Ok(change) => step(self, change),
                        Err(EditError::Unavailable(unavailable)) => return Err(unavailable),
                        Err(_) => {}
                    }
                    self.scripted += 1;
                }
            }
        }
        self.scripted = due;
        Ok(())
    }

    /// The file of the world was loaded again. Returns the world to show, if it is not the file's own, and messages.
    pub(crate) fn rebase(
        &mut self,
        base: &Arc<SessionWorld>,
        shown: &Arc<SessionWorld>,
    ) -> (Option<Arc<SessionWorld>>, Vec<Diagnostic>) {
        if Arc::ptr_eq(base, &self.base) {
            return ((!Arc::ptr_eq(base, shown)).then(|| shown.clone()), Vec::new());
        }
        let names = |scene: &Scene| scene.materials.iter().map(|material| material.name.clone()).collect::<Vec<_>>();
        let scene = base.scene();
        let mut found = Vec::new();
        if !self.edits.is_empty() && !names(&scene).starts_with(&names(&self.scene)) {
            self.edits = Edits::default();
            self.save = None;
            found.push(
                Diagnostic::warning(
                    codes::world::EDITS_DROPPED,
                    "the world has other materials now, and its edits are gone",
                )
                .help("a save has them still: open the world again with the materials that they were made with"),
            );
        }
        (self.base, self.scene, self.identity) = (base.clone(), scene, Arc::default());
        found.extend(self.unpack());
        (self.world(), found)
    }
}

/// A world with the contents of its save, without a device.
pub struct SavedWorld(Editing);

impl SavedWorld {
    /// Opens the save of a world, if it has one, with messages about it.
    ///
    /// # Errors
    /// The faults of the save.
    pub fn open(
        world: &Arc<SessionWorld>,
        root: &std::path::Path,
        files: &dyn raxel_diagnostics::Files,
        saves: Saves,
    ) -> Result<(Self, Vec<Diagnostic>), Vec<Diagnostic>> {
        let mut editing = Editing::new(world.clone());
        let mut found = editing.open_save(root, files, saves);
        // A window goes on when its edits cannot be saved. Here the save is all that matters.
        for diagnostic in found.iter_mut().filter(|diagnostic| diagnostic.code == codes::world::SAVE_READ_ONLY) {
            diagnostic.severity = Severity::Error;
        }
        if found.iter().any(Diagnostic::is_error) { Err(found) } else { Ok((Self(editing), found)) }
    }

    /// The world with its edits.
    pub fn world(&self) -> Arc<SessionWorld> {
        self.0.world().unwrap_or_else(|| self.0.base.clone())
    }

    /// Makes a checkpoint of everything and waits for it. Returns messages; none if all is well.
    pub fn checkpoint(&mut self) -> Vec<Diagnostic> {
        self.0.checkpoint();
        self.0.take_messages()
    }
}

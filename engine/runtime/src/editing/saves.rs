//! The save of a world: opened with a session, and the messages about it.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use raxel_diagnostics::{Diagnostic, Files, codes};
use raxel_edit::EditError;
use raxel_edit::save::{self, Meta, Save, SaveError, SaveEvent, SaveOptions};
use raxel_world::ChunkPos;
use raxel_worldfile::{Loaded, OnGeneratorChange, SaveSettings};

use super::Editing;
use crate::world::SessionWorld;

/// The use of the save of a world in a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Saves {
    /// Nothing: the world is as its file builds it. A demo always does so.
    Ignore,
    /// It is shown as it was saved, and edits end with the session.
    #[default]
    Read,
    /// Edits are saved.
    Write,
}

/// The identity of the save of a world.
fn save_meta(world: &SessionWorld, files: &dyn Files) -> Meta {
    Meta {
        format: 0,
        world: world.path.clone().unwrap_or_default(),
        generator: world.fingerprint(files),
        materials: world.scene().materials.into_iter().map(|material| material.name).collect(),
    }
}

/// The options of a save, from the world's file.
fn save_options(settings: &SaveSettings, saves: Saves) -> SaveOptions {
    SaveOptions {
        sync: Duration::from_secs_f64(settings.sync),
        keep_on_generator_change: settings.on_generator_change == OnGeneratorChange::Keep,
        read_only: saves != Saves::Write,
        ..SaveOptions::default()
    }
}

impl Editing {
    /// Opens the save of the world's file and takes over its contents. Returns messages: an error when it cannot be used.
    pub(crate) fn open_save(&mut self, root: &Path, files: &dyn Files, saves: Saves) -> Vec<Diagnostic> {
        let base = Arc::clone(&self.base);
        let Some(settings) = base.loaded().save.clone().filter(|_| saves != Saves::Ignore) else { return Vec::new() };
        let options = save_options(&settings, saves);
        let opened = match Save::open(&root.join(&settings.path.value), &save_meta(&base, files), options) {
            Ok(opened) => opened,
            Err(error) => return vec![refused(&error, &settings)],
        };
        let mut found: Vec<Diagnostic> = (opened.damages.iter().filter(|damage| !damage.unfinished))
            .map(|damage| {
                Diagnostic::warning(codes::world::SAVE_DAMAGED, format!("`{}`: {damage}", settings.path.value)).help(
                    format!("`raxel world verify {}` lists the broken records", base.path.as_deref().unwrap_or("")),
                )
            })
            .collect();
        if let Some(why) = &opened.read_only
            && saves == Saves::Write
        {
            let message = format!("edits are not saved: {why}");
            found.push(Diagnostic::warning(codes::world::SAVE_READ_ONLY, message));
        }
        let mut save = opened.save;
        self.edits.adopt(opened.chunks, self.scene.materials.len());
        found.extend(self.unpack());
        for (seq, operations) in opened.steps {
            match self.edits.replay(&operations, &self.scene, base.base()) {
                Ok(change) => save.replayed(&change),
                // Edits that cannot be replayed today stay in the journal.
                Err(EditError::Unavailable(reason)) => {
                    let message = format!("the edits in `{}` cannot be made: {reason}", settings.path.value);
                    found.push(Diagnostic::error(codes::world::STORE_FAILING, message));
                    return found;
                }
                Err(error) => {
                    let message = format!("`{}`: edit {seq} is left out: {error}", settings.path.value);
                    found.push(Diagnostic::warning(codes::world::SAVE_DAMAGED, message));
                }
            }
        }
        self.save = Some(save);
        found
    }
}

impl Editing {
    /// Unpacks the chunks of a save where the world is whole, as that is built of all of them; of a streamed one, those are unpacked that
    /// come near. Returns messages about broken chunks, which are as the world's file builds them from now on.
    pub(super) fn unpack(&mut self) -> Vec<Diagnostic> {
        let broken = if self.base.tiles().is_none() { self.edits.unpack() } else { Vec::new() };
        let path = self.base.loaded().save.as_ref().map_or("", |settings| &settings.path.value);
        let message = |ChunkPos { x, y, z }| format!("`{path}`: the chunk at {x}, {y}, {z} cannot be unpacked");
        broken.into_iter().map(|pos| Diagnostic::warning(codes::world::SAVE_DAMAGED, message(pos))).collect()
    }
}

/// A message if a world names a place for its save that cannot be used.
pub(crate) fn misplaced(world: &Loaded, root: Option<&Path>) -> Option<Diagnostic> {
    let settings = world.save.as_ref()?;
    save::check_folder(&root?.join(&settings.path.value)).err().map(|error| refused(&error, settings))
}

fn refused(error: &SaveError, settings: &SaveSettings) -> Diagnostic {
    let (code, help) = match error {
        SaveError::Newer { .. } => (codes::world::SAVE_NEWER, "use the raxel that made it, or another `path`"),
        SaveError::Generator { .. } => (
            codes::world::SAVE_GENERATOR,
            "`on_generator_change = \"keep\"` in [save] leaves the edited chunks as they are",
        ),
        SaveError::Materials { .. } => {
            (codes::world::SAVE_MATERIALS, "bring the materials back, or use another `path`")
        }
        SaveError::ReadOnly { .. } => {
            (codes::world::SAVE_READ_ONLY, "close the other window, or make the folder writable")
        }
        SaveError::Place { .. } => {
            (codes::world::SAVE_PLACE, "give `path` a folder of its own, such as `saves/quarry`")
        }
        SaveError::Io { .. } => (codes::world::SAVE_UNREADABLE, "look at the permissions of the folder"),
    };
    Diagnostic::error(code, format!("`{}`: {error}", settings.path.value))
        .label(settings.path.span.clone(), "")
        .help(help)
}

pub(super) fn failing(why: &str, world: &Loaded) -> Diagnostic {
    let path = world.save.as_ref().map_or("", |settings| &settings.path.value);
    Diagnostic::warning(codes::world::SAVE_FAILING, format!("`{path}`: edits are not saved at the moment: {why}"))
        .help("they are kept in memory and saved as soon as that is possible")
}

/// The window's message about an event.
pub(super) fn message(event: &SaveEvent, world: &Loaded) -> Option<Diagnostic> {
    match event {
        SaveEvent::Failing { why } => Some(failing(why, world)),
        SaveEvent::Recovered => {
            let path = world.save.as_ref().map_or("", |settings| &settings.path.value);
            Some(Diagnostic::warning(codes::world::SAVE_FAILING, format!("`{path}`: everything is saved again")))
        }
        SaveEvent::Checkpoint { .. } => None,
    }
}

//! The inputs of a world file's reader besides its text, and the names that it gathers.

use std::cell::RefCell;

use raxel_diagnostics::Files;
use raxel_diagnostics::table::Table;
use raxel_world::random::mix;

use super::materials::Palette;
use super::models::Models;

/// A world file that is being read. Materials and models join it before operations and instances look for them.
pub(super) struct Reading<'f> {
    /// Project path of the file.
    pub(super) path: &'f str,
    pub(super) files: &'f dyn Files,
    /// The world has `[stream]`.
    pub(super) streamed: bool,
    seed: u64,
    pub(super) palette: RefCell<Palette>,
    pub(super) models: RefCell<Models>,
}

impl<'f> Reading<'f> {
    pub(super) fn new(root: &Table<'_, '_>, path: &'f str, files: &'f dyn Files) -> Self {
        let seed = root.peek("seed", |node| node.integer(i64::MIN..=i64::MAX)).unwrap_or(0);
        Self {
            path,
            files,
            streamed: root.peek("stream", |_| Some(())).is_some(),
            seed: seed.cast_unsigned(),
            palette: RefCell::default(),
            models: RefCell::default(),
        }
    }

    /// The seed of the operation at an index: its own or its index, mixed with the world's.
    pub(super) fn seed(&self, own: Option<i64>, index: usize) -> u64 {
        mix(self.seed ^ mix(own.map_or(index as u64, i64::cast_unsigned)))
    }
}

//! What a frame takes.

use std::sync::{Arc, Mutex, PoisonError};

use glam::IVec3;
use raxel_world::layout::Tree64Header;
use raxel_world::lights::HEADER_WORDS;

use crate::reach::{Reach, TileKey};
use crate::view::View;

/// A state of the world that is whole in the pool. Writing its header to the start of the buffer shows it.
#[derive(Clone, Debug)]
pub struct Publication {
    /// Larger than that of all before.
    pub version: u64,
    /// The first words of the buffer.
    pub header: Tree64Header,
    /// The first words of the buffer of lamps, where there is one.
    pub lights: Option<[u32; HEADER_WORDS]>,
    /// Every call of [`crate::Streamer::changed`] up to the one that gave this number is in its chunks.
    pub changes: u64,
    /// What there was when it was made.
    pub stats: Stats,
    /// What it is without.
    pub(crate) lacking: Arc<Mutex<Option<Lacking>>>,
}

/// What a publication is without of what is loaded at a place. The newest one is told of each place that is looked at.
#[derive(Clone, Debug)]
pub(crate) struct Lacking {
    /// The place.
    pub(crate) cell: IVec3,
    /// What is shown, which is less than what is loaded.
    pub(crate) shown: Reach,
    /// Tiles that are loaded at the place, and not in the publication.
    pub(crate) tiles: Vec<TileKey>,
}

impl Lacking {
    /// Those of the tiles that are shown at the place of a view and may be in its picture, and how many of these no coarser one could stand
    /// in for. `None` when more may be wanted there than what was known of the place.
    pub(crate) fn in_view(&self, view: &View) -> Option<[usize; 2]> {
        let known = self.shown.loaded(false).covers(self.cell, view.cell);
        let unseen = self.tiles.iter().filter(|key| self.shown.wants(view.cell, **key, 0) && view.sees(**key));
        known.then(|| {
            unseen.fold([0, 0], |[all, holes], key| [all + 1, holes + usize::from(key.level == self.shown.top())])
        })
    }
}

impl Publication {
    /// Of the tiles that are to be shown at the place of a view and may be in its picture, those that a frame misses which sees this: all of
    /// them, and those that no coarser one could stand in for. `None` while the streamer has not looked at such a place.
    pub fn missing_in_view(&self, view: &View) -> Option<[usize; 2]> {
        self.lacking.lock().unwrap_or_else(PoisonError::into_inner).as_ref()?.in_view(view)
    }

    /// The header as words.
    pub fn words(&self) -> &[u32] {
        bytemuck::cast_slice(std::slice::from_ref(&self.header))
    }
}

/// How a streamer is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Tiles that are wanted.
    pub wanted: usize,
    /// Those of them that are not there yet.
    pub missing: usize,
    /// Those of them that are chunks, of level 0, and to be shown from where the camera is.
    pub missing_chunks: usize,
    /// Those of them that may be in the picture. Where a coarser one is there, that is seen meanwhile.
    pub missing_in_view: usize,
    /// Those of them that no coarser one could stand in for: nothing is seen in their place.
    pub holes_in_view: usize,
    /// Those of them that the source did not have when it was asked.
    pub unavailable: usize,
    /// Tiles in the directory, the empty ones not counted.
    pub live: usize,
    /// Lamps that are listed.
    pub lights: u64,
    /// Tiles whose lamps there is no room for: they give off light, and are in no list.
    pub unlisted: usize,
    /// Tiles made since the start.
    pub made: u64,
    /// Tiles dropped since the start.
    pub dropped: u64,
    /// Bytes of blocks and directories written since the start.
    pub written: u64,
    /// Most bytes written in a frame.
    pub most_written: u64,
    /// Publications since the start.
    pub publications: u64,
    /// Bytes in use, bytes most in use at any time, and bytes there are.
    pub pool: [u64; 3],
    /// How often the pool had no room.
    pub failed: u64,
    /// Tiles of level 0 around the camera that the pool has room for, as far as is known.
    pub near: i32,
}

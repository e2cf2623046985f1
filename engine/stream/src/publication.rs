//! The snapshots of the world that frames take.

use std::sync::{Arc, Mutex, PoisonError};

use glam::IVec3;
use raxel_layouts::Tree64Header;
use raxel_layouts::lights::HEADER_WORDS;

use crate::pool::PoolStats;
use crate::reach::{StreamingRange, TileKey};
use crate::view::View;

/// A snapshot of the world that is complete in the pool. A frame shows it by writing its header to the start of the buffer.
#[derive(Clone, Debug)]
pub struct Publication {
    /// Larger than the version of every publication before.
    pub version: u64,
    /// The first words of the buffer.
    pub header: Tree64Header,
    /// The first words of the buffer of lamps, where there is one.
    pub lights: Option<[u32; HEADER_WORDS]>,
    /// Its chunks show every change up to this number, as [`crate::Streamer::changed`] returns them.
    pub changes: u64,
    /// The figures when it was made.
    pub stats: Stats,
    /// The loaded tiles that it does not have; `None` before the director has counted them.
    pub(crate) missing_tiles: Arc<Mutex<Option<MissingTiles>>>,
}

/// The tiles that are loaded around a camera and missing from a publication. The director updates it for the newest publication whenever the
/// camera moves.
#[derive(Clone, Debug)]
pub(crate) struct MissingTiles {
    /// The voxel of the camera.
    pub(crate) cell: IVec3,
    /// The range that is shown, which is shorter than the loaded one.
    pub(crate) shown: StreamingRange,
    /// The tiles that are wanted from there and missing.
    pub(crate) tiles: Vec<TileKey>,
}

impl MissingTiles {
    /// Counts the missing tiles that are shown from a view and may be in its picture. Returns `None` if the view may want tiles that were not
    /// counted.
    pub(crate) fn in_view(&self, view: &View) -> Option<Missing> {
        let known = self.shown.loaded(false).covers(self.cell, view.cell);
        let unseen = self.tiles.iter().filter(|key| self.shown.wants(view.cell, **key, 0) && view.sees(**key));
        known.then(|| {
            unseen.fold(Missing::default(), |Missing { tiles, holes }, key| Missing {
                tiles: tiles + 1,
                holes: holes + usize::from(key.level == self.shown.top()),
            })
        })
    }
}

/// Tiles that a picture lacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Missing {
    /// All of them.
    pub tiles: usize,
    /// Those that no coarser tile replaces.
    pub holes: usize,
}

impl Publication {
    /// Counts the tiles that this publication misses in the picture of a view. Returns `None` while the streamer has not counted for a camera
    /// near that view.
    pub fn missing_in_view(&self, view: &View) -> Option<Missing> {
        self.missing_tiles.lock().unwrap_or_else(PoisonError::into_inner).as_ref()?.in_view(view)
    }

    /// The header as words.
    pub fn words(&self) -> &[u32] {
        bytemuck::cast_slice(std::slice::from_ref(&self.header))
    }
}

/// Figures about a streamer's tiles and its pool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Wanted tiles.
    pub wanted: usize,
    /// Wanted tiles that are not there yet.
    pub missing: usize,
    /// Missing chunks (level 0) that should be shown from the camera.
    pub missing_chunks: usize,
    /// Missing tiles that may be in the picture. Where a coarser tile is there, the picture shows it instead.
    pub missing_in_view: usize,
    /// Missing tiles in the picture that no coarser tile can replace: the picture has a hole there.
    pub holes_in_view: usize,
    /// Missing tiles that the source did not have when it was asked.
    pub unavailable: usize,
    /// Tiles in the directory, without the empty ones.
    pub live: usize,
    /// Lamps in the light table.
    pub lights: u64,
    /// Tiles with lamps that found no room in the list: they glow, but nothing samples them.
    pub unlisted: usize,
    /// Tiles made since the start.
    pub made: u64,
    /// Tiles dropped since the start.
    pub dropped: u64,
    /// Bytes of blocks and directories written since the start.
    pub written: u64,
    /// Bytes written in the frame that wrote most.
    pub most_written: u64,
    /// Publications since the start.
    pub publications: u64,
    /// How full the pool is.
    pub pool: PoolStats,
    /// Range of level 0 around the camera that the pool has room for, in tiles.
    pub near: i32,
}

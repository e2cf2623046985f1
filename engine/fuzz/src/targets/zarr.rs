//! Stores: the document of a group and one shard. Tiles are the baked ones or unavailable, never anything else.

use std::time::Duration;

use raxel_bake::{Store, StoreError, Wanted, ZarrSource};
use raxel_diagnostics::{Files, MemoryFiles};
use raxel_world::{ChunkPos, ChunkProvider, Content};

use crate::bounds::Bounds;
use crate::{Mutation, Target, projects};

pub(crate) const TARGET: Target = Target {
    name: "zarr",
    run,
    bounds: Bounds { bytes: 128 << 20, ..Bounds::PARSER },
    mutation: Mutation::Store,
    seeds: &[],
    longest: 8 << 10,
    quick: 250,
};

/// The objects of an input.
struct Objects(MemoryFiles);

impl Store for Objects {
    #[expect(clippy::cast_possible_truncation, reason = "a range lies in bytes in memory")]
    fn get(&self, key: &str, wanted: Wanted) -> Result<Option<Vec<u8>>, StoreError> {
        let Ok(bytes) = self.0.read(key) else { return Ok(None) };
        let size = bytes.len() as u64;
        let range = match wanted {
            Wanted::Whole | Wanted::Document => 0..size,
            Wanted::Last(count) => size.saturating_sub(count)..size,
            Wanted::Bytes(range) if range.start <= range.end && range.end <= size => range,
            Wanted::Bytes(range) => {
                let reason =
                    format!("it has {size} bytes, and those from {} to {} were wanted", range.start, range.end);
                return Err(StoreError { key: key.to_owned(), reason, passing: false });
            }
        };
        Ok(Some(bytes[range.start as usize..range.end as usize].to_vec()))
    }

    fn put(&self, key: &str, _: &[u8]) -> Result<(), StoreError> {
        panic!("`{key}` is written while a store is read");
    }

    /// A damaged object stays damaged.
    fn pauses(&self) -> &[Duration] {
        &[]
    }
}

#[expect(clippy::cast_possible_truncation, reason = "regions are within ±2³¹ voxels")]
fn run(input: &[u8]) {
    let files = MemoryFiles::default();
    projects::add(&files, "zarr.json", input);
    let source = match ZarrSource::of(std::sync::Arc::new(Objects(files)), "store") {
        Ok(source) => source,
        Err(error) => return assert!(!error.to_string().trim().is_empty()),
    };
    let count = source.materials().len();
    let region = source.region();
    let range = source.height_range();
    assert!(count > 0 && (0..3).all(|axis| region.min[axis] <= region.max[axis]), "{region:?}");
    assert_eq!(range, Some([region.min[1], region.max[1]]));
    let first = region.min.map(|c| (c >> 6) as i32);
    let last = region.max.map(|c| ((c - 1) >> 6) as i32);
    for level in 0..=source.top_level() + 1 {
        let shift = 2 * level.min(15);
        let [low, high] = [first, last].map(|corner| corner.map(|c| c >> shift));
        let beside = low.map(|c| c.saturating_add(1));
        for [x, y, z] in [low, beside, high, [low[0], high[1], beside[2]], [low[0].saturating_sub(1), low[1], low[2]]] {
            let pos = ChunkPos::new(x, y, z);
            let made = source.try_chunk(level, pos);
            assert_eq!(made, source.try_chunk(level, pos), "the same tile at level {level}, {pos:?}");
            match made {
                Ok(Content::Empty) => {}
                Ok(Content::Full(material)) => assert!(usize::from(material) < count && material > 0),
                Ok(content) => {
                    let chunk = content.to_chunk().expect("a tile that is not empty has a chunk");
                    assert!(chunk.iter().all(|(_, material)| usize::from(material) < count && material > 0));
                }
                Err(unavailable) => assert!(!unavailable.to_string().trim().is_empty()),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A store that is refused as a whole shows nothing of how tiles are read.
    #[test]
    fn the_corpus_has_tiles() {
        for (path, input) in TARGET.inputs().into_iter().filter(|(path, _)| !path.to_string_lossy().contains("found-"))
        {
            let files = MemoryFiles::default();
            projects::add(&files, "zarr.json", &input);
            let source = ZarrSource::of(std::sync::Arc::new(Objects(files)), "store").expect("a store");
            let level = u32::from(path.ends_with("level_one"));
            let tile = source.try_chunk(level, ChunkPos::new(0, 0, 0));
            assert!(tile.is_ok_and(|tile| tile.to_chunk().is_some()), "{}", path.display());
        }
    }
}

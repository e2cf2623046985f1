//! Helpers of these tests: a small land, and Python with packages.

#![allow(dead_code, unused_imports, reason = "each test file uses a part of this")]

pub(crate) mod python;
#[cfg(feature = "cloud")]
pub(crate) mod s3;
#[cfg(feature = "cloud")]
pub(crate) mod web;

use std::sync::Arc;

use raxel_bake::Plan;
use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_world::{Bounds, ChunkPos, ChunkProvider, Content};

/// Cells along an edge of a shard: two chunks.
pub(crate) const EDGE: u32 = 128;
pub(crate) const LEVELS: u32 = 2;

const LAND: &str = include_str!("../fixtures/common/land.toml");

/// Land with caves, and a lamp.
pub(crate) fn land() -> Arc<dyn ChunkProvider> {
    let files = MemoryFiles::new([("worlds/land.toml", LAND)]);
    let loaded = raxel_worldfile::load("worlds/land.toml", &files, &mut SourceMap::default());
    loaded.expect("it is right").0.stream.expect("it is streamed").generator
}

/// 8 shards of single voxels and 8 of coarse cells, around the origin.
pub(crate) fn plan(land: &dyn ChunkProvider) -> Plan {
    let region = Bounds { min: [-100, -100, -100], max: [100, 80, 100] };
    Plan::new("land", "0123", land.materials().to_vec(), region, EDGE, LEVELS).expect("it can be baked")
}

/// The cells of a level of the plan, z slowest, then y, as 16-bit palette indices, with their number along each axis: z, y, x.
pub(crate) fn cells(land: &dyn ChunkProvider, plan: &Plan, level: u32) -> (Vec<u16>, [usize; 3]) {
    let of = plan.levels()[level as usize];
    let chunks = of.shards.map(|count| count as usize * EDGE as usize / 64);
    let [x, y, z] = chunks.map(|count| count * 64);
    let mut cells = vec![0; x * y * z];
    for cz in 0..chunks[2] {
        for cy in 0..chunks[1] {
            for cx in 0..chunks[0] {
                let at = [cx, cy, cz];
                let first = of.first.map(|c| c * EDGE as i32 / 64);
                let [px, py, pz] = std::array::from_fn(|axis| first[axis] + at[axis] as i32);
                let Some(chunk) = land.try_chunk(level, ChunkPos::new(px, py, pz)).unwrap().to_chunk() else {
                    continue;
                };
                for (local, material) in chunk.iter() {
                    let [lx, ly, lz]: [usize; 3] = std::array::from_fn(|axis| at[axis] * 64 + local[axis] as usize);
                    cells[(lz * y + ly) * x + lx] = material;
                }
            }
        }
    }
    (cells, [z, y, x])
}

/// Every tile of the levels, those around the region included.
pub(crate) fn tiles(plan: &Plan) -> Vec<(u32, ChunkPos)> {
    let mut tiles = Vec::new();
    for level in plan.levels() {
        let first = level.first.map(|c| c * EDGE as i32 / 64);
        let end: [i32; 3] = std::array::from_fn(|axis| first[axis] + (level.shards[axis] * EDGE / 64) as i32);
        for z in first[2] - 1..=end[2] {
            for y in first[1] - 1..=end[1] {
                tiles.extend((first[0] - 1..=end[0]).map(|x| (level.level, ChunkPos::new(x, y, z))));
            }
        }
    }
    tiles
}

/// Whether a tile is in the region.
pub(crate) fn is_inside(plan: &Plan, (level, pos): (u32, ChunkPos)) -> bool {
    let of = plan.levels()[level as usize];
    let edge = EDGE as i32 / 64;
    let pos = [pos.x, pos.y, pos.z];
    (0..3).all(|axis| (of.first[axis]..of.first[axis] + of.shards[axis] as i32).contains(&pos[axis].div_euclid(edge)))
}

/// A tile of the region that has solid cells.
pub(crate) fn solid_tile(land: &dyn ChunkProvider, plan: &Plan) -> (u32, ChunkPos) {
    let solid =
        |tile: &(u32, ChunkPos)| is_inside(plan, *tile) && land.try_chunk(tile.0, tile.1).unwrap().to_chunk().is_some();
    tiles(plan).into_iter().find(solid).expect("there is land")
}

/// The answer of a source about a tile of the plan.
pub(crate) fn expected(land: &dyn ChunkProvider, plan: &Plan, tile: (u32, ChunkPos)) -> Content {
    if is_inside(plan, tile) { land.try_chunk(tile.0, tile.1).unwrap() } else { Content::Empty }
}

//! The picture of tiles that lie over each other: the reference for every ray over a streamed world.

use std::collections::BTreeMap;

use raxel_world::{AIR, BLOCKS, ChunkPos, ChunkProvider, Content, DenseChunk, Mode, Unavailable, World, block_cell};

use raxel_stream::TileKey;

/// The voxels that rays meet where these tiles are there: in every chunk, the cells of the finest tile as solid cubes. It does not show how
/// they are stored.
///
/// # Errors
/// When the source does not have one of the tiles.
pub fn union(source: &dyn ChunkProvider, tiles: &[TileKey]) -> Result<World, Unavailable> {
    let mut tiles = tiles.to_vec();
    tiles.sort_unstable_by_key(|tile| std::cmp::Reverse(tile.level));
    let mut chunks: BTreeMap<ChunkPos, Content> = BTreeMap::new();
    for key in tiles {
        let content = source.try_chunk(key.level, key.pos)?;
        if content == Content::Empty && chunks.is_empty() {
            continue;
        }
        let edge = 1 << (2 * key.level);
        for y in 0..edge {
            for z in 0..edge {
                for x in 0..edge {
                    let pos = ChunkPos::new(key.pos.x * edge + x, key.pos.y * edge + y, key.pos.z * edge + z);
                    match expand(&content, key.level, pos) {
                        Content::Empty => chunks.remove(&pos),
                        part => chunks.insert(pos, part),
                    };
                }
            }
        }
    }
    let packed = chunks.into_iter().filter_map(|(pos, content)| Some((pos, content.to_chunk()?)));
    Ok(World::new(source.materials().to_vec(), packed))
}

/// The part of a tile that a chunk is.
fn expand(content: &Content, level: u32, chunk: ChunkPos) -> Content {
    let Content::Chunk(cells) = content else { return content.clone() };
    if level == 0 {
        return content.clone();
    }
    // A block of 4³ voxels lies in one cell, which has 4^(level - 1) blocks along an edge; the chunk begins where a cell does.
    let shift = 2 * (level - 1);
    let [first_x, first_y, first_z] = [chunk.x, chunk.y, chunk.z].map(|c| (((c & 63) << 4) >> shift).cast_unsigned());
    let material = |block: usize| {
        let [x, y, z] = block_cell(block);
        cells.voxel((first_x + (x >> shift)) & 63, (first_y + (y >> shift)) & 63, (first_z + (z >> shift)) & 63)
    };
    let first = material(0);
    if (1..BLOCKS).all(|block| material(block) == first) {
        return if first == AIR { Content::Empty } else { Content::Full(first) };
    }
    let mut dense = DenseChunk::default();
    for block in 0..BLOCKS {
        match material(block) {
            AIR => {}
            material => dense.apply(block, u64::MAX, Mode::Add, material),
        }
    }
    Content::pack(&dense)
}

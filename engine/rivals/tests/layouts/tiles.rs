//! Blocks of tiles, read by their format alone, hold the cells of their tiles at any place in a buffer.

use std::sync::Arc;

use raxel_layouts::{FULL_RUN_WORDS, Layout, MATERIAL_WORDS, TileBlock, TileNode, Tree64Header, full_run};
use raxel_world::random::SplitMix64;
use raxel_world::{Chunk, ChunkPos, Content, DenseChunk, Mode, World};

use crate::decode::{self, Voxels};
use crate::palette;

/// A word that no part of a tile contains: a mask with all bits that name no place.
const POISON: u32 = 0xdead_beef;

/// Cells of a chunk.
fn cells(chunk: &Chunk) -> Voxels {
    chunk.iter().map(|(cell, material)| (cell.map(|c| c as i32), material)).collect()
}

/// A tile with full blocks and nodes, of one material and of several, and others that have gaps; or only full nodes of one material.
fn random_chunk(random: &mut SplitMix64) -> Option<Arc<Chunk>> {
    let mut dense = DenseChunk::default();
    if random.below(16) == 0 {
        let (nodes, material) = (random.bits() & random.bits(), 1 + random.below(300) as u16);
        for block in (0..4096).filter(|block| nodes >> (block / 64) & 1 == 1) {
            dense.apply(block, u64::MAX, Mode::Add, material);
        }
        return Chunk::pack(&dense).map(Arc::new);
    }
    let materials = [1, 2, 5, 300][random.index(4)];
    let one = 1 + random.below(materials) as u16;
    for _ in 0..random.below(30) {
        // Blocks of 4³: whole nodes of them, or single ones.
        let (first, count) = if random.below(5) == 0 { (64 * random.index(64), 64) } else { (random.index(4096), 1) };
        let (full, alike) = (random.below(3) > 0, random.below(3) > 0);
        let all = if random.below(4) > 0 { one } else { 1 + random.below(materials) as u16 };
        for block in first..first + count {
            let mask = if full { u64::MAX } else { random.bits() & random.bits() };
            dense.apply(block, mask, Mode::Add, all);
            if !alike {
                for bit in 0..64 {
                    dense.apply(block, 1 << bit, Mode::Paint, 1 + random.below(materials) as u16);
                }
            }
        }
    }
    Chunk::pack(&dense).map(Arc::new)
}

/// The cells of a tile at a place in a buffer with the full run, both at random.
fn read(block: Result<TileBlock, Option<TileNode>>, level: u32, random: &mut SplitMix64) -> (Voxels, u32) {
    let mut buffer = vec![POISON; 4 * random.index(2000)];
    let (node, words) = match block {
        Ok(block) => {
            let run = buffer.len() as u32;
            buffer.extend(full_run());
            assert_eq!(buffer.len() as u32, run + FULL_RUN_WORDS);
            buffer.resize(buffer.len() + 4 * random.index(2000), POISON);
            let (words, node) = block.encode(buffer.len() as u32, run);
            assert_eq!((words.len() as u32, block.words() % 4), (block.words(), 0));
            assert_eq!(node.0[2], buffer.len() as u32 / 4, "its first node is that of its first child");
            buffer.extend(words);
            (node, block.words())
        }
        Err(Some(node)) => (node, 0),
        Err(None) => return (Voxels::new(), 0),
    };
    let mut voxels = Voxels::new();
    decode::tree64_node(&buffer, node.0, 3 + level, [0; 3], 1 << (2 * level), &mut voxels);
    (voxels, words)
}

#[test]
fn tiles_of_every_level_keep_their_cells() {
    let mut random = SplitMix64::new(5);
    let mut kinds = [0; 2];
    for round in 0..120 {
        let level = round % 4;
        let content = random_chunk(&mut random).map_or(Content::Empty, Content::of);
        let block = TileBlock::of(&content, level);
        kinds[usize::from(block.is_ok())] += 1;
        let expected = content.to_chunk().map_or(Voxels::new(), |chunk| cells(&chunk));
        let (found, words) = read(block, level, &mut random);
        assert!(found == expected, "level {level}, round {round}");
        // No larger than a world of that chunk, which shares no leaves.
        if let (0, Some(chunk)) = (level, content.to_chunk()) {
            let world = World::new(palette(300), [(ChunkPos::new(0, 0, 0), chunk)]);
            let encoded = Layout::TREE64.encode(&world, u64::MAX).expect("it fits").words.len() as u32;
            let front = Tree64Header::WORDS + 301 * MATERIAL_WORDS + 4;
            assert!(words + front <= encoded, "{words} words, {encoded} in a world");
        }
    }
    assert!(kinds[0] > 0 && kinds[1] > 100, "{kinds:?}");
    let full = Content::Full(9);
    assert_eq!(read(TileBlock::of(&full, 2), 2, &mut random), (cells(&Chunk::full(9)), 0));
}

/// Nodes of full leaves of several materials take no leaves at level 0, and a block of several materials one node above it.
#[test]
fn full_leaves_are_those_of_the_full_run() {
    let mut dense = DenseChunk::default();
    dense.fill(1);
    dense.set(0, 0, 0, 2);
    let content = Content::pack(&dense);
    let words = |level| TileBlock::of(&content, level).expect("two materials").words();
    // 64 nodes; 64 links of the node with both materials, and four words of its mixed block: a palette, and a bit for each voxel.
    assert_eq!(words(0), 64 * 4 + 64 + 4);
    // 64 nodes of 16³ cells, 64 of 4³, and the same four words.
    assert_eq!([1, 2, 3].map(words), [128 * 4 + 4; 3]);
}

#[test]
fn a_node_says_what_its_children_are() {
    let mask = 0x8123_4567_89ab_cdef;
    let node = TileNode::of_children(mask, 77);
    assert_eq!((node.mask(), node.filled_material(), node.0[2]), (mask, None, 77));
    let filled = TileNode::filled(513);
    assert_eq!((filled.mask(), filled.filled_material()), (u64::MAX, Some(513)));
}

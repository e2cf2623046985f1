//! Coarse cells of an edited world: those of the source below, except where voxels of a cell have changed.

use raxel_world::{
    AIR, BLOCKS, Chunk, ChunkPos, DenseChunk, MaterialIndex, Mode, block_cell, block_index, cell_edge, child_cell,
    child_index, voxel_index,
};

/// The cells of a chunk that have a changed voxel in them, at every level above 0.
///
/// The source below has a rule of its own for coarse cells: land is solid where most of a cell is, models where they are as thick as a
/// wall, and thin layers keep their colour. A rule over voxels alone cannot agree with it everywhere: one changed voxel would then change
/// its whole chunk. So a cell stays as in the source until enough of it has changed.
///
/// The source may also have a cell solid that has no voxel in it: caves are no part of coarse land. Dug-out space continues through such cells, as
/// far as they touch each other in the chunk.
pub(super) struct ChangedCells {
    /// Of level 1, by the block of the chunk that they are.
    of_blocks: Box<[(u16, Share)]>,
    /// Of level 2, by the node of the chunk that they are.
    of_nodes: Box<[(u16, Share)]>,
    /// Of level 3; all of the chunk.
    whole: Option<Share>,
}

/// Counts of a cell's voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Share {
    /// Solid ones below the edits.
    before: u32,
    /// Solid ones now.
    after: u32,
    /// Solid ones of a material that they did not have.
    written: u32,
    /// Their most frequent material; on a tie, the one with the lowest index.
    material: MaterialIndex,
}

/// Materials of written voxels, with how many are of each.
#[derive(Default)]
struct Written(Vec<(MaterialIndex, u32)>);

impl ChangedCells {
    /// The differing cells of two chunks.
    #[expect(clippy::cast_possible_truncation, reason = "a chunk has 4096 blocks and 64 nodes")]
    pub(super) fn between(before: Option<&Chunk>, after: Option<&Chunk>) -> Self {
        let mask = |chunk: Option<&Chunk>, block: usize| chunk.map_or(0, |chunk| chunk.mask(block));
        let (mut of_blocks, mut of_nodes, mut in_chunk) = (Vec::new(), Vec::new(), Written::default());
        for node in 0..BLOCKS / 64 {
            let (first, mut in_node) = (of_blocks.len(), Written::default());
            let blocks = node * 64..node * 64 + 64;
            for block in blocks.clone() {
                let masks = [mask(before, block), mask(after, block)];
                if masks == [0, 0] || (masks[0] == masks[1] && same_materials(before, after, block)) {
                    continue;
                }
                let written = Written::of_block(before, after, block);
                in_node.add(&written);
                of_blocks.push((block as u16, written.share(masks.map(u64::count_ones))));
            }
            if of_blocks.len() > first {
                let solids = |chunk| blocks.clone().map(|block| mask(chunk, block).count_ones()).sum();
                in_chunk.add(&in_node);
                of_nodes.push((node as u16, in_node.share([solids(before), solids(after)])));
            }
        }
        let is_void = |block: usize| mask(before, block) | mask(after, block) == 0;
        of_blocks.extend(opened(&of_blocks, 1, 16, block_cell, |[x, y, z]| block_index(x, y, z), is_void));
        let is_void = |node: usize| (node * 64..node * 64 + 64).all(is_void);
        let node_cell = |node: usize| child_cell(node as u32);
        of_nodes.extend(opened(&of_nodes, 2, 4, node_cell, |[x, y, z]| child_index(x, y, z) as usize, is_void));
        let solids = |chunk: Option<&Chunk>| chunk.map_or(0, Chunk::solids);
        let whole = (!of_nodes.is_empty()).then(|| in_chunk.share([solids(before), solids(after)]));
        Self { of_blocks: of_blocks.into(), of_nodes: of_nodes.into(), whole }
    }

    /// Lays them over a tile of the source, of a level above 0, that the chunk is in.
    pub(super) fn lay(&self, level: u32, pos: ChunkPos, tile: &mut DenseChunk) {
        let within = |mask: i32| [pos.x, pos.y, pos.z].map(|c| (c & mask).cast_unsigned());
        let mut lay = |block: usize, bit: u32, share: &Share| {
            let below = if tile.masks()[block] >> bit & 1 == 1 { tile.block(block)[bit as usize] } else { AIR };
            let mode = match share.cell(level, below) {
                now if now == below => return,
                AIR => (Mode::Subtract, AIR),
                now => (Mode::Add, now),
            };
            tile.apply(block, 1 << bit, mode.0, mode.1);
        };
        match level {
            1 => {
                // The cells of a block of the tile are the blocks of a node of the chunk, in the same order.
                let [x, y, z] = within(3);
                let node = child_index(x, y, z) as usize;
                self.of_blocks.iter().for_each(|(at, share)| {
                    lay(node * 64 + usize::from(at / 64), u32::from(at % 64), share);
                });
            }
            2 => {
                let [x, y, z] = within(15);
                let block = block_index(x, y, z);
                self.of_nodes.iter().for_each(|(at, share)| lay(block, u32::from(*at), share));
            }
            _ => {
                let [x, y, z] = within(63);
                let (block, bit) = voxel_index(x, y, z);
                self.whole.iter().for_each(|share| lay(block, bit, share));
            }
        }
    }
}

impl Share {
    /// The new content of a cell of a level that has the content `below` in the source: air or a material.
    ///
    /// A cell of air becomes solid when half of it is solid, or when it has gained as many voxels as a wall one voxel thick has in it.
    /// One that is solid stays so while half of it is. In both cases half as many voxels as such a wall has must have come or gone, about
    /// half of its visible ones from one side: the source may have rounded a cell that is nearly half full either way. As many must be
    /// written before it changes its material.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a cell has at most 64 voxels along an edge, and a cube at most 16³ cells"
    )]
    fn cell(&self, level: u32, below: MaterialIndex) -> MaterialIndex {
        let edge = cell_edge(level) as u32;
        let (wall, half) = (edge * edge, edge * edge * edge / 2);
        let least = match below {
            AIR => half.min(self.before + wall).max(self.before + wall / 2),
            _ => half.min(self.before.saturating_sub(wall / 2)).max(1),
        };
        if self.after < least {
            AIR
        } else if below == AIR || 2 * self.written >= wall {
            self.material
        } else {
            below
        }
    }
}

impl Written {
    fn of_block(before: Option<&Chunk>, after: Option<&Chunk>, block: usize) -> Self {
        let mut written = Self::default();
        let Some(after) = after.map(|chunk| chunk.block(block)) else { return written };
        let before = before.map(|chunk| chunk.block(block));
        for bit in 0..64 {
            let known = before.as_ref().map_or(AIR, |before| before.materials[bit]);
            if after.materials[bit] != AIR && after.materials[bit] != known {
                written.count(after.materials[bit], 1);
            }
        }
        written
    }

    fn count(&mut self, material: MaterialIndex, voxels: u32) {
        match self.0.iter_mut().find(|(known, _)| *known == material) {
            Some((_, count)) => *count += voxels,
            None => self.0.push((material, voxels)),
        }
    }

    fn add(&mut self, other: &Self) {
        other.0.iter().for_each(|(material, voxels)| self.count(*material, *voxels));
    }

    /// The share of a cell with these solid voxels before and after.
    fn share(&self, [before, after]: [u32; 2]) -> Share {
        let most = self.0.iter().max_by_key(|(material, count)| (*count, std::cmp::Reverse(*material)));
        let written = self.0.iter().map(|(_, count)| count).sum();
        Share { before, after, written, material: most.map_or(AIR, |(material, _)| *material) }
    }
}

/// The cells without voxels that are reachable from cells that an edit has emptied, in a cube of `edge` cells along an edge.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a cell has at most 64 voxels along an edge, and a cube at most 16³ cells"
)]
fn opened(
    cells: &[(u16, Share)],
    level: u32,
    edge: u32,
    place: impl Fn(usize) -> [u32; 3],
    index: impl Fn([u32; 3]) -> usize,
    is_void: impl Fn(usize) -> bool,
) -> Vec<(u16, Share)> {
    let half_a_wall = cell_edge(level).pow(2) as u32 / 2;
    let emptied = cells.iter().filter(|(_, share)| share.after == 0 && share.before >= half_a_wall);
    let mut open: Vec<usize> = emptied.map(|(at, _)| usize::from(*at)).collect();
    let (mut found, mut known) = (Vec::new(), vec![false; edge.pow(3) as usize]);
    while let Some(at) = open.pop() {
        let from = place(at);
        for axis in 0..3 {
            for to in [from[axis].wrapping_sub(1), from[axis] + 1].into_iter().filter(|to| *to < edge) {
                let mut cell = from;
                cell[axis] = to;
                let next = index(cell);
                if !std::mem::replace(&mut known[next], true) && is_void(next) {
                    found.push((next as u16, Share::default()));
                    open.push(next);
                }
            }
        }
    }
    found
}

/// Whether a block is of the same materials in two chunks that have the same voxels in it.
fn same_materials(before: Option<&Chunk>, after: Option<&Chunk>, block: usize) -> bool {
    let (Some(before), Some(after)) = (before, after) else { return true };
    match [before, after].map(|chunk| chunk.block_uniform(block)) {
        [Some(before), Some(after)] => before == after,
        [None, None] => before.block_materials(block).eq(after.block_materials(block)),
        _ => false,
    }
}

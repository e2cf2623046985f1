//! Layout `bvh`: see `shaders/include/raxel/rivals/internal/layouts/bvh.glsl` for the format.

use raxel_world::World;
use raxel_world::{Bits, Chunk, block_cell};
use rayon::prelude::*;

use super::LINKED;
use raxel_layouts::parts::Parts;
use raxel_layouts::{
    Encoded, Encoding, Extent, Layout, LayoutError, MATERIAL_WORDS, buffer, check_size, layout_header,
};

/// A tree of boxes around 4³ blocks with occupancy masks.
pub const LAYOUT: Layout = Layout::new(&ENCODING);

static ENCODING: Encoding =
    Encoding::new("bvh", BvhHeader::block, |world, limits, _| encode(world, limits.buffer_bytes));

/// Words of a node.
const NODE_WORDS: usize = 8;
/// Words of a block.
const BLOCK_WORDS: usize = 6;
/// Most blocks of a leaf.
const LEAF_BLOCKS: usize = 4;
/// The mark of a leaf, in place of an axis.
const LEAF: u32 = 3;
/// Link of a block whose voxels are all of the material in the low half.
const UNIFORM_LINK: u32 = 0x8000_0000;
/// Fewer blocks are not worth a task of their own.
const TASK_BLOCKS: usize = 4096;

layout_header! {
    /// Header of the layout `bvh`. Addresses (`…_at`) count words from the first word behind the header.
    BvhHeader {
        /// Address of the root node.
        nodes_at: u32,
        /// Nodes.
        node_count: u32,
        /// Address of the first block.
        blocks_at: u32,
        /// Blocks of 4³ voxels with a solid one.
        block_count: u32,
    }
}

/// A 4³ block: its smallest corner in voxels from the world's origin, its mask (low word first), its link.
type Block = [u32; BLOCK_WORDS];
/// A node: smallest corner, link, largest voxel, kind.
type Node = [u32; NODE_WORDS];

/// Smallest and largest voxel of a box, from the world's origin.
#[derive(Clone, Copy)]
struct Box3 {
    low: [u32; 3],
    last: [u32; 3],
}

/// One distinct chunk.
struct Part<'a> {
    chunk: &'a Chunk,
    /// 4³ blocks with solids.
    blocks: usize,
    /// Halfwords of the materials of those that have several.
    attributes: usize,
}

fn encode(world: &World, limit: u64) -> Result<Encoded, LayoutError> {
    let layout = LAYOUT;
    let extent = Extent::of(world, layout)?;
    let (parts, uses) = distinct_chunks(world, &extent);

    // Every size is known before anything is built: the median split makes the number of nodes a matter of counting.
    let blocks: u64 = uses.iter().map(|(_, part)| parts[*part].blocks as u64).sum();
    let attributes: u64 = parts.iter().map(|part| part.attributes as u64).sum();
    let nodes = 2 * blocks.div_ceil(LEAF_BLOCKS as u64).max(1) - 1;
    let nodes_at = u64::from(MATERIAL_WORDS) * world.materials().len() as u64;
    let blocks_at = nodes_at + NODE_WORDS as u64 * nodes;
    let attributes_at = blocks_at + BLOCK_WORDS as u64 * blocks;
    let words = u64::from(BvhHeader::WORDS) + attributes_at + attributes.div_ceil(2);
    let bytes = check_size(layout, 4 * words, limit.min(LINKED))?;

    let header = BvhHeader {
        nodes_at: nodes_at as u32,
        node_count: nodes as u32,
        blocks_at: blocks_at as u32,
        block_count: blocks as u32,
        ..BvhHeader::of(&extent, world.materials())
    };
    let mut buffer = buffer(&header, world.materials(), words as usize);

    let body = &mut buffer[BvhHeader::WORDS as usize + nodes_at as usize..];
    let (node_words, rest) = body.split_at_mut(NODE_WORDS * nodes as usize);
    let (block_words, attribute_words) = rest.split_at_mut(BLOCK_WORDS * blocks as usize);
    let links = fill_attributes(&parts, bytemuck::cast_slice_mut(attribute_words), 2 * attributes_at as usize);
    let blocks: &mut [Block] = bytemuck::cast_slice_mut(block_words);
    fill_blocks(&parts, &uses, &links, blocks);
    build(bytemuck::cast_slice_mut(node_words), nodes_at as usize, blocks, blocks_at as usize);

    let attribute_bytes = 4 * (nodes_at + attributes.div_ceil(2));
    Ok(Encoded { words: buffer, geometry_bytes: bytes - attribute_bytes, attribute_bytes })
}

/// The distinct chunks of a world, and for every chunk its cell and the index of its distinct one.
fn distinct_chunks<'a>(world: &'a World, extent: &Extent) -> (Vec<Part<'a>>, Vec<([u32; 3], usize)>) {
    let Parts { distinct, uses } = Parts::chunks(world, extent);
    let parts = distinct
        .par_iter()
        .map(|chunk| {
            let solid = || chunk.masks().iter().enumerate().filter(|(_, mask)| **mask != 0);
            let mixed = solid().filter(|(block, _)| chunk.block_uniform(*block).is_none());
            let attributes = mixed.map(|(_, mask)| mask.count_ones() as usize).sum();
            Part { chunk, blocks: solid().count(), attributes }
        })
        .collect();
    (parts, uses)
}

/// Writes the materials of each distinct chunk's mixed blocks, and gives the links of its blocks in the order of its masks.
fn fill_attributes(parts: &[Part<'_>], mut halfwords: &mut [u16], mut at: usize) -> Vec<Vec<u32>> {
    let mut jobs = Vec::with_capacity(parts.len());
    for part in parts {
        let (own, rest) = halfwords.split_at_mut(part.attributes);
        halfwords = rest;
        jobs.push((part, own, at));
        at += part.attributes;
    }
    let fill = |(part, own, at): (&Part<'_>, &mut [u16], usize)| {
        let mut used = 0;
        let solid = (0..part.chunk.masks().len()).filter(|block| part.chunk.mask(*block) != 0);
        solid
            .map(|block| {
                if let Some(material) = part.chunk.block_uniform(block) {
                    return UNIFORM_LINK | u32::from(material);
                }
                let link = (at + used) as u32;
                for material in part.chunk.block_materials(block) {
                    own[used] = material;
                    used += 1;
                }
                link
            })
            .collect()
    };
    jobs.into_par_iter().map(fill).collect()
}

/// Writes the blocks of every chunk, in any order: the build arranges them.
fn fill_blocks(parts: &[Part<'_>], uses: &[([u32; 3], usize)], links: &[Vec<u32>], mut blocks: &mut [Block]) {
    let mut jobs = Vec::with_capacity(uses.len());
    for &(cell, part) in uses {
        let (own, rest) = blocks.split_at_mut(parts[part].blocks);
        blocks = rest;
        jobs.push((cell, part, own));
    }
    jobs.into_par_iter().for_each(|(cell, part, own)| {
        let corner = cell.map(|c| c << 6);
        let solid = parts[part].chunk.masks().iter().enumerate().filter(|(_, mask)| **mask != 0);
        for (((index, &mask), &link), block) in solid.zip(&links[part]).zip(own) {
            let [x, y, z] = block_cell(index);
            let [x, y, z] = [corner[0] + 4 * x, corner[1] + 4 * y, corner[2] + 4 * z];
            *block = [x, y, z, mask as u32, (mask >> 32) as u32, link];
        }
    });
}

/// Builds the tree of `blocks`, depth first, into `nodes`, and sorts the blocks so that those of a leaf are neighbours. Each node splits
/// the widest axis of its blocks' centres at the median block. So the depth of the tree is the logarithm of their number, and the
/// traversal's stack cannot overflow. Addresses are those of the slices in the buffer.
fn build(nodes: &mut [Node], nodes_at: usize, blocks: &mut [Block], blocks_at: usize) -> Box3 {
    if blocks.len() <= LEAF_BLOCKS {
        // Only an empty world has an empty leaf.
        let bounds = blocks.iter().map(block_bounds).reduce(Box3::union).unwrap_or(Box3 { low: [0; 3], last: [0; 3] });
        nodes[0] = node(bounds, blocks_at, LEAF | (blocks.len() as u32) << 2);
        return bounds;
    }
    let axis = widest_axis(blocks);
    // Every leaf but the last is full.
    let left_leaves = blocks.len().div_ceil(LEAF_BLOCKS) / 2;
    let middle = LEAF_BLOCKS * left_leaves;
    // The other two axes order blocks at the same place on that axis, so that their boxes stay compact.
    let rank = |block: &Block| (block[axis], block[(axis + 1) % 3], block[(axis + 2) % 3]);
    blocks.select_nth_unstable_by_key(middle, rank);

    let (left, right) = blocks.split_at_mut(middle);
    let (own, children) = nodes.split_at_mut(1);
    let (left_nodes, right_nodes) = children.split_at_mut(2 * left_leaves - 1);
    let left_at = nodes_at + NODE_WORDS;
    let right_at = left_at + NODE_WORDS * left_nodes.len();
    let right_blocks_at = blocks_at + BLOCK_WORDS * left.len();
    let (left, right) = if left.len() + right.len() >= TASK_BLOCKS {
        rayon::join(
            || build(left_nodes, left_at, left, blocks_at),
            || build(right_nodes, right_at, right, right_blocks_at),
        )
    } else {
        (build(left_nodes, left_at, left, blocks_at), build(right_nodes, right_at, right, right_blocks_at))
    };
    let bounds = left.union(right);
    own[0] = node(bounds, right_at, axis as u32);
    bounds
}

fn node(Box3 { low, last }: Box3, link: usize, kind: u32) -> Node {
    [low[0], low[1], low[2], link as u32, last[0], last[1], last[2], kind]
}

/// The axis along which the blocks' centres are farthest apart.
fn widest_axis(blocks: &[Block]) -> usize {
    let corner = |block: &Block| [block[0], block[1], block[2]];
    let ends = blocks.iter().map(|block| Box3 { low: corner(block), last: corner(block) }).reduce(Box3::union);
    let Some(Box3 { low, last }) = ends else { return 0 };
    (0..3).max_by_key(|&axis| (last[axis] - low[axis], 2 - axis)).unwrap_or(0)
}

/// The box of the solid voxels of a block.
fn block_bounds(block: &Block) -> Box3 {
    let mask = u64::from(block[3]) | u64::from(block[4]) << 32;
    let none = Box3 { low: [u32::MAX; 3], last: [0; 3] };
    Bits(mask).fold(none, |bounds, bit| {
        let cell = raxel_world::child_cell(bit);
        let voxel = std::array::from_fn(|i| block[i] + cell[i]);
        bounds.union(Box3 { low: voxel, last: voxel })
    })
}

impl Box3 {
    /// Smallest box around both.
    fn union(self, other: Self) -> Self {
        Self {
            low: std::array::from_fn(|i| self.low[i].min(other.low[i])),
            last: std::array::from_fn(|i| self.last[i].max(other.last[i])),
        }
    }
}

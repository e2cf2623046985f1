//! Layout `svo`: see `shaders/include/raxel/rivals/internal/layouts/svo.glsl` for the format.

use raxel_world::MaterialIndex;
use raxel_world::World;
use raxel_world::{Bits, Chunk, block_index, child_index};
use rayon::prelude::*;

use raxel_layouts::parts::{Parts, child_of, octree_path};
use raxel_layouts::{
    Encoded, Encoding, Extent, Layout, LayoutError, MATERIAL_WORDS, buffer, check_size, layout_header,
};

/// A sparse octree.
pub const LAYOUT: Layout = Layout::new(&ENCODING);

static ENCODING: Encoding =
    Encoding::new("svo", SvoHeader::block, |world, limits, _| encode(world, limits.buffer_bytes));

/// Words of a node from the root down to the chunks: a node's own word, and an address.
const UPPER_WORDS: usize = 2;
/// Bit of a node whose occupied children are filled with the material in the upper half.
const SOLID: u32 = 0x100;
/// The pointer of a node that is not solid is above its mask.
const POINTER_SHIFT: u32 = 9;
/// Chunks have 2^6 voxels a side.
const LOG2_CHUNK: u32 = 6;

layout_header! {
    /// Header of the layout `svo`. Addresses (`…_at`, `root`) count words from the first word behind the header.
    SvoHeader {
        /// Address of the root node.
        root: u32,
        /// Nodes from the root down to the chunks, both included.
        upper_count: u32,
        /// Address of the first chunk's nodes.
        chunks_at: u32,
        /// Chunks of nodes: equal chunks share them.
        chunk_count: u32,
    }
}

/// The words of one distinct chunk in the buffer.
#[derive(Clone, Copy)]
struct ChunkSize {
    /// Nodes below the chunk's own.
    nodes: usize,
    /// Halfwords of materials.
    attributes: usize,
}

impl ChunkSize {
    fn of(chunk: &Chunk) -> Self {
        let mut writer = Writer::new(&mut [], &mut [], 0);
        writer.chunk(chunk);
        Self { nodes: writer.next_node, attributes: writer.next_attribute }
    }

    fn words(&self) -> usize {
        self.nodes + self.attributes.div_ceil(2)
    }
}

fn encode(world: &World, limit: u64) -> Result<Encoded, LayoutError> {
    let layout = LAYOUT;
    let extent = Extent::of(world, layout)?;
    let parts = Parts::chunks(world, &extent);
    let mut uses: Vec<(u128, usize)> = parts.uses.iter().map(|&(cell, index)| (octree_path(cell), index)).collect();
    uses.sort_unstable();
    let sizes: Vec<ChunkSize> = parts.distinct.par_iter().map(|chunk| ChunkSize::of(chunk)).collect();

    let root = MATERIAL_WORDS as usize * world.materials().len();
    let upper = upper_nodes(&uses, extent.log2_size);
    let chunks_at = root + UPPER_WORDS * upper;
    let words = SvoHeader::WORDS as usize + chunks_at + sizes.iter().map(ChunkSize::words).sum::<usize>();
    // Addresses are 32 bits wide and count words, or halfwords to a voxel's material.
    let bytes = check_size(layout, 4 * words as u64, limit.min(4 << 31))?;

    let header = SvoHeader {
        root: root as u32,
        upper_count: upper as u32,
        chunks_at: chunks_at as u32,
        chunk_count: parts.distinct.len() as u32,
        ..SvoHeader::of(&extent, world.materials())
    };
    let mut buffer = buffer(&header, world.materials(), words);
    let (front, chunks) = buffer.split_at_mut(SvoHeader::WORDS as usize + chunks_at);
    let nodes = fill_chunks(&parts.distinct, &sizes, chunks, chunks_at);
    fill_upper(&uses, &nodes, extent.log2_size, &mut front[SvoHeader::WORDS as usize + root..], root);

    let nodes: usize = sizes.iter().map(|size| size.nodes).sum();
    let geometry_bytes = 4 * (SvoHeader::WORDS as usize + UPPER_WORDS * upper + nodes) as u64;
    Ok(Encoded { words: buffer, geometry_bytes, attribute_bytes: bytes - geometry_bytes })
}

/// Encodes every distinct chunk into its part of the buffer, in parallel, and gives each one's node and the address of its part.
fn fill_chunks(chunks: &[&Chunk], sizes: &[ChunkSize], mut words: &mut [u32], mut at: usize) -> Vec<(u32, u32)> {
    let mut jobs = Vec::with_capacity(chunks.len());
    for (chunk, size) in chunks.iter().zip(sizes) {
        let (own, rest) = words.split_at_mut(size.words());
        words = rest;
        jobs.push((*chunk, *size, own, at as u32));
        at += size.words();
    }
    let encode = |(chunk, size, words, at): (&Chunk, ChunkSize, &mut [u32], u32)| {
        let (nodes, attributes) = words.split_at_mut(size.nodes);
        let mut writer = Writer::new(nodes, bytemuck::cast_slice_mut(attributes), 2 * size.nodes);
        (writer.chunk(chunk), at)
    };
    jobs.into_par_iter().map(encode).collect()
}

/// Nodes from the root down to the chunks, both included.
fn upper_nodes(uses: &[(u128, usize)], log2_size: u32) -> usize {
    let of_level = |level: u32| uses.chunk_by(|a, b| a.0 >> (3 * level) == b.0 >> (3 * level)).count();
    (0..=log2_size - LOG2_CHUNK).map(of_level).sum::<usize>().max(1)
}

/// Writes the nodes from the root (first) down to the chunks, level by level.
fn fill_upper(uses: &[(u128, usize)], chunks: &[(u32, u32)], log2_size: u32, words: &mut [u32], words_at: usize) {
    // From the chunks upwards; each level's nodes are in the order of their paths, so siblings are neighbours.
    let mut level: Vec<(u128, (u32, u32))> = uses.iter().map(|&(path, index)| (path, chunks[index])).collect();
    let mut end = words.len();
    for _ in LOG2_CHUNK..log2_size {
        let start = end - UPPER_WORDS * level.len();
        let mut parents: Vec<(u128, (u32, u32))> = Vec::new();
        for (i, &(path, (node, link))) in level.iter().enumerate() {
            let at = start + UPPER_WORDS * i;
            words[at..at + UPPER_WORDS].copy_from_slice(&[node, link]);
            if parents.last().is_none_or(|(parent, _)| *parent != path >> 3) {
                parents.push((path >> 3, (0, (words_at + at) as u32)));
            }
            if let Some((_, (mask, _))) = parents.last_mut() {
                *mask |= 1 << (path & 7);
            }
        }
        level = parents;
        end = start;
    }
    // An empty world has an empty root.
    let (node, link) = level.first().map_or((0, 0), |(_, root)| *root);
    words[..UPPER_WORDS].copy_from_slice(&[node, link]);
}

/// Writes the nodes of a chunk, children before their parents; with empty slices it only counts.
struct Writer<'a> {
    nodes: &'a mut [u32],
    next_node: usize,
    attributes: &'a mut [MaterialIndex],
    next_attribute: usize,
    /// Halfwords in front of the materials, from the first node.
    attributes_at: usize,
}

impl<'a> Writer<'a> {
    fn new(nodes: &'a mut [u32], attributes: &'a mut [MaterialIndex], attributes_at: usize) -> Self {
        Self { nodes, next_node: 0, attributes, next_attribute: 0, attributes_at }
    }

    /// The chunk's own node.
    fn chunk(&mut self, chunk: &Chunk) -> u32 {
        self.inner(chunk, LOG2_CHUNK, [0; 3])
    }

    /// The node of a cube of 2^`height` voxels, 3 or more, in a chunk; 0 if it is empty. Cells count such cubes.
    fn inner(&mut self, chunk: &Chunk, height: u32, cell: [u32; 3]) -> u32 {
        if height == 4 && chunk.node_mask(child_index(cell[0], cell[1], cell[2]) as usize) == 0 {
            return 0;
        }
        let mut children = [0; 8];
        for (child, number) in children.iter_mut().zip(0..) {
            let cell = child_of(cell, number);
            *child = if height == 3 {
                self.block(chunk, block_index(cell[0], cell[1], cell[2]))
            } else {
                self.inner(chunk, height - 1, cell)
            };
        }
        self.parent(children)
    }

    /// The node of a 4³ block.
    fn block(&mut self, chunk: &Chunk, block: usize) -> u32 {
        let mask = chunk.mask(block);
        if mask == 0 {
            return 0;
        }
        let uniform = chunk.block_uniform(block);
        let mut children = [0; 8];
        for (child, number) in children.iter_mut().zip(0..) {
            let cell = child_of([0; 3], number);
            let here = mask & 0x0033_0033 << child_index(2 * cell[0], 2 * cell[1], 2 * cell[2]);
            *child = self.voxels(chunk, block, here, uniform);
        }
        self.parent(children)
    }

    /// The node of 2³ voxels, given as bits of their block.
    fn voxels(&mut self, chunk: &Chunk, block: usize, bits: u64, uniform: Option<MaterialIndex>) -> u32 {
        if bits == 0 {
            return 0;
        }
        // Their places in the mask of 4³ are ordered x, z, y; children are x, y, z.
        let base = bits.trailing_zeros() & 0b10_1010;
        let mask = (0..8).fold(0, |mask, number: u32| {
            let (x, y, z) = (number & 1, number >> 1 & 1, number >> 2);
            mask | ((bits >> (base + child_index(x, y, z)) & 1) as u32) << number
        });
        if let Some(material) = uniform {
            return solid(mask, material);
        }
        let materials = Bits(u64::from(mask)).map(|number| {
            let bit = base + child_index(number & 1, number >> 1 & 1, number >> 2);
            chunk.material(chunk.first(block) + (chunk.mask(block) & ((1 << bit) - 1)).count_ones())
        });
        let materials: Vec<MaterialIndex> = materials.collect();
        if materials.iter().all(|material| *material == materials[0]) {
            return solid(mask, materials[0]);
        }
        let pointer = self.attributes_at + self.next_attribute;
        for material in materials {
            if let Some(slot) = self.attributes.get_mut(self.next_attribute) {
                *slot = material;
            }
            self.next_attribute += 1;
        }
        mask | (pointer as u32) << POINTER_SHIFT
    }

    /// A node from its children, whose occupied ones are written unless it is solid.
    fn parent(&mut self, children: [u32; 8]) -> u32 {
        let mask = children.iter().enumerate().fold(0, |mask, (i, &child)| mask | u32::from(child != 0) << i);
        let mut occupied = children.into_iter().filter(|child| *child != 0);
        let Some(first) = occupied.clone().next() else { return 0 };
        let filled = first & 0x1ff == SOLID | 0xff;
        if filled && occupied.all(|child| child == first) {
            return first & 0xffff_0000 | SOLID | mask;
        }
        let pointer = self.next_node as u32;
        for child in children.into_iter().filter(|child| *child != 0) {
            if let Some(slot) = self.nodes.get_mut(self.next_node) {
                *slot = child;
            }
            self.next_node += 1;
        }
        mask | pointer << POINTER_SHIFT
    }
}

fn solid(mask: u32, material: MaterialIndex) -> u32 {
    u32::from(material) << 16 | SOLID | mask
}

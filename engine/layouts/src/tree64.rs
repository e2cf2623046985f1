//! Layout `tree64`: see `shaders/include/raxel/internal/layouts/tree64.glsl` for the format.

mod live;
mod shared;

use std::collections::HashMap;

use rayon::prelude::*;

pub use live::LiveTree64;
use raxel_world::MaterialIndex;
use raxel_world::{Bits, Chunk, child_index};
use raxel_world::{ChunkPos, World};

use super::block::layout_header;
use super::header::{Extent, MATERIAL_WORDS, buffer};
use super::packed::Packing;
use super::parts::{filled_node, has_full_leaves, uniform_node};
use super::{Edits, Encoded, Encoding, Layout, LayoutError, check_size};
pub(super) use shared::SharedMaterials;

pub(super) static ENCODING: Encoding = Encoding {
    edits: Edits::Tree64,
    ..Encoding::new("tree64", Tree64Header::block_in_quads, |world, limits, _| encode(world, limits.buffer_bytes))
};

/// Words of a node.
pub(super) const QUAD: usize = 4;
/// Word 3 of a node whose occupied children are full, all of the material in the low half.
pub(super) const FILLED: u32 = 0x8000_0000;
/// Beside [`FILLED`], of several materials: word 2 is their link, as if the node were a leaf.
pub(super) const LINKED: u32 = 0x2000_0000;
/// Word 3 of a node whose voxels are all of the material in the low half; also a leaf's link, by itself.
pub(super) const UNIFORM: u32 = 0x4000_0000;

/// Bytes that the link of a leaf reaches: it has 29 bits, and counts words.
pub(super) const ADDRESSABLE: u64 = 4 << 29;

/// The link of a leaf of several materials: where they are packed, and in bits 29 and 31 how ([`Packing::kind`], 3 for 4).
pub(super) fn packed_link(kind: u32, at: usize) -> u32 {
    let code = kind.min(3);
    (code >> 1) << 31 | (code & 1) << 29 | at as u32
}

/// The words of one distinct chunk in the buffer.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ChunkSize {
    /// Nodes of 16³ voxels.
    pub(super) nodes: usize,
    /// Leaves: masks of 4³ voxels.
    pub(super) leaves: usize,
    /// Leaves of nodes of more than one material.
    pub(super) links: usize,
    /// Words of the materials of leaves of more than one.
    pub(super) attributes: usize,
}

/// A node: mask, address of its first child, and the materials of its voxels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Node {
    pub(super) mask: u64,
    pub(super) children: u32,
    pub(super) material: u32,
}

impl Node {
    pub(super) fn put(self, words: &mut [u32], at: usize) {
        words[at..at + QUAD].copy_from_slice(&[
            self.mask as u32,
            (self.mask >> 32) as u32,
            self.children,
            self.material,
        ]);
    }
}

/// Where the parts of the buffer begin, in words from the end of the header.
struct Sections {
    nodes: usize,
    leaves: usize,
    links: usize,
    attributes: usize,
    end: usize,
}

layout_header! {
    /// Header of the layout `tree64`. Addresses count from the first word behind the header, in units of their targets: words, nodes of
    /// four words, leaves of two.
    Tree64Header {
        /// Address of the root node.
        root: u32,
        /// Nodes in the buffer.
        node_count: u32,
        /// Leaves in the buffer.
        leaf_count: u32,
        /// Always 0: the nodes behind begin at a multiple of their size.
        unused: u32,
    }
}

pub(super) fn encode(world: &World, limit: u64) -> Result<Encoded, LayoutError> {
    let layout = Layout::TREE64;
    let extent = Extent::of(world, layout)?;
    let levels = (extent.log2_size - 6) / 2;
    let (distinct, uses) = distinct_chunks(world, &extent);
    let (sizes, mut materials) = SharedMaterials::of(&distinct);

    let sum = |part: fn(&ChunkSize) -> usize| sizes.iter().map(part).sum::<usize>();
    let upper = upper_nodes(&uses, levels);
    let nodes = upper + sum(|size| size.nodes);
    let [leaves, links] = [sum(|size| size.leaves), sum(|size| size.links)];
    let mut at = Sections {
        nodes: MATERIAL_WORDS as usize * world.materials().len(),
        leaves: 0,
        links: 0,
        attributes: 0,
        end: 0,
    };
    at.leaves = at.nodes + QUAD * nodes;
    at.links = at.leaves + 2 * leaves;
    at.attributes = at.links + links;
    // Nodes are read four words at a time, the last leaf too.
    at.end = (at.attributes + materials.words.len()).next_multiple_of(QUAD);
    let bytes = check_size(layout, 4 * (Tree64Header::WORDS as usize + at.end) as u64, limit.min(ADDRESSABLE))?;

    materials.begin_at(at.attributes);

    let header = Tree64Header {
        root: (at.nodes / QUAD) as u32,
        node_count: nodes as u32,
        leaf_count: leaves as u32,
        unused: 0,
        ..Tree64Header::of(&extent, world.materials())
    };
    let mut buffer = buffer(&header, world.materials(), Tree64Header::WORDS as usize + at.end);

    let body = &mut buffer[Tree64Header::WORDS as usize..];
    let roots = fill_chunks(&distinct, &sizes, &materials.links, body, &at, upper);
    body[at.attributes..][..materials.words.len()].copy_from_slice(&materials.words);
    let chunks = uses.iter().map(|&(path, index)| (path, roots[index])).collect();
    fill_upper(chunks, levels, &mut body[at.nodes..at.nodes + QUAD * upper], at.nodes);

    let geometry_bytes = 4 * (Tree64Header::WORDS as usize + at.links - at.nodes) as u64;
    Ok(Encoded { words: buffer, geometry_bytes, attribute_bytes: bytes - geometry_bytes })
}

/// The distinct chunks of a world, and for every chunk its path from the root with the index of its distinct one, in the order of
/// the paths.
fn distinct_chunks<'a>(world: &'a World, extent: &Extent) -> (Vec<&'a Chunk>, Vec<(u128, usize)>) {
    let mut known: HashMap<*const Chunk, usize> = HashMap::new();
    let mut distinct: Vec<&Chunk> = Vec::new();
    let mut uses: Vec<(u128, usize)> = world
        .chunks()
        .map(|(pos, chunk)| {
            let index = *known.entry(std::sync::Arc::as_ptr(chunk)).or_insert_with(|| {
                distinct.push(chunk);
                distinct.len() - 1
            });
            (path(pos, extent), index)
        })
        .collect();
    uses.sort_unstable();
    (distinct, uses)
}

/// Child indices from the root down to a chunk, 6 bits each, the root's highest.
fn path(pos: ChunkPos, extent: &Extent) -> u128 {
    let [ox, oy, oz] = extent.origin.map(|origin| origin >> 6);
    let (x, y, z) = ((pos.x - ox).cast_unsigned(), (pos.y - oy).cast_unsigned(), (pos.z - oz).cast_unsigned());
    let levels = (extent.log2_size - 6) / 2;
    (0..levels).rev().fold(0, |path, level| {
        let digit = |c: u32| c >> (2 * level) & 3;
        path << 6 | u128::from(child_index(digit(x), digit(y), digit(z)))
    })
}

/// Nodes from the root down to the chunks at these paths, both included.
fn upper_nodes<T>(chunks: &[(u128, T)], levels: u32) -> usize {
    let of_level = |level: u32| chunks.chunk_by(|a, b| a.0 >> (6 * level) == b.0 >> (6 * level)).count();
    (0..=levels).map(of_level).sum::<usize>().max(1)
}

impl ChunkSize {
    /// With room of the chunk's own for materials.
    pub(super) fn of(chunk: &Chunk) -> Self {
        let mut attributes = 0;
        let size = Self::visit(chunk, false, |block| attributes += Packing::of(chunk.block_materials(block)).words());
        Self { attributes, ..size }
    }

    /// Without room for materials; `mixed` is given each block of several materials, in the order of the leaves. If all nodes share a run of
    /// full leaves, a node with full leaves only has no leaves of its own.
    fn visit(chunk: &Chunk, full_run: bool, mut mixed: impl FnMut(usize)) -> Self {
        let mut size = Self::default();
        if filled_chunk(chunk).is_some() {
            return size;
        }
        for node in 0..64 {
            let mask = chunk.node_mask(node);
            if mask == 0 {
                continue;
            }
            size.nodes += 1;
            if filled_node(chunk, node).is_some() {
                continue;
            }
            let leaves = mask.count_ones() as usize;
            size.leaves += if full_run && has_full_leaves(chunk, node) { 0 } else { leaves };
            if uniform_node(chunk, node).is_some() {
                continue;
            }
            size.links += leaves;
            for block in Bits(mask).map(|bit| node * 64 + bit as usize) {
                if chunk.block_uniform(block).is_none() {
                    mixed(block);
                }
            }
        }
        size
    }
}

/// The material of a chunk all of whose occupied 16³ nodes are full and of that one material.
pub(super) fn filled_chunk(chunk: &Chunk) -> Option<MaterialIndex> {
    let mut found = None;
    for node in Bits(chunk.root_mask()) {
        if chunk.node_mask(node as usize) != u64::MAX {
            return None;
        }
        let material = filled_node(chunk, node as usize)?;
        if *found.get_or_insert(material) != material {
            return None;
        }
    }
    found
}

/// A part of the buffer, and the address of its first element.
pub(super) struct Part<'a, T> {
    pub(super) rest: &'a mut [T],
    pub(super) at: usize,
}

impl<'a, T> Part<'a, T> {
    /// Takes the next `count` elements.
    fn take(&mut self, count: usize) -> Part<'a, T> {
        let (taken, rest) = std::mem::take(&mut self.rest).split_at_mut(count);
        let at = self.at;
        self.rest = rest;
        self.at += count;
        Part { rest: taken, at }
    }
}

/// The parts of the buffer that a chunk fills. Addresses of nodes and leaves are counted in their own sizes.
pub(super) struct Room<'a> {
    pub(super) nodes: Part<'a, [u32; QUAD]>,
    pub(super) leaves: Part<'a, [u32; 2]>,
    pub(super) links: Part<'a, u32>,
    pub(super) materials: Materials<'a>,
    /// The first of 64 full leaves that are there for every chunk.
    pub(super) full_run: Option<u32>,
}

/// The materials of the leaves of a chunk that have several.
pub(super) enum Materials<'a> {
    /// They are packed into this part, leaf by leaf.
    Own(Part<'a, u32>),
    /// They are packed already; the links in the order of the leaves.
    Shared(std::slice::Iter<'a, u32>),
}

impl Materials<'_> {
    /// The link of the next leaf.
    fn link(&mut self, chunk: &Chunk, block: usize) -> u32 {
        match self {
            Self::Own(part) => {
                let packing = Packing::of(chunk.block_materials(block));
                let words = part.take(packing.words());
                packing.write(chunk.block_materials(block), words.rest);
                packed_link(packing.kind, words.at)
            }
            Self::Shared(links) => *links.next().expect("there is one for each block that `ChunkSize::visit` gives"),
        }
    }
}

/// Encodes every distinct chunk into its parts of the buffer, in parallel, and gives their nodes.
/// `materials` has the links of each.
fn fill_chunks(
    distinct: &[&Chunk],
    sizes: &[ChunkSize],
    materials: &[Vec<u32>],
    body: &mut [u32],
    at: &Sections,
    upper: usize,
) -> Vec<Node> {
    let (front, _) = body.split_at_mut(at.attributes);
    let (front, links) = front.split_at_mut(at.links);
    let (front, leaves) = front.split_at_mut(at.leaves);
    let first_node = at.nodes / QUAD + upper;
    let nodes = &mut front[QUAD * first_node..at.leaves];
    let mut nodes = Part { rest: bytemuck::cast_slice_mut(nodes), at: first_node };
    let mut leaves = Part { rest: bytemuck::cast_slice_mut(leaves), at: at.leaves / 2 };
    let mut links = Part { rest: links, at: at.links };
    let rooms: Vec<Room> = (sizes.iter().zip(materials))
        .map(|(size, materials)| Room {
            nodes: nodes.take(size.nodes),
            leaves: leaves.take(size.leaves),
            links: links.take(size.links),
            materials: Materials::Shared(materials.iter()),
            full_run: None,
        })
        .collect();
    distinct.par_iter().zip(rooms).map(|(chunk, room)| encode_chunk(chunk, room)).collect()
}

/// Writes the nodes of a chunk below its own, its leaves, and the materials of its voxels.
pub(super) fn encode_chunk(chunk: &Chunk, mut room: Room) -> Node {
    let mask = chunk.root_mask();
    if let Some(material) = filled_chunk(chunk) {
        return Node { mask, children: 0, material: FILLED | u32::from(material) };
    }
    let children = room.nodes.at as u32;
    for node in Bits(mask).map(|node| node as usize) {
        let mask = chunk.node_mask(node);
        let slot = &mut room.nodes.take(1).rest[0];
        if let Some(material) = filled_node(chunk, node) {
            Node { mask, children: 0, material: FILLED | u32::from(material) }.put(slot, 0);
            continue;
        }
        let blocks = || Bits(mask).map(|bit| node * 64 + bit as usize);
        let count = mask.count_ones() as usize;
        let first_leaf = match room.full_run {
            Some(run) if has_full_leaves(chunk, node) => run,
            _ => {
                let leaves = room.leaves.take(count);
                for (leaf, block) in leaves.rest.iter_mut().zip(blocks()) {
                    *leaf = [chunk.mask(block) as u32, (chunk.mask(block) >> 32) as u32];
                }
                leaves.at as u32
            }
        };
        let material = uniform_node(chunk, node).map_or_else(
            || {
                let links = room.links.take(count);
                for (link, block) in links.rest.iter_mut().zip(blocks()) {
                    *link = chunk
                        .block_uniform(block)
                        .map_or_else(|| room.materials.link(chunk, block), |material| UNIFORM | u32::from(material));
                }
                links.at as u32
            },
            |material| UNIFORM | u32::from(material),
        );
        Node { mask, children: first_leaf, material }.put(slot, 0);
    }
    Node { mask, children, material: 0 }
}

/// Writes the nodes from the root (first) down to the chunks, level by level. `chunks` are in the order of their paths, so siblings
/// are neighbours; `words_at` is the address of `words`.
fn fill_upper(chunks: Vec<(u128, Node)>, levels: u32, words: &mut [u32], words_at: usize) {
    let mut level = chunks;
    let mut end = words.len();
    for _ in 0..levels {
        let start = end - QUAD * level.len();
        let mut parents: Vec<(u128, Node)> = Vec::new();
        for (i, &(path, node)) in level.iter().enumerate() {
            let at = start + QUAD * i;
            node.put(words, at);
            if parents.last().is_none_or(|(parent, _)| *parent != path >> 6) {
                let children = ((words_at + at) / QUAD) as u32;
                parents.push((path >> 6, Node { mask: 0, children, material: 0 }));
            }
            if let Some((_, parent)) = parents.last_mut() {
                parent.mask |= 1 << (path & 63);
            }
        }
        level = parents;
        end = start;
    }
    // An empty world has an empty root.
    level.first().map_or(Node::default(), |(_, node)| *node).put(words, 0);
}

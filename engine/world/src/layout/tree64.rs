//! Layout `tree64`: see `shaders/include/raxel/tree64.glsl` for the format.

use std::collections::HashMap;

use rayon::prelude::*;

use super::header::{Extent, MATERIAL_WORDS, Tree64Header, material_words};
use super::{Encoded, Layout, LayoutError, check_size};
use crate::chunk::{Bits, Chunk, child_index};
use crate::material::MaterialIndex;
use crate::world::{ChunkPos, World};

/// Words of a node.
const NODE_WORDS: usize = 3;
/// Link of a node whose occupied children are filled with the material in the low half.
const SOLID_LINK: u32 = 0x8000_0000;

/// What one distinct chunk takes in the buffer.
#[derive(Clone, Copy, Default)]
struct ChunkSize {
    /// Words of nodes below the chunk's own.
    node_words: usize,
    /// Halfwords of materials.
    attributes: usize,
}

/// A node: its mask and its link.
type Node = (u64, u32);

pub(super) fn encode(world: &World, limit: u64) -> Result<Encoded, LayoutError> {
    let layout = Layout::Tree64;
    let extent = Extent::of(world, layout)?;
    let (distinct, uses) = distinct_chunks(world, &extent);
    let sizes: Vec<ChunkSize> = distinct.par_iter().map(|chunk| ChunkSize::of(chunk)).collect();

    // The nodes from the root down to the chunks come first, then each chunk's nodes, then the materials of voxels.
    let upper_words = NODE_WORDS * upper_nodes(&uses, extent.log2_size);
    let chunk_words: usize = sizes.iter().map(|size| size.node_words).sum();
    let attributes: usize = sizes.iter().map(|size| size.attributes).sum();
    let materials_at = 0;
    let root = MATERIAL_WORDS as usize * world.materials().len();
    let chunks_at = root + upper_words;
    let attributes_at = chunks_at + chunk_words;
    let words = Tree64Header::WORDS as usize + attributes_at + attributes.div_ceil(2);
    // Links have 31 bits, and those to materials count halfwords.
    let addressable = 4 * (1 << 30);
    let bytes = check_size(layout, 4 * words as u64, limit.min(addressable))?;

    let header = Tree64Header {
        origin: extent.origin,
        log2_size: extent.log2_size,
        bounds_min: extent.bounds_min,
        material_count: world.materials().len() as u32,
        bounds_last: extent.bounds_last,
        materials_at,
        root: root as u32,
        node_count: ((upper_words + chunk_words) / NODE_WORDS) as u32,
        attributes_at: attributes_at as u32,
        attribute_count: attributes as u32,
    };
    let mut buffer = Vec::with_capacity(words);
    buffer.extend_from_slice(bytemuck::cast_slice(&[header]));
    buffer.extend(material_words(world.materials()));
    buffer.resize(words, 0);

    let body = &mut buffer[Tree64Header::WORDS as usize..];
    let (front, attribute_words) = body.split_at_mut(attributes_at);
    let (front, node_words) = front.split_at_mut(chunks_at);
    let nodes = fill_chunks(&distinct, &sizes, node_words, chunks_at, attribute_words, attributes_at);
    fill_upper(&uses, &nodes, extent.log2_size, &mut front[root..], root);

    let geometry_bytes = 4 * (Tree64Header::WORDS as usize + upper_words + chunk_words) as u64;
    Ok(Encoded { words: buffer, geometry_bytes, attribute_bytes: bytes - geometry_bytes })
}

/// The distinct chunks of a world, and for every chunk its path from the root (6 bits a level) with the index of its distinct one,
/// in the order of the paths.
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
    let (x, y, z) = ((pos.x - ox) as u32, (pos.y - oy) as u32, (pos.z - oz) as u32);
    let levels = (extent.log2_size - 6) / 2;
    (0..levels).rev().fold(0, |path, level| {
        let digit = |c: u32| c >> (2 * level) & 3;
        path << 6 | u128::from(child_index(digit(x), digit(y), digit(z)))
    })
}

/// Nodes from the root down to the chunks, both included.
fn upper_nodes(uses: &[(u128, usize)], log2_size: u32) -> usize {
    let levels = (log2_size - 6) / 2;
    let of_level = |level: u32| uses.chunk_by(|a, b| a.0 >> (6 * level) == b.0 >> (6 * level)).count();
    (0..=levels).map(of_level).sum::<usize>().max(1)
}

impl ChunkSize {
    fn of(chunk: &Chunk) -> Self {
        let mut size = Self::default();
        if solid_chunk(chunk).is_some() {
            return size;
        }
        for node in 0..64 {
            let mask = chunk.node_mask(node);
            if mask == 0 {
                continue;
            }
            size.node_words += NODE_WORDS;
            if solid_node(chunk, node).is_some() {
                continue;
            }
            size.node_words += NODE_WORDS * mask.count_ones() as usize;
            for block in Bits(mask).map(|bit| node * 64 + bit as usize) {
                if uniform(chunk, block).is_none() {
                    size.attributes += chunk.mask(block).count_ones() as usize;
                }
            }
        }
        size
    }
}

/// The only material of a block, if there is only one.
fn uniform(chunk: &Chunk, block: usize) -> Option<MaterialIndex> {
    if let Some(material) = chunk.uniform() {
        return Some(material);
    }
    let mut materials = chunk.block_materials(block);
    let first = materials.next()?;
    materials.all(|material| material == first).then_some(first)
}

/// The material of a 16³ node (0…63) all of whose occupied blocks are full and of that one material.
fn solid_node(chunk: &Chunk, node: usize) -> Option<MaterialIndex> {
    let mut found = None;
    for block in node * 64..node * 64 + 64 {
        match chunk.mask(block) {
            0 => continue,
            u64::MAX => {}
            _ => return None,
        }
        let material = uniform(chunk, block)?;
        if *found.get_or_insert(material) != material {
            return None;
        }
    }
    found
}

/// The material of a chunk all of whose occupied 16³ nodes are full and of that one material.
fn solid_chunk(chunk: &Chunk) -> Option<MaterialIndex> {
    let mut found = None;
    for node in Bits(chunk.root_mask()) {
        if chunk.node_mask(node as usize) != u64::MAX {
            return None;
        }
        let material = solid_node(chunk, node as usize)?;
        if *found.get_or_insert(material) != material {
            return None;
        }
    }
    found
}

/// Encodes every distinct chunk into its part of the buffer, in parallel, and gives their nodes.
fn fill_chunks(
    distinct: &[&Chunk],
    sizes: &[ChunkSize],
    mut node_words: &mut [u32],
    mut nodes_at: usize,
    attribute_words: &mut [u32],
    attributes_at: usize,
) -> Vec<Node> {
    struct Job<'a> {
        chunk: &'a Chunk,
        nodes: &'a mut [u32],
        nodes_at: usize,
        attributes: &'a mut [u16],
        attributes_at: usize,
    }
    let mut halfwords: &mut [u16] = bytemuck::cast_slice_mut(attribute_words);
    let mut halfwords_at = 2 * attributes_at;
    let mut jobs = Vec::with_capacity(distinct.len());
    for (chunk, size) in distinct.iter().zip(sizes) {
        let (nodes, rest) = node_words.split_at_mut(size.node_words);
        node_words = rest;
        let (attributes, rest) = halfwords.split_at_mut(size.attributes);
        halfwords = rest;
        jobs.push(Job { chunk, nodes, nodes_at, attributes, attributes_at: halfwords_at });
        nodes_at += size.node_words;
        halfwords_at += size.attributes;
    }
    let encode = |job: Job| encode_chunk(job.chunk, job.nodes, job.nodes_at, job.attributes, job.attributes_at);
    jobs.into_par_iter().map(encode).collect()
}

/// Writes the nodes of a chunk below its own, and the materials of its voxels. Addresses are those of the slices in the buffer.
fn encode_chunk(
    chunk: &Chunk,
    nodes: &mut [u32],
    nodes_at: usize,
    attributes: &mut [u16],
    attributes_at: usize,
) -> Node {
    let root_mask = chunk.root_mask();
    if let Some(material) = solid_chunk(chunk) {
        return (root_mask, SOLID_LINK | u32::from(material));
    }
    // The chunk's children are neighbours; the children of each follow in turn.
    let mut next_node = NODE_WORDS * root_mask.count_ones() as usize;
    let mut next_attribute = 0;
    for (slot, node) in Bits(root_mask).enumerate() {
        let first_block = node as usize * 64;
        let mask = chunk.node_mask(node as usize);
        if let Some(material) = solid_node(chunk, node as usize) {
            put(nodes, NODE_WORDS * slot, (mask, SOLID_LINK | u32::from(material)));
            continue;
        }
        put(nodes, NODE_WORDS * slot, (mask, (nodes_at + next_node) as u32));
        for bit in Bits(mask) {
            let block = first_block + bit as usize;
            let link = uniform(chunk, block).map_or_else(
                || {
                    let link = (attributes_at + next_attribute) as u32;
                    for material in chunk.block_materials(block) {
                        attributes[next_attribute] = material;
                        next_attribute += 1;
                    }
                    link
                },
                |material| SOLID_LINK | u32::from(material),
            );
            put(nodes, next_node, (chunk.mask(block), link));
            next_node += NODE_WORDS;
        }
    }
    (root_mask, nodes_at as u32)
}

/// Writes the nodes from the root (first) down to the chunks, level by level.
fn fill_upper(uses: &[(u128, usize)], chunks: &[Node], log2_size: u32, words: &mut [u32], words_at: usize) {
    let levels = (log2_size - 6) / 2;
    // From the chunks upwards; each level's nodes are in the order of their paths, so siblings are neighbours.
    let mut level: Vec<(u128, Node)> = uses.iter().map(|&(path, index)| (path, chunks[index])).collect();
    let mut end = words.len();
    for _ in 0..levels {
        let start = end - NODE_WORDS * level.len();
        let mut parents: Vec<(u128, Node)> = Vec::new();
        for (i, &(path, node)) in level.iter().enumerate() {
            let at = start + NODE_WORDS * i;
            put(words, at, node);
            if parents.last().is_none_or(|(parent, _)| *parent != path >> 6) {
                parents.push((path >> 6, (0, (words_at + at) as u32)));
            }
            if let Some((_, (mask, _))) = parents.last_mut() {
                *mask |= 1 << (path & 63);
            }
        }
        level = parents;
        end = start;
    }
    // An empty world has an empty root.
    let root = level.first().map_or((0, SOLID_LINK), |(_, node)| *node);
    put(words, 0, root);
}

fn put(words: &mut [u32], at: usize, (mask, link): Node) {
    words[at] = mask as u32;
    words[at + 1] = (mask >> 32) as u32;
    words[at + 2] = link;
}

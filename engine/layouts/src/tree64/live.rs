//! The layout `tree64` in a buffer with room to spare. An edit replaces only the blocks of the chunks that it touched, and the nodes above
//! all chunks.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use offset_allocator::{Allocation, Allocator};
use raxel_world::Chunk;
use raxel_world::{ChunkPos, World};
use rayon::prelude::*;

use super::{
    ADDRESSABLE, ChunkSize, MATERIAL_WORDS, Materials, Node, Part, QUAD, Room, Tree64Header, encode_chunk, fill_upper,
    path, upper_nodes,
};
use crate::header::{Extent, buffer};
use crate::live::{Patch, roomy};
use crate::{Layout, LayoutError, check_size};

/// Spare quads besides a quarter of the world's: 4 MiB.
const ROOM: u64 = 1 << 18;

/// A world in a buffer of the layout `tree64` that follows edits.
pub struct LiveTree64 {
    extent: Extent,
    materials: usize,
    /// Words of the whole buffer.
    capacity: usize,
    /// Of the quads behind the materials.
    allocator: Allocator,
    /// Blocks by the address of their chunk; a block is shared by equal chunks.
    blocks: HashMap<usize, Block>,
    /// The block of each chunk, by its path from the root.
    places: BTreeMap<u128, usize>,
    /// The nodes from the root down to the chunks.
    upper: Option<Upper>,
}

/// The nodes from the root down to the chunks.
#[derive(Clone, Copy)]
struct Upper {
    place: Allocation,
    /// Quads that they may take.
    room: u32,
    /// Quads that they take, one each.
    nodes: u32,
}

/// A chunk's words in the buffer. It holds the chunk, so that no other one comes to lie at its address.
struct Block {
    chunk: Arc<Chunk>,
    uses: usize,
    node: Node,
    size: ChunkSize,
    /// A chunk that its node describes completely has none.
    place: Option<Allocation>,
}

impl LiveTree64 {
    /// Puts a world into a buffer, whose words are given as well.
    pub fn new(world: &World, limit: u64) -> Result<(Self, Vec<u32>), LayoutError> {
        let layout = Layout::TREE64;
        let extent = roomy(world, layout)?;
        let chunks: Vec<(u128, &Arc<Chunk>)> = world.chunks().map(|(pos, chunk)| (path(pos, &extent), chunk)).collect();
        let mut distinct: HashMap<usize, &Arc<Chunk>> = HashMap::new();
        for (_, chunk) in &chunks {
            distinct.entry(address(chunk)).or_insert(chunk);
        }
        let mut distinct: Vec<&Arc<Chunk>> = distinct.into_values().collect();
        distinct.sort_unstable_by_key(|chunk| address(chunk));
        let sizes: Vec<ChunkSize> = distinct.par_iter().map(|chunk| ChunkSize::of(chunk)).collect();

        let quads: u64 = sizes.iter().map(|size| u64::from(quads_of(size))).sum();
        let front = u64::from(Tree64Header::WORDS) + u64::from(MATERIAL_WORDS) * world.materials().len() as u64;
        let needed = quads + quads / 4 + 2 * chunks.len() as u64 + ROOM;
        let limit = limit.min(ADDRESSABLE);
        let least = 4 * front + 16 * (quads + upper_quads(chunks.len()));
        check_size(layout, least, limit)?;
        let quads = needed.min((limit / 4 - front) / QUAD as u64);
        let capacity = (front + quads * QUAD as u64) as usize;
        let most = (4 * distinct.len() as u32).max(1 << 16);
        let mut live = Self {
            extent,
            materials: world.materials().len(),
            capacity,
            allocator: Allocator::with_max_allocs(quads as u32, most),
            blocks: HashMap::new(),
            places: BTreeMap::new(),
            upper: None,
        };
        // The gaps between blocks may take what is left of a small buffer, but not of one with all of the room.
        let bytes = 4 * front + 16 * needed;
        let patches = (live.change(chunks.iter().map(|(path, chunk)| (*path, Some((*chunk).clone()))).collect()))
            .ok_or(LayoutError::TooLarge { layout: layout.name(), bytes, limit })?;
        let mut words = buffer(&live.header(world), world.materials(), capacity);
        for patch in patches {
            words[patch.at..patch.at + patch.words.len()].copy_from_slice(&patch.words);
        }
        words[..Tree64Header::WORDS as usize].copy_from_slice(&live.header_words(world));
        Ok((live, words))
    }

    /// Follows a change of chunks, after which the world is `world`. Gives the changed words, in parts that do not overlap; `None` when the
    /// world no longer fits. Then encode it again.
    pub fn update(
        &mut self,
        world: &World,
        changes: impl IntoIterator<Item = (ChunkPos, Option<Arc<Chunk>>)>,
    ) -> Option<Vec<Patch>> {
        if world.materials().len() != self.materials {
            return None;
        }
        let mut of_path = Vec::new();
        for (pos, chunk) in changes {
            if self.extent.holds(pos) {
                of_path.push((path(pos, &self.extent), chunk));
            } else if chunk.is_some() {
                return None;
            }
        }
        let mut patches = self.change(of_path)?;
        patches.push(Patch { at: 0, words: self.header_words(world) });
        Some(patches)
    }

    /// Words of the buffer.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    fn change(&mut self, changes: Vec<(u128, Option<Arc<Chunk>>)>) -> Option<Vec<Patch>> {
        let mut fresh: Vec<usize> = Vec::new();
        for (path, chunk) in changes {
            // The new one first: it may be the old one.
            if let Some(chunk) = &chunk {
                let block = self.blocks.entry(address(chunk)).or_insert_with(|| {
                    fresh.push(address(chunk));
                    Block {
                        chunk: chunk.clone(),
                        uses: 0,
                        node: Node::default(),
                        size: ChunkSize::default(),
                        place: None,
                    }
                });
                block.uses += 1;
            }
            let before = match &chunk {
                Some(chunk) => self.places.insert(path, address(chunk)),
                None => self.places.remove(&path),
            };
            if let Some(before) = before {
                self.release(before);
            }
        }
        let base = Tree64Header::WORDS as usize;
        let first = MATERIAL_WORDS as usize * self.materials;
        // One that was made and replaced again is gone already.
        fresh.retain(|address| self.blocks.contains_key(address));
        let chunks: Vec<Arc<Chunk>> = fresh.iter().map(|address| self.blocks[address].chunk.clone()).collect();
        let sizes: Vec<ChunkSize> = chunks.par_iter().map(|chunk| ChunkSize::of(chunk)).collect();
        let mut starts = Vec::with_capacity(fresh.len());
        for (address, size) in fresh.iter().zip(&sizes) {
            let place = match quads_of(size) {
                0 => None,
                quads => Some(self.allocator.allocate(quads)?),
            };
            starts.push(first + QUAD * place.map_or(0, |place| place.offset as usize));
            let block = self.blocks.get_mut(address)?;
            (block.place, block.size) = (place, *size);
        }
        let encoded: Vec<(Node, Vec<u32>)> = (chunks.par_iter().zip(&sizes).zip(&starts))
            .map(|((chunk, size), start)| encode_block(chunk, size, *start))
            .collect();
        let mut patches = Vec::with_capacity(encoded.len() + 2);
        for ((address, start), (node, words)) in fresh.iter().zip(starts).zip(encoded) {
            self.blocks.get_mut(address)?.node = node;
            if !words.is_empty() {
                patches.push(Patch { at: base + start, words });
            }
        }
        patches.push(self.put_upper()?);
        Some(patches)
    }

    fn release(&mut self, address: usize) {
        let Some(block) = self.blocks.get_mut(&address) else { return };
        block.uses -= 1;
        if block.uses == 0
            && let Some(Block { place: Some(place), .. }) = self.blocks.remove(&address)
        {
            self.allocator.free(place);
        }
    }

    /// The nodes from the root down to the chunks.
    fn put_upper(&mut self) -> Option<Patch> {
        let levels = (self.extent.log2_size - 6) / 2;
        let chunks: Vec<(u128, Node)> =
            self.places.iter().map(|(path, address)| (*path, self.blocks[address].node)).collect();
        let quads = upper_nodes(&chunks, levels);
        let (place, room) = match self.upper {
            Some(upper) if upper.room >= quads as u32 => (upper.place, upper.room),
            small => {
                if let Some(small) = small {
                    self.allocator.free(small.place);
                }
                let room = (quads + quads / 4 + 64) as u32;
                (self.allocator.allocate(room)?, room)
            }
        };
        self.upper = Some(Upper { place, room, nodes: quads as u32 });
        let at = MATERIAL_WORDS as usize * self.materials + QUAD * place.offset as usize;
        let mut words = vec![0; QUAD * quads];
        fill_upper(chunks, levels, &mut words, at);
        Some(Patch { at: Tree64Header::WORDS as usize + at, words })
    }

    fn header(&self, world: &World) -> Tree64Header {
        let nodes: usize = self.blocks.values().map(|block| block.size.nodes).sum();
        let leaves: usize = self.blocks.values().map(|block| block.size.leaves).sum();
        let extent = self.extent.with_bounds_of(world);
        Tree64Header {
            root: (MATERIAL_WORDS as usize * self.materials / QUAD) as u32
                + self.upper.map_or(0, |upper| upper.place.offset),
            node_count: nodes as u32 + self.upper.map_or(0, |upper| upper.nodes),
            leaf_count: leaves as u32,
            unused: 0,
            ..Tree64Header::of(&extent, world.materials())
        }
    }

    fn header_words(&self, world: &World) -> Vec<u32> {
        bytemuck::cast_slice(std::slice::from_ref(&self.header(world))).to_vec()
    }
}

impl std::fmt::Debug for LiveTree64 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "LiveTree64({} chunks, {} words)", self.places.len(), self.capacity)
    }
}

/// The identity of a distinct chunk: equal chunks of a world are one.
fn address(chunk: &Arc<Chunk>) -> usize {
    Arc::as_ptr(chunk) as usize
}

/// Quads of a chunk's block.
fn quads_of(size: &ChunkSize) -> u32 {
    let words = QUAD * size.nodes + 2 * size.leaves + size.links + size.attributes;
    words.div_ceil(QUAD) as u32
}

/// An upper bound of the quads of the nodes above `chunks` chunks.
fn upper_quads(chunks: usize) -> u64 {
    2 * chunks as u64 + 128
}

/// The block of a chunk that begins at a word.
fn encode_block(chunk: &Chunk, size: &ChunkSize, start: usize) -> (Node, Vec<u32>) {
    let mut words = vec![0_u32; QUAD * quads_of(size) as usize];
    let (nodes, rest) = words.split_at_mut(QUAD * size.nodes);
    let (leaves, rest) = rest.split_at_mut(2 * size.leaves);
    let (links, attributes) = rest.split_at_mut(size.links);
    let leaves_at = start + QUAD * size.nodes;
    let links_at = leaves_at + 2 * size.leaves;
    let room = Room {
        nodes: Part { rest: bytemuck::cast_slice_mut(nodes), at: start / QUAD },
        leaves: Part { rest: bytemuck::cast_slice_mut(leaves), at: leaves_at / 2 },
        links: Part { rest: links, at: links_at },
        materials: Materials::Own(Part { rest: attributes, at: links_at + size.links }),
        full_run: None,
    };
    let node = encode_chunk(chunk, room);
    (node, words)
}

//! Single tiles in the format of the layout `tree64`: blocks of words for any place in a buffer, and the nodes that stand for them.
//!
//! A tile of level l is a node of height 3 + l. For a chunk, that node and everything below it are as [`super::Layout::TREE64`] makes them,
//! with one exception: 64 full leaves in a row are the full run, which all tiles share. A cell of a higher level is a filled cube of 4^l
//! voxels: 4³ cells are one filled node, which has their material, or the link of several.

use raxel_world::Content;
use raxel_world::{Bits, Chunk};
use raxel_world::{Material, MaterialIndex};

use super::header::{MATERIAL_WORDS, material_words};
use super::parts::filled_node;
use super::tree64::{
    ChunkSize, FILLED, LINKED, Materials, Node, Part, QUAD, Room, SharedMaterials, encode_chunk, filled_chunk,
};

/// Words of the full run: 64 full leaves.
pub const FULL_RUN_WORDS: u32 = 128;

/// The full run, once in a buffer that has tiles.
pub fn full_run() -> Vec<u32> {
    vec![u32::MAX; FULL_RUN_WORDS as usize]
}

/// The palette in the words of every layout.
pub fn palette(materials: &[Material]) -> Vec<u32> {
    debug_assert_eq!(material_words(materials).len(), materials.len() * MATERIAL_WORDS as usize);
    material_words(materials)
}

/// A node of the layout: four words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct TileNode(pub [u32; 4]);

impl TileNode {
    /// A node whose 64 children are full and of one material, at any height.
    pub fn filled(material: MaterialIndex) -> Self {
        Self([u32::MAX, u32::MAX, 0, FILLED | u32::from(material)])
    }

    /// A node of these children. `first` is the place of the first one, in nodes.
    pub fn of_children(mask: u64, first: u32) -> Self {
        Self([mask as u32, (mask >> 32) as u32, first, 0])
    }

    /// Which of its children are occupied.
    pub fn mask(self) -> u64 {
        u64::from(self.0[0]) | u64::from(self.0[1]) << 32
    }

    /// The material of its occupied children, if they are all full and of one.
    pub fn filled_material(self) -> Option<MaterialIndex> {
        (self.0[3] & FILLED != 0).then_some(self.0[3] as MaterialIndex)
    }
}

impl From<Node> for TileNode {
    fn from(node: Node) -> Self {
        Self([node.mask as u32, (node.mask >> 32) as u32, node.children, node.material])
    }
}

/// A tile that waits for its place in a buffer.
#[derive(Clone, Debug)]
pub struct TileBlock<'c> {
    chunk: &'c Chunk,
    level: u32,
    size: ChunkSize,
    /// The materials of its blocks of several materials.
    materials: SharedMaterials,
}

impl<'c> TileBlock<'c> {
    /// The block of a tile; `Err` with its node when it needs none, and without one when it is empty.
    pub fn of(content: &'c Content, level: u32) -> Result<Self, Option<TileNode>> {
        let chunk = match content {
            Content::Empty => return Err(None),
            Content::Full(material) => return Err(Some(TileNode::filled(*material))),
            Content::Chunk(chunk) => chunk,
        };
        if let Some(material) = filled_chunk(chunk) {
            let node = Node { mask: chunk.root_mask(), children: 0, material: FILLED | u32::from(material) };
            return Err(Some(node.into()));
        }
        let (size, materials) = if level == 0 { SharedMaterials::of_tile(chunk) } else { Self::cells(chunk) };
        Ok(Self { chunk, level, size, materials })
    }

    /// The size of a tile of cells: nodes of 16³ cells and of 4³.
    fn cells(chunk: &Chunk) -> (ChunkSize, SharedMaterials) {
        let nodes = || Bits(chunk.root_mask()).map(|node| node as usize);
        let split = || nodes().filter(|node| filled_node(chunk, *node).is_none());
        let blocks = || split().flat_map(|node| Bits(chunk.node_mask(node)).map(move |bit| node * 64 + bit as usize));
        let materials =
            SharedMaterials::of_blocks(chunk, blocks().filter(|block| chunk.block_uniform(*block).is_none()));
        let nodes = nodes().count() + blocks().count();
        (ChunkSize { nodes, attributes: materials.words.len(), ..ChunkSize::default() }, materials)
    }

    /// Words that it takes: a multiple of 4.
    pub fn words(&self) -> u32 {
        let ChunkSize { nodes, leaves, links, attributes } = self.size;
        let words = QUAD * nodes + 2 * leaves + links + attributes;
        words.next_multiple_of(QUAD) as u32
    }

    /// The block for a place in the buffer, with the node that stands for the tile. Its occupied children are the first nodes of the
    /// block, in the order of its mask. `at` is the place in words behind the header, a multiple of 4; `full_run` that of the full run.
    pub fn encode(&self, at: u32, full_run: u32) -> (Vec<u32>, TileNode) {
        let mut words = vec![0; self.words() as usize];
        let node = if self.level == 0 {
            self.encode_chunk(&mut words, at, full_run)
        } else {
            self.encode_cells(&mut words, at)
        };
        (words, node)
    }

    fn encode_chunk(&self, words: &mut [u32], at: u32, full_run: u32) -> TileNode {
        let at = at as usize;
        let ChunkSize { nodes, leaves, links, .. } = self.size;
        let (node_words, rest) = words.split_at_mut(QUAD * nodes);
        let (leaf_words, rest) = rest.split_at_mut(2 * leaves);
        let (link_words, attribute_words) = rest.split_at_mut(links);
        let leaves_at = at + QUAD * nodes;
        let links_at = leaves_at + 2 * leaves;
        let mut materials = self.materials.clone();
        materials.begin_at(links_at + links);
        attribute_words[..materials.words.len()].copy_from_slice(&materials.words);
        let room = Room {
            nodes: Part { rest: bytemuck::cast_slice_mut(node_words), at: at / QUAD },
            leaves: Part { rest: bytemuck::cast_slice_mut(leaf_words), at: leaves_at / 2 },
            links: Part { rest: link_words, at: links_at },
            materials: Materials::Shared(materials.links[0].iter()),
            full_run: Some(full_run / 2),
        };
        encode_chunk(self.chunk, room).into()
    }

    fn encode_cells(&self, words: &mut [u32], at: u32) -> TileNode {
        let chunk = self.chunk;
        let at = at as usize;
        let root = chunk.root_mask();
        // Nodes of 16³ cells, then those of 4³, then materials.
        let attributes = QUAD * self.size.nodes;
        let mut materials = self.materials.clone();
        materials.begin_at(at + attributes);
        words[attributes..][..materials.words.len()].copy_from_slice(&materials.words);
        let mut links = materials.links[0].iter();
        let mut next_block = root.count_ones() as usize;
        for (index, node) in Bits(root).map(|node| node as usize).enumerate() {
            let mask = chunk.node_mask(node);
            if let Some(material) = filled_node(chunk, node) {
                Node { mask, children: 0, material: FILLED | u32::from(material) }.put(words, QUAD * index);
                continue;
            }
            Node { mask, children: (at / QUAD + next_block) as u32, material: 0 }.put(words, QUAD * index);
            for block in Bits(mask).map(|bit| node * 64 + bit as usize) {
                let (children, material) = match chunk.block_uniform(block) {
                    Some(material) => (0, FILLED | u32::from(material)),
                    None => (*links.next().expect("`cells` links each block of several materials"), FILLED | LINKED),
                };
                Node { mask: chunk.mask(block), children, material }.put(words, QUAD * next_block);
                next_block += 1;
            }
        }
        TileNode::of_children(root, (at / QUAD) as u32)
    }
}

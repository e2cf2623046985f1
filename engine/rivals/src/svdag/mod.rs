//! Layout `svdag`: see `shaders/include/raxel/rivals/internal/layouts/svdag.glsl` for the format.

mod geometry;
mod materials;
mod upper;

use geometry::Geometry;
use materials::Materials;
use raxel_layouts::parts::Parts;
use raxel_layouts::{
    ADDRESSABLE, Encoded, Encoding, Extent, Layout, LayoutError, MATERIAL_WORDS, buffer, check_size, layout_header,
};
use raxel_world::World;
use upper::Upper;

/// A sparse octree in which equal subtrees are stored once.
pub const LAYOUT: Layout = Layout::new(&ENCODING);

static ENCODING: Encoding =
    Encoding::new("svdag", SvdagHeader::block, |world, limits, _| encode(world, limits.buffer_bytes));

/// Chunks have 2^6 voxels a side.
const LOG2_CHUNK: u32 = 6;

layout_header! {
    /// Header of the layout `svdag`. Addresses (`…_at`, `root`) count words from the first word behind the header.
    SvdagHeader {
        /// Address of the root: a node, or an instance if the cube is one chunk.
        root: u32,
        /// Different nodes and leaves inside chunks.
        node_count: u32,
        /// Different 4³ leaves.
        leaf_count: u32,
        /// Address of the packed materials of voxels.
        attributes_at: u32,
    }
}

fn encode(world: &World, limit: u64) -> Result<Encoded, LayoutError> {
    let layout = LAYOUT;
    let extent = Extent::of(world, layout)?;
    let parts = Parts::chunks(world, &extent);
    let geometry = Geometry::of(&parts.distinct);
    let materials = Materials::of(&parts.distinct);
    let uses = parts.uses.iter().map(|&(cell, chunk)| (cell, (geometry.root(chunk), materials.link(chunk))));
    let upper = Upper::of(uses, extent.log2_size - LOG2_CHUNK);

    let upper_at = MATERIAL_WORDS as usize * world.materials().len();
    let geometry_at = upper_at + upper.words();
    let attributes_at = geometry_at + geometry.words();
    let words = SvdagHeader::WORDS as usize + attributes_at + materials.words();
    // Addresses of packed materials have fewer bits, and begin at attributes_at.
    let addressable =
        if materials.words() > materials::MAX_WORDS { 4 * materials::MAX_WORDS as u64 } else { ADDRESSABLE };
    let bytes = check_size(layout, 4 * words as u64, limit.min(addressable))?;

    let header = SvdagHeader {
        root: upper_at as u32,
        node_count: geometry.node_count() as u32,
        leaf_count: geometry.leaf_count() as u32,
        attributes_at: attributes_at as u32,
        ..SvdagHeader::of(&extent, world.materials())
    };
    let mut buffer = buffer(&header, world.materials(), words);
    let body = &mut buffer[SvdagHeader::WORDS as usize..];
    let (front, attribute_words) = body.split_at_mut(attributes_at);
    let (front, geometry_words) = front.split_at_mut(geometry_at);
    upper.write(&mut front[upper_at..], upper_at, geometry_at);
    geometry.write(geometry_words, geometry_at);
    materials.write(attribute_words);

    // An instance's second word is the place of its materials.
    let attribute_words = upper_at + upper.instances() + materials.words();
    let attribute_bytes = 4 * attribute_words as u64;
    Ok(Encoded { words: buffer, geometry_bytes: bytes - attribute_bytes, attribute_bytes })
}

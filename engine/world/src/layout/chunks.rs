//! Layout `chunks`: see `shaders/include/raxel/chunks.glsl` for the format.

use std::collections::HashMap;

use glam::IVec3;
use rayon::prelude::*;

use super::header::{ChunksHeader, Extent, MATERIAL_WORDS, material_words};
use super::{Encoded, Layout, LayoutError, check_size};
use crate::chunk::{Chunk, block_cell};
use crate::world::World;

/// Voxels along an edge of one of this layout's chunks.
const EDGE: i32 = 32;
/// Words of the voxels of a chunk: two voxels a word.
const VOXEL_WORDS: usize = 32 * 32 * 32 / 2;
/// Words of a chunk in the list: its key in front, and its entry.
const LIST_WORDS: usize = 5;

pub(super) fn encode(world: &World, limit: u64) -> Result<Encoded, LayoutError> {
    let layout = Layout::Chunks;
    let extent = Extent::of(world, layout)?;
    let (list, parts) = list(world);

    let materials_at = 0;
    let chunks_at = MATERIAL_WORDS as usize * world.materials().len();
    let voxels_at = chunks_at + LIST_WORDS * list.len();
    let words = ChunksHeader::WORDS as usize + voxels_at + VOXEL_WORDS * parts.len();
    // Addresses are 32 bits wide and count words.
    let bytes = check_size(layout, 4 * words as u64, limit.min(4 << 32))?;

    let header = ChunksHeader {
        origin: extent.origin,
        log2_size: extent.log2_size,
        bounds_min: extent.bounds_min,
        material_count: world.materials().len() as u32,
        bounds_last: extent.bounds_last,
        materials_at,
        chunks_at: chunks_at as u32,
        chunk_count: list.len() as u32,
        voxels_at: voxels_at as u32,
        voxel_chunks: parts.len() as u32,
    };
    let mut buffer = Vec::with_capacity(words);
    buffer.extend_from_slice(bytemuck::cast_slice(&[header]));
    buffer.extend(material_words(world.materials()));
    // The search compares keys: ten bits of each coordinate.
    let key = |pos: &IVec3| (pos.x & 1023 | (pos.y & 1023) << 10 | (pos.z & 1023) << 20) as u32;
    buffer.extend(list.iter().map(|(pos, _)| key(pos)));
    for (pos, part) in &list {
        buffer.extend(pos.to_array().map(|c| c as u32));
        buffer.push((voxels_at + VOXEL_WORDS * part) as u32);
    }
    buffer.resize(words, 0);
    let voxels = &mut buffer[ChunksHeader::WORDS as usize + voxels_at..];
    voxels.par_chunks_exact_mut(VOXEL_WORDS).zip(&parts).for_each(|(words, (chunk, octant))| {
        fill(chunk, *octant, bytemuck::cast_slice_mut(words));
    });
    let attribute_bytes = 4 * u64::from(MATERIAL_WORDS) * world.materials().len() as u64;
    Ok(Encoded { words: buffer, geometry_bytes: bytes - attribute_bytes, attribute_bytes })
}

/// Octant of a 64³ chunk: bit 0 x, bit 1 y, bit 2 z.
type Part<'a> = (&'a Chunk, usize);

/// Every 32³ chunk with solids and the index of its voxels, and the distinct voxels.
fn list(world: &World) -> (Vec<(IVec3, usize)>, Vec<Part<'_>>) {
    let mut known: HashMap<*const Chunk, [Option<usize>; 8]> = HashMap::new();
    let mut parts: Vec<Part> = Vec::new();
    let mut list = Vec::new();
    for (pos, chunk) in world.chunks() {
        let octants = known.entry(std::sync::Arc::as_ptr(chunk)).or_insert_with(|| {
            std::array::from_fn(|octant| {
                let solid =
                    chunk.masks().iter().enumerate().any(|(block, mask)| *mask != 0 && octant_of(block) == octant);
                solid.then(|| {
                    parts.push((chunk, octant));
                    parts.len() - 1
                })
            })
        });
        for (octant, part) in octants.iter().enumerate() {
            let Some(part) = part else { continue };
            let [x, y, z] = [0, 1, 2].map(|axis| (octant >> axis & 1) as i32);
            list.push((pos.origin() / EDGE + IVec3::new(x, y, z), *part));
        }
    }
    (list, parts)
}

/// The octant of a chunk that a 4³ block lies in.
fn octant_of(block: usize) -> usize {
    let [x, y, z] = block_cell(block).map(|c| (c >> 3) as usize);
    x | y << 1 | z << 2
}

/// Writes the voxels of an octant.
fn fill(chunk: &Chunk, octant: usize, voxels: &mut [u16]) {
    for ([x, y, z], material) in chunk.iter() {
        let here = (x >> 5 | (y >> 5) << 1 | (z >> 5) << 2) as usize;
        if here == octant {
            voxels[((x & 31) | (y & 31) << 5 | (z & 31) << 10) as usize] = material;
        }
    }
}

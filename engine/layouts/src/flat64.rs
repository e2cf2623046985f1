//! Layout `flat64`: see `shaders/include/raxel/internal/layouts/flat64.glsl` for the format.

use raxel_world::MaterialIndex;
use raxel_world::World;
use raxel_world::{Bits, Chunk, child_cell};
use rayon::prelude::*;

use super::block::layout_header;
use super::header::{Extent, MATERIAL_WORDS, buffer};
use super::packed::Packing;
use super::parts::{Parts, filled_node};
use super::tree64::{ADDRESSABLE, packed_link};
use super::{Encoded, Encoding, Layout, LayoutError, check_size};

pub(super) static ENCODING: Encoding = Encoding {
    window: Some(WINDOW),
    ..Encoding::new("flat64", Flat64Header::block_in_quads, |world, limits, _| encode(world, limits.buffer_bytes))
};

/// Words of a record.
const QUAD: usize = 4;
/// Largest world, in voxels: a cell is one word in shaders, of 11, 10 and 11 bits.
pub(super) const WINDOW: [u64; 3] = [2048, 1024, 2048];
/// Words before the records that say for each octant of directions where rays begin and end.
const OCTANT_WORDS: usize = 8 * 3 * QUAD;
/// The cells of a ray are the low bits of a float; these are those of cell 0, 1.5 · 2²³ + 8192.
const CELL_BITS: u32 = 0x4b40_2000;
/// Link of a leaf whose voxels are all of the material in the low half.
const UNIFORM: u32 = 0x4000_0000;
/// Largest free radius: four bits.
const LARGEST_RADIUS: u8 = 15;
/// Leaves of a full 16³ block, which all blocks share that are full of one material.
const RUN: usize = 64;

layout_header! {
    /// Header of the layout `flat64`. Addresses count from the first word behind the header.
    Flat64Header {
        /// Address of the first record, in records of four words.
        records_at: u32,
        /// Records from one to the next along z (low half) and y.
        strides: u32,
        /// Address of the first leaf, in leaves of two words.
        leaves_at: u32,
        /// Address of the first leaf's link, in words.
        links_at: u32,
    }
}

/// The words of one distinct chunk in the buffer.
#[derive(Clone, Copy, Default)]
struct ChunkSize {
    leaves: usize,
    /// Words of materials.
    attributes: usize,
}

/// Where the parts of the buffer begin, in words from the end of the header.
struct Sections {
    octants: usize,
    records: usize,
    leaves: usize,
    links: usize,
    attributes: usize,
    end: usize,
}

pub(super) fn encode(world: &World, limit: u64) -> Result<Encoded, LayoutError> {
    let layout = Layout::FLAT64;
    let extent = Extent::of(world, layout)?;
    check_window(&extent)?;
    let parts = Parts::chunks(world, &extent);
    let runs = Runs::of(&parts.distinct);
    let sizes: Vec<ChunkSize> = parts.distinct.par_iter().map(|chunk| ChunkSize::of(chunk)).collect();
    let free = Free::of(&parts, &extent);

    let leaves = runs.leaves() + sizes.iter().map(|size| size.leaves).sum::<usize>();
    let attributes: usize = sizes.iter().map(|size| size.attributes).sum();
    let records = free.radii.len();
    let mut at = Sections {
        octants: MATERIAL_WORDS as usize * world.materials().len(),
        records: 0,
        leaves: 0,
        links: 0,
        attributes: 0,
        end: 0,
    };
    at.records = at.octants + OCTANT_WORDS;
    at.leaves = at.records + QUAD * records;
    at.links = at.leaves + 2 * leaves;
    at.attributes = at.links + leaves;
    // Leaves are read two at a time, the last one too.
    at.end = (at.attributes + attributes).next_multiple_of(QUAD);
    let bytes = check_size(layout, 4 * (Flat64Header::WORDS as usize + at.end) as u64, limit.min(ADDRESSABLE))?;

    let header = Flat64Header {
        records_at: (at.records / QUAD) as u32,
        strides: (free.size[0] | (free.size[0] * free.size[2]) << 16) as u32,
        leaves_at: (at.leaves / 2) as u32,
        links_at: at.links as u32,
        ..Flat64Header::of(&extent, world.materials())
    };
    let mut buffer = buffer(&header, world.materials(), Flat64Header::WORDS as usize + at.end);
    let body = &mut buffer[Flat64Header::WORDS as usize..];
    let first_leaves = fill_leaves(&parts.distinct, &sizes, &runs, body, &at);
    fill_records(&parts, &first_leaves, &runs, &free, body, &at);
    fill_octants(&extent, &mut body[at.octants..at.records]);

    let geometry_bytes = 4 * (Flat64Header::WORDS as usize + at.links - at.octants) as u64;
    Ok(Encoded { words: buffer, geometry_bytes, attribute_bytes: bytes - geometry_bytes })
}

/// The solids must lie in the window, which begins at the corner of the world's cube.
fn check_window(extent: &Extent) -> Result<(), LayoutError> {
    for (axis, limit) in WINDOW.into_iter().enumerate() {
        let span = (i64::from(extent.bounds_last[axis]) + 1 - i64::from(extent.origin[axis])).max(0).cast_unsigned();
        if span > limit {
            return Err(LayoutError::TooWide { layout: Layout::FLAT64.name(), span, limit });
        }
    }
    Ok(())
}

/// The shared leaves of full 16³ blocks: 64 full masks for each material that fills one.
struct Runs {
    materials: Vec<MaterialIndex>,
}

impl Runs {
    fn of(distinct: &[&Chunk]) -> Self {
        let mut materials: Vec<MaterialIndex> =
            (distinct.par_iter()).flat_map_iter(|chunk| (0..64).filter_map(|node| filled_node(chunk, node))).collect();
        materials.sort_unstable();
        materials.dedup();
        Self { materials }
    }

    fn leaves(&self) -> usize {
        RUN * self.materials.len()
    }

    /// Its first leaf among all leaves.
    fn first_leaf(&self, material: MaterialIndex) -> usize {
        RUN * self.materials.binary_search(&material).expect("every material that fills a block has a run")
    }
}

/// The blocks of a chunk that have leaves of their own, in order.
fn own_leaves(chunk: &Chunk) -> impl Iterator<Item = usize> + '_ {
    let own = |node: &usize| filled_node(chunk, *node).is_none();
    (0..64).filter(own).flat_map(|node| Bits(chunk.node_mask(node)).map(move |bit| 64 * node + bit as usize))
}

impl ChunkSize {
    fn of(chunk: &Chunk) -> Self {
        let mut size = Self::default();
        for block in own_leaves(chunk) {
            size.leaves += 1;
            if chunk.block_uniform(block).is_none() {
                size.attributes += Packing::of(chunk.block_materials(block)).words();
            }
        }
        size
    }
}

/// The free radii of the blocks from the corner of the world's cube to the last solids: for each of the eight octants of directions, four
/// bits. They count the 16³ blocks ahead, in all directions of the octant, that are empty too.
struct Free {
    size: [usize; 3],
    radii: Vec<u32>,
}

impl Free {
    fn of(parts: &Parts<&Chunk>, extent: &Extent) -> Self {
        let last = |axis: usize| {
            (extent.bounds_last[axis].max(extent.origin[axis]) - extent.origin[axis]).cast_unsigned() as usize >> 4
        };
        let mut blocks = Occupied::new([0, 1, 2].map(|axis| last(axis) + 1));
        for &(cell, index) in &parts.uses {
            for node in Bits(parts.distinct[index].root_mask()) {
                blocks.set(block_of(cell, node));
            }
        }
        blocks.radii()
    }
}

/// A 16³ block of a chunk, from the corner of the world's cube.
fn block_of(chunk: [u32; 3], node: u32) -> [usize; 3] {
    let child = child_cell(node);
    std::array::from_fn(|axis| (4 * chunk[axis] + child[axis]) as usize)
}

struct Occupied {
    size: [usize; 3],
    cells: Vec<bool>,
}

impl Occupied {
    fn new(size: [usize; 3]) -> Self {
        Self { size, cells: vec![false; size.iter().product()] }
    }

    fn set(&mut self, cell: [usize; 3]) {
        let at = index(self.size, cell);
        self.cells[at] = true;
    }

    fn radii(&self) -> Free {
        let of_octants: Vec<Vec<u8>> = (0..8usize).into_par_iter().map(|octant| self.of_octant(octant)).collect();
        let radii = (0..self.cells.len())
            .map(|i| (0..8).fold(0, |word, octant| word | u32::from(of_octants[octant][i]) << (4 * octant)))
            .collect();
        Free { size: self.size, radii }
    }

    /// Radii of all cells for rays that go down on the axes whose bit is set in `octant`, up elsewhere.
    fn of_octant(&self, octant: usize) -> Vec<u8> {
        // Cells on the way of a side, the cell itself counted, that are empty: one more than the radius beside it.
        let mut empty = vec![0u8; self.cells.len()];
        let mut radii = vec![0u8; self.cells.len()];
        let down = |axis: usize| octant >> axis & 1 == 1;
        let seen = |axis: usize, n: usize| if down(axis) { n } else { self.size[axis] - 1 - n };
        let strides = [1, self.size[0] * self.size[2], self.size[0]].map(usize::cast_signed);
        // To the seven cells ahead, by the axes that are moved along.
        let steps: [isize; 8] = std::array::from_fn(|step| {
            let along = (0..3).filter(|axis| step >> axis & 1 == 1);
            along.map(|axis| if down(axis) { -strides[axis] } else { strides[axis] }).sum()
        });
        for y in 0..self.size[1] {
            for z in 0..self.size[2] {
                for x in 0..self.size[0] {
                    let at = index(self.size, [seen(0, x), seen(1, y), seen(2, z)]);
                    // Texels outside are empty.
                    let outside = usize::from(x == 0) | usize::from(y == 0) << 1 | usize::from(z == 0) << 2;
                    let ahead = (1..8).filter(|step| step & outside == 0);
                    let radius = ahead.map(|step| empty[at.wrapping_add_signed(steps[step])]).min();
                    let radius = radius.unwrap_or(LARGEST_RADIUS + 1);
                    radii[at] = radius.min(LARGEST_RADIUS);
                    empty[at] = if self.cells[at] { 0 } else { (radius + 1).min(LARGEST_RADIUS + 1) };
                }
            }
        }
        radii
    }
}

fn index(size: [usize; 3], cell: [usize; 3]) -> usize {
    cell[0] + size[0] * (cell[2] + size[2] * cell[1])
}

/// Writes the leaves with their links and materials, and gives each distinct chunk's first leaf.
fn fill_leaves(distinct: &[&Chunk], sizes: &[ChunkSize], runs: &Runs, body: &mut [u32], at: &Sections) -> Vec<usize> {
    let (front, mut attributes) = body.split_at_mut(at.attributes);
    let (front, links) = front.split_at_mut(at.links);
    let masks: &mut [[u32; 2]] = bytemuck::cast_slice_mut(&mut front[at.leaves..]);
    let (run_masks, mut masks) = masks.split_at_mut(runs.leaves());
    let (run_links, mut links) = links.split_at_mut(runs.leaves());
    run_masks.fill([u32::MAX; 2]);
    for (links, material) in run_links.chunks_mut(RUN).zip(&runs.materials) {
        links.fill(UNIFORM | u32::from(*material));
    }

    let mut jobs = Vec::with_capacity(distinct.len());
    let (mut leaf, mut word) = (runs.leaves(), at.attributes);
    let mut first_leaves = Vec::with_capacity(distinct.len());
    for (chunk, size) in distinct.iter().zip(sizes) {
        let (own_masks, rest_masks) = masks.split_at_mut(size.leaves);
        let (own_links, rest_links) = links.split_at_mut(size.leaves);
        let (own_attributes, rest_attributes) = attributes.split_at_mut(size.attributes);
        (masks, links, attributes) = (rest_masks, rest_links, rest_attributes);
        jobs.push((*chunk, own_masks, own_links, own_attributes, word));
        first_leaves.push(leaf);
        leaf += size.leaves;
        word += size.attributes;
    }
    jobs.into_par_iter().for_each(|(chunk, masks, links, mut attributes, mut word)| {
        for ((block, mask), link) in own_leaves(chunk).zip(masks).zip(links) {
            *mask = [chunk.mask(block) as u32, (chunk.mask(block) >> 32) as u32];
            *link = chunk.block_uniform(block).map_or_else(
                || {
                    let packing = Packing::of(chunk.block_materials(block));
                    let (own, rest) = std::mem::take(&mut attributes).split_at_mut(packing.words());
                    packing.write(chunk.block_materials(block), own);
                    attributes = rest;
                    word += packing.words();
                    packed_link(packing.kind, word - packing.words())
                },
                |material| UNIFORM | u32::from(material),
            );
        }
    });
    first_leaves
}

/// Writes the records.
fn fill_records(
    parts: &Parts<&Chunk>,
    first_leaves: &[usize],
    runs: &Runs,
    free: &Free,
    body: &mut [u32],
    at: &Sections,
) {
    let records = &mut body[at.records..at.leaves];
    for (record, radii) in records.chunks_mut(QUAD).zip(&free.radii) {
        record[3] = *radii;
    }
    // A leaf's number is the sum of this and its rank, itself counted.
    let before = |leaf: usize| (at.leaves as u32 / 2).wrapping_add(leaf as u32).wrapping_sub(1);
    for &(cell, index_of) in &parts.uses {
        let chunk = parts.distinct[index_of];
        let mut leaf = first_leaves[index_of];
        for node in 0..64 {
            let mask = chunk.node_mask(node);
            if mask == 0 {
                continue;
            }
            let first = if let Some(material) = filled_node(chunk, node) {
                runs.first_leaf(material)
            } else {
                leaf += mask.count_ones() as usize;
                leaf - mask.count_ones() as usize
            };
            let record = QUAD * index(free.size, block_of(cell, node as u32));
            records[record..record + 3].copy_from_slice(&[mask as u32, (mask >> 32) as u32, before(first)]);
        }
    }
}

/// For each octant of directions, mirrored so that its rays go up: the number to add to the bits of a cell (mirrored ones inverted), with
/// the mirror of a packed cell; the first and the last cells of the solids.
fn fill_octants(extent: &Extent, words: &mut [u32]) {
    for (octant, words) in words.chunks_mut(3 * QUAD).enumerate() {
        for axis in 0..3 {
            let down = octant >> axis & 1 == 1;
            let (origin, side) = (extent.origin[axis], WINDOW[axis] as i32);
            let low = extent.bounds_min[axis].wrapping_sub(origin);
            let last = extent.bounds_last[axis].wrapping_sub(origin);
            let (base, near, far) = if down {
                // The inverse of a cell is -1 - cell.
                (side.wrapping_add(origin), side - 1 - last, side - 1 - low)
            } else {
                (0i32.wrapping_sub(origin), low, last)
            };
            for (part, cell) in [base, near, far].into_iter().enumerate() {
                words[QUAD * part + axis] = CELL_BITS.wrapping_add(cell.cast_unsigned());
            }
        }
        let field =
            |axis: usize, shift: u32| if octant >> axis & 1 == 1 { (WINDOW[axis] as u32 - 1) << shift } else { 0 };
        words[3] = field(0, 0) | field(2, 11) | field(1, 22);
    }
}

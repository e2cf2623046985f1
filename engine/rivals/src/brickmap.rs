//! Layout `brickmap`: see `shaders/include/raxel/rivals/internal/layouts/brickmap.glsl` for the format.

use std::collections::HashMap;

use raxel_world::World;
use raxel_world::{Bits, Chunk, block_index, child_cell};
use rayon::prelude::*;

use super::LINKED;
use raxel_layouts::parts::{Parts, child_of, octant_cell};
use raxel_layouts::{
    Encoded, Encoding, Extent, Layout, LayoutError, MATERIAL_WORDS, Table, buffer, check_size, layout_header,
};

/// Sectors of 8³ bricks with occupancy masks.
pub const LAYOUT: Layout = Layout::new(&ENCODING);

static ENCODING: Encoding =
    Encoding::new("brickmap", BrickmapHeader::block, |world, limits, _| encode(world, limits.buffer_bytes));

/// Sectors have 2^6 voxels a side, as chunks do.
const LOG2_EDGE: u32 = 6;
/// Words of a sector: for each of its eight octants a mask of its 4³ bricks (two words) and the address of its first brick.
const SECTOR_WORDS: usize = 24;
/// Words of a brick: the masks of its eight 4³ tiles, and a link to materials.
const BRICK_WORDS: usize = 17;
/// Link of a brick of one material, which is in the low half.
const SOLID_LINK: u32 = 0x8000_0000;
/// Bit of a grid cell without a sector; the low bits are the binary logarithm of the empty cube around it, in voxels.
const EMPTY_CELL: u32 = 0x8000_0000;
/// A grid may have this many cells, or as many for each sector; a world with fewer sectors than that has a hash table of them.
const GRID_CELLS: u64 = 4096;
const GRID_CELLS_A_SECTOR: u64 = 32;

layout_header! {
    /// Header of the layout `brickmap`. Addresses (`…_at`) count words from the first word behind the header.
    BrickmapHeader {
        /// Address of the grid, or of the hash table.
        table_at: u32,
        /// The hash table has 2^`log2_slots` slots; 0 if there is a grid.
        log2_slots: u32,
        /// Address of the first sector.
        sectors_at: u32,
        /// Sectors: equal ones are stored once.
        sector_count: u32,
    }
}

/// How sectors are found.
enum Directory {
    /// By place: every 64³ cell of the box around the world.
    Grid(Grid),
    /// By hash, in worlds that are mostly empty.
    Table(Table),
}

/// The words of one distinct sector in the buffer.
#[derive(Clone, Copy, Default)]
struct SectorSize {
    bricks: usize,
    /// Halfwords of materials.
    attributes: usize,
}

fn encode(world: &World, limit: u64) -> Result<Encoded, LayoutError> {
    let layout = LAYOUT;
    let extent = Extent::of(world, layout)?;
    let parts = Parts::chunks(world, &extent);
    let directory = Directory::of(&parts, &extent);
    let sizes: Vec<SectorSize> = parts.distinct.par_iter().map(|chunk| SectorSize::of(chunk)).collect();

    let table_at = MATERIAL_WORDS as usize * world.materials().len();
    let sectors_at = table_at + directory.words();
    let bricks_at = sectors_at + SECTOR_WORDS * parts.distinct.len();
    let attributes_at = bricks_at + BRICK_WORDS * sizes.iter().map(|size| size.bricks).sum::<usize>();
    let attributes: usize = sizes.iter().map(|size| size.attributes).sum();
    let words = BrickmapHeader::WORDS as usize + attributes_at + attributes.div_ceil(2);
    let bytes = check_size(layout, 4 * words as u64, limit.min(LINKED))?;

    let header = BrickmapHeader {
        table_at: table_at as u32,
        log2_slots: directory.log2_slots(),
        sectors_at: sectors_at as u32,
        sector_count: parts.distinct.len() as u32,
        ..BrickmapHeader::of(&extent, world.materials())
    };
    let mut buffer = buffer(&header, world.materials(), words);
    let body = &mut buffer[BrickmapHeader::WORDS as usize..];
    let (front, attribute_words) = body.split_at_mut(attributes_at);
    let (front, brick_words) = front.split_at_mut(bricks_at);
    let (front, sector_words) = front.split_at_mut(sectors_at);
    directory.write(&mut front[table_at..], |index| (sectors_at + SECTOR_WORDS * index as usize) as u32);
    let jobs = jobs(&parts.distinct, &sizes, sector_words, brick_words, bricks_at, attribute_words, attributes_at);
    jobs.into_par_iter().for_each(Job::run);

    let palette = 4 * u64::from(MATERIAL_WORDS) * world.materials().len() as u64;
    let links = 4 * sizes.iter().map(|size| size.bricks as u64).sum::<u64>();
    let attribute_bytes = palette + links + 4 * attributes.div_ceil(2) as u64;
    Ok(Encoded { words: buffer, geometry_bytes: bytes - attribute_bytes, attribute_bytes })
}

impl Directory {
    fn of(parts: &Parts<&Chunk>, extent: &Extent) -> Self {
        let cells = parts.uses.iter().map(|&(cell, index)| (cell, index as u32));
        match Grid::of(parts, extent) {
            Some(grid) => Self::Grid(grid),
            None => Self::Table(Table::new(cells, LOG2_EDGE, extent.log2_size)),
        }
    }

    fn words(&self) -> usize {
        match self {
            Self::Grid(grid) => grid.size.iter().map(|size| *size as usize).product(),
            Self::Table(table) => table.words(),
        }
    }

    fn log2_slots(&self) -> u32 {
        match self {
            Self::Grid(_) => 0,
            Self::Table(table) => table.log2_slots(),
        }
    }

    fn write(&self, words: &mut [u32], address: impl Fn(u32) -> u32 + Sync) {
        match self {
            Self::Grid(grid) => grid.write(words, address),
            Self::Table(table) => table.write(words, LOG2_EDGE, address),
        }
    }
}

/// A dense grid of sectors over the box of the world's solids.
struct Grid {
    /// Its smallest cell, from the corner of the world's cube.
    first: [u32; 3],
    size: [u32; 3],
    sectors: HashMap<[u32; 3], u32>,
    log2_size: u32,
}

impl Grid {
    /// None if it had far more cells than there are sectors.
    fn of(parts: &Parts<&Chunk>, extent: &Extent) -> Option<Self> {
        let cell = |corner: [i32; 3]| -> [u32; 3] {
            std::array::from_fn(|i| corner[i].wrapping_sub(extent.origin[i]).cast_unsigned() >> LOG2_EDGE)
        };
        let empty = parts.uses.is_empty();
        let first = cell(extent.bounds_min);
        let last = if empty { first } else { cell(extent.bounds_last) };
        let size: [u32; 3] = std::array::from_fn(|i| last[i] - first[i] + 1);
        // At most 2^24 cells along an axis.
        let cells = size.iter().fold(1u64, |cells, size| cells.saturating_mul(u64::from(*size)));
        if cells > GRID_CELLS.max(GRID_CELLS_A_SECTOR * parts.uses.len() as u64) {
            return None;
        }
        let sectors = parts.uses.iter().map(|&(cell, index)| (cell, index as u32)).collect();
        Some(Self { first, size, sectors, log2_size: extent.log2_size })
    }

    fn write(&self, words: &mut [u32], address: impl Fn(u32) -> u32 + Sync) {
        // Occupied cubes of 2, 4, 8, … sectors a side, up to the whole.
        let mut occupied = vec![self.sectors.keys().copied().collect::<std::collections::HashSet<[u32; 3]>>()];
        for _ in LOG2_EDGE + 1..self.log2_size {
            let below = &occupied[occupied.len() - 1];
            occupied.push(below.iter().map(|cell| cell.map(|c| c >> 1)).collect());
        }
        let [width, height, _] = self.size.map(|size| size as usize);
        words.par_iter_mut().enumerate().for_each(|(i, word)| {
            let local = [i % width, i / width % height, i / width / height];
            let cell: [u32; 3] = std::array::from_fn(|a| self.first[a] + local[a] as u32);
            *word = self.sectors.get(&cell).map_or_else(
                || {
                    let free = (0..occupied.len()).take_while(|&k| !occupied[k].contains(&cell.map(|c| c >> k)));
                    EMPTY_CELL | (LOG2_EDGE + free.count().saturating_sub(1) as u32)
                },
                |&index| address(index),
            );
        });
    }
}

/// Blocks of a brick, as (tile, block of the chunk). Octants and tiles are numbered like octree children.
fn tiles(octant: u32, brick: u32) -> impl Iterator<Item = (usize, usize)> {
    let (octant, brick) = (octant_cell(octant), child_cell(brick));
    let brick = std::array::from_fn(|i| octant[i] << 2 | brick[i]);
    (0..8).map(move |tile| {
        let [x, y, z] = child_of(brick, tile);
        (tile as usize, block_index(x, y, z))
    })
}

/// Bricks with solids of one octant of a chunk.
fn brick_mask(chunk: &Chunk, octant: u32) -> u64 {
    (0..64)
        .filter(|&brick| tiles(octant, brick).any(|(_, block)| chunk.mask(block) != 0))
        .fold(0, |mask, brick| mask | 1 << brick)
}

/// The only material of a brick with solids, if there is only one.
fn uniform_brick(chunk: &Chunk, octant: u32, brick: u32) -> Option<u16> {
    let mut found = None;
    for (_, block) in tiles(octant, brick).filter(|(_, block)| chunk.mask(*block) != 0) {
        let material = chunk.block_uniform(block)?;
        if *found.get_or_insert(material) != material {
            return None;
        }
    }
    found
}

impl SectorSize {
    fn of(chunk: &Chunk) -> Self {
        let mut size = Self::default();
        for octant in 0..8 {
            let mask = brick_mask(chunk, octant);
            size.bricks += mask.count_ones() as usize;
            for brick in Bits(mask).filter(|&brick| uniform_brick(chunk, octant, brick).is_none()) {
                let solids = tiles(octant, brick).map(|(_, block)| chunk.mask(block).count_ones() as usize);
                size.attributes += solids.sum::<usize>();
            }
        }
        size
    }
}

/// A sector to be written, with its parts of the buffer and their addresses.
struct Job<'a> {
    chunk: &'a Chunk,
    sector: &'a mut [u32],
    bricks: &'a mut [u32],
    bricks_at: usize,
    attributes: &'a mut [u16],
    /// In halfwords.
    attributes_at: usize,
}

fn jobs<'a>(
    chunks: &[&'a Chunk],
    sizes: &[SectorSize],
    sectors: &'a mut [u32],
    mut bricks: &'a mut [u32],
    mut bricks_at: usize,
    attribute_words: &'a mut [u32],
    attributes_at: usize,
) -> Vec<Job<'a>> {
    let mut halfwords: &mut [u16] = bytemuck::cast_slice_mut(attribute_words);
    let mut halfwords_at = 2 * attributes_at;
    let mut jobs = Vec::with_capacity(chunks.len());
    for ((chunk, size), sector) in chunks.iter().zip(sizes).zip(sectors.chunks_exact_mut(SECTOR_WORDS)) {
        let (own_bricks, rest) = bricks.split_at_mut(BRICK_WORDS * size.bricks);
        bricks = rest;
        let (attributes, rest) = halfwords.split_at_mut(size.attributes);
        halfwords = rest;
        jobs.push(Job { chunk, sector, bricks: own_bricks, bricks_at, attributes, attributes_at: halfwords_at });
        bricks_at += BRICK_WORDS * size.bricks;
        halfwords_at += size.attributes;
    }
    jobs
}

impl Job<'_> {
    fn run(self) {
        let (mut next_brick, mut next_attribute) = (0, 0);
        for octant in 0..8 {
            let mask = brick_mask(self.chunk, octant);
            let words = &mut self.sector[3 * octant as usize..][..3];
            words.copy_from_slice(&[mask as u32, (mask >> 32) as u32, (self.bricks_at + next_brick) as u32]);
            for brick in Bits(mask) {
                let words = &mut self.bricks[next_brick..][..BRICK_WORDS];
                next_brick += BRICK_WORDS;
                let uniform = uniform_brick(self.chunk, octant, brick);
                words[16] = uniform.map_or((self.attributes_at + next_attribute) as u32, |m| SOLID_LINK | u32::from(m));
                for (tile, block) in tiles(octant, brick) {
                    let mask = self.chunk.mask(block);
                    words[2 * tile] = mask as u32;
                    words[2 * tile + 1] = (mask >> 32) as u32;
                    if uniform.is_none() {
                        for material in self.chunk.block_materials(block) {
                            self.attributes[next_attribute] = material;
                            next_attribute += 1;
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raxel_world::child_index;

    #[test]
    fn tiles_of_all_bricks_are_the_blocks_of_a_chunk() {
        let mut seen: Vec<usize> = (0..512).flat_map(|i| tiles(i / 64, i % 64).map(|(_, block)| block)).collect();
        assert_eq!(seen[0], block_index(0, 0, 0));
        assert_eq!(seen[8 * child_index(1, 0, 0) as usize + 1], block_index(3, 0, 0));
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..4096));
    }
}

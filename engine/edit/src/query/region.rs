//! The materials in a box.

use std::collections::BTreeMap;

use raxel_generate::{Box3, Shape};
use raxel_world::{AIR, Bits, Bounds, ChunkPos, MaterialIndex, Unavailable, block_cell};
use rayon::prelude::*;

use crate::operation::{EditError, MOST_CHUNKS};
use crate::scene::Base;

/// Voxels of each material of a box; air is counted too.
pub type Histogram = BTreeMap<MaterialIndex, u64>;

/// Counts the voxels of a box by material.
///
/// # Errors
/// When it is empty, leaves the range of coordinates, reaches over more chunks than an edit may, or touches a chunk that is unavailable.
pub fn histogram(base: &dyn Base, bounds: &Bounds) -> Result<Histogram, EditError> {
    if (0..3).any(|i| bounds.min[i] >= bounds.max[i]) {
        let what = format!("its box goes from {:?} to {:?}", bounds.min, bounds.max);
        return Err(EditError::Empty { what });
    }
    if (0..3).any(|i| bounds.min[i] < -(1 << 31) || bounds.max[i] > 1 << 31) {
        return Err(EditError::OutOfRange { min: bounds.min, max: bounds.max });
    }
    let [xs, ys, zs] = bounds.chunk_ranges();
    let chunks = bounds.chunk_count();
    if chunks > u128::from(MOST_CHUNKS) {
        return Err(EditError::TooLarge { chunks, limit: MOST_CHUNKS });
    }
    let columns: Vec<(i64, i64)> = ys.flat_map(|y| zs.clone().map(move |z| (y, z))).collect();
    let of_column = |(y, z): (i64, i64)| {
        let mut counts = Histogram::new();
        for x in xs.clone() {
            count(base, bounds, ChunkPos::of_range([x, y, z]), &mut counts)?;
        }
        Ok::<_, Unavailable>(counts)
    };
    let sum = |mut all: Histogram, counts: Histogram| {
        counts.into_iter().for_each(|(material, count)| *all.entry(material).or_default() += count);
        Ok(all)
    };
    let mut counts = columns.into_par_iter().map(of_column).try_reduce(Histogram::new, sum)?;
    let volume: u64 = bounds.size().iter().product();
    let solid: u64 = counts.values().sum();
    if volume > solid {
        counts.insert(AIR, volume - solid);
    }
    Ok(counts)
}

/// Adds the solid voxels of the part of a box inside a chunk.
fn count(base: &dyn Base, bounds: &Bounds, pos: ChunkPos, counts: &mut Histogram) -> Result<(), Unavailable> {
    let Some(chunk) = base.try_chunk(pos)? else { return Ok(()) };
    let whole = bounds.contains_chunk(pos);
    if let (true, Some(material)) = (whole, chunk.uniform()) {
        *counts.entry(material).or_default() += u64::from(chunk.solids());
        return Ok(());
    }
    let shape = Box3 { bounds: *bounds, shell: None };
    let origin = pos.origin().to_array().map(i64::from);
    for (block, &mask) in chunk.masks().iter().enumerate().filter(|(_, mask)| **mask != 0) {
        let cell = block_cell(block).map(i64::from);
        let covered = if whole { u64::MAX } else { shape.mask(std::array::from_fn(|i| origin[i] + 4 * cell[i])) };
        for (bit, material) in Bits(mask).zip(chunk.block_materials(block)) {
            if covered >> bit & 1 == 1 {
                *counts.entry(material).or_default() += 1;
            }
        }
    }
    Ok(())
}

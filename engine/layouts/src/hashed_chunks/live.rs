//! 32³ chunks in a hash table, in a buffer with blocks to spare: an edit writes the 4³ parts of chunks that it changed, and the slots of
//! chunks that come, go or become others.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use raxel_world::Chunk;
use raxel_world::{ChunkPos, World};
use rayon::prelude::*;

use super::{Form, HashedChunksHeader, LOG2_EDGE};
use crate::header::{Extent, MATERIAL_WORDS, buffer};
use crate::live::{Patch, roomy};
use crate::parts::{Octant, child_of};
use crate::table::{LiveTable, Table};
use crate::{ADDRESSABLE, LayoutError, check_size};

/// Spare blocks besides a quarter of the world's.
const ROOM: usize = 64;

/// A world in a buffer of 32³ chunks that follows edits.
pub struct LiveHashedChunks {
    form: &'static Form,
    extent: Extent,
    materials: usize,
    table: LiveTable,
    /// The contents of each block of the buffer.
    blocks: Vec<Option<Held>>,
    /// Blocks without a use.
    free: Vec<usize>,
    /// Blocks by their contents.
    known: HashMap<(usize, u32), usize>,
    /// The block of each 32³ chunk with solids, by its cell.
    places: HashMap<[u32; 3], usize>,
}

/// An octant in a block. It holds the chunk, so that no other one comes to lie at its address.
struct Held {
    chunk: Arc<Chunk>,
    number: u32,
    uses: usize,
}

impl Held {
    fn octant(&self) -> Octant<'_> {
        Octant { chunk: &self.chunk, number: self.number }
    }

    fn key(&self) -> (usize, u32) {
        (Arc::as_ptr(&self.chunk) as usize, self.number)
    }
}

/// The changes of an edit to blocks.
#[derive(Default)]
struct Changed {
    /// Those that are written as a whole.
    filled: BTreeSet<usize>,
    /// The partly written chunks: their words, counted from the first block of all.
    parts: BTreeMap<usize, Vec<Patch>>,
}

impl LiveHashedChunks {
    /// Puts a world into a buffer, whose words are given as well.
    pub(crate) fn new(form: &'static Form, world: &World, limit: u64) -> Result<(Self, Vec<u32>), LayoutError> {
        let extent = roomy(world, form.layout)?;
        let octants = || {
            world.chunks().flat_map(|(pos, chunk)| {
                (0..8).map(move |number| (pos, Octant { chunk, number })).filter(|(_, octant)| octant.is_solid())
            })
        };
        let distinct = octants().map(|(_, of)| (std::ptr::from_ref(of.chunk), of.number)).collect::<HashSet<_>>().len();
        let cells = octants().map(|(pos, of)| (child_of(cell_of(pos, &extent), of.number), 0));
        let table = LiveTable::with_room(&Table::new(cells, LOG2_EDGE, extent.log2_size), LOG2_EDGE, extent.log2_size);

        let words = |blocks: usize| {
            let front = HashedChunksHeader::WORDS as usize + MATERIAL_WORDS as usize * world.materials().len();
            (front + table.words() + form.chunk_words * blocks) as u64
        };
        let limit = limit.min(ADDRESSABLE);
        check_size(form.layout, 4 * words(distinct), limit)?;
        let room = ((limit / 4 - words(distinct)) / form.chunk_words as u64).min((distinct / 4 + ROOM) as u64);
        let blocks = distinct + room as usize;
        let words = words(blocks) as usize;
        let mut live = Self {
            form,
            extent,
            materials: world.materials().len(),
            table,
            blocks: std::iter::repeat_with(|| None).take(blocks).collect(),
            free: (0..blocks).rev().collect(),
            known: HashMap::new(),
            places: HashMap::new(),
        };
        let changed = live.change(world.chunks().map(|(pos, chunk)| (pos, Some(chunk.clone()))));
        let changed = changed.expect("there are as many blocks and slots as the world needs, and more");
        let mut words = buffer(&live.header(world), world.materials(), words);
        let chunks_at = live.chunks_at();
        for slots in live.take_slots() {
            words[slots.at..][..slots.words.len()].copy_from_slice(&slots.words);
        }
        let mut filled: Vec<Option<Octant>> = vec![None; blocks];
        for &block in &changed.filled {
            filled[block] = live.blocks[block].as_ref().map(Held::octant);
        }
        let of_blocks = words[chunks_at..].par_chunks_exact_mut(form.chunk_words);
        of_blocks.zip(filled).for_each(|(words, octant)| {
            if let Some(octant) = octant {
                (form.fill)(&octant, words);
            }
        });
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
        let Changed { filled, parts } = self.change(changes)?;
        let chunks_at = self.chunks_at();
        let parts = parts.into_values().flatten();
        let mut patches: Vec<Patch> = parts.map(|patch| Patch { at: chunks_at + patch.at, ..patch }).collect();
        let words = self.form.chunk_words;
        let fill = |&block: &usize| {
            let mut patch = Patch { at: chunks_at + words * block, words: vec![0; words] };
            (self.form.fill)(&self.blocks[block].as_ref()?.octant(), &mut patch.words);
            Some(patch)
        };
        patches.extend(filled.par_iter().filter_map(fill).collect::<Vec<_>>());
        patches.extend(self.take_slots());
        let header = self.header(world);
        patches.push(Patch { at: 0, words: bytemuck::cast_slice(std::slice::from_ref(&header)).to_vec() });
        Some(patches)
    }

    fn change(&mut self, changes: impl IntoIterator<Item = (ChunkPos, Option<Arc<Chunk>>)>) -> Option<Changed> {
        let mut changed = Changed::default();
        // A released block is written again only by a later change, so that no two patches overlap.
        let mut released = Vec::new();
        for (pos, chunk) in changes {
            if !self.extent.holds(pos) {
                if chunk.is_some() {
                    return None;
                }
                continue;
            }
            let corner = cell_of(pos, &self.extent);
            for number in 0..8 {
                let cell = child_of(corner, number);
                let there = chunk.as_ref().filter(|chunk| Octant { chunk, number }.is_solid());
                if let Some(chunk) = there {
                    self.put(cell, chunk, number, &mut changed, &mut released)?;
                } else if let Some(before) = self.places.remove(&cell) {
                    self.table.remove(cell);
                    released.extend(self.release(before));
                }
            }
        }
        // One that was filled and given up again holds nothing.
        changed.filled.retain(|block| self.blocks[*block].is_some());
        self.free.append(&mut released);
        Some(changed)
    }

    /// Puts an octant with solids into a cell. `None` when there is no room.
    fn put(
        &mut self,
        cell: [u32; 3],
        chunk: &Arc<Chunk>,
        number: u32,
        changed: &mut Changed,
        released: &mut Vec<usize>,
    ) -> Option<()> {
        let next = Held { chunk: chunk.clone(), number, uses: 1 };
        let before = self.places.get(&cell).copied();
        let alone = |block: &usize| self.blocks[*block].as_ref().is_some_and(|held| held.uses == 1);
        let block = if let Some(&known) = self.known.get(&next.key()) {
            if before == Some(known) {
                return Some(());
            }
            self.blocks[known].as_mut()?.uses += 1;
            known
        } else if let Some(own) = before.filter(alone) {
            self.rewrite(own, next, changed)?;
            return Some(());
        } else {
            let block = self.free.pop()?;
            self.known.insert(next.key(), block);
            self.blocks[block] = Some(next);
            changed.filled.insert(block);
            block
        };
        if let Some(before) = before {
            released.extend(self.release(before));
        }
        self.places.insert(cell, block);
        let address = self.chunks_at() + self.form.chunk_words * block - HashedChunksHeader::WORDS as usize;
        self.table.insert(cell, address as u32)
    }

    /// Makes a block that is used once hold another octant, by its differences.
    fn rewrite(&mut self, block: usize, next: Held, changed: &mut Changed) -> Option<()> {
        let held = self.blocks[block].as_mut()?;
        let different = held.octant().different_blocks(&next.octant());
        // Parts that an earlier change of the same edit wrote would overlap with these.
        let again = changed.parts.remove(&block).is_some();
        if again || different.len() > self.form.most_parts || changed.filled.contains(&block) {
            changed.filled.insert(block);
        } else {
            let patches = (self.form.rewrite)(&next.octant(), &different);
            let at = self.form.chunk_words * block;
            let patches = patches.into_iter().map(|patch| Patch { at: at + patch.at, ..patch });
            changed.parts.insert(block, patches.collect());
        }
        self.known.remove(&held.key());
        self.known.insert(next.key(), block);
        *held = next;
        Some(())
    }

    /// Gives up one use of a block; the block, if that was the last.
    fn release(&mut self, block: usize) -> Option<usize> {
        let held = self.blocks[block].as_mut()?;
        held.uses -= 1;
        if held.uses > 0 {
            return None;
        }
        self.known.remove(&held.key());
        self.blocks[block] = None;
        Some(block)
    }

    /// The slots of the table that were written since the last call.
    fn take_slots(&mut self) -> impl Iterator<Item = Patch> + use<> {
        let table_at = self.table_at();
        self.table.take_changes().into_iter().map(move |patch| Patch { at: table_at + patch.at, ..patch })
    }

    /// Index of the first word of the table in the buffer.
    fn table_at(&self) -> usize {
        HashedChunksHeader::WORDS as usize + MATERIAL_WORDS as usize * self.materials
    }

    /// Index of the first word of the first block in the buffer.
    fn chunks_at(&self) -> usize {
        self.table_at() + self.table.words()
    }

    fn header(&self, world: &World) -> HashedChunksHeader {
        let base = HashedChunksHeader::WORDS as usize;
        HashedChunksHeader {
            table_at: (self.table_at() - base) as u32,
            log2_slots: self.table.log2_slots(),
            chunks_at: (self.chunks_at() - base) as u32,
            chunk_count: self.known.len() as u32,
            ..HashedChunksHeader::of(&self.extent.with_bounds_of(world), world.materials())
        }
    }
}

impl std::fmt::Debug for LiveHashedChunks {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "LiveHashedChunks({:?}, {} chunks, {} blocks)",
            self.form.layout,
            self.places.len(),
            self.blocks.len()
        )
    }
}

/// The cell of a chunk in the cube, in chunks.
fn cell_of(pos: ChunkPos, extent: &Extent) -> [u32; 3] {
    let pos = [pos.x, pos.y, pos.z];
    std::array::from_fn(|i| (pos[i] - (extent.origin[i] >> 6)).cast_unsigned())
}

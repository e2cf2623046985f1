//! Stores equal packed materials once. A leaf finds its materials by their address, so rays are not affected: over a terrain this saves
//! half of their memory. It packs a whole world, or each chunk of a streamed world by itself. In a buffer that is edited in place, each
//! leaf has its own room.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use raxel_world::Chunk;
use rayon::prelude::*;

use super::super::packed::Packing;
use super::{ChunkSize, packed_link};

/// The packed materials of all chunks of a world.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct SharedMaterials {
    /// The link of each leaf of several materials, by chunk, in the order of the leaves.
    pub(in super::super) links: Vec<Vec<u32>>,
    /// Their targets: the packed materials, each once, in the order in which they are first met.
    pub(in super::super) words: Vec<u32>,
}

/// The packed materials of one chunk.
#[derive(Default)]
struct PackedChunk {
    size: ChunkSize,
    words: Vec<u32>,
    leaves: Vec<PackedLeaf>,
}

struct PackedLeaf {
    hash: u64,
    kind: u32,
    words: u32,
}

impl SharedMaterials {
    /// Packs the materials of chunks, and counts their other words.
    pub(super) fn of(chunks: &[&Chunk]) -> (Vec<ChunkSize>, Self) {
        let packed: Vec<PackedChunk> = chunks.par_iter().map(|chunk| PackedChunk::of(chunk, false)).collect();
        (packed.iter().map(|chunk| chunk.size).collect(), Self::share(&packed))
    }

    /// The same of a single chunk, beside which there is a run of full leaves. Its size has the room for them.
    pub(in super::super) fn of_tile(chunk: &Chunk) -> (ChunkSize, Self) {
        let packed = PackedChunk::of(chunk, true);
        let shared = Self::share(std::slice::from_ref(&packed));
        (ChunkSize { attributes: shared.words.len(), ..packed.size }, shared)
    }

    /// The packed materials of some blocks of a chunk.
    pub(in super::super) fn of_blocks(chunk: &Chunk, blocks: impl Iterator<Item = usize>) -> Self {
        let mut packed = PackedChunk::default();
        blocks.for_each(|block| packed.push(chunk, block));
        Self::share(std::slice::from_ref(&packed))
    }

    fn share(packed: &[PackedChunk]) -> Self {
        let mut shared = Self { links: Vec::with_capacity(packed.len()), words: Vec::new() };
        // By hash, or by the next number when another content has that: its place and its kind.
        let mut known: HashMap<u64, (usize, u32), BuildHasherDefault<AsItIs>> = HashMap::default();
        for chunk in packed {
            let mut rest = &chunk.words[..];
            let link = |leaf: &PackedLeaf| {
                let (words, behind) = rest.split_at(leaf.words as usize);
                rest = behind;
                let mut key = leaf.hash;
                loop {
                    match known.get(&key) {
                        None => break,
                        Some(&(at, kind)) if kind == leaf.kind && shared.words[at..].starts_with(words) => {
                            return (kind, at);
                        }
                        Some(_) => key = key.wrapping_add(1),
                    }
                }
                let at = shared.words.len();
                shared.words.extend_from_slice(words);
                known.insert(key, (at, leaf.kind));
                (leaf.kind, at)
            };
            shared.links.push(chunk.leaves.iter().map(link).map(|(kind, at)| packed_link(kind, at)).collect());
        }
        shared
    }

    /// Puts the first word at an address, which is 0 before.
    pub(in super::super) fn begin_at(&mut self, address: usize) {
        self.links.iter_mut().flatten().for_each(|link| *link += address as u32);
    }
}

impl PackedChunk {
    fn of(chunk: &Chunk, full_run: bool) -> Self {
        let mut packed = Self::default();
        packed.size = ChunkSize::visit(chunk, full_run, |block| packed.push(chunk, block));
        packed
    }

    fn push(&mut self, chunk: &Chunk, block: usize) {
        let packing = Packing::of(chunk.block_materials(block));
        let at = self.words.len();
        self.words.resize(at + packing.words(), 0);
        packing.write(chunk.block_materials(block), &mut self.words[at..]);
        let hash = hash(packing.kind, &self.words[at..]);
        self.leaves.push(PackedLeaf { hash, kind: packing.kind, words: packing.words() as u32 });
    }
}

/// The words of voxels that are the content, and nothing of an attacker's: any mixing of all bits will do (the finaliser of `MurmurHash3`).
fn hash(kind: u32, words: &[u32]) -> u64 {
    let mix = |hash: u64, word: u32| {
        let x = (hash ^ u64::from(word)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        x ^ x >> 33
    };
    words.iter().fold(mix(words.len() as u64, kind), |hash, word| mix(hash, *word)).wrapping_mul(0xc4ce_b9fe_1a85_ec53)
}

/// Keys that are hashes already.
#[derive(Default)]
struct AsItIs(u64);

impl Hasher for AsItIs {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = self.0 << 8 ^ u64::from(*byte);
        }
    }

    fn write_u64(&mut self, key: u64) {
        self.0 = key;
    }
}

#[cfg(test)]
mod tests {
    use glam::IVec3;

    use super::*;
    use raxel_world::{Material, World};

    #[test]
    fn equal_materials_are_packed_once_whatever_their_chunk_and_shape() {
        let palette = vec![Material::air(), Material::matt("a", [0.1; 3]), Material::matt("b", [0.2; 3])];
        // In each of five chunks a block of 32 voxels, the lower or the upper half, and a voxel elsewhere, so that no two chunks are equal.
        let block = |chunk: i32| {
            let solid = move |i: i32| IVec3::new(64 * chunk + i % 4, i / 16 + 2 * (chunk % 2), i / 4 % 4);
            (0..32).map(move |i| (solid(i), 1 + (i % 2) as u16)).chain([(IVec3::new(64 * chunk + 32, chunk, 0), 1)])
        };
        let world = World::from_voxels(palette, (0..5).flat_map(block));
        let chunks: Vec<&Chunk> = world.chunks().map(|(_, chunk)| &**chunk).collect();
        let (sizes, mut shared) = SharedMaterials::of(&chunks);
        assert_eq!(sizes.iter().map(|size| (size.links, size.attributes)).collect::<Vec<_>>(), [(1, 0); 5]);
        assert_eq!(shared.words, [1 | 2 << 16, 0xaaaa_aaaa]);
        shared.begin_at(100);
        assert_eq!(shared.links, vec![vec![packed_link(0, 100)]; 5]);
    }

    #[test]
    fn contents_of_one_hash_are_told_apart() {
        let leaf = |kind| PackedLeaf { hash: 7, kind, words: 2 };
        let chunk = |kind, words: [u32; 2]| PackedChunk {
            size: ChunkSize::default(),
            words: words.into(),
            leaves: vec![leaf(kind)],
        };
        let shared = SharedMaterials::share(&[
            chunk(0, [1, 2]),
            chunk(0, [3, 4]),
            chunk(1, [1, 2]),
            chunk(0, [3, 4]),
            chunk(0, [1, 2]),
        ]);
        assert_eq!(shared.words, [1, 2, 3, 4, 1, 2]);
        assert_eq!(
            shared.links.concat(),
            [(0, 0), (0, 2), (1, 4), (0, 2), (0, 0)].map(|(kind, at)| packed_link(kind, at))
        );
    }
}

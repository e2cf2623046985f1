//! Tells the shards of one world and place from all others.

use crate::metadata::Baked;
use crate::plan::ShardKey;

/// Bytes of a seal.
pub(crate) const SEAL: usize = 16;

/// A hash of everything that the voxels of a shard follow from. Checksums find changed bytes. This hash finds a shard that was moved, or
/// that belongs to another world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Seal(pub(crate) [u8; SEAL]);

/// Makes the seals of one world.
pub(crate) struct Seals {
    world: blake3::Hasher,
    edge: i64,
    origins: Vec<[i64; 3]>,
}

impl Seals {
    pub(crate) fn of(baked: &Baked) -> Self {
        let mut world = blake3::Hasher::new();
        // A cell is the index of a material. The looks of a material change no voxel.
        let names = baked.materials.iter().map(|material| &material.name);
        for text in std::iter::once(&baked.fingerprint).chain(names) {
            world.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
        }
        world.update(&baked.edge.to_le_bytes());
        let origins = baked.levels.iter().map(|level| level.origin).collect();
        Self { world, edge: i64::from(baked.edge), origins }
    }

    /// The place counts from the world's origin, so a shard is the same in every region.
    pub(crate) fn of_shard(&self, key: ShardKey) -> Seal {
        let mut hasher = self.world.clone();
        hasher.update(&key.level.to_le_bytes());
        for (origin, at) in self.origins[key.level as usize].into_iter().zip(key.at) {
            hasher.update(&(origin + i64::from(at) * self.edge).to_le_bytes());
        }
        let hash = hasher.finalize();
        Seal(std::array::from_fn(|byte| hash.as_bytes()[byte]))
    }
}

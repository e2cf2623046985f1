//! The plan of a bake: its tiles, their arrays, and the shards of each array.

use raxel_world::{Bounds, MAX_LEVEL, Material, cell_edge};

/// Cells along an edge of a shard, by default.
pub const DEFAULT_EDGE: u32 = 512;
/// Most cells along an edge of a shard: the index of the 64³ chunks of the largest takes 4 MiB.
pub(crate) const MOST_EDGE: u32 = 4096;
/// Cells along an edge of a chunk.
pub(crate) const CHUNK: u32 = 64;
/// The largest distance of a voxel from the origin.
const RANGE: i64 = 1 << 31;
/// Most shards of a level: a task looks at the numbers of all of them.
const MOST_SHARDS: u64 = 1 << 32;

/// Arrays of one world: one a level of detail. Every shard lies at a multiple of its size from the world's origin, so the region does not
/// change its contents.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub(crate) name: String,
    pub(crate) fingerprint: String,
    pub(crate) materials: Vec<Material>,
    pub(crate) edge: u32,
    levels: Vec<BakedLevel>,
}

/// The array of a level of detail, of cells of 4^level voxels a side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BakedLevel {
    /// 0 for single voxels.
    pub level: u32,
    /// The shard at the smallest corner, in shards of this level from the origin of the world: x, y, z.
    pub first: [i32; 3],
    /// Shards along x, y, z.
    pub shards: [u32; 3],
}

/// One shard: an object of the store.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShardKey {
    /// Of which level.
    pub level: u32,
    /// Which of the shards of its array: x, y, z, from 0.
    pub at: [u32; 3],
}

/// Why something cannot be baked.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// It holds no voxel.
    #[error("the region from {min:?} to {max:?} is empty")]
    Empty {
        /// Its smallest voxel.
        min: [i64; 3],
        /// One past its largest.
        max: [i64; 3],
    },
    /// It reaches beyond where voxels are.
    #[error("the region from {min:?} to {max:?} reaches further than 2^31 voxels from the origin")]
    Range {
        /// Its smallest voxel.
        min: [i64; 3],
        /// One past its largest.
        max: [i64; 3],
    },
    /// A size that shards cannot have.
    #[error("shards of {edge} cells a side: it must be a multiple of {CHUNK}, and at most {MOST_EDGE}")]
    Edge {
        /// Cells along an edge.
        edge: u32,
    },
    /// A level of detail that worlds do not have.
    #[error("{levels} levels of detail: there are 1 to {}", MAX_LEVEL + 1)]
    Levels {
        /// How many were asked for.
        levels: u32,
    },
    /// It would take too many shards.
    #[error("the region takes {shards} shards; at most {MOST_SHARDS} are baked at a time")]
    TooLarge {
        /// How many.
        shards: u128,
    },
}

impl Plan {
    /// Plans `levels` levels of detail of a region, which is rounded outwards to whole shards of `edge` cells a side. The fingerprint identifies the
    /// world: two worlds with the same one have the same voxels.
    pub fn new(
        name: &str,
        fingerprint: &str,
        materials: Vec<Material>,
        region: Bounds,
        edge: u32,
        levels: u32,
    ) -> Result<Self, PlanError> {
        let Bounds { min, max } = region;
        if (0..3).any(|axis| min[axis] >= max[axis]) {
            return Err(PlanError::Empty { min, max });
        }
        if min.iter().any(|c| *c < -RANGE) || max.iter().any(|c| *c > RANGE) {
            return Err(PlanError::Range { min, max });
        }
        if edge == 0 || edge > MOST_EDGE || !edge.is_multiple_of(CHUNK) {
            return Err(PlanError::Edge { edge });
        }
        if levels == 0 || levels > MAX_LEVEL + 1 {
            return Err(PlanError::Levels { levels });
        }
        let levels: Vec<BakedLevel> = (0..levels).map(|level| BakedLevel::around(level, &region, edge)).collect();
        let shards = levels[0].shards.iter().map(|count| u128::from(*count)).product();
        if shards > u128::from(MOST_SHARDS) {
            return Err(PlanError::TooLarge { shards });
        }
        Ok(Self { name: name.to_owned(), fingerprint: fingerprint.to_owned(), materials, edge, levels })
    }

    /// Its levels, level 0 first.
    pub fn levels(&self) -> &[BakedLevel] {
        &self.levels
    }

    /// Cells along an edge of a shard.
    pub fn edge(&self) -> u32 {
        self.edge
    }

    /// The box of voxels that the shards of level 0 fill.
    pub fn region(&self) -> Bounds {
        let level = &self.levels[0];
        let edge = i64::from(self.edge);
        let min = level.first.map(|c| i64::from(c) * edge);
        Bounds { min, max: std::array::from_fn(|axis| min[axis] + i64::from(level.shards[axis]) * edge) }
    }
}

impl BakedLevel {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a plan's region is within ±2³¹ voxels, and a shard has at least 64 along an edge"
    )]
    fn around(level: u32, region: &Bounds, edge: u32) -> Self {
        let size = i64::from(edge) * cell_edge(level);
        let first = region.min.map(|c| c.div_euclid(size));
        let end = region.max.map(|c| -(-c).div_euclid(size));
        Self {
            level,
            first: first.map(|c| c as i32),
            shards: std::array::from_fn(|axis| (end[axis] - first[axis]) as u32),
        }
    }

    /// How many shards it has.
    pub fn count(&self) -> u64 {
        self.shards.iter().map(|count| u64::from(*count)).product()
    }

    /// The cell at the smallest corner, in cells of this level from the origin of the world: x, y, z.
    pub fn origin(&self, edge: u32) -> [i64; 3] {
        self.first.map(|c| i64::from(c) * i64::from(edge))
    }
}

impl ShardKey {
    /// The name of its object.
    pub fn object(&self) -> String {
        let [x, y, z] = self.at;
        format!("{}/c/{z}/{y}/{x}", self.level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_grow_to_whole_shards() {
        let region = Bounds { min: [-1, 0, 600], max: [1, 64, 700] };
        let plan = Plan::new("test", "0", Vec::new(), region, 128, 2).unwrap();
        assert_eq!(plan.region(), Bounds { min: [-128, 0, 512], max: [128, 128, 768] });
        assert_eq!(plan.levels()[1], BakedLevel { level: 1, first: [-1, 0, 1], shards: [2, 1, 1] });
        assert_eq!(plan.levels()[1].origin(128), [-128, 0, 128]);
        assert_eq!(ShardKey { level: 1, at: [3, 2, 1] }.object(), "1/c/1/2/3");
    }

    #[test]
    fn plans_that_cannot_be_are_refused() {
        let whole = Bounds { min: [0; 3], max: [64; 3] };
        let plan = |region, edge, levels| Plan::new("test", "0", Vec::new(), region, edge, levels);
        assert!(matches!(plan(Bounds { min: [0; 3], max: [1, 1, 0] }, 64, 1), Err(PlanError::Empty { .. })));
        assert!(matches!(plan(Bounds { min: [0; 3], max: [i64::MAX; 3] }, 64, 1), Err(PlanError::Range { .. })));
        for edge in [0, 1, 100, 8192] {
            assert!(matches!(plan(whole, edge, 1), Err(PlanError::Edge { .. })), "{edge}");
        }
        assert!(matches!(plan(whole, 64, 0), Err(PlanError::Levels { .. })));
        assert!(matches!(plan(whole, 64, 5), Err(PlanError::Levels { .. })));
        let all = Bounds { min: [-RANGE; 3], max: [RANGE; 3] };
        assert!(matches!(plan(all, 512, 1), Err(PlanError::TooLarge { .. })));
    }
}

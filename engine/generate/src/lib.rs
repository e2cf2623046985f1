//! Generators of voxels. Operations are plain data, applied chunk by chunk in the order of the file: [`build`] makes a bounded world of
//! them, a [`Generator`] makes any tile of a world without end.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod caves;
mod generator;
mod maze;
mod menger;
mod noise;
mod place;
pub(crate) mod scatter;
pub(crate) mod shape;
mod simplex;
mod stage;
pub(crate) mod stamp;
pub(crate) mod terrain;

pub use caves::Caves;
pub use generator::{Generator, NeedsWhole};
pub use maze::{Maze, MazePlan};
pub use menger::Menger;
pub use noise::Noise;
pub use place::Placed;
pub use scatter::{Jittered, Scatter, Scattered, place_anchor};
pub use shape::{Ball, Box3, Cylinder, Shape, Solid, Span3};
pub use stage::{BuildError, BuildLimits, Reach, Shortfall, build, build_within, reach};
pub use terrain::{Band, Layer, River, Terrain, Water};

use raxel_world::DenseChunk;
use raxel_world::{Bounds, ChunkPos};

/// One operation of a build. Materials are palette indices of the world being built.
#[allow(clippy::large_enum_variant, reason = "a world has a handful of them")]
pub enum Operation {
    /// A closed form that can decide between inside and outside.
    Solid(Solid),
    /// A height field of noise.
    Terrain(Terrain),
    /// A model at one or more places.
    Place(Placed),
    /// A model at random places on the earlier operations' ground.
    Scatter(Scatter),
    /// A model at random places on the land, at most one in each cell of a grid.
    Jittered(Jittered),
}

/// Chunks that a box of voxels touches, as half-open ranges of chunk coordinates along x, y, z.
pub(crate) fn chunk_ranges(bounds: &Bounds) -> [std::ops::Range<i64>; 3] {
    bounds.chunk_ranges()
}

/// The part of a box inside one chunk, in chunk-local coordinates; `None` when they do not meet.
pub(crate) fn local_part(bounds: &Bounds, pos: ChunkPos) -> Option<LocalBox> {
    let origin = pos.origin().to_array();
    let low = std::array::from_fn(|i| (bounds.min[i] - i64::from(origin[i])).clamp(0, 64) as i32);
    let high = std::array::from_fn(|i| (bounds.max[i] - i64::from(origin[i])).clamp(0, 64) as i32);
    (0..3).all(|i| low[i] < high[i]).then_some(LocalBox { low, high })
}

/// A half-open box in chunk-local coordinates.
pub(crate) struct LocalBox {
    /// Smallest coordinates inside.
    pub low: [i32; 3],
    /// One past the largest coordinates inside.
    pub high: [i32; 3],
}

/// The things that an operation needs of a chunk while it is being built.
pub(crate) struct Draft<'a> {
    /// Where the chunk lies.
    pub pos: ChunkPos,
    /// Its voxels so far.
    pub chunk: &'a mut DenseChunk,
}

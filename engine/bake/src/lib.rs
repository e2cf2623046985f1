//! Worlds in Zarr stores.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! [`bake`] makes the tiles of any [`raxel_world::ChunkProvider`] and writes them as arrays of [Zarr v3](https://zarr-specs.readthedocs.io),
//! one object a shard, to a [`Store`]. The bytes of a shard depend only on the world and the place of the shard. So any machine can make
//! shards, in any order, and repeat them after an interruption. [`ZarrSource`] is the way back: a store as the source of a streamed world.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod bake;
mod folder_store;
mod metadata;
#[cfg(feature = "cloud")]
mod object;
mod part;
mod plan;
mod retry;
mod seal;
mod shard;
mod source;
mod store;

pub use bake::{BakeError, Report, bake};
pub use folder_store::FolderStore;
#[cfg(feature = "cloud")]
pub use object::{ObjectStore, Patience};
pub use part::BakePart;
pub use plan::{BakedLevel, DEFAULT_EDGE, Plan, PlanError, ShardKey};
pub use source::{SourceError, ZarrSource};
pub use store::{OpenError, Store, StoreError, Wanted, open};

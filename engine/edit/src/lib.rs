//! Edits of voxel worlds: what an edit is, the chunks that edits have changed, undo and redo, questions about the newest voxels, the tiles
//! of a streamed world with its edits, and the save that keeps all of it.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! Everything here is exact and repeatable. Operations carry integers only, so the same operations in the same order give the same
//! bytes on every machine.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod apply;
mod chunk_cache;
mod edits;
mod history;
mod operation;
mod packed;
pub mod query;
pub mod records;
pub mod save;
mod scene;
mod shape;
mod source;

pub use chunk_cache::{ChunkCache, ChunkCacheStats};
pub use edits::{Change, ChunkChange, Edits, Overlay};
pub use history::Steps;
pub use operation::{Brush, EditError, MOST_CHUNKS, MOST_RADIUS, Operation, UNIT, fixed};
pub use packed::PackedChunk;
pub use scene::{Base, EditModel, Scene};
pub use source::EditedChunks;

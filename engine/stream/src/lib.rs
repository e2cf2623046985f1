//! Worlds that are loaded around a camera.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! A [`Streamer`] asks a [`raxel_world::ChunkProvider`] for tiles on threads of its own, puts each into a block of a pool, and makes
//! [`Publication`]s: a directory of all tiles that are there, and a header, which together with the blocks are a buffer of the layout
//! `tree64`. A frame takes the newest publication by writing the header. Words that a header can reach are never overwritten. Unreached
//! blocks and directories become free when all frames that could reach them have finished.
//!
//! A [`WorldStream`] is a streamer on a Vulkan device: its pool is a buffer, and its frames are those of a session.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod cube;
mod on_device;
mod pool;
mod publication;
mod reach;
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "words of a pool are addressed in 32 bits, and estimates saturate"
)]
mod streamer;
mod tile_directory;
mod upload_budget;
mod view;

pub use cube::Cube;
pub use on_device::{Eye, Refused, SeenChanges, ThreadTime, WorldStream, streaming_range};
pub use pool::{PoolMemory, PoolStats};
pub use publication::{Missing, Publication, Stats};
pub use reach::{StreamingRange, TileKey};
pub use streamer::{Estimate, StreamError, StreamOptions, Streamer};
pub use view::View;

//! GPU encodings of a world: one file a layout, each the twin of its file in `shaders/include/raxel/internal/layouts`. An encoding is the
//! content of one storage buffer in 32-bit words: a header, the materials, then the voxels.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! The layouts here are those that raxel uses. `raxel-rivals` has their rivals, made of the same parts.

#![expect(
    clippy::cast_possible_truncation,
    reason = "`check_size` refuses buffers whose words 32 bits cannot address; masks are packed as halves of 64 bits"
)]
#![cfg_attr(test, allow(clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod block;
mod encoded;
mod flat64;
pub mod hashed_chunks;
mod header;
pub mod instances;
mod layout;
pub mod lights;
mod live;
mod octree;
mod packed;
pub mod parts;
mod table;
mod tile_block;
mod tree64;

pub use block::{BlockMember, GlslType, QUADS_STRIDE, WORDS_STRIDE};
pub use encoded::{ADDRESSABLE, Access, Encoded, EncodedImage, EncodingLimits, LayoutError, check_size};
pub use flat64::Flat64Header;
pub use hashed_chunks::{HashedChunksHeader, LiveHashedChunks};
pub use header::{Extent, MATERIAL_WORDS, buffer};
pub use layout::{Edits, EncodeImage, Encoding, Layout};
pub use live::{LiveLayout, Patch};
pub use packed::Packing;
pub use table::Table;
pub use tile_block::{FULL_RUN_WORDS, TileBlock, TileNode, full_run, palette};
pub use tree64::{LiveTree64, Tree64Header};

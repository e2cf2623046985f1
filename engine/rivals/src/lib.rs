//! Layouts that are there to be compared with: the ways in which other renderers keep their voxels. One file a layout, each the twin of its
//! file in `shaders/include/raxel/rivals/internal/layouts`. They are judged like raxel's own, by the same tests, `raxel bench` and
//! `raxel stress`.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.
//!
//! This crate has the list of all layouts, since it is the one that knows all. `docs/rivals/README.md` has an overview.

#![expect(
    clippy::cast_possible_truncation,
    reason = "`check_size` refuses buffers whose words 32 bits cannot address; masks are packed as halves of 64 bits"
)]
#![cfg_attr(test, allow(clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod brickmap;
mod bvh;
mod chunk_table;
mod chunks;
mod svdag;
mod svo;
mod texture3d;

use raxel_layouts::Layout;

/// Bytes that links of 31 bits reach, where they count halfwords.
const LINKED: u64 = 4 << 30;

pub use brickmap::{BrickmapHeader, LAYOUT as BRICKMAP};
pub use bvh::{BvhHeader, LAYOUT as BVH};
pub use chunk_table::LAYOUT as CHUNK_TABLE;
pub use chunks::{ChunksHeader, LAYOUT as CHUNKS};
pub use svdag::{LAYOUT as SVDAG, SvdagHeader};
pub use svo::{LAYOUT as SVO, SvoHeader};
pub use texture3d::{LAYOUT as TEXTURE3D, Texture3dHeader};

/// The layouts of this crate.
pub const RIVALS: [Layout; 7] = [CHUNKS, BVH, CHUNK_TABLE, BRICKMAP, SVO, SVDAG, TEXTURE3D];

/// Every layout, raxel's own first.
pub const LAYOUTS: &[Layout] = &{
    let mut all = [Layout::TREE64; 10];
    let (own, rivals) = (Layout::OWN, RIVALS);
    let mut i = 0;
    while i < all.len() {
        all[i] = if i < own.len() { own[i] } else { rivals[i - own.len()] };
        i += 1;
    }
    all
};

/// The layout of that name.
pub fn layout(name: &str) -> Option<Layout> {
    LAYOUTS.iter().copied().find(|layout| layout.name() == name)
}

//! GPU encodings of a world: one file a layout, each the twin of `shaders/include/raxel/<layout>.glsl`. An encoding is the content of
//! one storage buffer in 32-bit words: a header, the materials, then the voxels.

#![expect(
    clippy::cast_possible_truncation,
    reason = "`check_size` refuses buffers whose words 32 bits cannot address; masks are packed as halves of 64 bits"
)]
#![cfg_attr(test, allow(clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod block;
mod brickmap;
mod bvh;
mod chunk_table;
mod chunks;
mod flat64;
mod hashed_chunks;
mod header;
pub mod instances;
pub mod lights;
mod live;
mod octree;
mod packed;
mod parts;
mod svdag;
mod svo;
mod table;
mod texture3d;
mod tile_block;
mod tree64;

use thiserror::Error;

pub use block::{BlockMember, QUADS_STRIDE, WORDS_STRIDE};
pub use brickmap::BrickmapHeader;
pub use bvh::BvhHeader;
pub use chunks::ChunksHeader;
pub use flat64::Flat64Header;
pub use hashed_chunks::{HashedChunksHeader, LiveHashedChunks};
pub use header::{Extent, MATERIAL_WORDS};
pub use live::{LiveLayout, Patch};
pub use svdag::SvdagHeader;
pub use svo::SvoHeader;
pub use texture3d::{EncodedImage, Texture3dHeader};
pub use tile_block::{FULL_RUN_WORDS, TileBlock, TileNode, full_run, palette};
pub use tree64::{LiveTree64, Tree64Header};

use raxel_world::World;

/// A way to lay out a world in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Layout {
    /// A list of 32³ flat chunks that is searched linearly.
    Chunks,
    /// A sparse tree of 4³ nodes with occupancy masks.
    Tree64,
    /// A tree of boxes around 4³ blocks with occupancy masks.
    Bvh,
    /// Flat 32³ chunks with occupancy masks in a hash table.
    ChunkTable,
    /// Sectors of 8³ bricks with occupancy masks.
    Brickmap,
    /// A complete octree for each 32³ chunk, in a hash table.
    Octree,
    /// A sparse octree.
    Svo,
    /// A sparse octree in which equal subtrees are stored once.
    Svdag,
    /// A dense 3-D image with mips.
    Texture3d,
    /// Chunks by place and 4³ masks, with free radii: for worlds of at most 2048 × 1024 × 2048 voxels.
    Flat64,
}

/// What shaders do with an encoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Access {
    /// Read it.
    Read,
    /// Set voxels of it, too.
    Write,
}

/// The content of a world buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Encoded {
    /// The whole buffer.
    pub words: Vec<u32>,
    /// Bytes that say where solid voxels are.
    pub geometry_bytes: u64,
    /// Bytes that say what they are made of, the palette included.
    pub attribute_bytes: u64,
}

/// What a device can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of the largest storage buffer.
    pub buffer_bytes: u64,
    /// Texels along an axis of the largest 3-D image.
    pub image_side: u32,
    /// Bytes that an image may have.
    pub image_bytes: u64,
}

impl From<u64> for Limits {
    /// Buffers of so many bytes, and images as most devices have them: 2048 texels a side, 4 GiB.
    fn from(buffer_bytes: u64) -> Self {
        Self { buffer_bytes, image_side: 2048, image_bytes: 4 << 30 }
    }
}

/// Why a world does not fit a layout. Nothing big has been allocated when this is returned.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LayoutError {
    /// More bytes than the buffer may have.
    #[error("the world takes {bytes} bytes in the layout `{layout}`, and the largest storage buffer has {limit} bytes")]
    TooLarge {
        /// The layout's name.
        layout: &'static str,
        /// Bytes needed.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// More bytes than an image may have.
    #[error("the world takes {bytes} bytes as an image in the layout `{layout}`, and the device has room for {limit}")]
    ImageTooLarge {
        /// The layout's name.
        layout: &'static str,
        /// Bytes needed, mips included.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// Its voxels are too far apart.
    #[error("the world is {span} voxels wide, and the layout `{layout}` holds at most {limit}")]
    TooWide {
        /// The layout's name.
        layout: &'static str,
        /// Largest extent of the world's chunks in voxels.
        span: u64,
        /// Largest extent allowed.
        limit: u64,
    },
    /// More lamps than the buffer may have.
    #[error(
        "{faces} faces of the world give off light and take {bytes} bytes, and the largest storage buffer has {limit} bytes"
    )]
    TooManyLights {
        /// Bare faces of emissive voxels.
        faces: u64,
        /// Bytes needed.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
    },
}

impl Layout {
    /// Every layout.
    pub const ALL: &[Layout] = &[
        Layout::Chunks,
        Layout::Tree64,
        Layout::Bvh,
        Layout::ChunkTable,
        Layout::Brickmap,
        Layout::Octree,
        Layout::Svo,
        Layout::Svdag,
        Layout::Texture3d,
        Layout::Flat64,
    ];

    /// The largest box of solids, in voxels from the corner of the world's cube, of a layout that does not hold worlds of any width.
    pub const fn window(self) -> Option<[u64; 3]> {
        match self {
            Self::Flat64 => Some(flat64::WINDOW),
            _ => None,
        }
    }

    /// Its name in `source = "world.<name>"`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Chunks => "chunks",
            Self::Tree64 => "tree64",
            Self::Bvh => "bvh",
            Self::ChunkTable => "chunk_table",
            Self::Brickmap => "brickmap",
            Self::Octree => "octree",
            Self::Svo => "svo",
            Self::Svdag => "svdag",
            Self::Texture3d => "texture3d",
            Self::Flat64 => "flat64",
        }
    }

    /// The layout of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|layout| layout.name() == name)
    }

    /// The members of the buffer block that a shader must declare for it, in order; the last is the runtime array.
    pub fn block(self) -> Vec<BlockMember> {
        match self {
            Self::Chunks => ChunksHeader::block(),
            Self::Tree64 => Tree64Header::block_in_quads(),
            Self::Bvh => BvhHeader::block(),
            Self::ChunkTable | Self::Octree => HashedChunksHeader::block(),
            Self::Brickmap => BrickmapHeader::block(),
            Self::Svo => SvoHeader::block(),
            Self::Svdag => SvdagHeader::block(),
            Self::Texture3d => Texture3dHeader::block(),
            Self::Flat64 => Flat64Header::block_in_quads(),
        }
    }

    /// Encodes a world for a buffer of at most so many bytes, or for a device of these limits.
    pub fn encode(self, world: &World, limits: impl Into<Limits>) -> Result<Encoded, LayoutError> {
        self.encode_for(world, limits.into(), Access::Read)
    }

    /// Whether its shaders can set single voxels of a writable copy: `rx_set` in its GLSL.
    pub const fn has_set(self) -> bool {
        matches!(self, Self::Chunks | Self::ChunkTable | Self::Octree | Self::Texture3d)
    }

    /// Whether its buffer follows edits of the world by writing what they touched ([`LiveLayout`]). The others are encoded again.
    pub const fn follows_edits(self) -> bool {
        matches!(self, Self::Tree64 | Self::Octree | Self::ChunkTable)
    }

    /// Encodes a world for a copy that shaders write. Where [`Layout::has_set`], equal chunks are stored as often as they stand in
    /// the world, and the bounds of the solid voxels are those of all voxels that can be set. Otherwise it is [`Layout::encode`].
    pub fn encode_writable(self, world: &World, limits: impl Into<Limits>) -> Result<Encoded, LayoutError> {
        self.encode_for(world, limits.into(), Access::Write)
    }

    fn encode_for(self, world: &World, limits: Limits, access: Access) -> Result<Encoded, LayoutError> {
        let limit = limits.buffer_bytes;
        match self {
            Self::Chunks => chunks::encode(world, limit, access),
            Self::Tree64 => tree64::encode(world, limit),
            Self::Bvh => bvh::encode(world, limit),
            Self::ChunkTable => chunk_table::encode(world, limit, access),
            Self::Brickmap => brickmap::encode(world, limit),
            Self::Octree => octree::encode(world, limit, access),
            Self::Svo => svo::encode(world, limit),
            Self::Svdag => svdag::encode(world, limit),
            Self::Texture3d => texture3d::encode(world, limits, access),
            Self::Flat64 => flat64::encode(world, limit),
        }
    }

    /// Whether the voxels are in an image beside the buffer: texels of 16-bit unsigned integers.
    pub const fn has_image(self) -> bool {
        matches!(self, Self::Texture3d)
    }

    /// The image of a layout that has one.
    pub fn encode_image(self, world: &World, limits: Limits) -> Result<Option<EncodedImage>, LayoutError> {
        match self {
            Self::Texture3d => texture3d::encode_image(world, limits).map(Some),
            _ => Ok(None),
        }
    }
}

/// `bytes`, unless they are over the limit.
fn check_size(layout: Layout, bytes: u64, limit: u64) -> Result<u64, LayoutError> {
    if bytes > limit { Err(LayoutError::TooLarge { layout: layout.name(), bytes, limit }) } else { Ok(bytes) }
}

//! The result of encoding a world, within the limits of a device.

use raxel_world::MaterialIndex;
use thiserror::Error;

use super::Layout;

/// The accesses of shaders to an encoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
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
    /// Bytes that describe the materials of voxels, the palette included.
    pub attribute_bytes: u64,
}

/// The capacities of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncodingLimits {
    /// Bytes of the largest storage buffer.
    pub buffer_bytes: u64,
    /// Texels along an axis of the largest 3-D image.
    pub image_side: u32,
    /// Bytes that an image may have.
    pub image_bytes: u64,
}

impl From<u64> for EncodingLimits {
    /// Buffers of that many bytes, and images as most devices have them: 2048 texels a side, 4 GiB.
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
        /// Exposed faces of emissive voxels.
        faces: u64,
        /// Bytes needed.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
    },
}

/// The 3-D image of a layout that has one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EncodedImage {
    /// Texels of mip 0.
    pub size: [u32; 3],
    /// Every mip down to one texel, x first, then y, then z, without padding. A texel of mip k is 0 when its cube of 2^k voxels is empty,
    /// else the material of one of its voxels. Along each axis mip k has ⌊size / 2^k⌋ texels, at least 1, as images have them: the
    /// remainder at the far end has no texel.
    pub mips: Vec<Vec<MaterialIndex>>,
}

impl EncodedImage {
    /// Bytes of all mips.
    pub fn bytes(&self) -> u64 {
        self.mips.iter().map(|mip| size_of_val(mip.as_slice()) as u64).sum()
    }
}

/// Bytes that addresses of 32 bits reach, where they count words.
pub const ADDRESSABLE: u64 = 4 << 32;

/// `bytes`, unless they are over the limit.
pub fn check_size(layout: Layout, bytes: u64, limit: u64) -> Result<u64, LayoutError> {
    if bytes > limit { Err(LayoutError::TooLarge { layout: layout.name(), bytes, limit }) } else { Ok(bytes) }
}

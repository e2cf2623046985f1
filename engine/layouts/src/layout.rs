//! Layouts as values, so that crates can bring layouts of their own.

use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};

use raxel_world::World;

use super::hashed_chunks::Form;
use super::{Access, BlockMember, Encoded, EncodedImage, EncodingLimits, LayoutError};

/// A way to lay out a world in a buffer. Layouts are identified by their names.
#[derive(Clone, Copy)]
pub struct Layout(&'static Encoding);

/// Encodes the voxels of a world as texels of an image.
pub type EncodeImage = fn(&World, EncodingLimits) -> Result<EncodedImage, LayoutError>;

/// The parts of a layout: its name, its buffer, and the operations on it.
pub struct Encoding {
    /// Its name in `source = "world.<name>"`; no other layout has it.
    pub name: &'static str,
    /// The members of the buffer block that a shader must declare for it, in order; the last is the runtime array.
    pub block: fn() -> Vec<BlockMember>,
    /// Encodes a world.
    pub encode: fn(&World, EncodingLimits, Access) -> Result<Encoded, LayoutError>,
    /// Encodes the image beside the buffer, if the voxels are in one: texels of 16-bit unsigned integers.
    pub image: Option<EncodeImage>,
    /// Whether its shaders can set single voxels of a writable copy: `rx_set` in its GLSL.
    pub has_set: bool,
    /// How its buffer follows edits of the world.
    pub edits: Edits,
    /// The largest box of solids, in voxels from the corner of the world's cube, if it does not hold worlds of any width.
    pub window: Option<[u64; 3]>,
}

impl Encoding {
    /// A layout without an image, whose voxels cannot be set and whose buffer does not follow edits, for worlds of any width.
    pub const fn new(
        name: &'static str,
        block: fn() -> Vec<BlockMember>,
        encode: fn(&World, EncodingLimits, Access) -> Result<Encoded, LayoutError>,
    ) -> Self {
        Self { name, block, encode, image: None, has_set: false, edits: Edits::Encode, window: None }
    }
}

/// How a buffer follows edits of the world.
#[derive(Clone, Copy)]
pub enum Edits {
    /// It does not: the world is encoded again.
    Encode,
    /// As [`LiveTree64`](super::LiveTree64).
    Tree64,
    /// As [`LiveHashedChunks`](super::LiveHashedChunks) with chunks of this form.
    HashedChunks(&'static Form),
}

impl Layout {
    /// A sparse tree of 4³ nodes with occupancy masks.
    pub const TREE64: Self = Self(&super::tree64::ENCODING);
    /// Chunks by place and 4³ masks, with free radii: for worlds of at most 2048 × 1024 × 2048 voxels.
    pub const FLAT64: Self = Self(&super::flat64::ENCODING);
    /// A complete octree for each 32³ chunk, in a hash table: shaders can set its voxels.
    pub const OCTREE: Self = Self(&super::octree::ENCODING);

    /// The layouts of this crate. `raxel-rivals` has others, and the list of all.
    pub const OWN: [Self; 3] = [Self::TREE64, Self::OCTREE, Self::FLAT64];

    /// A layout that is encoded so.
    pub const fn new(encoding: &'static Encoding) -> Self {
        Self(encoding)
    }

    /// The largest box of solids, in voxels from the corner of the world's cube, of a layout that does not hold worlds of any width.
    pub const fn window(self) -> Option<[u64; 3]> {
        self.0.window
    }

    /// Its name in `source = "world.<name>"`.
    pub const fn name(self) -> &'static str {
        self.0.name
    }

    /// The members of the buffer block that a shader must declare for it, in order; the last is the runtime array.
    pub fn block(self) -> Vec<BlockMember> {
        (self.0.block)()
    }

    /// Encodes a world for a buffer with a limit of bytes, or for a device of these limits.
    pub fn encode(self, world: &World, limits: impl Into<EncodingLimits>) -> Result<Encoded, LayoutError> {
        (self.0.encode)(world, limits.into(), Access::Read)
    }

    /// Whether its shaders can set single voxels of a writable copy: `rx_set` in its GLSL.
    pub const fn has_set(self) -> bool {
        self.0.has_set
    }

    /// Whether edits of the world write only the touched parts of its buffer ([`LiveLayout`](super::LiveLayout)). The others are encoded
    /// again.
    pub const fn follows_edits(self) -> bool {
        !matches!(self.0.edits, Edits::Encode)
    }

    /// How its buffer follows edits.
    pub(super) const fn edits(self) -> Edits {
        self.0.edits
    }

    /// Encodes a world for a copy that shaders write. With [`Layout::has_set`], each chunk of the world is stored apart, even if
    /// chunks are equal. The bounds of the solid voxels are then those of all voxels that can be set. Otherwise it is
    /// [`Layout::encode`].
    pub fn encode_writable(self, world: &World, limits: impl Into<EncodingLimits>) -> Result<Encoded, LayoutError> {
        (self.0.encode)(world, limits.into(), Access::Write)
    }

    /// Whether the voxels are in an image beside the buffer: texels of 16-bit unsigned integers.
    pub const fn has_image(self) -> bool {
        self.0.image.is_some()
    }

    /// The image of a layout that has one.
    pub fn encode_image(self, world: &World, limits: EncodingLimits) -> Result<Option<EncodedImage>, LayoutError> {
        self.0.image.map(|encode| encode(world, limits)).transpose()
    }
}

impl fmt::Debug for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl PartialEq for Layout {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for Layout {}

impl Ord for Layout {
    fn cmp(&self, other: &Self) -> Ordering {
        self.name().cmp(other.name())
    }
}

impl PartialOrd for Layout {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Hash for Layout {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name().hash(state);
    }
}

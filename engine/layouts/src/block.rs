//! The interface that the runtime compares a shader's world block with: a description derived from the Rust header.

/// Bytes of an element of the runtime array `words`.
pub const WORDS_STRIDE: u32 = 4;
/// Bytes of an element of the runtime array `quads`.
pub const QUADS_STRIDE: u32 = 16;

/// One member of the buffer block `RxWorld`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockMember {
    /// GLSL name.
    pub name: &'static str,
    /// Byte offset in the block.
    pub offset: u32,
    /// GLSL type: `uint`, `ivec3` or, in an array, `uvec4`; of an array, that of its element.
    pub ty: &'static str,
    /// Bytes from one element to the next when it is the runtime array.
    pub stride: Option<u32>,
}

/// The members of a block that begins with words of these names, and goes on with the runtime array `quads`.
pub(crate) fn words_and_quads<const N: usize>(names: [&'static str; N]) -> Vec<BlockMember> {
    let word = |(offset, name)| BlockMember { name, offset, ty: "uint", stride: None };
    let mut members: Vec<_> = (0..).step_by(4).zip(names).map(word).collect();
    members.push(BlockMember { name: "quads", offset: 4 * N as u32, ty: "uvec4", stride: Some(QUADS_STRIDE) });
    members
}

/// Field types that a header may have, with their GLSL names.
pub trait GlslType {
    /// The name.
    const NAME: &'static str;
}

impl GlslType for u32 {
    const NAME: &'static str = "uint";
}

impl GlslType for [i32; 3] {
    const NAME: &'static str = "ivec3";
}

/// Declares a header: a `Pod` struct whose fields are the members of the block, and its description. All headers begin alike; the declared
/// members come after that.
#[macro_export]
macro_rules! layout_header {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $ty:ty,)* }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name {
            /// Smallest corner of a cube around the world, in voxels: the root's, where there is a tree.
            pub origin: [i32; 3],
            /// The cube has 2^`log2_size` voxels a side, at least 64.
            pub log2_size: u32,
            /// Smallest coordinates of solid voxels.
            pub bounds_min: [i32; 3],
            /// Materials, air included.
            pub material_count: u32,
            /// Largest coordinates of solid voxels.
            pub bounds_last: [i32; 3],
            /// Address of the first material, in words behind the header.
            pub materials_at: u32,
            $($(#[$field_doc])* pub $field: $ty,)*
        }

        impl $name {
            /// The part that all headers have, for materials right behind the header; the rest is 0.
            pub(super) fn of(extent: &$crate::Extent, materials: &[raxel_world::Material]) -> Self {
                Self {
                    origin: extent.origin,
                    log2_size: extent.log2_size,
                    bounds_min: extent.bounds_min,
                    material_count: materials.len() as u32,
                    bounds_last: extent.bounds_last,
                    ..bytemuck::Zeroable::zeroed()
                }
            }

            /// Words of the header: the index of the word behind it in a buffer.
            pub const WORDS: u32 = size_of::<Self>() as u32 / 4;

            /// The members of the buffer block that a shader must declare, in order; the last is the runtime array.
            pub fn block() -> Vec<$crate::BlockMember> {
                macro_rules! member {
                    ($member:ident: $of:ty) => {
                        $crate::BlockMember {
                            name: stringify!($member),
                            offset: std::mem::offset_of!($name, $member) as u32,
                            ty: <$of as $crate::GlslType>::NAME,
                            stride: None,
                        }
                    };
                }
                let mut members = vec![
                    member!(origin: [i32; 3]),
                    member!(log2_size: u32),
                    member!(bounds_min: [i32; 3]),
                    member!(material_count: u32),
                    member!(bounds_last: [i32; 3]),
                    member!(materials_at: u32),
                    $(member!($field: $ty)),*
                ];
                members.push($crate::BlockMember {
                    name: "words",
                    offset: size_of::<Self>() as u32,
                    ty: <u32 as $crate::GlslType>::NAME,
                    stride: Some($crate::WORDS_STRIDE),
                });
                members
            }

            /// The block of a layout whose shaders read four words at a time: the runtime array is `uvec4 quads[]`.
            #[allow(dead_code, reason = "not every layout does")]
            pub(super) fn block_in_quads() -> Vec<$crate::BlockMember> {
                let mut members = Self::block();
                if let Some(array) = members.last_mut() {
                    *array = $crate::BlockMember { name: "quads", ty: "uvec4", stride: Some($crate::QUADS_STRIDE), ..*array };
                }
                members
            }
        }
    };
}

pub(super) use layout_header;

//! What the runtime compares a shader's world block with: a description derived from the Rust header.

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

/// Field types that a header may have, with their GLSL names.
pub(super) trait GlslType {
    const NAME: &'static str;
}

impl GlslType for u32 {
    const NAME: &'static str = "uint";
}

impl GlslType for [i32; 3] {
    const NAME: &'static str = "ivec3";
}

/// Declares a header: a `Pod` struct whose fields are the members of the block, and its description.
macro_rules! header {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $ty:ty,)* }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$field_doc])* pub $field: $ty,)* }

        impl $name {
            /// Words of the header: the index of the word behind it in a buffer.
            pub const WORDS: u32 = size_of::<Self>() as u32 / 4;

            pub(super) fn block() -> Vec<BlockMember> {
                let mut members = vec![
                    $(BlockMember {
                        name: stringify!($field),
                        offset: std::mem::offset_of!($name, $field) as u32,
                        ty: <$ty as super::block::GlslType>::NAME,
                        stride: None,
                    }),*
                ];
                members.push(BlockMember {
                    name: "words",
                    offset: size_of::<Self>() as u32,
                    ty: u32::NAME,
                    stride: Some(WORDS_STRIDE),
                });
                members
            }

            /// The block of a layout whose shaders read four words at a time: the runtime array is `uvec4 quads[]`.
            #[allow(dead_code, reason = "not every layout does")]
            pub(super) fn block_in_quads() -> Vec<BlockMember> {
                let mut members = Self::block();
                if let Some(array) = members.last_mut() {
                    *array = BlockMember { name: "quads", ty: "uvec4", stride: Some(super::block::QUADS_STRIDE), ..*array };
                }
                members
            }
        }
    };
}

pub(super) use header;

//! Image formats, named by GLSL's own layout qualifiers (GLSL 4.60, section 4.4.7).

use serde::{Deserialize, Serialize};

/// The type of the numbers that an image load or fetch returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub enum ScalarKind {
    /// `image2D`, `sampler2D`.
    Float,
    /// `iimage2D`, `isampler2D`.
    Int,
    /// `uimage2D`, `usampler2D`.
    Uint,
}

macro_rules! formats {
    ($($variant:ident = $name:literal, $bytes:literal, $channels:literal, $kind:ident;)*) => {
        /// An image format that GLSL can name as a layout qualifier.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[allow(missing_docs, reason = "each variant is the GLSL qualifier of its name")]
        pub enum Format { $(#[serde(rename = $name)] $variant),* }

        impl Format {
            /// Every format, in GLSL's order.
            pub const ALL: &[Format] = &[$(Format::$variant),*];

            /// GLSL's name, e.g. `rgba16f`.
            pub const fn name(self) -> &'static str {
                match self { $(Format::$variant => $name),* }
            }

            /// The format of that GLSL name.
            pub fn from_name(name: &str) -> Option<Format> {
                match name { $($name => Some(Format::$variant),)* _ => None }
            }

            /// Bytes of one texel.
            pub const fn bytes(self) -> u32 {
                match self { $(Format::$variant => $bytes),* }
            }

            /// Number of channels.
            pub const fn channels(self) -> u32 {
                match self { $(Format::$variant => $channels),* }
            }

            /// The type that a shader reads from it: float (also for unorm and snorm), signed or unsigned integers.
            pub const fn scalar(self) -> ScalarKind {
                match self { $(Format::$variant => ScalarKind::$kind),* }
            }
        }
    };
}

formats! {
    Rgba32f = "rgba32f", 16, 4, Float;
    Rgba16f = "rgba16f", 8, 4, Float;
    Rg32f = "rg32f", 8, 2, Float;
    Rg16f = "rg16f", 4, 2, Float;
    R11fG11fB10f = "r11f_g11f_b10f", 4, 3, Float;
    R32f = "r32f", 4, 1, Float;
    R16f = "r16f", 2, 1, Float;
    Rgba16 = "rgba16", 8, 4, Float;
    Rgb10A2 = "rgb10_a2", 4, 4, Float;
    Rgba8 = "rgba8", 4, 4, Float;
    Rg16 = "rg16", 4, 2, Float;
    Rg8 = "rg8", 2, 2, Float;
    R16 = "r16", 2, 1, Float;
    R8 = "r8", 1, 1, Float;
    Rgba16Snorm = "rgba16_snorm", 8, 4, Float;
    Rgba8Snorm = "rgba8_snorm", 4, 4, Float;
    Rg16Snorm = "rg16_snorm", 4, 2, Float;
    Rg8Snorm = "rg8_snorm", 2, 2, Float;
    R16Snorm = "r16_snorm", 2, 1, Float;
    R8Snorm = "r8_snorm", 1, 1, Float;
    Rgba32i = "rgba32i", 16, 4, Int;
    Rgba16i = "rgba16i", 8, 4, Int;
    Rgba8i = "rgba8i", 4, 4, Int;
    Rg32i = "rg32i", 8, 2, Int;
    Rg16i = "rg16i", 4, 2, Int;
    Rg8i = "rg8i", 2, 2, Int;
    R32i = "r32i", 4, 1, Int;
    R16i = "r16i", 2, 1, Int;
    R8i = "r8i", 1, 1, Int;
    Rgba32ui = "rgba32ui", 16, 4, Uint;
    Rgba16ui = "rgba16ui", 8, 4, Uint;
    Rgb10A2ui = "rgb10_a2ui", 4, 4, Uint;
    Rgba8ui = "rgba8ui", 4, 4, Uint;
    Rg32ui = "rg32ui", 8, 2, Uint;
    Rg16ui = "rg16ui", 4, 2, Uint;
    Rg8ui = "rg8ui", 2, 2, Uint;
    R32ui = "r32ui", 4, 1, Uint;
    R16ui = "r16ui", 2, 1, Uint;
    R8ui = "r8ui", 1, 1, Uint;
}

/// What every device can do with images of a format (Vulkan specification, "Required Format Support").
impl Format {
    /// Shaders can load from and store to such images without `shaderStorageImageExtendedFormats`.
    pub const fn is_stored_everywhere(self) -> bool {
        let of_8_bits = matches!(self, Self::Rgba8 | Self::Rgba8Snorm | Self::Rgba8i | Self::Rgba8ui);
        let of_16_bits = matches!(self, Self::Rgba16f | Self::Rgba16i | Self::Rgba16ui);
        let floats = matches!(self, Self::R32f | Self::Rg32f | Self::Rgba32f);
        let signed = matches!(self, Self::R32i | Self::Rg32i | Self::Rgba32i);
        let unsigned = matches!(self, Self::R32ui | Self::Rg32ui | Self::Rgba32ui);
        of_8_bits || of_16_bits || floats || signed || unsigned
    }

    /// Shaders can read such images.
    pub const fn is_sampled_everywhere(self) -> bool {
        let normalized = matches!(self, Self::R16 | Self::Rg16 | Self::Rgba16);
        let signed = matches!(self, Self::R16Snorm | Self::Rg16Snorm | Self::Rgba16Snorm);
        !normalized && !signed
    }

    /// Samplers can filter between their texels.
    pub const fn is_filtered_everywhere(self) -> bool {
        let is_float = matches!(self.scalar(), ScalarKind::Float);
        let is_wide = matches!(self, Self::R32f | Self::Rg32f | Self::Rgba32f);
        is_float && self.is_sampled_everywhere() && !is_wide
    }
}

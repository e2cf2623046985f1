//! How the debug target is looked at: which part of it is shown, and what it is compared with.

use std::sync::Arc;

use raxel_gpu::Buffer;
use raxel_shader::interface::ScalarKind;

use super::error::ExecuteError;
use super::prepare::Builder;
use super::report::Texels;

/// A part of the debug target that fills the picture, as shares of its extent along each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Its top left corner: 0 to 1 - [`Self::size`].
    pub origin: [f64; 2],
    /// Its width and its height, above 0 and at most 1.
    pub size: f64,
}

impl Region {
    /// All of it.
    pub const WHOLE: Region = Region { origin: [0.0; 2], size: 1.0 };
}

/// What the numbers of a reference are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReferenceValues {
    /// Floats, in the unit of the debug target.
    Floats,
    /// Integers.
    Integers,
    /// Colours as a screen shows them: 0 to 1, sRGB-encoded.
    Displayed,
}

/// A picture on the device that the debug target is compared with.
pub struct Reference {
    pub(super) buffer: Arc<Buffer>,
    pub(super) extent: [u32; 2],
    pub(super) channels: u32,
    pub(super) values: ReferenceValues,
}

impl Reference {
    /// Its extent in texels.
    pub fn extent(&self) -> [u32; 2] {
        self.extent
    }
}

/// How the debug target and a reference are shown together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Comparison {
    /// The debug target left of an edge, the reference right of it. The edge is a share of the picture's width.
    Wipe(f64),
    /// The reference alone.
    Reference,
    /// The debug target minus the reference, times this.
    Difference(f32),
}

/// Why the debug target cannot be compared with a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Mismatch {
    /// They have different extents.
    #[error("the shown target is {}×{}, the kept picture {}×{}", .0[0], .0[1], .1[0], .1[1])]
    Extent([u32; 2], [u32; 2]),
    /// One holds floats, the other integers.
    #[error("the shown target and the kept picture do not both hold floats, or both integers")]
    Values,
    /// A buffer is shown.
    #[error("a buffer cannot be compared with a picture")]
    Buffer,
}

impl Builder {
    /// Puts texels on the device to be compared with. Waits for the copy; meant for a thread of its own.
    pub fn reference(&self, texels: &Texels) -> Result<Reference, ExecuteError> {
        let channels = texels.format.channels() as usize;
        let integers = texels.scalar() != ScalarKind::Float;
        let words: Vec<u32> = match texels.integers().filter(|_| integers) {
            Some(texels) => texels.iter().flat_map(|texel| texel[..channels].iter().copied()).collect(),
            None => (texels.floats().iter())
                .flat_map(|texel| texel[..channels].iter().map(|value| value.to_bits()).collect::<Vec<_>>())
                .collect(),
        };
        let values = if integers { ReferenceValues::Integers } else { ReferenceValues::Floats };
        self.reference_of((&words, texels.format.channels()), [texels.width, texels.height], values)
    }

    /// Puts a picture on the device to be compared with: rows from the top, red, green, blue. Waits as [`Self::reference`].
    pub fn reference_picture(
        &self,
        pixels: &[[f32; 3]],
        extent: [u32; 2],
        values: ReferenceValues,
    ) -> Result<Reference, ExecuteError> {
        let words: Vec<u32> = pixels.as_flattened().iter().map(|value| value.to_bits()).collect();
        self.reference_of((&words, 3), extent, values)
    }

    fn reference_of(
        &self,
        (words, channels): (&[u32], u32),
        extent: [u32; 2],
        values: ReferenceValues,
    ) -> Result<Reference, ExecuteError> {
        let buffer = self.upload_buffer(bytemuck::cast_slice(words), "picture to compare with")?;
        Ok(Reference { buffer, extent, channels, values })
    }
}

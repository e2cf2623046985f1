//! An estimate of memory requirements for when no device is asked.

use crate::ir::plan::{BufferDesc, ImageDesc, MemoryModel, Requirements};

/// Texels packed tightly, images on pages of 4 KiB, buffers on 256 bytes; one memory type. Real devices pad and tile, and need a
/// little more.
#[derive(Clone, Copy, Debug, Default)]
pub struct EstimatedMemory;

/// Alignment of images and size of a page.
const PAGE: u64 = 4096;

impl MemoryModel for EstimatedMemory {
    fn image(&self, image: &ImageDesc) -> Requirements {
        let texels = (0..image.mips)
            .map(|mip| {
                let axis = |axis: u32| u64::from(axis.checked_shr(mip).unwrap_or(0).max(1));
                image.extent.into_iter().fold(1_u64, |texels, side| texels.saturating_mul(axis(side)))
            })
            .fold(0_u64, u64::saturating_add);
        let size = texels.saturating_mul(image.layers.into()).saturating_mul(image.format.bytes().into());
        Requirements { size: padded(size, PAGE), alignment: PAGE, type_bits: 1 }
    }

    fn buffer(&self, buffer: &BufferDesc) -> Requirements {
        Requirements { size: padded(buffer.size, 256), alignment: 256, type_bits: 1 }
    }

    fn granularity(&self) -> u64 {
        1
    }
}

fn padded(size: u64, alignment: u64) -> u64 {
    size.checked_next_multiple_of(alignment).unwrap_or(u64::MAX / alignment * alignment)
}

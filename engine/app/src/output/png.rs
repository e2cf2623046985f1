//! PNG: 8 bits a channel, no alpha, sRGB as the picture is.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageResult};
use raxel_runtime::execute::Picture;

/// The bytes of the PNG file. Equal pictures give equal bytes.
pub(crate) fn encode(picture: &Picture) -> ImageResult<Vec<u8>> {
    let rgb: Vec<u8> = picture.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive).write_image(
        &rgb,
        picture.width,
        picture.height,
        ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}

//! PNG: 8 bits a channel, no alpha, sRGB as the picture is.

use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter};
use raxel_runtime::execute::Picture;

/// The bytes of the PNG file. Equal pictures give equal bytes.
pub(crate) fn encode(picture: &Picture) -> Result<Vec<u8>, EncodingError> {
    let rgb: Vec<u8> = picture.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    encoder.set_filter(Filter::Adaptive);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb)?;
    writer.finish()?;
    Ok(bytes)
}

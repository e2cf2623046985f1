//! PNG: 8 bits a channel, no alpha, sRGB as the picture is.

use png::{BitDepth, ColorType, Encoder, EncodingError};
use raxel_execute::Picture;

/// How much time PNG compression takes. The pixels are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Compression {
    /// The fastest that is still small.
    #[default]
    Fast,
    /// As most programs write it: about ten times slower, somewhat smaller.
    Balanced,
    /// As small as can be had, slower again.
    High,
}

/// The bytes of the PNG file. Equal pictures give equal bytes.
pub(crate) fn encode(picture: &Picture, compression: Compression) -> Result<Vec<u8>, EncodingError> {
    let rgb = super::rgb(picture);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(match compression {
        Compression::Fast => png::Compression::Fast,
        Compression::Balanced => png::Compression::Balanced,
        Compression::High => png::Compression::High,
    });
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb)?;
    writer.finish()?;
    Ok(bytes)
}

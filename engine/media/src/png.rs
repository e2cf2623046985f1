//! PNG: grey or colour, with or without alpha, of 8 or 16 bits a channel; palettes and fewer bits are expanded to 8.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Transformations};

use raxel_picture::can_hold;

use super::texels::Channel;
use super::{MOST_BYTES, Picture, check_extent};

#[expect(clippy::cast_possible_truncation, reason = "`MOST_BYTES` is far below 2⁶³")]
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let text = |error: DecodingError| error.to_string();
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: 2 * MOST_BYTES as usize });
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(text)?;
    let (color, depth) = reader.output_color_type();
    let channel = match depth {
        BitDepth::Sixteen => Channel::Unorm16,
        _ => Channel::Unorm8,
    };
    let channels = match color {
        ColorType::Grayscale => 1,
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgb => 3,
        ColorType::Rgba => 4,
        ColorType::Indexed => return Err("its palette is missing".to_owned()),
    };
    let (width, height) = reader.info().size();
    can_hold(bytes, reader.info().raw_bytes() as u64).map_err(|error| error.to_string())?;
    let extent = check_extent(width.into(), height.into(), (channels * channel.bytes()) as u64)?;
    let mut bytes = vec![0; width as usize * height as usize * channels * channel.bytes()];
    reader.next_frame(&mut bytes).map_err(text)?;
    if channel == Channel::Unorm16 {
        // PNG is big-endian.
        bytes.chunks_exact_mut(2).for_each(<[u8]>::reverse);
    }
    Ok(Picture { extent, channel, channels, bytes })
}

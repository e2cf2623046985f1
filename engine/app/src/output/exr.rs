//! OpenEXR: the texels of a target as they are. Half stays half, unsigned integers stay integers, everything else becomes 32-bit float. The
//! format has no signed integers: those of 8 and 16 bits are exact as floats, those of 32 bits are written as unsigned ones, in two's
//! complement. One channel is called `Y`, more are `R`, `G`, `B`, `A`.

use std::io::Cursor;

use exr::image::write::WritableImage;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, Text, f16,
};
use raxel_runtime::execute::Texels;
use raxel_shader::format::Format;
use raxel_shader::interface::ScalarKind;

/// The bytes of the EXR file; `name` becomes the layer's name. Equal texels give equal bytes.
pub(crate) fn encode(texels: &Texels, name: &str) -> exr::error::Result<Vec<u8>> {
    let names: &[&str] = match texels.format.channels() {
        1 => &["Y"],
        2 => &["R", "G"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    let integers = match texels.scalar() {
        ScalarKind::Uint => texels.integers(),
        ScalarKind::Int if wraps(texels.format) => texels.integers(),
        ScalarKind::Int | ScalarKind::Float => None,
    };
    let floats = if integers.is_none() { texels.floats() } else { Vec::new() };
    let half = matches!(texels.format, Format::R16f | Format::Rg16f | Format::Rgba16f);
    for (i, channel) in names.iter().enumerate() {
        let samples = match &integers {
            Some(integers) => FlatSamples::U32(integers.iter().map(|texel| texel[i]).collect()),
            None if half => FlatSamples::F16(floats.iter().map(|texel| f16::from_f32(texel[i])).collect()),
            None => FlatSamples::F32(floats.iter().map(|texel| texel[i]).collect()),
        };
        channels.push(AnyChannel::new(*channel, samples));
    }
    let attributes = LayerAttributes {
        layer_name: Text::new_or_none(name),
        software_name: Text::new_or_none("raxel"),
        comments: Text::new_or_none(if wraps(texels.format) { "signed integers in two's complement" } else { "" }),
        ..LayerAttributes::default()
    };
    let size = (texels.width as usize, texels.height as usize);
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// Whether negative numbers are written as 2³² more: 32-bit floats do not hold all integers of this format.
pub(crate) fn wraps(format: Format) -> bool {
    matches!(format, Format::R32i | Format::Rg32i | Format::Rgba32i)
}

#[cfg(test)]
mod tests {
    use exr::prelude::{ReadChannels, ReadLayers, read};

    use super::*;

    #[test]
    fn signed_integers_keep_every_bit() {
        let far = [16_777_217, -16_777_217, i32::MIN, i32::MAX, -1, 0];
        let bytes = far.iter().flat_map(|v| v.to_le_bytes()).collect();
        let encoded = encode(&Texels { format: Format::R32i, width: 6, height: 1, bytes }, "hit").unwrap();
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(encoded))
            .unwrap();
        let FlatSamples::U32(found) = &image.layer_data.channel_data.list[0].sample_data else { panic!("no integers") };
        assert_eq!(found.iter().map(|v| v.cast_signed()).collect::<Vec<_>>(), far);
        assert_eq!(image.layer_data.attributes.comments.unwrap().to_string(), "signed integers in two's complement");
    }

    #[test]
    fn texels_come_back_bit_by_bit() {
        let depth = [0.5f32, -1.0, f32::INFINITY, 1e-30, 3.0, 16_777_217.0];
        let texels = Texels {
            format: Format::R32f,
            width: 3,
            height: 2,
            bytes: depth.iter().flat_map(|v| v.to_le_bytes()).collect(),
        };
        let bytes = encode(&texels, "depth").unwrap();
        assert_eq!(bytes, encode(&texels, "depth").unwrap());
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .unwrap();
        let channel = &image.layer_data.channel_data.list[0];
        assert_eq!(channel.name.to_string(), "Y");
        assert_eq!(channel.sample_data.values_as_f32().collect::<Vec<_>>(), depth);
    }
}

//! OpenEXR: the texels of a target as they are. Half stays half, unsigned integers stay integers, everything else becomes 32-bit float. The
//! format has no signed integers: those of 8 and 16 bits are exact as floats, those of 32 bits are written as unsigned ones, in two's
//! complement. One channel is called `Y`, more are `R`, `G`, `B`, `A`.

use std::io::Cursor;

use exr::image::write::WritableImage;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer, LayerAttributes,
    SmallVec, Text, f16,
};
use raxel_execute::Texels;
use raxel_shader::format::Format;
use raxel_shader::interface::ScalarKind;

/// The bytes of the EXR file: a layer of each target. Equal texels give equal bytes.
pub(super) fn encode(targets: &[(String, Texels)]) -> exr::error::Result<Vec<u8>> {
    let layers: SmallVec<[_; 2]> = targets.iter().map(|(name, texels)| layer(texels, name)).collect();
    // The display window: the extents of the layers may differ.
    let size = |axis: fn(&Texels) -> u32| targets.iter().map(|(_, texels)| axis(texels)).max().unwrap_or(1) as usize;
    let window = IntegerBounds::from_dimensions((size(|t| t.width), size(|t| t.height)));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layers(ImageAttributes::new(window), layers).write().non_parallel().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

fn layer(texels: &Texels, name: &str) -> Layer<AnyChannels<FlatSamples>> {
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
    Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels))
}

/// Whether negative numbers are written as 2³² more: 32-bit floats do not hold all integers of this format.
fn wraps(format: Format) -> bool {
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
        let encoded =
            encode(&[("hit".to_owned(), Texels { format: Format::R32i, width: 6, height: 1, bytes })]).unwrap();
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
        let targets = [("depth".to_owned(), texels)];
        let bytes = encode(&targets).unwrap();
        assert_eq!(bytes, encode(&targets).unwrap());
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

    #[test]
    fn targets_of_any_extent_become_layers() {
        let texels = |width: u32, value: f32| {
            let bytes = (0..width * 2).flat_map(|_| value.to_le_bytes()).collect();
            Texels { format: Format::R32f, width, height: 2, bytes }
        };
        let targets = [("depth".to_owned(), texels(4, 1.5)), ("half".to_owned(), texels(2, -2.0))];
        let image = exr::prelude::read_all_flat_layers_from_file;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::fs::write(&path, encode(&targets).unwrap()).unwrap();
        let layers = image(&path).unwrap().layer_data;
        let found: Vec<_> = layers
            .iter()
            .map(|layer| {
                let name = layer.attributes.layer_name.as_ref().unwrap().to_string();
                (name, layer.size.0, layer.channel_data.list[0].sample_data.values_as_f32().next().unwrap())
            })
            .collect();
        assert_eq!(found, [("depth".to_owned(), 4, 1.5), ("half".to_owned(), 2, -2.0)]);
    }
}

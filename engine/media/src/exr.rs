//! OpenEXR: the first layer, with the channels Y, or R, RG, RGB or RGBA, or one of any name; half, float or unsigned integers.

use std::io::Cursor;

use exr::meta::MetaData;
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, SampleType, read};

use raxel_picture::can_hold;

use super::texels::Channel;
use super::{Picture, check_extent};

/// Which channels a picture may have, in their order.
const CHANNELS: [&[&str]; 5] = [&["R"], &["R", "G"], &["R", "G", "B"], &["R", "G", "B", "A"], &["Y"]];

pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let text = |error: exr::error::Error| error.to_string();
    // The header first: it has the size of the rest.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(text)?;
    let header = meta.headers.first().ok_or("it has no layer")?;
    if header.deep {
        return Err("it is a deep image".to_owned());
    }
    let list = &header.channels.list;
    let names: Vec<String> = list.iter().map(|channel| channel.name.to_string()).collect();
    let order: Vec<usize> = match names.as_slice() {
        [_] => vec![0],
        _ => CHANNELS
            .iter()
            .filter(|wanted| wanted.len() == names.len())
            .find_map(|wanted| wanted.iter().map(|name| names.iter().position(|known| known == name)).collect())
            .ok_or_else(|| format!("its channels are {}; raxel reads Y, R, RG, RGB and RGBA", names.join(", ")))?,
    };
    let sample = list[0].sample_type;
    if list.iter().any(|channel| channel.sample_type != sample || channel.sampling.0 != 1 || channel.sampling.1 != 1) {
        return Err("its channels differ in type or resolution".to_owned());
    }
    let channel = match sample {
        SampleType::F16 => Channel::Half,
        SampleType::F32 => Channel::Float,
        SampleType::U32 => Channel::Uint32,
    };
    let size = header.layer_size;
    let channels = order.len();
    let texel_bytes = (channels * channel.bytes()) as u64;
    let [width, height] = check_extent(size.0 as u64, size.1 as u64, texel_bytes)?;
    can_hold(bytes, u64::from(width) * u64::from(height) * texel_bytes).map_err(|error| error.to_string())?;

    let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = reader.from_buffered(Cursor::new(bytes)).map_err(text)?;
    let list = &image.layer_data.channel_data.list;
    let texels = width as usize * height as usize;
    let mut bytes = Vec::with_capacity(texels * channels * channel.bytes());
    for texel in 0..texels {
        for index in &order {
            match list.get(*index).map(|channel| &channel.sample_data) {
                Some(FlatSamples::F16(samples)) => bytes.extend(samples[texel].to_le_bytes()),
                Some(FlatSamples::F32(samples)) => bytes.extend(samples[texel].to_le_bytes()),
                Some(FlatSamples::U32(samples)) => bytes.extend(samples[texel].to_le_bytes()),
                None => return Err("a channel is missing".to_owned()),
            }
        }
    }
    Ok(Picture { extent: [width, height], channel, channels, bytes })
}

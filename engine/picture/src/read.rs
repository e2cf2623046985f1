//! Reads PNG, JPEG, Radiance HDR and OpenEXR, identified by their contents.

use std::io::Cursor;
use std::path::Path;

use exr::meta::MetaData;
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
use image::{ImageDecoder, ImageFormat, ImageReader};
use raxel_diagnostics::quietly;

use crate::{Encoding, Picture};

/// Most bytes of pixels that a byte of a file can stand for: no compression in use reaches a quarter of it.
const MOST_RATIO: u64 = 4096;

/// Why a file is no picture.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// It is no PNG, JPEG, HDR or EXR, or is broken.
    #[error("{0}")]
    Format(String),
    /// The EXR has no such layer.
    #[error("it has no layer `{name}`; it has {}", .known.join(", "))]
    Layer {
        /// The layer that was asked for.
        name: String,
        /// Those that there are.
        known: Vec<String>,
    },
}

/// Reads a picture from a file; of an EXR one layer, by default the first.
pub fn read(path: &Path, layer: Option<&str>) -> Result<Picture, ReadError> {
    decode(&std::fs::read(path)?, layer)
}

/// Reads a picture from the bytes of a file.
pub fn decode(bytes: &[u8], layer: Option<&str>) -> Result<Picture, ReadError> {
    // The decoders panic on some files that are broken.
    let decoded = quietly(|| decode_kind(bytes, layer));
    decoded.unwrap_or_else(|| Err(ReadError::Format("it is damaged".to_owned())))
}

fn decode_kind(bytes: &[u8], layer: Option<&str>) -> Result<Picture, ReadError> {
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return decode_exr(bytes, layer);
    }
    if let Some(name) = layer {
        return Err(ReadError::Layer { name: name.to_owned(), known: vec!["no layers: it is no EXR".to_owned()] });
    }
    let broken = |error: image::ImageError| ReadError::Format(error.to_string());
    let format = image::guess_format(bytes)
        .map_err(|_| ReadError::Format("it is not a PNG, JPEG, HDR or EXR picture".to_owned()))?;
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder().map_err(broken)?;
    can_hold(bytes, decoder.total_bytes())?;
    let image = image::load_from_memory_with_format(bytes, format).map_err(broken)?;
    let (width, height) = (image.width(), image.height());
    Ok(if format == ImageFormat::Hdr {
        let pixels = image.into_rgb32f().pixels().map(|pixel| pixel.0).collect();
        Picture { width, height, pixels, encoding: Encoding::Linear }
    } else {
        let pixels = image.into_rgb8().pixels().map(|pixel| pixel.0.map(|value| f32::from(value) / 255.0)).collect();
        Picture { width, height, pixels, encoding: Encoding::Display }
    })
}

/// Refuses a file whose header promises more bytes of pixels than the file can hold: decoders would allocate all of them first.
///
/// # Errors
/// Says how many bytes the header promises.
pub fn can_hold(bytes: &[u8], promised: u64) -> Result<(), ReadError> {
    if promised / MOST_RATIO <= bytes.len() as u64 {
        return Ok(());
    }
    let held = bytes.len();
    Err(ReadError::Format(format!(
        "it is damaged: its header promises {promised} bytes of pixels, and it has {held} bytes"
    )))
}

fn decode_exr(bytes: &[u8], layer: Option<&str>) -> Result<Picture, ReadError> {
    let text = |error: exr::error::Error| ReadError::Format(error.to_string());
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(text)?;
    let promised = meta.headers.iter().map(|header| {
        let pixels = (header.layer_size.0 as u64).saturating_mul(header.layer_size.1 as u64);
        pixels.saturating_mul(header.channels.bytes_per_pixel as u64)
    });
    can_hold(bytes, promised.fold(0, u64::saturating_add))?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(text)?;
    let name_of = |name: &Option<exr::prelude::Text>| name.as_ref().map(ToString::to_string).unwrap_or_default();
    let found = match layer {
        None => image.layer_data.first(),
        Some(name) => image.layer_data.iter().find(|layer| name_of(&layer.attributes.layer_name) == name),
    };
    let Some(found) = found else {
        let known =
            image.layer_data.iter().map(|layer| format!("`{}`", name_of(&layer.attributes.layer_name))).collect();
        return Err(ReadError::Layer { name: layer.unwrap_or_default().to_owned(), known });
    };
    let channel = |name: &str| {
        let list = &found.channel_data.list;
        list.iter().find(|channel| channel.name.to_string() == name).map(|channel| &channel.sample_data)
    };
    let value = |samples: Option<&FlatSamples>, at: usize| match samples {
        Some(FlatSamples::F32(values)) => values[at],
        Some(FlatSamples::F16(values)) => values[at].to_f32(),
        Some(FlatSamples::U32(values)) => values[at] as f32,
        None => 0.0,
    };
    let (width, height) = (found.size.width(), found.size.height());
    let grey = channel("Y").or_else(|| match found.channel_data.list.as_slice() {
        [only] => Some(&only.sample_data),
        _ => None,
    });
    let channels = match grey {
        Some(grey) => [Some(grey); 3],
        None => [channel("R"), channel("G"), channel("B")],
    };
    if channels.iter().all(Option::is_none) {
        return Err(ReadError::Format("it has neither channels R, G, B nor a single one".to_owned()));
    }
    let size = |axis: usize| {
        u32::try_from(axis).map_err(|_| ReadError::Format(format!("it is {width} × {height} pixels large")))
    };
    let (wide, high) = (size(width)?, size(height)?);
    let pixels = (0..width * height).map(|at| channels.map(|samples| value(samples, at))).collect();
    Ok(Picture { width: wide, height: high, pixels, encoding: Encoding::Linear })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_picture_is_said() {
        for bytes in [&b""[..], b"hello", &[0x76, 0x2f, 0x31, 0x01, 0, 0], b"\x89PNG\r\n\x1a\n\0\0"] {
            assert!(matches!(decode(bytes, None), Err(ReadError::Format(_))), "{bytes:?}");
        }
    }

    /// A chunk of a PNG.
    fn chunk(kind: [u8; 4], data: &[u8]) -> Vec<u8> {
        let named = [kind.as_slice(), data].concat();
        let step = |crc: u32| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
        let crc = !named.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc)));
        [&(data.len() as u32).to_be_bytes(), named.as_slice(), &crc.to_be_bytes()].concat()
    }

    /// The decoder panics on it.
    #[test]
    fn a_palette_that_is_cut_off_is_an_error() {
        let header = [0, 0, 0, 1, 0, 0, 0, 1, 8, 3, 0, 0, 0];
        let rows = [0x78, 1, 1, 2, 0, 0xfd, 0xff, 0, 0, 0, 2, 0, 1];
        let chunks = [
            chunk(*b"IHDR", &header),
            chunk(*b"PLTE", &[7; 4]),
            chunk(*b"tRNS", &[7]),
            chunk(*b"IDAT", &rows),
            chunk(*b"IEND", &[]),
        ];
        let file = [b"\x89PNG\r\n\x1a\n".as_slice(), &chunks.concat()].concat();
        let said = decode(&file, None).unwrap_err().to_string();
        assert!(said.contains("damaged"), "{said}");
    }

    /// 65536 × 65536 pixels in a header, and none behind it: nothing is allocated for them.
    #[test]
    fn a_header_that_promises_too_much_is_an_error() {
        let channel = exr::prelude::AnyChannel::new("Y", FlatSamples::F32(vec![0.0; 16]));
        let list = exr::prelude::AnyChannels::sort([channel].into_iter().collect());
        let layer = exr::prelude::Layer::new(
            (4, 4),
            exr::prelude::LayerAttributes::default(),
            exr::prelude::Encoding::UNCOMPRESSED,
            list,
        );
        let mut file = Cursor::new(Vec::new());
        exr::prelude::WritableImage::write(&exr::prelude::Image::from_layer(layer)).to_buffered(&mut file).unwrap();
        let mut file = file.into_inner();
        for name in [b"dataWindow\0box2i\0".as_slice(), b"displayWindow\0box2i\0"] {
            let at = file.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4;
            file[at + 8..at + 16].copy_from_slice(&[255, 255, 0, 0, 255, 255, 0, 0]);
        }
        let said = decode(&file, None).unwrap_err().to_string();
        assert!(said.contains("promises 17179869184 bytes"), "{said}");
    }

    #[test]
    fn a_png_is_what_it_displays() {
        let mut bytes = Cursor::new(Vec::new());
        image::RgbaImage::from_raw(2, 1, vec![255, 0, 51, 7, 0, 0, 0, 255])
            .unwrap()
            .write_to(&mut bytes, ImageFormat::Png)
            .unwrap();
        let picture = decode(bytes.get_ref(), None).unwrap();
        assert_eq!(picture.encoding, Encoding::Display);
        assert_eq!(picture.pixels, [[1.0, 0.0, 0.2], [0.0; 3]]);
        assert!(decode(bytes.get_ref(), Some("depth")).is_err());
    }
}

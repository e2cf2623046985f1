//! Encodes frames that were read back.

use raxel_execute::{Picture, Texels};

use super::png::Compression;
use super::{exr, png};
use crate::error::{OutputError, Result};

/// The form of one picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum PictureFormat {
    /// 8 bits a channel, as the display map shows it.
    Png,
    /// As PNG, with losses: see --quality.
    Jpg,
    /// The texels of targets as they are; several targets become layers.
    Exr,
    /// Radiance: the texels of a target as 8-bit mantissas with a shared exponent.
    Hdr,
    /// The displayed picture without a header: width × height × 4 bytes, red, green, blue, 255.
    Raw,
}

impl PictureFormat {
    /// Extensions with their kinds.
    pub const EXTENSIONS: [(&str, PictureFormat); 5] = [
        ("png", PictureFormat::Png),
        ("jpg", PictureFormat::Jpg),
        ("jpeg", PictureFormat::Jpg),
        ("exr", PictureFormat::Exr),
        ("hdr", PictureFormat::Hdr),
    ];

    /// The extension of files of this form.
    pub fn extension(self) -> &'static str {
        match self {
            PictureFormat::Png => "png",
            PictureFormat::Jpg => "jpg",
            PictureFormat::Exr => "exr",
            PictureFormat::Hdr => "hdr",
            PictureFormat::Raw => "rgba",
        }
    }

    /// Whether this form takes texels of targets instead of the displayed picture.
    pub fn wants_texels(self) -> bool {
        matches!(self, PictureFormat::Exr | PictureFormat::Hdr)
    }
}

/// A form with its settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coding {
    /// The form.
    pub kind: PictureFormat,
    /// Effort of PNG compression.
    pub compression: Compression,
    /// Quality of JPEG, 1 to 100.
    pub quality: u8,
}

/// A frame that was read back.
#[derive(Clone, Debug)]
pub enum Shot {
    /// The displayed picture.
    Picture(Picture),
    /// The texels of at least one target, by name.
    Texels(Vec<(String, Texels)>),
}

impl Shot {
    /// Extent in pixels of the picture, or of the first target.
    pub fn size(&self) -> [u32; 2] {
        match self {
            Shot::Picture(picture) => [picture.width, picture.height],
            Shot::Texels(layers) => layers.first().map_or([0; 2], |(_, texels)| [texels.width, texels.height]),
        }
    }
}

impl Coding {
    /// Encodes a frame. Equal frames give equal bytes.
    pub fn encode(self, shot: Shot) -> Result<Vec<u8>> {
        let failed = |error: &dyn std::fmt::Display| {
            OutputError::new(format!("the {} could not be made: {error}", self.kind.extension().to_uppercase()))
        };
        match (self.kind, shot) {
            (PictureFormat::Png, Shot::Picture(picture)) => {
                png::encode(&picture, self.compression).map_err(|error| failed(&error))
            }
            (PictureFormat::Jpg, Shot::Picture(picture)) => {
                raxel_picture::jpeg(&rgb(&picture), [picture.width, picture.height], self.quality)
                    .map_err(|error| failed(&error))
            }
            (PictureFormat::Raw, Shot::Picture(picture)) => Ok(picture.rgba),
            (PictureFormat::Exr, Shot::Texels(layers)) => exr::encode(&layers).map_err(|error| failed(&error)),
            (PictureFormat::Hdr, Shot::Texels(layers)) => {
                let Some((_, texels)) = layers.first() else { return Err(failed(&"there is no target")) };
                raxel_picture::hdr(&radiance(texels), [texels.width, texels.height]).map_err(|error| failed(&error))
            }
            (_, _) => Err(failed(&"it was read back in another form")),
        }
    }
}

/// The pixels without alpha.
pub(super) fn rgb(picture: &Picture) -> Vec<u8> {
    let mut rgb = vec![0; picture.rgba.len() / 4 * 3];
    for (to, [red, green, blue, _]) in rgb.as_chunks_mut().0.iter_mut().zip(picture.rgba.as_chunks().0) {
        *to = [*red, *green, *blue];
    }
    rgb
}

/// Red, green and blue; one channel is grey. The format has neither negative numbers nor NaN, which become 0, and no infinity.
fn radiance(texels: &Texels) -> Vec<[f32; 3]> {
    let grey = texels.format.channels() == 1;
    let value = |x: f32| if x > 0.0 { x.min(f32::MAX / 2.0) } else { 0.0 };
    let pixel = |[r, g, b, _]: [f32; 4]| if grey { [value(r); 3] } else { [value(r), value(g), value(b)] };
    texels.floats().into_iter().map(pixel).collect()
}

#[cfg(test)]
mod tests {
    use raxel_shader::format::Format;

    use super::*;

    fn picture() -> Picture {
        let rgba = (0..64 * 48).flat_map(|i: u32| [(i % 64 * 4) as u8, (i / 64 * 5) as u8, 90, 255]).collect();
        Picture { width: 64, height: 48, rgba }
    }

    fn coding(kind: PictureFormat) -> Coding {
        Coding { kind, compression: Compression::Fast, quality: 90 }
    }

    #[test]
    fn every_compression_of_a_png_has_the_same_pixels() {
        let all = [Compression::Fast, Compression::Balanced, Compression::High];
        let decoded = all.map(|compression| {
            let bytes = Coding { compression, ..coding(PictureFormat::Png) }.encode(Shot::Picture(picture())).unwrap();
            let mut reader = ::png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            pixels
        });
        assert!(decoded.iter().all(|pixels| *pixels == rgb(&picture())));
    }

    #[test]
    fn a_jpeg_is_close_and_smaller_with_less_quality() {
        let encode =
            |quality| Coding { quality, ..coding(PictureFormat::Jpg) }.encode(Shot::Picture(picture())).unwrap();
        let (good, bad) = (encode(95), encode(20));
        assert!(bad.len() < good.len());
        let decoded = image::load_from_memory_with_format(&good, image::ImageFormat::Jpeg).unwrap().into_rgb8();
        assert_eq!(decoded.dimensions(), (64, 48));
        assert!(decoded.iter().zip(rgb(&picture())).all(|(a, b)| a.abs_diff(b) < 16));
    }

    #[test]
    fn radiance_keeps_the_range() {
        let values = [0.25_f32, 1000.0, -1.0, f32::NAN];
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let texels = Texels { format: Format::R32f, width: 2, height: 2, bytes };
        let bytes = coding(PictureFormat::Hdr).encode(Shot::Texels(vec![("depth".to_owned(), texels)])).unwrap();
        let decoded = image::load_from_memory_with_format(&bytes, image::ImageFormat::Hdr).unwrap().into_rgb32f();
        let found: Vec<f32> = decoded.pixels().map(|pixel| pixel.0[1]).collect();
        assert!((found[0] - 0.25).abs() < 0.01 && (found[1] - 1000.0).abs() < 8.0, "{found:?}");
        assert!(found[2].abs() < 1e-6 && found[3].abs() < 1e-6, "{found:?}");
    }
}

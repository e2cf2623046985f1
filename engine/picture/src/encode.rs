//! JPEG and Radiance HDR. The encoders of `image` are generic and compiled where they are called: here, in a crate that is optimised as one unit.

use image::codecs::hdr::HdrEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, Rgb};

/// Why pixels do not become a file: more of them than the format holds, or another number than `width × height`.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct EncodeError(#[from] image::ImageError);

/// The bytes of a JPEG of sRGB-encoded pixels: red, green, blue, rows from the top. `quality` is 1 to 100.
pub fn jpeg(rgb: &[u8], [width, height]: [u32; 2], quality: u8) -> Result<Vec<u8>, EncodeError> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, quality).encode(rgb, width, height, ExtendedColorType::Rgb8)?;
    Ok(bytes)
}

/// The bytes of a Radiance HDR of linear pixels, rows from the top. The format has no negative numbers, no NaN and no infinity, so the pixels must
/// not have them.
pub fn hdr(pixels: &[[f32; 3]], [width, height]: [u32; 2]) -> Result<Vec<u8>, EncodeError> {
    let pixels: Vec<Rgb<f32>> = pixels.iter().copied().map(Rgb).collect();
    let mut bytes = Vec::new();
    HdrEncoder::new(&mut bytes).encode(&pixels, width as usize, height as usize)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decode;

    #[test]
    fn what_is_encoded_is_read_again() {
        let size = [16, 8];
        let grey: Vec<u8> = (0..128).flat_map(|i: u32| [(i % 16 * 16) as u8; 3]).collect();
        let picture = decode(&jpeg(&grey, size, 95).unwrap(), None).unwrap();
        assert_eq!([picture.width, picture.height], size);
        let close = |(pixel, byte): (&[f32; 3], &u8)| (pixel[0] - f32::from(*byte) / 255.0).abs() < 0.1;
        assert!(picture.pixels.iter().zip(grey.iter().step_by(3)).all(close));
        let light: Vec<[f32; 3]> = (0..128u16).map(|i| [f32::from(i), 0.5, 1000.0]).collect();
        let picture = decode(&hdr(&light, size).unwrap(), None).unwrap();
        assert!(picture.pixels.iter().zip(&light).all(|(a, b)| (0..3).all(|c| (a[c] - b[c]).abs() <= 8.0)));
    }
}

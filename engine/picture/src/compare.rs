//! Compares a picture with a reference, by FLIP (Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", 2020) and by
//! numbers.

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool, flip, magma_lut};

use crate::{Encoding, Picture};

/// How far two pictures are apart. All are 0 for equal ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Mean FLIP error: 0 is equal, 1 is black for white. Of pictures of linear light, as a screen shows them: 0 to 1, sRGB-encoded.
    pub flip: f64,
    /// Root of the mean square of the differences of all numbers: 0 to 1 for displayed pictures, in their own unit for others.
    pub rmse: f64,
    /// Largest difference of two numbers. Infinite where one is not finite and the other is another.
    pub max: f64,
    /// Pixels that differ at all.
    pub differing: u64,
    /// The FLIP error of each pixel in the colours of the magma map: width × height × 3 bytes.
    pub heat: Vec<u8>,
}

/// Why two pictures cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// They are not of one extent.
    #[error("one is {}×{} pixels, the other {}×{}", reference[0], reference[1], other[0], other[1])]
    Extent {
        /// Of the reference, in pixels.
        reference: [u32; 2],
        /// Of the other picture, in pixels.
        other: [u32; 2],
    },
    /// They hold nothing.
    #[error("they have no pixels")]
    Empty,
}

/// Compares a picture with a reference, as seen from about 0.7 m on a 4K screen (67 pixels a degree).
pub fn compare(reference: &Picture, other: &Picture) -> Result<Comparison, CompareError> {
    let extent = [reference.width, reference.height];
    if extent != [other.width, other.height] {
        return Err(CompareError::Extent { reference: extent, other: [other.width, other.height] });
    }
    if reference.pixels.is_empty() {
        return Err(CompareError::Empty);
    }
    let (mut squares, mut max, mut differing) = (0.0_f64, 0.0_f64, 0);
    for (a, b) in reference.pixels.iter().zip(&other.pixels) {
        let mut pixel_differs = false;
        for (a, b) in a.iter().zip(b) {
            // The same infinity and the same NaN are no difference.
            if a.to_bits() == b.to_bits() {
                continue;
            }
            let apart = (f64::from(*a) - f64::from(*b)).abs();
            let apart = if apart.is_nan() { f64::INFINITY } else { apart };
            pixel_differs |= apart > 0.0;
            squares += apart * apart;
            max = max.max(apart);
        }
        differing += u64::from(pixel_differs);
    }
    let error = flip(displayed(reference), displayed(other), DEFAULT_PIXELS_PER_DEGREE);
    Ok(Comparison {
        // Equal pictures have no error, although the metric rounds.
        flip: if differing == 0 { 0.0 } else { f64::from(FlipPool::from_image(&error).mean()) },
        rmse: (squares / (3 * reference.pixels.len()) as f64).sqrt(),
        max,
        differing,
        heat: error.apply_color_lut(&magma_lut()).to_vec(),
    })
}

/// The picture on a screen.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the value is clamped to a byte")]
fn displayed(picture: &Picture) -> FlipImageRgb8 {
    let value = |x: f32| {
        let x = match picture.encoding {
            Encoding::Display => x,
            Encoding::Linear if x <= 0.003_130_8 => x * 12.92,
            Encoding::Linear => 1.055 * x.powf(1.0 / 2.4) - 0.055,
        };
        (x * 255.0).round().clamp(0.0, 255.0) as u8
    };
    let pixel = |pixel: &[f32; 3]| if pixel.iter().any(|x| x.is_nan()) { [255, 0, 255] } else { pixel.map(value) };
    let bytes: Vec<u8> = picture.pixels.iter().flat_map(pixel).collect();
    FlipImageRgb8::with_data(picture.width, picture.height, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(values: &[f32], encoding: Encoding) -> Picture {
        let pixels = values.iter().map(|value| [*value; 3]).collect();
        Picture { width: values.len() as u32, height: 1, pixels, encoding }
    }

    #[test]
    fn equal_is_zero_and_black_for_white_is_almost_one() {
        let (black, white) = (gray(&[0.0; 64], Encoding::Display), gray(&[1.0; 64], Encoding::Display));
        let same = compare(&black, &black).unwrap();
        assert!(same.flip == 0.0 && same.rmse == 0.0 && same.max == 0.0 && same.differing == 0);
        let apart = compare(&black, &white).unwrap();
        assert!(apart.flip > 0.9 && apart.flip <= 1.0 && (apart.rmse - 1.0).abs() < 1e-6, "{}", apart.flip);
        assert_eq!((apart.max.to_bits(), apart.differing, apart.heat.len()), (1.0_f64.to_bits(), 64, 192));
    }

    #[test]
    fn numbers_keep_their_unit_and_nan_is_as_far_as_can_be() {
        let a = gray(&[1.0, 100.0, f32::NAN, f32::INFINITY], Encoding::Linear);
        let b = gray(&[1.0, 103.0, f32::NAN, f32::INFINITY], Encoding::Linear);
        let found = compare(&a, &b).unwrap();
        assert_eq!((found.max.to_bits(), found.differing), (3.0_f64.to_bits(), 1));
        assert!((found.rmse - 1.5).abs() < 1e-9);
        let c = gray(&[1.0, f32::NAN, f32::NAN, 5.0], Encoding::Linear);
        assert!(compare(&a, &c).unwrap().max.is_infinite());
    }

    #[test]
    fn extents_must_agree() {
        let error = compare(&gray(&[0.0; 4], Encoding::Display), &gray(&[0.0; 5], Encoding::Display)).unwrap_err();
        assert_eq!(error.to_string(), "one is 4×1 pixels, the other 5×1");
    }
}

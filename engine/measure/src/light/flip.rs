//! HDR-FLIP: the visible error at the exposures between which the reference is neither black nor white (Andersson and others, "Visualizing
//! errors in rendered high dynamic range images", 2021). The comparison at one exposure is the authors' own code.

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, flip};
use rayon::prelude::*;

use super::{Picture, luminance};

/// Mean HDR-FLIP, 0 to 1; `None` when the reference is so dark that it has no exposure.
pub(crate) fn hdr_flip(reference: &Picture, test: &Picture) -> Option<f64> {
    let exposures = exposures(reference)?;
    let worst = exposures
        .into_par_iter()
        .map(|exposure| {
            let [reference, test] = [reference, test].map(|picture| {
                let bytes: Vec<u8> = picture.texels.iter().flat_map(|texel| shown(texel, exposure)).collect();
                FlipImageRgb8::with_data(picture.size[0], picture.size[1], &bytes)
            });
            flip(reference, test, DEFAULT_PIXELS_PER_DEGREE).to_vec()
        })
        .reduce_with(|a, b| a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect())?;
    Some(worst.iter().map(|error| f64::from(*error)).sum::<f64>() / worst.len().max(1) as f64)
}

/// Factors that are tried, in steps of about one stop: from where the brightest pixel comes out at 0.85 to where the median one does.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "casts of floats saturate, and the count is clamped"
)]
fn exposures(reference: &Picture) -> Option<Vec<f64>> {
    let mut all: Vec<f64> = reference.texels.iter().map(luminance).filter(|value| value.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    let (most, median) = (*all.last()?, all[all.len() / 2]);
    // Light that the tone curve takes to 0.85.
    let [a, b, c] = [CURVE[0] - 0.85 * CURVE[3], CURVE[1] - 0.85 * CURVE[4], CURVE[2] - 0.85 * CURVE[5]];
    let half = -0.5 * b / a;
    let bright = half + (half * half - c / a).sqrt();
    let (start, stop) = ((bright / most).log2(), (bright / median.max(most * 1e-6)).log2());
    if !start.is_finite() || !stop.is_finite() {
        return None;
    }
    let count = ((stop - start).ceil() as usize).clamp(2, 24);
    Some((0..count).map(|i| (start + (stop - start) * i as f64 / (count - 1) as f64).exp2()).collect())
}

/// The ACES curve of the paper: (c0 x² + c1 x + c2) / (c3 x² + c4 x + c5).
const CURVE: [f64; 6] = [0.36 * 2.51, 0.6 * 0.03, 0.0, 0.36 * 2.43, 0.6 * 0.59, 0.14];

/// A texel at an exposure, tone-mapped, in sRGB.
#[expect(clippy::cast_possible_truncation, reason = "a displayed value is rounded to a byte in the end")]
fn shown(texel: &[f32; 3], exposure: f64) -> [u8; 3] {
    texel.map(|value| {
        let x = f64::from(if value.is_finite() { value.max(0.0) } else { 0.0 }) * exposure;
        let y = (CURVE[0] * x * x + CURVE[1] * x + CURVE[2]) / (CURVE[3] * x * x + CURVE[4] * x + CURVE[5]);
        raxel_world::srgb_from_linear(y as f32)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(scale: f32) -> Picture {
        let texels = (0..64 * 32).map(|i| [scale * (0.01 + (i % 64) as f32 / 8.0); 3]).collect();
        Picture { size: [64, 32], texels }
    }

    #[test]
    fn equal_pictures_differ_by_nothing_and_brighter_ones_by_more_the_brighter() {
        assert!(hdr_flip(&ramp(1.0), &ramp(1.0)).unwrap() < 1e-6);
        let [little, much] = [1.1, 3.0].map(|scale| hdr_flip(&ramp(1.0), &ramp(scale)).unwrap());
        assert!(little > 0.005 && little < much && much < 1.0, "{little} {much}");
        assert_eq!(hdr_flip(&ramp(0.0), &ramp(1.0)), None);
    }

    #[test]
    fn exposures_bring_bright_and_middle_to_the_same_grey() {
        let picture = ramp(1.0);
        let all = exposures(&picture).unwrap();
        let brightest = picture.texels.iter().fold(0.0_f32, |most, texel| most.max(texel[0]));
        let grey = shown(&[brightest; 3], all[0])[0];
        assert_eq!(grey, raxel_world::srgb_from_linear(0.85));
        assert!(all.windows(2).all(|pair| pair[0] < pair[1]));
    }
}

//! Many pictures of one moment, each with its rays at another place in the pixels, averaged: smooth edges, the same in every run.

use raxel_execute::{Picture, Texels};
use raxel_shader::format::Format;
use raxel_shader::interface::ScalarKind;

use super::coding::Shot;
use crate::error::{OutputError, Result};

/// The place in a pixel of the rays of sample `index` of `of`, in pixels from its centre, right and down: the R2 sequence (Roberts, "The
/// Unreasonable Effectiveness of Quasirandom Sequences", 2018), shifted so that the mean is the centre. One sample is at the centre.
#[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "there are two axes")]
pub(super) fn offset(index: u32, of: u32) -> [f64; 2] {
    /// The plastic number, whose powers make the steps.
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let place = |index: u32, axis: usize| {
        let step = PLASTIC.powi(-(axis as i32 + 1));
        (0.5 + f64::from(index) * step).fract() - 0.5
    };
    std::array::from_fn(|axis| {
        let mean = (0..of).map(|index| place(index, axis)).sum::<f64>() / f64::from(of);
        place(index, axis) - mean
    })
}

/// The sum of the samples so far.
#[derive(Default)]
pub(super) struct Sum {
    samples: u32,
    /// Of each layer; of a picture, one: linear light, three channels a pixel.
    layers: Vec<Vec<f32>>,
}

impl Sum {
    /// Adds a sample. All are of one form and extent.
    ///
    /// # Errors
    /// A target of integers has no average.
    pub(crate) fn add(&mut self, shot: &Shot) -> Result {
        self.samples += 1;
        match shot {
            Shot::Picture(picture) => {
                let decode = decode_table();
                let pixels = picture.rgba.chunks_exact(4);
                self.add_layer(0, pixels.flat_map(|pixel| [0, 1, 2].map(|c| decode[usize::from(pixel[c])])));
            }
            Shot::Texels(layers) => {
                for (index, (name, texels)) in layers.iter().enumerate() {
                    if texels.scalar() != ScalarKind::Float {
                        let message = format!("`{name}` holds integers, which have no average");
                        return Err(OutputError::new(message).help("leave `--samples` out, or take another target"));
                    }
                    let channels = texels.format.channels() as usize;
                    let values = texels.floats().into_iter();
                    self.add_layer(index, values.flat_map(move |texel| texel.into_iter().take(channels)));
                }
            }
        }
        Ok(())
    }

    fn add_layer(&mut self, index: usize, values: impl Iterator<Item = f32>) {
        match self.layers.get_mut(index) {
            Some(sum) => sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value),
            None => self.layers.push(values.collect()),
        }
    }

    /// The average, in the form of the last sample; averages of texels are 32-bit floats.
    pub(crate) fn average(self, like: Shot) -> Shot {
        let samples = self.samples.max(1) as f32;
        match like {
            Shot::Picture(picture) => {
                let mut rgba = picture.rgba;
                for (pixel, sum) in rgba.chunks_exact_mut(4).zip(self.layers[0].chunks_exact(3)) {
                    for (channel, sum) in pixel.iter_mut().zip(sum) {
                        *channel = encoded(sum / samples);
                    }
                }
                Shot::Picture(Picture { rgba, ..picture })
            }
            Shot::Texels(layers) => Shot::Texels(
                layers
                    .into_iter()
                    .zip(self.layers)
                    .map(|((name, texels), sum)| {
                        let format = match texels.format.channels() {
                            1 => Format::R32f,
                            2 => Format::Rg32f,
                            _ => Format::Rgba32f,
                        };
                        // Three channels become four, the last of them 1.
                        let channels = texels.format.channels() as usize;
                        let pad = format.channels() as usize - channels;
                        let texel = |sum: &[f32]| {
                            let values = sum.iter().map(|sum| sum / samples).chain(std::iter::repeat_n(1.0, pad));
                            values.flat_map(f32::to_le_bytes).collect::<Vec<u8>>()
                        };
                        let bytes = sum.chunks_exact(channels).flat_map(texel).collect();
                        (name, Texels { format, bytes, ..texels })
                    })
                    .collect(),
            ),
        }
    }
}

/// Linear light of each encoded value (IEC 61966-2-1).
fn decode_table() -> [f32; 256] {
    std::array::from_fn(|value| {
        let x = value as f32 / 255.0;
        if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    })
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the value is clamped to a byte")]
fn encoded(linear: f32) -> u8 {
    let x = if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (x * 255.0).round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_lie_around_the_middle_and_apart() {
        assert!(offset(0, 1).iter().all(|place| place.abs() < 1e-12));
        for of in [2, 4, 16, 64] {
            let places: Vec<_> = (0..of).map(|index| offset(index, of)).collect();
            for axis in 0..2 {
                assert!(places.iter().map(|place| place[axis]).sum::<f64>().abs() < 1e-9);
                assert!(places.iter().all(|place| place[axis].abs() < 0.8));
            }
            let apart = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            let nearest = (0..places.len())
                .flat_map(|i| (0..i).map(move |j| (i, j)))
                .map(|(i, j)| apart(&places[i], &places[j]))
                .fold(f64::MAX, f64::min);
            assert!(nearest > 0.4 / f64::from(of).sqrt(), "{of}: {nearest}");
        }
    }

    #[test]
    fn light_is_averaged_rather_than_code_values() {
        let shot = |value: u8| Shot::Picture(Picture { width: 1, height: 1, rgba: vec![value, value, 7, 255] });
        let mut sum = Sum::default();
        sum.add(&shot(0)).unwrap();
        sum.add(&shot(255)).unwrap();
        let Shot::Picture(picture) = sum.average(shot(255)) else { panic!() };
        // Half the light of white is 188, not 128; equal samples stay.
        assert_eq!(picture.rgba, [188, 188, 7, 255]);
    }

    #[test]
    fn texels_are_averaged_as_numbers_and_integers_refused() {
        let texels =
            |value: f32| Texels { format: Format::R32f, width: 1, height: 1, bytes: value.to_le_bytes().into() };
        let shot = |value: f32| Shot::Texels(vec![("depth".to_owned(), texels(value))]);
        let mut sum = Sum::default();
        sum.add(&shot(1.0)).unwrap();
        sum.add(&shot(4.0)).unwrap();
        let Shot::Texels(layers) = sum.average(shot(4.0)) else { panic!() };
        assert_eq!(layers[0].1.floats()[0][0].to_bits(), 2.5_f32.to_bits());
        let hit = Texels { format: Format::R32ui, width: 1, height: 1, bytes: vec![1, 0, 0, 0] };
        let failure = Sum::default().add(&Shot::Texels(vec![("hit".to_owned(), hit)])).unwrap_err();
        assert!(failure.message.contains("`hit` holds integers"));
    }
}

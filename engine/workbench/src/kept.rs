//! A picture that is kept to compare what a session shows with: a copy of a target, a file, or another target of the running graph.

use std::path::Path;
use std::sync::Arc;

use raxel_execute::{Builder, ExecuteError, Reference, ReferenceValues, Texels};
use raxel_graph::checked::{Display, DisplayMap};
use raxel_picture::{Encoding, Picture};
use raxel_runtime::debug_target::DebugTarget;
use raxel_world::srgb_from_linear;

/// Values are compared with values, however they are shown.
pub const VALUES: Display = Display { map: DisplayMap::Raw, range: [0.0, 1.0], channel: 0 };

/// The picture to compare with.
#[derive(Clone, Debug)]
pub struct Kept {
    /// In words.
    pub name: String,
    /// Its contents.
    pub what: What,
}

/// The contents of a [`Kept`].
#[derive(Clone, Debug)]
pub enum What {
    /// A picture that was kept.
    Still(Pixels),
    /// The contents of a target in each frame.
    Live(DebugTarget),
}

/// The pixels of a kept picture.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// A copy of a target.
    Texels(Arc<Texels>),
    /// A picture of a file.
    File(Arc<Picture>),
}

/// How far a shown target is from the kept picture, as `raxel compare` measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Mean FLIP error.
    pub flip: f64,
    /// Root of the mean square of the differences.
    pub rmse: f64,
    /// Largest difference. Infinite where one is not finite and the other is another.
    pub max: f64,
    /// Pixels that differ.
    pub differing: u64,
    /// All pixels.
    pub pixels: u64,
}

impl Kept {
    /// A copy of a target.
    pub fn copy(name: &str, texels: impl Into<Arc<Texels>>) -> Self {
        let texels = texels.into();
        let name = format!("{name}, {} × {}", texels.width, texels.height);
        Self { name, what: What::Still(Pixels::Texels(texels)) }
    }

    /// A target as it goes on.
    pub fn live(target: DebugTarget) -> Self {
        Self { name: format!("{target}, live"), what: What::Live(target) }
    }

    /// The picture in a file, which a person calls `name`. Takes as long as the disk and the decoder do.
    ///
    /// # Errors
    /// Why it cannot be read, in one line.
    pub fn read(path: &Path, name: &str) -> Result<Self, String> {
        // To read a pipe would wait for its writer.
        if std::fs::metadata(path).is_ok_and(|found| !found.is_file()) {
            return Err(format!("`{name}` cannot be read: it is not a file"));
        }
        let picture = raxel_picture::read(path, None).map_err(|error| format!("`{name}` cannot be loaded: {error}"))?;
        let name = format!("{name}, {} × {}", picture.width, picture.height);
        Ok(Self { name, what: What::Still(Pixels::File(Arc::new(picture))) })
    }
}

impl Pixels {
    /// The picture on a device.
    ///
    /// # Errors
    /// The device has no room for it, or is lost.
    pub fn reference(&self, builder: &Builder) -> Result<Reference, ExecuteError> {
        match self {
            Pixels::Texels(texels) => builder.reference(texels),
            Pixels::File(picture) => {
                let values = match picture.encoding {
                    Encoding::Display => ReferenceValues::Displayed,
                    Encoding::Linear => ReferenceValues::Floats,
                };
                builder.reference_picture(&picture.pixels, [picture.width, picture.height], values)
            }
        }
    }

    /// The figures of a target that is shown in this way, with this picture as the reference.
    ///
    /// # Errors
    /// The two cannot be compared, in one line.
    pub fn figures(&self, shown: &Texels, display: &Display) -> Result<Figures, String> {
        let (kept, shown) = match self {
            Pixels::Texels(kept) => (&Arc::new(picture(kept)), picture(shown)),
            Pixels::File(kept) if kept.encoding == Encoding::Linear => (kept, picture(shown)),
            Pixels::File(kept) => (kept, displayed(shown, display)?),
        };
        let found = raxel_picture::compare(kept, &shown).map_err(|error| error.to_string())?;
        let raxel_picture::Comparison { flip, rmse, max, differing, .. } = found;
        Ok(Figures { flip, rmse, max, differing, pixels: kept.pixels.len() as u64 })
    }
}

/// Texels as linear light; one channel is grey.
fn picture(texels: &Texels) -> Picture {
    let gray = texels.format.channels() == 1;
    let pixel = |[r, g, b, _]: [f32; 4]| if gray { [r; 3] } else { [r, g, b] };
    let pixels = texels.floats().into_iter().map(pixel).collect();
    Picture { width: texels.width, height: texels.height, pixels, encoding: Encoding::Linear }
}

/// Texels as a screen shows them, to be compared with a picture of a screen.
fn displayed(texels: &Texels, display: &Display) -> Result<Picture, String> {
    let [low, high] = display.range;
    let encode: &dyn Fn(f32) -> f32 = match display.map {
        DisplayMap::Color => {
            &|value| f32::from(srgb_from_linear(((value - low) / (high - low)).clamp(0.0, 1.0))) / 255.0
        }
        DisplayMap::Raw => &|value| value.clamp(0.0, 1.0),
        _ => {
            let why = "a picture of a screen has figures only for targets that are shown by `color` or `raw`";
            return Err(why.to_owned());
        }
    };
    let mut picture = picture(texels);
    picture.pixels.iter_mut().flatten().for_each(|value| *value = encode(*value));
    Ok(Picture { encoding: Encoding::Display, ..picture })
}

#[cfg(test)]
mod tests {
    use raxel_shader::format::Format;

    use super::*;

    const COLOR: Display = Display { map: DisplayMap::Color, range: [0.0, 1.0], channel: 0 };

    fn texels(values: &[f32]) -> Texels {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        Texels { format: Format::R32f, width: u32::try_from(values.len()).unwrap(), height: 1, bytes }
    }

    fn kept(values: &[f32]) -> Pixels {
        Pixels::Texels(Arc::new(texels(values)))
    }

    fn file(pixels: &[[f32; 3]], encoding: Encoding) -> Pixels {
        let width = u32::try_from(pixels.len()).unwrap();
        Pixels::File(Arc::new(Picture { width, height: 1, pixels: pixels.to_vec(), encoding }))
    }

    fn found(figures: &Result<Figures, String>) -> ([u64; 2], [u64; 2]) {
        let figures = figures.as_ref().unwrap();
        // In hundredths.
        let hundredths = [figures.rmse, figures.max].map(|value| (value * 100.0).round() as u64);
        (hundredths, [figures.differing, figures.pixels])
    }

    #[test]
    fn figures_are_of_values() {
        let shown = texels(&[1.0, 2.0, 3.0, 4.0]);
        let figures = |kept: &Pixels| kept.figures(&shown, &COLOR);
        assert_eq!(found(&figures(&kept(&[1.0, 2.0, 3.0, 4.0]))), ([0, 0], [0, 4]));
        assert_eq!(found(&figures(&kept(&[1.0, 2.0, 3.0, 6.0]))), ([100, 200], [1, 4]));
        let linear = file(&[[1.0; 3], [2.0; 3], [3.0; 3], [3.0; 3]], Encoding::Linear);
        assert_eq!(found(&figures(&linear)), ([50, 100], [1, 4]));
        let why = figures(&kept(&[1.0; 3])).unwrap_err();
        assert!(why.contains("3×1") && why.contains("4×1"), "{why}");
    }

    #[test]
    fn a_picture_of_a_screen_is_compared_with_what_a_screen_shows() {
        let white = file(&[[1.0; 3], [0.0; 3]], Encoding::Display);
        let figures = |shown: &[f32], display: &Display| white.figures(&texels(shown), display);
        assert_eq!(found(&figures(&[1.0, 0.0], &COLOR)), ([0, 0], [0, 2]));
        assert_eq!(found(&figures(&[4.0, 2.0], &Display { range: [2.0, 4.0], ..COLOR })), ([0, 0], [0, 2]));
        // A half of linear light is brighter on a screen than half of the way.
        assert_eq!(found(&figures(&[1.0, 0.5], &COLOR)).0[1], 74);
        let turbo = Display { map: DisplayMap::Turbo, ..COLOR };
        assert!(figures(&[1.0, 0.0], &turbo).unwrap_err().contains("`color` or `raw`"));
    }
}

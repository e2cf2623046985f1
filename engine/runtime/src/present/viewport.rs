//! How large the output is for a window: its extent, times a scale.

use std::ops::RangeInclusive;

/// The extent of a window in pixels, and the scale from it to the output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewport {
    window: [u32; 2],
    scale: f64,
}

impl Viewport {
    /// Range of the scale: pixels of the output for each pixel of the window, along each axis.
    pub const SCALES: RangeInclusive<f64> = 0.0625..=4.0;

    /// A viewport of a window. An extent of zero becomes 1, a scale is clamped to [`Self::SCALES`], and NaN becomes 1.
    pub fn new(window: [u32; 2], scale: f64) -> Self {
        let scale = if scale.is_nan() { 1.0 } else { scale.clamp(*Self::SCALES.start(), *Self::SCALES.end()) };
        Self { window: window.map(|pixels| pixels.max(1)), scale }
    }

    /// Extent of the window in pixels.
    pub fn window(&self) -> [u32; 2] {
        self.window
    }

    /// Pixels of the output for each pixel of the window, along each axis.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Extent of the output in pixels, at least one.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "casts of floats saturate, and sizes are not negative"
    )]
    pub fn output(&self) -> [u32; 2] {
        self.window.map(|pixels| ((f64::from(pixels) * self.scale).round() as u32).max(1))
    }

    /// The pixel of the output that a pixel of the window shows, both counted from the top left.
    #[expect(clippy::cast_possible_truncation, reason = "casts of floats saturate")]
    pub fn to_output(&self, pixel: [i32; 2]) -> [i32; 2] {
        let output = self.output();
        std::array::from_fn(|axis| {
            let share = (f64::from(pixel[axis]) + 0.5) / f64::from(self.window[axis]);
            (share * f64::from(output[axis])).floor() as i32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Viewport;

    #[test]
    fn the_output_is_the_window_scaled() {
        let half = Viewport::new([321, 180], 0.5);
        assert_eq!((half.window(), half.output()), ([321, 180], [161, 90]));
        assert_eq!(Viewport::new([320, 180], 1.0).output(), [320, 180]);
        assert_eq!(Viewport::new([3, 0], 0.0).output(), [1, 1]);
        assert_eq!(Viewport::new([100, 50], 1e9).output(), [400, 200]);
        assert_eq!(Viewport::new([100, 50], f64::NAN).output(), [100, 50]);
    }

    #[test]
    fn a_pixel_of_the_window_shows_the_nearest_pixel_of_the_output() {
        let half = Viewport::new([320, 180], 0.5);
        assert_eq!(half.to_output([0, 0]), [0, 0]);
        assert_eq!(half.to_output([319, 179]), [159, 89]);
        assert_eq!(half.to_output([101, 7]), [50, 3]);
        let whole = Viewport::new([320, 180], 1.0);
        assert_eq!(whole.to_output([17, 5]), [17, 5]);
        assert_eq!(whole.to_output([-1, -1]), [-1, -1]);
    }
}

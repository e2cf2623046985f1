//! Zoom and pan: the part of the shown target that fills the window.

use raxel_execute::Region;

/// Pixels of the window that a texel has at the largest zoom.
const LARGEST: f64 = 256.0;

/// Pixels below which a texel is hard to see.
const TINY: f64 = 4.0;

/// Pixels of a texel that was jumped to.
const SEEN: f64 = 32.0;

/// How large a picture and its window are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extents {
    /// Of the picture, in texels.
    pub picture: [u32; 2],
    /// Of the window, in pixels.
    pub window: [u32; 2],
}

/// The part of the picture that fills the window. Places are shares of an extent, from the top left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Magnifier {
    region: Region,
}

impl Default for Magnifier {
    fn default() -> Self {
        Self { region: Region::WHOLE }
    }
}

impl Magnifier {
    /// The part to show.
    pub(crate) fn region(&self) -> Region {
        self.region
    }

    /// Whether less than the whole picture is shown.
    pub(crate) fn is_on(&self) -> bool {
        self.region != Region::WHOLE
    }

    /// The magnification of the picture.
    pub(crate) fn zoom(&self) -> f64 {
        1.0 / self.region.size
    }

    /// The place of the picture that is seen at a place of the window.
    pub(crate) fn to_picture(self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.region.origin[axis] + at[axis] * self.region.size)
    }

    /// The place of the window where a place of the picture is seen: outside of 0 to 1 where it is not.
    pub(crate) fn to_window(self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (at[axis] - self.region.origin[axis]) / self.region.size)
    }

    /// The pixel of a window that would show the same place if the picture were not magnified.
    #[expect(clippy::cast_possible_truncation, reason = "casts of floats saturate")]
    pub(crate) fn unmagnified(&self, pixel: [i32; 2], window: [u32; 2]) -> [i32; 2] {
        if !self.is_on() {
            return pixel;
        }
        let window = window.map(f64::from);
        let place = self.to_picture([0, 1].map(|axis| (f64::from(pixel[axis]) + 0.5) / window[axis]));
        [0, 1].map(|axis| (place[axis] * window[axis]).floor() as i32)
    }

    /// The visible place of a point of the picture, both in pixels of a window.
    #[expect(clippy::cast_possible_truncation, reason = "pixels of a window are small numbers")]
    pub(crate) fn magnified(&self, point: [f32; 2], window: [u32; 2]) -> [f32; 2] {
        let window = window.map(f64::from);
        let at = self.to_window([0, 1].map(|axis| f64::from(point[axis]) / window[axis]));
        [0, 1].map(|axis| (at[axis] * window[axis]) as f32)
    }

    /// Magnifies by a factor; the point at a place of the window stays there, as far as the picture reaches. No texel becomes larger than
    /// [`LARGEST`] pixels.
    pub(crate) fn zoom_about(&mut self, at: [f64; 2], factor: f64, Extents { picture, window }: Extents) {
        let place = self.to_picture(at);
        let most = (0..2).map(|axis| LARGEST * f64::from(picture[axis]) / f64::from(window[axis].max(1)));
        let zoom = (self.zoom() * factor).clamp(1.0, most.fold(f64::INFINITY, f64::min).max(1.0));
        if zoom.is_finite() {
            self.put(place, at, 1.0 / zoom);
        }
    }

    /// Moves the picture with the cursor, by shares of the window.
    pub(crate) fn pan(&mut self, by: [f64; 2]) {
        let origin = [0, 1].map(|axis| self.region.origin[axis] - by[axis] * self.region.size);
        self.put(origin, [0.0; 2], self.region.size);
    }

    /// Shows the whole picture.
    pub(crate) fn reset(&mut self) {
        *self = Self::default();
    }

    /// Brings a texel into sight, and magnifies it where it is tiny.
    pub(crate) fn reveal(&mut self, at: [u32; 2], Extents { picture, window }: Extents) {
        let place = [0, 1].map(|axis| (f64::from(at[axis]) + 0.5) / f64::from(picture[axis].max(1)));
        let seen = self.to_window(place).iter().all(|share| (0.0..1.0).contains(share));
        let pixels = (0..2).map(|axis| f64::from(window[axis]) / f64::from(picture[axis].max(1)) * self.zoom());
        let texel = pixels.fold(f64::INFINITY, f64::min);
        let factor = if texel < TINY { SEEN / texel } else { 1.0 };
        if factor > 1.0 || !seen {
            self.put(place, [0.5; 2], self.region.size / factor);
        }
    }

    /// Shows a place of the picture at a place of the window, as far as nothing beside the picture would be seen.
    fn put(&mut self, place: [f64; 2], at: [f64; 2], size: f64) {
        let origin = [0, 1].map(|axis| (place[axis] - at[axis] * size).clamp(0.0, 1.0 - size));
        self.region = Region { origin, size };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXTENTS: Extents = Extents { picture: [640, 320], window: [1280, 640] };

    fn close(a: [f64; 2], b: [f64; 2]) -> bool {
        (0..2).all(|axis| (a[axis] - b[axis]).abs() < 1e-9)
    }

    #[test]
    fn what_is_under_the_cursor_stays_there() {
        let mut magnifier = Magnifier::default();
        let cursor = [0.3, 0.8];
        for factor in [2.0, 8.0, 0.5, 3.0] {
            let before = magnifier.to_picture(cursor);
            magnifier.zoom_about(cursor, factor, EXTENTS);
            assert!(close(magnifier.to_picture(cursor), before), "{magnifier:?}");
            assert!(close(magnifier.to_window(before), cursor));
        }
        assert!((magnifier.zoom() - 24.0).abs() < 1e-9);
        // Out again, all of it is shown, wherever the cursor is.
        magnifier.zoom_about([1.0, 0.0], 1e-9, EXTENTS);
        assert_eq!((magnifier.region(), magnifier.is_on()), (Region::WHOLE, false));
    }

    #[test]
    fn a_magnified_pixel_shows_another_place() {
        let window = [640, 320];
        let mut magnifier = Magnifier::default();
        assert_eq!(magnifier.unmagnified([-3, 7], window), [-3, 7]);
        magnifier.zoom_about([0.0; 2], 4.0, EXTENTS);
        assert_eq!(magnifier.unmagnified([41, 320], window), [10, 80]);
        assert_eq!(magnifier.magnified([10.0, 80.0], window).map(f32::to_bits), [40.0_f32, 320.0].map(f32::to_bits));
    }

    #[test]
    fn a_texel_has_at_most_so_many_pixels_and_a_small_picture_is_not_made_smaller() {
        let mut magnifier = Magnifier::default();
        magnifier.zoom_about([0.5; 2], 1e9, EXTENTS);
        assert!((magnifier.zoom() - LARGEST / 2.0).abs() < 1e-9);
        let mut small = Magnifier::default();
        small.zoom_about([0.5; 2], 4.0, Extents { picture: [2, 1], ..EXTENTS });
        assert!(!small.is_on(), "its texels are larger already");
        small.zoom_about([0.5; 2], f64::NAN, EXTENTS);
        assert!(!small.is_on(), "a device of the system may give anything");
    }

    #[test]
    fn the_picture_follows_the_cursor_up_to_its_edges() {
        let mut magnifier = Magnifier::default();
        magnifier.pan([0.5; 2]);
        assert!(!magnifier.is_on());
        magnifier.zoom_about([0.5; 2], 4.0, EXTENTS);
        let seen = magnifier.to_picture([0.25, 0.25]);
        magnifier.pan([0.1, -0.2]);
        assert!(close(magnifier.to_window(seen), [0.35, 0.05]));
        magnifier.pan([9.0, -9.0]);
        assert!(close(magnifier.region().origin, [0.0, 0.75]));
    }

    #[test]
    fn a_tiny_texel_is_magnified_and_one_in_sight_leaves_the_picture_as_it_is() {
        let mut magnifier = Magnifier::default();
        magnifier.reveal([3, 5], Extents { picture: [64, 32], ..EXTENTS });
        assert!(!magnifier.is_on(), "it has 20 pixels");
        let extents = Extents { picture: [1280, 640], ..EXTENTS };
        magnifier.reveal([640, 320], extents);
        assert!((magnifier.zoom() - SEEN).abs() < 1e-9);
        let middle = magnifier.to_window([640.5 / 1280.0, 320.5 / 640.0]);
        assert!(close(middle, [0.5; 2]), "{middle:?}");
        let before = magnifier;
        magnifier.reveal([642, 321], extents);
        assert_eq!(magnifier, before);
        magnifier.reveal([0, 0], extents);
        assert!(close(magnifier.region().origin, [0.0; 2]) && (magnifier.zoom() - SEEN).abs() < 1e-9);
    }
}

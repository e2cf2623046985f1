//! The part of the picture that fills the window.

use egui::{Pos2, Rect, Vec2, vec2};

/// The part of the picture that fills the window, and what is written on its texels.
#[derive(Clone, Debug, PartialEq)]
pub struct Magnified {
    /// Its top left corner, as shares of the picture's extent.
    pub origin: [f64; 2],
    /// Its width and height, as a share of the picture's: 1 is the whole.
    pub size: f64,
    /// Texels of the shown mip, across and down; `[0, 0]` where they are not known.
    pub extent: [u32; 2],
    /// Texels with their values, where they are large enough to be read.
    pub values: Vec<WrittenTexel>,
}

/// A texel whose values are written on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenTexel {
    /// From the top left.
    pub at: [u32; 2],
    /// A line for each channel.
    pub lines: Vec<String>,
}

impl Default for Magnified {
    fn default() -> Self {
        Self { origin: [0.0; 2], size: 1.0, extent: [0; 2], values: Vec::new() }
    }
}

impl Magnified {
    /// Points of a texel along both axes, in a window of this area.
    #[expect(clippy::cast_possible_truncation, reason = "points of a window are small numbers")]
    pub(crate) fn texel(&self, area: Rect) -> Vec2 {
        let along =
            |axis: usize| (f64::from(area.size()[axis]) / (f64::from(self.extent[axis].max(1)) * self.size)) as f32;
        vec2(along(0), along(1))
    }

    /// The point of the window where a place of the picture is seen, in texels from the top left. It may lie outside of the window.
    #[expect(clippy::cast_possible_truncation, reason = "points of a window are small numbers")]
    pub(crate) fn point(&self, area: Rect, place: [f64; 2], extent: [u32; 2]) -> Pos2 {
        let along = |axis: usize| {
            let share = place[axis] / f64::from(extent[axis].max(1));
            ((share - self.origin[axis]) / self.size * f64::from(area.size()[axis])) as f32
        };
        area.min + vec2(along(0), along(1))
    }
}

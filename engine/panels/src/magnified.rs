//! The grid of a magnified picture, and the values of its texels.

use egui::{Align2, Color32, Context, FontId, LayerId, Painter, Rect, Stroke, pos2};

use crate::view::{Magnified, WrittenTexel};

/// Pixels of a texel from which on its edges are drawn.
const GRID: f32 = 8.0;

/// Points of the largest and of the smallest letters that values are written in.
const LETTERS: [f32; 2] = [13.0, 6.5];

/// Draws both over the picture, which is in this area, below all panels.
pub(crate) fn show(ctx: &Context, area: Rect, magnified: &Magnified) {
    let scale = ctx.pixels_per_point();
    let texel = magnified.texel(area);
    if magnified.size >= 1.0 || magnified.extent.contains(&0) || texel.min_elem() * scale < GRID {
        return;
    }
    let painter = ctx.layer_painter(LayerId::background()).with_clip_rect(area);
    grid(&painter, magnified, area, 1.0 / scale);
    for written in &magnified.values {
        write(&painter, magnified, area, written);
    }
}

/// Lines between texels, dark beside light, so that they are seen on any picture.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "lines of a picture are 32-bit numbers")]
fn grid(painter: &Painter, magnified: &Magnified, area: Rect, pixel: f32) {
    for axis in 0..2 {
        let extent = f64::from(magnified.extent[axis]);
        let first = (magnified.origin[axis] * extent).ceil() as u32;
        let last = ((magnified.origin[axis] + magnified.size) * extent).floor() as u32;
        for line in first..=last {
            let mut place = [0.0; 2];
            place[axis] = f64::from(line);
            let at = magnified.point(area, place, magnified.extent)[axis];
            for (offset, color) in [(0.0, Color32::from_black_alpha(110)), (pixel, Color32::from_white_alpha(45))] {
                let stroke = Stroke::new(pixel, color);
                if axis == 0 {
                    painter.vline(at + offset, area.y_range(), stroke);
                } else {
                    painter.hline(area.x_range(), at + offset, stroke);
                }
            }
        }
    }
}

fn write(painter: &Painter, magnified: &Magnified, area: Rect, written: &WrittenTexel) {
    let [x, y] = written.at.map(f64::from);
    let corner = |x, y| magnified.point(area, [x, y], magnified.extent);
    let square = Rect::from_min_max(corner(x, y), corner(x + 1.0, y + 1.0));
    let longest = written.lines.iter().map(|line| line.chars().count()).max().unwrap_or(0).max(1) as f32;
    let lines = written.lines.len().max(1) as f32;
    // A digit is about half as wide as its line is high.
    let size = (square.height() / (lines * 1.2)).min(square.width() / (longest * 0.62)).min(LETTERS[0]);
    if size < LETTERS[1] || !square.intersects(area) {
        return;
    }
    let ground = egui::vec2(longest * 0.6 * size, lines * 1.15 * size);
    painter.rect_filled(Rect::from_center_size(square.center(), ground), 1.0, Color32::from_black_alpha(150));
    for (index, line) in written.lines.iter().enumerate() {
        let middle = square.center().y + (index as f32 - (lines - 1.0) / 2.0) * size * 1.1;
        let at = pos2(square.center().x, middle);
        painter.text(at, Align2::CENTER_CENTER, line, FontId::monospace(size), Color32::WHITE);
    }
}

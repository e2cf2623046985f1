//! A caption in a picture: white letters on a darkened band, as high as a twentieth of the picture.

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};
use raxel_execute::Picture;
use raxel_runtime::timeline::{CaptionEdge, CaptionText};

/// Draws a line into a picture. A line that is too long becomes smaller.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "places are inside the picture, and casts of floats saturate"
)]
pub(super) fn draw(picture: &mut Picture, line: &CaptionText) {
    let Ok(font) = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT) else { return };
    let (width, height) = (picture.width as f32, picture.height as f32);
    let wanted = (height / 20.0).max(8.0);
    let long = length(&font, wanted, &line.text);
    let size = wanted * (width * 0.94 / long.max(1.0)).min(1.0);
    let band = (wanted * 1.6).ceil();
    let top = if line.place == CaptionEdge::Top { 0.0 } else { (height - band).max(0.0) };
    darken(picture, top as u32, (top + band) as u32);

    let scale = PxScale::from(size);
    let scaled = font.as_scaled(scale);
    let baseline = top + (band - size) / 2.0 + scaled.ascent() * size / scaled.height().max(1.0);
    let mut x = (width - length(&font, size, &line.text)) / 2.0;
    let mut last = None;
    for letter in line.text.chars() {
        let id = font.glyph_id(letter);
        x += last.map_or(0.0, |last| scaled.kern(last, id));
        let glyph = id.with_scale_and_position(scale, point(x, baseline));
        x += scaled.h_advance(id);
        last = Some(id);
        let Some(outline) = font.outline_glyph(glyph) else { continue };
        let bounds = outline.px_bounds();
        outline.draw(|dx, dy, cover| {
            let place = [bounds.min.x + dx as f32, bounds.min.y + dy as f32];
            if place[0] >= 0.0 && place[1] >= 0.0 && place[0] < width && place[1] < height {
                let at = (place[1] as usize * picture.width as usize + place[0] as usize) * 4;
                for channel in &mut picture.rgba[at..at + 3] {
                    let value = f32::from(*channel);
                    *channel = (value + (255.0 - value) * cover.clamp(0.0, 1.0)).round() as u8;
                }
            }
        });
    }
}

/// Pixels of a line of text.
fn length(font: &FontRef<'_>, size: f32, text: &str) -> f32 {
    let scaled = font.as_scaled(PxScale::from(size));
    let mut last = None;
    let letter = |letter| {
        let id = font.glyph_id(letter);
        let kern = last.replace(id).map_or(0.0, |last| scaled.kern(last, id));
        kern + scaled.h_advance(id)
    };
    text.chars().map(letter).sum()
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of 255 is below 256")]
fn darken(picture: &mut Picture, from: u32, to: u32) {
    let row = picture.width as usize * 4;
    let rows = from.min(picture.height) as usize * row..to.min(picture.height) as usize * row;
    for pixel in picture.rgba[rows].chunks_exact_mut(4) {
        for channel in &mut pixel[..3] {
            *channel = (f32::from(*channel) * 0.4).round() as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(width: u32, height: u32) -> Picture {
        let rgba = (0..width * height).flat_map(|_| [100, 100, 100, 255]).collect();
        Picture { width, height, rgba }
    }

    fn line(text: &str, top: bool) -> CaptionText {
        CaptionText { text: text.to_owned(), place: if top { CaptionEdge::Top } else { CaptionEdge::Bottom } }
    }

    #[test]
    fn letters_are_in_their_band_and_nowhere_else() {
        let mut picture = gray(400, 200);
        draw(&mut picture, &line("Bounce light", false));
        let rows: Vec<&[u8]> = picture.rgba.chunks_exact(1600).collect();
        let white = |row: &[u8]| row.chunks_exact(4).filter(|pixel| pixel[0] > 110).count();
        assert!(rows[..184].iter().all(|row| row.chunks_exact(4).all(|pixel| pixel[0] == 100)));
        assert!(rows[184..].iter().map(|row| white(row)).sum::<usize>() > 40);
        // The same at the top; both sides have the same room.
        let mut other = gray(400, 200);
        draw(&mut other, &line("Bounce light", true));
        assert!(other.rgba.chunks_exact(1600).skip(16).all(|row| row.chunks_exact(4).all(|pixel| pixel[0] == 100)));
    }

    #[test]
    fn long_lines_and_small_pictures_are_no_trouble() {
        for (width, height) in [(1, 1), (7, 300), (64, 5), (200, 100)] {
            let mut picture = gray(width, height);
            draw(&mut picture, &line(&"a very long line ".repeat(20), false));
            assert_eq!(picture.rgba.len() as u32, width * height * 4);
        }
        let mut picture = gray(200, 100);
        draw(&mut picture, &line("Привет, Welt 世界", true));
    }
}

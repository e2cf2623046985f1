//! The places of the texels behind a picture's figures, and the surroundings of one.

use raxel_execute::{Region, Texels};
use raxel_graph::checked::{Display, DisplayMap};
use raxel_panels::view::{WrittenTexel, Zoom};
use raxel_shader::interface::ScalarKind;
use raxel_world::srgb_from_linear;

/// The same place in a picture of another extent.
#[expect(clippy::cast_possible_truncation, reason = "the place is below `to`")]
pub(crate) fn scaled(at: [u32; 2], from: [u32; 2], to: [u32; 2]) -> [u32; 2] {
    let place = |axis: usize| {
        // Through the centre of the texel.
        let place = (2 * u64::from(at[axis]) + 1) * u64::from(to[axis]) / (2 * u64::from(from[axis].max(1)));
        (place as u32).min(to[axis].saturating_sub(1))
    };
    [place(0), place(1)]
}

/// The texels around one. Colours are shown as such, anything else by its channel in grey; NaN is magenta and infinity yellow.
pub(crate) fn zoom(texels: &Texels, at: [u32; 2], display: &Display) -> Zoom {
    let half = Zoom::SIDE / 2;
    let place = |middle: u32, index: u32| (middle + index).checked_sub(half);
    let color = |index: u32| {
        let (x, y) = (place(at[0], index % Zoom::SIDE)?, place(at[1], index / Zoom::SIDE)?);
        Some(color_of(texels.texel([x, y])?.0, texels.format.channels(), display))
    };
    Zoom { colors: (0..Zoom::SIDE * Zoom::SIDE).map(color).collect() }
}

/// The values of the texels that are seen in a region, a line for each channel.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the places are inside the picture")]
pub(crate) fn written(texels: &Texels, region: &Region) -> Vec<WrittenTexel> {
    let span = |axis: usize, extent: u32| {
        let (first, extent) = (region.origin[axis] * f64::from(extent), f64::from(extent));
        (first.floor() as u32)..((first + region.size * extent).ceil().min(extent) as u32)
    };
    let channels = texels.format.channels() as usize;
    let write = |at: [u32; 2]| {
        let integers = texels.integer(at);
        let (floats, _) = texels.texel(at)?;
        let line = |channel: usize| match (texels.scalar(), integers) {
            (ScalarKind::Int, Some(integers)) => integers[channel].cast_signed().to_string(),
            (ScalarKind::Uint, Some(integers)) => integers[channel].to_string(),
            _ => short(floats[channel]),
        };
        Some(WrittenTexel { at, lines: (0..channels).map(line).collect() })
    };
    let rows = span(1, texels.height);
    rows.flat_map(|y| span(0, texels.width).filter_map(move |x| write([x, y])).collect::<Vec<_>>()).collect()
}

/// A number in at most some seven characters.
fn short(value: f32) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        0.001..1.0 => format!("{value:.3}"),
        1.0..100.0 => format!("{value:.2}"),
        100.0..100_000.0 => format!("{value:.0}"),
        size if size.is_finite() => format!("{value:.0e}"),
        _ => value.to_string(),
    }
}

fn color_of(texel: [f32; 4], channels: u32, display: &Display) -> [u8; 3] {
    let [r, g, b, _] = texel;
    let colored = channels >= 3 && matches!(display.map, DisplayMap::Color | DisplayMap::Raw);
    let one = texel[display.channel.min(3) as usize];
    let shown = if colored { [r, g, b] } else { [one; 3] };
    if shown.iter().any(|value| value.is_nan()) {
        return [255, 0, 255];
    }
    if shown.iter().any(|value| value.is_infinite()) {
        return [255, 255, 0];
    }
    let [low, high] = display.range;
    let in_range = shown.map(|value| ((value - low) / (high - low).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0));
    let raw = display.map == DisplayMap::Raw;
    in_range.map(if colored && !raw { srgb_from_linear } else { byte })
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the value is in 0…1")]
fn byte(value: f32) -> u8 {
    (value * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use raxel_shader::format::Format;

    use super::*;

    /// Three by two: 1, NaN, infinity; 3, NaN, 1.
    fn texels() -> Texels {
        let values = [1.0, f32::NAN, f32::INFINITY, 3.0, f32::NAN, 1.0_f32];
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        Texels { format: Format::R32f, width: 3, height: 2, bytes }
    }

    #[test]
    fn a_place_is_the_same_in_another_extent() {
        assert_eq!(scaled([5, 7], [8, 8], [8, 8]), [5, 7]);
        assert_eq!(scaled([5, 7], [8, 8], [4, 2]), [2, 1]);
        assert_eq!(scaled([1, 0], [2, 1], [8, 8]), [6, 4]);
    }

    #[test]
    fn the_values_of_what_is_seen_are_written() {
        let right = Region { origin: [0.5, 0.0], size: 0.5 };
        let lines: Vec<_> = written(&texels(), &right).into_iter().map(|found| (found.at, found.lines)).collect();
        assert_eq!(lines, [([1, 0], vec!["NaN".to_owned()]), ([2, 0], vec!["inf".to_owned()])]);
        let integers = Texels { format: Format::Rg16i, width: 1, height: 1, bytes: vec![0xff, 0xff, 2, 0] };
        assert_eq!(written(&integers, &Region::WHOLE)[0].lines, ["-1", "2"]);
        let said = [0.0, -0.0123, 3.146, 720.4, 1e-9, -2.5e8, f32::NEG_INFINITY].map(short);
        assert_eq!(said, ["0", "-0.012", "3.15", "720", "1e-9", "-2e8", "-inf"]);
    }

    #[test]
    fn what_lies_around_a_texel_is_seen() {
        let display = Display { map: DisplayMap::Turbo, range: [1.0, 3.0], channel: 0 };
        let zoom = zoom(&texels(), [1, 0], &display);
        let middle = (Zoom::SIDE * Zoom::SIDE / 2) as usize;
        let row = Zoom::SIDE as usize;
        assert_eq!(
            zoom.colors[middle - 2..=middle + 2],
            [None, Some([0; 3]), Some([255, 0, 255]), Some([255, 255, 0]), None]
        );
        assert_eq!(zoom.colors[middle + row - 1], Some([255; 3]));
        assert_eq!(zoom.colors[middle - row], None);
    }
}

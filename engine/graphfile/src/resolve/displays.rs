//! Resolves `display`: how the numbers of a target become a picture.

use raxel_diagnostics::{Diagnostic, Spanned, codes};
use raxel_graph::checked::{self, DisplayMap};
use raxel_shader::format::Format;
use raxel_shader::interface::ScalarKind;

use crate::model::Display;

/// `display`, with the format's own map where the file names none.
#[expect(clippy::cast_possible_truncation, reason = "the reader has checked that the ends differ as 32-bit floats")]
pub(super) fn show(
    name: &str,
    display: &Spanned<Display>,
    format: Format,
    found: &mut Vec<Diagnostic>,
) -> Option<checked::Display> {
    let (channels, float) = (format.channels(), format.scalar() == ScalarKind::Float);
    let Display { map, range, channel } = &display.value;
    let map = map.unwrap_or(default_map(format));
    let needs = match map {
        DisplayMap::Color | DisplayMap::Normal if !float || channels < 3 => "a float format with 3 or 4 channels",
        DisplayMap::Raw if !float => "a float or normalised format",
        DisplayMap::Id | DisplayMap::Integer if float => "an integer format",
        _ => "",
    };
    let word = DisplayMap::WORDS.iter().find(|known| known.1 == map).map_or("", |known| known.0);
    if !needs.is_empty() {
        found.push(
            Diagnostic::error(
                codes::graph::DISPLAY,
                format!("target `{name}` is `{}`, which the display map `{word}` cannot show", format.name()),
            )
            .label(display.span.clone(), format!("`{word}` needs {needs}")),
        );
        return None;
    }
    if let Some(channel) = channel.as_ref().filter(|channel| channel.value >= channels) {
        found.push(
            Diagnostic::error(
                codes::graph::DISPLAY,
                format!("target `{name}` is `{}`, which has no channel {}", format.name(), channel.value),
            )
            .label(channel.span.clone(), format!("the last channel is {}", channels - 1)),
        );
        return None;
    }
    if range.is_some() && matches!(map, DisplayMap::Raw | DisplayMap::Normal | DisplayMap::Id) {
        let message = format!("the `range` of target `{name}` does nothing: the display map `{word}` has none");
        found.push(
            Diagnostic::warning(codes::graph::DISPLAY, message)
                .label(display.span.clone(), format!("`{word}` shows values as they are"))
                .help("take `range` out, or choose `color`, `gray`, `turbo` or `viridis`"),
        );
    }
    let range = range.map_or([0.0, 1.0], |range| range.map(|end| end as f32));
    Some(checked::Display { map, range, channel: channel.as_ref().map_or(0, |channel| channel.value) })
}

/// The map of a format without one in the file.
fn default_map(format: Format) -> DisplayMap {
    match (format.scalar(), format.channels()) {
        (ScalarKind::Int | ScalarKind::Uint, _) => DisplayMap::Id,
        (ScalarKind::Float, 1 | 2) => DisplayMap::Gray,
        (ScalarKind::Float, _) if is_unorm(format) => DisplayMap::Raw,
        (ScalarKind::Float, _) => DisplayMap::Color,
    }
}

fn is_unorm(format: Format) -> bool {
    matches!(format, Format::Rgba16 | Format::Rgb10A2 | Format::Rgba8)
}

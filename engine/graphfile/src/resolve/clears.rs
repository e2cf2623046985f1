//! Resolves `init` and `clear`: the values that fill targets and buffers.

use raxel_diagnostics::{Diagnostic, codes};
use raxel_graph::checked::Clear;
use raxel_shader::format::Format;
use raxel_shader::interface::ScalarKind;

use crate::literal::{describe, float, integer};
use crate::model::{Data, Literal};

/// A fill value of a target: one number for every channel, or one for each.
pub(super) fn colour(
    name: &str,
    key: &str,
    literal: &Literal,
    format: Format,
    found: &mut Vec<Diagnostic>,
) -> Option<Clear> {
    let channels = format.channels() as usize;
    let one = std::slice::from_ref(literal);
    let elements = match &literal.data {
        Data::Array(elements) => elements.as_slice(),
        _ => one,
    };
    let single = elements.len() == 1 && !matches!(literal.data, Data::Array(_));
    let clear = (single || elements.len() == channels)
        .then(|| match format.scalar() {
            ScalarKind::Float => broadcast(elements, channels, |_, element| float(element)).map(Clear::Float),
            ScalarKind::Int => broadcast(elements, channels, |channel, element| {
                let half = 1_i64 << (channel_bits(format, channel) - 1);
                integer(element).filter(|v: &i32| (-half..half).contains(&i64::from(*v)))
            })
            .map(Clear::Int),
            ScalarKind::Uint => broadcast(elements, channels, |channel, element| {
                integer(element).filter(|v: &u32| u64::from(*v) < 1 << channel_bits(format, channel))
            })
            .map(Clear::Uint),
        })
        .flatten();
    if clear.is_none() {
        let kind = match format.scalar() {
            ScalarKind::Float => "float",
            ScalarKind::Int => "integer",
            ScalarKind::Uint => "unsigned integer",
        };
        let bits = channel_bits(format, 0);
        found.push(
            Diagnostic::error(
                codes::graph::FILL_VALUE,
                format!("`{key}` of target `{name}` is {}, which `{}` cannot hold", describe(literal), format.name()),
            )
            .label(literal.span.clone(), "")
            .help(match channels {
                1 => format!("`{}` takes one {kind} of {bits} bits", format.name()),
                n => format!("`{}` takes {n} {kind}s of {bits} bits, or one for all channels", format.name()),
            }),
        );
    }
    clear
}

/// Bits of a channel of an integer format.
fn channel_bits(format: Format, channel: usize) -> u32 {
    match (format, channel) {
        (Format::Rgb10A2 | Format::Rgb10A2ui, 3) => 2,
        (Format::Rgb10A2 | Format::Rgb10A2ui, _) => 10,
        _ => format.bytes() * 8 / format.channels(),
    }
}

/// One element for every channel, or an element a channel; channels that the format lacks are zero.
fn broadcast<T: Copy + Default>(
    elements: &[Literal],
    channels: usize,
    value: impl Fn(usize, &Literal) -> Option<T>,
) -> Option<[T; 4]> {
    let mut all = [T::default(); 4];
    for (channel, out) in all.iter_mut().enumerate().take(channels) {
        *out = value(channel, elements.get(channel).or(elements.first())?)?;
    }
    Some(all)
}

/// The fill pattern of a buffer: 32 bits, written as a signed or unsigned integer.
pub(super) fn pattern(name: &str, key: &str, literal: &Literal, found: &mut Vec<Diagnostic>) -> Option<u32> {
    let pattern = integer::<u32>(literal).or_else(|| integer::<i32>(literal).map(i32::cast_unsigned));
    if pattern.is_none() {
        let diagnostic = Diagnostic::error(
            codes::graph::FILL_VALUE,
            format!("`{key}` of buffer `{name}` is {}, not a 32-bit integer", describe(literal)),
        )
        .label(literal.span.clone(), "a buffer is filled with one 32-bit pattern");
        found.push(match float(literal) {
            Some(value) if matches!(literal.data, Data::Float(_)) => {
                diagnostic.help(format!("the pattern of the float {value:?} is {:#010x}", value.to_bits()))
            }
            _ => diagnostic,
        });
    }
    pattern
}

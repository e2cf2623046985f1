//! Texels of every format as numbers on the CPU (Vulkan 1.3, section 43.3, "Format Definition").

use half::f16;
use raxel_shader::format::Format;
use raxel_shader::interface::ScalarKind;

/// How the channels of a format are laid out: bits of each channel from the least significant, and their kind.
enum Layout {
    /// Little-endian channels of so many bits.
    Even(u32),
    /// 10, 10, 10 and 2 bits in one word.
    Packed10,
    /// Unsigned small floats of 11, 11 and 10 bits in one word.
    Small11,
}

fn layout(format: Format) -> Layout {
    match format {
        Format::Rgb10A2 | Format::Rgb10A2ui => Layout::Packed10,
        Format::R11fG11fB10f => Layout::Small11,
        _ => Layout::Even(format.bytes() * 8 / format.channels()),
    }
}

/// Bits of the channels, absent ones 0.
pub fn bits(format: Format, texel: &[u8]) -> [u32; 4] {
    let mut word = [0u8; 16];
    word[..texel.len()].copy_from_slice(texel);
    let word = u128::from_le_bytes(word);
    let widths = match layout(format) {
        Layout::Even(width) => [width; 4],
        Layout::Packed10 => [10, 10, 10, 2],
        Layout::Small11 => [11, 11, 10, 0],
    };
    let mut channels = [0; 4];
    let mut shift = 0;
    for (channel, width) in channels.iter_mut().zip(widths).take(format.channels() as usize) {
        *channel = ((word >> shift) & ((1u128 << width) - 1)) as u32;
        shift += width;
    }
    channels
}

fn width(format: Format, channel: usize) -> u32 {
    match layout(format) {
        Layout::Even(width) => width,
        Layout::Packed10 => [10, 10, 10, 2][channel],
        Layout::Small11 => [11, 11, 10, 0][channel],
    }
}

fn sign_extend(value: u32, width: u32) -> i32 {
    ((value << (32 - width)) as i32) >> (32 - width)
}

/// One texel of an integer format; signed channels are sign-extended and given by their bits.
pub fn integers(format: Format, texel: &[u8]) -> [u32; 4] {
    let mut channels = bits(format, texel);
    if format.scalar() == ScalarKind::Int {
        for (i, channel) in channels.iter_mut().enumerate().take(format.channels() as usize) {
            *channel = sign_extend(*channel, width(format, i)) as u32;
        }
    }
    if format.channels() < 4 {
        channels[3] = 1;
    }
    channels
}

/// One texel of any format as floats.
pub fn floats(format: Format, texel: &[u8]) -> [f32; 4] {
    let raw = bits(format, texel);
    let mut channels = [0.0, 0.0, 0.0, 1.0];
    for (i, channel) in channels.iter_mut().enumerate().take(format.channels() as usize) {
        let width = width(format, i);
        *channel = match (format.scalar(), is_float(format), is_signed_normalised(format)) {
            (ScalarKind::Int, ..) => sign_extend(raw[i], width) as f32,
            (ScalarKind::Uint, ..) => raw[i] as f32,
            (ScalarKind::Float, true, _) if width == 32 => f32::from_bits(raw[i]),
            (ScalarKind::Float, true, _) if width == 16 => f16::from_bits(raw[i] as u16).to_f32(),
            // An unsigned float of 11 or 10 bits has the exponent of a half, no sign, and the upper bits of its mantissa.
            (ScalarKind::Float, true, _) => f16::from_bits((raw[i] << (15 - width)) as u16).to_f32(),
            (ScalarKind::Float, false, true) => {
                (f64::from(sign_extend(raw[i], width)) / ((1u64 << (width - 1)) - 1) as f64).max(-1.0) as f32
            }
            (ScalarKind::Float, false, false) => (f64::from(raw[i]) / ((1u64 << width) - 1) as f64) as f32,
        };
    }
    channels
}

fn is_float(format: Format) -> bool {
    let name = format.name();
    name.ends_with('f')
}

fn is_signed_normalised(format: Format) -> bool {
    format.name().ends_with("_snorm")
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "every value is exact")]
mod tests {
    use super::*;

    #[test]
    fn halves_and_small_floats() {
        let half = |bits: u16| floats(Format::R16f, &bits.to_le_bytes())[0];
        assert_eq!(half(0x3c00), 1.0);
        assert_eq!(half(0xc000), -2.0);
        assert_eq!(half(0x0001), 5.960_464_5e-8);
        assert_eq!(half(0x7c00), f32::INFINITY);
        assert!(half(0x7e00).is_nan());
        // 1.0, 2.0 and 0.5.
        let word: u32 = (15 << 6) | ((16 << 6) << 11) | ((14 << 5) << 22);
        assert_eq!(floats(Format::R11fG11fB10f, &word.to_le_bytes()), [1.0, 2.0, 0.5, 1.0]);
    }

    #[test]
    fn normalised_and_integer_channels() {
        assert_eq!(floats(Format::Rgba8, &[255, 0, 51, 255]), [1.0, 0.0, 0.2, 1.0]);
        assert_eq!(floats(Format::R8Snorm, &[0x80])[0], -1.0);
        assert_eq!(floats(Format::R8Snorm, &[0x7f])[0], 1.0);
        assert_eq!(integers(Format::Rg16i, &[0xff, 0xff, 2, 0]), [u32::MAX, 2, 0, 1]);
        assert_eq!(integers(Format::Rgb10A2ui, &0xc000_0c01u32.to_le_bytes()), [1, 3, 0, 3]);
        assert_eq!(floats(Format::R8i, &[0xfe])[0], -2.0);
    }
}

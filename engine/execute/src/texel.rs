//! Texels of every format as numbers on the CPU (Vulkan 1.3, section 43.3, "Format Definition").

use half::f16;
use raxel_shader::format::Format;
use raxel_shader::interface::ScalarKind;

/// Reads texels of one format. The properties of the format are looked up once, not for each texel.
pub(crate) struct Decoder {
    channels: usize,
    /// Bits of each channel, from the least significant.
    widths: [u32; 4],
    /// The meaning of the bits.
    meaning: Meaning,
}

#[derive(Clone, Copy, PartialEq)]
enum Meaning {
    Signed,
    Unsigned,
    Float,
    SignedNormalised,
    UnsignedNormalised,
}

impl Decoder {
    pub(crate) fn of(format: Format) -> Self {
        let channels = format.channels();
        let widths = match format {
            Format::Rgb10A2 | Format::Rgb10A2ui => [10, 10, 10, 2],
            Format::R11fG11fB10f => [11, 11, 10, 0],
            _ => [format.bytes() * 8 / channels; 4],
        };
        let name = format.name();
        let meaning = match format.scalar() {
            ScalarKind::Int => Meaning::Signed,
            ScalarKind::Uint => Meaning::Unsigned,
            ScalarKind::Float if name.ends_with('f') => Meaning::Float,
            ScalarKind::Float if name.ends_with("_snorm") => Meaning::SignedNormalised,
            ScalarKind::Float => Meaning::UnsignedNormalised,
        };
        Self { channels: channels as usize, widths, meaning }
    }

    /// Bits of the channels, absent ones 0.
    #[expect(clippy::cast_possible_truncation, reason = "a channel has at most 32 bits")]
    pub(crate) fn bits(&self, texel: &[u8]) -> [u32; 4] {
        let mut channels = [0; 4];
        if self.widths[0] == 32 {
            for (channel, &bytes) in channels.iter_mut().zip(texel.as_chunks().0) {
                *channel = u32::from_le_bytes(bytes);
            }
            return channels;
        }
        let mut word = [0; 8];
        word[..texel.len()].copy_from_slice(texel);
        let mut word = u64::from_le_bytes(word);
        for (channel, width) in channels.iter_mut().zip(self.widths).take(self.channels) {
            *channel = (word & ((1 << width) - 1)) as u32;
            word >>= width;
        }
        channels
    }

    /// One texel of an integer format; signed channels are sign-extended and given by their bits.
    pub(crate) fn integers(&self, texel: &[u8]) -> [u32; 4] {
        let mut channels = self.bits(texel);
        if self.meaning == Meaning::Signed {
            for (channel, width) in channels.iter_mut().zip(self.widths).take(self.channels) {
                *channel = sign_extend(*channel, width).cast_unsigned();
            }
        }
        if self.channels < 4 {
            channels[3] = 1;
        }
        channels
    }

    /// One texel of any format as floats.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "halves have 16 bits, and normalised values are rounded to 32-bit floats"
    )]
    pub(crate) fn floats(&self, texel: &[u8]) -> [f32; 4] {
        let raw = self.bits(texel);
        let mut channels = [0.0, 0.0, 0.0, 1.0];
        for ((channel, raw), width) in channels.iter_mut().zip(raw).zip(self.widths).take(self.channels) {
            *channel = match self.meaning {
                Meaning::Signed => sign_extend(raw, width) as f32,
                Meaning::Unsigned => raw as f32,
                Meaning::Float if width == 32 => f32::from_bits(raw),
                Meaning::Float if width == 16 => f16::from_bits(raw as u16).to_f32(),
                // An unsigned float of 11 or 10 bits has the exponent of a half, no sign, and the upper bits of its mantissa.
                Meaning::Float => f16::from_bits((raw << (15 - width)) as u16).to_f32(),
                Meaning::SignedNormalised => {
                    (f64::from(sign_extend(raw, width)) / ((1u64 << (width - 1)) - 1) as f64).max(-1.0) as f32
                }
                Meaning::UnsignedNormalised => (f64::from(raw) / ((1u64 << width) - 1) as f64) as f32,
            };
        }
        channels
    }
}

fn sign_extend(value: u32, width: u32) -> i32 {
    (value << (32 - width)).cast_signed() >> (32 - width)
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "every value is exact")]
mod tests {
    use super::*;

    #[test]
    fn halves_and_small_floats() {
        let half = |bits: u16| Decoder::of(Format::R16f).floats(&bits.to_le_bytes())[0];
        assert_eq!(half(0x3c00), 1.0);
        assert_eq!(half(0xc000), -2.0);
        assert_eq!(half(0x0001), 5.960_464_5e-8);
        assert_eq!(half(0x7c00), f32::INFINITY);
        assert!(half(0x7e00).is_nan());
        // 1.0, 2.0 and 0.5.
        let word: u32 = (15 << 6) | ((16 << 6) << 11) | ((14 << 5) << 22);
        assert_eq!(Decoder::of(Format::R11fG11fB10f).floats(&word.to_le_bytes()), [1.0, 2.0, 0.5, 1.0]);
    }

    #[test]
    fn normalised_and_integer_channels() {
        assert_eq!(Decoder::of(Format::Rgba8).floats(&[255, 0, 51, 255]), [1.0, 0.0, 0.2, 1.0]);
        assert_eq!(Decoder::of(Format::R8Snorm).floats(&[0x80])[0], -1.0);
        assert_eq!(Decoder::of(Format::R8Snorm).floats(&[0x7f])[0], 1.0);
        assert_eq!(Decoder::of(Format::Rg16i).integers(&[0xff, 0xff, 2, 0]), [u32::MAX, 2, 0, 1]);
        assert_eq!(Decoder::of(Format::Rgb10A2ui).integers(&0xc000_0c01u32.to_le_bytes()), [1, 3, 0, 3]);
        assert_eq!(Decoder::of(Format::R8i).floats(&[0xfe])[0], -2.0);
    }
}

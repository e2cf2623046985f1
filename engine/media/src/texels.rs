//! Texels of files: channels of a format to and from numbers.

use half::f16;
use raxel_shader::format::Format;

/// How one channel of a format that files can have is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Channel {
    Unorm8,
    Unorm16,
    Half,
    Float,
    Uint8,
    Uint16,
    Uint32,
}

/// The formats that files can be brought into: the channel, and the formats of one, two and four of them.
const FORMATS: [(Channel, [Format; 3]); 7] = [
    (Channel::Unorm8, [Format::R8, Format::Rg8, Format::Rgba8]),
    (Channel::Unorm16, [Format::R16, Format::Rg16, Format::Rgba16]),
    (Channel::Half, [Format::R16f, Format::Rg16f, Format::Rgba16f]),
    (Channel::Float, [Format::R32f, Format::Rg32f, Format::Rgba32f]),
    (Channel::Uint8, [Format::R8ui, Format::Rg8ui, Format::Rgba8ui]),
    (Channel::Uint16, [Format::R16ui, Format::Rg16ui, Format::Rgba16ui]),
    (Channel::Uint32, [Format::R32ui, Format::Rg32ui, Format::Rgba32ui]),
];

impl Channel {
    /// The format of `channels` of these channels; three are four with 1 as the last.
    pub(crate) fn format(self, channels: usize) -> Format {
        let index = match channels {
            1 => 0,
            2 => 1,
            _ => 2,
        };
        FORMATS.iter().find(|(channel, _)| *channel == self).map_or(Format::Rgba32f, |(_, formats)| formats[index])
    }

    /// The channel of a format; `None` of one that files are not brought into.
    pub(crate) fn of(format: Format) -> Option<Self> {
        FORMATS.iter().find(|(_, formats)| formats.contains(&format)).map(|(channel, _)| *channel)
    }

    /// Whether it holds whole numbers rather than amounts, so that nothing lies between two of them.
    pub(crate) fn is_integer(self) -> bool {
        matches!(self, Self::Uint8 | Self::Uint16 | Self::Uint32)
    }

    /// Bytes.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::Unorm8 | Self::Uint8 => 1,
            Self::Unorm16 | Self::Half | Self::Uint16 => 2,
            Self::Float | Self::Uint32 => 4,
        }
    }

    /// Appends a number; one out of range is clamped. Of unorm channels, 1 is the largest number.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "casts of floats saturate: what a channel cannot hold is clamped"
    )]
    pub(crate) fn put(self, value: f64, to: &mut Vec<u8>) {
        match self {
            Self::Unorm8 => to.push((value.clamp(0.0, 1.0) * 255.0).round() as u8),
            Self::Unorm16 => to.extend(((value.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes()),
            Self::Half => to.extend(f16::from_f64(value).to_le_bytes()),
            Self::Float => to.extend((value as f32).to_le_bytes()),
            Self::Uint8 => to.push(value as u8),
            Self::Uint16 => to.extend((value as u16).to_le_bytes()),
            Self::Uint32 => to.extend((value as u32).to_le_bytes()),
        }
    }

    /// The number that `put` would take for the channel at an index.
    #[expect(clippy::cast_possible_truncation, reason = "a half has 16 bits")]
    pub(crate) fn get(self, bytes: &[u8], index: usize) -> f64 {
        let at = index * self.bytes();
        let word =
            |count: usize| bytes[at..at + count].iter().rev().fold(0_u32, |word, byte| word << 8 | u32::from(*byte));
        match self {
            Self::Unorm8 => f64::from(word(1)) / 255.0,
            Self::Unorm16 => f64::from(word(2)) / 65535.0,
            Self::Half => f16::from_bits(word(2) as u16).to_f64(),
            Self::Float => f64::from(f32::from_bits(word(4))),
            Self::Uint8 => f64::from(word(1)),
            Self::Uint16 => f64::from(word(2)),
            Self::Uint32 => f64::from(word(4)),
        }
    }
}

/// Linear light of an sRGB value in 0…1 (IEC 61966-2-1).
pub(crate) fn linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "every number is exact in its channel")]
mod tests {
    use super::*;

    #[test]
    fn channels_give_back_what_they_hold() {
        let halves = [0.0, 0.25, 1.0];
        for (channel, values) in [
            (Channel::Unorm8, [0.0, 51.0 / 255.0, 1.0]),
            (Channel::Unorm16, [0.0, 257.0 / 65535.0, 1.0]),
            (Channel::Half, halves),
            (Channel::Float, halves),
            (Channel::Uint8, [0.0, 7.0, 255.0]),
            (Channel::Uint16, [0.0, 300.0, 65535.0]),
            (Channel::Uint32, [0.0, 70000.0, 4_294_967_295.0]),
        ] {
            let mut bytes = Vec::new();
            for value in values {
                channel.put(value, &mut bytes);
            }
            assert_eq!(bytes.len(), 3 * channel.bytes());
            assert_eq!([0, 1, 2].map(|index| channel.get(&bytes, index)), values, "{channel:?}");
            for channels in [1, 2, 4] {
                assert_eq!(Channel::of(channel.format(channels)), Some(channel));
                assert_eq!(channel.format(channels).bytes() as usize, channels * channel.bytes());
            }
        }
        assert_eq!(Channel::of(Format::R11fG11fB10f), None);
    }

    #[test]
    fn srgb_becomes_linear_light() {
        assert_eq!(linear(0.0), 0.0);
        assert_eq!(linear(1.0), 1.0);
        assert!((linear(0.5) - 0.214_041).abs() < 1e-6);
        assert!((linear(0.04045) - linear(0.040_450_1)).abs() < 1e-6);
    }
}

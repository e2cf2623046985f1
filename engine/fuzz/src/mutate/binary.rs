//! Changes of bytes: bits, numbers on the edge of something, and ranges that are gone, doubled or those of another input.
#![expect(clippy::cast_possible_truncation, reason = "random bytes are the lowest of random bits")]

use std::ops::Range;

use raxel_world::random::SplitMix64;

use super::pick;

/// Numbers of 32 bits that are on the edge of something.
pub(super) const NUMBERS: [u32; 18] = [
    0,
    1,
    2,
    3,
    4,
    0x7f,
    0x80,
    0xff,
    0x100,
    0x7fff,
    0x8000,
    0xffff,
    0x1_0000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
    0x0101_0101,
];

/// Changes bytes one to eight times.
pub(super) fn mutated(input: &[u8], other: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..=random.below(8) {
        change(&mut bytes, other, random);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, other: &[u8], random: &mut SplitMix64) {
    let at = random.index(bytes.len() + 1);
    match random.below(10) {
        0 | 1 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
        2 if at < bytes.len() => bytes[at] = random.bits() as u8,
        3..=5 => {
            let number = pick(random, &NUMBERS).copied().unwrap_or_default();
            let number = if random.below(2) == 0 { number.to_le_bytes() } else { number.to_be_bytes() };
            let width = *pick(random, &[1, 2, 4]).unwrap_or(&4);
            // Numbers are mostly aligned.
            let at = if random.below(4) == 0 { at } else { at & !3 };
            let end = (at + width).min(bytes.len());
            bytes[at..end].copy_from_slice(&number[..end - at]);
        }
        6 => drop(bytes.drain(range(bytes.len(), random))),
        7 => {
            let copied = bytes[range(bytes.len(), random)].to_vec();
            bytes.splice(at..at, copied);
        }
        8 => {
            let copied = other[range(other.len(), random)].to_vec();
            let end = if random.below(2) == 0 { at } else { (at + copied.len()).min(bytes.len()) };
            bytes.splice(at..end, copied);
        }
        _ => {
            let by = random.below(9) as u32;
            let end = (at + 4).min(bytes.len());
            if let Ok(word) = <[u8; 4]>::try_from(&bytes[at..end]) {
                let word = u32::from_le_bytes(word).wrapping_add(by).wrapping_sub(4);
                bytes[at..end].copy_from_slice(&word.to_le_bytes());
            }
        }
    }
}

/// A range within `of` bytes: mostly short.
fn range(of: usize, random: &mut SplitMix64) -> Range<usize> {
    let from = random.index(of + 1);
    let bits = if random.below(4) == 0 { 11 } else { 6 };
    let most = 1 << random.below(bits);
    from..(from + random.index(most) + 1).min(of)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn any_length_can_be_changed() {
        for length in [0, 1, 2, 3, 4, 5, 100] {
            let input = vec![7; length];
            let made = |seed| mutated(&input, &input, &mut SplitMix64::new(seed));
            let all: BTreeSet<Vec<u8>> = (0..500).map(made).collect();
            assert!(all.len() > 4 * length.min(50), "{length} bytes become {} others", all.len());
        }
    }
}

//! Changes of PNG chunk by chunk, with checksums that are right: a wrong one ends the reading where it stands.
#![expect(
    clippy::cast_possible_truncation,
    reason = "random bytes are the lowest of random bits, and an input is far below 2³² bytes"
)]

use raxel_world::random::SplitMix64;

use super::{binary, pick};

const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Kinds of chunks that decoders look at.
const KINDS: [[u8; 4]; 16] = [
    *b"IHDR", *b"PLTE", *b"IDAT", *b"IEND", *b"tRNS", *b"gAMA", *b"cHRM", *b"sRGB", *b"iCCP", *b"sBIT", *b"tEXt",
    *b"zTXt", *b"iTXt", *b"acTL", *b"fcTL", *b"fdAT",
];

type Chunk = ([u8; 4], Vec<u8>);

/// Changes chunks one to three times; rarely bytes, without regard to checksums.
pub(super) fn mutated(input: &[u8], other: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let mut chunks = chunks(input);
    if chunks.is_empty() || random.below(16) == 0 {
        return binary::mutated(input, other, random);
    }
    for _ in 0..=random.below(3) {
        change(&mut chunks, &self::chunks(other), random);
    }
    let mut bytes = SIGNATURE.to_vec();
    for (kind, data) in &chunks {
        let start = bytes.len() + 4;
        bytes.extend((data.len() as u32).to_be_bytes());
        bytes.extend(kind);
        bytes.extend(data);
        bytes.extend(crc(&bytes[start..]).to_be_bytes());
    }
    bytes
}

/// The whole chunks of a file.
fn chunks(bytes: &[u8]) -> Vec<Chunk> {
    let mut rest = bytes.get(SIGNATURE.len()..).unwrap_or_default();
    let mut chunks = Vec::new();
    while let Some((head, tail)) = rest.split_first_chunk::<8>() {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(data) = tail.get(..length) else { break };
        chunks.push(([head[4], head[5], head[6], head[7]], data.to_vec()));
        rest = tail.get(length + 4..).unwrap_or_default();
    }
    chunks
}

fn change(chunks: &mut Vec<Chunk>, other: &[Chunk], random: &mut SplitMix64) {
    let [at, to] = [(); 2].map(|()| random.index(chunks.len() + 1));
    match random.below(12) {
        0..=3 => header(chunks, random),
        4 => image(chunks, random),
        5..=7 => {
            if let Some((_, data)) = chunks.get_mut(at) {
                *data = binary::mutated(data, data, random);
            }
        }
        8 if at < chunks.len() => drop(chunks.remove(at)),
        9 if at < chunks.len() && to < chunks.len() => chunks.swap(at, to),
        10 => chunks.extend(pick(random, other).cloned()),
        _ => {
            let kind = *pick(random, &KINDS).unwrap_or(&KINDS[0]);
            let length = random.below(40);
            chunks.insert(at, (kind, (0..length).map(|_| random.bits() as u8).collect()));
        }
    }
}

/// Another size, depth, kind of colour or order of rows.
fn header(chunks: &mut [Chunk], random: &mut SplitMix64) {
    let Some((_, data)) = chunks.iter_mut().find(|(kind, data)| kind == b"IHDR" && data.len() >= 13) else { return };
    let field = random.index(5);
    match field {
        0 | 1 => {
            let near = random.below(20) as u32;
            let side =
                if random.below(2) == 0 { near } else { pick(random, &binary::NUMBERS).copied().unwrap_or(near) };
            data[4 * field..4 * field + 4].copy_from_slice(&side.to_be_bytes());
        }
        2 => data[8] = *pick(random, &[1, 2, 4, 8, 16, 3, 0]).unwrap_or(&8),
        3 => data[9] = *pick(random, &[0, 2, 3, 4, 6, 1]).unwrap_or(&0),
        _ => data[12] = random.below(3) as u8,
    }
}

/// Uncompressed rows: any bytes, about as many as the header asks for.
fn image(chunks: &mut [Chunk], random: &mut SplitMix64) {
    let sides = chunks.iter().find(|(kind, data)| kind == b"IHDR" && data.len() >= 13).map(|(_, data)| {
        let [width, height] =
            [0, 4].map(|at| u64::from(u32::from_be_bytes([data[at], data[at + 1], data[at + 2], data[at + 3]])));
        (width, height, u64::from(data[8]) * [1, 1, 3, 1, 2, 1, 4][usize::from(data[9]) % 7])
    });
    let Some((width, height, bits)) = sides else { return };
    let row = 1 + width.saturating_mul(bits).div_ceil(8);
    let length = (row.saturating_mul(height).min(3000) + random.below(3)).saturating_sub(1);
    // A row begins with the number of its filter, 0 to 4.
    let byte = |at: u64| if at.is_multiple_of(row) { random.below(6) as u8 } else { random.bits() as u8 };
    let rows: Vec<u8> = (0..length).map(byte).collect();
    let Some((_, data)) = chunks.iter_mut().find(|(kind, _)| kind == b"IDAT") else { return };
    // A zlib stream of one stored block.
    *data = vec![0x78, 0x01, 0x01];
    data.extend((rows.len() as u16).to_le_bytes());
    data.extend((!(rows.len() as u16)).to_le_bytes());
    data.extend(&rows);
    let (a, b) = rows.iter().fold((1_u32, 0), |(a, b), byte| {
        let a = (a + u32::from(*byte)) % 65521;
        (a, (b + a) % 65521)
    });
    data.extend((b << 16 | a).to_be_bytes());
}

/// The checksum of a chunk's kind and data (PNG, annex D).
fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_those_of_png() {
        assert_eq!(crc(b"IEND"), 0xae42_6082);
        let file = [&SIGNATURE[..], &[0, 0, 0, 0], b"IEND", &[0xae, 0x42, 0x60, 0x82]].concat();
        assert_eq!(chunks(&file), [(*b"IEND", Vec::new())]);
        assert!(chunks(&file[..10]).is_empty() && chunks(b"").is_empty());
    }
}

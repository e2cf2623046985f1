//! Changes of a Zarr store with one shard: of its document word by word; of its shard by bytes and by the numbers of its index. Checksums stay right,
//! because a wrong one would hide everything else.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "an input is in memory, and far below 2⁶³ bytes"
)]

use std::sync::Arc;

use raxel_world::random::SplitMix64;

use super::{binary, pick, text};
use crate::projects::MARK;

/// Bytes of an entry of an index, and of a checksum.
const ENTRY: usize = 16;
const CRC: usize = 4;

/// Words for such a document.
const WORDS: [&str; 16] = [
    "zarr_format",
    "node_type",
    "attributes",
    "raxel",
    "format",
    "world",
    "fingerprint",
    "edge",
    "levels",
    "materials",
    "cell",
    "origin",
    "shards",
    "name",
    "albedo",
    "emission",
];

pub(super) fn mutated(input: &[u8], other: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let Some(at) = shard(input) else { return binary::mutated(input, other, random) };
    let (document, shard) = input.split_at(at);
    if random.below(3) == 0 {
        let end = document.windows(MARK.len()).rposition(|window| window == MARK.as_bytes()).unwrap_or(document.len());
        let words: Arc<[String]> = WORDS.iter().map(|word| (*word).to_owned()).collect();
        let changed = text::mutated(&text::lossy(&document[..end]), &text::lossy(other), &words, random);
        return [changed.as_bytes(), &document[end..], shard].concat();
    }
    let mut shard = shard.to_vec();
    for _ in 0..=random.below(3) {
        change(&mut shard, entries(document), random);
    }
    [document, &shard].concat()
}

/// Where the last file of an input begins.
fn shard(input: &[u8]) -> Option<usize> {
    let mark = input.windows(MARK.len()).rposition(|window| window == MARK.as_bytes())?;
    let line = input[mark..].iter().position(|byte| *byte == b'\n')?;
    Some(mark + line + 1)
}

/// The number of chunks in a shard of this document.
fn entries(document: &[u8]) -> usize {
    let is_large = document.windows(11).any(|window| window == b"\"edge\": 128");
    if is_large { 8 } else { 1 }
}

fn change(shard: &mut Vec<u8>, entries: usize, random: &mut SplitMix64) {
    let Some(index) = shard.len().checked_sub(ENTRY * entries + CRC) else {
        *shard = binary::mutated(shard, shard, random);
        return;
    };
    let entry = index + ENTRY * random.index(entries);
    let word = |shard: &[u8], at: usize| u64::from_le_bytes(std::array::from_fn(|i| shard[at + i]));
    match random.below(8) {
        0 => {
            *shard = binary::mutated(shard, shard, random);
            return;
        }
        1 | 2 => {
            let at = entry + 8 * random.index(2);
            let old = word(shard, at);
            let new = match random.below(4) {
                0 => u64::from(pick(random, &binary::NUMBERS).copied().unwrap_or_default()),
                1 => u64::MAX - random.below(3),
                2 => old.wrapping_add(random.below(9)).wrapping_sub(4),
                _ => random.below(shard.len() as u64 + 1),
            };
            shard[at..at + 8].copy_from_slice(&new.to_le_bytes());
        }
        // The bytes of a chunk, with their checksum.
        _ => {
            let (offset, length) = (word(shard, entry) as usize, word(shard, entry + 8) as usize);
            let end = offset.checked_add(length).filter(|end| *end <= index && length > CRC);
            if let Some(end) = end {
                let content = &shard[offset..end - CRC];
                let mut changed = binary::mutated(content, content, random);
                let sum = crc32c::crc32c(&changed);
                changed.extend(sum.to_le_bytes());
                let length = changed.len() as u64;
                let grown = changed.len() as i64 - (end - offset) as i64;
                shard.splice(offset..end, changed);
                let entry = (entry as i64 + grown) as usize;
                shard[entry + 8..entry + 16].copy_from_slice(&length.to_le_bytes());
            }
        }
    }
    let end = shard.len() - CRC;
    let sum = crc32c::crc32c(&shard[end - ENTRY * entries..end]);
    shard[end..].copy_from_slice(&sum.to_le_bytes());
}

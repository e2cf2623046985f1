//! Changes the files of a save record by record, with right and chained checksums: a wrong one would hide everything behind it.
#![expect(
    clippy::cast_possible_truncation,
    reason = "random bytes are the lowest of random bits, and an input is far below 2³² bytes"
)]

use raxel_world::random::SplitMix64;

use super::{binary, pick};
use crate::projects::{parts, whole};

/// Bytes of a header in each format, by its magic.
const HEADERS: [(&[u8; 4], usize); 2] = [(b"RXV1", 40), (b"RXV2", 44)];

pub(super) fn mutated(input: &[u8], other: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let mut files: Vec<(String, Vec<u8>)> = parts(input).collect();
    if files.is_empty() {
        return binary::mutated(input, other, random);
    }
    for _ in 0..=random.below(3) {
        change(&mut files, other, random);
    }
    whole(&files)
}

fn change(files: &mut Vec<(String, Vec<u8>)>, other: &[u8], random: &mut SplitMix64) {
    let count = files.len();
    let [at, to] = [(); 2].map(|()| random.index(count));
    match random.below(16) {
        0 if count > 1 => drop(files.remove(at)),
        1 => {
            let name = files[to].0.clone();
            files[at].0 = name;
        }
        2 => files.extend(pick(random, &parts(other).collect::<Vec<_>>()).cloned()),
        3 => files[at].0 = format!("journal-{:08}.log", random.below(9)),
        4 | 5 => {
            let bytes = &files[at].1;
            files[at].1 = binary::mutated(bytes, bytes, random);
        }
        _ if files[at].0 == "tail" => slots(&mut files[at].1, random),
        _ => {
            let mut records = records(&files[at].1);
            record(&mut records, random);
            files[at].1 = chained(&records);
        }
    }
}

/// The records of a file, as far as they can be separated.
fn records(mut bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut records = Vec::new();
    while let Some((_, header)) = HEADERS.iter().find(|(magic, size)| bytes.starts_with(*magic) && bytes.len() >= *size)
    {
        let length = u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]) as usize;
        let end = header.saturating_add(length).min(bytes.len());
        records.push(bytes[..end].to_vec());
        bytes = &bytes[end..];
    }
    records
}

fn header(record: &[u8]) -> usize {
    HEADERS.iter().find(|(magic, _)| record.starts_with(*magic)).map_or(record.len(), |(_, size)| *size)
}

fn record(records: &mut Vec<Vec<u8>>, random: &mut SplitMix64) {
    if records.is_empty() {
        return;
    }
    let count = records.len();
    let [at, to] = [(); 2].map(|()| random.index(count));
    match random.below(8) {
        0 => drop(records.remove(at)),
        1 => records.swap(at, to),
        2 => records.insert(to, records[at].clone()),
        // Its kind, its number, its place.
        3 => records[at][4] = random.below(7) as u8,
        4 => {
            let number = match random.below(4) {
                0 => u64::MAX - random.below(3),
                1 => 1 << random.below(64),
                _ => random.below(20),
            };
            records[at][12..20].copy_from_slice(&number.to_le_bytes());
        }
        5 => {
            let place = pick(random, &binary::NUMBERS).copied().unwrap_or_default();
            let axis = 20 + 4 * random.index(3);
            records[at][axis..axis + 4].copy_from_slice(&place.to_le_bytes());
        }
        _ => {
            let header = header(&records[at]);
            let payload = binary::mutated(&records[at][header..], &records[to], random);
            records[at].truncate(header);
            records[at].extend(&payload);
            records[at][8..12].copy_from_slice(&(payload.len() as u32).to_le_bytes());
        }
    }
}

/// The records behind each other, each with its own sums and the sum of the one before.
fn chained(records: &[Vec<u8>]) -> Vec<u8> {
    let (mut bytes, mut before) = (Vec::new(), 0_u32);
    for record in records {
        let mut record = record.clone();
        let header = header(&record);
        if record.len() >= header && header >= 40 {
            if header == 44 {
                record[32..36].copy_from_slice(&before.to_le_bytes());
            }
            let payload = crc32c::crc32c(&record[header..]);
            record[header - 8..header - 4].copy_from_slice(&payload.to_le_bytes());
            before = crc32c::crc32c(&record[..header - 4]);
            record[header - 4..header].copy_from_slice(&before.to_le_bytes());
        }
        bytes.extend(record);
    }
    bytes
}

/// Numbers of a tail: two slots of 36 bytes.
fn slots(tail: &mut [u8], random: &mut SplitMix64) {
    for slot in tail.chunks_exact_mut(36) {
        if random.below(4) > 0 {
            let at = 4 + 8 * random.index(3);
            let number = if random.below(3) == 0 { u64::MAX - random.below(3) } else { random.below(20) };
            slot[at..at + 8].copy_from_slice(&number.to_le_bytes());
        }
        let sum = crc32c::crc32c(&slot[..32]);
        slot[32..].copy_from_slice(&sum.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A format that changes would leave the mutations without effect.
    #[test]
    fn what_is_not_changed_stays() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/save");
        for entry in std::fs::read_dir(folder).expect("there is a corpus") {
            let path = entry.expect("it can be listed").path();
            let input = std::fs::read(&path).expect("it can be read");
            let files: Vec<(String, Vec<u8>)> = parts(&input).collect();
            assert_eq!(whole(&files), input, "{}", path.display());
            if path.to_string_lossy().contains("found-") {
                continue;
            }
            for (name, bytes) in files.iter().filter(|(name, _)| name != "tail") {
                let records = records(bytes);
                assert!(records.len() > 1, "{name} in {}", path.display());
                assert_eq!(chained(&records), *bytes, "{name} in {}", path.display());
            }
        }
    }
}

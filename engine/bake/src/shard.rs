//! The bytes of a shard: compressed chunks one behind the other, a [`Seal`], then an index of where each chunk is (the codec
//! `sharding_indexed` of Zarr v3, whose readers skip the seal). A chunk without a solid cell is left out; an array's fill value is air. A
//! chunk is its cells as little-endian 16-bit palette indices, x fastest, then y, then z, in a zstd frame with a CRC-32C behind it; so is
//! the index, without zstd.

use raxel_world::{BLOCKS, CHUNK_VOXELS, Chunk, Content, block_cell, child_cell};

use crate::seal::{SEAL, Seal};

/// Bytes of a CRC-32C.
const CRC: usize = 4;
/// Bytes of an entry of the index: offset and length.
const ENTRY: usize = 16;
/// Level of zstd: terrain is 4 % larger than at level 9, and made eight times as fast.
pub(crate) const ZSTD_LEVEL: i32 = 3;

/// Bytes that differ from the written ones.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Damage {
    /// Fewer bytes than an index has.
    #[error("it has {found} bytes, and its index alone has {needed}")]
    Short {
        /// Bytes there are.
        found: usize,
        /// Bytes of the index.
        needed: usize,
    },
    /// The shard of another place, or of another world.
    #[error("it is the shard of another place or another world")]
    Other,
    /// The index has another checksum than is written behind it.
    #[error("its index has the checksum {found:08x}, and {written:08x} is written behind it")]
    Index {
        /// Of the bytes there are.
        found: u32,
        /// The checksum in the file.
        written: u32,
    },
    /// The index names bytes that are not there.
    #[error("its index says that chunk {chunk} is at bytes {from} to {to}, which are not there")]
    Place {
        /// The chunk in the shard.
        chunk: usize,
        /// Its first byte.
        from: u64,
        /// One past its last.
        to: u64,
    },
    /// A chunk has another checksum than is written behind it.
    #[error("chunk {chunk} has the checksum {found:08x}, and {written:08x} is written behind it")]
    Chunk {
        /// The chunk in the shard.
        chunk: usize,
        /// Of the bytes there are.
        found: u32,
        /// The checksum in the file.
        written: u32,
    },
    /// A chunk that is no chunk in spite of its checksum.
    #[error("chunk {chunk} is wrong: {reason}")]
    Content {
        /// The chunk in the shard.
        chunk: usize,
        /// The reason.
        reason: String,
    },
}

/// Where the chunks of a shard are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Index(Vec<Option<(u64, u64)>>);

/// A shard being written. Chunks come in the order of their place: x fastest, then y, then z.
pub(crate) struct ShardWriter {
    bytes: Vec<u8>,
    index: Index,
}

impl ShardWriter {
    pub(crate) fn new() -> Self {
        Self { bytes: Vec::new(), index: Index(Vec::new()) }
    }

    /// Adds the next chunk; `None` has no solid cell.
    pub(crate) fn push(&mut self, chunk: Option<&[u8]>) {
        self.index.0.push(chunk.map(|chunk| (self.bytes.len() as u64, chunk.len() as u64)));
        self.bytes.extend_from_slice(chunk.unwrap_or_default());
    }

    pub(crate) fn finish(mut self, seal: Seal) -> Vec<u8> {
        self.bytes.extend_from_slice(&seal.0);
        let start = self.bytes.len();
        for entry in self.index.0 {
            let (offset, length) = entry.unwrap_or((u64::MAX, u64::MAX));
            self.bytes.extend_from_slice(&offset.to_le_bytes());
            self.bytes.extend_from_slice(&length.to_le_bytes());
        }
        let crc = crc32c::crc32c(&self.bytes[start..]);
        self.bytes.extend_from_slice(&crc.to_le_bytes());
        self.bytes
    }
}

impl Index {
    /// Bytes of the seal and the index of a shard with `chunks` chunks, which are its end.
    pub(crate) fn bytes(chunks: usize) -> usize {
        SEAL + ENTRY * chunks + CRC
    }

    /// Reads the last bytes of a shard.
    pub(crate) fn read(tail: &[u8], chunks: usize, seal: Seal) -> Result<Self, Damage> {
        let needed = Self::bytes(chunks);
        let start = tail.len().checked_sub(needed).ok_or(Damage::Short { found: tail.len(), needed })?;
        let (sealed, index) = tail[start..].split_at(SEAL);
        let (entries, crc) = index.split_at(ENTRY * chunks);
        let (found, written) = (crc32c::crc32c(entries), le_u32(crc));
        if found != written {
            return Err(Damage::Index { found, written });
        }
        if sealed != seal.0 {
            return Err(Damage::Other);
        }
        let word = |bytes: &[u8]| u64::from_le_bytes(std::array::from_fn(|i| bytes[i]));
        let entry = |bytes: &[u8]| (word(bytes), word(&bytes[8..]));
        Ok(Self(
            entries
                .chunks_exact(ENTRY)
                .map(entry)
                .map(|entry| (entry != (u64::MAX, u64::MAX)).then_some(entry))
                .collect(),
        ))
    }

    /// The bytes of a chunk; `None` when it has no solid cell.
    pub(crate) fn place(&self, chunk: usize) -> Result<Option<std::ops::Range<u64>>, Damage> {
        let Some((offset, length)) = self.0[chunk] else { return Ok(None) };
        match offset.checked_add(length) {
            Some(end) if length >= CRC as u64 && length <= most_bytes() => Ok(Some(offset..end)),
            end => Err(Damage::Place { chunk, from: offset, to: end.unwrap_or(u64::MAX) }),
        }
    }
}

/// Checks every byte of a shard against the checksums in it. Returns how many of its chunks have solid cells.
#[expect(clippy::cast_possible_truncation, reason = "a place ends before the bytes in memory do")]
pub(crate) fn check(bytes: &[u8], chunks: usize, seal: Seal) -> Result<u64, Damage> {
    let index = Index::read(bytes, chunks, seal)?;
    let end = (bytes.len() - Index::bytes(chunks)) as u64;
    let mut at = 0;
    let mut solid = 0;
    for chunk in 0..chunks {
        let Some(place) = index.place(chunk)? else { continue };
        // They stand one behind the other.
        if place.start != at || place.end > end {
            return Err(Damage::Place { chunk, from: place.start, to: place.end });
        }
        checked(&bytes[place.start as usize..place.end as usize], chunk)?;
        at = place.end;
        solid += 1;
    }
    if at == end { Ok(solid) } else { Err(Damage::Place { chunk: chunks, from: at, to: end }) }
}

/// The bytes of a tile in a shard; `None` when it has no solid cell.
pub(crate) fn encode(content: &Content) -> Option<Vec<u8>> {
    let chunk = content.to_chunk()?;
    let mut cells = vec![0u8; 2 * CHUNK_VOXELS];
    for ([x, y, z], material) in chunk.iter() {
        let at = 2 * ((z * 64 + y) * 64 + x) as usize;
        cells[at..at + 2].copy_from_slice(&material.to_le_bytes());
    }
    let mut bytes = zstd::bulk::compress(&cells, ZSTD_LEVEL).expect("there is memory for what is compressed");
    let crc = crc32c::crc32c(&bytes);
    bytes.extend_from_slice(&crc.to_le_bytes());
    Some(bytes)
}

/// The tile that bytes of a shard are. `materials` is how many there are, air included.
pub(crate) fn decode(bytes: &[u8], chunk: usize, materials: usize) -> Result<Content, Damage> {
    let wrong = |reason: String| Damage::Content { chunk, reason };
    let cells = zstd::bulk::decompress(checked(bytes, chunk)?, 2 * CHUNK_VOXELS).map_err(|e| wrong(e.to_string()))?;
    if cells.len() != 2 * CHUNK_VOXELS {
        return Err(wrong(format!("it has {} bytes, not {}", cells.len(), 2 * CHUNK_VOXELS)));
    }
    let mut masks: Box<[u64; BLOCKS]> = vec![0; BLOCKS].into_boxed_slice().try_into().expect("it is that long");
    let mut solids = Vec::new();
    for (block, mask) in masks.iter_mut().enumerate() {
        let corner = block_cell(block);
        // Four cells along x are neighbours in both orders.
        for first in (0..64).step_by(4) {
            let inner = child_cell(first);
            let [x, y, z]: [u32; 3] = std::array::from_fn(|axis| 4 * corner[axis] + inner[axis]);
            let at = 2 * ((z * 64 + y) * 64 + x) as usize;
            let row: [u8; 8] = std::array::from_fn(|byte| cells[at + byte]);
            if row == [0; 8] {
                continue;
            }
            for (bit, cell) in (first..).zip(row.chunks_exact(2)) {
                let material = u16::from_le_bytes([cell[0], cell[1]]);
                if material == 0 {
                    continue;
                }
                if usize::from(material) >= materials {
                    return Err(wrong(format!("it has material {material}, and there are {materials}")));
                }
                *mask |= 1 << bit;
                solids.push(material);
            }
        }
    }
    Ok(Chunk::from_parts(&masks, solids).map_or(Content::Empty, |chunk| Content::of(chunk.into())))
}

/// The bytes before the checksum, if that is right.
fn checked(bytes: &[u8], chunk: usize) -> Result<&[u8], Damage> {
    let end = bytes.len().checked_sub(CRC).ok_or(Damage::Short { found: bytes.len(), needed: CRC })?;
    let (content, crc) = bytes.split_at(end);
    let (found, written) = (crc32c::crc32c(content), le_u32(crc));
    if found == written { Ok(content) } else { Err(Damage::Chunk { chunk, found, written }) }
}

/// Most bytes that any chunk can take.
fn most_bytes() -> u64 {
    (zstd::zstd_safe::compress_bound(2 * CHUNK_VOXELS) + CRC) as u64
}

fn le_u32(bytes: &[u8]) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|i| bytes[i]))
}

#[cfg(test)]
mod tests {
    use raxel_world::{DenseChunk, random::SplitMix64};

    use super::*;

    fn contents() -> Vec<Content> {
        let mut dense = DenseChunk::default();
        let mut random = SplitMix64::new(7);
        for _ in 0..5000 {
            let [x, y, z] = std::array::from_fn(|_| random.below(64) as u32);
            dense.set(x, y, z, 1 + random.below(300) as u16);
        }
        vec![Content::Empty, Content::Full(3), Content::pack(&dense), Content::Empty]
    }

    const SEALED: Seal = Seal([7; SEAL]);

    fn shard() -> Vec<u8> {
        let mut writer = ShardWriter::new();
        contents().iter().for_each(|content| writer.push(encode(content).as_deref()));
        writer.finish(SEALED)
    }

    #[test]
    fn what_is_written_is_read() {
        let bytes = shard();
        assert_eq!(check(&bytes, 4, SEALED), Ok(2));
        assert_eq!(check(&bytes, 4, Seal([8; SEAL])), Err(Damage::Other));
        let index = Index::read(&bytes, 4, SEALED).unwrap();
        for (chunk, content) in contents().into_iter().enumerate() {
            let found = match index.place(chunk).unwrap() {
                None => Content::Empty,
                Some(place) => decode(&bytes[place.start as usize..place.end as usize], chunk, 301).unwrap(),
            };
            assert_eq!(found, content, "chunk {chunk}");
        }
        let place = index.place(1).unwrap().unwrap();
        let few = decode(&bytes[place.start as usize..place.end as usize], 1, 3).unwrap_err();
        assert_eq!(few.to_string(), "chunk 1 is wrong: it has material 3, and there are 3");
    }

    #[test]
    fn no_half_and_no_flipped_shard_is_whole() {
        let bytes = shard();
        for length in (0..bytes.len()).step_by(97) {
            assert!(check(&bytes[..length], 4, SEALED).is_err(), "{length} bytes of {}", bytes.len());
        }
        for at in (0..bytes.len()).step_by(61).chain(bytes.len() - 80..bytes.len()) {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (at % 8);
            assert!(check(&flipped, 4, SEALED).is_err(), "byte {at}");
        }
        // An index that is right in itself, of a shard with more chunks.
        assert!(check(&bytes, 3, SEALED).is_err() && check(&bytes, 5, SEALED).is_err());
    }
}

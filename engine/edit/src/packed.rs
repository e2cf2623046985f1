//! A chunk in few bytes: what saves keep, and old steps of the history.
//!
//! The bytes are a zstd frame (level 1) of little-endian numbers: the occupancy of the chunk (u64), that of its occupied 16³ nodes, that
//! of their occupied 4³ blocks; then the number of materials (u16) and the materials (u16 each, ascending); then, unless there is only
//! one, an index into them for each solid voxel in tree order: u8 up to 256 materials, u16 above. No bytes at all are a chunk without
//! solids.

use std::sync::Arc;

use raxel_world::{AIR, BLOCKS, Bits, Chunk, MaterialIndex};
use serde::{Deserialize, Serialize};

/// More bytes than the largest chunk has before compression: its masks, a palette of all materials, two bytes a voxel.
const MOST_BYTES: usize = 1 << 20;

/// A chunk in few bytes. Equal chunks are equal bytes.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PackedChunk(Arc<[u8]>);

impl PackedChunk {
    /// Packs a chunk; `None` is one without solids.
    pub fn pack(chunk: Option<&Chunk>) -> Self {
        let Some(chunk) = chunk else { return Self(Arc::default()) };
        let plain = plain_bytes(chunk);
        // It fails only where memory cannot be allocated, where Rust's own containers end the program as well.
        let packed = zstd::bulk::compress(&plain, 1).expect("zstd has memory for a chunk");
        Self(packed.into())
    }

    /// From the bytes of [`PackedChunk::bytes`].
    pub fn from_bytes(bytes: &[u8]) -> Self {
        Self(bytes.into())
    }

    /// The bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// The chunk. The outer `None`: the bytes are no chunk, or a material of the chunk is not below `materials`.
    #[allow(clippy::option_option, reason = "broken, and without solids, are different answers")]
    pub fn unpack(&self, materials: usize) -> Option<Option<Chunk>> {
        if self.0.is_empty() {
            return Some(None);
        }
        let plain = zstd::bulk::decompress(&self.0, MOST_BYTES).ok()?;
        read_plain(&plain, materials).map(Some)
    }
}

impl PackedChunk {
    /// The same chunk in another palette: material i becomes `indices[i]`. `None` when it is broken or has a material beyond them.
    #[must_use]
    pub fn remapped(&self, indices: &[MaterialIndex]) -> Option<Self> {
        let Some(chunk) = self.unpack(indices.len())? else { return Some(self.clone()) };
        let materials = (0..chunk.solids()).map(|n| indices[usize::from(chunk.material(n))]).collect();
        Chunk::from_parts(chunk.masks(), materials).map(|chunk| Self::pack(Some(&chunk)))
    }
}

impl std::fmt::Debug for PackedChunk {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "PackedChunk({} bytes)", self.0.len())
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a palette has at most 2¹⁶ materials")]
fn plain_bytes(chunk: &Chunk) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(1 << 15);
    let root = chunk.root_mask();
    bytes.extend(root.to_le_bytes());
    let nodes: Vec<usize> = Bits(root).map(|node| node as usize).collect();
    for node in &nodes {
        bytes.extend(chunk.node_mask(*node).to_le_bytes());
    }
    for node in &nodes {
        for block in Bits(chunk.node_mask(*node)) {
            bytes.extend(chunk.mask(node * 64 + block as usize).to_le_bytes());
        }
    }
    if let Some((palette, indices)) = chunk.indexed() {
        write_palette(palette, &mut bytes);
        bytes.extend_from_slice(indices);
        return bytes;
    }
    let materials: Vec<MaterialIndex> = (0..chunk.solids()).map(|n| chunk.material(n)).collect();
    let mut palette = materials.clone();
    palette.sort_unstable();
    palette.dedup();
    write_palette(&palette, &mut bytes);
    let index_of = |material| palette.binary_search(material).unwrap_or(0) as u16;
    materials.iter().for_each(|material| bytes.extend(index_of(material).to_le_bytes()));
    bytes
}

#[expect(clippy::cast_possible_truncation, reason = "a palette has no air, so that it has fewer than 2¹⁶ materials")]
fn write_palette(palette: &[MaterialIndex], bytes: &mut Vec<u8>) {
    bytes.extend((palette.len() as u16).to_le_bytes());
    palette.iter().for_each(|material| bytes.extend(material.to_le_bytes()));
}

#[allow(clippy::large_stack_arrays, reason = "it goes into its box at once")]
fn read_plain(mut bytes: &[u8], materials: usize) -> Option<Chunk> {
    let bytes = &mut bytes;
    let root = read_u64(bytes)?;
    let nodes: Vec<(usize, u64)> =
        Bits(root).map(|node| Some((node as usize, read_u64(bytes)?))).collect::<Option<_>>()?;
    let mut masks = Box::new([0u64; BLOCKS]);
    for (node, mask) in nodes {
        for block in Bits(mask) {
            let mask = read_u64(bytes)?;
            masks[node * 64 + block as usize] = mask;
        }
    }
    let count = usize::from(read_u16(bytes)?);
    let palette: Vec<MaterialIndex> = (0..count).map(|_| read_u16(bytes)).collect::<Option<_>>()?;
    if palette.iter().any(|material| *material == AIR || usize::from(*material) >= materials) {
        return None;
    }
    if count <= 256 {
        return Chunk::from_indexed(&masks, &palette, if count == 1 { &[] } else { bytes });
    }
    let (pairs, rest) = bytes.as_chunks::<2>();
    if !rest.is_empty() {
        return None;
    }
    let of_index = |index: u16| palette.get(usize::from(index)).copied();
    let plain = pairs.iter().map(|pair| of_index(u16::from_le_bytes(*pair))).collect::<Option<_>>()?;
    Chunk::from_parts(&masks, plain)
}

fn read_u64(bytes: &mut &[u8]) -> Option<u64> {
    let (first, rest) = bytes.split_first_chunk::<8>()?;
    *bytes = rest;
    Some(u64::from_le_bytes(*first))
}

fn read_u16(bytes: &mut &[u8]) -> Option<u16> {
    let (first, rest) = bytes.split_first_chunk::<2>()?;
    *bytes = rest;
    Some(u16::from_le_bytes(*first))
}

#[cfg(test)]
mod tests {
    use raxel_world::DenseChunk;
    use raxel_world::random::mix;

    use super::*;

    #[test]
    fn chunks_come_back_as_they_were() {
        for (solids, materials) in [(1, 1), (500, 2), (9000, 256), (200_000, 300), (262_144, 1)] {
            let mut dense = DenseChunk::default();
            for i in 0..solids as u64 {
                let at = if solids == 262_144 { i } else { mix(i) };
                let [x, y, z] = [at & 63, at >> 6 & 63, at >> 12 & 63].map(|c| c as u32);
                dense.set(x, y, z, 1 + (mix(at) % materials) as u16);
            }
            let chunk = Chunk::pack(&dense).unwrap();
            let packed = PackedChunk::pack(Some(&chunk));
            assert_eq!(packed.unpack(301), Some(Some(chunk.clone())), "{solids} {materials}");
            let top = (0..chunk.solids()).map(|n| chunk.material(n)).max().unwrap();
            assert_eq!(packed.unpack(usize::from(top)), None, "a material that the world does not have");
            // No bytes make it panic.
            let plain = plain_bytes(&chunk);
            for end in (0..plain.len()).step_by(plain.len() / 50 + 1) {
                assert_eq!(read_plain(&plain[..end], 301), None);
            }
            for at in 0..200 {
                let mut bent = plain.clone();
                let place = (mix(at) % bent.len() as u64) as usize;
                bent[place] ^= 1 << (at & 7);
                let _ = read_plain(&bent, 301);
            }
        }
        assert_eq!(PackedChunk::pack(None).unpack(1), Some(None));
        assert_eq!(PackedChunk::from_bytes(&[1, 2, 3]).unpack(9), None);
    }
}

//! Materials of up to 64 voxels in few bits: a palette of the few that there are, and an index into it for each voxel, as in Dado et al.,
//! "Geometry and attribute compression for voxel scenes" (2016).

use raxel_world::MaterialIndex;

/// Materials of the largest palette.
const MOST: usize = 16;

/// How the materials of several voxels are packed: a palette of 2^(2^kind) materials, two a word, then 2^kind bits for each voxel in turn.
/// Kind 4 has no palette, and the 16 bits are the material. The rest of a word is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packing {
    /// 0, 1, 2 or 4.
    pub kind: u32,
    voxels: usize,
    /// Ascending, and 0 behind its end.
    palette: [MaterialIndex; MOST],
}

impl Packing {
    /// The packing of fewest words.
    pub fn of(materials: impl Iterator<Item = MaterialIndex>) -> Self {
        let mut palette = [0; MOST];
        let (mut distinct, mut voxels, mut last) = (0, 0, None);
        for material in materials {
            voxels += 1;
            // Neighbours are alike more often than not.
            if last == Some(material) || distinct > MOST {
                continue;
            }
            last = Some(material);
            if !palette[..distinct].contains(&material) {
                if let Some(slot) = palette.get_mut(distinct) {
                    *slot = material;
                }
                distinct += 1;
            }
        }
        palette[..distinct.min(MOST)].sort_unstable();
        let kinds = [0, 1, 2, 4].into_iter().filter(|kind| *kind == 4 || distinct <= 1 << (1 << kind));
        let kind = kinds.min_by_key(|kind| words(*kind, voxels)).unwrap_or(4);
        Self { kind, voxels, palette }
    }

    /// Words that it takes.
    pub fn words(&self) -> usize {
        words(self.kind, self.voxels)
    }

    /// Writes it into `words`, which are 0.
    pub fn write(&self, materials: impl Iterator<Item = MaterialIndex>, words: &mut [u32]) {
        let (palette, indices) = words.split_at_mut(palette_words(self.kind));
        for (word, pair) in palette.iter_mut().zip(self.palette.chunks(2)) {
            *word = u32::from(pair[0]) | u32::from(pair[1]) << 16;
        }
        let bits = 1 << self.kind;
        let (mut last, mut value) = (None, 0);
        for (voxel, material) in materials.enumerate() {
            if last != Some(material) {
                last = Some(material);
                value = match self.kind {
                    4 => u32::from(material),
                    _ => self.palette.iter().position(|of_palette| *of_palette == material).unwrap_or(0) as u32,
                };
            }
            indices[voxel * bits / 32] |= value << (voxel * bits % 32);
        }
    }
}

fn palette_words(kind: u32) -> usize {
    if kind == 4 { 0 } else { 1 << (1 << kind) >> 1 }
}

fn words(kind: u32, voxels: usize) -> usize {
    palette_words(kind) + (voxels << kind).div_ceil(32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pack(materials: &[MaterialIndex]) -> (u32, Vec<u32>) {
        let packing = Packing::of(materials.iter().copied());
        let mut words = vec![0; packing.words()];
        packing.write(materials.iter().copied(), &mut words);
        (packing.kind, words)
    }

    #[test]
    fn blocks_take_as_few_bits_as_their_materials_need() {
        let two: Vec<u16> = (0..64).map(|i| 5 + u16::from(i % 2 == 0) * 300).collect();
        assert_eq!(pack(&two), (0, vec![5 | 305 << 16, 0x5555_5555, 0x5555_5555]));
        let words = |materials: u16| pack(&(0..64).map(|i| i % materials).collect::<Vec<_>>()).1.len();
        assert_eq!([2, 3, 4, 5, 16, 17, 64].map(words), [3, 6, 6, 16, 16, 32, 32]);
        // Of few voxels, the palette would be most of it.
        assert_eq!(pack(&[1, 2, 3]), (4, vec![1 | 2 << 16, 3]));
        assert_eq!(pack(&[7, 2]), (4, vec![7 | 2 << 16]));
    }
}

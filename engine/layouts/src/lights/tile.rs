//! The lamps of worlds that are loaded tile by tile. A tile has its own list, made once. A draw has two steps: a group, then a light of
//! the group. So a tile that comes or goes changes only the table of the groups.

use std::sync::Arc;

use glam::IVec3;
use raxel_world::ChunkPos;
use raxel_world::Side;
use raxel_world::{AIR, Material, MaterialIndex};
use raxel_world::{Bits, Chunk, block_cell, child_cell};
use raxel_world::{Content, cell_edge};

use super::{Draw, HEADER_WORDS, LIGHT_WORDS, Light, alias_table, power};

/// The emission of each material of a palette.
#[derive(Clone, Debug)]
pub struct LightPowers(Vec<f32>);

impl LightPowers {
    /// Of a palette; `None` when nothing in it gives off light.
    pub fn of(materials: &[Material]) -> Option<Self> {
        let powers: Vec<f32> = materials.iter().map(power).collect();
        powers.iter().any(|power| *power > 0.0).then_some(Self(powers))
    }

    fn get(&self, material: MaterialIndex) -> f32 {
        self.0.get(usize::from(material)).copied().unwrap_or(0.0)
    }
}

/// The lamps of a tile: its parts in order. Each part is there as a whole or not at all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileLights {
    level: u32,
    lights: Vec<Light>,
    /// Number of the part, its lights, and the sum of their powers.
    parts: Vec<(u32, u32, f64)>,
    /// The faces of the tile at which it has something that gives off light.
    sides: u8,
}

/// Lights behind each other in a buffer that are drawn together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightGroup {
    /// Index of the first one.
    pub first: u32,
    /// How many.
    pub count: u32,
    /// The sum of their emission: power times area.
    pub power: f64,
}

impl TileLights {
    /// The lamps of a tile with these voxels or cells. `beside` gives the outermost cells of the tile beyond a face; it is called only for
    /// faces where the result depends on them.
    ///
    /// A tile of level 0 has one part, and exactly the faces that the whole world has there. Above that, each 16³ cells are a part,
    /// since finer tiles may replace any of them. Between two parts, a face counts as exposed: a finer tile beyond it may leave some of it
    /// free.
    #[expect(clippy::cast_possible_truncation, reason = "cells of the world have 32 bits")]
    pub fn of(
        content: &Content,
        (level, pos): (u32, ChunkPos),
        powers: &LightPowers,
        beside: impl FnMut(u32) -> Arc<Side>,
    ) -> Self {
        let mut found = Self { level, ..Self::default() };
        let Some(chunk) = content.to_chunk() else { return found };
        if !chunk.may_have_material(|material| powers.get(material) > 0.0) {
            return found;
        }
        let mut around = Around { chunk: &chunk, level, beside, known: Default::default() };
        let edge = cell_edge(level);
        let origin = [pos.x, pos.y, pos.z].map(|c| i64::from(c) * 64 * edge);
        for node in Bits(chunk.root_mask()) {
            let before = found.lights.len();
            for block in Bits(chunk.node_mask(node as usize)).map(|bit| (node * 64 + bit) as usize) {
                if chunk.block_uniform(block).is_some_and(|material| powers.get(material) <= 0.0) {
                    continue;
                }
                let corner = block_cell(block);
                for (bit, material) in Bits(chunk.mask(block)).zip(chunk.block_materials(block)) {
                    let power = powers.get(material);
                    if power <= 0.0 {
                        continue;
                    }
                    let child = child_cell(bit);
                    let cell: [u32; 3] = std::array::from_fn(|i| 4 * corner[i] + child[i]);
                    let voxel = IVec3::from_array([0, 1, 2].map(|i| (origin[i] + i64::from(cell[i]) * edge) as i32));
                    for face in 0..6 {
                        found.sides |= u8::from(at_side(cell, face)) << face;
                        if around.is_bare(cell, face) {
                            found.lights.push(Light { voxel, face, material, power });
                        }
                    }
                }
            }
            if level > 0 {
                found.end_part(node, before);
            }
        }
        if level == 0 {
            found.end_part(0, 0);
        }
        found
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "a list of lamps has 32-bit floats and is addressed in 32 bits"
    )]
    fn end_part(&mut self, number: u32, first: usize) {
        let lights = &self.lights[first..];
        if !lights.is_empty() {
            let area = (cell_edge(self.level) * cell_edge(self.level)) as f64;
            let power = lights.iter().map(|light| f64::from(light.power) * area).sum();
            self.parts.push((number, lights.len() as u32, power));
        }
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// The faces of the tile, a bit each, at which it has emissive cells. Which of these are lamps depends on the tile beyond the face.
    pub fn sides(&self) -> u8 {
        self.sides
    }

    /// Words that they take.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a list of lamps has 32-bit floats and is addressed in 32 bits"
    )]
    pub fn words(&self) -> u32 {
        (LIGHT_WORDS * self.lights.len()) as u32
    }

    /// The words for a place in the buffer, from the light `first` on, and the groups that they make, with the number of the part of each.
    pub fn encode(&self, first: u32) -> (Vec<u32>, Vec<(u32, LightGroup)>) {
        let mut words = Vec::with_capacity(self.words() as usize);
        let mut groups = Vec::with_capacity(self.parts.len());
        let mut at = 0;
        for &(part, count, power) in &self.parts {
            let lights = &self.lights[at as usize..][..count as usize];
            let powers: Vec<f64> = lights.iter().map(|light| f64::from(light.power)).collect();
            for (light, draw) in lights.iter().zip(alias_table(&powers, powers.iter().sum())) {
                // The probability among all lamps changes with the other tiles: shaders compute it from the sum of all powers.
                let draw = Draw { probability: 0.0, alias: first + at + draw.alias, ..draw };
                light.put(&draw, self.level, &mut words);
            }
            groups.push((part, LightGroup { first: first + at, count, power }));
            at += count;
        }
        (words, groups)
    }
}

/// The words of a table of groups: for each its first light, how many there are, and how it is drawn.
pub fn grouped_words(groups: &[LightGroup]) -> Vec<u32> {
    let powers: Vec<f64> = groups.iter().map(|group| group.power).collect();
    let draws = alias_table(&powers, powers.iter().sum());
    let words = |(group, draw): (&LightGroup, Draw)| [group.first, group.count, draw.threshold.to_bits(), draw.alias];
    groups.iter().zip(draws).flat_map(words).collect()
}

/// The words in front of the lights: `at` is the place of the table of the groups, in four words.
#[expect(clippy::cast_possible_truncation, reason = "a list of lamps has 32-bit floats and is addressed in 32 bits")]
pub fn grouped_header(groups: &[LightGroup], at: u32) -> [u32; HEADER_WORDS] {
    let power: f64 = groups.iter().map(|group| group.power).sum();
    let count = groups.iter().map(|group| group.count).sum();
    [count, (power as f32).to_bits(), at, groups.len() as u32]
}

/// A tile, and the voxels beyond its faces.
struct Around<'c, F> {
    chunk: &'c Chunk,
    level: u32,
    beside: F,
    known: [Option<Arc<Side>>; 6],
}

impl<F: FnMut(u32) -> Arc<Side>> Around<'_, F> {
    fn is_bare(&mut self, cell: [u32; 3], face: u32) -> bool {
        let axis = (face >> 1) as usize;
        let step = if face & 1 == 1 { 1 } else { u32::MAX };
        let next = cell[axis].wrapping_add(step);
        if self.level > 0 && next >> 4 != cell[axis] >> 4 {
            return true;
        }
        let mut beyond = cell;
        beyond[axis] = next & 63;
        let [x, y, z] = beyond;
        if next < 64 {
            return self.chunk.voxel(x, y, z) == AIR;
        }
        let beside = &mut self.beside;
        !self.known[face as usize].get_or_insert_with(|| beside(face)).is_solid(beyond, face ^ 1)
    }
}

/// Whether a cell of a tile touches one of its faces.
fn at_side(cell: [u32; 3], face: u32) -> bool {
    cell[(face >> 1) as usize] == if face & 1 == 1 { 63 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lights::lights;
    use raxel_world::World;
    use raxel_world::random::SplitMix64;

    fn materials() -> Vec<Material> {
        let lamp = |emission| Material { emission, ..Material::matt("lamp", [1.0; 3]) };
        vec![Material::air(), Material::matt("stone", [0.5; 3]), lamp(2.0), lamp(20.0)]
    }

    #[test]
    fn the_lamps_of_all_chunks_are_those_of_the_world() {
        let mut random = SplitMix64::new(6);
        let voxels: Vec<_> = (0..60_000)
            .map(|_| {
                let cell = [0; 3].map(|_| random.below(140) as i32 - 70);
                (IVec3::from_array(cell), 1 + random.below(3) as u16)
            })
            .collect();
        let world = World::from_voxels(materials(), voxels);
        let powers = LightPowers::of(&materials()).unwrap();
        let mut found = Vec::new();
        for (pos, chunk) in world.chunks() {
            let content = Content::of(chunk.clone());
            let beside = |face| Arc::new(Side::of(&world.tile(0, pos.beside(face)), face ^ 1));
            let tile = TileLights::of(&content, (0, pos), &powers, beside);
            assert_eq!(tile.parts.len(), usize::from(!tile.is_empty()));
            found.extend(tile.lights);
        }
        assert!(found.len() > 10_000);
        assert_eq!(found, lights(&world));
    }

    #[test]
    fn nothing_is_asked_for_that_does_not_decide() {
        let powers = LightPowers::of(&materials()).unwrap();
        let lights = |voxels: &[[i32; 3]]| {
            let world = World::from_voxels(materials(), voxels.iter().map(|at| (IVec3::from_array(*at), 2)));
            let content = world.tile(0, ChunkPos::new(0, 0, 0));
            let mut asked = Vec::new();
            let tile = TileLights::of(&content, (0, ChunkPos::new(0, 0, 0)), &powers, |face| {
                asked.push(face);
                Arc::new(Side::of(&Content::Full(1), face ^ 1))
            });
            (tile.len(), asked, tile.sides())
        };
        assert_eq!(lights(&[[20, 20, 20]]), (6, vec![], 0));
        assert_eq!(lights(&[[63, 0, 5], [63, 1, 5]]), (7, vec![1, 2], 0b110));
        assert!(LightPowers::of(&materials()[..2]).is_none());
    }

    #[test]
    fn coarse_lamps_are_as_large_as_their_cells_and_parts_stand_for_themselves() {
        let powers = LightPowers::of(&materials()).unwrap();
        // Two cells on both sides of a border between two parts.
        let world = World::from_voxels(materials(), [(IVec3::new(15, 0, 0), 2), (IVec3::new(16, 0, 0), 3)]);
        let content = world.tile(0, ChunkPos::new(0, 0, 0));
        let tile = TileLights::of(&content, (1, ChunkPos::new(-1, 0, 2)), &powers, |_| unreachable!());
        let (words, groups) = tile.encode(10);
        assert_eq!(words.len(), 12 * LIGHT_WORDS);
        let expected = |first, power: f32| LightGroup { first, count: 6, power: 6.0 * 16.0 * f64::from(power) };
        let [low, high] = [2, 3].map(|material| powers.get(material));
        assert_eq!(groups, [(0, expected(10, low)), (1, expected(16, high))]);
        assert_eq!(words[..4], [(-256_i32 + 60).cast_unsigned(), 0, 512, 2 | 1 << 19]);
        assert_eq!(words[LIGHT_WORDS + 3], 2 | 1 << 16 | 1 << 19, "face 1");
        let groups: Vec<LightGroup> = groups.iter().map(|(_, group)| *group).collect();
        let table = grouped_words(&groups);
        assert_eq!((table[0], table[1], table[4], table[5]), (10, 6, 16, 6));
        // The first light is drawn once in eleven times: its threshold is 2/11, and its alias is the other light.
        assert!((f64::from(f32::from_bits(table[2])) - 2.0 / 11.0).abs() < 1e-6 && table[3] == 1);
        let header = grouped_header(&groups, 7);
        assert_eq!((header[0], header[2], header[3]), (12, 7, 2));
    }
}

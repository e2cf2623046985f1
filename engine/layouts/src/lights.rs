//! The lamps of a world: every face through which an emissive voxel can give off light, with a table that draws one of them in constant
//! time. The twin of `shaders/include/raxel/light/lights.glsl`.

mod tile;

use glam::IVec3;

use raxel_world::Material;
use raxel_world::World;
use raxel_world::{block_cell, child_cell};
pub use tile::{LightGroup, LightPowers, TileLights, grouped_header, grouped_words};

use crate::block::words_and_quads;
use crate::{BlockMember, EncodingLimits, LayoutError};

/// Words in front of the lights: their number, the sum of their powers as a float, and where the groups of a streamed world are and how many;
/// a whole world has none.
pub const HEADER_WORDS: usize = 4;
/// Words of a light.
pub const LIGHT_WORDS: usize = 8;

/// A face of an emissive voxel that no other voxel covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// The voxel.
    pub voxel: IVec3,
    /// The face: 0 to 5 for −x, +x, −y, +y, −z, +z.
    pub face: u32,
    /// Palette index.
    pub material: u16,
    /// Luminance of the radiance that it gives off (ITU-R BT.709), which does not depend on the direction. The area is 1.
    pub power: f32,
}

impl Light {
    /// Its words; `level` is that of the cell that it is a face of.
    fn put(&self, draw: &Draw, level: u32, words: &mut Vec<u32>) {
        words.extend(self.voxel.to_array().map(i32::cast_unsigned));
        words.push(u32::from(self.material) | self.face << 16 | level << 19);
        words.extend([draw.probability.to_bits(), draw.threshold.to_bits(), draw.alias, self.power.to_bits()]);
    }
}

/// Every light of a world: chunk by chunk, in tree order inside each, the faces of a voxel in order. Faces that are black are left out.
pub fn lights(world: &World) -> Vec<Light> {
    lights_by(world, &world.materials().iter().map(power).collect::<Vec<_>>())
}

/// The same with the powers of its palette given. Materials beyond them emit nothing.
pub(crate) fn lights_by(world: &World, powers: &[f32]) -> Vec<Light> {
    let mut found = Vec::new();
    for (position, chunk) in world.chunks() {
        let origin = position.origin();
        for (block, &mask) in chunk.masks().iter().enumerate().filter(|(_, mask)| **mask != 0) {
            let corner = origin + glam::UVec3::from_array(block_cell(block)).as_ivec3() * 4;
            for (bit, material) in raxel_world::Bits(mask).zip(chunk.block_materials(block)) {
                let power = powers.get(usize::from(material)).copied().unwrap_or(0.0);
                if power > 0.0 {
                    let voxel = corner + glam::UVec3::from_array(child_cell(bit)).as_ivec3();
                    let bare = (0..6).filter(|face| is_bare(world, voxel, *face));
                    found.extend(bare.map(|face| Light { voxel, face, material, power }));
                }
            }
        }
    }
    found
}

/// Luminance of a material's emission; 0 where it is no number.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a list of lamps has 32-bit floats and numbers its lamps in 32 bits"
)]
pub(crate) fn power(material: &Material) -> f32 {
    let [r, g, b] = material.albedo.map(f64::from);
    let luminance = (0.2126 * r + 0.7152 * g + 0.0722 * b) * f64::from(material.emission);
    let power = luminance.min(f64::from(f32::MAX)) as f32;
    if power > 0.0 { power } else { 0.0 }
}

fn is_bare(world: &World, voxel: IVec3, face: u32) -> bool {
    let mut beside = voxel.to_array();
    let axis = (face >> 1) as usize;
    // Beyond the last coordinate there is nothing to light.
    let Some(next) = beside[axis].checked_add(if face & 1 == 1 { 1 } else { -1 }) else { return false };
    beside[axis] = next;
    world.voxel(IVec3::from_array(beside)) == 0
}

/// The content of the buffer of `source = "world.lights"`.
#[expect(clippy::cast_possible_truncation, reason = "a list of lamps has 32-bit floats and is addressed in 32 bits")]
pub fn encode(world: &World, limits: impl Into<EncodingLimits>) -> Result<Vec<u32>, LayoutError> {
    let lights = lights(world);
    let limit = limits.into().buffer_bytes;
    let bytes = 4 * (HEADER_WORDS + LIGHT_WORDS * lights.len().max(1)) as u64;
    if bytes > limit {
        return Err(LayoutError::TooManyLights { faces: lights.len() as u64, bytes, limit });
    }
    let total = lights.iter().fold(0.0, |total, light| total + f64::from(light.power));
    let mut words = Vec::with_capacity((bytes / 4) as usize);
    words.extend([lights.len() as u32, (total as f32).to_bits(), 0, 0]);
    let powers: Vec<f64> = lights.iter().map(|light| f64::from(light.power)).collect();
    for (light, draw) in lights.iter().zip(alias_table(&powers, total)) {
        light.put(&draw, 0, &mut words);
    }
    // An array without an element is none: shaders look at the count.
    words.resize((bytes / 4) as usize, 0);
    Ok(words)
}

/// An entry of the draw table. One entry is picked evenly: its light is drawn if a number in 0 to 1 is below the threshold, otherwise the alias.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Draw {
    pub(crate) probability: f32,
    pub(crate) threshold: f32,
    pub(crate) alias: u32,
}

/// Draws things in proportion to their powers, whose sum is `total` (Vose, "A linear algorithm for generating random numbers with a given
/// distribution", 1991).
#[expect(
    clippy::cast_possible_truncation,
    reason = "a list of lamps has 32-bit floats and numbers its lamps in 32 bits"
)]
pub(crate) fn alias_table(powers: &[f64], total: f64) -> Vec<Draw> {
    let count = powers.len() as f64;
    let mut scaled: Vec<f64> = powers.iter().map(|power| power / total * count).collect();
    let mut draws: Vec<Draw> = (0..)
        .zip(powers)
        .map(|(alias, power)| Draw { probability: (power / total) as f32, threshold: 1.0, alias })
        .collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..powers.len()).partition(|&i| scaled[i] < 1.0);
    while let (Some(low), Some(&high)) = (small.pop(), large.last()) {
        draws[low].threshold = scaled[low] as f32;
        draws[low].alias = high as u32;
        scaled[high] -= 1.0 - scaled[low];
        if scaled[high] < 1.0 {
            large.pop();
            small.push(high);
        }
    }
    // The remaining ones are 1 up to rounding, and stay.
    draws
}

/// The members of the buffer block that a shader must declare for the lights, in order.
pub fn block() -> Vec<BlockMember> {
    words_and_quads::<HEADER_WORDS>(["count", "power", "groups_at", "groups"])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Air, stone, a lamp, and one of ten times its power.
    fn materials() -> Vec<Material> {
        let lamp = |emission| Material { emission, ..Material::matt("lamp", [1.0; 3]) };
        let black = Material { emission: 5.0, ..Material::matt("black", [0.0; 3]) };
        vec![Material::air(), Material::matt("stone", [0.5; 3]), lamp(2.0), lamp(20.0), black]
    }

    #[test]
    fn the_bare_faces_of_lamps_are_listed_across_chunks() {
        // Two lamps side by side on both sides of a border of chunks, stone on the one, a black lamp that gives off nothing.
        let voxels = [([63, 0, 0], 2), ([64, 0, 0], 2), ([64, 1, 0], 1), ([9, 9, 9], 4)];
        let world = World::from_voxels(materials(), voxels.map(|(at, material)| (IVec3::from_array(at), material)));
        let found: Vec<_> = lights(&world).iter().map(|light| (light.voxel.to_array(), light.face)).collect();
        let expected = [
            ([63, 0, 0], 0),
            ([63, 0, 0], 2),
            ([63, 0, 0], 3),
            ([63, 0, 0], 4),
            ([63, 0, 0], 5),
            ([64, 0, 0], 1),
            ([64, 0, 0], 2),
            ([64, 0, 0], 4),
            ([64, 0, 0], 5),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn each_is_drawn_as_often_as_its_power_says() {
        let voxels = (0..7).map(|i| (IVec3::new(2 * i, 0, 0), if i == 3 { 3 } else { 2 }));
        let world = World::from_voxels(materials(), voxels);
        let lights = lights(&world);
        let total: f64 = lights.iter().map(|light| f64::from(light.power)).sum();
        let powers: Vec<f64> = lights.iter().map(|light| f64::from(light.power)).collect();
        let draws = alias_table(&powers, total);
        let mut drawn = vec![0.0; lights.len()];
        for (i, draw) in draws.iter().enumerate() {
            drawn[i] += f64::from(draw.threshold) / lights.len() as f64;
            drawn[draw.alias as usize] += f64::from(1.0 - draw.threshold) / lights.len() as f64;
        }
        for (light, (draw, drawn)) in lights.iter().zip(draws.iter().zip(&drawn)) {
            let share = f64::from(light.power) / total;
            assert!((drawn - share).abs() < 1e-7 && (f64::from(draw.probability) - share).abs() < 1e-7);
        }
        assert!((drawn.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_world_without_lamps_has_a_table_and_one_with_too_many_is_refused() {
        let words = encode(&World::empty(), 1024).unwrap();
        assert_eq!(words, [0; HEADER_WORDS + LIGHT_WORDS]);
        let world = World::from_voxels(materials(), [(IVec3::ZERO, 2)]);
        let words = encode(&world, 1024).unwrap();
        assert_eq!(words.len(), HEADER_WORDS + 6 * LIGHT_WORDS);
        let [power, share] = [2.0_f32, 1.0 / 6.0].map(f32::to_bits);
        assert_eq!(words[..HEADER_WORDS], [6, 12.0_f32.to_bits(), 0, 0]);
        let last = [0, 0, 0, 2 | 5 << 16, share, 1.0_f32.to_bits(), 5, power];
        assert_eq!(words[HEADER_WORDS + 5 * LIGHT_WORDS..], last);
        let error = encode(&world, 100).unwrap_err();
        assert_eq!(error, LayoutError::TooManyLights { faces: 6, bytes: 208, limit: 100 });
    }
}

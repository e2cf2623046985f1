//! The material of a voxel.

use serde::{Deserialize, Serialize};

/// A palette index. 0 is air; a world has at most [`MAX_MATERIALS`] materials besides it.
pub type MaterialIndex = u16;

/// The index of empty space.
pub const AIR: MaterialIndex = 0;

/// How many materials a world can have besides air.
pub const MAX_MATERIALS: usize = u16::MAX as usize;

/// A surface, for shaders and exporters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// The name it has in the world file or in the model.
    pub name: String,
    /// Linear (not sRGB) reflectance, each in 0…1.
    pub albedo: [f32; 3],
    /// 0 = mirror, 1 = matt.
    pub roughness: f32,
    /// 0 = dielectric, 1 = metal.
    pub metallic: f32,
    /// Strength of the light that it gives off, in multiples of `albedo`; 0 = none.
    pub emission: f32,
    /// 0 = opaque, 1 = clear.
    pub transparency: f32,
}

impl Material {
    /// A matt, opaque material of a linear colour.
    pub fn matt(name: impl Into<String>, albedo: [f32; 3]) -> Self {
        Self { name: name.into(), albedo, roughness: 1.0, metallic: 0.0, emission: 0.0, transparency: 0.0 }
    }

    /// The material at palette index 0: invisible, never hit.
    pub fn air() -> Self {
        Self { transparency: 1.0, ..Self::matt("air", [0.0; 3]) }
    }

    /// Whether both look the same, under any names.
    pub fn same_look(&self, other: &Self) -> bool {
        let look = |m: &Self| {
            (m.albedo.map(f32::to_bits), [m.roughness, m.metallic, m.emission, m.transparency].map(f32::to_bits))
        };
        look(self) == look(other)
    }
}

/// An sRGB byte as a linear value (IEC 61966-2-1).
#[expect(clippy::cast_possible_truncation, reason = "colours are 32-bit floats")]
pub fn linear_from_srgb(byte: u8) -> f32 {
    let s = f64::from(byte) / 255.0;
    let linear = if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

/// A linear value as the nearest sRGB byte.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the value is clamped to a byte")]
pub fn srgb_from_linear(linear: f32) -> u8 {
    let l = f64::from(linear).clamp(0.0, 1.0);
    let s = if l <= 0.003_130_8 { l * 12.92 } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
    (s * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_srgb_byte_survives_linear() {
        for byte in 0..=255 {
            assert_eq!(srgb_from_linear(linear_from_srgb(byte)), byte);
        }
    }
}

//! From palette and material properties to materials.

use super::reader::{Attributes, VoxFile};
use crate::material::{AIR, Material, MaterialIndex, linear_from_srgb};

/// The palette of files that have none of their own: a 6 × 6 × 6 cube from white to black without its last corner, then ramps of
/// red, green, blue and grey.
pub(super) fn default_palette() -> Vec<[u8; 4]> {
    let steps = [0xff, 0xcc, 0x99, 0x66, 0x33, 0x00];
    let ramp = [0xee, 0xdd, 0xbb, 0xaa, 0x88, 0x77, 0x55, 0x44, 0x22, 0x11];
    let cube = (0..215).map(|i| [steps[i / 36], steps[i / 6 % 6], steps[i % 6], 255]);
    let ramps = (0..4).flat_map(|channel| {
        ramp.map(|value| match channel {
            0 => [value, 0, 0, 255],
            1 => [0, value, 0, 255],
            2 => [0, 0, value, 255],
            _ => [value, value, value, 255],
        })
    });
    cube.chain(ramps).chain([[0, 0, 0, 0]]).collect()
}

/// The material of every palette index; that of index 0 is never used.
pub(super) fn materials(file: &VoxFile) -> Vec<Material> {
    let default = default_palette();
    let palette = file.palette.as_ref().unwrap_or(&default);
    (0..=255u8)
        .map(|index| {
            let [r, g, b, _] = palette.get(usize::from(index).wrapping_sub(1)).copied().unwrap_or_default();
            let mut material = Material::matt(format!("c{index}"), [r, g, b].map(linear_from_srgb));
            if let Some(attributes) = file.materials.get(&index) {
                apply(&mut material, attributes);
            }
            material
        })
        .collect()
}

/// Keeps the materials that models use. Gives the new index of each palette index, and the materials with air first.
#[expect(clippy::cast_possible_truncation, reason = "a palette of a .vox file has 256 entries")]
pub(super) fn used(file: &VoxFile, materials: Vec<Material>) -> (Vec<MaterialIndex>, Vec<Material>) {
    let mut is_used = [false; 256];
    file.models.iter().flat_map(|model| &model.voxels).for_each(|voxel| is_used[usize::from(voxel[3])] = true);
    let mut kept = vec![Material::air()];
    let index_of = (materials.into_iter().zip(is_used))
        .map(|(material, used)| {
            if !used {
                return AIR;
            }
            kept.push(material);
            (kept.len() - 1) as MaterialIndex
        })
        .collect();
    (index_of, kept)
}

/// Reads MATL properties. Each counts only for the types of material that show it, as in MagicaVoxel; light is `_emit`, with
/// `_flux` as further multiples of it.
#[expect(clippy::cast_possible_truncation, reason = "materials are 32-bit floats")]
fn apply(material: &mut Material, attributes: &Attributes) {
    let number =
        |key: &str| attributes.get(key).and_then(|text| text.trim().parse::<f64>().ok()).filter(|n| n.is_finite());
    let unit = |key: &str| number(key).map(|n| n.clamp(0.0, 1.0) as f32);
    let kind = attributes.get("_type").map_or("_diffuse", String::as_str);
    let weight = unit("_weight");
    if let Some(name) = attributes.get("_name") {
        material.name.clone_from(name);
    }
    if kind != "_diffuse" {
        material.roughness = unit("_rough").unwrap_or(material.roughness);
    }
    if matches!(kind, "_metal" | "_blend") {
        material.metallic = unit("_metal").or(weight).unwrap_or(1.0);
    }
    if matches!(kind, "_glass" | "_blend") {
        let from_alpha = unit("_alpha").map(|alpha| 1.0 - alpha);
        material.transparency = unit("_trans").or(weight).or(from_alpha).unwrap_or(0.5);
    }
    if matches!(kind, "_emit" | "_blend") {
        let strength = unit("_emit").or(weight).unwrap_or(0.0);
        let flux = number("_flux").unwrap_or(0.0).clamp(0.0, 1e6);
        material.emission = (f64::from(strength) * (1.0 + flux)) as f32;
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_default_palette_is_that_of_the_format() {
        let ours: Vec<_> = super::default_palette();
        let theirs: Vec<_> = dot_vox::DEFAULT_PALETTE.iter().map(|c| [c.r, c.g, c.b, c.a]).collect();
        assert_eq!(ours[..255], theirs[..255]);
    }
}

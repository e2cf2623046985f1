//! From a world to a .vox file: models of at most 256³ voxels, each placed by a node of the scene graph.

use std::collections::BTreeMap;

use super::error::ExportError;
use crate::material::{Material, MaterialIndex, srgb_from_linear};
use crate::orientation::Orientation;
use crate::world::World;

/// Edge of the largest model.
const EDGE: i64 = 256;

/// Voxels that fit into one file: 4 bytes each, in chunks whose sizes are 32 bits wide.
const MAX_VOXELS: u64 = 1 << 28;

/// Writes a world. Imported again it has the same voxels; colours are rounded to sRGB bytes.
#[expect(
    clippy::cast_possible_truncation,
    reason = "there are 255 materials at most, remainders are below `EDGE`, and there are at most `MAX_VOXELS` voxels"
)]
pub fn export(world: &World) -> Result<Vec<u8>, ExportError> {
    let used: Vec<MaterialIndex> =
        (1..world.materials().len()).filter(|&i| world.counts()[i] > 0).map(|i| i as MaterialIndex).collect();
    if used.len() > 255 {
        return Err(ExportError::TooManyMaterials { used: used.len() });
    }
    if world.solids() > MAX_VOXELS {
        return Err(ExportError::TooManyVoxels { voxels: world.solids(), limit: MAX_VOXELS });
    }
    let mut color_of = vec![0u8; world.materials().len()];
    used.iter().zip(1..=255).for_each(|(&material, color)| color_of[usize::from(material)] = color);

    // Cells of the file, by the cube of 256³ that they fall into.
    let mut cubes: BTreeMap<[i64; 3], Vec<[u8; 4]>> = BTreeMap::new();
    for (cell, material) in world.voxels() {
        let cell = Orientation::Z_UP_FROM_Y_UP.cell(cell.to_array().map(i64::from));
        let [x, y, z] = cell.map(|c| c.rem_euclid(EDGE) as u8);
        cubes.entry(cell.map(|c| c.div_euclid(EDGE))).or_default().push([x, y, z, color_of[usize::from(material)]]);
    }

    let mut out = Vec::new();
    let mut nodes = Nodes::new(cubes.len());
    for (cube, mut voxels) in cubes {
        let min: [u8; 3] = std::array::from_fn(|i| voxels.iter().map(|v| v[i]).min().unwrap_or(0));
        let max: [u8; 3] = std::array::from_fn(|i| voxels.iter().map(|v| v[i]).max().unwrap_or(0));
        let size: [u32; 3] = std::array::from_fn(|i| u32::from(max[i] - min[i]) + 1);
        for voxel in &mut voxels {
            (0..3).for_each(|i| voxel[i] -= min[i]);
        }
        voxels.sort_unstable();
        chunk(&mut out, *b"SIZE", &size.map(u32::to_le_bytes).concat());
        let count = (voxels.len() as u32).to_le_bytes();
        chunk(&mut out, *b"XYZI", &[&count[..], voxels.as_flattened()].concat());
        // A model stands about the lattice point at half its size.
        nodes.place(std::array::from_fn(|i| cube[i] * EDGE + i64::from(min[i]) + i64::from(size[i] / 2)));
    }
    out.extend(nodes.finish());
    let materials: Vec<&Material> = used.iter().map(|&index| &world.materials()[usize::from(index)]).collect();
    write_palette(&mut out, &materials);

    let mut file = b"VOX ".to_vec();
    file.extend(150u32.to_le_bytes());
    file.extend(b"MAIN");
    file.extend(0u32.to_le_bytes());
    file.extend(length(out.len())?.to_le_bytes());
    file.extend(out);
    Ok(file)
}

/// The length of a chunk as the file has it.
fn length(bytes: usize) -> Result<u32, ExportError> {
    u32::try_from(bytes).map_err(|_| ExportError::TooLarge { bytes: bytes as u64, limit: u32::MAX })
}

/// The scene graph: a root transform, a group, and a transform with a shape for each model.
struct Nodes {
    children: Vec<u8>,
    count: u32,
    out: Vec<u8>,
}

impl Nodes {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "`export` refuses files of 4 GiB and more, and no part is larger than the file"
    )]
    fn new(models: usize) -> Self {
        let mut out = Vec::new();
        chunk(&mut out, *b"nTRN", &transform(0, 1, None));
        let mut group = 1u32.to_le_bytes().to_vec();
        group.extend(attributes(&[]));
        group.extend((models as u32).to_le_bytes());
        (0..models as u32).for_each(|model| group.extend((2 + 2 * model).to_le_bytes()));
        chunk(&mut out, *b"nGRP", &group);
        Self { children: Vec::new(), count: 0, out }
    }

    fn place(&mut self, to: [i64; 3]) {
        let id = 2 + 2 * self.count;
        chunk(&mut self.children, *b"nTRN", &transform(id, id + 1, Some(to)));
        let mut shape = (id + 1).to_le_bytes().to_vec();
        shape.extend(attributes(&[]));
        shape.extend(1u32.to_le_bytes());
        shape.extend(self.count.to_le_bytes());
        shape.extend(attributes(&[]));
        chunk(&mut self.children, *b"nSHP", &shape);
        self.count += 1;
    }

    fn finish(mut self) -> Vec<u8> {
        self.out.extend(self.children);
        self.out
    }
}

fn transform(id: u32, child: u32, to: Option<[i64; 3]>) -> Vec<u8> {
    let mut content = id.to_le_bytes().to_vec();
    content.extend(attributes(&[]));
    content.extend(child.to_le_bytes());
    content.extend(u32::MAX.to_le_bytes());
    // Layer 0 for models, none for the root.
    content.extend(to.map_or(u32::MAX, |_| 0).to_le_bytes());
    content.extend(1u32.to_le_bytes());
    content.extend(match to {
        Some([x, y, z]) => attributes(&[("_t", format!("{x} {y} {z}"))]),
        None => attributes(&[]),
    });
    content
}

fn write_palette(out: &mut Vec<u8>, materials: &[&Material]) {
    let mut palette = vec![0u8; 1024];
    for (color, material) in palette.chunks_exact_mut(4).zip(materials) {
        let [r, g, b] = material.albedo.map(srgb_from_linear);
        color.copy_from_slice(&[r, g, b, 255]);
    }
    chunk(out, *b"RGBA", &palette);
    for (material, id) in materials.iter().zip(1u32..) {
        let mut content = id.to_le_bytes().to_vec();
        content.extend(properties(material));
        chunk(out, *b"MATL", &content);
    }
}

/// MATL properties that read back as the same numbers.
fn properties(material: &Material) -> Vec<u8> {
    let m = material;
    let shown = [m.metallic > 0.0, m.transparency > 0.0, m.emission > 0.0];
    let kind = match shown {
        // MagicaVoxel's diffuse is matt; everything else has a roughness.
        [false, false, false] if m.roughness >= 1.0 => "_diffuse",
        [_, false, false] => "_metal",
        [false, true, false] => "_glass",
        [false, false, true] => "_emit",
        _ => "_blend",
    };
    let emit = f64::from(m.emission.min(1.0));
    let flux = (f64::from(m.emission) - 1.0).max(0.0);
    attributes(&[
        ("_type", kind.to_owned()),
        ("_name", m.name.clone()),
        ("_rough", m.roughness.to_string()),
        ("_metal", m.metallic.to_string()),
        ("_trans", m.transparency.to_string()),
        ("_alpha", (1.0 - m.transparency).to_string()),
        ("_emit", emit.to_string()),
        ("_flux", flux.to_string()),
    ])
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "`export` refuses files of 4 GiB and more, and no part is larger than the file"
)]
fn attributes(entries: &[(&str, String)]) -> Vec<u8> {
    let mut out = (entries.len() as u32).to_le_bytes().to_vec();
    for (key, value) in entries {
        for text in [*key, value.as_str()] {
            out.extend((text.len() as u32).to_le_bytes());
            out.extend(text.as_bytes());
        }
    }
    out
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "`export` refuses files of 4 GiB and more, and no part is larger than the file"
)]
fn chunk(out: &mut Vec<u8>, id: [u8; 4], content: &[u8]) {
    out.extend(id);
    out.extend((content.len() as u32).to_le_bytes());
    out.extend(0u32.to_le_bytes());
    out.extend(content);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_longer_than_it_can_say_is_refused() {
        let longest = u32::MAX as usize;
        assert_eq!(length(longest), Ok(u32::MAX));
        assert_eq!(length(longest + 1), Err(ExportError::TooLarge { bytes: 1 << 32, limit: u32::MAX }));
    }
}

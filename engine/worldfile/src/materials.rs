//! `[materials.*]`: the palette by name.

use std::collections::HashMap;

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::table::{Node, Table};
use raxel_diagnostics::{Diagnostic, codes};

use raxel_world::{MAX_MATERIALS, Material, MaterialIndex, linear_from_srgb};

/// Materials in the order of their palette index, with their names.
pub(super) struct Palette {
    materials: Vec<Material>,
    by_name: HashMap<String, MaterialIndex>,
}

impl Palette {
    /// Reads every material, in the order of the file.
    pub(super) fn read(root: &Table<'_, '_>) -> Self {
        let mut palette = Self { materials: vec![Material::air()], by_name: HashMap::new() };
        for (name, node, table) in root.tables("materials") {
            let material = material(&name, &table);
            let Some(index) = palette.add(material) else {
                node.report(codes::world::TOO_MANY_MATERIALS, too_many(), "");
                break;
            };
            palette.by_name.insert(name, index);
        }
        palette
    }

    /// Adds a material. `None` when there is no index left.
    #[expect(clippy::cast_possible_truncation, reason = "an index is at most `MAX_MATERIALS`")]
    pub(super) fn add(&mut self, material: Material) -> Option<MaterialIndex> {
        let index = self.materials.len();
        (index <= MAX_MATERIALS).then(|| {
            self.materials.push(material);
            index as MaterialIndex
        })
    }

    /// The index of the material that a value names.
    pub(super) fn find(&self, node: &Node<'_, '_>) -> Option<MaterialIndex> {
        let name = node.string()?;
        if let Some(index) = self.by_name.get(&name) {
            return Some(*index);
        }
        let mut names: Vec<&str> = self.by_name.keys().map(String::as_str).collect();
        names.sort_unstable();
        let diagnostic = Diagnostic::error(codes::world::UNKNOWN_MATERIAL, format!("there is no material `{name}`"))
            .label(node.span.clone(), "named here");
        node.reporter().report(match closest(&name, names.iter().copied()) {
            Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
            None if names.is_empty() => diagnostic.help(format!("declare it: [materials.{name}]")),
            None => diagnostic.help(format!("materials: {}", list(names.into_iter()))),
        });
        None
    }

    pub(super) fn into_materials(self) -> Vec<Material> {
        self.materials
    }
}

pub(super) fn too_many() -> String {
    format!("a world has at most {MAX_MATERIALS} materials")
}

#[expect(clippy::cast_possible_truncation, reason = "materials are 32-bit floats")]
fn material(name: &str, table: &Table<'_, '_>) -> Material {
    let albedo = table.need("albedo").and_then(|node| color(&node)).unwrap_or([1.0, 0.0, 1.0]);
    let number = |key: &str, most: f64, default: f32| {
        table.get(key).and_then(|node| node.number(0.0..=most)).map_or(default, |value| value as f32)
    };
    let material = Material {
        name: name.to_owned(),
        albedo,
        roughness: number("roughness", 1.0, 1.0),
        metallic: number("metallic", 1.0, 0.0),
        emission: number("emission", 1e6, 0.0),
        transparency: number("transparency", 1.0, 0.0),
    };
    table.finish();
    material
}

/// `"#rrggbb"` in sRGB, or three linear numbers.
#[expect(clippy::cast_possible_truncation, reason = "materials are 32-bit floats, and a colour has 8 bits a channel")]
fn color(node: &Node<'_, '_>) -> Option<[f32; 3]> {
    if node.is_array() {
        return Some(node.numbers::<3>(0.0..=1.0)?.map(|value| value as f32));
    }
    let text = node.string()?;
    let bytes = text.strip_prefix('#').filter(|hex| hex.len() == 6 && hex.bytes().all(|b| b.is_ascii_hexdigit()));
    let Some(value) = bytes.and_then(|hex| u32::from_str_radix(hex, 16).ok()) else {
        node.report(
            codes::world::COLOR,
            format!("`{text}` is not a colour"),
            "`#rrggbb`, or three linear numbers in 0…1",
        );
        return None;
    };
    Some([16, 8, 0].map(|shift| linear_from_srgb((value >> shift) as u8)))
}

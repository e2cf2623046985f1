//! `[materials.*]`: the palette by name.

use std::collections::HashMap;

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::table::Node;
use raxel_diagnostics::{Diagnostic, codes};
use raxel_language::{Describe, Keys, ReadKeys, Shape, Value, describe};
use raxel_world::{MAX_MATERIALS, Material, MaterialIndex, linear_from_srgb};
use serde_json::json;

use super::reading::Reading;

/// Materials in the order of their palette index, with their names.
pub(super) struct Palette {
    materials: Vec<Material>,
    by_name: HashMap<String, MaterialIndex>,
}

impl Default for Palette {
    fn default() -> Self {
        Self { materials: vec![Material::air()], by_name: HashMap::new() }
    }
}

/// A material, as in the file.
#[derive(Keys)]
struct Look {
    /// "#rrggbb" in sRGB, or three linear numbers from 0 to 1.
    #[keys(read = color, shape = color_shape())]
    albedo: [f64; 3],
    /// 0 is a mirror, 1 is matt.
    #[keys(range = 0.0..=1.0, default = 1.0)]
    roughness: f64,
    /// 0 is no metal, 1 is metal.
    #[keys(range = 0.0..=1.0, default = 0.0)]
    metallic: f64,
    /// Light that it gives off, as a multiple of its albedo.
    #[keys(range = 0.0..=1e6, default = 0.0)]
    emission: f64,
    /// 0 is opaque, 1 is clear.
    #[keys(range = 0.0..=1.0, default = 0.0)]
    transparency: f64,
}

impl Look {
    #[expect(clippy::cast_possible_truncation, reason = "materials are 32-bit floats")]
    fn material(self, name: &str) -> Material {
        Material {
            name: name.to_owned(),
            albedo: self.albedo.map(|value| value as f32),
            roughness: self.roughness as f32,
            metallic: self.metallic as f32,
            emission: self.emission as f32,
            transparency: self.transparency as f32,
        }
    }
}

/// Reads `[materials.*]`: all join the palette in the order of the file. One that is wrong keeps its name, so that using it is no mistake.
pub(super) fn declare(node: &Node<'_, '_>, reading: &Reading<'_>) -> Option<()> {
    let mut palette = reading.palette.borrow_mut();
    for (name, node) in node.table()?.entries() {
        let Some(table) = node.table() else { continue };
        let material = Look::read_whole(&table, &()).map_or_else(Material::air, |look| look.material(&name));
        let Some(index) = palette.add(material) else {
            node.report(codes::world::TOO_MANY_MATERIALS, too_many(), "");
            break;
        };
        palette.by_name.insert(name, index);
    }
    Some(())
}

/// The shape of `[materials.*]`.
pub(super) fn declared() -> Shape {
    let look = Look::form().schema();
    Shape::Schema(json!({ "type": "object", "maxProperties": MAX_MATERIALS, "additionalProperties": look }))
}

/// A material, by its name.
#[derive(Clone, Copy)]
pub(super) struct Named(pub(super) MaterialIndex);

/// One material, or a list of some.
#[derive(Default)]
pub(super) struct Materials(pub(super) Vec<MaterialIndex>);

describe! {
    Named => Shape::Text;
    Materials => Shape::Either(vec![Shape::Text, Shape::array(Shape::Text, 1..)]);
}

impl Value<Reading<'_>> for Named {
    fn read(node: &Node<'_, '_>, (): &(), reading: &Reading<'_>) -> Option<Self> {
        reading.palette.borrow().find(node).map(Self)
    }
}

impl Value<Reading<'_>> for Materials {
    fn read(node: &Node<'_, '_>, (): &(), reading: &Reading<'_>) -> Option<Self> {
        let palette = reading.palette.borrow();
        if !node.is_array() {
            return Some(Self(vec![palette.find(node)?]));
        }
        let names = node.array()?;
        if names.is_empty() {
            return node.bad_value(format!("`{}` needs at least one material", node.name));
        }
        let found: Vec<_> = names.iter().map(|name| palette.find(name)).collect();
        found.into_iter().collect::<Option<_>>().map(Self)
    }
}

impl Palette {
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

fn color_shape() -> Shape {
    let hex = Shape::Schema(json!({ "type": "string", "pattern": "^#[0-9a-fA-F]{6}$" }));
    Shape::Either(vec![hex, <[f64; 3]>::shape(&(0.0..=1.0).into())])
}

/// `"#rrggbb"` in sRGB, or three linear numbers.
#[expect(clippy::cast_possible_truncation, reason = "a colour has 8 bits a channel")]
fn color(node: &Node<'_, '_>) -> Option<[f64; 3]> {
    if node.is_array() {
        return node.numbers(0.0..=1.0);
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
    Some([16, 8, 0].map(|shift| linear_from_srgb((value >> shift) as u8).into()))
}

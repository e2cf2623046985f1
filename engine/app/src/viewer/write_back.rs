//! Values that were found in the window, written into the files that they belong to. Comments and order of a file stay as they are.

use std::fs;
use std::path::Path;

use raxel_graph::checked::Value;
use raxel_runtime::camera::Camera;
use raxel_runtime::params::{components, is_integer};
use toml_edit::{Array, DocumentMut, Formatted, Item, Table, value};

use raxel_output::replace;

/// Changes the text of a file. Errors are one line each.
pub(crate) fn edit(path: &Path, change: impl FnOnce(&str) -> Result<String, String>) -> Result<(), String> {
    let said = |error: std::io::Error| format!("{}: {error}", path.display());
    let before = fs::read_to_string(path).map_err(said)?;
    let after = change(&before)?;
    if after == before { Ok(()) } else { replace(path, after.as_bytes()).map_err(said) }
}

/// The text of a graph with another default of a param.
pub(crate) fn with_param(text: &str, name: &str, new: &Value) -> Result<String, String> {
    let mut document = parsed(text)?;
    let param = document.get_mut("params").and_then(|params| params.get_mut(name));
    let default = param.and_then(|param| param.as_table_like_mut()?.get_mut("default")?.as_value_mut());
    let default = default.ok_or_else(|| format!("the file has no `default` of the param `{name}`"))?;
    let decor = default.decor().clone();
    *default = literal(new);
    *default.decor_mut() = decor;
    Ok(document.to_string())
}

/// The text of a world with a camera under a name; one that has it already is replaced.
pub(crate) fn with_camera(text: &str, name: &str, camera: &Camera) -> Result<String, String> {
    let mut document = parsed(text)?;
    let cameras = document.entry("cameras").or_insert_with(|| {
        let mut table = Table::new();
        // Only its members are written as tables.
        table.set_implicit(true);
        Item::Table(table)
    });
    let cameras = cameras.as_table_like_mut().ok_or("`cameras` of the file is not a table")?;
    let mut table = Table::new();
    for (key, written) in camera_values(camera) {
        table.insert(key, written);
    }
    if let Some(old) = cameras.get(name).and_then(Item::as_table) {
        *table.decor_mut() = old.decor().clone();
        table.set_position(old.position());
    }
    cameras.insert(name, Item::Table(table));
    Ok(document.to_string())
}

/// A camera as the lines of a world's file, under a name.
pub(crate) fn camera_lines(name: &str, camera: &Camera) -> String {
    let lines = camera_values(camera).map(|(key, value)| format!("{key} = {}\n", value.to_string().trim()));
    format!("[cameras.{name}]\n{}", lines.concat())
}

/// As exact as a thousandth of a voxel, of a degree and of a second are read by people; never -0.
pub(super) fn rounded(number: f64) -> f64 {
    (number * 1000.0).round() / 1000.0 + 0.0
}

pub(super) fn camera_values(camera: &Camera) -> [(&'static str, Item); 4] {
    let degrees = |radians: f64| value(rounded(radians.to_degrees()));
    let position: Array = camera.position().to_array().into_iter().map(rounded).collect();
    [
        ("position", value(position)),
        ("yaw", degrees(camera.yaw)),
        ("pitch", degrees(camera.pitch)),
        ("fov", degrees(camera.fov)),
    ]
}

pub(super) fn parsed(text: &str) -> Result<DocumentMut, String> {
    text.parse().map_err(|error: toml_edit::TomlError| format!("the file is broken: {}", error.message()))
}

/// A value as TOML writes it, floats by their shortest digits.
#[expect(clippy::cast_possible_truncation, reason = "the number is the component of a value of 32 bits")]
fn literal(written: &Value) -> toml_edit::Value {
    let number = |number: f64| {
        if is_integer(written) {
            toml_edit::Value::Integer(Formatted::new(number as i64))
        } else {
            let shortest = (number as f32).to_string().parse().unwrap_or(number);
            toml_edit::Value::Float(Formatted::new(shortest))
        }
    };
    if let Value::Bool(on) = written {
        return (*on).into();
    }
    match components(written).as_slice() {
        [single] => number(*single),
        several => toml_edit::Value::Array(several.iter().copied().map(number).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRAPH: &str = "# A graph.\nname = \"a\"\n\n[params.exposure] # how bright\ntype    = \"f32\"\n\
                         default = 0.85 # try 4.0\nrange = [0.0, 8.0]\n\n[params]\nfog = { type = \"bool\", default = false }\n\
                         steps = { type = \"i32\", default = 3 }\ntint = { type = \"vec3\", default = [1, 1, 1] }\n";

    #[test]
    fn a_default_changes_and_comments_stay() {
        let text = with_param(GRAPH, "exposure", &Value::F32(0.1)).unwrap();
        assert_eq!(text, GRAPH.replace("0.85 #", "0.1 #"));
        let text = with_param(GRAPH, "fog", &Value::Bool(true)).unwrap();
        assert_eq!(text, GRAPH.replace("false", "true"));
        let text = with_param(GRAPH, "steps", &Value::I32(-7)).unwrap();
        assert_eq!(text, GRAPH.replace("default = 3", "default = -7"));
        let text = with_param(GRAPH, "tint", &Value::Vec3([0.5, 0.25, 1.0])).unwrap();
        assert_eq!(text, GRAPH.replace("[1, 1, 1]", "[0.5, 0.25, 1.0]"));
    }

    #[test]
    fn a_file_that_does_not_have_it_is_left_alone() {
        assert!(with_param(GRAPH, "gamma", &Value::F32(1.0)).unwrap_err().contains("gamma"));
        assert!(with_param("params = 3", "gamma", &Value::F32(1.0)).is_err());
        assert!(with_param("a = ", "gamma", &Value::F32(1.0)).unwrap_err().starts_with("the file is broken"));
    }

    #[test]
    fn a_camera_is_added_and_replaced() {
        let world = "name = \"w\"\n\n# where to stand\n[cameras.ground]\nposition = [0, 1, 2]\n\n[materials]\na = { albedo = \"#ffffff\" }\n";
        let mut camera = Camera::at([10.25, -3.0, 7.5]);
        camera.yaw = 0.5_f64.to_radians();
        let added = with_camera(world, "roof", &camera).unwrap();
        // It stands with the other cameras, and nothing else has changed.
        let (before, after) = world.split_at(world.find("[materials]").unwrap());
        assert!(added.starts_with(before) && added.ends_with(after), "{added}");
        let lines = "[cameras.roof]\nposition = [10.25, -3.0, 7.5]\nyaw = 0.5\npitch = 0.0\nfov = 60.0\n";
        assert_eq!(camera_lines("roof", &camera), lines);
        assert!(added.contains(lines), "{added}");
        let replaced = with_camera(world, "ground", &camera).unwrap();
        assert!(replaced.contains("# where to stand\n[cameras.ground]\nposition = [10.25, -3.0, 7.5]\n"), "{replaced}");
        assert!(!replaced.contains("[0, 1, 2]") && replaced.contains("[materials]"), "{replaced}");
        assert_eq!(with_camera("", "a", &camera).unwrap(), camera_lines("a", &camera));
        assert!(with_camera("cameras = 1", "a", &camera).is_err());
    }
}

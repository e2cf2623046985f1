//! Values that were found in the window, written into the files that they belong to. Comments and order of a file stay as they are.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use raxel_graph::checked::Value;
use raxel_output::replace;
use raxel_runtime::camera::Camera;
use raxel_runtime::params::{components, is_integer};
use raxel_runtime::project::Project;
use toml_edit::{Array, DocumentMut, Formatted, Item, Table, value};

/// The changes of one write.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// Project path of the file.
    pub file: String,
    path: PathBuf,
    /// Its text, if the file exists.
    before: Option<String>,
    after: Option<String>,
}

impl Written {
    /// A text that replaces the one before.
    pub fn of(file: &str, path: &Path, before: Option<String>, after: String) -> Self {
        Self { file: file.to_owned(), path: path.to_owned(), before, after: Some(after) }
    }

    /// Restores the file, and returns the changes of that. Refused when somebody else has written it since. Errors are one line each.
    pub fn undo(&self) -> Result<Written, String> {
        let Self { file, path, before, after } = self;
        let said = |error: std::io::Error| format!("{file}: {error}");
        if text_of(path).map_err(said)? != *after {
            return Err(format!("{file} has been edited since it was written: nothing is undone there"));
        }
        match before {
            Some(text) => replace(path, text.as_bytes()),
            None => fs::remove_file(path),
        }
        .map_err(said)?;
        Ok(Written { before: after.clone(), after: before.clone(), ..self.clone() })
    }
}

/// The text of a file; `None` where there is none.
pub(super) fn text_of(path: &Path) -> std::io::Result<Option<String>> {
    match fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        read => read.map(Some),
    }
}

/// Makes a file of a project that is not there yet. Errors are one line each.
pub fn create(project: &Project, file: &str, text: &str) -> Result<Written, String> {
    let path = project.on_disk(file);
    if path.exists() {
        return Err(format!("{file} is there already"));
    }
    replace(&path, text.as_bytes()).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(Written::of(file, &path, None, text.to_owned()))
}

/// Changes the text of a file of a project; `None` when the text stays as it is. Errors are one line each.
pub fn edit(
    project: &Project,
    file: &str,
    change: impl FnOnce(&str) -> Result<String, String>,
) -> Result<Option<Written>, String> {
    let path = project.on_disk(file);
    let said = |error: std::io::Error| format!("{}: {error}", path.display());
    let before = fs::read_to_string(&path).map_err(said)?;
    let after = change(&before)?;
    if after == before {
        return Ok(None);
    }
    replace(&path, after.as_bytes()).map_err(said)?;
    Ok(Some(Written::of(file, &path, Some(before), after)))
}

/// Names of the params whose default the text of a graph has. A text that is no TOML has none.
pub fn defaults(text: &str) -> Vec<String> {
    let Ok(document) = parsed(text) else { return Vec::new() };
    let params = document.get("params").and_then(Item::as_table_like);
    let with_default = |(_, param): &(&str, &Item)| param.get("default").is_some();
    params.map_or_else(Vec::new, |params| params.iter().filter(with_default).map(|(name, _)| name.to_owned()).collect())
}

/// The text of a graph with a default of a param, which the file may inherit so far.
pub(crate) fn with_override(text: &str, name: &str, new: &Value) -> Result<String, String> {
    if defaults(text).iter().any(|known| known == name) {
        return with_param(text, name, new);
    }
    let mut document = parsed(text)?;
    let params = document.entry("params").or_insert_with(implicit_table);
    let params = params.as_table_like_mut().ok_or("`params` of the file is not a table")?;
    let param = params.entry(name).or_insert(Item::Table(Table::new()));
    let param = param.as_table_like_mut().ok_or_else(|| format!("`params.{name}` of the file is not a table"))?;
    param.insert("default", Item::Value(literal(new)));
    Ok(document.to_string())
}

/// A table that is not written itself, but only its members.
pub(super) fn implicit_table() -> Item {
    let mut table = Table::new();
    table.set_implicit(true);
    Item::Table(table)
}

/// The text of a graph with another default of a param that it has.
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
    let cameras = document.entry("cameras").or_insert_with(implicit_table);
    let cameras = cameras.as_table_like_mut().ok_or("`cameras` of the file is not a table")?;
    let mut table = Table::new();
    for (key, written) in camera_values(&in_one_turn(camera)) {
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
pub fn camera_lines(name: &str, camera: &Camera) -> String {
    let lines =
        camera_values(&in_one_turn(camera)).map(|(key, value)| format!("{key} = {}\n", value.to_string().trim()));
    format!("[cameras.{name}]\n{}", lines.concat())
}

/// As exact as a thousandth of a voxel, of a degree and of a second are read by people; never -0.
pub(super) fn rounded(number: f64) -> f64 {
    (number * 1000.0).round() / 1000.0 + 0.0
}

/// The same view, with a yaw that a world may have.
fn in_one_turn(camera: &Camera) -> Camera {
    Camera { yaw: camera.yaw % std::f64::consts::TAU, ..*camera }
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
pub(super) fn literal(written: &Value) -> toml_edit::Value {
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
    fn an_inherited_default_is_overridden_and_nothing_else_changes() {
        let own = "extends = \"base.toml\"\n# thicker\n[params.fog]\nlabel = \"Fog\"\n\n[[passes]]\nname = \"a\"\n";
        let text = with_override(own, "exposure", &Value::F32(0.5)).unwrap();
        assert_eq!(defaults(&text), ["exposure"]);
        assert_eq!(text.replace("\n[params.exposure]\ndefault = 0.5\n", ""), own, "{text}");
        // A table that is there gets the key, and a default that is there is replaced.
        let text = with_override(own, "fog", &Value::Bool(true)).unwrap();
        assert_eq!(text, own.replace("label = \"Fog\"\n", "label = \"Fog\"\ndefault = true\n"));
        assert_eq!(with_override(&text, "fog", &Value::Bool(false)).unwrap(), text.replace("true", "false"));
        assert!(with_override("params = 3", "fog", &Value::Bool(true)).is_err());
        assert_eq!(defaults(GRAPH), ["exposure", "fog", "steps", "tint"]);
    }

    #[test]
    fn a_write_is_undone_unless_somebody_else_has_written_since() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("raxel.toml"), "").unwrap();
        fs::write(folder.path().join("a.toml"), GRAPH).unwrap();
        let project = Project::at(folder.path()).unwrap();
        let read = || fs::read_to_string(folder.path().join("a.toml")).unwrap();
        let write = || edit(&project, "a.toml", |text| with_param(text, "exposure", &Value::F32(0.1))).unwrap();
        let written = write().unwrap();
        assert_eq!((written.file.as_str(), write()), ("a.toml", None), "the text has the value already");
        assert_ne!(read(), GRAPH);
        let undone = written.undo().unwrap();
        assert_eq!(read(), GRAPH);
        // The undone write is made again.
        assert_eq!(undone.undo().as_ref(), Ok(&written));
        assert_ne!(read(), GRAPH);
        written.undo().unwrap();
        let made = create(&project, "b.toml", "# new").unwrap();
        assert!(create(&project, "b.toml", "# newer").unwrap_err().contains("is there already"));
        let gone = made.undo().unwrap();
        assert!(!folder.path().join("b.toml").exists());
        gone.undo().unwrap();
        assert_eq!(fs::read_to_string(folder.path().join("b.toml")).unwrap(), "# new");
        let written = write().unwrap();
        fs::write(folder.path().join("a.toml"), "# mine\n").unwrap();
        assert!(written.undo().unwrap_err().contains("edited since"));
        assert_eq!(read(), "# mine\n");
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

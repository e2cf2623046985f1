//! Values of a session, written into the files of its project or into its presets.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use raxel_diagnostics::SourceMap;
use raxel_graph::checked::{Graph, Param, Value};
use raxel_runtime::Session;
use raxel_runtime::params::{components, from_components};

use super::presets::Values;
use super::write_back::{self, Written};

/// The file that values of params are written into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteTo {
    /// The graph's own file: it overrides inherited values.
    Own,
    /// The one that each default stands in, which other graphs may extend as well.
    Declared,
}

/// Files that were written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Files {
    /// Each file, and its text before.
    pub written: Vec<Written>,
    /// Params that had these values in the session only, and have them in the files now.
    pub params: Vec<(String, Value)>,
}

/// The params that one write was to put into one file.
#[derive(Clone, Debug, PartialEq)]
pub struct InFile {
    /// Project path of the file.
    pub file: String,
    /// Names and values.
    pub params: Vec<(String, Value)>,
    /// What was written (`None` when the text stays as it is), or why not.
    pub result: Result<Option<Written>, String>,
}

/// Writes the values of params into the graph's own file, or where each default stands. Returns the outcome for each file.
pub fn write_params(
    session: &Session,
    names: &[String],
    to: WriteTo,
    default_file: impl Fn(&Param) -> String,
) -> Vec<InFile> {
    let mut files: BTreeMap<String, Vec<(String, Value)>> = BTreeMap::new();
    for param in session.params().iter().filter(|param| names.contains(&param.name)) {
        let Ok(value) = session.param(&param.name) else { continue };
        let file = match to {
            WriteTo::Own => session.graph_path().to_owned(),
            WriteTo::Declared => default_file(param),
        };
        files.entry(file).or_default().push((param.name.clone(), value));
    }
    let write = |(file, params): (String, Vec<(String, Value)>)| {
        let result = write_back::edit(session.project(), &file, |text| {
            params.iter().try_fold(text.to_owned(), |text, (name, value)| match to {
                WriteTo::Own => write_back::with_override(&text, name, value),
                WriteTo::Declared => write_back::with_param(&text, name, value),
            })
        });
        InFile { file, params, result }
    };
    files.into_iter().map(write).collect()
}

/// Lets params follow their files, which were read again. `following` are these params, each with the value that was written. A param with
/// another value was set since the write, and keeps this value.
pub fn follow_files(session: &mut Session, following: &mut Vec<(String, Value)>) {
    for (name, value) in following.drain(..) {
        if session.param(&name).is_ok_and(|now| now == value) {
            // This cannot fail: the graph has the param.
            let _ = session.unset_param(&name);
        }
    }
}

/// Gives params the values again that files had taken over from a session, unless they were moved since. `following` are the params whose files
/// were not read again yet, and the written values. Returns refusals, one line each.
pub fn set_again(
    session: &mut Session,
    following: &mut Vec<(String, Value)>,
    params: &[(String, Value)],
) -> Vec<String> {
    following.retain(|(name, _)| params.iter().all(|(param, _)| param != name));
    let mut refused = Vec::new();
    for (name, value) in params {
        if session.param(name).is_ok_and(|now| now == *value) {
            refused.extend(session.set_param(name, *value).err().map(|error| error.to_string()));
        }
    }
    refused
}

/// For each param the file with its default: the first one among the graph and those that it extends.
pub fn default_files(graph: &Graph, texts: &SourceMap) -> HashMap<String, String> {
    let mut found = HashMap::new();
    for file in graph.files.iter().filter(|file| Path::new(file).extension().is_some_and(|end| end == "toml")) {
        for name in texts.get(file).map(|text| write_back::defaults(text)).unwrap_or_default() {
            found.entry(name).or_insert_with(|| file.clone());
        }
    }
    found
}

/// Writes the camera into the file of the world under a name. `None` in the empty world, which has no file.
///
/// # Errors
/// Why the file is not changed, in one line.
pub fn write_camera(session: &Session, name: &str) -> Option<Result<(String, Option<Written>), String>> {
    let file = session.world().path.clone()?;
    let camera = session.camera();
    let edited = write_back::edit(session.project(), &file, |text| write_back::with_camera(text, name, camera));
    Some(edited.map(|written| (file, written)))
}

/// The values of all params, as a preset keeps them.
pub fn values(session: &Session) -> Values {
    let value = |param: &Param| Some((param.name.clone(), components(&session.param(&param.name).ok()?)));
    session.params().iter().filter_map(value).collect()
}

/// A param that a preset has changed.
#[derive(Clone, Debug, PartialEq)]
pub struct ParamChange {
    /// Its name.
    pub name: String,
    /// Its value before.
    pub before: Value,
    /// Its value now.
    pub after: Value,
}

/// What a preset has changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Applied {
    /// Params whose values differ from those before.
    pub changes: Vec<ParamChange>,
    /// Params of the preset that the graph does not have, or not with this type.
    pub left: Vec<String>,
    /// Values that are out of range, one line each.
    pub refused: Vec<String>,
}

/// Sets the params that the graph has to the values of a preset.
pub fn apply(session: &mut Session, values: &Values) -> Applied {
    let mut applied = Applied::default();
    for (name, numbers) in values {
        let default = session.params().iter().find(|param| param.name == *name).map(|param| param.default);
        let Some((default, value)) = default.and_then(|default| Some((default, from_components(numbers, &default)?)))
        else {
            applied.left.push(name.clone());
            continue;
        };
        let before = session.param(name).unwrap_or(default);
        match session.set_param(name, value) {
            Ok(()) if before != value => {
                applied.changes.push(ParamChange { name: name.clone(), before, after: value });
            }
            Ok(()) => {}
            Err(error) => applied.refused.push(error.to_string()),
        }
    }
    applied
}

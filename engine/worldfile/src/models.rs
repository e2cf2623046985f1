//! `[models.*]`: .vox files by name, each read once, however often it is placed.

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::table::{Node, Table};
use raxel_diagnostics::{Diagnostic, Files, codes, files};

use raxel_world::World;
use raxel_world::vox::{self, VoxErrorKind};
use raxel_world::{AIR, MaterialIndex};

use super::materials::{Palette, too_many};

/// Models by name.
pub(super) struct Models {
    by_name: BTreeMap<String, Entry>,
    files: Vec<String>,
}

struct Entry {
    /// None when its file was not read; that has been reported.
    model: Option<Arc<World>>,
    /// Its materials in the palette of the world, once it is used.
    materials: Option<Arc<[MaterialIndex]>>,
}

/// A model ready to be placed.
pub(super) struct Model {
    pub(super) voxels: Arc<World>,
    pub(super) materials: Arc<[MaterialIndex]>,
}

impl Models {
    /// Reads every model's file.
    pub(super) fn read(root: &Table<'_, '_>, path: &str, files: &dyn Files) -> Self {
        let mut models = Self { by_name: BTreeMap::new(), files: Vec::new() };
        let mut read: BTreeMap<(String, u32), Option<Arc<World>>> = BTreeMap::new();
        for (name, _, table) in root.tables("models") {
            let node = table.need("file");
            let file = node.as_ref().and_then(|node| project_path(node, path));
            let frame_node = table.get("frame");
            let frame = match &frame_node {
                Some(node) => node.integer(0..=u32::MAX),
                None => Some(0),
            };
            table.finish();
            let model = file.zip(node).zip(frame).and_then(|((file, node), frame)| {
                let load = || load(&file, frame, &node, frame_node.as_ref(), files).map(Arc::new);
                read.entry((file.clone(), frame)).or_insert_with(load).clone()
            });
            models.by_name.insert(name, Entry { model, materials: None });
        }
        models.files = read.into_keys().map(|(file, _)| file).collect();
        models.files.dedup();
        models
    }

    /// The models that could be read, by name, and all files.
    pub(super) fn into_parts(self) -> (Vec<(String, Arc<World>)>, Vec<String>) {
        let models = self.by_name.into_iter().filter_map(|(name, entry)| Some((name, entry.model?)));
        (models.collect(), self.files)
    }

    /// The model that a value names; its materials join the palette at its first use.
    pub(super) fn find(&mut self, node: &Node<'_, '_>, palette: &mut Palette) -> Option<Model> {
        let name = node.string()?;
        let Some(entry) = self.by_name.get_mut(&name) else {
            let names = || self.by_name.keys().map(String::as_str);
            let diagnostic = Diagnostic::error(codes::world::UNKNOWN_MODEL, format!("there is no model `{name}`"))
                .label(node.span.clone(), "named here");
            node.reporter().report(match closest(&name, names()) {
                Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
                None if self.by_name.is_empty() => diagnostic.help(format!("declare it: [models.{name}]")),
                None => diagnostic.help(format!("models: {}", list(names()))),
            });
            return None;
        };
        let model = entry.model.clone()?;
        if entry.materials.is_none() {
            let mut indices = vec![AIR; model.materials().len()];
            for (index, material) in model.materials().iter().enumerate().skip(1) {
                if model.counts()[index] == 0 {
                    continue;
                }
                let mut material = material.clone();
                material.name = format!("{name}.{}", material.name);
                let Some(added) = palette.add(material) else {
                    node.report(codes::world::TOO_MANY_MATERIALS, too_many(), "this model's are too many");
                    return None;
                };
                indices[index] = added;
            }
            entry.materials = Some(indices.into());
        }
        entry.materials.clone().map(|materials| Model { voxels: model, materials })
    }
}

/// The project path of a file that a world names: relative to `worlds/`, or to the world's own folder when it lies elsewhere.
fn project_path(node: &Node<'_, '_>, world: &str) -> Option<String> {
    let text = node.string()?;
    let folder =
        if world.starts_with("worlds/") { "worlds" } else { world.rsplit_once('/').map_or("", |(folder, _)| folder) };
    let path = files::join(folder, &text);
    if path.is_none() {
        node.report(codes::files::OUTSIDE_ROOT, format!("`{text}` is not a path inside the project"), "");
    }
    path
}

/// Imports a frame of a file that is named at `node`; the frame is named at `frame_node`, if it is.
fn load(
    file: &str,
    frame: u32,
    node: &Node<'_, '_>,
    frame_node: Option<&Node<'_, '_>>,
    files: &dyn Files,
) -> Option<World> {
    let named_at = |node: &Node<'_, '_>| Some((node.span.clone(), "named here"));
    let result = match files.read(file) {
        Ok(bytes) => vox::import_frame(&bytes, frame).map_err(|error| {
            let wrong = frame_node.filter(|_| error.kind == VoxErrorKind::Frame).unwrap_or(node);
            error.diagnostic(file, named_at(wrong))
        }),
        Err(error) => Err(error.diagnostic(file, named_at(node))),
    };
    result.map_err(|diagnostic| node.reporter().report(diagnostic)).ok()
}

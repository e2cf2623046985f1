//! `[models.*]`: .vox files by name, each read once, however often it is placed.

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::table::{Node, Reporter};
use raxel_diagnostics::{Diagnostic, FileError, Files, Spanned, codes, files};
use raxel_language::{Keys, ReadKeys, Shape, Value, describe};
use raxel_world::World;
use raxel_world::vox::{self, VoxErrorKind};
use raxel_world::{AIR, MaterialIndex};

use super::materials::{Palette, too_many};
use super::reading::Reading;

/// Models by name.
#[derive(Default)]
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

/// A model, as in the file.
#[derive(Keys)]
#[keys(context = Reading<'_>)]
struct ModelFile {
    /// A .vox file, relative to worlds/.
    #[keys(read = project_path)]
    file: Spanned<String>,
    /// Which frame of an animation, from 0.
    #[keys(range = 0..=u32::MAX, told = 0)]
    frame: Option<Spanned<u32>>,
}

/// Reads `[models.*]` and their files.
pub(super) fn declare(node: &Node<'_, '_>, reading: &Reading<'_>) -> Option<()> {
    let mut models = reading.models.borrow_mut();
    let mut read: BTreeMap<(String, u32), Option<Arc<World>>> = BTreeMap::new();
    for (name, node) in node.table()?.entries() {
        let Some(table) = node.table() else { continue };
        let model = ModelFile::read_whole(&table, reading).and_then(|file| {
            let frame = file.frame.as_ref().map_or(0, |frame| frame.value);
            let load = || file.load(frame, reading.files, table.reporter()).map(Arc::new);
            read.entry((file.file.value.clone(), frame)).or_insert_with(load).clone()
        });
        models.by_name.insert(name, Entry { model, materials: None });
    }
    models.files = read.into_keys().map(|(file, _)| file).collect();
    models.files.dedup();
    Some(())
}

/// The shape of `[models.*]`.
pub(super) fn declared() -> Shape {
    Shape::by_name(Shape::Table(ModelFile::form()))
}

describe! {
    Model => Shape::Text;
}

impl Value<Reading<'_>> for Model {
    fn read(node: &Node<'_, '_>, (): &(), reading: &Reading<'_>) -> Option<Self> {
        reading.models.borrow_mut().find(node, &mut reading.palette.borrow_mut())
    }
}

impl Models {
    /// The models that could be read, by name, and all files.
    pub(super) fn into_parts(self) -> (Vec<(String, Arc<World>)>, Vec<String>) {
        let models = self.by_name.into_iter().filter_map(|(name, entry)| Some((name, entry.model?)));
        (models.collect(), self.files)
    }

    /// The model that a value names; its materials join the palette at its first use.
    fn find(&mut self, node: &Node<'_, '_>, palette: &mut Palette) -> Option<Model> {
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

/// The folder that names of files in a world count from: `worlds/`, or the world's own when it lies elsewhere.
fn folder_of_names(world: &str) -> &str {
    if world.starts_with("worlds/") { "worlds" } else { world.rsplit_once('/').map_or("", |(folder, _)| folder) }
}

/// The project path of a file that a world names.
fn project_path(node: &Node<'_, '_>, reading: &Reading<'_>) -> Option<Spanned<String>> {
    let text = node.string()?;
    let path = files::join(folder_of_names(reading.path), &text);
    if path.is_none() {
        node.report(codes::files::OUTSIDE_ROOT, format!("`{text}` is not a path inside the project"), "");
    }
    Some(Spanned::new(path?, node.span.clone()))
}

impl ModelFile {
    fn load(&self, frame: u32, files: &dyn Files, reporter: &Reporter) -> Option<World> {
        let Spanned { value: path, span } = &self.file;
        let result = match files.read(path) {
            Ok(bytes) => vox::import_frame(&bytes, frame).map_err(|error| {
                let wrong = self.frame.as_ref().filter(|_| error.kind == VoxErrorKind::Frame);
                error.diagnostic(path, Some((wrong.map_or(span, |frame| &frame.span).clone(), "named here")))
            }),
            Err(FileError::NotFound) => {
                let folder = folder_of_names(reporter.file());
                Err(files::not_found(files, path, Some((span.clone(), "named here")), folder))
            }
            Err(error) => Err(error.diagnostic(path, Some((span.clone(), "named here")))),
        };
        result.map_err(|diagnostic| reporter.report(diagnostic)).ok()
    }
}

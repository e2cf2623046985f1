//! World files: `worlds/*.toml`, and .vox scenes as worlds of their own.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod camera;
mod extent;
mod instances;
mod materials;
mod models;
mod operations;
mod placing;
mod reading;
mod save;
mod solids;
mod stream;
mod terrain;

use std::sync::Arc;

use raxel_diagnostics::table::read_document;
use raxel_diagnostics::{Diagnostic, Files, SourceMap, Span, Spanned, codes, files};

pub use camera::{Aim, CAMERA_COORDINATES, CAMERA_FOV, CameraHint};
pub use extent::{CELLS, POSITIONS};
pub use operations::QuarterTurns;
pub use save::{OnGeneratorChange, SaveSettings};
pub use stream::StreamSettings;

use raxel_language::{ByName, Keys, ReadKeys};

use camera::NamedCamera;
use raxel_generate::{BuildError, BuildLimits, Operation, Reach, Shortfall, build, reach};
use raxel_generate::{Generator, NeedsWhole};
use raxel_layouts::instances::Instances;
use raxel_world::World;
use raxel_world::vox;
use raxel_world::{ChunkProvider, MAX_LEVEL};
use raxel_world::{MAX_MATERIALS, Material};
use reading::Reading;
use stream::Stream;

/// A world and its file's cameras.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Its name; the file's stem when it gives none.
    pub name: String,
    /// A sentence about it.
    pub about: Option<String>,
    /// The voxels. A streamed world, and one that was not built, has only the materials.
    pub world: World,
    /// The reach of the operations, if they were not run ([`Effort::UpTo`]).
    pub unbuilt: Option<Reach>,
    /// The loading around the camera, if the file has `[stream]`.
    pub stream: Option<Streamed>,
    /// The camera of the file, if it has one.
    pub camera: Option<CameraHint>,
    /// Other places to look from, by name, in the order of the file.
    pub cameras: Vec<(String, CameraHint)>,
    /// Its models by name, each a world of its own around its origin, with its own materials.
    pub models: Vec<(String, Arc<World>)>,
    /// Models that stand in it without being part of its voxels.
    pub instances: Instances,
    /// Where edits are saved, if they are.
    pub save: Option<SaveSettings>,
    /// Every file that was read, the world file first: a change of any of them changes the world.
    pub files: Vec<String>,
}

/// A world that is never whole in memory.
#[derive(Clone)]
pub struct Streamed {
    /// The part of it that is loaded at a time.
    pub settings: StreamSettings,
    /// Makes its tiles.
    pub generator: Arc<dyn ChunkProvider>,
    /// Where they come from, if they are not built; [`ChunkProvider::fingerprint`] identifies the contents.
    pub source: Option<String>,
    /// The place of the key.
    pub place: Span,
}

impl std::fmt::Debug for Streamed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Streamed")
            .field("settings", &self.settings)
            .field("source", &self.source)
            .finish_non_exhaustive()
    }
}

/// Limits on the work of loading a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Every voxel is built.
    Whole,
    /// Voxels are built only where the operations reach over at most this many chunks. Of larger worlds all else is read and checked.
    UpTo(u64),
}

/// Opens the `source` of `[stream]`.
pub(crate) type OpenSource<'a> = dyn Fn(&str) -> Result<Arc<dyn ChunkProvider>, Box<Diagnostic>> + 'a;

impl Loaded {
    /// Voxels that come from these files, with a name and nothing besides.
    pub fn new(name: impl Into<String>, world: World, files: Vec<String>) -> Self {
        Self {
            name: name.into(),
            about: None,
            world,
            unbuilt: None,
            stream: None,
            camera: None,
            cameras: Vec::new(),
            models: Vec::new(),
            instances: Instances::default(),
            save: None,
            files,
        }
    }

    /// The same without its voxels.
    #[must_use]
    pub fn clone_without_voxels(&self) -> Self {
        Self {
            name: self.name.clone(),
            about: self.about.clone(),
            world: World::empty(),
            unbuilt: self.unbuilt,
            stream: self.stream.clone(),
            camera: self.camera,
            cameras: self.cameras.clone(),
            models: self.models.clone(),
            instances: self.instances.clone(),
            save: self.save.clone(),
            files: self.files.clone(),
        }
    }
}

/// Materials and the operations, in order.
#[derive(Keys)]
#[keys(context = Reading<'_>)]
struct WorldFile {
    /// Name of the world; may be left out.
    name: Option<String>,
    /// One sentence about the world; may be left out.
    about: Option<String>,
    /// Any number: another one makes another world of the same kind.
    #[keys(default = 0)]
    #[expect(dead_code, reason = "`Reading` has it")]
    seed: i64,
    /// Where to look from.
    camera: Option<CameraHint>,
    /// Other places to look from, by name: letters, digits, - and _.
    #[keys(shape = camera::named())]
    cameras: ByName<NamedCamera>,
    /// Builds the world around the camera while it moves.
    stream: Option<Stream>,
    /// Where edits of the world are saved.
    save: Option<SaveSettings>,
    /// Materials by name.
    #[expect(dead_code, reason = "`Reading` has it")]
    #[keys(read = materials::declare, shape = materials::declared(), absent = ())]
    materials: (),
    /// .vox files by name.
    #[expect(dead_code, reason = "`Reading` has it")]
    #[keys(read = models::declare, shape = models::declared(), absent = ())]
    models: (),
    /// Operations that build voxels, one after the other. An empty world when left out.
    #[keys(read = operations::read, shape = operations::declared(), absent = Vec::new())]
    build: Vec<(Operation, Span)>,
    /// Models that stand in the world without being part of its voxels, and can move.
    #[keys(read = instances::read, shape = instances::declared(), absent = Instances::default())]
    instances: Instances,
}

/// JSON schema of `worlds/*.toml`.
pub fn schema() -> serde_json::Value {
    WorldFile::form().document("raxel world")
}

/// Loads the world at a project path: a world file, or a .vox scene. Warnings come with the world; with any error there is none,
/// and all that was found is returned. A world whose tiles come from a store is an error: [`load_with`] loads those, too.
pub fn load(
    path: &str,
    files: &dyn Files,
    texts: &mut SourceMap,
) -> Result<(Loaded, Vec<Diagnostic>), Vec<Diagnostic>> {
    load_with(path, files, texts, Effort::Whole, &|source| {
        let message = format!("nothing opens the source `{source}` here");
        Err(Box::new(Diagnostic::error(codes::world::STORE_ADDRESS, message)))
    })
}

/// As [`load`], with a bound on the work, and with a function that opens the sources of streamed worlds.
pub fn load_with(
    path: &str,
    files: &dyn Files,
    texts: &mut SourceMap,
    effort: Effort,
    open: &OpenSource<'_>,
) -> Result<(Loaded, Vec<Diagnostic>), Vec<Diagnostic>> {
    if is_vox(path) {
        return load_vox(path, files).map_err(|error| vec![*error]);
    }
    let text = files::read_text(files, path, None, texts).map_err(|error| vec![*error])?;
    let ((file, materials, models, models_files), mut found) = read_document(path, &text, texts, |root| {
        let reading = Reading::new(root, path, files);
        let file = WorldFile::read_whole(root, &reading)?;
        let (models, files) = reading.models.into_inner().into_parts();
        Some((file, reading.palette.into_inner().into_materials(), models, files))
    })?;
    let (operations, places): (Vec<_>, Vec<_>) = file.build.into_iter().unzip();
    let name = file.name.unwrap_or_else(|| stem(path));
    let files = std::iter::once(path.to_owned()).chain(models_files).collect();
    let mut loaded = Loaded {
        about: file.about,
        camera: file.camera,
        cameras: file.cameras.0.into_iter().map(|named| (named.name.value, named.camera.into())).collect(),
        models,
        instances: file.instances,
        save: file.save,
        ..Loaded::new(name, World::empty(), files)
    };
    if let Some(stream) = file.stream {
        let settings = stream.settings();
        let Stream { source, place, .. } = stream;
        let (materials, generator): (_, Arc<dyn ChunkProvider>) = if let Some(source) = &source {
            let opened = opened(&settings, source, &places, open).map_err(|error| {
                found.push(*error);
                std::mem::take(&mut found)
            })?;
            (restyled(opened.materials(), materials), opened)
        } else {
            let generator = Generator::new(materials.clone(), operations).map_err(|error| {
                found.push(needs_whole(error, &places));
                std::mem::take(&mut found)
            })?;
            (materials, Arc::new(generator))
        };
        loaded.world = World::new(materials, []);
        loaded.stream = Some(Streamed { settings, generator, source: source.map(|source| source.value), place });
        return Ok((loaded, found));
    }
    let built = build_up_to(effort, materials, &operations).map_err(|error| {
        let mut all = std::mem::take(&mut found);
        all.push(build_diagnostic(&error, path, &places));
        all
    })?;
    let Built { world, shortfalls, unbuilt } = built;
    for shortfall in shortfalls {
        found.push(
            Diagnostic::warning(
                codes::world::SCATTER_SHORT,
                format!("only {} of {} found a place", shortfall.placed, shortfall.wanted),
            )
            .label(places[shortfall.operation].clone(), "this scatter")
            .help("ask for fewer, for a smaller `min_spacing`, or for a larger area that has the materials of `on`"),
        );
    }
    let is_empty = if unbuilt.is_none() { empty(&world, path) } else { None };
    found.extend(is_empty.map(|warning| warning.label(Span::new(path, 0..0), "")));
    (loaded.world, loaded.unbuilt) = (world, unbuilt);
    Ok((loaded, found))
}

/// The result of a world's operations.
struct Built {
    world: World,
    shortfalls: Vec<Shortfall>,
    unbuilt: Option<Reach>,
}

fn build_up_to(effort: Effort, materials: Vec<Material>, operations: &[Operation]) -> Result<Built, BuildError> {
    let reach = reach(operations, &BuildLimits::default())?;
    match effort {
        Effort::UpTo(most) if reach.chunks > most => {
            Ok(Built { world: World::new(materials, []), shortfalls: Vec::new(), unbuilt: Some(reach) })
        }
        _ => {
            let (world, shortfalls) = build(materials, operations)?;
            Ok(Built { world, shortfalls, unbuilt: None })
        }
    }
}

/// Whether a path names a .vox file.
fn is_vox(path: &str) -> bool {
    path.rsplit_once('.').is_some_and(|(_, extension)| extension.eq_ignore_ascii_case("vox"))
}

fn stem(path: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or(path);
    name.split('.').next().unwrap_or(name).to_owned()
}

fn load_vox(path: &str, files: &dyn Files) -> Result<(Loaded, Vec<Diagnostic>), Box<Diagnostic>> {
    let bytes: Arc<[u8]> = files.read(path).map_err(|error| Box::new(error.diagnostic(path, None)))?;
    let world = vox::import(&bytes).map_err(|error| Box::new(error.diagnostic(path, None)))?;
    let found = empty(&world, path).into_iter().collect();
    Ok((Loaded::new(stem(path), world, vec![path.to_owned()]), found))
}

fn empty(world: &World, path: &str) -> Option<Diagnostic> {
    let message = || format!("`{path}` is a world without a single voxel");
    world.bounds().is_none().then(|| Diagnostic::warning(codes::world::EMPTY, message()))
}

/// Opens the source that a file names, and checks that the rest of the file suits it.
fn opened(
    settings: &StreamSettings,
    Spanned { value: source, span: at }: &Spanned<String>,
    operations: &[Span],
    open: &OpenSource<'_>,
) -> Result<Arc<dyn ChunkProvider>, Box<Diagnostic>> {
    if let Some(operation) = operations.first() {
        let message = "the voxels of a world with a `source` are there already: nothing is built";
        return Err(Box::new(
            Diagnostic::error(codes::world::SOURCE_BUILD, message)
                .label(operation.clone(), "this would build")
                .label(at.clone(), "the voxels come from here")
                .help("remove [[build]] or `source`; edits can change a world from a source, too"),
        ));
    }
    let opened = open(source).map_err(|error| Box::new(error.label(at.clone(), "named here")))?;
    let needed = (0..=MAX_LEVEL).find(|level| settings.far <= settings.near << (2 * level)).unwrap_or(MAX_LEVEL);
    let top = opened.top_level();
    if needed > top {
        let farthest = u64::from(settings.near) << (2 * top);
        let message = format!(
            "`far` is {}, which takes {} levels of detail, and {} were baked",
            settings.far,
            needed + 1,
            top + 1
        );
        return Err(Box::new(
            Diagnostic::error(codes::world::SOURCE_LEVELS, message)
                .label(at.clone(), "these levels end")
                .help(format!("lower `far` to {farthest}, or bake again with `--levels {}`", needed + 1)),
        ));
    }
    Ok(opened)
}

/// The materials of a source, with the looks that the file declares for the same names, and its further declarations behind them.
fn restyled(materials: &[Material], declared: Vec<Material>) -> Vec<Material> {
    let mut all = materials.to_vec();
    for material in declared.into_iter().skip(1) {
        match all.iter().skip(1).position(|known| known.name == material.name) {
            Some(index) => all[index + 1] = material,
            None if all.len() <= MAX_MATERIALS => all.push(material),
            None => {}
        }
    }
    all
}

fn needs_whole(error: NeedsWhole, places: &[Span]) -> Diagnostic {
    Diagnostic::error(codes::world::NEEDS_WHOLE, "a world with `[stream]` cannot scatter by `count` or `density`")
        .label(places[error.operation].clone(), "this looks at everything that was built before")
        .help("give `cell` and `chance` instead: at most one model for each cell of a grid, wherever the camera goes")
}

fn build_diagnostic(error: &BuildError, path: &str, places: &[Span]) -> Diagnostic {
    match error {
        BuildError::TooManyChunks { operation, chunks, limit } => Diagnostic::error(
            codes::world::TOO_LARGE,
            format!("this reaches over {chunks} chunks of 64³ voxels; a world has at most {limit}"),
        )
        .label(places[*operation].clone(), "with everything before it")
        .help("make it smaller"),
        BuildError::TooManyBytes { .. } => {
            Diagnostic::error(codes::world::TOO_MANY_BYTES, format!("`{path}` is too large: {error}"))
                .label(Span::new(path, 0..0), "")
        }
    }
}

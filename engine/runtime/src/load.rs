//! From files to graphs, worlds and demos, right or wrong. No device is asked.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, DiskFiles, Files, Severity, SourceMap};
use raxel_graph::Refusal;
use raxel_graph::checked::Graph;
use raxel_layouts::Layout;
use raxel_shader::{Compiler, FirstLook, ShaderProvider};
use raxel_worldfile::Effort;

use crate::inputs::SoundFile;
use crate::project::Project;
use crate::recording_files::{Content, RecordingFiles, content};
use crate::sources::{SourceCatalog, SourceName};
use crate::timeline::{self, Demo};
use crate::world::SessionWorld;

/// Loads graphs, worlds and demos of one project. Compiled shaders are kept between loads.
pub struct Loader {
    files: Arc<dyn Files>,
    shader_files: Arc<RecordingFiles>,
    compiler: Compiler,
    sources: SourceCatalog,
    /// Takes the place of the layout of every world buffer.
    layout: Option<Layout>,
    /// How much work building a world may be.
    effort: Effort,
    /// How much it matters that a shader does not use what its graph gives it.
    unused: Severity,
}

/// Something loaded from files, right or wrong.
#[derive(Debug)]
pub struct LoadOutcome<T> {
    /// The thing, or everything that is wrong with it.
    pub result: Result<Arc<T>, Vec<Diagnostic>>,
    /// Warnings, when it is right.
    pub warnings: Vec<Diagnostic>,
    /// The texts that diagnostics point into.
    pub texts: SourceMap,
    /// Every requested file with its contents, or that it was missing. A change of any of them changes the loaded object.
    pub(crate) files: BTreeMap<String, Content>,
}

impl<T> Clone for LoadOutcome<T> {
    fn clone(&self) -> Self {
        Self {
            result: self.result.clone(),
            warnings: self.warnings.clone(),
            texts: self.texts.clone(),
            files: self.files.clone(),
        }
    }
}

impl<T> LoadOutcome<T> {
    fn new(
        result: Result<(T, Vec<Diagnostic>), Vec<Diagnostic>>,
        texts: SourceMap,
        files: BTreeMap<String, Content>,
    ) -> Self {
        match result {
            Ok((value, warnings)) => Self { result: Ok(Arc::new(value)), warnings, texts, files },
            Err(found) => Self { result: Err(found), warnings: Vec::new(), texts, files },
        }
    }

    /// Something that comes from no file.
    pub(crate) fn without_file(value: T) -> Self {
        Self::new(Ok((value, Vec::new())), SourceMap::default(), BTreeMap::new())
    }

    /// Whether a change of one of these files concerns it.
    pub(crate) fn depends_on(&self, changed: &[String]) -> bool {
        changed.iter().any(|path| self.files.contains_key(path))
    }

    /// Everything found: errors, or warnings.
    pub fn found(&self) -> &[Diagnostic] {
        match &self.result {
            Ok(_) => &self.warnings,
            Err(found) => found,
        }
    }
}

impl Loader {
    /// For a project on disk.
    pub fn new(project: &Project) -> std::io::Result<Self> {
        Ok(Self::with_files(Arc::new(DiskFiles::new(project.root())?)))
    }

    /// For a project that `files` reads.
    pub fn with_files(files: Arc<dyn Files>) -> Self {
        let shader_files = Arc::new(RecordingFiles::new(files.clone()));
        let compiler = Compiler::new(shader_files.clone());
        // Files of sources are recorded with the shaders': a graph depends on both.
        let sources = SourceCatalog::new(shader_files.clone());
        Self { files, shader_files, compiler, sources, layout: None, effort: Effort::Whole, unused: Severity::Error }
    }

    /// Loads graphs as if every buffer with a world in it had this layout. `None` leaves them as they are.
    #[must_use]
    pub(crate) fn with_layout(self, layout: Option<Layout>) -> Self {
        Self { layout, ..self }
    }

    /// Builds no world whose operations reach over more chunks than the effort allows.
    #[must_use]
    pub fn with_effort(self, effort: Effort) -> Self {
        Self { effort, ..self }
    }

    /// Says how much it matters that a shader does not use a binding, a block or a member that its graph gives it: an error by default.
    #[must_use]
    pub(crate) fn with_unused(self, unused: Severity) -> Self {
        Self { unused, ..self }
    }

    /// Makes shaders with checks of the bounds of their accesses, or without them: graphs that are loaded from now on.
    pub fn check_bounds(&self, on: bool) {
        self.compiler.check_bounds(on);
    }

    /// Whether shaders are made with checks of the bounds of their accesses.
    pub fn checks_bounds(&self) -> bool {
        self.compiler.checks_bounds()
    }

    /// Makes shaders with records of their writes of a texel, or without them: graphs that are loaded from now on.
    pub fn record_writes(&self, on: bool) {
        self.compiler.record_writes(on);
    }

    /// Whether shaders are made with records of their writes of a texel.
    pub fn records_writes(&self) -> bool {
        self.compiler.records_writes()
    }

    /// Texts of shaders that were compiled, not found in a cache.
    #[cfg(test)]
    pub(crate) fn compiled(&self) -> u64 {
        self.compiler.compiled()
    }

    /// The files of the project.
    pub fn files(&self) -> &Arc<dyn Files> {
        &self.files
    }

    /// Whether every file that something was loaded from is as it was then.
    pub fn is_current<T>(&self, loaded: &LoadOutcome<T>) -> bool {
        loaded.files.iter().all(|(path, known)| content(&self.files.read(path)) == *known)
    }

    /// Parses and checks a graph, and compiles its shaders. Graphs are loaded one at a time.
    pub fn graph(&self, path: &str) -> LoadOutcome<Graph> {
        self.graph_over(path, self.layout)
    }

    /// As [`Self::graph`], with another layout for its world.
    pub fn graph_over(&self, path: &str, layout: Option<Layout>) -> LoadOutcome<Graph> {
        let _span = tracing::debug_span!("load graph", path).entered();
        self.graph_with(path, layout, &self.compiler)
    }

    /// A look at files of shaders that were edited, for [`Self::looked_at`].
    pub fn first_look<'l>(&'l self, edited: &'l BTreeSet<String>) -> FirstLook<'l> {
        FirstLook::new(&self.compiler, edited)
    }

    /// The errors that a look finds in the shaders of a graph. Other diagnostics are as if the graph had no shaders.
    pub fn looked_at(&self, path: &str, look: &FirstLook<'_>) -> LoadOutcome<Graph> {
        self.graph_with(path, self.layout, look)
    }

    fn graph_with(&self, path: &str, layout: Option<Layout>, shaders: &dyn ShaderProvider) -> LoadOutcome<Graph> {
        let mut texts = SourceMap::default();
        let replace = |source: &str| {
            SourceName::world_layout(source).and(layout).map(|layout| SourceName::World(layout).to_string())
        };
        let files = &*self.shader_files;
        files.begin();
        let options = raxel_graphfile::Options { replace: &replace, unused: self.unused };
        let result = raxel_graphfile::compile_with(path, files, shaders, &self.sources, options, &mut texts);
        LoadOutcome::new(result, texts, files.end())
    }

    /// Builds a world.
    pub fn world(&self, path: &str) -> LoadOutcome<SessionWorld> {
        let _span = tracing::debug_span!("load world", path).entered();
        self.recorded(|files, texts| SessionWorld::load(path, files, texts, self.effort))
    }

    /// Reads a demo, and the sound that its microphone hears.
    pub fn demo(&self, path: &str) -> LoadOutcome<Demo> {
        self.recorded(|files, texts| {
            let (mut demo, warnings) = timeline::read(files, path, texts)?;
            if let Some(file) = demo.inputs.as_ref().and_then(|inputs| inputs.microphone.as_ref()) {
                let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
                let sound = read_sound(files, &file.value, folder).map_err(|refusal| {
                    let error = Diagnostic::error(refusal.code, refusal.message).label(file.span.clone(), "named here");
                    vec![Diagnostic { help: refusal.help.into_iter().collect(), ..error }]
                })?;
                demo.heard = Some(sound);
            }
            Ok((demo, warnings))
        })
    }

    /// Reads a sound for a microphone. The error says why it cannot be read, and what to do.
    pub fn sound(&self, path: &str) -> Result<SoundFile, String> {
        read_sound(&*self.files, path, "").map_err(|refusal| match refusal.help {
            Some(help) => format!("{}: {help}", refusal.message),
            None => refusal.message,
        })
    }

    fn recorded<T>(
        &self,
        load: impl FnOnce(&dyn Files, &mut SourceMap) -> Result<(T, Vec<Diagnostic>), Vec<Diagnostic>>,
    ) -> LoadOutcome<T> {
        let recorder = RecordingFiles::new(self.files.clone());
        recorder.begin();
        let mut texts = SourceMap::default();
        let result = load(&recorder, &mut texts);
        LoadOutcome::new(result, texts, recorder.end())
    }
}

/// A sound that a microphone hears in place of a device. What named it counts from the folder `from`.
fn read_sound(files: &dyn Files, path: &str, from: &str) -> Result<SoundFile, Refusal> {
    Ok(SoundFile { path: path.to_owned(), samples: raxel_media::sound::read(files, path, from)? })
}

//! The compiler with its caches: a request in, a module and its interface out. Modules of this process are kept in memory, those of earlier
//! ones on disk.

use std::collections::{BTreeSet, HashMap};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use raxel_diagnostics::{Diagnostic, Files, SourceMap, Span, codes};
use raxel_spirv::{Checks, Module, ModuleError};

use crate::compile;
use crate::front_end::{self, Job};
use crate::interface::Interface;
use crate::messages;
use crate::module_cache;
use crate::places;
use crate::prints::{self, Prints};
use crate::reflect;
use crate::request::{Request, Shader, ShaderProvider};
use crate::sources::{Dependency, Sources};

/// Most modules that are kept, and most words of them.
const MAX_ENTRIES: usize = 512;
const MAX_WORDS: usize = 4 << 20;

/// The number of newest entries to compare with a new one.
const SHARED_WITH: usize = 32;

/// Compiles the shaders of one project. Shaders may be compiled on several threads at once. Texts that stop or end the compiler stop or end
/// the process, unless it has called [`crate::worker::isolate`].
pub struct Compiler {
    files: Arc<dyn Files>,
    cache: Mutex<Cache>,
    on_disk: Option<Arc<raxel_cache::Cache>>,
    compiled: AtomicU64,
    checks_bounds: AtomicBool,
    records_writes: AtomicBool,
}

impl Compiler {
    /// For the project that `files` reads. Modules are kept in the process's cache, if it has one.
    pub fn new(files: Arc<dyn Files>) -> Self {
        Self {
            files,
            cache: Mutex::default(),
            on_disk: raxel_cache::of_process(),
            compiled: AtomicU64::new(0),
            checks_bounds: AtomicBool::new(false),
            records_writes: AtomicBool::new(false),
        }
    }

    /// Makes shaders from now on with or without checks of the bounds of their accesses.
    pub fn check_bounds(&self, on: bool) {
        self.checks_bounds.store(on, Ordering::Relaxed);
    }

    /// Whether shaders are made with checks of the bounds of their accesses.
    pub fn checks_bounds(&self) -> bool {
        self.checks_bounds.load(Ordering::Relaxed)
    }

    /// Makes shaders from now on with or without records of their writes of a texel.
    pub fn record_writes(&self, on: bool) {
        self.records_writes.store(on, Ordering::Relaxed);
    }

    /// Whether shaders are made with records of their writes of a texel.
    pub fn records_writes(&self) -> bool {
        self.records_writes.load(Ordering::Relaxed)
    }

    fn checks(&self) -> Checks {
        Checks { bounds: self.checks_bounds(), writes: self.records_writes() }
    }

    /// Keeps modules in this cache, or in none.
    #[must_use]
    pub fn with_cache(self, on_disk: Option<Arc<raxel_cache::Cache>>) -> Self {
        Self { on_disk, ..self }
    }

    /// Texts that were compiled, not found in a cache.
    pub fn compiled(&self) -> u64 {
        self.compiled.load(Ordering::Relaxed)
    }

    pub(crate) fn files(&self) -> &dyn Files {
        &*self.files
    }

    /// Whether the newest module of a request was made from one of these files. A module that is not there may be.
    pub(crate) fn may_depend_on(&self, request: &Request, files: &BTreeSet<String>) -> bool {
        let newest = self.lock().candidates(request, self.checks()).into_iter().next();
        newest.is_none_or(|entry| entry.dependencies.iter().any(|(path, _)| files.contains(path)))
    }

    fn compile(&self, request: &Request, checks: Checks, texts: &mut SourceMap) -> Result<Entry, Vec<Diagnostic>> {
        let mut sources = Sources::new(&*self.files);
        let ready = request.path.to_ascii_lowercase().ends_with(".spv");
        let words =
            if ready { self.ready(request, &mut sources) } else { self.of_text(request, checks.any(), &mut sources) };
        let result = words.and_then(|words| {
            let finished = finish(&words, request, Finish { ready, checks }, &sources);
            finished.map_err(|diagnostic| sources.diagnostics.push(*diagnostic)).ok()
        });
        let result = result.map(|Finished { spirv, interface, said }| {
            sources.diagnostics.extend(said);
            (spirv, interface)
        });
        texts.extend(&sources.texts);
        match result {
            Some((spirv, interface)) if !sources.diagnostics.iter().any(Diagnostic::is_error) => {
                Ok(Entry::new(request, checks, spirv, interface, sources))
            }
            _ => Err(sources.diagnostics),
        }
    }

    fn of_text<'f>(&'f self, request: &Request, checked: bool, sources: &mut Sources<'f>) -> Option<Vec<u32>> {
        let root = |sources: &mut Sources<'f>| {
            sources.root(&request.path).map_err(|diagnostic| sources.diagnostics.push(*diagnostic)).ok()
        };
        let start = Instant::now();
        let milliseconds = || start.elapsed().as_secs_f64() * 1e3;
        let mut text = root(sources)?;
        if let Some(cache) = &self.on_disk {
            let job = Job { request: request.clone(), text };
            let afresh = |sources: &mut Sources<'f>| {
                *sources = Sources::new(&*self.files);
                root(sources)
            };
            if let Some(words) = module_cache::find(cache, &job, checked, sources, afresh) {
                tracing::debug!("took {} from the cache on disk in {:.0} ms", request.path, milliseconds());
                return Some(words);
            }
            text = afresh(sources)?;
        }
        let _span = tracing::debug_span!("compile shader", path = request.path.as_str()).entered();
        self.compiled.fetch_add(1, Ordering::Relaxed);
        let words = compile::compile(request, &text, checked, sources, self.on_disk.as_deref())?;
        tracing::debug!("compiled {} in {:.0} ms", request.path, milliseconds());
        Some(words)
    }

    fn ready(&self, request: &Request, sources: &mut Sources<'_>) -> Option<Vec<u32>> {
        let words = match self.files.read(&request.path) {
            Ok(bytes) => {
                sources.dependencies.push((request.path.clone(), Some(blake3::hash(&bytes))));
                raxel_spirv::words_of(&bytes).map_err(|error| module_diagnostic(&error, &request.path))
            }
            Err(error) => Err(error.diagnostic(&request.path, None)),
        };
        words.map_err(|diagnostic| sources.diagnostics.push(diagnostic)).ok()
    }

    fn cached(
        &self,
        request: &Request,
        checks: Checks,
        texts: &mut SourceMap,
    ) -> Option<(Arc<Shader>, Vec<Diagnostic>)> {
        let candidates = self.lock().candidates(request, checks);
        let mut answers: HashMap<&str, Option<blake3::Hash>> = HashMap::new();
        for entry in &candidates {
            let holds = entry.dependencies.iter().all(|(path, expected)| {
                *answers.entry(path).or_insert_with(|| match self.files.read(path) {
                    Ok(bytes) => Some(blake3::hash(&bytes)),
                    Err(_) => None,
                }) == *expected
            });
            if holds {
                self.lock().touch(entry);
                texts.extend(&entry.texts);
                return Some((entry.shader.clone(), entry.warnings.clone()));
            }
        }
        None
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Cache> {
        // The cache is whole after every operation, so a panic elsewhere does not spoil it.
        self.cache.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ShaderProvider for Compiler {
    fn shader(
        &self,
        request: &Request,
        texts: &mut SourceMap,
    ) -> Result<(Arc<Shader>, Vec<Diagnostic>), Vec<Diagnostic>> {
        let checks = self.checks();
        if let Some(hit) = self.cached(request, checks, texts) {
            tracing::debug!("reused {}", request.path);
            return Ok(hit);
        }
        let _span = tracing::debug_span!("load shader", path = request.path.as_str()).entered();
        let entry = self.compile(request, checks, texts)?;
        let entry = self.lock().insert(entry);
        Ok((entry.shader.clone(), entry.warnings.clone()))
    }
}

impl std::fmt::Debug for Compiler {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Compiler").field("cached", &self.lock().entries.len()).finish_non_exhaustive()
    }
}

/// A module as the driver is given it.
struct Finished {
    spirv: Vec<u32>,
    interface: Interface,
    /// The messages on the way.
    said: Vec<Diagnostic>,
}

/// How a module is made.
#[derive(Clone, Copy)]
struct Finish {
    /// It came ready, and was not compiled here.
    ready: bool,
    /// What it records besides its prints.
    checks: Checks,
}

/// Checks a module, reads its interface, and makes the driver's module of it.
fn finish(
    words: &[u32],
    request: &Request,
    Finish { ready, checks }: Finish,
    sources: &Sources<'_>,
) -> Result<Finished, Box<Diagnostic>> {
    let open = |words| Module::new(words, &request.entry);
    let refused = |error: ModuleError| Box::new(module_diagnostic(&error, &request.path));
    let module = open(words).map_err(refused)?;
    let separate = module.with_separate_bindings();
    let module = separate.as_deref().map_or(Ok(module), open).map_err(refused)?;
    if ready {
        // A module that was compiled here is valid by construction.
        raxel_spirv::validate(words).map_err(|reason| refused(ModuleError::Broken(reason)))?;
    }
    let mut interface = reflect::reflect(&module, &request.entry)
        .map_err(|reason| Box::new(reflection_diagnostic(&reason, &request.path)))?;
    places::fill(&mut interface, sources);
    let mut said = messages::undefined(&module.undefined(), sources);
    let binding = interface.bindings.iter().filter(|binding| binding.set == 0).map(|binding| binding.binding + 1).max();
    let binding = binding.unwrap_or(0);
    let recording =
        module.with_records(binding, checks).map_err(|error| Box::new(prints::unprintable(&error, sources)))?;
    interface.prints = recording.as_ref().map(|recording| Prints::of(recording, binding, sources, &mut said));
    let module = recording.as_ref().map_or(Ok(module), |recording| open(&recording.words)).map_err(refused)?;
    let bounded = module.with_shared_bounds().map_err(refused)?;
    let module = bounded.as_deref().map_or(Ok(module), open).map_err(refused)?;
    Ok(Finished { spirv: module.without_debug_text(), interface, said })
}

/// A compiled shader, and its dependencies.
struct Entry {
    /// What it records besides its prints.
    checks: Checks,
    shader: Arc<Shader>,
    warnings: Vec<Diagnostic>,
    dependencies: Vec<Dependency>,
    texts: SourceMap,
}

impl Entry {
    fn new(request: &Request, checks: Checks, spirv: Vec<u32>, interface: Interface, sources: Sources<'_>) -> Self {
        let mut key = blake3::Hasher::new();
        let mut field = |bytes: &[u8]| {
            key.update(&(bytes.len() as u64).to_le_bytes());
            key.update(bytes);
        };
        field(front_end::VERSION.as_bytes());
        field(request.path.as_bytes());
        field(request.entry.as_bytes());
        field(&[u8::from(checks.bounds) | u8::from(checks.writes) << 1]);
        for (name, value) in &request.defines {
            field(name.as_bytes());
            field(value.as_bytes());
        }
        for source in &sources.found {
            field(source.name.as_bytes());
            field(source.text.as_bytes());
        }
        if sources.found.is_empty() {
            // A ready module is its own text.
            field(&raxel_spirv::bytes_of(&spirv));
        }
        let files = if sources.found.is_empty() {
            vec![request.path.clone()]
        } else {
            sources.found.iter().map(|source| source.name.clone()).collect()
        };
        let mut module = blake3::Hasher::new();
        module.update(&raxel_spirv::bytes_of(&spirv)).update(interface.entry.as_bytes());
        // Passes that share a pipeline run again for another text, so that it is printed.
        for call in interface.prints.iter().flat_map(|prints| &prints.calls) {
            module.update(format!("{call:?}").as_bytes());
        }
        for access in interface.prints.iter().flat_map(|prints| &prints.accesses) {
            module.update(format!("{access:?}").as_bytes());
        }
        if let Some(writes) = interface.prints.as_ref().and_then(|prints| prints.writes.as_ref()) {
            module.update(format!("{writes:?}").as_bytes());
        }
        let [key, module] = [key, module].map(|hasher| *hasher.finalize().as_bytes());
        let shader = Shader { request: request.clone(), spirv: spirv.into(), interface, files, key, module };
        Self {
            checks,
            shader: Arc::new(shader),
            warnings: sources.diagnostics,
            dependencies: sources.dependencies,
            texts: sources.texts,
        }
    }
}

/// Modules by request, several versions of each: taking an edit back costs nothing.
#[derive(Default)]
struct Cache {
    /// Oldest use first.
    entries: Vec<Arc<Entry>>,
}

impl Cache {
    /// Newest first.
    fn candidates(&self, request: &Request, checks: Checks) -> Vec<Arc<Entry>> {
        let fits = |entry: &&Arc<Entry>| entry.checks == checks && entry.shader.request == *request;
        self.entries.iter().rev().filter(fits).cloned().collect()
    }

    fn touch(&mut self, entry: &Arc<Entry>) {
        if let Some(at) = self.entries.iter().position(|known| Arc::ptr_eq(known, entry)) {
            let entry = self.entries.remove(at);
            self.entries.push(entry);
        }
    }

    fn insert(&mut self, mut entry: Entry) -> Arc<Entry> {
        self.share_texts(&mut entry);
        let entry = Arc::new(entry);
        self.entries.push(entry.clone());
        let mut words: usize = self.entries.iter().map(|entry| entry.shader.spirv.len()).sum();
        while self.entries.len() > MAX_ENTRIES || (words > MAX_WORDS && self.entries.len() > 1) {
            words -= self.entries.remove(0).shader.spirv.len();
        }
        entry
    }

    /// Texts that the newest entries have too are held once: most of a shader is the same library.
    fn share_texts(&self, entry: &mut Entry) {
        for known in self.entries.iter().rev().take(SHARED_WITH) {
            let same = |(file, text): (&Arc<str>, &Arc<str>)| {
                let other = known.texts.get(file).filter(|other| !Arc::ptr_eq(other, text) && *other == text)?;
                Some((file.clone(), other.clone()))
            };
            let shared: Vec<_> = entry.texts.iter().filter_map(same).collect();
            shared.into_iter().for_each(|(file, text)| entry.texts.insert(file, text));
        }
    }
}

fn module_diagnostic(error: &ModuleError, path: &str) -> Diagnostic {
    match error {
        ModuleError::Broken(reason) => {
            Diagnostic::error(codes::shader::BAD_SPIRV, format!("`{path}` is not a sound SPIR-V module: {reason}"))
        }
        ModuleError::Unsupported(reason) => {
            Diagnostic::error(codes::shader::UNSUPPORTED_SPIRV, format!("`{path}` is not supported: {reason}"))
        }
        ModuleError::TooMuch { bytes, limit } => Diagnostic::error(
            codes::shader::TOO_MUCH,
            format!("the variables of each thread of `{path}` take {bytes} bytes, more than {limit}"),
        )
        .help("put large arrays into a buffer"),
        ModuleError::NoEntry { entry, found } => {
            let diagnostic =
                Diagnostic::error(codes::shader::NO_ENTRY, format!("`{path}` has no compute entry point `{entry}`"));
            if found.is_empty() {
                diagnostic.note("it has no entry point at all")
            } else {
                diagnostic.note(format!("it has {}", found.join(", ")))
            }
        }
    }
    .label(Span::new(path, 0..0), "this module")
}

fn reflection_diagnostic(reason: &str, path: &str) -> Diagnostic {
    Diagnostic::error(codes::shader::REFLECTION, format!("the interface of `{path}` cannot be read: {reason}"))
        .label(Span::new(path, 0..0), "this module")
}

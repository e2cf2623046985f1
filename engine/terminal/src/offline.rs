//! Pieces that the verbs that need no GPU share: the project around a file, its compilers, and the reading of each kind of file.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use raxel_diagnostics::files::read_text;
use raxel_diagnostics::{Diagnostic, Severity, SourceMap, codes};
use raxel_execute::{Abilities as _, OnPaper};
use raxel_generate::Reach;
use raxel_gpu::known::KnownDevice;
use raxel_graph::Phase;
use raxel_graph::checked::{Fact, Graph, Pass, ResourceId, Value};
use raxel_graph::plan::{BindingLimits, DeviceLimits, Plan, PlanInput, Present, SourceSize, WorldInput};
use raxel_runtime::load::{LoadOutcome, Loader};
use raxel_runtime::manifest;
use raxel_runtime::project::Project;
use raxel_runtime::sources;
use raxel_runtime::world::SessionWorld;
use raxel_runtime::{SavedWorld, Saves};
use raxel_worldfile::Effort;

use crate::console::{Console, To};
use crate::failure::Result;

/// Limits that no Vulkan 1.3 device in use exceeds by much: a graph that does not fit these fits nowhere.
pub const LARGEST: DeviceLimits = DeviceLimits {
    image_2d: 32768,
    image_3d: 16384,
    image_layers: 2048,
    storage_buffer: 1 << 32,
    uniform_buffer: 1 << 27,
    push_constants: 256,
    workgroup_count: [u32::MAX; 3],
    workgroup_size: [2048, 2048, 1024],
    workgroup_invocations: 2048,
    shared_memory: 1 << 18,
    bindings: BindingLimits {
        storage_buffers: u32::MAX,
        storage_images: u32::MAX,
        sampled_images: u32::MAX,
        uniform_buffers: u32::MAX,
        resources: u32::MAX,
    },
};

/// Most chunks of a world that is built only to be checked: some seconds of work.
const CHECKED_CHUNKS: u64 = 1 << 14;

/// Kinds of files that raxel reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A graph.
    Graph,
    /// A world, also a .vox.
    World,
    /// A demo.
    Demo,
    /// The manifest of a project.
    Project,
}

impl FileKind {
    /// By the name of a named file: the folder it lies in decides for a file that is no demo and no .vox.
    pub fn of_named(path: &Path) -> Self {
        let folder = path.parent().and_then(Path::file_name).is_some_and(|folder| folder == "worlds");
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        FileKind::of(&if folder { format!("worlds/{name}") } else { name })
    }

    /// By the name of a project path: `raxel.toml` is the manifest, `*.demo.toml` a demo; `*.vox` and everything else in `worlds/` is a world.
    pub fn of(path: &str) -> Self {
        if path == manifest::PATH {
            FileKind::Project
        } else if path.ends_with(".demo.toml") {
            FileKind::Demo
        } else if path.starts_with("worlds/") || path.to_ascii_lowercase().ends_with(".vox") {
            FileKind::World
        } else {
            FileKind::Graph
        }
    }

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            FileKind::Graph => "graph",
            FileKind::World => "world",
            FileKind::Demo => "demo",
            FileKind::Project => "project",
        }
    }
}

/// A project and the loader of its files.
pub struct OfflineProject {
    /// The project.
    pub project: Project,
    /// The reader of its files.
    pub loader: Loader,
    /// The device that graphs are checked for; none by default.
    device: Option<OnPaper>,
    /// Worlds that graphs were planned over, by path: each is built once.
    worlds: RefCell<BTreeMap<String, LoadOutcome<SessionWorld>>>,
}

/// The world that a graph is planned over without a device.
#[derive(Clone)]
pub enum PlannedOver {
    /// Nothing of the graph depends on the world.
    Any,
    /// The world that was named, or that its demo names.
    Named(Arc<SessionWorld>),
    /// The world that the project's graphs run over when none is named.
    Default(Arc<SessionWorld>),
    /// There is no such world: any material will do, and sizes are those of a world of 256 voxels along each axis.
    StandIn,
}

impl PlannedOver {
    fn world(&self) -> Option<&SessionWorld> {
        match self {
            Self::Named(world) | Self::Default(world) => Some(world),
            Self::Any | Self::StandIn => None,
        }
    }

    /// Project path of the world, where there is one.
    pub fn path(&self) -> Option<&str> {
        self.world().and_then(|world| world.path.as_deref())
    }

    /// The assumption, in words; `None` when nothing was.
    pub fn assumed(&self) -> Option<String> {
        match self {
            Self::Any | Self::Named(_) => None,
            Self::Default(_) => {
                Some(format!("planned over `{}`; --world names another", self.path().unwrap_or_default()))
            }
            Self::StandIn => {
                let [x, y, z] = WorldInput::ON_PAPER.extent;
                Some(format!(
                    "planned over a world of {x} x {y} x {z} voxels with any material; --world names a real one"
                ))
            }
        }
    }
}

/// Which conditions of passes hold on paper.
#[derive(Clone, Copy, Debug)]
pub enum Conditions<'a> {
    /// Every one: each pass is checked.
    All,
    /// Those that hold when the graph starts over the world.
    AtStart,
    /// Those that hold when the graph starts on this device, whose limits count.
    OnDevice(&'a OnPaper),
}

/// The result of checking one file.
#[derive(Default)]
pub struct Checked {
    /// Everything found, errors and warnings.
    pub found: Vec<Diagnostic>,
    /// The texts that they point into.
    pub texts: SourceMap,
    /// For a graph that could be read: the world that it was planned over.
    pub over: Option<PlannedOver>,
    /// The reach of the operations of a world that was read and not built.
    pub unbuilt: Option<Reach>,
    /// Name of the device that graphs were checked for, if any was.
    pub device: Option<String>,
}

impl Checked {
    /// Its number of errors; the rest are warnings.
    pub fn errors(&self) -> usize {
        self.found.iter().filter(|d| d.severity == Severity::Error).count()
    }

    fn add_world(&mut self, world: &LoadOutcome<SessionWorld>) {
        self.add(world);
        self.unbuilt = world.result.as_ref().ok().and_then(|world| world.loaded().unbuilt);
    }

    fn add<T>(&mut self, part: &LoadOutcome<T>) {
        self.found.extend_from_slice(part.found());
        self.texts.extend(&part.texts);
    }
}

impl OfflineProject {
    /// The project around a file that somebody named, or around a folder.
    pub fn around(path: &Path) -> std::result::Result<Self, Box<Diagnostic>> {
        let project = if path.is_dir() { Project::around(path) } else { Project::around_file(path) }?;
        let loader = Loader::new(&project).map_err(|error| {
            let message = format!("the project cannot be read: {error}");
            Box::new(Diagnostic::error(codes::session::NO_PROJECT, message))
        })?;
        Ok(Self::new(project, loader))
    }

    /// A project whose files are loaded by `loader`.
    pub fn new(project: Project, loader: Loader) -> Self {
        Self { project, loader, device: None, worlds: RefCell::default() }
    }

    /// The same, but worlds of more than `CHECKED_CHUNKS` are read and not built: for verbs that check files.
    #[must_use]
    pub fn for_checks(self) -> Self {
        let loader = self.loader.with_effort(Effort::UpTo(CHECKED_CHUNKS));
        Self { loader, ..self }
    }

    /// The same, but graphs are checked for a device, if one is named.
    #[must_use]
    pub fn for_device(self, device: Option<&KnownDevice>) -> Self {
        Self { device: device.map(OnPaper::of), ..self }
    }

    /// Forgets the worlds whose files have changed since they were built.
    pub fn forget_changed_worlds(&self) {
        self.worlds.borrow_mut().retain(|_, world| self.loader.is_current(world));
    }

    /// The project around a file, and the file's project path. Without a file, `default` of the project around the current folder.
    pub fn of(
        named: Option<&Path>,
        default: impl FnOnce(&Project) -> std::result::Result<String, Box<Diagnostic>>,
        console: &Console,
    ) -> Result<(Self, String)> {
        let stop = |diagnostic: Box<Diagnostic>| console.stop(&[*diagnostic]);
        let offline = Self::around(named.unwrap_or(Path::new("."))).map_err(stop)?;
        let path = if let Some(named) = named {
            offline.project.path_of(named)
        } else {
            offline.project.manifest().map_err(|(found, texts)| console.stop_in(&found, &texts))?;
            default(&offline.project)
        };
        let path = path.map_err(stop)?;
        Ok((offline, path))
    }

    /// A part that is right, its warnings shown; or the failure, its errors shown.
    pub fn good<T>(part: LoadOutcome<T>, console: &Console) -> Result<Arc<T>> {
        match part.result {
            Ok(value) => {
                console.diagnostics(&part.warnings, &part.texts, To::Stderr);
                Ok(value)
            }
            Err(found) => Err(console.stop_in(&found, &part.texts)),
        }
    }

    /// Loads a world.
    pub fn world(&self, path: &str, console: &Console) -> Result<Arc<SessionWorld>> {
        Self::good(self.loader.world(path), console)
    }

    /// The world to plan a graph over: the named one, or the project's default if `needed`.
    pub fn planned_over(&self, named: Option<Arc<SessionWorld>>, needed: bool) -> PlannedOver {
        if let Some(world) = named {
            return PlannedOver::Named(world);
        }
        if !needed {
            return PlannedOver::Any;
        }
        // A world that is not right has its own errors.
        let default = self.project.default_world().ok().and_then(|path| self.built(&path).result.ok());
        default.map_or(PlannedOver::StandIn, PlannedOver::Default)
    }

    /// Builds a world for something that has to look at all of its voxels.
    pub fn whole_world(&self, path: &str, console: &Console) -> Result<Arc<SessionWorld>> {
        let world = self.world(path, console)?;
        self.whole(&world, path, None, console).map(|()| world)
    }

    /// Stops at a world that never has all of its voxels. `instead` is the advice for a use of it as it is.
    pub fn whole(&self, world: &SessionWorld, path: &str, instead: Option<&str>, console: &Console) -> Result<()> {
        let Some(streamed) = world.streamed() else { return Ok(()) };
        let mut diagnostic = Diagnostic::error(
            codes::world::STREAM_ENDLESS,
            format!("`{path}` is streamed: there is no moment at which all of its voxels are there"),
        )
        .label(streamed.place.clone(), "by this")
        .help("take `[stream]` out and give its operations bounds, to have a part of it");
        if let Some(instead) = instead {
            diagnostic = diagnostic.note(instead);
        }
        Err(console.stop_in(&[diagnostic], &self.text(path)))
    }

    /// The text of a loaded file, for places in it.
    fn text(&self, path: &str) -> SourceMap {
        let mut texts = SourceMap::default();
        // A file that cannot be read any more is named all the same.
        let _ = read_text(&**self.loader.files(), path, None, &mut texts);
        texts
    }

    /// Loads a world with the contents of its save.
    pub fn saved_world(&self, path: &str, saves: Saves, console: &Console) -> Result<SavedWorld> {
        let world = self.world(path, console)?;
        let (saved, found) = SavedWorld::open(&world, self.project.root(), &**self.loader.files(), saves)
            .map_err(|found| console.stop_in(&found, &self.text(path)))?;
        console.diagnostics(&found, &self.text(path), To::Stderr);
        Ok(saved)
    }

    /// Whether frames of a graph depend on those before them by more than the camera, for any shown resource and any conditions. A graph
    /// that cannot be planned on paper counts as if they did.
    #[expect(clippy::cast_possible_truncation, reason = "a graph numbers its resources in 32 bits")]
    pub fn uses_history(graph: &Arc<Graph>, output: [u32; 2]) -> bool {
        if graph.collected().next().is_some() {
            // Later frames see the changes of passes to the world.
            return true;
        }
        let present = Present::of(graph.present);
        let all: Vec<ResourceId> = (0..graph.resources.len() as u32).map(ResourceId).collect();
        let facts: [&dyn Fn(&Fact) -> bool; 2] = [&|_| true, &|_| false];
        facts.iter().any(|facts| {
            let paper = Paper { output, present, over: &PlannedOver::Any, conditions: Conditions::All };
            let planned = on_paper(graph, &paper, |input| {
                raxel_graph::plan(graph.clone(), &PlanInput { pinned: &all, facts, ..input.clone() })
            });
            planned.map_or(true, |plan| plan.uses_history)
        })
    }

    /// The world that the command line names.
    pub fn named_world(&self, named: &Path, console: &Console) -> Result<Arc<SessionWorld>> {
        let path = self.project.path_of(named).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
        let first = !self.worlds.borrow().contains_key(&path);
        let world = self.built(&path);
        if first {
            return Self::good(world, console);
        }
        world.result.map_err(|found| console.stop_in(&found, &world.texts))
    }

    /// A world, built at most once.
    pub fn built(&self, path: &str) -> LoadOutcome<SessionWorld> {
        self.worlds.borrow_mut().entry(path.to_owned()).or_insert_with(|| self.loader.world(path)).clone()
    }

    /// Checks a file of the project in every way that needs no GPU; graphs over `world`, if one is named.
    pub fn check(&self, path: &str, world: Option<&Arc<SessionWorld>>) -> Checked {
        let mut checked = Checked::default();
        match FileKind::of(path) {
            FileKind::Graph => {
                self.check_graph(path, world, &mut checked);
            }
            FileKind::World => checked.add_world(&self.built(path)),
            FileKind::Demo => self.check_demo(path, &mut checked),
            FileKind::Project => {
                let read = manifest::read(&**self.loader.files(), &mut checked.texts);
                checked.found = read.map_or_else(|found| found, |(_, warnings)| warnings);
            }
        }
        checked
    }

    fn check_graph(&self, path: &str, world: Option<&Arc<SessionWorld>>, checked: &mut Checked) -> Option<Arc<Graph>> {
        let part = self.loader.graph(path);
        checked.add(&part);
        let graph = part.result.ok()?;
        let asks = |pass: &Pass| pass.when.iter().any(|when| !matches!(when.fact, Fact::Param(_)));
        let needed = graph.is_sized_by_world() || self.device.is_some() && graph.passes.iter().any(asks);
        let over = self.planned_over(world.cloned(), needed);
        let paper = Paper {
            output: [1280, 720],
            present: Present::of(graph.present),
            over: &over,
            conditions: Conditions::All,
        };
        match (paper.plan(&graph), &self.device) {
            (Ok(_), Some(device)) => {
                // What other devices lack does not matter.
                checked.found.retain(|found| found.code != codes::graph::NOT_PORTABLE);
                checked.found.extend(refused(device, &graph, &paper));
                checked.device = Some(device.capabilities().name.clone());
            }
            (Ok(plan), None) => {
                checked.found.extend(raxel_graph::rarely_met(&plan));
                // Where every condition holds, no pass of `!…` runs. Most of them run as the graph starts on a device without packets.
                let at_start = Paper { conditions: Conditions::AtStart, ..paper }.plan(&graph);
                for new in at_start.iter().flat_map(raxel_graph::rarely_met) {
                    if !checked.found.iter().any(|old| old.message == new.message && old.labels == new.labels) {
                        checked.found.push(new);
                    }
                }
            }
            (Err(errors), _) => checked.found.extend(errors),
        }
        checked.over = Some(over);
        Some(graph)
    }

    /// A demo is checked against its graph, and that over its world; errors of both are reported too, since the demo cannot run.
    fn check_demo(&self, path: &str, checked: &mut Checked) {
        let part = self.loader.demo(path);
        checked.add(&part);
        let Ok(demo) = part.result else { return };
        let world = self.built(&demo.world.value);
        let mut graphs = BTreeMap::new();
        for place in demo.all_graphs() {
            let before = checked.found.len();
            if let Some(graph) = self.check_graph(&place.value, world.result.as_ref().ok(), checked) {
                graphs.insert(place.value.as_str(), graph);
            }
            place.point_at_missing(&mut checked.found[before..]);
        }
        checked.found.extend(demo.check(&|path| graphs.get(path).map(|graph| &**graph)));
        let before = checked.found.len();
        checked.add_world(&world);
        demo.world.point_at_missing(&mut checked.found[before..]);
        if let Ok(world) = &world.result {
            checked.found.extend(demo.check_edits(&world.scene()));
        }
    }
}

/// The settings of a graph's plan without a device: the largest one, with estimated memory.
#[derive(Clone, Copy)]
pub struct Paper<'a> {
    /// Extent of the output in pixels.
    pub output: [u32; 2],
    /// The presented resource.
    pub present: Present,
    /// The world.
    pub over: &'a PlannedOver,
    /// Which passes run.
    pub conditions: Conditions<'a>,
}

/// The errors with which the start of a graph on a device ends.
fn refused(device: &OnPaper, graph: &Arc<Graph>, paper: &Paper<'_>) -> Vec<Diagnostic> {
    let planned = Paper { conditions: Conditions::OnDevice(device), ..*paper }.plan(graph);
    match planned.map(|plan| raxel_runtime::fits(&plan, device)) {
        Ok(Ok(())) => Vec::new(),
        Ok(Err(refusal)) => refusal.into_diagnostics(),
        Err(errors) => errors,
    }
}

impl Paper<'_> {
    /// The plan of a graph.
    pub fn plan(&self, graph: &Arc<Graph>) -> std::result::Result<Plan, Vec<Diagnostic>> {
        let planned = on_paper(graph, self, |input| raxel_graph::plan(graph.clone(), input));
        // Over another world than the one that is named, a graph may well be right.
        let missing = match self.over {
            PlannedOver::Named(world) => sources::check(graph, world),
            _ => Vec::new(),
        };
        match planned {
            Ok(plan) if missing.is_empty() => Ok(plan),
            Ok(_) => Err(missing),
            Err(found) => Err([found, missing].concat()),
        }
    }

    /// The result of a phase of the planner.
    pub fn dump(&self, graph: &Arc<Graph>, phase: Phase) -> std::result::Result<String, Vec<Diagnostic>> {
        on_paper(graph, self, |input| raxel_graph::dump(graph.clone(), input, phase))
    }

    fn holds(&self, graph: &Graph, fact: &Fact) -> bool {
        match (self.conditions, fact, self.over.world()) {
            (Conditions::All, ..) => true,
            (_, Fact::Param(param), _) => graph.params[param.0 as usize].default == Value::Bool(true),
            (Conditions::OnDevice(device), _, Some(world)) => {
                raxel_runtime::holds_on(device.capabilities(), graph, world, fact)
            }
            // Of packets nothing is known without a device, and every device does without; a world may be too large for them.
            (_, Fact::DevicePackets, _) | (Conditions::AtStart, Fact::DeviceBallots, _) => false,
            (Conditions::OnDevice(device), Fact::DeviceBallots, None) => device.capabilities().has_plain_ballots(),
            (Conditions::AtStart, _, Some(world)) => world.holds(fact),
            _ => true,
        }
    }
}

fn on_paper<T>(graph: &Graph, paper: &Paper<'_>, make: impl FnOnce(&PlanInput<'_>) -> T) -> T {
    let Paper { output, present, over, conditions } = *paper;
    let limits = match conditions {
        Conditions::OnDevice(device) => raxel_execute::limits(device.capabilities()),
        Conditions::All | Conditions::AtStart => LARGEST,
    };
    // How large they are is known once they are on a device.
    let sources = graph.source_names().into_iter().map(|name| (name.to_owned(), SourceSize::default())).collect();
    make(&PlanInput {
        present,
        facts: &|fact| paper.holds(graph, fact),
        world: over.world().map_or(WorldInput::ON_PAPER, SessionWorld::input),
        limits,
        ..PlanInput::on_paper(graph, output, &sources)
    })
}

//! What the verbs that need no GPU share: the project around a file, its compilers, and the reading of each kind of file.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, Severity, SourceMap, codes};
use raxel_graph::checked::{Fact, Graph, ResourceId};
use raxel_graph::memory::EstimatedMemory;
use raxel_graph::plan::{Limits, Plan, PlanInput, Present, SourceSize, WorldInput};
use raxel_graph::print::Phase;
use raxel_runtime::build::{Loader, Part, source_names};
use raxel_runtime::project::Project;
use raxel_runtime::world::SessionWorld;

use crate::console::{Console, To};
use crate::failure::Result;

/// Limits that no Vulkan 1.3 device in use exceeds by much: what does not fit these fits nowhere.
pub(crate) const LARGEST: Limits = Limits {
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
};

/// Kinds of files that raxel reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileKind {
    Graph,
    World,
    Demo,
}

impl FileKind {
    /// By the name of a file that somebody named: the folder it lies in decides what is no demo and no .vox.
    pub fn of_named(path: &Path) -> Self {
        let folder = path.parent().and_then(Path::file_name).is_some_and(|folder| folder == "worlds");
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        FileKind::of(&if folder { format!("worlds/{name}") } else { name })
    }

    /// By the name of a project path: `*.demo.toml` is a demo; `*.vox` and everything else in `worlds/` is a world.
    pub fn of(path: &str) -> Self {
        if path.ends_with(".demo.toml") {
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
        }
    }
}

/// A project and what loads its files.
pub(crate) struct Front {
    pub project: Project,
    pub loader: Loader,
}

/// What checking one file gave.
#[derive(Debug, Default)]
pub(crate) struct Checked {
    /// Everything found, errors and warnings.
    pub found: Vec<Diagnostic>,
    /// The texts that they point into.
    pub texts: SourceMap,
}

impl Checked {
    /// Numbers of errors and warnings.
    pub fn counts(&self) -> (usize, usize) {
        let errors = self.found.iter().filter(|d| d.severity == Severity::Error).count();
        (errors, self.found.len() - errors)
    }

    fn add<T>(&mut self, part: &Part<T>) {
        self.found.extend_from_slice(part.found());
        self.texts.extend(&part.texts);
    }
}

impl Front {
    /// The project around a file that somebody named, or around a folder.
    pub fn around(path: &Path) -> std::result::Result<Self, Box<Diagnostic>> {
        let project = if path.is_dir() { Project::around(path) } else { Project::around_file(path) }?;
        let loader = Loader::new(&project).map_err(|error| {
            let message = format!("the project cannot be read: {error}");
            Box::new(Diagnostic::error(codes::session::NO_PROJECT, message))
        })?;
        Ok(Self { project, loader })
    }

    /// The project around a file, and the file's project path. Without a file, `default` of the project around the current folder.
    pub fn of(
        named: Option<&Path>,
        default: impl FnOnce(&Project) -> std::result::Result<String, Box<Diagnostic>>,
        console: &Console,
    ) -> Result<(Self, String)> {
        let open = || {
            let front = Self::around(named.unwrap_or(Path::new(".")))?;
            let path = match named {
                Some(named) => front.project.path_of(named)?,
                None => default(&front.project)?,
            };
            Ok((front, path))
        };
        open().map_err(|diagnostic: Box<Diagnostic>| console.stop(&[*diagnostic]))
    }

    /// A part that is right, its warnings shown; or the failure, its errors shown.
    pub fn good<T>(part: Part<T>, console: &Console) -> Result<Arc<T>> {
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

    /// Plans a graph for an output size on paper: the largest device, estimated memory, every condition true.
    pub fn plan(graph: &Arc<Graph>, output: [u32; 2], present: Present) -> std::result::Result<Plan, Vec<Diagnostic>> {
        on_paper(graph, output, present, |input| raxel_graph::plan(graph.clone(), input))
    }

    /// Whether frames of a graph depend on those before them by more than the camera, whatever is shown and whichever conditions hold.
    /// What cannot be planned on paper counts as if they did.
    pub fn looks_back(graph: &Arc<Graph>, output: [u32; 2]) -> bool {
        let present = Present { resource: graph.present, age: 0, mip: 0, layer: 0, after: None };
        let all: Vec<ResourceId> = (0..graph.resources.len() as u32).map(ResourceId).collect();
        let facts: [&dyn Fn(&Fact) -> bool; 2] = [&|_| true, &|_| false];
        facts.iter().any(|facts| {
            let planned = on_paper(graph, output, present, |input| {
                raxel_graph::plan(graph.clone(), &PlanInput { pinned: &all, facts, ..input.clone() })
            });
            planned.map_or(true, |plan| plan.looks_back)
        })
    }

    /// What a phase of the planner leaves behind, on paper.
    pub fn dump(
        graph: &Arc<Graph>,
        output: [u32; 2],
        present: Present,
        phase: Phase,
    ) -> std::result::Result<String, Vec<Diagnostic>> {
        on_paper(graph, output, present, |input| raxel_graph::dump(graph.clone(), input, phase))
    }

    /// Checks a file of the project in every way that needs no GPU.
    pub fn check(&self, path: &str) -> Checked {
        let mut checked = Checked::default();
        match FileKind::of(path) {
            FileKind::Graph => {
                self.check_graph(path, &mut checked);
            }
            FileKind::World => checked.add(&self.loader.world(path)),
            FileKind::Demo => self.check_demo(path, &mut checked),
        }
        checked
    }

    fn check_graph(&self, path: &str, checked: &mut Checked) -> Option<Arc<Graph>> {
        let part = self.loader.graph(path);
        checked.add(&part);
        let graph = part.result.ok()?;
        let present = Present { resource: graph.present, age: 0, mip: 0, layer: 0, after: None };
        if let Err(errors) = Self::plan(&graph, [1280, 720], present) {
            checked.found.extend(errors);
        }
        Some(graph)
    }

    /// A demo is checked against its graph; errors of the graph and the world are reported too, since the demo cannot run.
    fn check_demo(&self, path: &str, checked: &mut Checked) {
        let part = self.loader.demo(path);
        checked.add(&part);
        let Ok(demo) = part.result else { return };
        if let Some(graph) = self.check_graph(&demo.graph.value, checked) {
            checked.found.extend(demo.check(&graph));
        }
        checked.add(&self.loader.world(&demo.world.value));
    }
}

fn on_paper<T>(graph: &Graph, output: [u32; 2], present: Present, make: impl FnOnce(&PlanInput<'_>) -> T) -> T {
    make(&PlanInput {
        output,
        present,
        pinned: &[],
        facts: &|_| true,
        counts: &[],
        sources: &source_names(graph).into_iter().map(|name| (name, SourceSize::default())).collect::<BTreeMap<_, _>>(),
        world: WorldInput::ON_PAPER,
        memory: &EstimatedMemory,
        alias: true,
        poison: false,
        limits: LARGEST,
    })
}

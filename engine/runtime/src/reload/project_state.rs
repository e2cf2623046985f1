//! The input of a build: the loaded files, and the session's choices.

use std::collections::BTreeMap;

use raxel_diagnostics::{Diagnostic, SourceMap, Spanned};
use raxel_graph::checked::Graph;
use raxel_graph::plan::Observe;

use crate::build::{self, DeviceContext, Selection};
use crate::debug_target::DebugTarget;
use crate::load::{LoadOutcome, Loader};
use crate::params::Params;
use crate::recording_files::{Content, note};
use crate::sources;
use crate::timeline::Demo;
use crate::world::SessionWorld;

/// The state that a session has loaded from its files.
#[derive(Clone)]
pub(crate) struct ProjectState {
    /// Project path of the graph that runs.
    pub graph_path: String,
    /// Project path of the world; `None` for the empty world.
    pub(crate) world_path: Option<String>,
    /// Project path of the demo, if one runs.
    pub demo_path: Option<String>,
    /// The graph that runs.
    pub graph: LoadOutcome<Graph>,
    /// The other graphs of the demo, by project path.
    pub(crate) other_graphs: BTreeMap<String, LoadOutcome<Graph>>,
    /// The world.
    pub world: LoadOutcome<SessionWorld>,
    /// The demo.
    pub demo: Option<LoadOutcome<Demo>>,
    /// The files that were named besides the demo. They replace those of the demo.
    pub named: Named,
}

/// A file of the project that replaces the running one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProjectFile {
    /// A graph, over the world that runs.
    Graph(String),
    /// A world, under the graph that runs.
    World(String),
    /// A demo with its graph and its world.
    Demo(String),
}

impl ProjectFile {
    /// Its project path.
    pub fn path(&self) -> &str {
        match self {
            ProjectFile::Graph(path) | ProjectFile::World(path) | ProjectFile::Demo(path) => path,
        }
    }
}

/// The user's choices besides a demo.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Named {
    /// A graph.
    pub graph: bool,
    /// A world.
    pub world: bool,
}

impl ProjectState {
    /// A graph alone, over the empty world.
    pub(crate) fn of_graph(path: &str, loader: &Loader) -> Self {
        Self {
            graph_path: path.to_owned(),
            world_path: None,
            demo_path: None,
            graph: loader.graph(path),
            other_graphs: BTreeMap::new(),
            world: LoadOutcome::without_file(SessionWorld::empty()),
            demo: None,
            named: Named::default(),
        }
    }

    /// The graph at a project path, if it is one of those that run here.
    pub(crate) fn graph_at(&self, path: &str) -> Option<&LoadOutcome<Graph>> {
        if path == self.graph_path { Some(&self.graph) } else { self.other_graphs.get(path) }
    }

    /// Lets another of the graphs run. False when there is none at that path.
    pub(crate) fn change_graph(&mut self, path: &str) -> bool {
        if path == self.graph_path {
            return true;
        }
        let Some(graph) = self.other_graphs.remove(path) else { return false };
        let before = std::mem::replace(&mut self.graph_path, path.to_owned());
        self.other_graphs.insert(before, std::mem::replace(&mut self.graph, graph));
        true
    }

    /// Loads another file in place of the running one. A demo that runs ends.
    pub(crate) fn open(&mut self, file: &ProjectFile, loader: &Loader) {
        (self.demo, self.demo_path, self.named) = (None, None, Named::default());
        self.other_graphs.clear();
        match file {
            ProjectFile::Graph(path) => (self.graph_path, self.graph) = (path.clone(), loader.graph(path)),
            ProjectFile::World(path) => (self.world_path, self.world) = (Some(path.clone()), loader.world(path)),
            ProjectFile::Demo(path) => {
                let part = loader.demo(path);
                if let Ok(demo) = &part.result {
                    let graph = &demo.graph.value;
                    (self.graph_path, self.graph) = (graph.clone(), loader.graph(graph));
                    name_missing(&mut self.graph, &demo.graph);
                }
                (self.demo, self.demo_path) = (Some(part), Some(path.clone()));
                self.follow_demo(loader);
            }
        }
    }

    /// Whether a graph, a world or a demo is another file than in `before`.
    pub(crate) fn is_of_other_files(&self, before: &Self) -> bool {
        let paths = |state: &Self| (state.graph_path.clone(), state.world_path.clone(), state.demo_path.clone());
        paths(self) != paths(before)
    }

    /// Loads the files of the demo that are new or were wrong, and drops the files that it names no longer. Returns whether the graphs
    /// and the world changed.
    pub(crate) fn follow_demo(&mut self, loader: &Loader) -> Named {
        let mut changed = Named::default();
        let Some(demo) = self.demo.as_ref().and_then(|part| part.result.as_ref().ok()).cloned() else { return changed };
        if !self.named.graph {
            let wanted = demo.all_graphs();
            for place in &wanted {
                if self.graph_at(&place.value).is_some_and(|part| part.result.is_ok()) {
                    continue;
                }
                let mut part = loader.graph(&place.value);
                name_missing(&mut part, place);
                if place.value == self.graph_path {
                    self.graph = part;
                } else {
                    self.other_graphs.insert(place.value.clone(), part);
                }
                changed.graph = true;
            }
            if wanted.iter().all(|place| place.value != self.graph_path) {
                self.change_graph(&demo.graph.value);
            }
            let count = self.other_graphs.len();
            self.other_graphs.retain(|path, _| wanted.iter().any(|place| place.value == *path));
            changed.graph |= self.other_graphs.len() != count;
        }
        if !self.named.world && (self.world_path.as_ref() != Some(&demo.world.value) || self.world.result.is_err()) {
            self.world = loader.world(&demo.world.value);
            name_missing(&mut self.world, &demo.world);
            self.world_path = Some(demo.world.value.clone());
            changed.world = true;
        }
        changed
    }

    /// Every file with its content.
    pub(super) fn files(&self) -> BTreeMap<String, Content> {
        let mut files = self.graph.files.clone();
        let others = self.other_graphs.values().map(|graph| &graph.files);
        // A file may have been saved between the loading of two parts that both read it.
        for part in others.chain([&self.world.files]).chain(self.demo.iter().map(|demo| &demo.files)) {
            part.iter().for_each(|(path, content)| note(&mut files, path.clone(), *content));
        }
        files
    }

    /// Everything found in all files, with the texts; the demo is held against its graphs.
    pub(crate) fn diagnostics(&self) -> (Vec<Diagnostic>, SourceMap) {
        let mut texts = self.graph.texts.clone();
        let mut found = self.graph.found().to_vec();
        for other in self.other_graphs.values() {
            texts.extend(&other.texts);
            // Graphs that share files say the same of them.
            found.extend(other.found().iter().filter(|diagnostic| !self.graph.found().contains(diagnostic)).cloned());
        }
        texts.extend(&self.world.texts);
        found.extend_from_slice(self.world.found());
        if let (Ok(graph), Ok(world)) = (&self.graph.result, &self.world.result) {
            found.extend(sources::unseen_instances(graph, world));
        }
        if let Some(demo) = &self.demo {
            texts.extend(&demo.texts);
            found.extend_from_slice(demo.found());
            if let Ok(demo) = &demo.result {
                let graph = |path: &str| {
                    let part = if self.named.graph { Some(&self.graph) } else { self.graph_at(path) };
                    part.and_then(|part| part.result.as_deref().ok())
                };
                found.extend(demo.check(&graph));
            }
            if let (Ok(demo), Ok(world)) = (&demo.result, &self.world.result) {
                found.extend(demo.check_edits(&world.scene()));
            }
        }
        (found, texts)
    }
}

/// A file that a demo names and that is missing is pointed at where the demo names it.
fn name_missing<T>(part: &mut LoadOutcome<T>, named: &Spanned<String>) {
    if let Err(found) = &mut part.result {
        named.point_at_missing(found);
    }
}

/// The session's present settings for builds.
#[derive(Clone)]
pub(crate) struct BuildSettings {
    /// Extent of the output in pixels.
    pub output: [u32; 2],
    /// Project path of the graph that is to run.
    pub graph_path: String,
    /// The shown resource.
    pub debug_target: DebugTarget,
    /// Resources that stay readable.
    pub pinned: Vec<String>,
    /// Other resources that can be read.
    pub observe: Observe,
    /// Params as the user set them.
    pub params: Params,
    /// Whether transient resources may share memory.
    pub alias: bool,
    /// The device.
    pub context: DeviceContext,
}

impl BuildSettings {
    /// The inputs of a plan of this graph, which is at `path`, and world. A debug target that the graph does not have gives way to the
    /// graph's own, and a pinned resource that it does not have is left out.
    pub(crate) fn selection(&self, path: &str, graph: &Graph, world: &SessionWorld) -> Selection {
        let mut params = self.params.clone();
        params.adopt(graph);
        let present = self.debug_target.resolve(graph).or_else(|_| DebugTarget::default().resolve(graph));
        Selection {
            graph: path.to_owned(),
            output: self.output,
            present: present.unwrap_or(raxel_graph::plan::Present::of(graph.present)),
            pinned: self.pinned.iter().filter_map(|name| graph.find_resource(name)).collect(),
            observe: self.observe,
            facts: build::facts(graph, world, &params, self.context.builder.device().capabilities()),
            counts: build::counts(graph, &params),
            alias: self.alias,
        }
    }
}

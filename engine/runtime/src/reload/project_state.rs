//! What a build works on: what was loaded from files, and what the session wants of them.

use std::collections::BTreeMap;

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_graph::checked::Graph;

use crate::build::{self, DeviceContext, Selection};
use crate::debug_target::DebugTarget;
use crate::load::Part;
use crate::params::Params;
use crate::recording_files::Content;
use crate::timeline::Demo;
use crate::world::SessionWorld;

/// What a session has loaded from its files.
#[derive(Clone)]
pub struct ProjectState {
    /// Project path of the graph.
    pub graph_path: String,
    /// Project path of the world; `None` for the empty world.
    pub world_path: Option<String>,
    /// Project path of the demo, if one runs.
    pub demo_path: Option<String>,
    /// The graph.
    pub graph: Part<Graph>,
    /// The world.
    pub world: Part<SessionWorld>,
    /// The demo.
    pub demo: Option<Part<Demo>>,
}

impl ProjectState {
    /// Every file with what was found in it.
    pub(super) fn files(&self) -> BTreeMap<String, Content> {
        let mut files = self.graph.files.clone();
        files.extend(self.world.files.clone());
        files.extend(self.demo.iter().flat_map(|demo| demo.files.clone()));
        files
    }

    /// Everything found in all files, with the texts; the demo is held against its graph.
    pub fn diagnostics(&self) -> (Vec<Diagnostic>, SourceMap) {
        let mut texts = self.graph.texts.clone();
        texts.extend(&self.world.texts);
        let mut found: Vec<Diagnostic> = self.graph.found().iter().chain(self.world.found()).cloned().collect();
        if let Some(demo) = &self.demo {
            texts.extend(&demo.texts);
            found.extend_from_slice(demo.found());
            if let (Ok(demo), Ok(graph)) = (&demo.result, &self.graph.result) {
                found.extend(demo.check(graph));
            }
            if let (Ok(demo), Ok(world)) = (&demo.result, &self.world.result) {
                found.extend(demo.check_edits_in(world));
            }
        }
        (found, texts)
    }
}

/// What the session wants at the moment, for builds.
#[derive(Clone)]
pub struct BuildSettings {
    /// Extent of the output in pixels.
    pub output: [u32; 2],
    /// What is shown.
    pub debug_target: DebugTarget,
    /// Resources that stay readable.
    pub pinned: Vec<String>,
    /// Params as the user set them.
    pub params: Params,
    /// Whether transient resources may share memory.
    pub alias: bool,
    /// The device.
    pub context: DeviceContext,
}

impl BuildSettings {
    /// What a plan of this graph and world is made for. A debug target that the graph does not have gives way to the graph's own,
    /// and a pinned resource that it does not have is left out.
    pub fn selection(&self, graph: &Graph, world: &SessionWorld) -> Selection {
        let mut params = self.params.clone();
        params.adopt(graph);
        let present = self.debug_target.resolve(graph).or_else(|_| DebugTarget::default().resolve(graph));
        Selection {
            output: self.output,
            present: present.unwrap_or(raxel_graph::plan::Present {
                resource: graph.present,
                age: 0,
                mip: 0,
                layer: 0,
                after: None,
            }),
            pinned: self.pinned.iter().filter_map(|name| graph.find_resource(name)).collect(),
            facts: build::facts(graph, world, &params),
            counts: build::counts(graph, &params),
            alias: self.alias,
        }
    }
}

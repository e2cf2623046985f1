//! Opening: files, device, first plan.

use std::collections::BTreeMap;
use std::panic::resume_unwind;
use std::path::Path;
use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, codes};
use raxel_execute::Region;
use raxel_gpu::Device;

use super::files::ProjectFiles;
use super::playback::Playback;
use super::renderer::{self, Renderer, Shown, open_device};
use super::world::WorldState;
use super::{OpenError, Options, Session};
use crate::build;
use crate::build_error::BuildError;
use crate::debug_target::DebugTarget;
use crate::editing::Editing;
use crate::load::{LoadOutcome, Loader};
use crate::params::Params;
use crate::present::Viewport;
use crate::project::Project;
use crate::reload::project_state::{BuildSettings, Named, ProjectState};
use crate::sources::SourceName;
use crate::world::SessionWorld;

impl Session {
    /// Opens a project: finds and loads its files, opens a device, makes a plan, and creates all resources. No frame has run yet.
    ///
    /// # Errors
    /// If the project's files have mistakes and [`Options::wait`] is false. If there is no suitable device, or the device refuses the plan.
    pub fn open(options: Options) -> Result<Self, OpenError> {
        let waits = options.wait.then(|| options.clone());
        match (Self::open_on(options, None), waits) {
            (Err(OpenError::Project { diagnostics, texts }), Some(options)) => {
                Self::wait_for_mend(options, diagnostics, texts)
            }
            (opened, _) => opened,
        }
    }

    /// Opens a project on a device that is open already, or on a new one.
    pub(super) fn open_on(mut options: Options, device: Option<Arc<Device>>) -> Result<Self, OpenError> {
        let _span = tracing::debug_span!("open session").entered();
        let project = find_project(&options)?;
        if let Some(defaults) = options.manifest {
            let manifest = project.manifest().map_err(OpenError::of_files)?;
            options.fill_in(defaults, &manifest, &project);
        }
        let loader = Loader::new(&project).map_err(|error| {
            Box::new(Diagnostic::error(codes::session::NO_PROJECT, format!("the project cannot be read: {error}")))
        })?;
        let loader = Arc::new(loader.with_layout(options.layout).with_unused(options.unused));
        loader.check_bounds(options.check_bounds);
        loader.record_writes(options.record_writes);
        let (state, device) = load(&project, &options, &loader, device)?;
        Self::start(options, ProjectFiles::new(project, loader, state), device)
    }

    /// Runs the loaded files.
    pub(super) fn start(
        options: Options,
        mut files: ProjectFiles,
        device: Result<Arc<Device>, raxel_gpu::Error>,
    ) -> Result<Self, OpenError> {
        let (graph, world) = match (&files.state.graph.result, &files.state.world.result) {
            (Ok(graph), Ok(world)) if !files.warnings.iter().any(Diagnostic::is_error) => {
                (graph.clone(), world.clone())
            }
            _ => return Err(files.open_error(files.warnings.clone())),
        };
        let demo = files.state.demo.as_ref().and_then(|demo| demo.result.clone().ok());
        // Resources that were asked for by name must be there; later, after an edit, they may be missing.
        options.debug_target.resolve(&graph)?;
        for name in &options.pinned {
            DebugTarget::resource(name).resolve(&graph)?;
        }

        let mut editing = Editing::new(world.clone());
        match &demo {
            // A demo shows the same everywhere, and so it begins with the voxels of the world's file.
            Some(demo) => editing.set_script(demo.script(editing.scene())),
            None => {
                files.warnings.extend(editing.open_save(files.project.root(), &**files.loader.files(), options.saves));
            }
        }
        if files.warnings.iter().any(Diagnostic::is_error) {
            return Err(files.open_error(files.warnings.clone()));
        }
        let world = editing.world().unwrap_or(world);
        let (executor, context) = renderer::start(&device?, &options)?;
        let mut params = Params::default();
        params.adopt(&graph);
        let shown = Shown {
            viewport: Viewport::new(options.size, options.scale),
            debug_target: options.debug_target.clone(),
            display: None,
            region: Region::WHOLE,
            pinned: options.pinned.clone(),
            live: None,
        };
        let settings = BuildSettings {
            graph_path: files.state.graph_path.clone(),
            output: shown.viewport.output(),
            debug_target: shown.debug_target.clone(),
            pinned: shown.kept(),
            observe: options.observe,
            params: params.clone(),
            alias: options.alias,
            context: context.clone(),
        };
        let selection = settings.selection(&files.state.graph_path, &graph, &world);
        let renderer = build::assemble(&graph, &world, &selection, &context)
            .and_then(|assembly| Renderer::new(executor, context, graph, &assembly, selection, shown))
            .map_err(|error| match error {
                BuildError::Diagnosed(diagnostics) => files.open_error(diagnostics),
                BuildError::Device(error) => OpenError::Device(error),
            })?;
        let playback = Playback::new(options.step, world.first_camera(), params, demo);
        let world = WorldState::new(world, editing);
        let mut session = Self { options, files, playback, world, renderer, waiting: None, events: Vec::new() };
        session.note_conditions();
        if session.options.watch {
            session.files.watch(settings, &session.options)?;
        }
        Ok(session)
    }
}

pub(super) fn find_project(options: &Options) -> Result<Project, Box<Diagnostic>> {
    if let Some(folder) = &options.project {
        return Project::around(folder).or_else(|_| Project::at(folder));
    }
    match options.demo.as_ref().or(options.graph.as_ref()) {
        Some(file) if file.exists() => Project::around_file(file),
        // It may be named relative to the project of the current folder, and then it is that project's to say that it is missing.
        Some(file) => Project::around(file).or_else(|_| Project::around(Path::new("."))).map_err(|_| {
            Box::new(Diagnostic::error(codes::files::NOT_FOUND, format!("`{}` does not exist", file.display())))
        }),
        None => Project::around(Path::new(".")),
    }
}

/// Loads graph, world and demo; the device is opened meanwhile, if it is not yet.
#[allow(clippy::type_complexity, reason = "two results, each for its own error")]
fn load(
    project: &Project,
    options: &Options,
    loader: &Loader,
    device: Option<Arc<Device>>,
) -> Result<(ProjectState, Result<Arc<Device>, raxel_gpu::Error>), OpenError> {
    if options.demo.is_none() && (options.graph.is_none() || options.world.is_none()) {
        // The mistakes come from there.
        project.manifest().map_err(OpenError::of_files)?;
    }
    let named = |path: &Option<std::path::PathBuf>| path.as_ref().map(|path| project.path_of(path)).transpose();
    let demo_path = named(&options.demo)?;
    let demo = demo_path.as_ref().map(|path| loader.demo(path));
    let of_demo = match &demo {
        None => None,
        Some(part) => match &part.result {
            Ok(demo) => Some(demo.clone()),
            // Without it, graph and world are unknown.
            Err(found) if options.graph.is_none() || options.world.is_none() => {
                return Err(OpenError::Project { diagnostics: found.clone(), texts: Box::new(part.texts.clone()) });
            }
            Err(_) => None,
        },
    };
    let graph_path = match (named(&options.graph)?, &of_demo) {
        (Some(path), _) => path,
        (None, Some(demo)) => demo.graph.value.clone(),
        (None, None) => project.default_graph()?,
    };
    let (world_path, no_world) = match (named(&options.world)?, &of_demo) {
        (Some(path), _) => (Some(path), None),
        (None, Some(demo)) => (Some(demo.world.value.clone()), None),
        (None, None) => match project.default_world() {
            Ok(path) => (Some(path), None),
            Err(error) => (None, Some(error)),
        },
    };
    // Threads of their own: graph and device wait for other processes and for the driver, and rayon's threads are the world's.
    let (mut graph, world, device) = std::thread::scope(|scope| {
        let graph = scope.spawn(|| loader.graph(&graph_path));
        let device = scope.spawn(|| device.map_or_else(|| open_device(options), Ok));
        let world = world_path
            .as_ref()
            .map_or_else(|| LoadOutcome::without_file(SessionWorld::empty()), |path| loader.world(path));
        let graph = graph.join().unwrap_or_else(|panic| resume_unwind(panic));
        (graph, world, device.join().unwrap_or_else(|panic| resume_unwind(panic)))
    });
    if let (Ok(loaded), Some(error)) = (&graph.result, no_world)
        && loaded.source_names().iter().any(|name| SourceName::parse(name).is_some_and(|source| source.is_of_world()))
    {
        graph.result = Err(vec![*error]);
    }
    let named = Named { graph: options.graph.is_some(), world: options.world.is_some() };
    let other_graphs = BTreeMap::new();
    let mut state = ProjectState { graph_path, world_path, demo_path, graph, other_graphs, world, demo, named };
    // The other graphs of the demo; a missing one is reported at the place of its name.
    state.follow_demo(loader);
    Ok((state, device))
}

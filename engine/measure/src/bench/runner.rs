//! Goes through a matrix on one device.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use glam::{Mat4, Vec2};
use raxel_diagnostics::{Diagnostic, SourceMap, each_once};
use raxel_execute::{ExecuteError, ExecutorOptions};
use raxel_gpu::{Device, DeviceKind, DeviceOptions};
use raxel_graph::checked::Graph;
use raxel_layouts::Layout;
use raxel_oracle::Oracle;
use raxel_oracle::camera::Pinhole;
use raxel_runtime::camera::Camera;
use raxel_runtime::load::Loader;
use raxel_runtime::runner::GraphRunner;
use raxel_runtime::sources::SourceName;
use raxel_runtime::world::SessionWorld;

use super::judge::{Truth, bounces, judge, judge_periods, period_bounces};
use super::measure::{Bounces, CaseError, Run, first, measure};
use super::{Case, Effort, Matrix, Measured, PassSpread, Refusal, Row};

/// Why a matrix is not run to its end.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// There is no device, or it was lost and does not open again.
    #[error(transparent)]
    Device(#[from] ExecuteError),
}

impl From<raxel_gpu::Error> for BenchError {
    fn from(error: raxel_gpu::Error) -> Self {
        Self::Device(error.into())
    }
}

/// A graph that can run.
#[derive(Clone)]
pub struct Ready {
    graph: Arc<Graph>,
    /// The layout of its world.
    layout: Option<Layout>,
    texts: Arc<SourceMap>,
}

/// A graph, or why it cannot run.
type Compiled = Result<Ready, Arc<Uncompiled>>;

/// The mistakes of a graph, and the texts that these point into.
#[derive(Debug)]
pub struct Uncompiled {
    found: Vec<Diagnostic>,
    texts: SourceMap,
}

/// Graphs that do not compile over their own layouts.
#[derive(Debug, Default)]
pub struct Broken {
    /// Project paths.
    pub graphs: Vec<String>,
    /// Its mistakes, each once.
    pub found: Vec<Diagnostic>,
    /// The texts that diagnostics point into.
    pub texts: SourceMap,
}

/// A device, and the graphs compiled so far.
pub struct Runner {
    loader: Arc<Loader>,
    options: DeviceOptions,
    device: Arc<Device>,
    on_device: GraphRunner,
    graphs: BTreeMap<(String, Option<Layout>), Compiled>,
    /// The last bounced rays with their answers: exact graphs bounce alike over every layout.
    bounced: Option<Truth>,
}

impl Runner {
    /// Opens a device.
    pub fn new(loader: Arc<Loader>, options: &DeviceOptions) -> Result<Self, BenchError> {
        let (device, on_device) = open(options)?;
        let (options, graphs) = (options.clone(), BTreeMap::new());
        Ok(Self { loader, options, device, on_device, graphs, bounced: None })
    }

    /// The device.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// Compiles a graph over a layout, or over its own, with the layout that its world then has.
    pub fn graph(&mut self, path: &str, layout: Option<Layout>) -> &Compiled {
        let key = (path.to_owned(), layout);
        self.graphs.entry(key).or_insert_with(|| {
            let part = self.loader.graph_over(path, layout);
            let texts = part.texts;
            match part.result {
                Err(found) => Err(Arc::new(Uncompiled { found, texts })),
                Ok(graph) => {
                    let layout = graph.source_names().into_iter().find_map(SourceName::world_layout);
                    Ok(Ready { graph, layout, texts: Arc::new(texts) })
                }
            }
        })
    }

    /// Compiles graphs over their own layouts, and reports those that fail. A graph that fails over another layout is no error: it may be
    /// made for some layouts only.
    pub fn broken(&mut self, graphs: &[String]) -> Broken {
        let mut broken = Broken::default();
        for path in graphs {
            if let Err(wrong) = self.graph(path, None)
                && !broken.graphs.contains(path)
            {
                broken.graphs.push(path.clone());
                broken.found.extend_from_slice(&wrong.found);
                broken.texts.extend(&wrong.texts);
            }
        }
        broken.found = each_once(broken.found);
        broken
    }

    /// Runs every case over worlds that are loaded; a row goes to `each` as soon as it is there. A case that cannot run is a row with the
    /// reason.
    pub fn run(
        &mut self,
        matrix: &Matrix,
        worlds: &[Arc<SessionWorld>],
        each: &mut dyn FnMut(Row),
    ) -> Result<(), BenchError> {
        for world in worlds {
            let oracle = Oracle::new(world.voxels());
            for (name, camera) in cameras(world, &matrix.cameras) {
                for &size in &matrix.sizes {
                    // The rays are the same for all graphs and layouts, and so are the answers.
                    let truth = Truth::of(&oracle, pinhole(&camera, size).rays(size));
                    for graph in &matrix.graphs {
                        let own = matrix.own.contains(graph);
                        for layout in self.layouts(graph, if own { &[] } else { &matrix.layouts }) {
                            let place = Place { world, oracle: &oracle, truth: &truth, camera: &camera, size };
                            let row = self.row(graph, layout, &name, &place, &matrix.effort)?;
                            each(row);
                        }
                    }
                }
            }
            self.on_device.forget_worlds();
        }
        Ok(())
    }

    /// The layouts that a graph is run over. One that has no world is run once.
    fn layouts(&mut self, graph: &str, wanted: &[Layout]) -> Vec<Option<Layout>> {
        let has_world = !matches!(self.graph(graph, None), Ok(Ready { layout: None, .. }));
        if wanted.is_empty() || !has_world { vec![None] } else { wanted.iter().copied().map(Some).collect() }
    }

    fn row(
        &mut self,
        path: &str,
        layout: Option<Layout>,
        camera: &str,
        place: &Place<'_>,
        effort: &Effort,
    ) -> Result<Row, BenchError> {
        let compiled = self.graph(path, layout).clone();
        let bound = compiled.as_ref().map_or(layout, |ready| ready.layout);
        let case = Case {
            graph: path.to_owned(),
            layout: bound.map(Layout::name),
            world: place.world.path.clone().unwrap_or_default(),
            camera: camera.to_owned(),
            size: place.size,
        };
        let outcome = match compiled {
            // The errors were printed before.
            Err(wrong) => Err(Refusal::new(first(&wrong.found))),
            Ok(Ready { graph, texts, .. }) => {
                match measure(&mut self.on_device, &graph, place.world, place.camera, place.size, effort) {
                    Ok(run) => Ok(self.judged(run, &graph, bound, place)),
                    Err(CaseError::Refused(refusal)) => Err(Refusal { texts, ..refusal }),
                    Err(CaseError::Lost(error)) => {
                        (self.device, self.on_device) = open(&self.options)?;
                        Err(Refusal::new(error.to_string()))
                    }
                }
            }
        };
        Ok(Row { case, outcome })
    }

    fn judged(&mut self, run: Run, graph: &Graph, layout: Option<Layout>, place: &Place<'_>) -> Measured {
        let mean = |steps: &[u32]| steps.iter().map(|n| f64::from(*n)).sum::<f64>() / steps.len().max(1) as f64;
        let steps = run.steps.as_deref().map(mean);
        let no_hit = || "it has no target `hit` of format rgba32i".to_owned();
        let depths = run.depths.is_some() && run.hits.is_some() && run.bounces.is_none();
        let (rays, time, judgement) = match (&run.hits, &run.bounces) {
            (Some(hits), Some((kind, found, places))) => {
                let of = |pixels: &[usize]| -> Vec<_> { pixels.iter().map(|pixel| found[*pixel]).collect() };
                let errors = match kind {
                    Bounces::Lattice => {
                        let (rays, pixels) = bounces(hits, places);
                        let truth = match self.bounced.take() {
                            Some(known) if known.rays == rays => known,
                            _ => Truth::of(place.oracle, rays),
                        };
                        judge(self.bounced.insert(truth), &of(&pixels), None)
                    }
                    Bounces::Period => {
                        let (rays, pixels) = period_bounces(hits, places);
                        judge_periods(place.oracle, &rays, &of(&pixels))
                    }
                };
                let pass = |pass: &&PassSpread| pass.pass.starts_with("bounce");
                let time = run.passes.iter().find(pass).map_or(run.frame, |pass| pass.time);
                (errors.rays, time, Ok(errors))
            }
            (hits, _) => {
                let judgement = hits.as_ref().map(|hits| judge(place.truth, hits, run.depths.as_deref()));
                (place.truth.rays.len() as u64, run.frame, judgement.ok_or_else(no_hit))
            }
        };
        Measured {
            rays,
            bounced: run.hits.is_some() && run.bounces.is_some(),
            frames: run.frames,
            time,
            passes: run.passes,
            once: run.once,
            steps,
            cost: layout.and_then(|layout| place.world.cost(layout)),
            voxels: place.world.voxels().solids(),
            depths,
            judgement,
            claims_exact: graph.about.split([' ', ':']).next_back() == Some("exact"),
        }
    }
}

/// The viewpoint of a case, and the voxels to be seen there.
struct Place<'a> {
    world: &'a SessionWorld,
    oracle: &'a Oracle<'a>,
    truth: &'a Truth,
    camera: &'a Camera,
    size: [u32; 2],
}

/// The cameras of a world: those wanted that it has, all that it names, or its first, which is called `camera`.
pub fn cameras(world: &SessionWorld, wanted: &[String]) -> Vec<(String, Camera)> {
    let first = || vec![("camera".to_owned(), world.first_camera())];
    let named = world.camera_names().filter_map(|name| Some((name.to_owned(), world.camera(name)?)));
    if wanted.is_empty() {
        let all: Vec<_> = named.collect();
        return if all.is_empty() { first() } else { all };
    }
    let all: Vec<_> = named.chain(first()).collect();
    all.into_iter().filter(|(name, _)| wanted.contains(name)).collect()
}

/// A camera as graphs push it.
pub fn pinhole(camera: &Camera, size: [u32; 2]) -> Pinhole {
    let builtins = raxel_runtime::builtins::of(camera, camera, size, &SessionWorld::empty());
    Pinhole {
        cell: builtins.camera_cell.into(),
        frac: builtins.camera_frac.into(),
        view_to_world: Mat4::from_cols_array_2d(&builtins.camera_view_to_world),
        tan_half_fov: Vec2::from_array(builtins.camera_tan_half_fov),
    }
}

/// A device whose executor only takes times: no memo, no marks after passes.
fn open(options: &DeviceOptions) -> Result<(Arc<Device>, GraphRunner), BenchError> {
    let device = Device::new(options)?;
    let patience = if device.capabilities().kind == DeviceKind::Cpu { 12 } else { 2 };
    let runner = GraphRunner::new(
        device.clone(),
        ExecutorOptions { memo: false, timings: true, markers: false, watchdog: Duration::from_secs(10) * patience },
    )?;
    Ok((device, runner))
}

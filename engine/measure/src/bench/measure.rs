//! One case: a graph over a world from a camera, timed and read back.

use std::sync::Arc;
use std::time::Instant;

use raxel_diagnostics::Diagnostic;
use raxel_execute::moment::Moment;
use raxel_execute::{Builtins, ExecuteError, Executor, FrameInputs};
use raxel_gpu::DeviceKind;
use raxel_graph::checked::{Graph, PassId, ResourceId, ResourceKind};
use raxel_runtime::BuildError;
use raxel_runtime::camera::Camera;
use raxel_runtime::params::Params;
use raxel_runtime::runner::{GraphRunner, Setup};
use raxel_runtime::world::SessionWorld;
use raxel_shader::format::Format;

use super::judge::HitTexel;
use super::{Effort, PassSpread, Refusal, Spread};

/// Why a case gives nothing.
#[derive(Debug)]
pub(super) enum CaseError {
    /// It cannot run here; the next one may.
    Refused(Refusal),
    /// The device is gone.
    Lost(ExecuteError),
}

impl From<ExecuteError> for CaseError {
    fn from(error: ExecuteError) -> Self {
        match error {
            ExecuteError::DeviceLost { .. } => Self::Lost(error),
            error => Self::Refused(Refusal::new(error.to_string())),
        }
    }
}

impl From<BuildError> for CaseError {
    fn from(error: BuildError) -> Self {
        match error {
            BuildError::Diagnosed(found) => Self::Refused(Refusal::of(found)),
            BuildError::Device(error) => error.into(),
        }
    }
}

/// The first mistake, in a line.
pub(super) fn first(found: &[Diagnostic]) -> String {
    let Some(error) = found.iter().find(|diagnostic| diagnostic.is_error()) else { return String::new() };
    let line = error.message.lines().next().unwrap_or_default();
    format!("{}: {line}", error.code)
}

/// The device's results of a case.
pub(super) struct Run {
    pub(super) frames: u32,
    /// Of whole frames.
    pub(super) frame: Spread,
    pub(super) passes: Vec<PassSpread>,
    pub(super) once: Vec<PassSpread>,
    /// The target `hit`.
    pub(super) hits: Option<Vec<HitTexel>>,
    pub(super) depths: Option<Vec<f32>>,
    pub(super) steps: Option<Vec<u32>>,
    /// The targets `bounce_hit`, or `period_hit`, and `place` of a graph that bounces.
    pub(super) bounces: Option<(Bounces, Vec<HitTexel>, Vec<[f32; 2]>)>,
}

/// The rays that leave the hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bounces {
    /// Rays of the tracing contract: the target `bounce_hit`.
    Lattice,
    /// Period rays: the target `period_hit`.
    Period,
}

/// The targets that are read back.
struct Judged {
    hit: Option<ResourceId>,
    depth: Option<ResourceId>,
    steps: Option<ResourceId>,
    place: Option<ResourceId>,
    bounce_hit: Option<(Bounces, ResourceId)>,
}

impl Judged {
    fn of(graph: &Graph) -> Self {
        let find = |name: &str, format: Format| {
            let id = graph.find_resource(name)?;
            match &graph.resource(id).kind {
                ResourceKind::Target(target) if target.format == format && target.layers == 1 => Some(id),
                _ => None,
            }
        };
        Self {
            hit: find("hit", Format::Rgba32i),
            depth: find("depth", Format::R32f),
            steps: find("steps", Format::R32ui),
            place: find("place", Format::Rg32f),
            bounce_hit: (find("bounce_hit", Format::Rgba32i).map(|id| (Bounces::Lattice, id)))
                .or_else(|| Some((Bounces::Period, find("period_hit", Format::Rgba32i)?))),
        }
    }

    fn all(&self) -> Vec<ResourceId> {
        [self.hit, self.depth, self.steps, self.place, self.bounce_hit.map(|(_, id)| id)]
            .into_iter()
            .flatten()
            .collect()
    }
}

/// Seconds that a GPU is kept busy before it is timed. While the judge counts, it lowers its clock: the first frames after took up to
/// twice as long.
const WAKING: f64 = 0.5;

/// Runs a case. The world's layouts are encoded and uploaded if they are not yet.
#[expect(clippy::cast_possible_truncation, reason = "frames of a measurement are counted in 32 bits")]
pub(super) fn measure(
    runner: &mut GraphRunner,
    graph: &Arc<Graph>,
    world: &SessionWorld,
    camera: &Camera,
    size: [u32; 2],
    effort: &Effort,
) -> Result<Run, CaseError> {
    let judged = Judged::of(graph);
    let mut params = Params::default();
    params.adopt(graph);
    // The output of a pass that runs once must stay for all frames.
    runner.load(graph, world, &params, Setup { output: size, pinned: judged.all(), alias: false })?;
    let executor = runner.executor();

    let mut frames = Frames { executor, graph, world, camera, params: &params, size, index: 0, disabled: Vec::new() };
    let began = Instant::now();
    let once = frames.settle()?;
    let software = frames.executor.device().capabilities().kind == DeviceKind::Cpu;
    let least = if software { 0.0 } else { WAKING };
    let mut warm = 0;
    loop {
        let seconds = began.elapsed().as_secs_f64();
        if seconds >= effort.seconds / 2.0 || (warm >= effort.warmup && seconds >= least) {
            break;
        }
        frames.run(camera)?;
        warm += 1;
    }
    let mut spans = Vec::new();
    let mut samples: Vec<(String, Vec<f64>)> = Vec::new();
    let began = Instant::now();
    let enough = |frames: usize, seconds: f64| match frames {
        0 => false,
        1..3 => seconds >= 4.0 * effort.seconds,
        _ => seconds >= effort.seconds,
    };
    while spans.len() < effort.frames as usize && !enough(spans.len(), began.elapsed().as_secs_f64()) {
        frames.run(camera)?;
        let Some(span) = frames.executor.gpu_times().span else {
            return Err(CaseError::Refused(Refusal::new("the device has no timestamps".to_owned())));
        };
        spans.push(span / 1e6);
        for (name, milliseconds) in frames.times() {
            match samples.iter_mut().find(|(known, _)| *known == name) {
                Some((_, all)) => all.push(milliseconds),
                None => samples.push((name, vec![milliseconds])),
            }
        }
    }
    let spread = |(pass, samples): (String, Vec<f64>)| Some(PassSpread { pass, time: Spread::of(&samples)? });
    Ok(Run {
        frames: spans.len() as u32,
        frame: Spread::of(&spans)
            .ok_or_else(|| CaseError::Refused(Refusal::new("no frame was asked for".to_owned())))?,
        passes: samples.into_iter().filter_map(spread).collect(),
        once,
        hits: read(executor, judged.hit)?,
        depths: read(executor, judged.depth)?,
        steps: read(executor, judged.steps)?,
        bounces: match judged.bounce_hit {
            Some((kind, id)) => read(executor, Some(id))?
                .zip(read(executor, judged.place)?)
                .map(|(found, places)| (kind, found, places)),
            None => None,
        },
    })
}

/// All texels of a target.
fn read<T: bytemuck::AnyBitPattern>(
    executor: &mut Executor,
    target: Option<ResourceId>,
) -> Result<Option<Vec<T>>, ExecuteError> {
    let texels = target.map(|target| executor.read_target(target, 0, 0, 0)).transpose()?;
    Ok(texels.map(|texels| texels.bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()))
}

/// Frames of one case, each waited for.
struct Frames<'a> {
    executor: &'a mut Executor,
    graph: &'a Graph,
    world: &'a SessionWorld,
    camera: &'a Camera,
    params: &'a Params,
    size: [u32; 2],
    index: u32,
    disabled: Vec<PassId>,
}

impl Frames<'_> {
    fn run(&mut self, camera: &Camera) -> Result<(), ExecuteError> {
        let builtins = Builtins {
            frame_index: self.index,
            ..raxel_runtime::builtins::of(camera, self.camera, self.size, self.world)
        };
        let inputs = FrameInputs {
            builtins: &builtins,
            params: self.params.values(),
            overrides: &[],
            clock: Moment::from(f64::from(self.index) / 60.0),
            disabled: &self.disabled,
        };
        self.index += 1;
        self.executor.frame(&inputs)?;
        self.executor.wait()?;
        // The times of this frame replace those of the one before.
        self.executor.timings();
        Ok(())
    }

    /// Milliseconds of the passes that ran in the last frame; the rounds of a loop count together.
    fn times(&mut self) -> Vec<(String, f64)> {
        let Some(plan) = self.executor.plan().cloned() else { return Vec::new() };
        let mut times: Vec<(String, f64)> = Vec::new();
        for time in self.executor.timings() {
            let Some(nanoseconds) = time.nanoseconds else { continue };
            let name = &self.graph.pass(plan.graph.declared(time.pass)).name;
            match times.iter_mut().find(|(known, _)| known == name) {
                Some((_, sum)) => *sum += nanoseconds / 1e6,
                None => times.push((name.clone(), nanoseconds / 1e6)),
            }
        }
        times
    }

    /// Runs everything, then again from elsewhere with the memo on. If the memo skips a pass then, a session would skip it in every frame
    /// (for example a baked table), and so does the bench from here on. Returns these passes with their times.
    fn settle(&mut self) -> Result<Vec<PassSpread>, ExecuteError> {
        let mut elsewhere = *self.camera;
        elsewhere.frac.x = if elsewhere.frac.x < 0.5 { elsewhere.frac.x + 0.25 } else { elsewhere.frac.x - 0.25 };
        elsewhere.yaw += 0.01;
        self.executor.set_memo(true);
        self.run(self.camera)?;
        let all = self.times();
        if all.len() < 2 {
            // All measured passes depend on the camera.
            self.executor.set_memo(false);
            return Ok(Vec::new());
        }
        self.run(&elsewhere)?;
        let again = self.times();
        self.executor.set_memo(false);
        let once: Vec<(String, f64)> =
            all.into_iter().filter(|(name, _)| again.iter().all(|(other, _)| other != name)).collect();
        self.disabled = once.iter().flat_map(|(name, _)| self.graph.cases(name)).collect();
        let spread = |(pass, time): (String, f64)| PassSpread { pass, time: Spread { median: time, p95: time } };
        Ok(once.into_iter().map(spread).collect())
    }
}

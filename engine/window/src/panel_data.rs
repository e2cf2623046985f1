//! The panels' view of a session: the parts that only another plan changes are kept, the others are gathered for each frame.

use std::collections::HashMap;
use std::sync::Arc;

use raxel_edit::Scene;
use raxel_edit::query::CastHit;
use raxel_execute::FrameReport;
use raxel_execute::moment::Moment;
use raxel_graph::checked::{Graph, Value};
use raxel_graph::plan::Plan;
use raxel_panels::view::{
    ComponentKind, Editing, Frame, Lane, Loading, Param, Pass, PassState, Shown, Solids, Swatch, Timeline, Track,
    World, WorldExtent, WorldStatistics,
};
use raxel_panels::{Samples, view};
use raxel_runtime::Session;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::params::components;
use raxel_runtime::present::Viewport;
use raxel_runtime::timeline::DemoInputs;
use raxel_workbench::demo;
use raxel_world::{Bounds, Material, srgb_from_linear};

use super::described::{Described, Row, accesses, place, state};

/// Times of frames and passes, and the parts of the running plan.
#[derive(Default)]
pub(crate) struct PanelData {
    /// Milliseconds from frame to frame.
    pub interval: Samples,
    cpu: Samples,
    gpu: Option<Samples>,
    passes: HashMap<String, Samples>,
    /// The frame whose GPU times were noted last.
    timed: Option<u64>,
    ran: [u32; 3],
    plan: Option<Arc<Described>>,
    /// The pointer rests on a pass, whose output is shown meanwhile.
    peeking: bool,
    /// The states of the passes before that: the plan for the shown output leaves others out, and the list must not change under the
    /// pointer.
    held: Option<(Arc<Described>, Vec<PassState>)>,
    /// Materials that edits can use.
    swatches: Vec<Swatch>,
    /// Small pictures of targets, by the names of pass and target. Indices are found for each frame: another plan has others.
    thumbnails: HashMap<(String, String), view::Thumbnail>,
    /// How many of them have arrived.
    arrived: u64,
}

impl PanelData {
    /// Notes the times of a frame.
    pub(crate) fn note(&mut self, session: &mut Session, report: &FrameReport) {
        self.held = self.held.take().filter(|_| self.peeking);
        self.ran = [report.dispatched, report.skipped, report.idle];
        self.cpu.push(report.cpu_nanoseconds as f64 / 1e6);
        let Some(plan) = session.plan().cloned() else { return };
        self.describe(session, &plan);
        let times = session.gpu_times();
        if times.frame.is_none() || times.frame == self.timed {
            return;
        }
        self.timed = times.frame;
        if let Some(span) = times.span {
            self.gpu.get_or_insert_with(Samples::warming).push(span / 1e6);
        }
        let Some(described) = &self.plan else { return };
        for row in &described.rows {
            let Ok(index) = row.planned else { continue };
            if let Some(nanoseconds) = times.passes.get(index).and_then(|time| time.nanoseconds) {
                self.passes.entry(row.name.clone()).or_insert_with(Samples::warming).push(nanoseconds / 1e6);
            }
        }
    }

    /// An edit runs: times before it no longer count.
    pub(crate) fn forget(&mut self) {
        let interval = std::mem::take(&mut self.interval);
        *self = PanelData { interval, peeking: self.peeking, ..PanelData::default() };
    }

    /// Whether the pointer rests on a pass, whose output is shown meanwhile. The states stay as they are until a frame has run after that
    /// has ended.
    pub(crate) fn peek(&mut self, session: &Session, peeking: bool) {
        if peeking && !self.peeking && self.held.is_none() {
            let outcomes = session.outcomes();
            self.held = self.plan.clone().map(|described| {
                let states = described.rows.iter().map(|row| state(row, &outcomes)).collect();
                (described, states)
            });
        }
        self.peeking = peeking;
    }

    /// Takes the thumbnails that have arrived. Whether there were any.
    pub(crate) fn take_thumbnails(&mut self, session: &mut Session) -> bool {
        let arrived = session.take_thumbnails();
        let any = !arrived.is_empty();
        let Some(described) = self.plan.clone() else { return any };
        for thumbnail in arrived {
            let Some(row) = described.rows.iter().find(|row| row.planned == Ok(thumbnail.pass)) else { continue };
            let written = accesses(session.graph(), &described.plan, row.pass).nth(thumbnail.access);
            let Some((resource, _)) = written else { continue };
            let name = session.graph().resource(resource).name.clone();
            self.arrived += 1;
            let found = view::Thumbnail {
                number: self.arrived,
                size: thumbnail.size.map(|side| side as usize),
                rgba: thumbnail.rgba.into(),
                ..view::Thumbnail::default()
            };
            self.thumbnails.insert((row.name.clone(), name), found);
        }
        any
    }

    /// Drops the thumbnails: no panel shows them.
    pub(crate) fn drop_thumbnails(&mut self) {
        self.thumbnails.clear();
    }

    /// The thumbnails of the passes that are shown.
    pub(crate) fn thumbnails(&self) -> Vec<view::Thumbnail> {
        let Some(described) = self.held.as_ref().map(|(described, _)| described).or(self.plan.as_ref()) else {
            return Vec::new();
        };
        let thumbnail = |((pass, resource), found): (&(String, String), &view::Thumbnail)| {
            Some(view::Thumbnail {
                pass: described.rows.iter().position(|row| row.name == *pass)?,
                resource: described.resources.iter().position(|known| known.name == *resource)?,
                ..found.clone()
            })
        };
        self.thumbnails.iter().filter_map(thumbnail).collect()
    }

    fn describe(&mut self, session: &Session, plan: &Arc<Plan>) {
        if self.plan.as_ref().is_none_or(|known| !Arc::ptr_eq(&known.plan, plan)) {
            self.plan = Some(Arc::new(Described::new(session.graph(), plan, session.texts())));
        }
    }

    /// Notes the materials of a world, if they differ from the known ones.
    #[expect(clippy::cast_possible_truncation, reason = "a world has at most `MAX_MATERIALS` materials besides air")]
    pub(crate) fn palette(&mut self, scene: &Scene) {
        // Index 0 is air, which no brush has.
        if self.swatches.len() + 1 == scene.materials.len().max(1) {
            return;
        }
        let swatch = |(index, material): (usize, &Material)| Swatch {
            material: index as u16,
            name: material.name.clone(),
            color: material.albedo.map(srgb_from_linear),
        };
        self.swatches = scene.materials.iter().enumerate().skip(1).map(swatch).collect();
    }

    /// The materials, as [`PanelData::palette`] has noted them.
    pub(crate) fn swatches(&self) -> &[Swatch] {
        &self.swatches
    }

    /// The passes with their times.
    pub(crate) fn passes(&self, session: &Session) -> Vec<Pass<'_>> {
        let pass = |(row, state)| {
            let Row { name, after, groups, place, output, .. }: &Row = row;
            Pass { name, after, groups, place, output: *output, times: self.passes.get(name), state }
        };
        if let Some((described, states)) = &self.held {
            return described.rows.iter().zip(states.iter().copied()).map(pass).collect();
        }
        let (rows, outcomes) = (self.plan.iter().flat_map(|described| &described.rows), session.outcomes());
        rows.map(|row| pass((row, state(row, &outcomes)))).collect()
    }

    /// A pass that is switched off.
    pub(crate) fn off(&self, session: &Session) -> Option<String> {
        let (mut rows, outcomes) = (self.plan.iter().flat_map(|described| &described.rows), session.outcomes());
        rows.find(|row| state(row, &outcomes) == PassState::Off).map(|row| row.name.clone())
    }

    /// Targets and buffers.
    pub(crate) fn resources(&self) -> &[view::Resource] {
        let described = self.held.as_ref().map(|(described, _)| described).or(self.plan.as_ref());
        described.map_or(&[], |described| &described.resources)
    }

    /// The params with their values.
    pub(crate) fn params(&self, session: &Session) -> Vec<Param> {
        params(session, |param| self.default_file(param))
    }

    /// Project path of the file that the default of a param stands in.
    pub(crate) fn default_file(&self, param: &raxel_graph::checked::Param) -> String {
        let known = self.plan.as_ref().and_then(|described| described.defaults.get(&param.name));
        known.cloned().unwrap_or_else(|| param.place.file.to_string())
    }

    /// Times, memory, scale.
    pub(crate) fn frame(&self, session: &Session, fps_cap: Option<u32>) -> Frame<'_> {
        let (memory, saved) = self.plan.as_ref().map_or((0, 0), |described| (described.memory, described.saved));
        Frame {
            interval: Some(&self.interval),
            cpu: Some(&self.cpu),
            gpu: self.gpu.as_ref(),
            memory,
            saved,
            scale: session.viewport().scale(),
            scales: [*Viewport::SCALES.start(), *Viewport::SCALES.end()],
            output: session.size(),
            fps_cap,
            device: session.device().capabilities().name.clone(),
            ran: self.ran,
            world: world_statistics(session),
        }
    }
}

/// The world in numbers.
fn world_statistics(session: &Session) -> WorldStatistics {
    let world = session.world();
    let extent = loading(session).map_or_else(
        || {
            let voxels = world.voxels();
            let shines = |(_, material): &(&u64, &Material)| material.emission > 0.0;
            WorldExtent::Whole {
                chunks: voxels.chunks().len(),
                voxels: voxels.solids(),
                lamps: voxels.counts().iter().zip(voxels.materials()).filter(shines).map(|(count, _)| count).sum(),
            }
        },
        WorldExtent::Around,
    );
    let bytes = |name: &str| Some((name.to_owned(), session.source(name)?.size().bytes));
    let names = session.graph().source_names().into_iter().filter(|name| name.starts_with("world."));
    let steps = session.edit_steps();
    WorldStatistics { extent, sources: names.filter_map(bytes).collect(), edits: [steps.undo, steps.redo] }
}

/// The progress of a streamed world.
fn loading(session: &Session) -> Option<Loading> {
    let (stats, kept) = (session.stream()?.stats(), session.world().kept()?);
    Some(Loading {
        there: [stats.wanted.saturating_sub(stats.missing), stats.wanted],
        device: [stats.pool.used, stats.pool.capacity],
        host: [kept.bytes, kept.capacity],
        found_made: [kept.hits, kept.misses],
        publications: stats.publications,
        lamps: stats.lights,
    })
}

/// The resource that a debug target shows; an empty one stands for the graph's own.
pub(crate) fn shown(target: &DebugTarget, graph: &Graph) -> Shown {
    let resource =
        if target.resource.is_empty() { &graph.resource(graph.present).name } else { &target.resource }.clone();
    Shown { resource, age: target.age, mip: target.mip, layer: target.layer, after: target.after.clone() }
}

/// The debug target that shows it.
pub(crate) fn debug_target(shown: &Shown) -> DebugTarget {
    DebugTarget {
        resource: shown.resource.clone(),
        age: shown.age,
        mip: shown.mip,
        layer: shown.layer,
        after: shown.after.clone(),
    }
}

/// The params with their values.
fn params(session: &Session, file_of: impl Fn(&raxel_graph::checked::Param) -> String) -> Vec<Param> {
    let drives = session.demo_drives();
    let tracks =
        |name: &str| session.demo().is_some_and(|demo| demo.tracks.iter().any(|track| track.param.value == name));
    let param = |param: &raxel_graph::checked::Param| Param {
        name: param.name.clone(),
        label: param.label.clone(),
        kind: kind(&param.default),
        value: components(&session.param(&param.name).unwrap_or(param.default)),
        default: components(&param.default),
        range: param.range,
        step: param.step,
        tooltip: param.tooltip.clone(),
        unit: param.unit.clone(),
        group: param.group.clone(),
        choices: param.choices.clone(),
        color: param.color,
        driven: drives && tracks(&param.name),
        file: file_of(param),
        place: place(&param.place, session.texts()),
    };
    session.params().iter().map(param).collect()
}

fn kind(value: &Value) -> ComponentKind {
    match value {
        Value::Bool(_) => ComponentKind::Bool,
        Value::I32(_) | Value::IVec2(_) | Value::IVec3(_) | Value::IVec4(_) => ComponentKind::Int,
        Value::U32(_) | Value::UVec2(_) | Value::UVec3(_) | Value::UVec4(_) => ComponentKind::Uint,
        Value::F32(_) | Value::Vec2(_) | Value::Vec3(_) | Value::Vec4(_) | Value::Mat4(_) => ComponentKind::Float,
    }
}

/// World and camera.
pub(crate) fn world(session: &Session, speed: f64) -> World<'static> {
    let (world, camera) = (session.world(), session.camera());
    World {
        path: world.path.clone(),
        solid: world.streamed().is_none().then(|| {
            let Bounds { min, max } = world.bounds();
            Solids { count: world.voxels().solids(), min, max }
        }),
        position: camera.position().to_array(),
        angles: [camera.yaw, camera.pitch, camera.fov].map(f64::to_degrees),
        speed,
        cameras: world.camera_names().map(str::to_owned).collect(),
        editing: Editing::default(),
    }
}

/// Material and place of a voxel that was met.
pub(crate) fn under(session: &Session, hit: &CastHit) -> String {
    let [x, y, z] = hit.exact.voxel;
    let name = session.scene().materials.get(usize::from(hit.exact.material)).map_or("?", |material| &material.name);
    format!("{name} at {x}, {y}, {z}, {:.1} voxels away", hit.distance)
}

/// The demo. `looped` is the user's choice.
pub(crate) fn timeline(session: &Session, looped: Option<bool>) -> Option<Timeline> {
    let demo = session.demo()?;
    let now = session.clock().now().map_or(Moment::START, |now| now.time);
    let params = demo.tracks.iter().map(|driven| {
        let name = &driven.param.value;
        Track::new(Lane::Param(name.clone()), name, driven.keys.values.iter().map(|key| key.value.0).collect())
    });
    let mut tracks = vec![Track::new(Lane::Camera, "camera", demo.camera.iter().map(|key| key.time.value).collect())];
    tracks.extend(params);
    tracks.push(Track::new(Lane::Graphs, "graph", demo.graphs.iter().map(|key| key.time.value).collect()));
    tracks.push(Track::new(Lane::Show, "target", demo.shows.iter().map(|key| key.time.value).collect()));
    tracks.push(Track::new(Lane::Edits, "edits", demo.edits.iter().map(|key| key.time.value).collect()));
    tracks.push(Track {
        lasting: demo.captions.iter().map(|caption| caption.until.value - caption.time.value).collect(),
        ..Track::new(Lane::Captions, "captions", demo.captions.iter().map(|caption| caption.time.value).collect())
    });
    tracks.push(Track::new(Lane::Checks, "checks", demo.checked_times()));
    tracks.extend(demo.inputs.iter().flat_map(DemoInputs::times).map(|(name, keys)| input_track(name, keys)));
    // The camera's row is there before its first key is recorded.
    tracks.retain(|track| track.lane == Lane::Camera || !track.keys.is_empty());
    Some(Timeline {
        name: demo.name.clone(),
        duration: demo.duration,
        time: demo.local_time(now),
        looped: looped.unwrap_or(demo.looped),
        drives: session.demo_drives(),
        tracks,
    })
}

/// The track of a demo that a row of the panel stands for.
pub(crate) fn lane(lane: &Lane) -> demo::Lane {
    match lane {
        Lane::Camera => demo::Lane::Camera,
        Lane::Param(name) => demo::Lane::Param(name.clone()),
        Lane::Graphs => demo::Lane::Graphs,
        Lane::Show => demo::Lane::Show,
        Lane::Edits => demo::Lane::Edits,
        Lane::Captions => demo::Lane::Captions,
        Lane::Checks => demo::Lane::Checks,
        Lane::Input(name) => demo::Lane::Input(name.clone()),
    }
}

/// Keys of an input that are drawn one by one. A take has one for each frame in which the cursor moves.
const MOST_KEYS: usize = 200;

/// The track of an input; one bar if it has too many keys to draw them apart.
fn input_track(name: &str, keys: Vec<f64>) -> Track {
    let (lane, title) = (Lane::Input(name.to_owned()), format!("input.{name}"));
    match (keys.first(), keys.last()) {
        (Some(first), Some(last)) if keys.len() > MOST_KEYS => {
            Track { lasting: vec![last - first], ..Track::new(lane, &title, vec![*first]) }
        }
        _ => Track::new(lane, &title, keys),
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "these values are exact")]
pub(crate) mod tests {
    use raxel_execute::Region;
    use raxel_runtime::{Observe, Options};

    use super::*;

    /// A session over these files, as a window has it.
    pub(crate) fn open(folder: &tempfile::TempDir, files: &[(&str, &str)]) -> Session {
        for (path, text) in files {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let project = Some(folder.path().to_owned());
        let options = Options { project, size: [8, 8], observe: Observe::Shown, ..Options::default() };
        Session::open(options).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn a_timeline_has_a_row_for_each_input_of_its_demo() {
        let folder = tempfile::tempdir().unwrap();
        let moves: Vec<String> = (0..300).map(|n| format!("[{}, [{n}, 2]]", f64::from(n) / 100.0)).collect();
        let demo = format!(
            "graph = \"a.toml\"\nworld = \"a.toml\"\nduration = 4.0\n[inputs]\nkeys = [[0.5, [\"KeyW\"]], [1.0, []]]\ncursor = [{}]\n",
            moves.join(", ")
        );
        let demo = ("worlds/a.demo.toml", demo.as_str());
        let world = (
            "worlds/a.toml",
            "[materials]\nstone = { albedo = [0.5, 0.5, 0.5] }\n[[build]]\nop = \"box\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nmaterial = \"stone\"\n",
        );
        drop(open(
            &folder,
            &[("graphs/a.toml", GRAPH), ("shaders/fill.comp", FILL), ("shaders/copy.comp", COPY), world, demo],
        ));
        let project = Some(folder.path().to_owned());
        let options = Options { project, size: [8, 8], demo: Some(demo.0.into()), ..Options::default() };
        let session = Session::open(options).unwrap_or_else(|error| panic!("{error}"));
        let timeline = timeline(&session, None).unwrap();
        let tracks: Vec<_> =
            timeline.tracks.iter().map(|track| (track.name.as_str(), track.keys.len(), track.lane.movable())).collect();
        assert_eq!(tracks, [("camera", 0, true), ("input.cursor", 1, false), ("input.keys", 2, false)]);
        assert!((timeline.tracks[1].lasts(0) - 2.99).abs() < 1e-9, "one bar");
    }

    const PYRAMID: &str = "name = \"pyramid\"\npresent = \"p\"\n[targets.p]\nformat = \"r32f\"\nmips = 4\n\
        [[passes]]\nname = \"first\"\nshader = \"fill.comp\"\ndispatch = { threads = \"p\" }\nbind = { c = \"p\" }\n\
        [loops.mips]\ncount = { mips = \"p\" }\n\
        [[passes]]\nname = \"down\"\nloop = \"mips\"\nshader = \"copy.comp\"\ndispatch = { threads = \"p\", mip = \"loop.next\" }\n\
        bind = { i = { target = \"p\", mip = \"loop.index\" }, c = { target = \"p\", mip = \"loop.next\" } }\n";

    #[test]
    fn a_pass_of_a_loop_shows_the_mip_that_it_writes_and_keeps_running() {
        let folder = tempfile::tempdir().unwrap();
        let files = [("graphs/pyramid.toml", PYRAMID), ("shaders/fill.comp", FILL), ("shaders/copy.comp", COPY)];
        let (mut session, mut data) = (open(&folder, &files), PanelData::default());
        let mut frame = |session: &mut Session| {
            let report = session.frame().unwrap();
            session.wait().unwrap();
            data.note(session, &report);
            let passes: Vec<_> = data.passes(session).iter().map(|p| (p.name.to_owned(), p.state, p.output)).collect();
            (passes, data.resources().to_vec())
        };
        session.set_debug_target_text("p,mip=3").unwrap();
        let (passes, resources) = frame(&mut session);
        let row = passes.iter().position(|(name, ..)| name == "down[2]").unwrap();
        let output = &resources[passes[row].2.unwrap()];
        let shown = Shown::after("p", Some("down[2]".to_owned())).part(output.uses[row]);
        assert_eq!((shown.mip, output.uses[row].reads, output.uses[row].writes), (3, true, true));
        session.set_debug_target(debug_target(&shown)).unwrap();
        let (passes, _) = frame(&mut session);
        assert!(passes.iter().all(|(_, state, _)| state.is_planned()), "{passes:?}");
    }

    const GRAPH: &str = "name = \"two\"\npresent = \"b\"\n[targets.a]\nformat = \"r32f\"\n[targets.b]\nformat = \"r32f\"\n\
        [[passes]]\nname = \"first\"\nshader = \"fill.comp\"\ndispatch = { threads = \"a\" }\nbind = { c = \"a\" }\n\
        [[passes]]\nname = \"second\"\nshader = \"copy.comp\"\ndispatch = { threads = \"b\" }\nbind = { i = \"a\", c = \"b\" }\n";
    pub(crate) const FILL: &str = "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(r32f) writeonly uniform image2D c;\n\
        void main() { imageStore(c, ivec2(gl_GlobalInvocationID.xy), vec4(0.5)); }\n";
    const COPY: &str = "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(r32f) readonly uniform image2D i;\n\
        layout(r32f) writeonly uniform image2D c;\n\
        void main() { ivec2 at = ivec2(gl_GlobalInvocationID.xy); imageStore(c, at, imageLoad(i, at)); }\n";

    #[test]
    fn a_round_that_changes_names_shows_what_it_wrote() {
        let folder = tempfile::tempdir().unwrap();
        let graph = "name = \"relax\"\npresent = \"a\"\n[targets.a]\nformat = \"r32f\"\n[targets.b]\nformat = \"r32f\"\n\
            [[passes]]\nname = \"first\"\nshader = \"fill.comp\"\ndispatch = { threads = \"a\" }\nbind = { c = \"a\" }\n\
            [loops.steps]\ncount = 2\nswap = [[\"a\", \"b\"]]\n\
            [[passes]]\nname = \"step\"\nloop = \"steps\"\nshader = \"add.comp\"\ndispatch = { threads = \"b\" }\nbind = { i = \"a\", c = \"b\" }\n";
        let add = COPY.replace("imageLoad(i, at)", "imageLoad(i, at) + 1.0");
        let files = [("graphs/relax.toml", graph), ("shaders/fill.comp", FILL), ("shaders/add.comp", &add)];
        let (mut session, mut data) = (open(&folder, &files), PanelData::default());
        let mut inspector = crate::inspector::Inspector::default();
        let report = session.frame().unwrap();
        data.note(&mut session, &report);
        for (round, written) in [("step[0]", 1.5), ("step[1]", 2.5)] {
            let passes = data.passes(&session);
            let output = passes.iter().find(|pass| pass.name == round).and_then(|pass| pass.output).unwrap();
            let shown = Shown::after(&data.resources()[output].name, Some(round.to_owned()));
            session.set_debug_target(debug_target(&shown)).unwrap();
            let numbers = eventually(|| {
                inspector.ask(&mut session);
                let report = session.frame().unwrap();
                session.wait().unwrap();
                inspector.take(&mut session, &report);
                let seen = inspector.view(&session, data.resources(), None, &Region::WHOLE)?;
                seen.statistics.clone().filter(|_| seen.shown == shown)
            });
            assert_eq!(numbers.range, [written; 2], "{round}");
        }
    }

    /// Asks until there is an answer: the numbers are worked out on another thread.
    pub(crate) fn eventually<T>(mut ask: impl FnMut() -> Option<T>) -> T {
        let until = std::time::Instant::now() + std::time::Duration::from_secs(120);
        loop {
            if let Some(answer) = ask() {
                return answer;
            }
            assert!(std::time::Instant::now() < until, "it never comes");
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
    }

    #[test]
    fn passes_are_timed_while_what_they_write_is_inspected() {
        let folder = tempfile::tempdir().unwrap();
        let graph = "name = \"two\"\npresent = \"b\"\n[targets.a]\nformat = \"r32f\"\n[targets.b]\nformat = \"r32f\"\n\
            [[passes]]\nname = \"first\"\nshader = \"time.comp\"\ndispatch = { threads = \"a\" }\nbind = { c = \"a\" }\n\
            [passes.push]\ntime = \"frame.time\"\n\
            [[passes]]\nname = \"second\"\nshader = \"copy.comp\"\ndispatch = { threads = \"b\" }\nbind = { i = \"a\", c = \"b\" }\n";
        let time = FILL.replace("void main", "layout(push_constant) uniform PC { float time; } pc;\nvoid main");
        let time = time.replace("0.5", "pc.time");
        let files = [("graphs/two.toml", graph), ("shaders/time.comp", &time), ("shaders/copy.comp", COPY)];
        let (mut session, mut data) = (open(&folder, &files), PanelData::default());
        let mut inspector = crate::inspector::Inspector::default();
        let mut timed = |target: &str, pass: usize| {
            session.set_debug_target_text(target).unwrap();
            let (mut counts, mut ranges) = (Vec::new(), Vec::new());
            for _ in 0..20 {
                inspector.ask(&mut session);
                let report = session.frame().unwrap();
                session.wait().unwrap();
                data.note(&mut session, &report);
                inspector.take(&mut session, &report);
                counts.extend(data.passes(&session)[pass].times.map(|times| times.iter().len()));
                let seen = inspector
                    .view(&session, data.resources(), None, &Region::WHOLE)
                    .and_then(|seen| seen.statistics.as_ref());
                ranges.extend(seen.map(|seen| seen.range[1]));
                std::thread::sleep(std::time::Duration::from_millis(30));
            }
            (counts, ranges)
        };
        for (target, pass) in [("b", 1), ("a", 0)] {
            let (counts, ranges) = timed(target, pass);
            assert!(counts.is_sorted() && counts[counts.len() - 1] > counts[0] + 8, "{counts:?}");
            assert!(ranges.last() > ranges.first(), "what is inspected changes: {ranges:?}");
        }
    }

    #[test]
    fn a_frame_of_two_ticks_has_a_row_for_each_dispatch() {
        let folder = tempfile::tempdir().unwrap();
        let graph = "name = \"two\"\npresent = \"b\"\n[clocks.sim]\nhz = 4\nmost = 2\n\
            [targets.a]\nformat = \"r32f\"\nclock = \"sim\"\n[targets.b]\nformat = \"r32f\"\n\
            [[passes]]\nname = \"first\"\nevery = \"sim\"\nshader = \"tick.comp\"\ndispatch = { threads = \"a\" }\nbind = { c = \"a\" }\n\
            push = { tick = \"clock.sim.tick\" }\n\
            [[passes]]\nname = \"second\"\nshader = \"copy.comp\"\ndispatch = { threads = \"b\" }\nbind = { i = \"a\", c = \"b\" }\n";
        let tick = FILL.replace("void main", "layout(push_constant) uniform PC { uint tick; } pc;\nvoid main");
        let tick = tick.replace("0.5", "pc.tick");
        drop(open(&folder, &[("graphs/two.toml", graph), ("shaders/tick.comp", &tick), ("shaders/copy.comp", COPY)]));
        let project = Some(folder.path().to_owned());
        let options = Options { project, size: [8, 8], step: Some(0.5), ..Options::default() };
        let mut session = Session::open(options).unwrap_or_else(|error| panic!("{error}"));
        let mut data = PanelData::default();
        for _ in 0..2 {
            let report = session.frame().unwrap();
            session.wait().unwrap();
            data.note(&mut session, &report);
        }
        let passes = data.passes(&session);
        let names: Vec<&str> = passes.iter().map(|pass| pass.name).collect();
        assert_eq!(names, ["first", "first, tick 2", "second"]);
        assert_eq!(data.frame(&session, None).ran, [3, 0, 0]);
    }

    #[test]
    fn the_list_of_passes_stays_while_the_pointer_rests_on_one() {
        let folder = tempfile::tempdir().unwrap();
        let files = [("graphs/two.toml", GRAPH), ("shaders/fill.comp", FILL), ("shaders/copy.comp", COPY)];
        let mut session = open(&folder, &files);
        let mut data = PanelData::default();
        let states = |data: &PanelData, session: &Session| -> Vec<PassState> {
            data.passes(session).iter().map(|pass| pass.state).collect()
        };
        let frame = |data: &mut PanelData, session: &mut Session, target: &str| {
            session.set_debug_target_text(target).unwrap();
            let report = session.frame().unwrap();
            session.wait().unwrap();
            data.note(session, &report);
        };
        frame(&mut data, &mut session, "b");
        assert_eq!(states(&data, &session), [PassState::Ran, PassState::Ran]);
        data.peek(&session, true);
        frame(&mut data, &mut session, "a");
        assert_eq!(states(&data, &session), [PassState::Ran, PassState::Ran]);
        // A click: the skipped passes are listed as skipped now.
        data.peek(&session, false);
        frame(&mut data, &mut session, "a");
        assert_eq!(states(&data, &session)[1], PassState::Unused);
        // The pointer goes without one.
        data.peek(&session, true);
        frame(&mut data, &mut session, "b");
        assert_eq!(states(&data, &session)[1], PassState::Unused);
        data.peek(&session, false);
        frame(&mut data, &mut session, "b");
        assert_ne!(states(&data, &session)[1], PassState::Unused);
    }
}

//! Runs systems: still, moving, and after a lamp went out.

use std::collections::BTreeMap;

use glam::DVec3;
use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_gpu::DeviceKind;
use raxel_graph::checked::{Fact, ResourceKind, Value};
use raxel_graph::plan::{Lifetime, Observe, Plan, ResourceDesc};
use raxel_oracle::Ray;
use raxel_runtime::camera::Camera;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::session::{Options, Session};
use raxel_shader::interface::ScalarKind;

use super::error::{flicker, judge};
use super::flip::hdr_flip;
use super::reference_store::Place;
use super::{
    CameraMotion, DeviceName, Effort, Lag, LightError, Motion, Outcome, Pan, Picture, Point, RADIANCE, REFERENCE,
    References, Scene, overlay,
};

/// Seeds of the two runs.
const SEEDS: [u32; 2] = [1, 2];
/// Milliseconds of GPU work that wake a GPU before it is timed.
const WAKING: f64 = 300.0;
/// Frames a second of motions.
const RATE: f64 = 60.0;
/// Voxels a second of a camera that moves sideways.
const SPEED: f64 = 53.0;

/// Runs systems over scenes.
pub struct Bench {
    effort: Effort,
    name: Option<DeviceName>,
    complaints: Vec<String>,
    messages: (Vec<Diagnostic>, SourceMap),
}

impl Bench {
    /// With nothing run yet.
    pub fn new(effort: Effort) -> Self {
        Self { effort, name: None, complaints: Vec::new(), messages: <(Vec<Diagnostic>, SourceMap)>::default() }
    }

    /// The device's name; known once something has run.
    pub fn device(&self) -> Option<&DeviceName> {
        self.name.as_ref()
    }

    /// Messages of the validation layer so far.
    pub fn complaints(&self) -> &[String] {
        &self.complaints
    }

    /// Messages of the last session, such as the counts of its passes, and the texts that they point into.
    pub fn take_messages(&mut self) -> (Vec<Diagnostic>, SourceMap) {
        std::mem::take(&mut self.messages)
    }

    fn listen(&mut self, session: &mut Session) {
        self.messages = (session.take_messages(), session.texts().clone());
        let said = session.device().log().take();
        self.complaints.extend(said.iter().map(|message| format!("[{}]: {}", message.id, message.text)));
    }

    /// The effort.
    pub fn effort(&self) -> &Effort {
        &self.effort
    }

    /// Makes the references of a scene, or finds those that an earlier run has made.
    pub fn references(&mut self, scene: &Scene) -> Result<References, LightError> {
        let mut session = self.open(REFERENCE, scene, &["sum", "squares"])?;
        let place = self.effort.keep.then(|| Place::of(&session, scene, &self.effort));
        if let Some(found) = place.as_ref().and_then(|place| place.read(&scene.name)) {
            return Ok(found);
        }
        let gpu = session.device().capabilities().kind != DeviceKind::Cpu;
        let made = References::make(&mut session, scene, (self.effort.goal, self.effort.most_paths), gpu);
        self.listen(&mut session);
        if let (Some(place), Ok(made)) = (&place, &made) {
            place.write(made);
        }
        made
    }

    /// Runs a system in a scene, and judges it.
    pub fn system(&mut self, graph: &str, scene: &Scene, references: &References) -> Result<Outcome, LightError> {
        let mut session = self.open(graph, scene, &[])?;
        let (both, epsilon) = (references.both(), references.about.epsilon);
        wake(&mut session)?;
        let runs = SEEDS.map(|seed| still(&mut session, seed, self.effort.frames));
        let [first, second] = runs;
        let (first, second) = (first?, second?);
        let times = first.times.cumulative();
        let still: Vec<Point> = (first.pictures.iter().zip(&second.pictures))
            .map(|((frame, a), (_, b))| Point {
                frame: *frame,
                ms: times[*frame as usize - 1],
                judged: judge([a, b], both, epsilon),
            })
            .collect();
        let last = first.pictures.last_key_value().map(|(_, picture)| picture);
        let pan = (self.effort.pan > 0)
            .then(|| pan(&mut session, &scene.motion, self.effort.pan, both, epsilon))
            .transpose()?;
        let dark = references.about.dark.filter(|_| self.effort.lag > 0 && session.param("lamp_strength").is_ok());
        let lag = dark.map(|dark| lag(&mut session, &self.effort, dark)).transpose()?;
        self.listen(&mut session);
        Ok(Outcome {
            flip: last.and_then(|last| hdr_flip(both[0], last)),
            mean: last.map_or(0.0, Picture::mean),
            flicker: first
                .before_last
                .as_ref()
                .zip(last)
                .map_or(0.0, |(before, last)| flicker(before, last, both, epsilon)),
            still,
            first_ms: first.times.first(),
            frame_ms: first.times.later(),
            rests: first.rests,
            bytes: session.plan().map_or(0, |plan| own_bytes(plan)),
            pan,
            lag,
        })
    }

    fn open(&mut self, graph: &str, scene: &Scene, pinned: &[&str]) -> Result<Session, LightError> {
        let graph = overlay::with_params(&self.effort.project, graph, &scene.instance_params)?;
        let mut session = Session::open(Options {
            project: Some(self.effort.project.clone()),
            graph: Some(graph.into()),
            world: Some((&scene.world).into()),
            size: self.effort.size,
            device: self.effort.device.clone(),
            validation: self.effort.validation,
            watchdog: std::time::Duration::from_secs(30),
            observe: Observe::Shown,
            ..Options::default()
        })?;
        let floats = session.graph().find_resource(RADIANCE).is_some_and(|id| {
            matches!(&session.graph().resource(id).kind, ResourceKind::Target(target) if target.format.scalar() == ScalarKind::Float)
        });
        if !floats {
            return Err(LightError::NoRadiance);
        }
        // Passes that only make a picture of the light are not timed.
        for name in pinned.iter().chain(&[RADIANCE]) {
            // Both names are in the graph: the reference's are its own, and the other one was found.
            let _ = session.pin(name);
        }
        let _ = session.set_debug_target(DebugTarget::resource(RADIANCE));
        for (name, value) in &scene.params {
            if session.param(name).is_ok() {
                session.set_param(name, Value::F32(*value))?;
            }
        }
        for (name, text) in &scene.set {
            if session.param(name).is_ok() {
                session.set_param_text(name, text)?;
            }
        }
        // A system with a sky and surfaces of its own has this param, to be compared.
        if let Ok(Value::Bool(_)) = session.param("judged") {
            session.set_param("judged", Value::Bool(true))?;
        }
        if let Some(camera) = scene.camera {
            session.set_camera(camera);
        }
        self.name.get_or_insert_with(|| DeviceName::of(session.device()));
        Ok(session)
    }
}

/// Bytes that a plan takes on the device, the world and other sources not counted.
fn own_bytes(plan: &Plan) -> u64 {
    let apart = plan.resources.iter().filter(|resource| {
        let supplied = matches!(resource.desc, ResourceDesc::Source(_) | ResourceDesc::SourceImage(..));
        !supplied && !matches!(resource.lifetime, Lifetime::Transient { place: Some(_), .. })
    });
    let apart = apart.map(|resource| resource.memory.size * u64::from(resource.copies));
    apart.chain(plan.blocks.iter().map(|block| block.size)).sum()
}

/// Whether a lamp can go out there.
pub(super) fn has_lamps(session: &Session) -> bool {
    session.world().holds(&Fact::WorldHasEmission) && session.param("lamp_strength").is_ok()
}

/// Gives a system other random numbers; one without a `seed` has none.
fn seed(session: &mut Session, seed: u32) -> Result<(), LightError> {
    match session.param("seed") {
        Ok(Value::U32(_)) => session.set_param("seed", Value::U32(seed))?,
        Ok(Value::I32(_)) => session.set_param("seed", Value::I32(seed.cast_signed()))?,
        Ok(_) | Err(_) => {}
    }
    Ok(())
}

/// GPU milliseconds of passes, frame by frame.
#[derive(Default)]
struct Times {
    frames: Vec<BTreeMap<u32, f64>>,
}

impl Times {
    /// Runs a frame and notes its passes.
    fn frame(&mut self, session: &mut Session) -> Result<bool, LightError> {
        let report = session.frame()?;
        session.wait()?;
        let passes = session.timings().iter().filter_map(|time| Some((time.pass.0, time.nanoseconds? / 1e6)));
        self.frames.push(passes.collect());
        Ok(report.dispatched > 0)
    }

    /// Of the first frame, which also makes the constant resources.
    fn first(&self) -> f64 {
        self.frames.first().map_or(0.0, |frame| frame.values().sum())
    }

    /// The median of each pass over the frames in which it ran, the first one left out where there are others.
    fn medians(&self) -> BTreeMap<u32, f64> {
        let mut samples: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
        for frame in self.frames.iter().skip(usize::from(self.frames.len() > 1)) {
            for (pass, time) in frame {
                samples.entry(*pass).or_default().push(*time);
            }
        }
        let median = |mut times: Vec<f64>| {
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        };
        samples.into_iter().map(|(pass, times)| (pass, median(times))).collect()
    }

    /// A later frame: the sum of the medians, each by how often its pass ran.
    fn later(&self) -> f64 {
        let medians = self.medians();
        let skipped = usize::from(self.frames.len() > 1);
        let sum: f64 =
            (self.frames.iter().skip(skipped)).flat_map(BTreeMap::keys).filter_map(|pass| medians.get(pass)).sum();
        sum / (self.frames.len() - skipped).max(1) as f64
    }

    /// Up to each frame.
    fn cumulative(&self) -> Vec<f64> {
        let medians = self.medians();
        let mut sum = 0.0;
        let frame = |frame: &BTreeMap<u32, f64>| {
            sum += frame.iter().map(|(pass, time)| medians.get(pass).unwrap_or(time)).sum::<f64>();
            sum
        };
        self.frames.iter().map(frame).collect()
    }
}

/// A GPU lowers its clock while nothing runs: the first frames after took up to twice as long.
fn wake(session: &mut Session) -> Result<(), LightError> {
    if session.device().capabilities().kind == DeviceKind::Cpu {
        return Ok(());
    }
    let mut times = Times::default();
    while times.frames.iter().flat_map(BTreeMap::values).sum::<f64>() < WAKING && times.frames.len() < 400 {
        times.frame(session)?;
    }
    Ok(())
}

/// One run under a still camera.
struct Run {
    /// At the powers of two, and at the end.
    pictures: BTreeMap<u32, Picture>,
    before_last: Option<Picture>,
    times: Times,
    rests: bool,
}

fn still(session: &mut Session, number: u32, frames: u32) -> Result<Run, LightError> {
    seed(session, number)?;
    session.reset();
    let mut run = Run { pictures: BTreeMap::new(), before_last: None, times: Times::default(), rests: false };
    for frame in 1..=frames {
        run.rests = !run.times.frame(session)?;
        if frame.is_power_of_two() || frame == frames {
            run.pictures.insert(frame, Picture::of(&session.read_target(RADIANCE)?));
        }
        if frame + 1 == frames {
            run.before_last = Some(Picture::of(&session.read_target(RADIANCE)?));
        }
    }
    Ok(run)
}

/// A camera and params that move, and end where the references were made.
fn pan(
    session: &mut Session,
    motion: &Motion,
    frames: u32,
    references: [&Picture; 2],
    epsilon: f64,
) -> Result<Pan, LightError> {
    let end = *session.camera();
    let seconds = f64::from(frames - 1) / RATE;
    let way = match motion.camera {
        CameraMotion::Sideways => free_way(session, &end, SPEED * seconds),
        CameraMotion::By(rate) => free(session, &end, -DVec3::from_array(rate) * seconds),
    };
    let driven = driven(session, motion);
    let mut pictures = Vec::new();
    let mut times = Times::default();
    for number in SEEDS {
        seed(session, number)?;
        place(session, &end, way, &driven, seconds, 1.0)?;
        session.reset();
        for frame in 1..=frames {
            let left = f64::from(frames - frame) / f64::from((frames - 1).max(1));
            place(session, &end, way, &driven, seconds, left)?;
            times.frame(session)?;
        }
        pictures.push(Picture::of(&session.read_target(RADIANCE)?));
    }
    place(session, &end, way, &driven, seconds, 0.0)?;
    let judged = judge([&pictures[0], &pictures[1]], references, epsilon);
    Ok(Pan { voxels: way.length(), frame_ms: times.later(), judged })
}

/// A param that moves.
struct Driven {
    name: String,
    /// Where it ends.
    end: Value,
    /// Change in a second.
    rate: f64,
    range: [f64; 2],
}

/// The params of a motion that the graph has, as numbers.
fn driven(session: &Session, motion: &Motion) -> Vec<Driven> {
    let of = |(name, rate): &(String, f32)| {
        let param = session.params().iter().find(|param| param.name == *name)?;
        let end = session.param(name).ok()?;
        let range = param.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        Some(Driven { name: name.clone(), end, rate: f64::from(*rate), range })
    };
    motion.params.iter().filter_map(of).collect()
}

/// Puts everything that moves where it is while this part of its way is still ahead. A param stays in its range.
#[expect(
    clippy::cast_possible_truncation,
    reason = "params of graphs are 32-bit numbers, and casts of floats saturate"
)]
fn place(
    session: &mut Session,
    end: &Camera,
    way: DVec3,
    driven: &[Driven],
    seconds: f64,
    left: f64,
) -> Result<(), LightError> {
    session.set_camera(moved(end, way * left));
    for Driven { name, end, rate, range } in driven {
        let at = |end: f64| (end - rate * seconds * left).clamp(range[0], range[1]);
        let value = match end {
            _ if left == 0.0 => *end,
            Value::F32(end) => Value::F32(at(f64::from(*end)) as f32),
            Value::I32(end) => Value::I32(at(f64::from(*end)).round() as i32),
            other => *other,
        };
        session.set_param(name, value)?;
    }
    Ok(())
}

fn moved(camera: &Camera, by: DVec3) -> Camera {
    let mut camera = *camera;
    if by != DVec3::ZERO {
        camera.translate(by);
    }
    camera
}

/// The way to the left or right along which a camera can come from furthest, at most so far: short of the first voxel.
fn free_way(session: &Session, camera: &Camera, most: f64) -> DVec3 {
    let right = camera.rotation() * DVec3::X;
    let (to_right, to_left) = (free(session, camera, right * most), free(session, camera, -right * most));
    if to_right.length() >= to_left.length() { to_right } else { to_left }
}

/// As much of a way as is free from a camera on: short of the first voxel. Nothing of it in a voxel.
fn free(session: &Session, camera: &Camera, way: DVec3) -> DVec3 {
    let most = way.length();
    if most == 0.0 {
        return way;
    }
    let ray = Ray::new(camera.cell.to_array(), camera.frac.to_array(), way.as_vec3().to_array());
    match session.cast(&ray, 2.0 * most) {
        Ok(None) => way,
        Ok(Some(hit)) => way * (0.8 * hit.distance / most).min(1.0),
        // The distance there is unknown.
        Err(_) => DVec3::ZERO,
    }
}

/// Lets the light settle, switches the lamps off, and looks how much of their light is left.
fn lag(session: &mut Session, effort: &Effort, dark: f64) -> Result<Lag, LightError> {
    seed(session, SEEDS[0])?;
    session.reset();
    for _ in 0..effort.frames {
        session.frame()?;
    }
    let before = Picture::of(&session.read_target(RADIANCE)?).mean() - dark;
    session.set_param("lamp_strength", Value::F32(0.0))?;
    let mut lag = Lag { to_5_percent: None, to_1_percent: None, left: 1.0, frames: effort.lag };
    for frame in 1..=effort.lag {
        session.frame()?;
        lag.left = (Picture::of(&session.read_target(RADIANCE)?).mean() - dark) / before;
        for (reached, part) in [(&mut lag.to_5_percent, 0.05), (&mut lag.to_1_percent, 0.01)] {
            if lag.left.abs() <= part {
                reached.get_or_insert(frame);
            } else {
                *reached = None;
            }
        }
    }
    session.unset_param("lamp_strength")?;
    Ok(lag)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_medians_by_how_often_a_pass_ran() {
        // Pass 0 in each of five frames, pass 1 in the first and in one of the four others.
        let frame = |passes: &[(u32, f64)]| passes.iter().copied().collect::<BTreeMap<_, _>>();
        let times = Times {
            frames: vec![
                frame(&[(0, 9.0), (1, 5.0), (2, 7.0)]),
                frame(&[(0, 2.0)]),
                frame(&[(0, 2.0), (1, 4.0)]),
                frame(&[(0, 2.0)]),
                frame(&[(0, 50.0)]),
            ],
        };
        assert!((times.first() - 21.0).abs() < 1e-12);
        assert!((times.later() - 3.0).abs() < 1e-12);
        // Passes that ran only in the first frame count with that time; the others with their medians.
        let expected = [13.0, 15.0, 21.0, 23.0, 25.0];
        assert!(times.cumulative().iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}

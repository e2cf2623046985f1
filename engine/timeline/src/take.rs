//! Takes: the inputs of the frames of a session, as a demo that repeats them. A take has the camera, params, inputs and the debug target of
//! each frame, the edits of the world between them, and the microphone's sound.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use raxel_edit::{Operation, Scene as EditScene};
use raxel_graph::checked::{Graph, Value};

use crate::camera::Camera;
use crate::clock::{FrameTime, Pace};
use crate::debug_target::DebugTarget;
use crate::edits::written;
use crate::inputs::{HISTORY, Heard, KeySet, SAMPLE_RATE, ShownInputs, button_names, gamepad_button_names};
use crate::params;

/// Longest take, in seconds.
pub const MOST_SECONDS: f64 = 600.0;

/// Samples of the longest take.
const MOST_SAMPLES: usize = 600 * SAMPLE_RATE as usize;

/// Most edits of a take.
pub const MOST_EDITS: usize = 20_000;

/// Frames a second of a take whose frames came as they could.
const LIVE_RATE: f64 = 60.0;

/// Why a take ended before it was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Ended {
    /// The clock was put back.
    #[error("time went back")]
    TimeWentBack,
    /// The session runs another graph.
    #[error("another graph runs")]
    OtherGraph,
    /// The picture has another size, so pixels of the cursor mean another place.
    #[error("the picture has another size")]
    OtherSize,
    /// The microphone hears something else than before: another file, or one file from another moment on.
    #[error("the microphone hears another sound")]
    OtherSound,
    /// An edit was undone or made again, or is one that no demo's file can say.
    #[error("a demo has no undo, and no edit of this kind")]
    Unsaid,
    /// It has [`MOST_EDITS`].
    #[error("a take has 20,000 edits at most")]
    ManyEdits,
    /// It has [`MOST_SECONDS`].
    #[error("a take lasts 10 minutes at most")]
    Full,
}

/// Why no take begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TakeError {
    /// A demo needs a world.
    #[error("a take is a demo, and a demo needs a world: this session has none")]
    NoWorld,
    /// One take at a time.
    #[error("a take is being recorded already")]
    Recording,
    /// There is nothing to stop.
    #[error("no take is being recorded")]
    NotRecording,
    /// A demo has one frame at least.
    #[error("the take has no frame")]
    Empty,
}

/// A finished take.
#[derive(Clone, Debug, PartialEq)]
pub struct Take {
    /// The text of its demo file.
    pub text: String,
    /// The sound that its demo file names, if the graph heard one: a channel of [`SAMPLE_RATE`] samples a second.
    pub sound: Option<Vec<i16>>,
    /// Its length.
    pub seconds: f64,
    /// Why it is shorter than requested.
    pub ended: Option<Ended>,
}

/// The part that is the same in all frames of a take.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Project path of the world.
    pub world: String,
    /// Project path of the graph.
    pub graph: String,
    /// Extent of the output.
    pub size: [u32; 2],
    /// How its clock goes.
    pub pace: Pace,
}

/// The inputs of a frame.
pub struct Told<'a> {
    /// The time of the frame.
    pub time: &'a FrameTime,
    /// Project path of the graph.
    pub graph_path: &'a str,
    /// The graph.
    pub graph: &'a Graph,
    /// Extent of the output.
    pub size: [u32; 2],
    /// Values of the graph's params, in its order.
    pub values: &'a [Value],
    /// The camera.
    pub camera: &'a Camera,
    /// Mouse, keyboard and time of day.
    pub inputs: &'a ShownInputs,
    /// The microphone, if the graph hears it.
    pub heard: Option<Heard<'a>>,
    /// The target that is shown.
    pub target: &'a DebugTarget,
}

/// Notes frame after frame. A copy shares the sound and the edits, so that it can be written on another thread while frames go on.
#[derive(Clone, Debug)]
pub struct Recorder {
    scene: Scene,
    camera: Recorded<Camera>,
    params: BTreeMap<String, Recorded<Value>>,
    cursor: Recorded<Option<[i32; 2]>>,
    buttons: Recorded<u32>,
    wheel: Recorded<[f64; 2]>,
    keys: Recorded<KeySet>,
    gamepad_sticks: Recorded<[f64; 4]>,
    gamepad_triggers: Recorded<[f64; 2]>,
    gamepad_buttons: Recorded<u32>,
    targets: Recorded<DebugTarget>,
    /// The graph's sound, from the start on.
    sound: Samples,
    /// The last value of [`Heard::changes`].
    sound_changes: Option<u64>,
    /// Each with the time of the frame that saw it first, in the form of a demo's file.
    edits: Vec<(f64, Arc<str>)>,
    /// Edits that no frame has seen yet.
    unseen: Vec<Arc<str>>,
    time_of_day: f64,
    last: Option<FrameTime>,
    ended: Option<Ended>,
}

/// A value over time: keys where it changes.
#[derive(Clone, Debug)]
struct Recorded<T> {
    keys: Vec<(f64, T)>,
    /// The time of the last look.
    seen: f64,
    /// It jumps. Any other value goes in straight lines, and needs a key where it begins to move.
    steps: bool,
}

/// Samples of a sound. Those of whole seconds are shared by copies.
#[derive(Clone, Debug, Default)]
struct Samples {
    seconds: Vec<Arc<[i16]>>,
    rest: Vec<i16>,
}

impl Samples {
    const SECOND: usize = SAMPLE_RATE as usize;

    fn len(&self) -> usize {
        self.seconds.len() * Self::SECOND + self.rest.len()
    }

    fn extend(&mut self, samples: impl Iterator<Item = i16>) {
        for sample in samples {
            self.rest.push(sample);
            if self.rest.len() == Self::SECOND {
                self.seconds.push(self.rest.as_slice().into());
                self.rest.clear();
            }
        }
    }

    fn all(&self) -> Vec<i16> {
        self.seconds.iter().flat_map(|second| second.iter()).chain(&self.rest).copied().collect()
    }
}

impl<T: Clone + PartialEq> Recorded<T> {
    fn new(steps: bool) -> Self {
        Self { keys: Vec::new(), seen: 0.0, steps }
    }

    fn note(&mut self, time: f64, value: &T) {
        match self.keys.last_mut() {
            Some((_, known)) if known == value => {}
            // A frame of the same moment, as while the clock is paused.
            Some((at, known)) if *at >= time => known.clone_from(value),
            Some((at, known)) => {
                if !self.steps && *at < self.seen && self.seen < time {
                    let held = (self.seen, known.clone());
                    self.keys.push(held);
                }
                self.keys.push((time, value.clone()));
            }
            None => self.keys.push((time, value.clone())),
        }
        self.seen = time;
    }

    /// The keys, unless it has this value all the time.
    fn keys_unless(&self, value: &T) -> Option<&[(f64, T)]> {
        match &self.keys[..] {
            [] => None,
            [(_, only)] if only == value => None,
            keys => Some(keys),
        }
    }
}

impl Recorder {
    /// A take without a frame.
    pub fn new(scene: Scene) -> Self {
        Self {
            scene,
            camera: Recorded::new(false),
            params: BTreeMap::new(),
            cursor: Recorded::new(false),
            buttons: Recorded::new(true),
            wheel: Recorded::new(false),
            keys: Recorded::new(true),
            gamepad_sticks: Recorded::new(false),
            gamepad_triggers: Recorded::new(false),
            gamepad_buttons: Recorded::new(true),
            targets: Recorded::new(true),
            sound: Samples::default(),
            sound_changes: None,
            edits: Vec::new(),
            unseen: Vec::new(),
            time_of_day: 0.0,
            last: None,
            ended: None,
        }
    }

    /// Seconds so far.
    pub fn seconds(&self) -> f64 {
        self.last.map_or(0.0, |last| self.end_of(&last))
    }

    /// Why nothing more is noted.
    pub fn ended(&self) -> Option<Ended> {
        self.ended
    }

    /// Notes a frame, unless the take has ended.
    pub fn note(&mut self, told: &Told<'_>) {
        self.ended = self.ended.or_else(|| self.ends_before(told));
        if self.ended.is_some() {
            return;
        }
        let time = told.time.time.seconds();
        if self.last.is_none() {
            self.time_of_day = told.inputs.time_of_day;
        }
        self.camera.note(time, told.camera);
        for (param, value) in told.graph.params.iter().zip(told.values) {
            let steps = params::is_integer(value) || matches!(value, Value::Bool(_));
            if !self.params.contains_key(&param.name) {
                self.params.insert(param.name.clone(), Recorded::new(steps));
            }
            if let Some(track) = self.params.get_mut(&param.name) {
                track.note(time, value);
            }
        }
        self.cursor.note(time, &told.inputs.cursor);
        self.buttons.note(time, &told.inputs.buttons);
        self.wheel.note(time, &told.inputs.wheel);
        self.keys.note(time, &told.inputs.keys);
        self.gamepad_sticks.note(time, &told.inputs.gamepad.sticks);
        self.gamepad_triggers.note(time, &told.inputs.gamepad.triggers);
        self.gamepad_buttons.note(time, &told.inputs.gamepad.buttons);
        self.targets.note(time, told.target);
        if let Some(heard) = &told.heard {
            self.hear(heard);
        }
        self.edits.extend(self.unseen.drain(..).map(|edit| (time, edit)));
        self.last = Some(*told.time);
    }

    /// Notes the new samples of a frame.
    fn hear(&mut self, heard: &Heard<'_>) {
        self.sound_changes = Some(heard.changes);
        let over = usize::try_from(heard.over).unwrap_or(MOST_SAMPLES).min(MOST_SAMPLES);
        let from = self.sound.len().max(over.saturating_sub(HISTORY)).min(over);
        let silence = from.saturating_sub(self.sound.len());
        self.sound.extend(std::iter::repeat_n(0, silence));
        self.sound.extend((from..over).map(|at| heard.sample(at as u64)));
    }

    /// Notes edits of the world that the next frame shows.
    pub fn edited(&mut self, operations: &[Operation], scene: &EditScene) {
        if self.ended.is_some() {
            return;
        }
        for operation in operations {
            match written(operation, scene) {
                Some(edit) => self.unseen.push(edit.into()),
                None => self.ended = Some(Ended::Unsaid),
            }
        }
        if self.edits.len() + self.unseen.len() > MOST_EDITS {
            self.ended = Some(Ended::ManyEdits);
        }
    }

    /// Why a frame is not part of it.
    fn ends_before(&self, told: &Told<'_>) -> Option<Ended> {
        if self.last.is_some_and(|last| last.time > told.time.time || last.index > told.time.index) {
            Some(Ended::TimeWentBack)
        } else if told.graph_path != self.scene.graph {
            Some(Ended::OtherGraph)
        } else if told.size != self.scene.size {
            Some(Ended::OtherSize)
        } else if told.heard.zip(self.sound_changes).is_some_and(|(heard, before)| heard.changes != before) {
            Some(Ended::OtherSound)
        } else {
            (told.time.time.seconds() >= MOST_SECONDS).then_some(Ended::Full)
        }
    }

    /// The take as a demo of the graph that has run. Its sound has the name `NAME.wav` and lies beside it.
    pub fn finish(&self, graph: &Graph, name: &str) -> Result<Take, TakeError> {
        if self.last.is_none() {
            return Err(TakeError::Empty);
        }
        let sound = Some(self.sound.all()).filter(|samples| samples.iter().any(|sample| *sample != 0));
        let sound_name = sound.as_ref().map(|_| format!("{name}.wav"));
        let text = self.text(graph, sound_name.as_deref());
        Ok(Take { text, sound, seconds: self.seconds(), ended: self.ended })
    }

    /// The end of a frame in seconds.
    fn end_of(&self, frame: &FrameTime) -> f64 {
        match self.scene.pace {
            Pace::Fixed(step) => frame.time.after(1, step).seconds(),
            Pace::Live => frame.time.seconds() + 1.0 / LIVE_RATE,
        }
    }

    fn text(&self, graph: &Graph, sound: Option<&str>) -> String {
        let Scene { world, graph: path, size: [width, height], pace } = &self.scene;
        let rate = match pace {
            Pace::Fixed(step) => {
                let (numerator, denominator) = step.parts();
                (denominator as f64 / numerator as f64).clamp(0.001, 1000.0)
            }
            Pace::Live => LIVE_RATE,
        };
        let mut text = format!(
            "#:schema ../.raxel/demo.schema.json\n# A take: what the frames of a session were told, from key to key.\n\
             world    = {}\ngraph    = {}\nduration = {:?}\nfps      = {rate:?}\nsize     = [{width}, {height}]\n\ncamera = [\n",
            quoted(&relative(world, "worlds/")),
            quoted(&relative(path, "graphs/")),
            self.seconds(),
        );
        for (time, camera) in &self.camera.keys {
            let [x, y, z] = camera.position().to_array();
            // A demo has angles within ten turns.
            let yaw = if camera.yaw.abs() > 60.0 { camera.yaw % std::f64::consts::TAU } else { camera.yaw };
            let [yaw, pitch, fov] = [yaw, camera.pitch, camera.fov].map(degrees);
            line(
                &mut text,
                &format!(
                    "    {{ time = {time:?}, position = [{x:?}, {y:?}, {z:?}], yaw = {yaw:?}, pitch = {pitch:?}, fov = {fov:?}, interpolation = \"linear\" }},"
                ),
            );
        }
        line(&mut text, "]");
        let own = DebugTarget::default();
        for (time, target) in self.targets.keys_unless(&own).unwrap_or_default() {
            let shown = if target.resource.is_empty() {
                graph.resource(graph.present).name.clone()
            } else {
                target.to_string()
            };
            line(&mut text, &format!("\n[[show]]\ntime = {time:?}\ntarget = {}", quoted(&shown)));
        }
        self.write_inputs(&mut text, sound);
        for (time, edit) in &self.edits {
            line(&mut text, &format!("\n[[edits]]\ntime = {time:?}\n{edit}"));
        }
        for param in &graph.params {
            let Some(track) = self.params.get(&param.name) else { continue };
            let Some(keys) = track.keys_unless(&param.default) else { continue };
            line(&mut text, &format!("\n[tracks.{}]", quoted(&param.name)));
            // A boolean steps by itself.
            if track.steps && !matches!(param.default, Value::Bool(_)) {
                line(&mut text, "interpolation = \"step\"");
            }
            write_keys(&mut text, "keys", keys, param_value);
        }
        text
    }

    fn write_inputs(&self, text: &mut String, sound: Option<&str>) {
        line(text, &format!("\n[inputs]\ntime_of_day = {:?}", self.time_of_day));
        if let Some(sound) = sound {
            line(text, &format!("microphone = {}", quoted(sound)));
        }
        if let Some(keys) = self.cursor.keys_unless(&None) {
            write_keys(text, "cursor", keys, |pixel| {
                pixel.map_or_else(|| "[]".to_owned(), |[x, y]| format!("[{x}, {y}]"))
            });
        }
        if let Some(keys) = self.buttons.keys_unless(&0) {
            write_keys(text, "buttons", keys, |buttons| names(button_names(*buttons)));
        }
        if let Some(keys) = self.wheel.keys_unless(&[0.0; 2]) {
            write_keys(text, "wheel", keys, |[x, y]| format!("[{x:?}, {y:?}]"));
        }
        if let Some(keys) = self.keys.keys_unless(&KeySet::NONE) {
            write_keys(text, "keys", keys, |keys| names(keys.names()));
        }
        if let Some(keys) = self.gamepad_sticks.keys_unless(&[0.0; 4]) {
            write_keys(text, "gamepad_sticks", keys, |sticks| format!("{sticks:?}"));
        }
        if let Some(keys) = self.gamepad_triggers.keys_unless(&[0.0; 2]) {
            write_keys(text, "gamepad_triggers", keys, |triggers| format!("{triggers:?}"));
        }
        if let Some(keys) = self.gamepad_buttons.keys_unless(&0) {
            write_keys(text, "gamepad_buttons", keys, |buttons| names(gamepad_button_names(*buttons)));
        }
    }
}

fn line(text: &mut String, line: &str) {
    text.push_str(line);
    text.push('\n');
}

fn write_keys<T>(text: &mut String, name: &str, keys: &[(f64, T)], value: impl Fn(&T) -> String) {
    line(text, &format!("{name} = ["));
    for (time, of) in keys {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "    [{time:?}, {}],", value(of));
    }
    line(text, "]");
}

fn names<'a>(names: impl Iterator<Item = &'a str>) -> String {
    format!("[{}]", names.map(quoted).collect::<Vec<_>>().join(", "))
}

/// A value of a param, as the key of a track has it.
fn param_value(value: &Value) -> String {
    if let Value::Bool(value) = value {
        return value.to_string();
    }
    let numbers: Vec<String> = params::components(value).iter().map(|number| format!("{number:?}")).collect();
    match &numbers[..] {
        [number] => number.clone(),
        numbers => format!("[{}]", numbers.join(", ")),
    }
}

/// Text as TOML has it. The escapes of JSON are escapes of TOML, too.
pub(crate) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// A project path as a demo names it, from the folder of its kind.
fn relative(path: &str, folder: &str) -> String {
    path.strip_prefix(folder).map_or_else(|| format!("../{path}"), str::to_owned)
}

/// Degrees that become exactly this angle again, where there are any.
fn degrees(radians: f64) -> f64 {
    let degrees = radians.to_degrees();
    let near = [degrees, degrees.next_up(), degrees.next_down()];
    near.into_iter().find(|near| near.to_radians().to_bits() == radians.to_bits()).unwrap_or(degrees)
}

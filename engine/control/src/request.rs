//! The requests that a program may send, and how they are read.

use raxel_runtime::present::Viewport;
use raxel_workbench::writes::WriteTo;
use raxel_worldfile::CAMERA_FOV;
use serde::Deserialize;
use serde_json::Value;

use super::compare::ToKeep;
use super::host::{BrushEffect, BrushShape, CompareMode, FLY_SPEEDS, LARGEST_BRUSH};
use super::refusal::Refusal;

/// The version of the protocol. A higher one has more requests; none changes its meaning.
pub(super) const PROTOCOL: u32 = 1;

/// A request: `{"id": 1, "do": "set", "param": "exposure", "value": 2.0}`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Request {
    /// The open project: files, size, params, resources, passes, cameras.
    Info {},
    /// Sets a param.
    Set { param: String, value: Value },
    /// Brings a param back to the graph's default.
    Unset { param: String },
    /// Chooses the debug target; an empty one is the graph's own.
    Target { target: String },
    /// Moves the camera, or only answers with its pose. Degrees and voxels.
    Camera(CameraMove),
    /// Sets the inputs that are held and turned from the next frame on, or only answers with them. Buttons and keys by their names.
    Input(HeldInputs),
    /// Starts over and records a take.
    Record {},
    /// Ends the take and writes it as a demo.
    Stop { name: Option<String> },
    /// Stops or starts the clock.
    Pause {
        #[serde(default = "yes")]
        paused: bool,
    },
    /// Runs frames; in a window that is paused, lets them pass.
    Step {
        #[serde(default = "one")]
        frames: u32,
    },
    /// Puts the next frame at `seconds` seconds.
    Seek { seconds: f64 },
    /// Starts over.
    Reset {},
    /// Changes the extent of the output, in pixels.
    Resize { size: [u32; 2] },
    /// Writes the picture of the last frame to a file in the format of its extension.
    Screenshot { path: String },
    /// The picture of the last frame.
    Picture { path: Option<String> },
    /// Runs a frame and captures it by RenderDoc.
    Capture {},
    /// Texels of a target as numbers.
    Texels {
        target: String,
        #[serde(default)]
        age: u32,
        #[serde(default)]
        mip: u32,
        #[serde(default)]
        layer: u32,
        after: Option<String>,
        path: Option<String>,
    },
    /// One texel of a target.
    Pixel {
        target: String,
        x: u32,
        y: u32,
        #[serde(default)]
        age: u32,
        #[serde(default)]
        mip: u32,
        #[serde(default)]
        layer: u32,
        after: Option<String>,
    },
    /// Statistics of each channel of a target.
    Statistics {
        target: String,
        #[serde(default)]
        age: u32,
        #[serde(default)]
        mip: u32,
        #[serde(default)]
        layer: u32,
        after: Option<String>,
    },
    /// The next texel of a target that has a value.
    Find(Find),
    /// Bytes of a buffer.
    Buffer {
        buffer: String,
        #[serde(default)]
        start: u64,
        bytes: u64,
        path: Option<String>,
    },
    /// Edits the world: operations as `[[edits]]` of a demo has them, without times, as one step.
    Edit { operations: Vec<Value> },
    /// Takes the newest step of edits back.
    Undo {},
    /// Makes the step again that was taken back last.
    Redo {},
    /// GPU times of the passes of the last frame.
    Timings {},
    /// Diagnostics since the last edit.
    Diagnostics {},
    /// Compiles all shaders again with checks of the bounds of their accesses, or without them.
    CheckBounds {
        #[serde(default = "yes")]
        on: bool,
    },
    /// Compiles all shaders again with records of their writes of a texel, or without them.
    RecordWrites {
        #[serde(default = "yes")]
        on: bool,
    },
    /// The invocations that write a texel of a target.
    Writers {
        target: String,
        x: u32,
        y: u32,
        #[serde(default)]
        mip: u32,
        #[serde(default)]
        layer: u32,
    },
    /// Waits until an edit is swapped in or found to be wrong.
    WaitReload {
        #[serde(default = "ten")]
        seconds: f64,
        /// An edit after the one of this number; the next one by default.
        after: Option<u64>,
    },
    /// The graphs, worlds and demos of the project.
    Files {},
    /// Opens one of them in place of what runs, and waits until it runs or is found to be wrong.
    Open {
        path: String,
        #[serde(default = "sixty")]
        seconds: f64,
    },
    /// The presets of the graph.
    Presets {},
    /// Keeps the values of all params under a name.
    SavePreset { name: String },
    /// Sets the params to the values of this name.
    ApplyPreset { name: String },
    /// Forgets the values of this name.
    DeletePreset { name: String },
    /// Writes the values of params into a file.
    WriteParams {
        params: Vec<String>,
        #[serde(default)]
        to: To,
    },
    /// Restores the files that were written last.
    UndoWrite {},
    /// Writes the camera into the world's file under a name.
    WriteCamera { name: String },
    /// The demo and its keys.
    Keys {},
    /// Writes another time of a key into the demo's file.
    MoveKey { track: String, key: usize, to: f64 },
    /// Takes a key out of the demo's file.
    DeleteKey { track: String, key: usize },
    /// Writes the camera into the demo's file as a key, or the value of a param.
    WriteKey { param: Option<String>, seconds: Option<f64> },
    /// Starts the demo over at its end, or stays there.
    Loop {
        #[serde(default = "yes")]
        on: bool,
    },
    /// Lets the demo drive again.
    HandBack {},
    /// Begins to record params that `set` moves, or writes what was recorded as keys of the demo.
    RecordParams {
        #[serde(default = "yes")]
        on: bool,
    },
    /// Bounds the frames a second of a window, or only answers with the bound; 0 is none.
    FpsCap { fps: Option<u32> },
    /// Sets the voxels a second that the keys of a window fly, or only answers with them.
    FlySpeed { voxels: Option<f64> },
    /// Changes the brush of a window, or only answers with it.
    Brush(BrushChange),
    /// Maps texels to colours in another way than the graph; without fields, as the graph does.
    Display(Shown),
    /// Keeps a picture to compare with: the shown one by default.
    Keep(ToKeep),
    /// Lets go of the kept picture.
    Forget {},
    /// Measures how far the shown target is from the kept picture.
    Measure {},
    /// Shows the kept picture in a window.
    Compare { mode: Option<CompareMode>, gain: Option<f32>, flipped: Option<bool> },
    /// Gives up the pass that the device has worked on for long.
    Cancel {},
    /// Pixels of the output for each pixel of the size, along each axis.
    Scale { scale: f64 },
    /// Ends the program.
    Quit {},
}

/// The file that values of params are written into.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum To {
    /// The graph's own file: it overrides inherited values.
    #[default]
    Own,
    /// The file that the default stands in, which other graphs may extend as well.
    Declared,
}

impl From<To> for WriteTo {
    fn from(to: To) -> Self {
        match to {
            To::Own => WriteTo::Own,
            To::Declared => WriteTo::Declared,
        }
    }
}

/// How the shown target is shown. Absent fields are those of the graph.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Shown {
    pub map: Option<String>,
    pub channel: Option<u32>,
    pub range: Option<[f32; 2]>,
}

/// Changes of a brush. Absent fields stay as they are. An empty material is the one under the cursor.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BrushChange {
    pub effect: Option<BrushEffect>,
    pub shape: Option<BrushShape>,
    pub size: Option<u32>,
    pub height: Option<u32>,
    pub material: Option<String>,
}

/// Where the camera shall be. Absent fields stay as they are; without any, nothing moves.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraMove {
    pub name: Option<String>,
    pub position: Option<[f64; 3]>,
    pub look_at: Option<[f64; 3]>,
    pub yaw: Option<f64>,
    pub pitch: Option<f64>,
    pub fov: Option<f64>,
}

/// The value to look for. Without mip and layer, all of them are searched.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Find {
    pub target: String,
    pub value: String,
    #[serde(default)]
    pub channel: u32,
    #[serde(default)]
    pub age: u32,
    pub mip: Option<u32>,
    pub layer: Option<u32>,
    pub after: Option<String>,
    pub from: Option<Found>,
    #[serde(default = "yes")]
    pub forward: bool,
}

/// A texel that was found.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Found {
    #[serde(default)]
    pub mip: u32,
    #[serde(default)]
    pub layer: u32,
    pub x: u32,
    pub y: u32,
}

/// Inputs to hold. Absent fields stay as they are.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HeldInputs {
    pub cursor: Option<Vec<i32>>,
    pub buttons: Option<Vec<String>>,
    pub wheel: Option<[f64; 2]>,
    pub keys: Option<Vec<String>>,
    pub gamepad_sticks: Option<[f64; 4]>,
    pub gamepad_triggers: Option<[f64; 2]>,
    pub gamepad_buttons: Option<Vec<String>>,
    pub microphone: Option<String>,
    pub time_of_day: Option<f64>,
}

fn yes() -> bool {
    true
}

fn one() -> u32 {
    1
}

fn sixty() -> f64 {
    60.0
}

fn ten() -> f64 {
    10.0
}

/// Most frames of one step: a program that wants more asks again, and can be stopped in between.
const MOST_FRAMES: u32 = 100_000;

/// Reads a line: its `id`, which the answer repeats, and the request, or why it is none.
pub(super) fn parse(line: &str) -> (Value, Result<Request, Refusal>) {
    let mut value: Value = match serde_json::from_str(line) {
        Ok(value) => value,
        Err(error) => return (Value::Null, Err(Refusal::new(format!("the line is not JSON: {error}")))),
    };
    let Some(object) = value.as_object_mut() else {
        return (Value::Null, Err(Refusal::new("a request is an object, {\"do\": …}")));
    };
    let id = object.remove("id").unwrap_or(Value::Null);
    let request = serde_json::from_value(value.clone()).map_err(|error| Refusal::new(told(&value, &error)));
    (id, request.and_then(within))
}

/// Why an object is no request, with the field that has a wrong value: the one without which the mistake is another or none.
fn told(value: &Value, error: &serde_json::Error) -> String {
    let text = error.to_string();
    let unknown = text.strip_prefix("unknown variant");
    if unknown.is_none() && !text.starts_with("invalid") {
        return text;
    }
    let is_wrong = |field: &&String| {
        let mut rest = value.clone();
        rest.as_object_mut().and_then(|object| object.remove(*field));
        serde_json::from_value::<Request>(rest).err().is_none_or(|error| error.to_string() != text)
    };
    let mut fields = value.as_object().into_iter().flat_map(serde_json::Map::keys).filter(|field| *field != "do");
    let field = fields.find(is_wrong).map_or("do", String::as_str);
    if let (Some(unknown), "do") = (unknown, field) {
        return format!("unknown request{unknown}");
    }
    let mut text = text;
    // The names that serde uses.
    for (theirs, ours) in [
        ("variant identifier", "the name of a request"),
        ("expected f64", "expected a number"),
        ("expected u32", "expected a whole number from 0"),
        ("expected u64", "expected a whole number from 0"),
        ("expected usize", "expected a whole number from 0"),
        ("expected f32", "expected a number"),
    ] {
        text = text.replace(theirs, ours);
    }
    format!("`{field}`: {text}")
}

/// Numbers that nothing can be done with are refused here, once.
fn within(request: Request) -> Result<Request, Refusal> {
    let message = match &request {
        Request::Step { frames } if !(1..=MOST_FRAMES).contains(frames) => Some("`frames` must be in 1…100000"),
        Request::Resize { size } if size.iter().any(|side| !(1..=16384).contains(side)) => {
            Some("both sides of `size` must be in 1…16384")
        }
        Request::Seek { seconds } | Request::WaitReload { seconds, .. } | Request::Open { seconds, .. }
            if !(0.0..=86_400.0).contains(seconds) =>
        {
            Some("`seconds` must be in 0…86400")
        }
        Request::Display(shown) => shown.mistake(),
        Request::Scale { scale } if !Viewport::SCALES.contains(scale) => Some("`scale` must be in 0.0625…4"),
        Request::Compare { gain: Some(gain), .. } if !(0.01..=1e5).contains(gain) => {
            Some("`gain` must be in 0.01…100000")
        }
        Request::Input(held) => held.mistake(),
        Request::FpsCap { fps: Some(fps) } if *fps > 1000 => Some("`fps` must be in 0…1000"),
        Request::FlySpeed { voxels: Some(voxels) } if !FLY_SPEEDS.contains(voxels) => {
            Some("`voxels` must be in 0.1…100000")
        }
        Request::Brush(change) => change.mistake(),
        Request::Camera(moved) => moved.mistake(),
        _ => None,
    };
    message.map_or(Ok(request), |message| Err(Refusal::new(message)))
}

impl Request {
    /// Whether it gives up a picture that is being kept.
    pub(crate) fn ends_keep(&self) -> bool {
        matches!(self, Request::Keep(_) | Request::Forget {} | Request::Quit {})
    }

    /// Whether an edit follows it, which `wait_reload` waits for.
    pub(crate) fn leads_to_edit(&self) -> bool {
        matches!(
            self,
            Request::WriteParams { .. }
                | Request::UndoWrite {}
                | Request::WriteCamera { .. }
                | Request::MoveKey { .. }
                | Request::DeleteKey { .. }
                | Request::WriteKey { .. }
                | Request::RecordParams { .. }
                | Request::CheckBounds { .. }
                | Request::RecordWrites { .. }
        )
    }
}

impl Shown {
    fn mistake(&self) -> Option<&'static str> {
        if self.channel.is_some_and(|channel| channel > 3) {
            Some("`channel` must be in 0…3")
        } else if self.range.is_some_and(|[low, high]| !low.is_finite() || !high.is_finite() || low >= high) {
            Some("`range` is [low, high], two finite numbers, the lower one first")
        } else {
            None
        }
    }
}

impl BrushChange {
    fn mistake(&self) -> Option<&'static str> {
        let is_outside = |voxels: Option<u32>| voxels.is_some_and(|voxels| !(1..=LARGEST_BRUSH).contains(&voxels));
        if is_outside(self.size) {
            Some("`size` must be in 1…512")
        } else if is_outside(self.height) {
            Some("`height` must be in 1…512")
        } else {
            None
        }
    }
}

impl HeldInputs {
    fn mistake(&self) -> Option<&'static str> {
        let exceeds = |axes: &[f64], most: f64| axes.iter().any(|axis| axis.abs() > most);
        if self.cursor.as_ref().is_some_and(|cursor| ![0, 2].contains(&cursor.len())) {
            Some("`cursor` is [x, y], or [] without a cursor")
        } else if self.time_of_day.is_some_and(|seconds| !(0.0..=86_400.0).contains(&seconds)) {
            Some("`time_of_day` must be in 0…86400")
        } else if self.wheel.is_some_and(|lines| exceeds(&lines, 1e6)) {
            Some("`wheel` must be in -1000000…1000000")
        } else if self.gamepad_sticks.is_some_and(|axes| exceeds(&axes, 1.0)) {
            Some("`gamepad_sticks` must be in -1…1")
        } else if self.gamepad_triggers.is_some_and(|axes| axes.iter().any(|axis| !(0.0..=1.0).contains(axis))) {
            Some("`gamepad_triggers` must be in 0…1")
        } else {
            None
        }
    }
}

impl CameraMove {
    fn mistake(&self) -> Option<&'static str> {
        let is_outside = |place: [f64; 3]| !place.iter().all(|x| x.abs() <= 2_147_483_648.0);
        if self.fov.is_some_and(|fov| !CAMERA_FOV.contains(&fov)) {
            Some("`fov` must be in 1…179")
        } else if self.pitch.is_some_and(|pitch| !(-90.0..=90.0).contains(&pitch)) {
            Some("`pitch` must be in -90…90")
        } else if self.yaw.is_some_and(|yaw| yaw.abs() > 3600.0) {
            Some("`yaw` must be in -3600…3600")
        } else if self.look_at.is_some() && (self.yaw.is_some() || self.pitch.is_some()) {
            Some("`look_at` and `yaw` or `pitch` exclude each other")
        } else if [self.position, self.look_at].into_iter().flatten().any(is_outside) {
            Some("a position is in -2147483648…2147483648")
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_that_are_left_out_have_their_defaults() {
        let read = |line: &str| parse(line).1.unwrap();
        for (line, request) in [
            (r#"{"do": "open", "path": "a"}"#, Request::Open { path: "a".to_owned(), seconds: 60.0 }),
            (r#"{"do": "wait_reload"}"#, Request::WaitReload { seconds: 10.0, after: None }),
            (r#"{"do": "write_params", "params": []}"#, Request::WriteParams { params: Vec::new(), to: To::Own }),
            (r#"{"do": "write_key"}"#, Request::WriteKey { param: None, seconds: None }),
            (r#"{"do": "loop"}"#, Request::Loop { on: true }),
            (r#"{"do": "record_params"}"#, Request::RecordParams { on: true }),
            (r#"{"do": "fps_cap"}"#, Request::FpsCap { fps: None }),
            (r#"{"do": "brush"}"#, Request::Brush(BrushChange::default())),
            (r#"{"do": "display", "map": null}"#, Request::Display(Shown::default())),
            (r#"{"do": "keep"}"#, Request::Keep(ToKeep::default())),
            (r#"{"do": "picture"}"#, Request::Picture { path: None }),
        ] {
            assert_eq!(read(line), request, "{line}");
        }
        assert!(read(r#"{"do": "undo_write"}"#).leads_to_edit() && !read(r#"{"do": "undo"}"#).leads_to_edit());
    }

    #[test]
    fn requests_are_read_and_anything_else_is_refused() {
        let (id, request) = parse(r#"{"id": "a", "do": "step"}"#);
        assert_eq!((id, request.unwrap()), (Value::from("a"), Request::Step { frames: 1 }));
        let (_, request) = parse(r#"{"do": "set", "param": "sun", "value": [1, 2]}"#);
        assert_eq!(request.unwrap(), Request::Set { param: "sun".into(), value: serde_json::json!([1, 2]) });
        for (line, said) in [
            ("no json", "not JSON"),
            ("[1]", "a request is an object"),
            ("{}", "missing field `do`"),
            (r#"{"id": 7, "do": "fly"}"#, "unknown request `fly`"),
            (r#"{"do": "step", "frame": 3}"#, "unknown field `frame`"),
            (r#"{"do": "info", "target": "depth"}"#, "unknown field `target`"),
            (r#"{"do": "step", "frames": 0}"#, "`frames` must be in"),
            (r#"{"do": "pixel", "target": "depth", "x": -1, "y": 0}"#, "`x`: invalid value"),
            (r#"{"do": "pixel", "target": "depth", "x": 0, "y": 0.5}"#, "`y`: invalid type: floating point `0.5`"),
            (r#"{"do": "seek", "seconds": "now"}"#, "`seconds`: invalid type: string \"now\", expected a number"),
            (
                r#"{"do": "step", "frames": -1}"#,
                "`frames`: invalid value: integer `-1`, expected a whole number from 0",
            ),
            (r#"{"do": 5}"#, "`do`: invalid type: integer `5`, expected the name of a request"),
            (r#"{"do": "camera", "look_at": [0, 0, 0], "yaw": 1}"#, "exclude each other"),
            (r#"{"do": "camera", "position": [0, 1e300, 0]}"#, "a position is in"),
            (r#"{"do": "camera", "fov": 179.5}"#, "`fov` must be in 1…179"),
            (r#"{"do": "camera", "yaw": 3601}"#, "`yaw` must be in -3600…3600"),
            (r#"{"do": "input", "cursor": [1]}"#, "`cursor` is [x, y], or []"),
            (r#"{"do": "input", "keys": "KeyW"}"#, "`keys`: invalid type: string"),
            (r#"{"do": "input", "time_of_day": -1}"#, "`time_of_day` must be in 0…86400"),
            (r#"{"do": "input", "wheel": [0, 1e9]}"#, "`wheel` must be in"),
            (r#"{"do": "input", "gamepad_sticks": [0, 0, 0, 2]}"#, "`gamepad_sticks` must be in -1…1"),
            (r#"{"do": "input", "gamepad_triggers": [0, -1]}"#, "`gamepad_triggers` must be in 0…1"),
            (r#"{"do": "open"}"#, "missing field `path`"),
            (r#"{"do": "open", "path": "a", "seconds": -1}"#, "`seconds` must be in 0…86400"),
            (r#"{"do": "presets", "name": "a"}"#, "unknown field `name`"),
            (r#"{"do": "save_preset", "name": 3}"#, "`name`: invalid type"),
            (r#"{"do": "write_params", "params": "fog"}"#, "`params`: invalid type"),
            (r#"{"do": "write_params", "params": [], "to": "base"}"#, "`to`: unknown variant `base`"),
            (
                r#"{"do": "move_key", "track": "camera", "key": -1, "to": 1}"#,
                "`key`: invalid value: integer `-1`, expected a whole number from 0",
            ),
            (r#"{"do": "move_key", "track": "camera", "key": 1}"#, "missing field `to`"),
            (r#"{"do": "write_key", "time": 1}"#, "unknown field `time`"),
            (r#"{"do": "display", "channel": 4}"#, "`channel` must be in 0…3"),
            (r#"{"do": "display", "range": [2, 1]}"#, "`range` is [low, high]"),
            (r#"{"do": "display", "range": [0, 1e300]}"#, "`range` is [low, high]"),
            (r#"{"do": "keep", "file": "a.png"}"#, "unknown field `file`"),
            (r#"{"do": "compare", "mode": "blink"}"#, "`mode`: unknown variant `blink`"),
            (r#"{"do": "compare", "gain": "much"}"#, "`gain`: invalid type: string \"much\", expected a number"),
            (r#"{"do": "compare", "gain": 0}"#, "`gain` must be in 0.01…100000"),
            (r#"{"do": "scale", "scale": 5}"#, "`scale` must be in 0.0625…4"),
            (r#"{"do": "fps_cap", "fps": 1001}"#, "`fps` must be in 0…1000"),
            (r#"{"do": "fly_speed", "voxels": 0}"#, "`voxels` must be in 0.1…100000"),
            (r#"{"do": "brush", "size": 0}"#, "`size` must be in 1…512"),
            (r#"{"do": "brush", "height": 513}"#, "`height` must be in 1…512"),
            (r#"{"do": "brush", "shape": "ball"}"#, "`shape`: unknown variant `ball`"),
            (r#"{"do": "texels", "target": "depth", "path": 3}"#, "`path`: invalid type"),
            (r#"{"do": "wait_reload", "after": -1}"#, "`after`: invalid value"),
        ] {
            let refusal = parse(line).1.unwrap_err();
            assert!(refusal.error.contains(said), "{line}: {}", refusal.error);
        }
        assert_eq!(parse(r#"{"id": 7, "do": "fly"}"#).0, Value::from(7));
        // As wide as the files of worlds and demos let a camera be.
        assert!(parse(r#"{"do": "camera", "fov": 179}"#).1.is_ok());
    }
}

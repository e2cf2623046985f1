//! What is done for a request.

use std::path::Path;

use data_encoding::BASE64;
use raxel_diagnostics::Diagnostic;
use raxel_diagnostics::names::{closest, list};
use raxel_execute::{Captured, PassOutcome, Texels};
use raxel_graph::checked::{Param, Pass, PassId, ResourceKind, Value as ParamValue};
use raxel_graph::index32;
use raxel_graph::plan::Present;
use raxel_output::{Coding, Compression, Output, OutputError, Pending, PictureFormat, Shot};
use raxel_runtime::camera::Camera;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::inputs::{
    BUTTONS, GAMEPAD_BUTTONS, Key, KeySet, button_named, button_names, gamepad_button_named, gamepad_button_names,
};
use raxel_runtime::params::{components, type_name};
use raxel_runtime::{ReadError, Session};
use raxel_shader::interface::ScalarKind;
use raxel_terminal::console;
use raxel_terminal::failure::Failure;
use serde_json::{Map, Value, json};

use super::Drive;
use super::request::Request;

/// Why a request was not done. Nothing has changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Refusal {
    pub error: String,
    help: Vec<String>,
}

impl Refusal {
    pub fn new(error: impl Into<String>) -> Self {
        Self { error: error.into(), help: Vec::new() }
    }

    /// The session waits for the mend of its files.
    pub fn nothing_runs() -> Self {
        let help = "`diagnostics` lists them, and `wait_reload` waits until they are mended".to_owned();
        Self { error: "nothing runs, as the files have mistakes".to_owned(), help: vec![help] }
    }
}

impl From<Failure> for Refusal {
    fn from(failure: Failure) -> Self {
        Self { error: failure.message.unwrap_or_default(), help: failure.help }
    }
}

impl From<OutputError> for Refusal {
    fn from(error: OutputError) -> Self {
        Self { error: error.message, help: error.help }
    }
}

macro_rules! refused_by {
    ($($error:ty),*) => {
        $(impl From<$error> for Refusal {
            fn from(error: $error) -> Self {
                Self::new(error.to_string())
            }
        })*
    };
}

refused_by!(
    ReadError,
    raxel_runtime::FrameError,
    raxel_runtime::session::CaptureError,
    raxel_runtime::params::SetError,
    raxel_runtime::take::TakeError,
    raxel_runtime::debug_target::DebugTargetError
);

/// Writes an answer.
pub(super) fn give(id: &Value, answer: Result<Value, Refusal>) {
    let mut object = Map::new();
    object.insert("id".to_owned(), id.clone());
    object.insert("ok".to_owned(), answer.is_ok().into());
    match answer {
        Ok(Value::Object(fields)) => object.extend(fields),
        Ok(other) => drop(object.insert("value".to_owned(), other)),
        Err(Refusal { error, help }) => {
            object.insert("error".to_owned(), error.into());
            object.insert("help".to_owned(), help.into());
        }
    }
    console::json(&Value::Object(object));
}

/// What was shown right after a pass of the last frame.
pub(super) struct Middle {
    of: Present,
    texels: Texels,
}

/// Does what is asked, or nothing.
pub(super) fn answer(
    request: Request,
    session: &mut Session,
    drive: Drive,
    middle: &mut Option<Middle>,
) -> Result<Value, Refusal> {
    match request {
        Request::Info {} => Ok(info(session)),
        Request::Set { param, value } => {
            session.set_param_text(&param, &text(&value)?)?;
            // A demo that drives the param would win.
            session.take_over();
            Ok(json!({ "param": param, "value": shown(&session.param(&param)?) }))
        }
        Request::Unset { param } => {
            session.unset_param(&param)?;
            Ok(json!({ "param": param, "value": shown(&session.param(&param)?) }))
        }
        Request::Target { target } => {
            session.set_debug_target_text(&target)?;
            Ok(json!({ "target": target }))
        }
        Request::Camera { name, position, look_at, yaw, pitch, fov } => {
            let moved = name.is_some() || [&position, &look_at].iter().any(|place| place.is_some());
            if moved || yaw.is_some() || pitch.is_some() || fov.is_some() {
                session.take_over();
                let camera = placed(session, name.as_deref(), position, look_at, [yaw, pitch, fov])?;
                session.set_camera(camera);
            }
            Ok(camera(session.camera()))
        }
        Request::Input {
            cursor,
            buttons,
            wheel,
            keys,
            gamepad_sticks,
            gamepad_triggers,
            gamepad_buttons,
            microphone,
            time_of_day,
        } => {
            let buttons = buttons.map(|names| bits(&names, "mouse button", &BUTTONS, button_named)).transpose()?;
            let of_gamepad =
                |names: Vec<String>| bits(&names, "button of a gamepad", &GAMEPAD_BUTTONS, gamepad_button_named);
            let gamepad_buttons = gamepad_buttons.map(of_gamepad).transpose()?;
            let keys = keys.map(|names| held(&names)).transpose()?;
            let by_hand = cursor.is_some() || buttons.is_some() || wheel.is_some() || keys.is_some();
            let by_gamepad = gamepad_sticks.is_some() || gamepad_triggers.is_some() || gamepad_buttons.is_some();
            if by_hand || by_gamepad || microphone.is_some() || time_of_day.is_some() {
                if drive == Drive::Window {
                    return Err(Refusal::new("the window has its own mouse and keyboard"));
                }
                // The file may be none that can be read, and then nothing has changed.
                if let Some(path) = microphone {
                    session.give_sound((!path.is_empty()).then_some(&path)).map_err(Refusal::new)?;
                }
                // A demo that drives them would win.
                session.take_over();
                let inputs = session.inputs();
                if let Some(cursor) = cursor {
                    inputs.cursor = cursor.first().zip(cursor.get(1)).map(|(x, y)| [*x, *y]);
                }
                buttons.into_iter().for_each(|buttons| inputs.hold_buttons(buttons));
                wheel.into_iter().for_each(|lines| inputs.set_wheel(lines));
                keys.into_iter().for_each(|keys| inputs.hold_keys(keys));
                gamepad_sticks.into_iter().for_each(|sticks| inputs.set_gamepad_sticks(sticks));
                gamepad_triggers.into_iter().for_each(|triggers| inputs.set_gamepad_triggers(triggers));
                gamepad_buttons.into_iter().for_each(|buttons| inputs.hold_gamepad_buttons(buttons));
                time_of_day.into_iter().for_each(|seconds| inputs.set_time_of_day(seconds));
            }
            let microphone = session.microphone().given().map_or(String::new(), |file| file.path.clone());
            let inputs = session.inputs();
            Ok(json!({
                "cursor": inputs.cursor.map_or(Vec::new(), Vec::from),
                "buttons": button_names(inputs.buttons()).collect::<Vec<_>>(),
                "wheel": inputs.wheel(),
                "keys": inputs.keys().names().collect::<Vec<_>>(),
                "gamepad_sticks": inputs.gamepad().sticks,
                "gamepad_triggers": inputs.gamepad().triggers,
                "gamepad_buttons": gamepad_button_names(inputs.gamepad().buttons).collect::<Vec<_>>(),
                "microphone": microphone,
                "time_of_day": inputs.time_of_day(),
            }))
        }
        Request::Record {} => {
            session.record()?;
            Ok(json!({}))
        }
        Request::Stop { name } => {
            let name = raxel_output::take_name(session.project(), name.as_deref())?;
            let take = session.take(&name)?;
            let path = raxel_output::write_take(session.project(), &name, &take)?;
            session.stop_recording();
            let ended = take.ended.map(|ended| ended.to_string());
            Ok(json!({ "path": path, "seconds": take.seconds, "ended": ended }))
        }
        Request::Pause { paused } => {
            session.pause(paused);
            Ok(json!({ "paused": paused }))
        }
        Request::Step { frames } => {
            if drive == Drive::Window && !session.clock().paused() {
                return Err(Refusal::new("the window runs by itself; pause it first"));
            }
            for index in 0..frames {
                match drive {
                    Drive::Requests => {
                        // What is shown right after a pass is copied there.
                        if index + 1 == frames && session.debug_target().after.is_some() {
                            session.capture_shown(0..0);
                        }
                        session.frame()?;
                    }
                    Drive::Window => session.step(),
                }
            }
            if drive == Drive::Requests {
                session.wait()?;
                *middle = shown_in_the_middle(session);
            }
            Ok(now(session))
        }
        Request::Seek { seconds } => {
            session.seek(seconds);
            Ok(json!({ "seconds": seconds }))
        }
        Request::Reset {} => {
            session.reset();
            Ok(json!({}))
        }
        Request::Resize { size: [width, height] } => {
            if drive == Drive::Window {
                return Err(Refusal::new("the window has its own size"));
            }
            session.resize(width, height);
            Ok(json!({ "size": [width, height] }))
        }
        Request::Screenshot { path } => screenshot(session, &path),
        Request::Capture {} => {
            let (_, file) = session.capture_frame()?;
            Ok(json!({ "path": file }))
        }
        Request::Picture {} => {
            let picture = session.read_presented()?;
            Ok(json!({
                "width": picture.width, "height": picture.height, "channels": 4, "type": "u1",
                "data": BASE64.encode(&picture.rgba),
            }))
        }
        Request::Texels { target, age, mip, layer, after } => {
            let target = DebugTarget { resource: target, age, mip, layer, after };
            let texels = texels(session, &target, middle.as_ref())?;
            let (kind, bytes) = numbers(&texels);
            Ok(json!({
                "width": texels.width, "height": texels.height, "channels": texels.format.channels(), "type": kind,
                "format": texels.format.name(), "data": BASE64.encode(&bytes),
            }))
        }
        Request::Pixel { target, x, y, age, mip, layer, after } => {
            let target = DebugTarget { resource: target, age, mip, layer, after };
            let texels = texels(session, &target, middle.as_ref())?;
            if x >= texels.width || y >= texels.height {
                let (width, height) = (texels.width, texels.height);
                return Err(Refusal::new(format!("`{target}` has {width}×{height} texels; there is none at {x}, {y}")));
            }
            let (kind, bytes) = numbers(&texels);
            let channels = texels.format.channels() as usize;
            let at = (y as usize * texels.width as usize + x as usize) * channels * 4;
            let words = bytes[at..at + channels * 4].chunks_exact(4).map(|word| [word[0], word[1], word[2], word[3]]);
            let bits: Vec<u32> = words.map(u32::from_le_bytes).collect();
            let values: Vec<Value> = bits.iter().map(|bits| number(kind, *bits)).collect();
            Ok(json!({ "format": texels.format.name(), "values": values, "bits": bits }))
        }
        Request::Buffer { buffer, start, bytes } => {
            let range = start..start.saturating_add(bytes);
            let found = session.read_buffer(&buffer, range)?;
            Ok(json!({ "bytes": found.len(), "data": BASE64.encode(&found) }))
        }
        Request::Timings {} => {
            session.wait()?;
            Ok(json!({ "passes": timings(session) }))
        }
        Request::Edit { operations } => {
            let written: Vec<String> = operations.iter().map(toml).collect::<Result<_, _>>()?;
            let text = format!("edits = [{}]", written.join(", "));
            let operations = raxel_runtime::timeline::operations(&text, session.scene()).map_err(refused)?;
            let chunks = session.edit(&operations).map_err(|failure| refused(failure.into_diagnostics()))?;
            Ok(with_steps(session, json!({ "chunks": chunks })))
        }
        Request::Undo {} => {
            let undone = session.undo().map_err(|failure| refused(failure.into_diagnostics()))?;
            Ok(with_steps(session, json!({ "undone": undone })))
        }
        Request::Redo {} => {
            let redone = session.redo().map_err(|failure| refused(failure.into_diagnostics()))?;
            Ok(with_steps(session, json!({ "redone": redone })))
        }
        Request::CheckBounds { on } => {
            let compiles = session.checks_bounds() != on && session.check_bounds(on);
            Ok(json!({ "on": on, "compiles": compiles }))
        }
        Request::Diagnostics {} | Request::WaitReload { .. } | Request::Quit {} => Ok(json!({})),
    }
}

/// The copy that the last frame took.
fn shown_in_the_middle(session: &mut Session) -> Option<Middle> {
    let copy = session.captured()?.poll().ok().flatten()?;
    let of = session.debug_target().resolve(session.graph()).ok()?;
    match copy {
        Captured::Texels(texels) if of.after.is_some() => Some(Middle { of, texels }),
        _ => None,
    }
}

/// Texels at the end of the last frame, or right after a pass of it.
fn texels(session: &mut Session, target: &DebugTarget, middle: Option<&Middle>) -> Result<Texels, Refusal> {
    if target.after.is_none() {
        return Ok(session.read_texels(&target.resource, target.age, target.mip, target.layer)?);
    }
    let wanted = target.resolve(session.graph())?;
    match middle.filter(|middle| middle.of == wanted) {
        Some(middle) => Ok(middle.texels.clone()),
        None => Err(Refusal {
            error: format!("the last frame has no copy of `{target}`"),
            help: vec![format!(
                "choose it with `target`, \"{target}\", and run a frame with `step`; a window takes no copies"
            )],
        }),
    }
}

/// Every pass of the graph in order, with its time in the last frame if it ran.
fn timings(session: &mut Session) -> Vec<Value> {
    let outcomes = session.outcomes();
    let times: Vec<_> = session.timings().to_vec();
    let Some(plan) = session.plan() else { return Vec::new() };
    let shown = plan.graph.passes.iter().enumerate().filter(|(index, _)| plan.shows(PassId(index32(*index))));
    let of_pass = |(index, pass): (usize, &Pass)| {
        // A pass of a clock runs once for each tick that was due.
        let runs = times
            .iter()
            .zip(&outcomes)
            .filter(|(time, outcome)| time.pass.0 as usize == index && **outcome == PassOutcome::Dispatched);
        let runs: Vec<Option<f64>> = runs.map(|(time, _)| time.nanoseconds).collect();
        let nanoseconds: Option<f64> = runs.iter().copied().sum();
        let milliseconds = nanoseconds.filter(|_| !runs.is_empty()).map(|time| time / 1e6);
        json!({ "pass": pass.name, "milliseconds": milliseconds, "ran": !runs.is_empty() })
    };
    shown.map(of_pass).collect()
}

fn with_steps(session: &Session, mut answer: Value) -> Value {
    let steps = session.edit_steps();
    answer["steps"] = json!({ "undo": steps.undo, "redo": steps.redo });
    answer
}

fn refused(diagnostics: Vec<Diagnostic>) -> Refusal {
    let said: Vec<String> = diagnostics.iter().map(|diagnostic| diagnostic.message.clone()).collect();
    Refusal { error: said.join("; "), help: diagnostics.into_iter().flat_map(|diagnostic| diagnostic.help).collect() }
}

/// JSON as an inline value of TOML.
fn toml(value: &Value) -> Result<String, Refusal> {
    Ok(match value {
        // The escapes of JSON are escapes of TOML, too.
        Value::Bool(_) | Value::Number(_) | Value::String(_) => value.to_string(),
        Value::Array(parts) => format!("[{}]", parts.iter().map(toml).collect::<Result<Vec<_>, _>>()?.join(", ")),
        Value::Object(fields) => {
            let field =
                |(key, value): (&String, &Value)| Ok(format!("{} = {}", Value::from(key.as_str()), toml(value)?));
            format!("{{ {} }}", fields.iter().map(field).collect::<Result<Vec<_>, Refusal>>()?.join(", "))
        }
        Value::Null => return Err(Refusal::new("an operation has no null")),
    })
}

fn info(session: &Session) -> Value {
    let graph = session.graph();
    let params: Vec<Value> = session.params().iter().map(|param| describe(param, session)).collect();
    let named = |target: bool| {
        let wanted = move |kind: &ResourceKind| matches!(kind, ResourceKind::Target(_)) == target;
        let all = graph.resources.iter().filter(|resource| !resource.made);
        all.filter(move |resource| wanted(&resource.kind)).map(|resource| resource.name.as_str()).collect::<Vec<_>>()
    };
    let passes: Vec<&str> = graph.pass_names().collect();
    json!({
        "graph": session.graph_path(),
        "world": session.world().path,
        "demo": session.demo().map(|demo| demo.file.as_str()),
        "device": session.device().capabilities().name,
        "size": session.size(),
        "params": params,
        "targets": named(true),
        "buffers": named(false),
        "passes": passes,
        "cameras": session.world().camera_names().collect::<Vec<_>>(),
    })
}

fn describe(param: &Param, session: &Session) -> Value {
    let value = session.param(&param.name).unwrap_or(param.default);
    json!({
        "name": param.name,
        "type": type_name(&param.default),
        "label": param.label,
        "value": shown(&value),
        "default": shown(&param.default),
        "range": param.range,
        "step": param.step,
        "tooltip": param.tooltip,
        "unit": param.unit,
        "group": param.group,
        "choices": param.choices,
    })
}

/// A value as JSON: a number, `true`, or an array.
fn shown(value: &ParamValue) -> Value {
    if let ParamValue::Bool(value) = value {
        return (*value).into();
    }
    match components(value).as_slice() {
        [one] => json!(one),
        many => json!(many),
    }
}

/// JSON as the text that a param is set by.
fn text(value: &Value) -> Result<String, Refusal> {
    match value {
        Value::Bool(_) | Value::Number(_) => Ok(value.to_string()),
        Value::String(text) => Ok(text.clone()),
        Value::Array(parts) => Ok(parts.iter().map(text).collect::<Result<Vec<_>, _>>()?.join(",")),
        Value::Null | Value::Object(_) => Err(Refusal::new("`value` is a number, true, false, or an array of numbers")),
    }
}

/// The bits of buttons.
fn bits(
    names: &[String],
    what: &str,
    known: &[&'static str],
    named: impl Fn(&str) -> Option<u32>,
) -> Result<u32, Refusal> {
    let bit = |name: &String| {
        named(name).ok_or_else(|| not_held(what, name, known.iter().copied(), list(known.iter().copied())))
    };
    names.iter().try_fold(0, |bits, name| Ok(bits | bit(name)?))
}

/// The keys of these names.
fn held(names: &[String]) -> Result<KeySet, Refusal> {
    let key = |name: &String| {
        Key::named(name)
            .ok_or_else(|| not_held("key", name, Key::names(), "names are those of browsers, e.g. `KeyW`".to_owned()))
    };
    names.iter().map(key).collect()
}

/// A button or a key that there is not.
fn not_held(what: &str, name: &str, known: impl Iterator<Item = &'static str>, otherwise: String) -> Refusal {
    let help = closest(name, known).map_or(otherwise, |like| format!("did you mean `{like}`?"));
    Refusal { error: format!("`{name}` is no {what}"), help: vec![help] }
}

fn placed(
    session: &Session,
    name: Option<&str>,
    position: Option<[f64; 3]>,
    look_at: Option<[f64; 3]>,
    [yaw, pitch, fov]: [Option<f64>; 3],
) -> Result<Camera, Refusal> {
    let mut camera = match name {
        Some(name) => raxel_terminal::session::named_camera(session.world(), name)?,
        None => *session.camera(),
    };
    if let Some(position) = position {
        camera = Camera { yaw: camera.yaw, pitch: camera.pitch, fov: camera.fov, ..Camera::at(position) };
    }
    if let Some(target) = look_at {
        if camera.is_at(target) {
            return Err(Refusal::new("`look_at` is where the camera is: it has no direction"));
        }
        camera.look_at(target);
    }
    camera.yaw = yaw.map_or(camera.yaw, f64::to_radians);
    camera.pitch = pitch.map_or(camera.pitch, f64::to_radians);
    camera.fov = fov.map_or(camera.fov, f64::to_radians);
    Ok(camera)
}

fn camera(camera: &Camera) -> Value {
    json!({
        "position": camera.position().to_array(),
        "cell": camera.cell.to_array(),
        "frac": camera.frac.to_array(),
        "yaw": camera.yaw.to_degrees(),
        "pitch": camera.pitch.to_degrees(),
        "fov": camera.fov.to_degrees(),
    })
}

fn now(session: &Session) -> Value {
    match session.clock().now() {
        Some(now) => json!({ "frame": now.index, "seconds": now.time.seconds() }),
        None => json!({ "frame": null, "seconds": 0.0 }),
    }
}

fn screenshot(session: &mut Session, path: &str) -> Result<Value, Refusal> {
    let Output::Single(kind, file) = Output::parse(path, None)? else {
        return Err(Refusal::new(format!("`{path}` names no single picture")));
    };
    let pending = Pending::new(&file)?;
    let shot = if kind.wants_texels() {
        let graph = session.graph();
        let target = session.debug_target();
        if target.after.is_some() {
            // The frame has run: its middle is gone.
            let message =
                format!("`{target}` is not what the frame ends with, and `{path}` takes texels as they are at the end");
            let help = vec!["a .png has the picture as it was shown; a target without `after` has texels".to_owned()];
            return Err(Refusal { error: message, help });
        }
        let (age, mip, layer) = (target.age, target.mip, target.layer);
        let shown = if target.resource.is_empty() { &graph.resource(graph.present).name } else { &target.resource };
        let name = shown.clone();
        let texels = session.read_texels(&name, age, mip, layer)?;
        Shot::Texels(vec![(name, texels)])
    } else {
        Shot::Picture(session.read_presented()?)
    };
    let size = shot.size();
    let coding = Coding { kind, compression: Compression::default(), quality: 90 };
    pending.finish(&coding.encode(shot)?)?;
    Ok(
        json!({ "path": Path::new(path), "size": size, "kind": match kind { PictureFormat::Jpg => "jpg", other => other.extension() } }),
    )
}

/// The numbers of all texels as little-endian words, and their type: `f4`, `u4` or `i4`.
fn numbers(texels: &Texels) -> (&'static str, Vec<u8>) {
    let channels = texels.format.channels() as usize;
    let words = |words: Vec<[u32; 4]>| {
        words.iter().flat_map(|texel| texel[..channels].iter().flat_map(|word| word.to_le_bytes())).collect()
    };
    match (texels.scalar(), texels.integers()) {
        (ScalarKind::Uint, Some(integers)) => ("u4", words(integers)),
        (ScalarKind::Int, Some(integers)) => ("i4", words(integers)),
        _ => ("f4", words(texels.floats().into_iter().map(|texel| texel.map(f32::to_bits)).collect())),
    }
}

/// A word as a number of JSON, which has neither NaN nor infinity: those are text.
fn number(kind: &str, bits: u32) -> Value {
    match kind {
        "u4" => bits.into(),
        "i4" => bits.cast_signed().into(),
        _ => {
            let value = f32::from_bits(bits);
            if value.is_finite() { json!(value) } else { json!(value.to_string()) }
        }
    }
}

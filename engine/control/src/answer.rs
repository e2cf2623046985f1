//! Carries requests out, and answers them.

use raxel_execute::TracedTexel;
use raxel_runtime::Session;
use raxel_runtime::camera::Camera;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::session::TakeIdentity;
use raxel_workbench::kept::Kept;
use raxel_workbench::{demo, tracks};
use serde_json::{Map, Value, json};

use super::Drive;
use super::brush;
use super::describe;
use super::find::{self, Finding};
use super::host::Host;
use super::inputs;
use super::later::Later;
use super::read::{self, Middle};
use super::refusal::Refusal;
use super::request::{CameraMove, Request};
use super::work;
use super::writers;

/// An answer as the program reads it.
pub(super) fn line(id: &Value, answer: Result<Value, Refusal>) -> Value {
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
    object.into()
}

/// Work whose answer comes later.
pub(super) enum Work {
    /// Another thread makes the answer.
    Answer(Later<Value>),
    /// Another thread writes this take. The recording ends once it is written.
    Take(Later<Value>, TakeIdentity),
    /// A search.
    Find(Box<Finding>),
}

/// Begins a request whose work takes longer than a frame may. Gives any other request back.
pub(super) fn begin(
    request: Request,
    host: &mut dyn Host,
    middle: Option<&Middle>,
) -> Result<Result<Work, Refusal>, Box<Request>> {
    let session = host.session();
    let later = match request {
        Request::Stop { name } => return Ok(stop_recording(session, name)),
        Request::Find(wanted) => {
            return Ok(Finding::new(session, wanted, middle.cloned()).map(|finding| Work::Find(Box::new(finding))));
        }
        Request::Screenshot { path } => read::screenshot(session, path),
        Request::Picture { path } => read::picture(session, path),
        Request::Texels { target, age, mip, layer, after, path } => {
            let target = DebugTarget { resource: target, age, mip, layer, after };
            read::texels(session, &target, middle, path)
        }
        Request::Pixel { target, x, y, age, mip, layer, after } => {
            read::pixel(session, &DebugTarget { resource: target, age, mip, layer, after }, [x, y], middle)
        }
        Request::Statistics { target, age, mip, layer, after } => {
            find::statistics(session, &DebugTarget { resource: target, age, mip, layer, after }, middle)
        }
        Request::Buffer { buffer, start, bytes, path } => {
            read::buffer(session, &buffer, start..start.saturating_add(bytes), path)
        }
        Request::Files {} => Ok(work::files(session)),
        other => return Err(Box::new(other)),
    };
    Ok(later.map(Work::Answer))
}

impl Work {
    /// Does all of it at once: where no frame waits for it.
    pub(crate) fn finish(self, session: &mut Session) -> Result<Value, Refusal> {
        match self {
            Work::Answer(mut later) => later.finish(session),
            Work::Take(mut later, take) => {
                let written = later.finish(session);
                if written.is_ok() {
                    session.stop_recording_of(&take);
                }
                written
            }
            Work::Find(finding) => finding.finish(session),
        }
    }
}

/// Carries out one request that takes no longer than a frame may, or nothing.
pub(super) fn answer(
    request: Request,
    host: &mut dyn Host,
    drive: Drive,
    middle: &mut Option<Middle>,
) -> Result<Value, Refusal> {
    let session = host.session();
    match request {
        Request::Info {} => Ok(describe::info(session)),
        Request::Set { param, value } => set(host, &param, &value),
        Request::Unset { param } => {
            session.unset_param(&param)?;
            param_value(session, &param)
        }
        Request::Target { target } => {
            session.set_debug_target_text(&target)?;
            Ok(json!({ "target": target }))
        }
        Request::Camera(camera) => move_camera(session, &camera),
        Request::Input(held) => inputs::hold(session, drive, held),
        Request::Record {} => {
            session.record()?;
            Ok(json!({}))
        }
        Request::Pause { paused } => {
            session.pause(paused);
            Ok(json!({ "paused": paused }))
        }
        Request::Step { frames } => step(host, drive, frames, middle),
        Request::Seek { seconds } => {
            session.seek(seconds);
            Ok(json!({ "seconds": seconds }))
        }
        Request::Reset {} => {
            session.reset();
            Ok(json!({}))
        }
        Request::Resize { size } => resize(session, drive, size),
        Request::Capture {} => {
            let (_, file) = session.capture_frame()?;
            Ok(json!({ "path": file }))
        }
        Request::Edit { operations } => edit(session, &operations),
        Request::Undo {} => {
            let undone = session.undo()?;
            Ok(with_steps(session, json!({ "undone": undone })))
        }
        Request::Redo {} => {
            let redone = session.redo()?;
            Ok(with_steps(session, json!({ "redone": redone })))
        }
        Request::CheckBounds { on } => {
            let compiles = session.checks_bounds() != on && session.check_bounds(on);
            Ok(json!({ "on": on, "compiles": compiles }))
        }
        Request::RecordWrites { on } => Ok(writers::record(session, on)),
        Request::Writers { target, x, y, mip, layer } => {
            writers::find(session, drive, TracedTexel { target, mip, layer, at: [x, y] })
        }
        Request::Presets {} => work::presets(host),
        Request::SavePreset { name } => work::save_preset(host, &name),
        Request::ApplyPreset { name } => work::apply_preset(host, &name),
        Request::DeletePreset { name } => work::delete_preset(host, &name),
        Request::WriteParams { params, to } => work::write_params(host, &params, to.into()),
        Request::UndoWrite {} => work::undo_write(host),
        Request::WriteCamera { name } => work::write_camera(host, &name),
        Request::Keys {} => work::keys(session),
        Request::MoveKey { track, key, to } => work::move_key(host, &track, key, to),
        Request::DeleteKey { track, key } => work::delete_key(host, &track, key),
        Request::WriteKey { param, seconds } => work::write_key(host, param.as_deref(), seconds),
        Request::Loop { on } => {
            host.set_looped(on);
            Ok(json!({ "on": on }))
        }
        Request::HandBack {} => {
            session.hand_back();
            Ok(json!({ "drives": session.demo_drives() }))
        }
        Request::RecordParams { on: true } => work::record_params(host),
        Request::RecordParams { on: false } => work::write_recorded(host),
        Request::FpsCap { fps } => {
            let window = host.window().ok_or_else(|| Refusal::no_window("fps_cap").or("`step` runs each frame"))?;
            if let Some(fps) = fps {
                window.set_fps_cap(Some(fps).filter(|fps| *fps > 0));
            }
            Ok(json!({ "fps": window.fps_cap().unwrap_or(0) }))
        }
        Request::FlySpeed { voxels } => {
            let window =
                host.window().ok_or_else(|| Refusal::no_window("fly_speed").or("`camera` moves the camera"))?;
            voxels.into_iter().for_each(|voxels| window.set_fly_speed(voxels));
            Ok(json!({ "voxels": window.fly_speed() }))
        }
        Request::Brush(change) => brush::change(host, &change),
        Request::Display(shown) => work::show(host, &shown),
        Request::Forget {} => {
            host.forget();
            Ok(json!({}))
        }
        Request::Compare { mode, gain, flipped } => {
            host.window().ok_or_else(|| Refusal::no_window("compare"))?.compare(mode, gain, flipped);
            Ok(json!({}))
        }
        Request::Cancel {} => {
            let given_up = host.window().ok_or_else(|| Refusal::no_window("cancel"))?.cancel();
            Ok(json!({ "cancelled": given_up.is_some(), "pass": given_up.flatten() }))
        }
        Request::Scale { scale } => {
            session.set_scale(scale);
            Ok(json!({ "scale": scale, "size": session.size() }))
        }
        // The conversation answers them, and those of [`begin`].
        Request::Diagnostics {}
        | Request::WaitReload { .. }
        | Request::Open { .. }
        | Request::Keep(_)
        | Request::Measure {}
        | Request::Stop { .. }
        | Request::Find(_)
        | Request::Screenshot { .. }
        | Request::Picture { .. }
        | Request::Texels { .. }
        | Request::Pixel { .. }
        | Request::Statistics { .. }
        | Request::Buffer { .. }
        | Request::Files {}
        | Request::Timings {}
        | Request::Quit {} => Ok(json!({})),
    }
}

/// Sets a param, which is recorded if a program records.
fn set(host: &mut dyn Host, param: &str, value: &Value) -> Result<Value, Refusal> {
    let text = text(value)?;
    let (session, recorder) = host.recorder();
    let before = session.param(param)?;
    session.set_param_text(param, &text)?;
    if recorder.is_of_program() {
        tracks::moved(session, recorder, param, before);
    } else {
        // A demo that drives the param would win.
        session.take_over();
    }
    param_value(session, param)
}

fn param_value(session: &Session, param: &str) -> Result<Value, Refusal> {
    Ok(json!({ "param": param, "value": describe::value(&session.param(param)?) }))
}

/// Moves the camera, or only answers with its pose.
fn move_camera(session: &mut Session, moved: &CameraMove) -> Result<Value, Refusal> {
    if *moved != CameraMove::default() {
        let camera = placed(session, moved)?;
        session.take_over();
        session.set_camera(camera);
    }
    Ok(describe::camera(session.camera()))
}

fn placed(session: &Session, moved: &CameraMove) -> Result<Camera, Refusal> {
    let CameraMove { name, position, look_at, yaw, pitch, fov } = moved;
    let mut camera = match name {
        Some(name) => raxel_terminal::session::named_camera(session.world(), name)?,
        None => *session.camera(),
    };
    if let Some(position) = *position {
        camera = Camera { yaw: camera.yaw, pitch: camera.pitch, fov: camera.fov, ..Camera::at(position) };
    }
    if let Some(target) = *look_at {
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

/// Keeps a picture that has come, or gives up its request.
pub(super) fn keep(host: &mut dyn Host, kept: Result<Kept, Refusal>, number: u64) -> Result<Value, Refusal> {
    let kept = kept.inspect_err(|_| host.give_up_kept(number))?;
    let name = kept.name.clone();
    if host.keep(kept, number) {
        Ok(json!({ "kept": name }))
    } else {
        Err(Refusal::new("the window was asked for another picture, or for none, meanwhile"))
    }
}

/// Writes the take so far as a demo.
fn stop_recording(session: &Session, name: Option<String>) -> Result<Work, Refusal> {
    // The user of a window may have ended it.
    if session.is_take_written() {
        return Err(Refusal::new("the take is being written"));
    }
    let take = session.take_so_far()?;
    let (project, identity) = (session.project().clone(), take.identity());
    let written = Later::beside(move || {
        let name = raxel_output::take_name(&project, name.as_deref())?;
        let take = take.finish(&name)?;
        let path = raxel_output::write_take(&project, &name, &take)?;
        let ended = take.ended.map(|ended| ended.to_string());
        Ok(json!({ "path": path, "seconds": take.seconds, "ended": ended }))
    });
    Ok(Work::Take(written, identity))
}

/// Runs frames; in a window that is paused, lets them pass.
fn step(host: &mut dyn Host, drive: Drive, frames: u32, middle: &mut Option<Middle>) -> Result<Value, Refusal> {
    let looped = host.looped();
    let session = host.session();
    if drive == Drive::Window && !session.clock().paused() {
        return Err(Refusal::new("the window runs by itself; pause it first"));
    }
    for index in 0..frames {
        let (session, recorder) = host.recorder();
        match drive {
            Drive::Requests => {
                demo::turn(session, looped);
                // A program ends the recordings.
                tracks::frame(session, recorder, false);
                // The output right after a pass is copied there.
                if index + 1 == frames && session.debug_target().after.is_some() {
                    session.capture_shown(0..0);
                }
                session.frame()?;
            }
            Drive::Window => session.step(),
        }
    }
    let session = host.session();
    if drive == Drive::Requests {
        session.wait()?;
        *middle = read::shown_in_the_middle(session);
    }
    Ok(describe::now(session))
}

fn resize(session: &mut Session, drive: Drive, [width, height]: [u32; 2]) -> Result<Value, Refusal> {
    if drive == Drive::Window {
        return Err(Refusal::new("the window has its own size"));
    }
    session.resize(width, height);
    Ok(json!({ "size": [width, height] }))
}

/// Edits the world by operations, as one step.
fn edit(session: &mut Session, operations: &[Value]) -> Result<Value, Refusal> {
    let written: Vec<String> = operations.iter().map(toml).collect::<Result<_, _>>()?;
    let text = format!("edits = [{}]", written.join(", "));
    let operations = raxel_runtime::timeline::operations(&text, session.scene())?;
    let chunks = session.edit(&operations)?;
    Ok(with_steps(session, json!({ "chunks": chunks })))
}

fn with_steps(session: &Session, mut answer: Value) -> Value {
    let steps = session.edit_steps();
    answer["steps"] = json!({ "undo": steps.undo, "redo": steps.redo });
    answer
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

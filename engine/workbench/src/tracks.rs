//! Tracks of a demo that are made by moving params of the session.

use raxel_graph::checked::Value;
use raxel_output::{demo_path, take_name};
use raxel_runtime::Session;
use raxel_runtime::params::components;
use raxel_runtime::reload::ProjectFile;

use super::demo::{self, Changed};
use super::demo_keys;
use super::recording::{Recorder, Recording};
use super::write_back;

/// Records that a param of the session was moved, and had a value before. A demo that drives this param must not change it meanwhile; its camera
/// and its other tracks go on.
pub fn moved(session: &mut Session, recorder: &mut Recorder, name: &str, before: Value) {
    let Some(value) = session.param(name).ok().filter(|_| recorder.is_on()) else { return };
    let tracked = session.demo().is_some_and(|demo| demo.tracks.iter().any(|track| track.param.value == name));
    if session.demo_drives() && tracked {
        session.release_param(Some(name));
        recorder.release();
    }
    recorder.moved(name, before, demo::seconds(session), &components(&value));
}

/// Before a frame: gives the recordings that have ended. `held` says whether a widget is held.
pub fn frame(session: &Session, recorder: &mut Recorder, held: bool) -> Vec<Recording> {
    let time = demo::seconds(session);
    recorder.note(time, |param| session.param(param).ok().map(|value| components(&value)));
    recorder.frame(time, held)
}

/// Why recordings could not be written, in one line, before there are any.
///
/// # Errors
/// No demo runs, and none can be made of what runs.
pub fn check(session: &Session) -> Result<(), String> {
    if session.demo().is_some() { Ok(()) } else { new_demo(session, &[]).map(drop) }
}

/// Writes recordings into the demo that runs. Without one, makes `worlds/take.demo.toml`, or one of the next free name, and opens it.
///
/// # Errors
/// Why nothing is written, in one line.
pub fn write(session: &mut Session, recordings: &[Recording]) -> Result<Changed, String> {
    if let Some(changed) = demo::change(session, |text, _, _| demo_keys::with_recordings(text, recordings)) {
        return changed;
    }
    let text = new_demo(session, recordings)?;
    let project = session.project();
    let file = demo_path(&take_name(project, None).map_err(|error| error.message)?);
    let written = write_back::create(project, &file, &text)?;
    session.open_file(ProjectFile::Demo(file.clone()));
    Ok(Changed { file, written: Some(written) })
}

/// The text of a demo of the running files with the keys of recordings.
fn new_demo(session: &Session, recordings: &[Recording]) -> Result<String, String> {
    let world = session.world().path.as_deref().ok_or("a demo needs a world: `--world` names one")?;
    demo_keys::new_demo(session.graph_path(), world, recordings, session.camera())
}

/// Lets the demo drive all params again that were recorded.
pub fn give_back(session: &mut Session, recorder: &mut Recorder) {
    if recorder.gives_back() {
        session.release_param(None);
    }
}

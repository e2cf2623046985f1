//! Requests that do what the panels of a window do: presets, values written into files, keys of demos, the display.

use std::collections::BTreeMap;

use raxel_graph::checked::{Display, Param};
use raxel_runtime::Session;
use raxel_runtime::reload::ProjectFile;
use raxel_workbench::demo::{self, Changed, Lane};
use raxel_workbench::presets::{Presets, Values};
use raxel_workbench::recording::Recording;
use raxel_workbench::writes::{self, Applied, Files, InFile, WriteTo};
use raxel_workbench::{demo_keys, display, files, tracks};
use serde_json::{Value, json};

use super::host::{Host, Restored};
use super::later::Later;
use super::refusal::Refusal;
use super::request::Shown;

/// The files that `open` opens.
pub(super) fn files(session: &Session) -> Later<Value> {
    let lister = files::Lister::of(session);
    Later::beside(move || {
        let file = |openable: &files::Openable| json!({ "kind": openable.kind(), "path": openable.file.path(), "runs": openable.runs });
        Ok(json!({ "files": lister.list().iter().map(file).collect::<Vec<_>>() }))
    })
}

/// The file of the project at this path.
pub(super) fn file(session: &Session, path: &str) -> Later<ProjectFile> {
    let (lister, path) = (files::Lister::of(session), path.to_owned());
    Later::beside(move || {
        lister.find(&path).map_err(|error| Refusal {
            error,
            help: vec!["`files` lists the graphs, worlds and demos of the project".to_owned()],
        })
    })
}

/// The presets of the graph.
pub(super) fn presets(host: &mut dyn Host) -> Result<Value, Refusal> {
    let (session, presets) = read_presets(host)?;
    let preset = |(name, values): (&str, &Values)| json!({ "name": name, "values": values });
    Ok(json!({ "presets": presets.of_graph(session.graph_path()).map(preset).collect::<Vec<_>>() }))
}

/// A user or another window may have written them.
fn read_presets(host: &mut dyn Host) -> Result<(&mut Session, &mut Presets), Refusal> {
    let (session, presets) = host.presets();
    presets.read().map_err(Refusal::new)?;
    Ok((session, presets))
}

/// The values of a preset of the graph.
fn preset(host: &mut dyn Host, name: &str) -> Result<Values, Refusal> {
    let (session, presets) = read_presets(host)?;
    let graph = session.graph_path();
    let found = presets.of_graph(graph).find(|(known, _)| *known == name).map(|(_, values)| values.clone());
    found.ok_or_else(|| {
        let known: Vec<&str> = presets.of_graph(graph).map(|(known, _)| known).collect();
        Refusal::unknown(&format!("`{graph}` has no preset"), name, known.iter().copied())
    })
}

/// Keeps the values of all params under a name.
pub(super) fn save_preset(host: &mut dyn Host, name: &str) -> Result<Value, Refusal> {
    if name.trim().is_empty() {
        return Err(Refusal::new("`name` is empty"));
    }
    let (session, presets) = host.presets();
    let values = writes::values(session);
    let written = presets.save(session.graph_path(), name, &values).map_err(Refusal::new)?;
    let answer = json!({ "path": written.file, "values": values });
    host.wrote(Files { written: vec![written], params: Vec::new() });
    Ok(answer)
}

/// Sets the params to the values of a preset.
pub(super) fn apply_preset(host: &mut dyn Host, name: &str) -> Result<Value, Refusal> {
    let values = preset(host, name)?;
    let session = host.session();
    let Applied { changes, left, refused } = writes::apply(session, &values);
    // A demo that drives the params would win.
    session.take_over();
    let changed: Vec<&String> = changes.iter().map(|change| &change.name).collect();
    Ok(json!({ "changed": changed, "left": left, "refused": refused }))
}

/// Takes a preset out of the file.
pub(super) fn delete_preset(host: &mut dyn Host, name: &str) -> Result<Value, Refusal> {
    preset(host, name)?;
    let (session, presets) = host.presets();
    let written = presets.remove(session.graph_path(), name).map_err(Refusal::new)?;
    let answer = json!({ "path": written.file });
    host.wrote(Files { written: vec![written], params: Vec::new() });
    Ok(answer)
}

/// Writes the values of params into a file of the graph.
pub(super) fn write_params(host: &mut dyn Host, names: &[String], to: WriteTo) -> Result<Value, Refusal> {
    let session = host.session();
    for name in names {
        session.param(name)?;
    }
    let files = writes::default_files(session.graph(), session.texts());
    let place = |param: &Param| files.get(&param.name).cloned().unwrap_or_else(|| param.place.file.to_string());
    let (mut step, mut said, mut refused) = (Files::default(), Vec::new(), Vec::new());
    for InFile { file, params, result } in writes::write_params(session, names, to, place) {
        match result {
            Ok(written) => {
                said.push(json!({
                    "path": file,
                    "params": params.iter().map(|(name, _)| name).collect::<Vec<_>>(),
                    "changed": written.is_some(),
                }));
                // raxel does not read an unchanged file again, so no param would follow it.
                if let Some(written) = written {
                    step.written.push(written);
                    step.params.extend(params);
                }
            }
            Err(error) => refused.push(format!("{file}: {error}")),
        }
    }
    let nothing = said.is_empty() && !refused.is_empty();
    host.wrote(step);
    if nothing { Err(Refusal::new(refused.join("; "))) } else { Ok(json!({ "files": said, "refused": refused })) }
}

/// Restores the files that were written last.
pub(super) fn undo_write(host: &mut dyn Host) -> Result<Value, Refusal> {
    let Restored { files, refused } = host.undo_write().map_err(Refusal::new)?;
    Ok(json!({ "files": files, "refused": refused }))
}

/// Writes the camera into the world's file.
pub(super) fn write_camera(host: &mut dyn Host, name: &str) -> Result<Value, Refusal> {
    let good = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    if !good {
        let help = vec!["a name is made of a to z, A to Z, 0 to 9, `_` and `-`".to_owned()];
        return Err(Refusal { error: format!("`{name}` cannot be the name of a camera"), help });
    }
    match writes::write_camera(host.session(), name) {
        Some(Ok((file, written))) => Ok(wrote(host, Changed { file, written })),
        Some(Err(error)) => Err(Refusal::new(error)),
        None => Err(Refusal::new("the empty world has no file to write a camera into")),
    }
}

/// The demo and its keys.
pub(super) fn keys(session: &Session) -> Result<Value, Refusal> {
    let demo = session.demo().ok_or_else(no_demo)?;
    let track = |(lane, times): (Lane, Vec<f64>)| json!({ "track": lane.to_string(), "keys": times, "movable": lane.movable() });
    Ok(json!({
        "path": demo.file,
        "duration": demo.duration,
        "seconds": demo::seconds(session),
        "drives": session.demo_drives(),
        "tracks": demo::lanes(demo).into_iter().map(track).collect::<Vec<_>>(),
    }))
}

/// Writes another time of a key.
pub(super) fn move_key(host: &mut dyn Host, track: &str, key: usize, to: f64) -> Result<Value, Refusal> {
    let lane: Lane = track.parse().map_err(|error: String| Refusal::new(error))?;
    change_demo(host, |text| demo_keys::with_time(text, &lane, key, to))
}

/// Takes a key out of the demo.
pub(super) fn delete_key(host: &mut dyn Host, track: &str, key: usize) -> Result<Value, Refusal> {
    let lane: Lane = track.parse().map_err(|error: String| Refusal::new(error))?;
    change_demo(host, |text| demo_keys::without_key(text, &lane, key))
}

/// Writes the camera, or the value of a param, as a key of the demo.
pub(super) fn write_key(host: &mut dyn Host, param: Option<&str>, seconds: Option<f64>) -> Result<Value, Refusal> {
    let session = host.session();
    let demo = session.demo().ok_or_else(no_demo)?;
    let seconds = seconds.unwrap_or_else(|| demo::seconds(session));
    if !(0.0..=demo.duration).contains(&seconds) {
        return Err(Refusal::new(format!("a key of this demo is at 0 to {} s, got {seconds}", demo.duration)));
    }
    let camera = *session.camera();
    let Some(name) = param else {
        return change_demo(host, |text| demo_keys::with_camera_key(text, seconds, &camera));
    };
    let value = session.param(name)?;
    let default = session.params().iter().find(|param| param.name == name).map_or(value, |param| param.default);
    let recording = Recording::key(name, default, seconds, &value);
    change_demo(host, |text| demo_keys::with_param_keys(text, &recording))
}

/// Records params that are set from here on.
pub(super) fn record_params(host: &mut dyn Host) -> Result<Value, Refusal> {
    let (session, recorder) = host.recorder();
    tracks::check(session).map_err(Refusal::new)?;
    recorder.begin();
    Ok(json!({ "on": true }))
}

/// Writes what was recorded as keys of the demo. If that fails, the recording goes on.
pub(super) fn write_recorded(host: &mut dyn Host) -> Result<Value, Refusal> {
    let (session, recorder) = host.recorder();
    let recordings = recorder.end();
    if recordings.is_empty() {
        return Ok(json!({ "on": false, "path": null, "changed": false, "tracks": [] }));
    }
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for recording in &recordings {
        *counts.entry(Lane::Param(recording.param.clone()).to_string()).or_default() += recording.keys().len();
    }
    let recorded: Vec<Value> = counts.iter().map(|(track, keys)| json!({ "track": track, "keys": keys })).collect();
    match tracks::write(session, &recordings) {
        Ok(changed) => {
            tracks::give_back(session, recorder);
            let mut answer = wrote(host, changed);
            answer["on"] = false.into();
            answer["tracks"] = recorded.into();
            Ok(answer)
        }
        Err(error) => {
            recorder.go_on(recordings);
            Err(Refusal::new(error))
        }
    }
}

fn change_demo(host: &mut dyn Host, change: impl FnOnce(&str) -> Result<String, String>) -> Result<Value, Refusal> {
    match demo::change(host.session(), |text, _, _| change(text)) {
        Some(Ok(changed)) => Ok(wrote(host, changed)),
        Some(Err(error)) => Err(Refusal::new(error)),
        None => Err(no_demo()),
    }
}

/// Notes a change of one file, and answers with it.
fn wrote(host: &mut dyn Host, Changed { file, written }: Changed) -> Value {
    let answer = json!({ "path": file, "changed": written.is_some() });
    host.wrote(Files { written: written.into_iter().collect(), params: Vec::new() });
    answer
}

fn no_demo() -> Refusal {
    let help = vec!["`open` opens one; `files` lists them".to_owned()];
    Refusal { error: "no demo runs".to_owned(), help }
}

/// Shows the shown target in another way, or in the graph's.
pub(super) fn show(host: &mut dyn Host, shown: &Shown) -> Result<Value, Refusal> {
    let session = host.session();
    let graphs = display::of_graph(session).ok_or_else(|| {
        Refusal::new(format!("`{}` is a buffer: only targets have a display", display::shown_resource(session)))
    })?;
    let map = match &shown.map {
        Some(name) => display::map_named(name)
            .ok_or_else(|| Refusal::unknown("there is no map", name, display::MAPS.iter().map(|(name, _)| *name)))?,
        None => graphs.map,
    };
    let chosen =
        Display { map, range: shown.range.unwrap_or(graphs.range), channel: shown.channel.unwrap_or(graphs.channel) };
    host.set_display((*shown != Shown::default()).then_some(chosen));
    let Display { map, range, channel } = chosen;
    Ok(json!({ "map": display::name_of(map), "range": range, "channel": channel }))
}

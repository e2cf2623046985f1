//! Describes a session as JSON.

use raxel_execute::PassOutcome;
use raxel_graph::checked::{Param, Pass, PassId, ResourceKind, Value as ParamValue};
use raxel_graph::index32;
use raxel_runtime::Session;
use raxel_runtime::camera::Camera;
use raxel_runtime::params::{components, type_name};
use serde_json::{Value, json};

use super::refusal::Refusal;

/// The open project: files, size, params, resources, passes, cameras.
pub(super) fn info(session: &Session) -> Value {
    let graph = session.graph();
    let params: Vec<Value> = session.params().iter().map(|param| describe_param(param, session)).collect();
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

fn describe_param(param: &Param, session: &Session) -> Value {
    let now = session.param(&param.name).unwrap_or(param.default);
    json!({
        "name": param.name,
        "type": type_name(&param.default),
        "label": param.label,
        "value": value(&now),
        "default": value(&param.default),
        "range": param.range,
        "step": param.step,
        "tooltip": param.tooltip,
        "unit": param.unit,
        "group": param.group,
        "choices": param.choices,
    })
}

/// A value of a param as JSON: a number, `true`, or an array.
pub(super) fn value(value: &ParamValue) -> Value {
    if let ParamValue::Bool(value) = value {
        return (*value).into();
    }
    match components(value).as_slice() {
        [one] => json!(one),
        many => json!(many),
    }
}

/// Where a camera is, in voxels and degrees.
pub(super) fn camera(camera: &Camera) -> Value {
    json!({
        "position": camera.position().to_array(),
        "cell": camera.cell.to_array(),
        "frac": camera.frac.to_array(),
        "yaw": camera.yaw.to_degrees(),
        "pitch": camera.pitch.to_degrees(),
        "fov": camera.fov.to_degrees(),
    })
}

/// The last frame and its time.
pub(super) fn now(session: &Session) -> Value {
    match session.clock().now() {
        Some(now) => json!({ "frame": now.index, "seconds": now.time.seconds() }),
        None => json!({ "frame": null, "seconds": 0.0 }),
    }
}

/// Refuses before the first frame.
pub(super) fn may_time(session: &Session) -> Result<(), Refusal> {
    if session.picture().is_some() {
        return Ok(());
    }
    let help = vec!["run a frame with `step`".to_owned()];
    Err(Refusal { error: "no frame has run, so no pass has a time".to_owned(), help })
}

/// The times of the passes in the last frame, which has ended.
pub(super) fn times(session: &mut Session) -> Value {
    json!({ "passes": timings(session) })
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

//! Reads a demo file.

use raxel_diagnostics::table::{Node, Reporter, Table, read_document};
use raxel_diagnostics::{Diagnostic, Files, SourceMap, Spanned, codes, files};
use raxel_execute::moment::{Fraction, Moment};
use raxel_worldfile::{CAMERA_COORDINATES, CAMERA_FOV};

use super::curve::Interpolation;
use super::demo::{CameraKey, Caption, CaptionText, Check, Claim, DebugTargetKey, Demo, Direction, GraphKey, Track};
use super::edits;
use crate::camera::Camera;
use crate::debug_target::DebugTarget;

/// Longest demo: a day.
const LONGEST: f64 = 86_400.0;

/// Reads a demo, with its warnings, or everything that is wrong with the file. Names of params and targets are checked by
/// [`Demo::check`], when the graph is known.
pub fn read(files: &dyn Files, path: &str, texts: &mut SourceMap) -> Result<(Demo, Vec<Diagnostic>), Vec<Diagnostic>> {
    let text = files::read_text(files, path, None, texts).map_err(|error| vec![*error])?;
    read_document(path, &text, texts, |root| document(path, root))
}

fn document(path: &str, root: &Table<'_, '_>) -> Option<Demo> {
    let file_stem = path.rsplit('/').next().unwrap_or(path).trim_end_matches(".demo.toml");
    let name = root.string("name").map_or_else(|| file_stem.to_owned(), |(name, _)| name);
    let about = root.string("about").map(|(about, _)| about).unwrap_or_default();
    let world = project_path(root, "world", "worlds");
    let graph = project_path(root, "graph", "graphs");
    let duration = root.need("duration").and_then(|node| node.number(1e-3..=LONGEST));
    let fps = root.get("fps").map_or(Some(30.0), |node| node.number(1e-3..=1000.0));
    let looped = root.get("loop").map_or(Some(false), |node| node.boolean());
    // Without a duration, keys are still read for their other mistakes.
    let end = duration.unwrap_or(LONGEST);
    let camera = ordered(root.reporter(), root.array_of_tables("camera").iter().map(|table| camera_key(table, end)));
    let size = root.get("size").map_or(Some([1280, 720]), |node| node.integers(1..=16384));
    let captions = ordered(root.reporter(), root.array_of_tables("caption").iter().map(|table| caption(table, end)));
    let rate = fps.unwrap_or(30.0);
    let checks: Vec<_> = root.array_of_tables("check").iter().map(|table| check(table, end, rate)).collect();
    let graphs = ordered(root.reporter(), root.array_of_tables("graphs").iter().map(|table| graph_key(table, end)));
    let shows = ordered(root.reporter(), root.array_of_tables("show").iter().map(|table| debug_target_key(table, end)));
    let edits: Vec<_> = root.array_of_tables("edits").iter().map(|table| edits::read(table, end)).collect();
    let edits = edits::in_order(root.reporter(), edits);
    let tracks: Vec<_> =
        root.tables("tracks").into_iter().map(|(name, node, table)| track(name, &node, &table, end)).collect();
    root.finish();
    Some(Demo {
        file: path.to_owned(),
        name,
        about,
        world: world?,
        graph: graph?,
        duration: duration?,
        fps: fps?,
        size: size?,
        looped: looped?,
        camera: camera?,
        tracks: tracks.into_iter().collect::<Option<_>>()?,
        graphs: graphs?,
        shows: shows?,
        edits: edits?,
        captions: captions?,
        checks: checks.into_iter().collect::<Option<_>>()?,
    })
}

/// A file named by the demo, relative to the folder of its kind.
fn project_path(root: &Table<'_, '_>, key: &str, folder: &str) -> Option<Spanned<String>> {
    let (text, span) = root.need_string(key)?;
    let Some(value) = files::join(folder, &text) else {
        root.reporter().report(
            Diagnostic::error(codes::files::OUTSIDE_ROOT, format!("`{text}` leads outside the project root"))
                .label(span, format!("relative to `{folder}/`")),
        );
        return None;
    };
    Some(Spanned { value, span })
}

/// A key's time: reported when it is outside the demo.
pub(super) fn time(node: &Node<'_, '_>, end: f64) -> Option<Spanned<f64>> {
    let value = node.number(f64::MIN..=f64::MAX)?;
    if !(0.0..=end).contains(&value) {
        node.report(
            codes::session::KEY_TIME,
            format!("a key at {value} s is outside the demo, which lasts {end} s"),
            "outside",
        );
        return None;
    }
    Some(Spanned { value, span: node.span.clone() })
}

/// The keys, if all are right and in order of time.
fn ordered<T>(reporter: &Reporter, keys: impl Iterator<Item = Keyed<T>>) -> Option<Vec<T>> {
    let mut last: Option<Spanned<f64>> = None;
    let mut all_right = true;
    let mut found = Vec::new();
    for key in keys {
        let Some((time, value)) = key else {
            all_right = false;
            continue;
        };
        if let Some(last) = last.as_ref().filter(|last| last.value >= time.value) {
            reporter.report(
                Diagnostic::error(
                    codes::session::KEY_TIME,
                    format!("keys must be in order of time: {} s stands after {} s", time.value, last.value),
                )
                .label(time.span.clone(), "this one")
                .label(last.span.clone(), "after this one"),
            );
            all_right = false;
        }
        found.push(value);
        last = Some(time);
    }
    all_right.then_some(found)
}

/// A key with its time; `None` when something about it is wrong.
type Keyed<T> = Option<(Spanned<f64>, T)>;

fn camera_key(table: &Table<'_, '_>, end: f64) -> Keyed<CameraKey> {
    let time = table.need("time").and_then(|node| time(&node, end));
    let position = table.need("position").and_then(|node| node.numbers(CAMERA_COORDINATES));
    table.conflict("look_at", "yaw", "a camera looks at a point, or along angles");
    table.conflict("look_at", "pitch", "a camera looks at a point, or along angles");
    let degrees = |key: &str, range| table.get(key).map_or(Some(0.0), |node| node.number(range)).map(f64::to_radians);
    let (yaw, pitch) = (degrees("yaw", -3600.0..=3600.0), degrees("pitch", -90.0..=90.0));
    let direction = match table.get("look_at") {
        Some(node) => node.numbers(CAMERA_COORDINATES).and_then(|target| {
            if position == Some(target) {
                return node.bad_value(format!("`{}` is where the camera is: it has no direction", node.name));
            }
            Some(Direction::LookAt(target))
        }),
        None => yaw.zip(pitch).map(|(yaw, pitch)| Direction::Angles([yaw, pitch])),
    };
    let fov = table.get("fov").map_or(Some(Camera::default().fov), |node| node.number(CAMERA_FOV).map(f64::to_radians));
    let interpolation = interpolation(table, Interpolation::Smooth);
    let cut = table.get("cut").map_or(Some(false), |node| node.boolean());
    table.finish();
    let time = time?;
    let key = CameraKey {
        time: time.value,
        position: position?,
        direction: direction?,
        fov: fov?,
        interpolation: interpolation?,
        cut: cut?,
    };
    Some((time, key))
}

fn debug_target(node: &Node<'_, '_>) -> Option<Spanned<DebugTarget>> {
    match DebugTarget::parse(&node.string()?) {
        Ok(value) => Some(Spanned { value, span: node.span.clone() }),
        Err(error) => {
            node.report(codes::session::UNKNOWN_TARGET, error.to_string(), "");
            None
        }
    }
}

fn caption(table: &Table<'_, '_>, end: f64) -> Keyed<Caption> {
    let from = table.need("time").and_then(|node| time(&node, end));
    let until = table.need("until").and_then(|node| Some((time(&node, end)?, node)));
    let text = table.need("text").and_then(|node| {
        let text = node.string()?;
        if text.trim().is_empty() || text.chars().any(char::is_control) {
            return node.bad_value(format!("`{}` needs one line of text", node.name));
        }
        Some(text)
    });
    let top = table.get("place").map_or(Some(false), |node| node.word(&[("bottom", false), ("top", true)]));
    table.finish();
    let (from, (until, node)) = (from?, until?);
    if until.value <= from.value {
        node.report(
            codes::session::KEY_TIME,
            format!("a caption that appears at {} s is gone at {} s", from.value, until.value),
            "not after its `time`",
        );
        return None;
    }
    let during = [from.value, until.value];
    Some((from, Caption { during, line: CaptionText { text: text?, top: top? } }))
}

fn check(table: &Table<'_, '_>, end: f64, fps: f64) -> Option<Check> {
    let span = table.span().clone();
    // The key that only one of the two kinds has says which one is meant.
    if table.get("pass").is_some() {
        for key in ["reference", "target", "frame", "time", "flip"] {
            table.conflict("pass", key, "a check is about a pass or about a picture");
        }
        let pass = table.need_string("pass").map(|(value, span)| Spanned { value, span });
        let below_ms = table.need("below_ms").and_then(|node| node.number(1e-6..=1e6));
        table.finish();
        return Some(Check { span, claim: Claim::Pass { pass: pass?, below_ms: below_ms? } });
    }
    let reference = project_path(table, "reference", "worlds");
    let flip = table.need("flip").and_then(|node| node.number(0.0..=1.0));
    let target = table.get("target").map(|node| debug_target(&node));
    let frame_at = |seconds: f64| Moment::from(seconds).nearest(Fraction::of(fps));
    let last = frame_at(end).saturating_sub(1);
    let frame = match (table.get("frame"), table.get("time")) {
        (Some(frame), None) => frame.integer(0..=last),
        (None, Some(node)) => time(&node, end).map(|time| frame_at(time.value).min(last)),
        (Some(_), Some(_)) => {
            table.conflict("frame", "time", "both say when");
            None
        }
        (None, None) => table.need("frame").and(None),
    };
    table.finish();
    let target = match target {
        Some(target) => Some(target?),
        None => None,
    };
    Some(Check { span, claim: Claim::Picture { frame: frame?, target, reference: reference?, flip: flip? } })
}

fn graph_key(table: &Table<'_, '_>, end: f64) -> Keyed<GraphKey> {
    let time = table.need("time").and_then(|node| time(&node, end));
    let graph = project_path(table, "graph", "graphs");
    table.finish();
    let time = time?;
    let key = GraphKey { time: time.value, graph: graph? };
    Some((time, key))
}

fn debug_target_key(table: &Table<'_, '_>, end: f64) -> Keyed<DebugTargetKey> {
    let time = table.need("time").and_then(|node| time(&node, end));
    let target = table.need("target").and_then(|node| debug_target(&node));
    table.finish();
    let time = time?;
    let key = DebugTargetKey { time: time.value, target: target? };
    Some((time, key))
}

fn track(name: String, node: &Node<'_, '_>, table: &Table<'_, '_>, end: f64) -> Option<Track> {
    let keys = table.need("keys").and_then(|node| node.array()).and_then(|nodes| {
        if nodes.is_empty() {
            table.get("keys")?.bad_value::<()>(format!("`tracks.{name}.keys` needs one key at least"));
            return None;
        }
        let read: Vec<_> = nodes.iter().map(|node| track_key(node, end)).collect();
        let booleans = read.iter().flatten().filter(|(_, _, boolean)| *boolean).count();
        let first_width = read.iter().flatten().next().map_or(0, |(_, key, _)| key.value.1.len());
        for (_, key, boolean) in read.iter().flatten() {
            if key.value.1.len() != first_width || *boolean != (booleans > 0) {
                table.reporter().report(
                    Diagnostic::error(
                        codes::session::WRONG_PARAM_VALUE,
                        format!("the keys of `tracks.{name}` must all be of one type"),
                    )
                    .label(key.span.clone(), "this one differs"),
                );
                return None;
            }
        }
        let keys = ordered(table.reporter(), read.into_iter().map(|key| key.map(|(time, key, _)| (time, key))))?;
        Some((keys, booleans > 0))
    });
    let boolean = keys.as_ref().is_some_and(|(_, boolean)| *boolean);
    let interpolation = interpolation(table, if boolean { Interpolation::Step } else { Interpolation::Linear });
    if boolean
        && let Some(node) = table.get("interpolation")
        && interpolation.is_some_and(|how| how != Interpolation::Step)
    {
        return node.bad_value(format!("`tracks.{name}` is true or false; its interpolation can only be `step`"));
    }
    table.finish();
    let (keys, boolean) = keys?;
    Some(Track {
        param: Spanned { value: name, span: node.key_span.clone() },
        keys,
        boolean,
        interpolation: interpolation?,
    })
}

/// A key of a track: its time, its components, whether it is `true` or `false`.
type TrackKey = (Spanned<f64>, Spanned<(f64, Vec<f64>)>, bool);

/// `[seconds, value]`.
fn track_key(node: &Node<'_, '_>, end: f64) -> Option<TrackKey> {
    let parts = node.array()?;
    let [at, value] = parts.as_slice() else {
        return node.bad_value(format!("`{}` must be [seconds, value]", node.name));
    };
    let time = time(at, end);
    let numbers = if value.is_boolean() {
        vec![f64::from(u8::from(value.boolean()?))]
    } else if value.is_array() {
        let elements = value.array()?;
        let numbers: Vec<f64> = elements.iter().filter_map(|element| element.number(f64::MIN..=f64::MAX)).collect();
        if numbers.len() != elements.len() {
            return None;
        }
        numbers
    } else {
        vec![value.number(f64::MIN..=f64::MAX)?]
    };
    let time = time?;
    let key = Spanned { value: (time.value, numbers), span: node.span.clone() };
    Some((time, key, value.is_boolean()))
}

fn interpolation(table: &Table<'_, '_>, default: Interpolation) -> Option<Interpolation> {
    table.get("interpolation").map_or(Some(default), |node| node.word(Interpolation::WORDS))
}

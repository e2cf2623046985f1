//! Reads the parts of a demo file that its declaration in `demo.rs` leaves to functions, mostly about time.

use std::ops::RangeInclusive;

use raxel_diagnostics::table::{Node, Reporter, Table, read_document};
use raxel_diagnostics::{Diagnostic, Files, SourceMap, Spanned, codes, files};
use raxel_execute::moment::{Fraction, Moment};
use raxel_language::{Json, Keys, ReadKeys, Shape, Value, describe};
use serde_json::json;

use crate::curve::Interpolation;
use crate::debug_target::DebugTarget;
use crate::demo::{CameraKey, Caption, DebugTargetKey, Demo, GraphKey, TrackKeys};

/// Reads a demo, with its warnings, or everything that is wrong with the file. Names of params and targets are checked by
/// [`Demo::check`], when the graph is known.
pub fn read(files: &dyn Files, path: &str, texts: &mut SourceMap) -> Result<(Demo, Vec<Diagnostic>), Vec<Diagnostic>> {
    let text = files::read_text(files, path, None, texts).map_err(|error| vec![*error])?;
    read_document(path, &text, texts, |root| document(path, root))
}

/// JSON schema of `worlds/*.demo.toml`.
pub fn schema() -> Json {
    Demo::form().document("raxel demo")
}

fn document(path: &str, root: &Table<'_, '_>) -> Option<Demo> {
    let mut demo = Demo::read_whole(root, &Clock::of(root))?;
    path.clone_into(&mut demo.file);
    if root.get("name").is_none() {
        let file = path.rsplit('/').next().unwrap_or(path);
        file.trim_end_matches(".demo.toml").clone_into(&mut demo.name);
    }
    Some(demo)
}

/// The times that the keys of a demo are placed on.
pub(crate) struct Clock {
    /// Seconds that the demo lasts.
    end: f64,
    /// Frames a second.
    fps: f64,
}

impl Clock {
    /// How long a demo may last: a day at most.
    pub(crate) const DURATIONS: RangeInclusive<f64> = 1e-3..=86_400.0;
    /// Frames a second that it may have.
    pub(crate) const RATES: RangeInclusive<f64> = 1e-3..=1000.0;

    /// Without a duration that can be read, keys are still read for their other mistakes.
    fn of(root: &Table<'_, '_>) -> Self {
        let number = |key, range| root.peek(key, |node| node.number(range));
        Self {
            end: number("duration", Self::DURATIONS).unwrap_or(*Self::DURATIONS.end()),
            fps: number("fps", Self::RATES).unwrap_or(30.0),
        }
    }

    fn frame_at(&self, seconds: f64) -> u64 {
        Moment::from(seconds).nearest(Fraction::of(self.fps))
    }

    fn last_frame(&self) -> u64 {
        self.frame_at(self.end).saturating_sub(1)
    }
}

/// Reads the name of a file, relative to the folder of its kind, as a project path.
pub(crate) fn project_path(folder: &str) -> impl Fn(&Node<'_, '_>, &Clock) -> Option<Spanned<String>> {
    move |node, _| {
        let text = node.string()?;
        let Some(value) = files::join(folder, &text) else {
            let message = format!("`{text}` leads outside the project root");
            node.report(codes::files::OUTSIDE_ROOT, message, format!("relative to `{folder}/`"));
            return None;
        };
        Some(Spanned { value, span: node.span.clone() })
    }
}

/// A key's time: reported when it is outside the demo.
pub(crate) fn time(node: &Node<'_, '_>, clock: &Clock) -> Option<Spanned<f64>> {
    let (value, end) = (node.number(f64::MIN..=f64::MAX)?, clock.end);
    if !(0.0..=end).contains(&value) {
        let message = format!("a key at {value} s is outside the demo, which lasts {end} s");
        node.report(codes::session::KEY_TIME, message, "outside");
        return None;
    }
    Some(Spanned { value, span: node.span.clone() })
}

/// An event at a time.
pub(crate) trait Timed {
    fn time(&self) -> &Spanned<f64>;
}

macro_rules! timed {
    ($($key:ty),*) => {$(
        impl Timed for $key {
            fn time(&self) -> &Spanned<f64> {
                &self.time
            }
        }
    )*};
}

timed!(CameraKey, Caption, GraphKey, DebugTargetKey);

/// Reads keys that must be in order of time.
pub(crate) fn in_order<T: Timed + Value<Clock, Limits = ()>>(node: &Node<'_, '_>, clock: &Clock) -> Option<Vec<T>> {
    let keys: Vec<Option<T>> = node.array()?.iter().map(|node| T::read(node, &(), clock)).collect();
    ordered(node.reporter(), keys, T::time)
}

/// The keys, if all are right and in order of time.
pub(crate) fn ordered<T>(
    reporter: &Reporter,
    keys: Vec<Option<T>>,
    time: impl Fn(&T) -> &Spanned<f64>,
) -> Option<Vec<T>> {
    let mut all_right = keys.iter().all(Option::is_some);
    let found: Vec<T> = keys.into_iter().flatten().collect();
    for pair in found.windows(2) {
        let [last, time] = [time(&pair[0]), time(&pair[1])];
        if last.value >= time.value {
            let message = format!("keys must be in order of time: {} s stands after {} s", time.value, last.value);
            reporter.report(
                Diagnostic::error(codes::session::KEY_TIME, message)
                    .label(time.span.clone(), "this one")
                    .label(last.span.clone(), "after this one"),
            );
            all_right = false;
        }
    }
    all_right.then_some(found)
}

/// A camera cannot look at the point where it is.
pub(crate) fn elsewhere(table: &Table<'_, '_>, _: &Clock, position: &[f64; 3], look_at: Option<&[f64; 3]>) -> bool {
    let same = table.get("look_at").filter(|_| look_at == Some(position));
    if let Some(node) = &same {
        node.bad_value::<()>(format!("`{}` is where the camera is: it has no direction", node.name));
    }
    same.is_none()
}

/// A caption is there for some time.
pub(crate) fn lasts(table: &Table<'_, '_>, _: &Clock, time: &Spanned<f64>, until: &Spanned<f64>) -> bool {
    let lasts = time.value < until.value;
    if !lasts && let Some(node) = table.get("until") {
        let message = format!("a caption that appears at {} s is gone at {} s", time.value, until.value);
        node.report(codes::session::KEY_TIME, message, "not after its `time`");
    }
    lasts
}

/// Text of a caption.
pub(crate) fn line(node: &Node<'_, '_>) -> Option<String> {
    let text = node.string()?;
    if text.trim().is_empty() || text.chars().any(char::is_control) {
        return node.bad_value(format!("`{}` needs one line of text", node.name));
    }
    Some(text)
}

/// The number of a frame.
pub(crate) fn frame(node: &Node<'_, '_>, clock: &Clock) -> Option<u64> {
    node.integer(0..=clock.last_frame())
}

/// The frame nearest to a time.
pub(crate) fn nearest_frame(node: &Node<'_, '_>, clock: &Clock) -> Option<u64> {
    time(node, clock).map(|time| clock.frame_at(time.value).min(clock.last_frame()))
}

/// A picture is looked at once.
pub(crate) fn once(table: &Table<'_, '_>, _: &Clock, frame: Option<&u64>, time: Option<&u64>) -> bool {
    if frame.is_none() && time.is_none() {
        table.need("frame");
    }
    frame.is_some() != time.is_some()
}

/// A boolean steps; it cannot become the other bit by bit.
pub(crate) fn steps(table: &Table<'_, '_>, _: &Clock, keys: &TrackKeys, interpolation: Option<&Interpolation>) -> bool {
    let wrong = table.get("interpolation").filter(|_| keys.boolean && interpolation != Some(&Interpolation::Step));
    if let Some(node) = &wrong {
        let message = format!("`{}` is true or false; its interpolation can only be `step`", table.name());
        node.bad_value::<()>(message);
    }
    wrong.is_none()
}

describe! {
    DebugTarget => Shape::Text;
    TrackKeys => Shape::Schema(json!({ "type": "array", "minItems": 1, "items": { "type": "array", "minItems": 2, "maxItems": 2 } }));
}

impl<C: ?Sized> Value<C> for DebugTarget {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        DebugTarget::parse(&node.string()?)
            .map_err(|error| node.report(codes::session::UNKNOWN_TARGET, error.to_string(), ""))
            .ok()
    }
}

impl Value<Clock> for TrackKeys {
    fn read(node: &Node<'_, '_>, (): &(), clock: &Clock) -> Option<Self> {
        let nodes = node.array()?;
        if nodes.is_empty() {
            return node.bad_value(format!("`{}` needs one key at least", node.name));
        }
        let read: Vec<Option<TrackKey>> = nodes.iter().map(|node| track_key(node, clock)).collect();
        let boolean = read.iter().flatten().any(|key| key.boolean);
        let width = read.iter().flatten().next().map_or(0, |key| key.value.value.1.len());
        if let Some(other) =
            read.iter().flatten().find(|key| key.value.value.1.len() != width || key.boolean != boolean)
        {
            let track = node.name.strip_suffix(".keys").unwrap_or(&node.name);
            let message = format!("the keys of `{track}` must all be of one type");
            node.reporter().report(
                Diagnostic::error(codes::session::WRONG_PARAM_VALUE, message)
                    .label(other.value.span.clone(), "this one differs"),
            );
            return None;
        }
        let keys = ordered(node.reporter(), read, |key| &key.time)?;
        Some(Self { values: keys.into_iter().map(|key| key.value).collect(), boolean })
    }
}

/// A key of a track: its time, its components, whether it is `true` or `false`.
struct TrackKey {
    time: Spanned<f64>,
    value: Spanned<(f64, Vec<f64>)>,
    boolean: bool,
}

/// `[seconds, value]`.
fn track_key(node: &Node<'_, '_>, clock: &Clock) -> Option<TrackKey> {
    let parts = node.array()?;
    let [at, value] = parts.as_slice() else {
        return node.bad_value(format!("`{}` must be [seconds, value]", node.name));
    };
    let time = time(at, clock);
    let numbers = if value.is_boolean() {
        vec![f64::from(u8::from(value.boolean()?))]
    } else if value.is_array() {
        Vec::<f64>::read(value, &raxel_language::NumberRange::default(), clock)?
    } else {
        vec![value.number(f64::MIN..=f64::MAX)?]
    };
    let time = time?;
    let value_at = Spanned { value: (time.value, numbers), span: node.span.clone() };
    Some(TrackKey { time, value: value_at, boolean: value.is_boolean() })
}

//! The program's messages about itself: `tracing` spans and events. A slow step is named while it runs. All is printed with `--verbose`,
//! and written with `--trace` as a file that <https://ui.perfetto.dev> and `chrome://tracing` open (Chrome's Trace Event Format). Threads
//! of the CPU are one process of it, the passes on the GPU another.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use raxel_execute::SLOW;
use raxel_output::Pending;
use serde_json::{Value, json};
use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::{Event, Level, Metadata, Subscriber, span};
use tracing_subscriber::Registry;
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::registry::LookupSpan;

use crate::console::Console;
use crate::failure::Result;

/// Most slices of a trace, about 300 MiB of file. Later slices are left out, with a message.
const MOST_SLICES: usize = 2_000_000;

/// The target of the runtime's events about the GPU's work.
const GPU: &str = "raxel::gpu";

/// Seconds after which a step is named in a log, without a terminal.
const UNWATCHED: u64 = 30;

/// A trace in the making.
pub struct TraceWriter {
    trace: Option<(Pending, Arc<Mutex<Trace>>)>,
    console: Console,
}

struct Trace {
    began: Instant,
    slices: Vec<Slice>,
    threads: BTreeMap<u64, String>,
    left_out: u64,
    /// Microseconds since the start at which the GPU's last frame ended, and at which the one in work began.
    gpu_end: f64,
    gpu_frame: f64,
    /// Where the last pass in each track of the GPU ended: passes that overlap are drawn in tracks of their own.
    gpu_tracks: Vec<f64>,
}

struct Slice {
    name: String,
    gpu: bool,
    thread: u64,
    /// Microseconds since the start.
    start: f64,
    duration: f64,
    about: String,
}

impl TraceWriter {
    /// Listens from now on, if any of it is requested.
    pub fn listen(path: Option<&Path>, console: &Console) -> Result<Self> {
        let trace = path.map(|path| Pending::new(path).map(|pending| (pending, Arc::default()))).transpose()?;
        let writer = Self { trace, console: console.clone() };
        let level = match &writer.trace {
            Some(_) => LevelFilter::TRACE,
            None if console.verbose() => LevelFilter::DEBUG,
            None => LevelFilter::INFO,
        };
        let ear = TraceLayer {
            console: console.clone(),
            level,
            trace: writer.trace.as_ref().map(|(_, trace)| trace.clone()),
        };
        // A second one in a process is none: the first stays.
        let _ = tracing::subscriber::set_global_default(Registry::default().with(ear));
        Ok(writer)
    }

    /// Writes the trace.
    pub fn finish(self) -> Result {
        let Some((pending, trace)) = self.trace else { return Ok(()) };
        let trace = lock(&trace);
        pending.finish(trace.text().as_bytes())?;
        let left_out = match trace.left_out {
            0 => String::new(),
            count => format!(", {count} more left out"),
        };
        self.console
            .message(&format!("wrote the trace ({} slices{left_out}); ui.perfetto.dev opens it", trace.slices.len()));
        Ok(())
    }
}

fn lock(trace: &Mutex<Trace>) -> MutexGuard<'_, Trace> {
    trace.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Default for Trace {
    fn default() -> Self {
        let (slices, threads) = (Vec::new(), BTreeMap::new());
        Self {
            began: Instant::now(),
            slices,
            threads,
            left_out: 0,
            gpu_end: 0.0,
            gpu_frame: 0.0,
            gpu_tracks: Vec::new(),
        }
    }
}

impl Trace {
    fn push(&mut self, slice: Slice) {
        if self.slices.len() < MOST_SLICES {
            self.slices.push(slice);
        } else {
            self.left_out += 1;
        }
    }

    /// Microseconds since the start.
    fn at(&self, instant: Instant) -> f64 {
        instant.saturating_duration_since(self.began).as_nanos() as f64 / 1e3
    }

    /// A frame or a pass on the GPU. Its clock is another one: a frame is put where it was submitted, or behind the frame before it.
    fn gpu(&mut self, told: &Fields) {
        let number = |name: &str| told.numbers.get(name).copied().unwrap_or_default() as f64 / 1e3;
        let (begin, end) = (number("begin_ns"), number("end_ns"));
        let name = told.texts.get("pass").cloned();
        if name.is_none() {
            let submitted = self.at(Instant::now()) - number("ago_ns");
            self.gpu_frame = submitted.max(self.gpu_end);
            self.gpu_end = self.gpu_frame + end;
            self.gpu_tracks.clear();
        }
        let mut track = 0;
        if name.is_some() {
            track = self.gpu_tracks.iter().position(|ended| *ended <= begin).unwrap_or(self.gpu_tracks.len());
            self.gpu_tracks.resize(self.gpu_tracks.len().max(track + 1), 0.0);
            self.gpu_tracks[track] = end;
        }
        let frame = told.numbers.get("frame").copied().unwrap_or_default();
        self.push(Slice {
            name: name.unwrap_or_else(|| format!("frame {frame}")),
            gpu: true,
            thread: 1 + track as u64,
            start: self.gpu_frame + begin,
            duration: end - begin,
            about: String::new(),
        });
    }

    /// The file.
    fn text(&self) -> String {
        let named = |what: &str, process: u32, thread: u64, name: &str| json!({ "ph": "M", "name": what, "pid": process, "tid": thread, "args": { "name": name } });
        let mut events = vec![
            named("process_name", 1, 0, "raxel (CPU)"),
            named("process_name", 2, 0, "GPU"),
            named("thread_name", 2, 1, "passes"),
        ];
        events.extend(self.threads.iter().map(|(thread, name)| named("thread_name", 1, *thread, name)));
        events.extend(self.slices.iter().map(|slice| {
            let mut event = json!({
                "ph": "X", "name": slice.name, "pid": if slice.gpu { 2 } else { 1 }, "tid": slice.thread,
                "ts": slice.start, "dur": slice.duration,
            });
            if !slice.about.is_empty() {
                event["args"] = json!({ "about": slice.about });
            }
            event
        }));
        json!({ "displayTimeUnit": "ms", "traceEvents": Value::Array(events) }).to_string()
    }
}

/// Hears spans and events.
struct TraceLayer {
    console: Console,
    level: LevelFilter,
    trace: Option<Arc<Mutex<Trace>>>,
}

/// The fields of a span, and the time since when it is entered.
struct Entered {
    fields: Fields,
    since: Option<Instant>,
}

impl<S: Subscriber + for<'l> LookupSpan<'l>> Layer<S> for TraceLayer {
    fn enabled(&self, metadata: &Metadata<'_>, _: Context<'_, S>) -> bool {
        metadata.target().starts_with("raxel") && *metadata.level() <= self.level
    }

    fn max_level_hint(&self) -> Option<LevelFilter> {
        Some(self.level)
    }

    fn on_new_span(&self, attributes: &span::Attributes<'_>, id: &span::Id, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        let mut fields = Fields::default();
        attributes.record(&mut fields);
        span.extensions_mut().insert(Entered { fields, since: None });
    }

    fn on_enter(&self, id: &span::Id, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        let mut extensions = span.extensions_mut();
        if let Some(entered) = extensions.get_mut::<Entered>() {
            entered.since = Some(Instant::now());
        }
    }

    fn on_exit(&self, id: &span::Id, context: Context<'_, S>) {
        let (Some(trace), Some(span)) = (&self.trace, context.span(id)) else { return };
        let mut extensions = span.extensions_mut();
        let Some(entered) = extensions.get_mut::<Entered>() else { return };
        let Some(since) = entered.since.take() else { return };
        let duration = since.elapsed();
        let about = entered.fields.line();
        let thread = thread();
        let mut trace = lock(trace);
        let start = trace.at(since);
        trace
            .threads
            .entry(thread)
            .or_insert_with(|| std::thread::current().name().map_or_else(|| format!("thread {thread}"), str::to_owned));
        let name = span.name().to_owned();
        trace.push(Slice { name, gpu: false, thread, start, duration: micros(duration), about });
    }

    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let mut fields = Fields::default();
        event.record(&mut fields);
        if event.metadata().target() == GPU {
            if let Some(trace) = &self.trace {
                lock(trace).gpu(&fields);
            }
        } else if event.metadata().target() == SLOW {
            if let Some(program) = self.console.program() {
                program.event(&fields.json());
            }
            let seconds = fields.numbers.get("seconds").copied().unwrap_or_default();
            if self.console.watched() || self.console.verbose() || seconds >= UNWATCHED {
                self.console.message(&fields.message);
            }
        } else if *event.metadata().level() <= Level::DEBUG {
            self.console.detail(&fields.line());
        }
    }
}

fn micros(duration: Duration) -> f64 {
    duration.as_nanos() as f64 / 1e3
}

/// A small number of this thread.
fn thread() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    thread_local!(static NUMBER: u64 = NEXT.fetch_add(1, Ordering::Relaxed));
    NUMBER.with(|number| *number)
}

/// The fields of a span or an event.
#[derive(Default)]
struct Fields {
    message: String,
    texts: BTreeMap<&'static str, String>,
    numbers: BTreeMap<&'static str, u64>,
}

impl Fields {
    /// As an object, without the message.
    fn json(&self) -> Value {
        let texts = self.texts.iter().map(|(name, text)| ((*name).to_owned(), json!(text)));
        let numbers = self.numbers.iter().map(|(name, number)| ((*name).to_owned(), json!(number)));
        texts.chain(numbers).collect::<serde_json::Map<_, _>>().into()
    }

    /// In one line.
    fn line(&self) -> String {
        let mut line = self.message.clone();
        let texts = self.texts.iter().map(|(name, text)| (name, text.clone()));
        for (name, value) in texts.chain(self.numbers.iter().map(|(name, number)| (name, number.to_string()))) {
            let _ = write!(line, "{}{name}={value}", if line.is_empty() { "" } else { " " });
        }
        line
    }
}

impl Visit for Fields {
    fn record_u64(&mut self, field: &Field, value: u64) {
        self.numbers.insert(field.name(), value);
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        self.texts.insert(field.name(), value.to_owned());
    }

    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        let text = format!("{value:?}");
        if field.name() == "message" {
            self.message = text;
        } else {
            self.texts.insert(field.name(), text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_the_gpu_follow_each_other_and_hold_their_passes() {
        let mut trace = Trace::default();
        let told = |pass: Option<&str>, [ago, begin, end]: [u64; 3]| Fields {
            texts: pass.map(|pass| ("pass", pass.to_owned())).into_iter().collect(),
            numbers: [("ago_ns", ago), ("begin_ns", begin), ("end_ns", end)].into_iter().collect(),
            ..Fields::default()
        };
        // Both were submitted at once; the second waits for the first. Its passes overlap.
        for begin in [3_000_000, 2_000_000] {
            trace.gpu(&told(None, [0, 0, 5_000_000]));
            trace.gpu(&told(Some("trace"), [0, 0, 3_000_000]));
            trace.gpu(&told(Some("shade"), [0, begin, 5_000_000]));
        }
        assert_eq!(trace.slices.iter().map(|slice| slice.thread).collect::<Vec<_>>(), [1, 1, 1, 1, 1, 2]);
        let end = |slice: &Slice| slice.start + slice.duration;
        for frame in trace.slices.chunks(3) {
            assert!(frame[1..].iter().all(|pass| pass.start >= frame[0].start && end(pass) <= end(&frame[0]) + 1e-6));
        }
        assert!(trace.slices[3].start >= end(&trace.slices[0]));
        let written: Value = serde_json::from_str(&trace.text()).unwrap();
        assert_eq!(written["traceEvents"].as_array().unwrap().len(), 3 + 6);
    }
}

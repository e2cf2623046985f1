//! The thread that rebuilds: it waits for finished edits, loads their dependents again, and creates all objects of a new plan while the old
//! one runs. Only a whole plan is handed over.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use raxel_diagnostics::Diagnostic;
use raxel_execute::{ExecuteError, Prepared};

use super::debounce::{Debounce, FileActivity};
use super::early::Early;
use super::event::{Failed, Rebuilt, Stages};
use super::project_state::{BuildSettings, ProjectFile, ProjectState};
use super::watch::{Notice, Tell, Watcher};
use crate::build::{self, DeviceContext, Selection};
use crate::build_error::BuildError;
use crate::load::Loader;
use crate::recording_files::{Content, content};

/// The delay of the report about a wrong edit: a file that is saved in pieces is wrong in between.
const HOLD: Duration = Duration::from_millis(120);

/// After this time the plan before an edit is usually gone, and the heaps that compiling has left are released.
const TIDY: Duration = Duration::from_secs(1);

/// A finished edit.
pub(crate) enum Outcome {
    /// Ready to be swapped in.
    Ready(Box<Ready>),
    /// Wrong.
    Failed(Failed),
}

/// Everything that a new plan needs.
pub(crate) struct Ready {
    /// Counts the edits.
    pub generation: u64,
    /// Files that changed.
    pub changed: Vec<String>,
    /// The parts that were built again.
    pub rebuilt: Rebuilt,
    /// The loaded files.
    pub state: ProjectState,
    /// The inputs of the plan.
    pub selection: Selection,
    /// The device that the plan was made for.
    pub context: DeviceContext,
    /// The plan with its resources.
    pub prepared: Prepared,
    /// When the edit was seen to be finished.
    pub since: Instant,
    /// The work since then.
    pub stages: Stages,
}

enum Message {
    FileChanged(String, FileActivity),
    FolderChanged,
    DeviceChanged,
    Open(ProjectFile),
    CheckBounds(bool),
    RecordWrites(bool),
    Stop,
}

/// A session's end of the thread.
pub(crate) struct Reloader {
    outcomes: Receiver<Outcome>,
    messages: Sender<Message>,
    settings: Arc<Mutex<BuildSettings>>,
    thread: Option<JoinHandle<()>>,
}

/// Called on the thread of the builder when a session has a finished edit to poll.
pub type Waker = Arc<dyn Fn() + Send + Sync>;

impl Reloader {
    /// Watches the files of `state` in the folder `root`.
    pub(crate) fn start(
        root: &std::path::Path,
        loader: Arc<Loader>,
        state: ProjectState,
        settings: BuildSettings,
        poll: bool,
        waker: Option<Waker>,
    ) -> std::io::Result<Self> {
        let (messages, inbox) = channel();
        let (sender, outcomes) = channel();
        let tell: Tell = {
            // `notify` calls from one thread; the lock makes the sender shareable all the same.
            let messages = Mutex::new(messages.clone());
            Arc::new(move |notice| {
                let message = match notice {
                    Notice::File(path, activity) => Message::FileChanged(path.to_owned(), activity),
                    Notice::Folder => Message::FolderChanged,
                };
                // The builder may have stopped already.
                let _ = messages.lock().unwrap_or_else(PoisonError::into_inner).send(message);
            })
        };
        let watcher = Watcher::new(root, poll, tell);
        let settings = Arc::new(Mutex::new(settings));
        let mut builder = Builder {
            loader,
            watcher,
            debounce: Debounce::default(),
            inbox,
            outcomes: sender,
            settings: settings.clone(),
            running: Vec::new(),
            state,
            generation: 0,
            changed: Vec::new(),
            rebuilt: Rebuilt::default(),
            load: 0.0,
            unfinished: None,
            without_device: None,
            held: None,
            tidy: None,
            early: Early::default(),
            waker,
        };
        builder.running = builder.shader_modules();
        builder.watch();
        let thread = std::thread::Builder::new().name("raxel-reload".to_owned()).spawn(move || builder.run())?;
        Ok(Self { outcomes, messages, settings, thread: Some(thread) })
    }

    /// Changes the settings of builds.
    pub(crate) fn set_settings(&self, settings: BuildSettings) {
        let mut current = self.settings.lock().unwrap_or_else(PoisonError::into_inner);
        let other_device = !Arc::ptr_eq(&current.context.memory, &settings.context.memory);
        *current = settings;
        drop(current);
        if other_device {
            // A builder that has stopped needs no device.
            let _ = self.messages.send(Message::DeviceChanged);
        }
    }

    /// Loads another file in place of the running one: an outcome as of an edit.
    pub(crate) fn open(&self, file: ProjectFile) {
        // A builder that has stopped opens nothing.
        let _ = self.messages.send(Message::Open(file));
    }

    /// Compiles all shaders again, with or without checks of the bounds of their accesses: an outcome as of an edit.
    pub(crate) fn check_bounds(&self, on: bool) {
        // A builder that has stopped compiles nothing.
        let _ = self.messages.send(Message::CheckBounds(on));
    }

    /// Compiles all shaders again, with or without records of their writes: an outcome as of an edit.
    pub(crate) fn record_writes(&self, on: bool) {
        // A builder that has stopped compiles nothing.
        let _ = self.messages.send(Message::RecordWrites(on));
    }

    /// The outcomes since the last call, oldest first.
    pub(crate) fn poll(&self) -> Vec<Outcome> {
        self.outcomes.try_iter().collect()
    }

    /// Waits for an outcome.
    pub(crate) fn wait(&self, timeout: Duration) -> Vec<Outcome> {
        let first = self.outcomes.recv_timeout(timeout);
        first.into_iter().chain(self.outcomes.try_iter()).collect()
    }
}

impl Drop for Reloader {
    fn drop(&mut self) {
        let _ = self.messages.send(Message::Stop);
        if let Some(thread) = self.thread.take() {
            // A panic of the thread was shown when it happened.
            let _ = thread.join();
        }
    }
}

struct Builder {
    loader: Arc<Loader>,
    watcher: Watcher,
    debounce: Debounce,
    inbox: Receiver<Message>,
    outcomes: Sender<Outcome>,
    settings: Arc<Mutex<BuildSettings>>,
    state: ProjectState,
    generation: u64,
    /// Files of edits that were not handed over yet.
    changed: Vec<String>,
    /// Rebuilt parts that do not run yet.
    rebuilt: Rebuilt,
    /// Modules of the last graph that was right: path and hash.
    running: Vec<(String, [u8; 32])>,
    /// Milliseconds that loading has taken for edits that were not handed over yet.
    load: f64,
    /// An edit that is loaded and not handed over yet, with the time at which it was seen to be finished.
    unfinished: Option<Instant>,
    /// An edit that is loaded and waits for another device, since the device was lost.
    without_device: Option<Instant>,
    /// A wrong edit that waits for the rest of it.
    held: Option<(Instant, Failed)>,
    /// The time at which freed memory is released.
    tidy: Option<Instant>,
    early: Early,
    waker: Option<Waker>,
}

impl Builder {
    fn run(mut self) {
        loop {
            let deadlines = [self.debounce.due(), self.held.as_ref().map(|(due, _)| *due), self.tidy];
            let wait = deadlines.into_iter().flatten().min().map(|due| due.saturating_duration_since(Instant::now()));
            let message = match wait {
                Some(wait) => self.inbox.recv_timeout(wait),
                None => self.inbox.recv().map_err(|_| RecvTimeoutError::Disconnected),
            };
            match message {
                Ok(message) => {
                    if !self.take(message) {
                        return;
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            let files = self.loader.files();
            let changed = self.debounce.changed(Instant::now(), |path| content(&files.read(path)));
            if !changed.is_empty() {
                self.held = None;
                self.without_device = None;
                self.unfinished = Some(Instant::now());
                self.load(changed);
            } else if self.unfinished.is_none() {
                self.early.compile(&self.debounce, &self.loader, &self.state.graph_path, &self.state.graph);
            }
            if let Some(since) = self.unfinished {
                match self.superseded() {
                    None => return,
                    // The newer edit is loaded first.
                    Some(true) => continue,
                    Some(false) => self.finish(since),
                }
            }
            if self.debounce.due().is_none()
                && self.held.as_ref().is_some_and(|(due, _)| *due <= Instant::now())
                && let Some((_, failed)) = self.held.take()
            {
                self.hand_over(Outcome::Failed(failed));
            }
            if self.tidy.is_some_and(|due| due <= Instant::now()) {
                self.tidy = None;
                raxel_gpu::trim_heaps();
            }
        }
    }

    /// Takes note of a message. False when it is time to stop.
    fn take(&mut self, message: Message) -> bool {
        match message {
            Message::FileChanged(path, activity) => self.debounce.touch(&path, activity, Instant::now()),
            Message::FolderChanged => self.watcher.renew(),
            Message::DeviceChanged => self.unfinished = self.unfinished.or(self.without_device.take()),
            Message::Open(file) => self.open(&file),
            Message::CheckBounds(on) => {
                let is_other = self.loader.checks_bounds() != on;
                self.compile_again(is_other, |loader| loader.check_bounds(on));
            }
            Message::RecordWrites(on) => {
                let is_other = self.loader.records_writes() != on;
                self.compile_again(is_other, |loader| loader.record_writes(on));
            }
            Message::Stop => return false,
        }
        true
    }

    /// Loads another file in place of the running one. Until it is right, edits of it are followed, and the old one runs on.
    fn open(&mut self, file: &ProjectFile) {
        let start = Instant::now();
        (self.held, self.without_device, self.unfinished) = (None, None, Some(start));
        self.state.open(file, &self.loader);
        self.rebuilt = Rebuilt { graph: true, world: true, demo: self.state.demo.is_some(), shaders: Vec::new() };
        self.changed = vec![file.path().to_owned()];
        self.load += milliseconds_since(start);
        self.watch();
    }

    /// Loads all graphs again for another way to make shaders.
    fn compile_again(&mut self, is_other: bool, change: impl FnOnce(&Loader)) {
        if !is_other {
            return;
        }
        let start = Instant::now();
        (self.held, self.without_device, self.unfinished) = (None, None, Some(start));
        change(&self.loader);
        self.state.graph = self.loader.graph(&self.state.graph_path);
        for (path, graph) in &mut self.state.other_graphs {
            *graph = self.loader.graph(path);
        }
        self.rebuilt.graph = true;
        self.load += milliseconds_since(start);
        self.watch();
    }

    /// Watches the files that the project depends on. A change before the watch began, or while it was read, is noticed too.
    fn watch(&mut self) {
        let files = self.state.files();
        let unsure =
            |(path, content): &(&String, &Content)| !self.debounce.matters(path) || **content == Content::Mixed;
        let new: Vec<String> = files.iter().filter(unsure).map(|(path, _)| path.clone()).collect();
        self.watcher.watch(files.keys().map(String::as_str));
        self.debounce.expect(files);
        for path in new {
            self.debounce.touch(&path, FileActivity::Finished, Instant::now());
        }
    }

    /// Whether a newer edit makes the build in flight pointless. `None` when it is time to stop.
    fn superseded(&mut self) -> Option<bool> {
        while let Ok(message) = self.inbox.try_recv() {
            if !self.take(message) {
                return None;
            }
        }
        let files = self.loader.files();
        Some(self.debounce.differs(|path| content(&files.read(path))))
    }

    /// Loads the dependents of the changed files.
    fn load(&mut self, changed: Vec<String>) {
        let start = Instant::now();
        let state = &mut self.state;
        if state.graph.depends_on(&changed) {
            state.graph = self.loader.graph(&state.graph_path);
            self.rebuilt.graph = true;
        }
        for (path, graph) in &mut state.other_graphs {
            if graph.depends_on(&changed) {
                *graph = self.loader.graph(path);
                self.rebuilt.graph = true;
            }
        }
        if let Some(path) = state.world_path.as_ref().filter(|_| state.world.depends_on(&changed)) {
            state.world = self.loader.world(path);
            self.rebuilt.world = true;
        }
        if let (Some(demo), Some(path)) = (&mut state.demo, &state.demo_path)
            && demo.depends_on(&changed)
        {
            *demo = self.loader.demo(path);
            self.rebuilt.demo = true;
            let followed = state.follow_demo(&self.loader);
            self.rebuilt.graph |= followed.graph;
            self.rebuilt.world |= followed.world;
        }
        for path in changed {
            if !self.changed.contains(&path) {
                self.changed.push(path);
            }
        }
        self.load += milliseconds_since(start);
        self.watch();
    }

    /// Hands over a plan, or holds the mistakes.
    fn finish(&mut self, since: Instant) {
        self.unfinished = None;
        self.generation += 1;
        self.tidy.get_or_insert(Instant::now() + TIDY);
        match self.assemble(since) {
            None => self.without_device = Some(since),
            Some(Outcome::Failed(failed)) => self.held = Some((Instant::now() + HOLD, failed)),
            Some(ready @ Outcome::Ready(_)) => {
                self.running = self.shader_modules();
                self.hand_over(ready);
            }
        }
    }

    /// Plans and creates the objects of the files, if they are right. `None` when the device is lost: it is no fault of the edit.
    fn assemble(&mut self, since: Instant) -> Option<Outcome> {
        let settings = self.settings.lock().unwrap_or_else(PoisonError::into_inner).clone();
        // A graph that the demo no longer has runs no longer.
        self.state.change_graph(&settings.graph_path);
        let changed = std::mem::take(&mut self.changed);
        let generation = self.generation;
        let (diagnostics, texts) = self.state.diagnostics();
        let failed = |diagnostics, texts| {
            Some(Outcome::Failed(Failed { generation, changed: changed.clone(), diagnostics, texts }))
        };
        let (graph, world) = match (&self.state.graph.result, &self.state.world.result) {
            (Ok(graph), Ok(world)) if !diagnostics.iter().any(Diagnostic::is_error) => (graph.clone(), world.clone()),
            _ => return failed(diagnostics, texts),
        };
        let selection = settings.selection(&self.state.graph_path, &graph, &world);
        let start = Instant::now();
        let mut stages = Stages { load: std::mem::take(&mut self.load), ..Stages::default() };
        let built = build::assemble(&graph, &world, &selection, &settings.context).and_then(|assembly| {
            stages.plan = milliseconds_since(start);
            let start = Instant::now();
            let prepared = build::prepare(&assembly, &settings.context);
            stages.prepare = milliseconds_since(start);
            prepared
        });
        let prepared = match built {
            Ok(prepared) => prepared,
            Err(BuildError::Device(ExecuteError::DeviceLost { .. })) => {
                self.changed = changed;
                return None;
            }
            Err(error) => return failed(error.into_diagnostics(), texts),
        };
        let mut rebuilt = std::mem::take(&mut self.rebuilt);
        rebuilt.shaders =
            self.shader_modules().into_iter().filter(|key| !self.running.contains(key)).map(|key| key.0).collect();
        rebuilt.shaders.dedup();
        Some(Outcome::Ready(Box::new(Ready {
            generation,
            changed,
            rebuilt,
            state: self.state.clone(),
            selection,
            context: settings.context,
            prepared,
            since,
            stages,
        })))
    }

    fn shader_modules(&self) -> Vec<(String, [u8; 32])> {
        let Ok(graph) = &self.state.graph.result else { return self.running.clone() };
        let mut keys: Vec<_> =
            graph.passes.iter().map(|pass| (pass.shader.request.path.clone(), pass.shader.module)).collect();
        keys.sort();
        keys.dedup();
        keys
    }

    fn hand_over(&mut self, outcome: Outcome) {
        // The session may be gone; then there is no receiver.
        let _ = self.outcomes.send(outcome);
        if let Some(waker) = &self.waker {
            waker();
        }
    }
}

fn milliseconds_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

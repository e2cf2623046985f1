//! The window: winit's events drive a session, and its frames are presented. Messages go to stderr.

mod args;
mod controls;
mod dig;
mod reload_log;
mod title;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use raxel_diagnostics::SourceMap;
use raxel_gpu::{DeviceKind, DeviceOptions};
use raxel_graph::checked::{BufferSize, ResourceKind};
use raxel_runtime::camera::FlyInput;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::execute::Progress;
use raxel_runtime::present::{PresentError, Presented, Presenter};
use raxel_runtime::{EditFailure, FrameError, Saves, Session};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::error::EventLoopError;
use winit::event::{ElementState, MouseButton, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::ModifiersState;
use winit::window::{Window, WindowId};

pub(crate) use self::args::Args;
pub(crate) use self::controls::KEYS;
use self::controls::{Command, Controls};
use self::reload_log::ReloadLog;
use self::title::Title;
use crate::console::{Console, To};
use crate::control::{Control, Drive, Next};
use crate::failure::{Exit, Failure, Result};
use crate::output::{self, Pending, shown};
use crate::session::{frame_failure, print_validation, validated};

/// Wakes the window: an edit is ready.
#[derive(Clone, Copy, Debug)]
struct Wake;

/// Time between two titles.
const TITLE_EVERY: Duration = Duration::from_millis(250);

/// Time between two looks at a picture that does not change.
const STILL: Duration = Duration::from_millis(15);

/// Longest wait for the device between two looks at the window's events.
const SLICE: Duration = Duration::from_millis(8);

/// The device may work so long before the pass that it works on is named.
const PATIENCE: Duration = Duration::from_secs(2);

/// Runs a window until it is closed.
pub(crate) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    let event_loop = EventLoop::<Wake>::with_user_event().build().map_err(|error| no_window(&error))?;
    let proxy = event_loop.create_proxy();
    let waker = proxy.clone();
    let mut options = args.what.options(device)?;
    options.size = args.size.0;
    options.scale = args.scale;
    options.step = None;
    options.watch = true;
    options.saves = Saves::Write;
    options.poll = args.poll;
    options.waker = Some(Arc::new(move || {
        // Without a window there is nobody to wake.
        let _ = proxy.send_event(Wake);
    }));
    let session = args.what.open(options, console)?;
    console.message(&format!(
        "{} on {}; Escape quits, `raxel run --help` lists the keys",
        session.graph_path(),
        device_name(&session)
    ));

    let control = args.control.then(|| {
        Control::listen(Drive::Window, move || {
            let _ = waker.send_event(Wake);
        })
    });
    let mut viewer = Viewer {
        args,
        control,
        console,
        reloads: ReloadLog::new(console),
        session,
        window: None,
        controls: Controls::default(),
        ball: dig::Ball::default(),
        modifiers: ModifiersState::empty(),
        titled: None,
        last: Instant::now(),
        frame_time: None,
        unshown: false,
        busy: None,
        presented: 0,
        complained: false,
        failure: None,
    };
    event_loop.run_app(&mut viewer).map_err(|error| no_window(&error))?;
    viewer.complained |= print_validation(&viewer.session, console);
    // A dispatch that does not end must not keep the program.
    if !matches!(viewer.session.wait_picture(SLICE), Ok(Progress::Done)) {
        viewer.session.abandon_device();
    }
    match viewer.failure.take() {
        Some(failure) => Err(failure),
        None => validated(viewer.complained),
    }
}

fn device_name(session: &Session) -> String {
    session.device().capabilities().name.clone()
}

fn no_window(error: &EventLoopError) -> Failure {
    // winit says where in its own sources it gave up, which helps nobody here: `os error at FILE:LINE: WHY`.
    let text = error.to_string();
    let why =
        text.strip_prefix("os error at ").and_then(|rest| rest.split_once(": ")).map_or(text.as_str(), |(_, why)| why);
    Failure::new(Exit::NoDevice, format!("no window can be opened: {why}"))
        .help("set DISPLAY or WAYLAND_DISPLAY (a desktop, or ssh -X)")
        .help("`raxel render -o p.png` needs no window")
}

/// An open window with what it is drawn on.
struct Open {
    window: Arc<Window>,
    presenter: Presenter,
}

struct Viewer<'a> {
    args: &'a Args,
    /// A program that drives the session too.
    control: Option<Control>,
    console: &'a Console,
    reloads: ReloadLog<'a>,
    session: Session,
    window: Option<Open>,
    controls: Controls,
    /// What the right button digs and places.
    ball: dig::Ball,
    modifiers: ModifiersState,
    titled: Option<Instant>,
    last: Instant,
    /// Seconds of a frame, smoothed.
    frame_time: Option<f64>,
    /// The picture of the last frame was not shown yet.
    unshown: bool,
    /// The device has worked for long: on which pass, and since how many seconds.
    busy: Option<(Option<String>, u64)>,
    presented: u64,
    complained: bool,
    failure: Option<Failure>,
}

impl ApplicationHandler<Wake> for Viewer<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.window.is_none()
            && let Err(failure) = self.open(event_loop)
        {
            self.stop(event_loop, failure);
        }
    }

    fn suspended(&mut self, _: &ActiveEventLoop) {
        self.window = None;
    }

    fn user_event(&mut self, _: &ActiveEventLoop, Wake: Wake) {
        self.redraw();
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => self.resize(size),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, .. } => {
                let pressed = event.state == ElementState::Pressed;
                let command =
                    self.controls.key(event.physical_key, &event.logical_key, self.modifiers, pressed, event.repeat);
                if let Some(command) = command {
                    self.run_command(command, event_loop);
                }
                self.redraw();
            }
            WindowEvent::MouseInput { state, button: MouseButton::Left, .. } => {
                self.controls.drag(state == ElementState::Pressed);
            }
            WindowEvent::MouseInput { state: ElementState::Pressed, button: MouseButton::Right, .. } => {
                let place = self.modifiers.shift_key();
                self.dig(if place { dig::Action::Place } else { dig::Action::Dig });
                self.redraw();
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.controls.cursor_moved([position.x, position.y]);
                self.redraw();
            }
            WindowEvent::CursorLeft { .. } => self.controls.cursor_left(),
            WindowEvent::Focused(false) => self.controls.release_all(),
            WindowEvent::RedrawRequested => {
                if let Err(failure) = self.draw(event_loop) {
                    self.stop(event_loop, failure);
                }
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        // Minimised, nothing is drawn until something happens.
        let drawn = self.window.as_ref().is_some_and(|open| open.presenter.extent().is_some());
        if !drawn {
            event_loop.set_control_flow(ControlFlow::Wait);
        }
        if let ControlFlow::WaitUntil(time) = event_loop.control_flow()
            && Instant::now() < time
        {
            return;
        }
        if drawn {
            self.redraw();
        }
    }
}

impl Viewer<'_> {
    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result {
        let [width, height] = self.args.size.0;
        let attributes = Window::default_attributes()
            .with_title(self.title().text())
            .with_inner_size(PhysicalSize::new(width, height))
            .with_min_inner_size(PhysicalSize::new(64, 64));
        let window = event_loop.create_window(attributes).map_err(|error| {
            Failure::new(Exit::NoDevice, format!("no window can be opened: {error}"))
                .help("`raxel render -o p.png` needs no window")
        })?;
        let window = Arc::new(window);
        let presenter = self.presenter(&window)?;
        let size = window.inner_size();
        self.session.resize(size.width, size.height);
        self.window = Some(Open { window, presenter });
        self.last = Instant::now();
        self.redraw();
        Ok(())
    }

    fn presenter(&self, window: &Arc<Window>) -> Result<Presenter> {
        let size = window.inner_size();
        let vsync = !self.args.no_vsync;
        Ok(Presenter::new(self.session.device(), window.clone(), [size.width, size.height], vsync)?)
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        if let Some(open) = &mut self.window {
            open.presenter.resize([size.width, size.height]);
        }
        self.session.resize(size.width, size.height);
        self.redraw();
    }

    fn redraw(&self) {
        if let Some(open) = &self.window {
            open.window.request_redraw();
        }
    }

    fn stop(&mut self, event_loop: &ActiveEventLoop, failure: Failure) {
        self.failure.get_or_insert(failure);
        event_loop.exit();
    }

    /// One frame: edits, motion, the picture, the title. Never waits for the device for longer than a [`SLICE`]: events are looked at in
    /// between, so that the window can be left and an edit taken in whatever the device does.
    fn draw(&mut self, event_loop: &ActiveEventLoop) -> Result {
        for event in self.session.poll_reload() {
            self.reloads.tell(&event);
            if let Some(control) = &mut self.control {
                control.note(&event);
            }
            self.titled = None;
        }
        if let Some(control) = &mut self.control
            && control.poll(&mut self.session) == Next::Quit
        {
            event_loop.exit();
            return Ok(());
        }
        event_loop.set_control_flow(ControlFlow::Poll);
        if self.window.is_none() {
            return Ok(());
        }
        if self.unshown && !self.show(event_loop)? {
            return Ok(());
        }
        let progress = self.session.wait_next(SLICE);
        if !self.is_done(progress)? {
            return Ok(());
        }
        self.fly();
        let report = match self.session.frame() {
            Ok(report) => report,
            // Said once; what ran before runs on.
            Err(error @ FrameError::Plan { .. }) => {
                self.reloads.refused(&error);
                self.titled = None;
                return Ok(());
            }
            Err(error) => return Err(frame_failure(error, self.console)),
        };
        self.complained |= print_validation(&self.session, self.console);
        let said = self.session.take_save_messages();
        self.console.diagnostics(&said, &SourceMap::default(), To::Stderr);
        self.unshown = true;
        if self.show(event_loop)? && !report.displayed && report.dispatched == 0 {
            event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + STILL));
        }
        Ok(())
    }

    /// Shows the picture of the last frame. False when it could not be shown yet.
    fn show(&mut self, event_loop: &ActiveEventLoop) -> Result<bool> {
        // A driver that computes on the processor waits for the picture when it presents it, without a limit.
        if self.session.device().capabilities().kind == DeviceKind::Cpu {
            let progress = self.session.wait_picture(SLICE);
            if !self.is_done(progress)? {
                return Ok(false);
            }
        }
        let (Some(open), Some(picture)) = (&mut self.window, self.session.picture()) else { return Ok(true) };
        if open.presenter.device().id() != self.session.device().id() {
            let window = open.window.clone();
            // The old surface belongs to the lost device; it goes before a new one is made for the same window.
            self.window = None;
            let presenter = self.presenter(&window)?;
            self.window = Some(Open { window, presenter });
            return Ok(false);
        }
        match open.presenter.present(&picture, None) {
            Ok(Presented::Shown) => {
                self.presented += 1;
                if self.args.frames.is_some_and(|frames| self.presented >= frames) {
                    event_loop.exit();
                }
            }
            Ok(Presented::NoArea) => {}
            Ok(Presented::OutOfDate | Presented::NotReady) => return Ok(false),
            // The next frame finds the loss, and opens the device anew.
            Err(error) if error.is_device_lost() => {}
            Err(error) => return Err(error.into()),
        }
        self.unshown = false;
        self.update_title();
        Ok(true)
    }

    /// Whether the device has finished what was waited for. Says once what it works on when that takes long.
    fn is_done(&mut self, progress: std::result::Result<Progress, FrameError>) -> Result<bool> {
        match progress.map_err(|error| frame_failure(error, self.console))? {
            Progress::Done => {
                self.titled = self.titled.filter(|_| self.busy.is_none());
                self.busy = None;
                Ok(true)
            }
            Progress::Working { pass, elapsed } => {
                if elapsed >= PATIENCE {
                    if self.busy.is_none() {
                        let on = pass.as_ref().map_or_else(String::new, |pass| format!(" on pass `{pass}`"));
                        let seconds = elapsed.as_secs();
                        self.console.message(&format!(
                            "the device has worked{on} for {seconds} s; Escape quits, an edit is taken"
                        ));
                    }
                    self.busy = Some((pass, elapsed.as_secs()));
                    self.update_title();
                }
                Ok(false)
            }
        }
    }

    /// Moves the camera as keys and mouse ask. The first gesture takes over from a demo.
    fn fly(&mut self) {
        let now = Instant::now();
        let seconds = (now - self.last).as_secs_f64();
        self.last = now;
        let smoothed = self.frame_time.map_or(seconds, |old| old * 0.9 + seconds * 0.1);
        self.frame_time = Some(smoothed);
        self.session.set_cursor(self.controls.cursor());
        let (input, speed) = self.controls.fly();
        if input == FlyInput::default() {
            return;
        }
        self.session.take_over();
        let mut camera = *self.session.camera();
        camera.fly(&input, &speed, seconds.min(0.25));
        self.session.set_camera(camera);
    }

    fn run_command(&mut self, command: Command, event_loop: &ActiveEventLoop) {
        self.titled = None;
        match command {
            Command::NextTarget => self.cycle(1),
            Command::PreviousTarget => self.cycle(-1),
            Command::Pause => self.session.pause(!self.session.clock().paused()),
            Command::Step => {
                self.session.pause(true);
                self.session.step();
            }
            Command::Reset => {
                self.session.reset();
                self.session.hand_back();
            }
            Command::Undo => self.edited(|session| session.undo().map(drop)),
            Command::Redo => self.edited(|session| session.redo().map(drop)),
            Command::Larger => self.choose(|ball, _| ball.resize(1)),
            Command::Smaller => self.choose(|ball, _| ball.resize(-1)),
            Command::NextMaterial => self.choose(dig::Ball::next_material),
            Command::Screenshot => match self.screenshot() {
                Ok(path) => self.console.message(&format!("wrote {}", shown(&path))),
                Err(failure) => self.console.failure(&failure),
            },
            Command::Quit => event_loop.exit(),
        }
    }

    /// Digs or places a ball at the cursor.
    fn dig(&mut self, action: dig::Action) {
        let edit = self.controls.cursor().and_then(|pixel| self.ball.edit(action, &self.session, pixel));
        if let Some(edit) = edit {
            self.edited(|session| session.edit(&[edit]).map(drop));
        }
    }

    /// Edits the world, and says why when that is refused.
    fn edited(&mut self, edit: impl FnOnce(&mut Session) -> std::result::Result<(), EditFailure>) {
        if let Err(failure) = edit(&mut self.session) {
            self.console.diagnostics(&failure.into_diagnostics(), &SourceMap::default(), To::Stderr);
        }
    }

    /// Chooses another ball, and says which.
    fn choose(&mut self, change: impl FnOnce(&mut dig::Ball, usize)) {
        change(&mut self.ball, self.session.scene().materials.len());
        self.console.message(&self.ball.text(&self.session));
    }

    /// Shows the resource so many places after this one, in the order of the file.
    fn cycle(&mut self, by: isize) {
        let graph = self.session.graph();
        let names: Vec<String> = graph
            .resources
            .iter()
            // A world's buffer is no picture.
            .filter(|resource| !matches!(&resource.kind, ResourceKind::Buffer(b) if matches!(b.size, BufferSize::Source(_))))
            .map(|resource| resource.name.clone())
            .collect();
        let now = self.target();
        let at = names.iter().position(|name| *name == now).unwrap_or(0) as isize;
        if let Some(name) = names.get((at + by).rem_euclid(names.len().max(1) as isize) as usize) {
            self.select(DebugTarget::resource(name.clone()));
        }
    }

    fn select(&mut self, target: DebugTarget) {
        if let Err(error) = self.session.set_debug_target(target) {
            self.console.message(&format!("warning: {error}"));
        }
    }

    /// Name of the resource shown.
    fn target(&self) -> String {
        let selected = self.session.debug_target();
        let graph = self.session.graph();
        if selected.resource.is_empty() {
            graph.resource(graph.present).name.clone()
        } else {
            selected.resource.clone()
        }
    }

    /// Writes what is shown to a PNG in the current folder that does not exist yet.
    fn screenshot(&mut self) -> Result<PathBuf> {
        let picture = self.session.read_presented()?;
        let frame = self.session.clock().now().map_or(0, |time| time.index);
        let name = format!("{}-{}-{frame:05}", self.session.graph().name, self.target());
        let name: String =
            name.chars().map(|c| if c.is_alphanumeric() || "-_@".contains(c) { c } else { '_' }).collect();
        let path = (1..10_000)
            .map(|n| PathBuf::from(if n == 1 { format!("{name}.png") } else { format!("{name}-{n}.png") }))
            .find(|path| !path.exists())
            .unwrap_or_default();
        output::write_picture(Pending::new(&path)?, &picture)?;
        Ok(path)
    }

    fn title(&self) -> Title {
        Title {
            graph: self.session.graph().name.clone(),
            target: match self.session.debug_target() {
                selected if selected.resource.is_empty() => self.target(),
                selected => selected.to_string(),
            },
            milliseconds: self.frame_time.map(|seconds| seconds * 1e3),
            paused: self.session.clock().paused(),
            generation: self.reloads.shown,
            failed: self.reloads.failed,
            refused: self.session.is_refused(),
            busy: self.busy.clone(),
            caption: self.caption(),
        }
    }

    /// What the demo says at this moment, while it drives.
    fn caption(&self) -> Option<String> {
        let demo = self.session.demo().filter(|_| self.session.demo_drives())?;
        demo.caption(self.session.clock().now()?.time).map(|line| line.text.clone())
    }

    fn update_title(&mut self) {
        if self.titled.is_some_and(|at| at.elapsed() < TITLE_EVERY) {
            return;
        }
        self.titled = Some(Instant::now());
        if let Some(open) = &self.window {
            open.window.set_title(&self.title().text());
        }
    }
}

impl From<PresentError> for Failure {
    fn from(error: PresentError) -> Self {
        match error {
            PresentError::Gpu(error) => error.into(),
            error @ PresentError::Shader(_) => Failure::new(Exit::NoDevice, error.to_string()),
        }
    }
}

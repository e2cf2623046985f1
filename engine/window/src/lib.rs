//! The window: winit's events drive a session, and its frames are presented. Messages go to stderr.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod args;
mod brush;
mod commands;
mod comparing;
mod controls;
mod described;
mod editor;
mod elements;
mod finding;
mod frame;
mod gamepad;
mod given;
mod hidden;
mod history;
mod hosting;
pub mod inspector;
mod layout_file;
mod locate;
mod looking;
pub mod lost_display;
mod magnifier;
mod microphone;
mod numbers;
mod outline;
mod overlay;
mod panel_data;
mod pins;
mod presenting;
mod preset_list;
mod problem_log;
mod reload_log;
mod switching;
mod texel_history;
mod title;
mod undoing;
mod waiting;
mod worker;
mod writing;

use std::sync::Arc;
use std::time::{Duration, Instant};

use raxel_diagnostics::Severity;
use raxel_gpu::DeviceOptions;
use raxel_graph::checked::Value;
use raxel_panels::view::{Brush, Busy, Problem};
use raxel_panels::{Layout, Panels};
use raxel_runtime::camera::Camera;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::present::Place;
use raxel_runtime::reload::Waker;
use raxel_runtime::{ManifestDefaults, Observe, Options, Saves, Session};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::error::EventLoopError;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::ModifiersState;
use winit::window::{Window, WindowId};

pub use self::args::Args;
use self::comparing::Comparing;
use self::controls::Controls;
pub use self::controls::KEYS;
use self::editor::Editors;
use self::gamepad::Gamepads;
use self::hidden::Redraws;
use self::history::History;
use self::inspector::Inspector;
use self::layout_file::LayoutFile;
use self::magnifier::Magnifier;
use self::microphone::Capture;
use self::panel_data::PanelData;
use self::presenting::{Open, Pictures, Refusals};
use self::reload_log::ReloadLog;
use self::switching::Files;
use self::title::Title;
use self::writing::{Ending, Writings};
use raxel_control::{Control, Drive};
use raxel_terminal::console::Console;
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::prints::PrintLog;
use raxel_terminal::session::{open_failure, print_log, print_validation, validated};
use raxel_workbench::presets::Presets;
use raxel_workbench::recording::Recorder;
use raxel_workbench::{demo_keys, write_back};

/// Wakes the window: an edit is ready.
#[derive(Clone, Copy, Debug)]
struct Wake;

/// Time between two titles.
const TITLE_EVERY: Duration = Duration::from_millis(250);

/// Time between two looks at a picture that does not change.
const STILL: Duration = Duration::from_millis(15);

/// Time between two looks at panels over a picture that does not change, while nothing is done to them.
const REFRESH: Duration = Duration::from_millis(250);

/// Time between two drawings of the panels while the device works: they must not take the processor from a device that computes on it.
const MEANWHILE: Duration = Duration::from_millis(50);

/// The ground of a window that has no picture yet, sRGB-encoded.
const GROUND: [f32; 3] = [0.078, 0.078, 0.078];

/// Time without a motion of the camera after which the next one is another flight, for undo.
const LANDED: Duration = Duration::from_millis(500);

/// Longest wait for the device between two looks at the window's events.
const SLICE: Duration = Duration::from_millis(8);

/// The device may work so long before the pass that it works on is named.
const PATIENCE: Duration = Duration::from_secs(2);

/// The same before the first picture: a driver may still compile then, and that is no reason to give a pass up.
const PATIENCE_AT_FIRST: Duration = Duration::from_secs(8);

/// A pass whose shader was edited while the device worked on it for longer than this is abandoned: reopening the device takes about a
/// second, and the picture of that frame is not needed any more.
const MENDED: Duration = Duration::from_secs(5);

/// Runs a window until it is closed.
pub fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    let event_loop = EventLoop::<Wake>::with_user_event().build().map_err(|error| no_window(&error))?;
    let proxy = event_loop.create_proxy();
    let waker = Arc::new(move || {
        // Without a window there is no event loop to wake.
        let _ = proxy.send_event(Wake);
    });
    lost_display::watch(console);
    let mut viewer = Viewer::open(args, console, device, waker)?;
    event_loop.run_app(&mut viewer).map_err(|error| lost_display::failure(&error.to_string()))?;
    viewer.finish()
}

/// The options of a window's session. If its files have mistakes, it waits until they are mended, unless it runs a fixed number of frames.
fn options(args: &Args, device: &DeviceOptions, waker: Waker) -> Result<Options> {
    let options = args.what.options(device)?;
    Ok(Options {
        size: args.first_size(),
        scale: args.scale.unwrap_or(options.scale),
        manifest: Some(ManifestDefaults { demo: true, size: args.size.is_none(), scale: args.scale.is_none() }),
        step: None,
        // A program may read anything.
        observe: if args.control { Observe::Everything } else { options.observe },
        wait: args.frames.is_none(),
        watch: true,
        unused: Severity::Warning,
        saves: Saves::Write,
        poll: args.poll,
        waker: Some(waker),
        ..options
    })
}

fn device_name(session: &Session) -> String {
    session.device().capabilities().name.clone()
}

fn no_window(error: &EventLoopError) -> Failure {
    // winit adds the place in its own sources, which helps no user: `os error at FILE:LINE: WHY`.
    let text = error.to_string();
    let why =
        text.strip_prefix("os error at ").and_then(|rest| rest.split_once(": ")).map_or(text.as_str(), |(_, why)| why);
    Failure::new(Exit::NoDevice, format!("no window can be opened: {why}"))
        .help("set DISPLAY or WAYLAND_DISPLAY (a desktop, or ssh -X)")
        .help("`raxel render -o p.png` needs no window")
}

fn new_window(event_loop: &ActiveEventLoop, [width, height]: [u32; 2], title: String) -> Result<Arc<Window>> {
    let attributes = Window::default_attributes()
        .with_title(title)
        .with_inner_size(PhysicalSize::new(width, height))
        .with_min_inner_size(PhysicalSize::new(64, 64));
    let window = event_loop.create_window(attributes).map_err(|error| {
        Failure::new(Exit::NoDevice, format!("no window can be opened: {error}"))
            .help("`raxel render -o p.png` needs no window")
    })?;
    Ok(Arc::new(window))
}

/// How the next frame runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum NextFrame {
    /// As any other.
    #[default]
    Plain,
    /// Captured by RenderDoc.
    Captured,
}

/// The background of a window before the first picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Ground {
    /// Nothing: it is as the window system has made it.
    #[default]
    Unshown,
    /// The panels over one colour.
    Shown,
}

/// Who has mouse and keyboard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Holder {
    /// The window acts on them, and the graph reads them.
    #[default]
    Both,
    /// The graph alone.
    Graph,
}

/// Where the picture is in the window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Placed {
    /// Its place, if it does not fill the window.
    place: Option<Place>,
    /// The output has the extent of another place.
    outgrown: bool,
}

struct Viewer<'a> {
    args: &'a Args,
    /// A program that drives the session too.
    control: Option<Control>,
    console: &'a Console,
    reloads: ReloadLog<'a>,
    session: Session,
    window: Option<Open>,
    panels: Panels,
    layout_file: LayoutFile,
    presets: Presets,
    data: PanelData,
    inspector: Inspector,
    /// Which part of the picture fills the window.
    magnifier: Magnifier,
    comparing: Comparing,
    /// Files that are being written.
    writings: Writings,
    problems: Vec<Problem>,
    /// Files of the project, as they were listed last.
    files: Files,
    printed: PrintLog,
    /// Said in the bar until then.
    notice: Option<(String, Instant)>,
    /// The shown target before the pointer came to rest on a pass.
    before_peek: Option<DebugTarget>,
    /// Params and values that were written to a file that was not read again yet.
    written: Vec<(String, Value)>,
    /// The window's own changes, for undo.
    history: History,
    /// Makes keys of params that are moved.
    recorder: Recorder,
    /// Editors that were opened.
    editors: Editors,
    /// Whether the demo starts over, if the user has chosen.
    looped: Option<bool>,
    /// How the next frame runs.
    next_runs: NextFrame,
    /// Most frames a second.
    fps_cap: Option<u32>,
    /// Where the camera began.
    home: Camera,
    /// When the user moved it last.
    flown: Instant,
    controls: Controls,
    holder: Holder,
    placed: Placed,
    redraws: Redraws,
    gamepads: Gamepads,
    capture: Capture,
    /// The effect of the right button on voxels.
    brush: Brush,
    /// Why the last edit was not made.
    refused: Option<String>,
    /// The voxel that was painted last while the right button is held.
    painting: Option<[i32; 3]>,
    modifiers: ModifiersState,
    titled: Option<Instant>,
    last: Instant,
    /// Seconds of a frame, smoothed.
    frame_time: Option<f64>,
    /// Something has happened since the panels were drawn last.
    touched: bool,
    /// When they were.
    drawn: Instant,
    /// The picture of the last frame was not shown yet.
    unshown: bool,
    /// Pictures that the window did not take.
    refusals: Refusals,
    /// The device has worked for long.
    busy: Option<Busy>,
    /// So it has in this frame, and in the one before.
    long: [bool; 2],
    presented: u64,
    /// The background before the first picture.
    ground: Ground,
    complained: bool,
    failure: Option<Failure>,
}

impl ApplicationHandler<Wake> for Viewer<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.window.is_none()
            && let Err(failure) = self.open_window(event_loop)
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
        if matches!(event, WindowEvent::RedrawRequested) {
            self.redraws.came();
        }
        if self.session.is_waiting() {
            return self.waiting_event(event_loop, &event);
        }
        self.touched |= !matches!(event, WindowEvent::RedrawRequested);
        let visible = self.panels.are_drawn();
        let taken = match &mut self.window {
            Some(Open { window, overlay, .. }) => overlay.take(window, &event) && visible,
            None => false,
        };
        let by_pointer = matches!(event, WindowEvent::MouseInput { .. } | WindowEvent::MouseWheel { .. });
        let taken = if by_pointer { self.is_over_panels() } else { taken };
        given::note(self.session.inputs(), &event, taken);
        // An input of the graph alone moves no camera, edits no world, and is no command.
        let taken = taken || self.holder == Holder::Graph;
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => self.resize(size),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, .. } => {
                let pressed = event.state == ElementState::Pressed;
                if taken && pressed && !(self.holder == Holder::Graph && given::is_windows(event.physical_key)) {
                    return self.redraw();
                }
                let command =
                    self.controls.key(event.physical_key, &event.logical_key, self.modifiers, pressed, event.repeat);
                if let Some(command) = command {
                    self.run_command(command, event_loop);
                }
                self.redraw();
            }
            WindowEvent::MouseInput { state, button: MouseButton::Left, .. } => {
                let pressed = state == ElementState::Pressed && !taken;
                let held = self.hold_wipe(pressed);
                self.controls.drag(pressed && !held);
                self.redraw();
            }
            WindowEvent::MouseWheel { delta, .. } if !taken => {
                let lines = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / 50.0,
                };
                if self.wheel_magnifies() {
                    self.magnify(lines);
                } else {
                    self.controls.wheel(lines);
                    self.notice(self.controls.speed_text());
                }
                self.redraw();
            }
            WindowEvent::MouseInput { state: ElementState::Pressed, button: MouseButton::Right, .. } if !taken => {
                self.stroke();
                self.redraw();
            }
            WindowEvent::MouseInput { state: ElementState::Released, button: MouseButton::Right, .. } => {
                self.painting = None;
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.controls.cursor_moved([position.x, position.y]);
                if self.painting.is_some() {
                    self.stroke();
                }
                if let Some([x, _]) = self.controls.on_picture() {
                    self.comparing.drag_edge(x, self.session.viewport().window()[0]);
                }
                self.redraw();
            }
            WindowEvent::CursorLeft { .. } => self.controls.cursor_left(),
            WindowEvent::Focused(false) => {
                self.controls.release_all();
                self.painting = None;
                self.comparing.release_edge();
            }
            WindowEvent::RedrawRequested => {
                if let Err(failure) = self.draw(event_loop) {
                    self.stop(event_loop, failure);
                }
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if let ControlFlow::WaitUntil(time) = event_loop.control_flow()
            && Instant::now() < time
        {
            return;
        }
        if self.is_hidden() {
            self.go_on_hidden(event_loop);
        } else {
            self.redraw();
        }
    }
}

impl<'a> Viewer<'a> {
    /// Opens a session that is not shown yet.
    fn open(args: &'a Args, console: &'a Console, device: &DeviceOptions, waker: Waker) -> Result<Self> {
        let control = console.program().map(|program| {
            let waker = waker.clone();
            Control::listen(Drive::Window, program.clone(), move || waker())
        });
        let session = Session::open(options(args, device, waker)?).map_err(|error| open_failure(error, console))?;
        let mut viewer = Viewer {
            args,
            control,
            console,
            reloads: ReloadLog::new(console),
            home: *session.camera(),
            flown: Instant::now(),
            problems: Vec::new(),
            files: Files::default(),
            printed: PrintLog::default(),
            layout_file: LayoutFile::of(session.project().root()),
            presets: Presets::of(session.project().root()),
            session,
            panels: Panels::default(),
            data: PanelData::default(),
            inspector: Inspector::default(),
            magnifier: Magnifier::default(),
            comparing: Comparing::default(),
            writings: Writings::default(),
            notice: None,
            before_peek: None,
            written: Vec::new(),
            history: History::default(),
            recorder: Recorder::default(),
            editors: Editors::default(),
            looped: None,
            next_runs: NextFrame::default(),
            fps_cap: None,
            window: None,
            controls: Controls::default(),
            holder: Holder::default(),
            placed: Placed::default(),
            redraws: Redraws::default(),
            gamepads: Gamepads::default(),
            capture: Capture::default(),
            brush: Brush::default(),
            refused: None,
            painting: None,
            modifiers: ModifiersState::empty(),
            titled: None,
            last: Instant::now(),
            frame_time: None,
            touched: true,
            drawn: Instant::now(),
            unshown: false,
            refusals: Refusals::default(),
            busy: None,
            long: [false; 2],
            presented: 0,
            ground: Ground::default(),
            complained: false,
            failure: None,
        };
        if viewer.session.is_waiting() {
            viewer.take_events()?;
            console.message("the window waits for the files to be mended");
        } else {
            viewer.begin()?;
        }
        Ok(viewer)
    }

    /// The session runs from here on: the command line's options are applied, and the files kept for its project are read.
    fn begin(&mut self) -> Result {
        self.args.what.set_up(&mut self.session, self.console)?;
        self.console.message(&format!(
            "{} on {}; Escape quits, `raxel run --help` lists the keys",
            self.session.graph_path(),
            device_name(&self.session)
        ));
        let (mut layout, said) = self.layout_file.read();
        if let Some(said) = said {
            self.console.message(&format!("warning: {said}"));
        }
        layout.visible &= !self.args.no_panels;
        self.panels = Panels::new(layout);
        if let Err(error) = self.presets.read() {
            self.console.message(&format!("warning: {error}"));
        }
        self.home = *self.session.camera();
        self.problems = problem_log::problems(self.session.warnings(), self.session.texts());
        self.last = Instant::now();
        Ok(())
    }

    /// Says how it went.
    fn finish(mut self) -> Result {
        self.look_at_log();
        let mut ending = Ending::default();
        self.finish_writing(&mut ending);
        let unmended = self.session.is_waiting();
        if !unmended {
            self.keep_layout(LayoutFile::write);
        }
        // An endless dispatch must not keep the program running.
        if ending.device_works(&mut self.session) {
            ending.abandon(&mut self.session);
        }
        match self.failure.take() {
            Some(failure) => Err(failure),
            None if unmended => Err(Failure::printed(Exit::Project)),
            None => validated(self.complained),
        }
    }

    /// Keeps the layout of the panels.
    fn keep_layout(&mut self, keep: fn(&mut LayoutFile, &Layout) -> std::io::Result<()>) {
        let mut layout = self.panels.layout.clone();
        // `--no-panels` is no choice of a layout, so the file does not keep it.
        layout.visible |= self.args.no_panels;
        if let Err(error) = keep(&mut self.layout_file, &layout) {
            self.console.detail(&format!("the layout of the panels cannot be saved: {error}"));
        }
    }

    /// Shows the session in a window from here on.
    fn open_window(&mut self, event_loop: &ActiveEventLoop) -> Result {
        let window = new_window(event_loop, self.session.viewport().window(), self.title_text())?;
        let size = window.inner_size();
        self.session.resize(size.width, size.height);
        self.window = Some(self.opened(&window)?);
        self.last = Instant::now();
        self.redraw();
        Ok(())
    }

    /// The parts of a window that show pictures of the session's device.
    fn opened(&self, window: &Arc<Window>) -> Result<Open> {
        let Args { present_with, no_vsync, .. } = self.args;
        Open::on(self.session.device(), present_with.as_ref(), window, !no_vsync, self.console)
    }

    /// Reports messages of the validation layer, of the session's device and of one that presents.
    fn look_at_log(&mut self) {
        self.complained |= print_validation(&self.session, self.console);
        if let Some(open) = self.window.as_ref().filter(|open| open.pictures == Pictures::Other) {
            self.complained |= print_log(open.presenter.device(), self.console);
        }
    }

    /// Whether the cursor is over a panel, or where a press resizes a dock.
    fn is_over_panels(&self) -> bool {
        let at = self.window.as_ref().zip(self.controls.pointer());
        at.is_some_and(|(open, pixel)| open.overlay.has_pointer(&self.panels, pixel))
    }

    /// The left button was pressed or released. Whether it holds the edge of a wipe now.
    fn hold_wipe(&mut self, pressed: bool) -> bool {
        self.comparing.release_edge();
        let Some([x, _]) = self.controls.on_picture().filter(|_| pressed) else { return false };
        self.comparing.hold_edge(x, self.session.viewport().window()[0], &self.session)
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        if let Some(open) = &mut self.window {
            open.presenter.resize([size.width, size.height]);
        }
        // Beside the panels, the picture follows once they are drawn.
        if self.placed.place.is_none() {
            self.session.resize(size.width, size.height);
        }
        self.redraw();
    }

    fn redraw(&self) {
        if let Some(open) = &self.window {
            self.redraws.ask(Instant::now());
            open.window.request_redraw();
        }
    }

    fn stop(&mut self, event_loop: &ActiveEventLoop, failure: Failure) {
        self.failure.get_or_insert(failure);
        event_loop.exit();
    }

    fn title_text(&self) -> String {
        if self.session.is_waiting() { "mistakes — raxel".to_owned() } else { self.title().text() }
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
            recording: self.session.recording().map(|(seconds, _)| seconds),
            generation: self.reloads.shown,
            failed: self.reloads.failed,
            refused: self.session.is_refused(),
            starting: self.presented == 0,
            busy: self.busy.clone(),
            off: self.data.off(&self.session),
            caption: self.caption(),
        }
    }

    /// The demo's caption at this moment, while it drives.
    fn caption(&self) -> Option<String> {
        let demo = self.session.demo().filter(|_| self.session.demo_drives())?;
        demo.caption(self.session.clock().now()?.time).map(|line| line.text.clone())
    }

    fn update_title(&mut self) {
        if self.titled.is_some_and(|at| at.elapsed() < TITLE_EVERY) {
            return;
        }
        self.titled = Some(Instant::now());
        // Now and not only at the end: a window may be killed.
        self.keep_layout(LayoutFile::look);
        if let Some(open) = &self.window {
            open.window.set_title(&self.title_text());
        }
    }
}

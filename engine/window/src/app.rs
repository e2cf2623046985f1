//! What the window's events go to: a session, or, while its files are broken, what is wrong with them.

use std::path::Path;
use std::time::{Duration, Instant};

use raxel_control::{Control, Drive, Next};
use raxel_diagnostics::Severity;
use raxel_gpu::DeviceOptions;
use raxel_runtime::reload::Waker;
use raxel_runtime::{Observe, OpenError, Saves, Session};
use raxel_terminal::args::Size;
use raxel_terminal::console::{Console, To};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::OfflineProject;
use raxel_terminal::session::{open_failure, print_log, validated};
use winit::application::ApplicationHandler;
use winit::event::{ElementState, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{Key, NamedKey};
use winit::window::WindowId;

use super::error_window::ErrorWindow;
use super::presenting::Open;
use super::{Args, Viewer, Wake, new_window};

/// Time between two looks at what happens while files are broken.
const LOOK: Duration = Duration::from_millis(50);

/// The program behind the window.
pub(super) struct App<'a> {
    /// What the command line says.
    args: &'a Args,
    console: &'a Console,
    device: &'a DeviceOptions,
    waker: Waker,
    /// A program that drives the session too, until there is one.
    control: Option<Control>,
    stage: Stage<'a>,
    /// The validation layer has said something while files were broken.
    complained: bool,
}

enum Stage<'a> {
    Viewing(Box<Viewer<'a>>),
    ErrorWindow(Box<ErrorWindow>),
    /// It has ended with this.
    Ended(Option<Failure>),
}

impl<'a> App<'a> {
    /// Opens the session. Where its files have mistakes it waits for their mend, unless frames are counted.
    pub fn open(args: &'a Args, console: &'a Console, device: &'a DeviceOptions, waker: Waker) -> Result<Self> {
        let mut control = args.control.then(|| {
            let waker = waker.clone();
            Control::listen(Drive::Window, move || waker())
        });
        let stage = match open_session(args, device, &waker)? {
            Ok((args, session)) => Stage::Viewing(Box::new(Viewer::new(args, console, session, control.take())?)),
            Err(OpenError::Project { diagnostics, texts }) if args.frames.is_none() => {
                console.diagnostics(&diagnostics, &texts, To::Stderr);
                let at = args.what.file.as_deref().or(args.what.world.as_deref()).unwrap_or(Path::new("."));
                // Without a project there is nothing that could be mended.
                let Ok(front) = OfflineProject::around(at) else { return Err(Failure::printed(Exit::Project)) };
                console.message("the window waits for the files to be mended");
                if let Some(control) = &mut control {
                    control.broken(&diagnostics, &texts);
                }
                let root = front.project.root().to_owned();
                Stage::ErrorWindow(Box::new(ErrorWindow::new(root, device, &diagnostics, &texts)?))
            }
            Err(error) => return Err(open_failure(error, console)),
        };
        Ok(Self { args, console, device, waker, control, stage, complained: false })
    }

    /// How it went.
    pub fn finish(self) -> Result {
        match self.stage {
            Stage::Viewing(viewer) => viewer.finish().and_then(|()| validated(self.complained)),
            Stage::ErrorWindow(_) => Err(Failure::printed(Exit::Project)),
            Stage::Ended(failure) => failure.map_or(Ok(()), Err),
        }
    }

    /// Draws what is wrong, and goes on when it is not wrong any more.
    fn wait(&mut self, event_loop: &ActiveEventLoop) {
        if self.control.as_mut().is_some_and(|control| control.poll(None) == Next::Quit) {
            return event_loop.exit();
        }
        if let Err(failure) = self.try_wait() {
            self.stage = Stage::Ended(Some(failure));
            event_loop.exit();
        }
    }

    fn try_wait(&mut self) -> Result {
        let Stage::ErrorWindow(waiting) = &mut self.stage else { return Ok(()) };
        waiting.draw(self.console)?;
        for device in waiting.devices() {
            self.complained |= print_log(device, self.console);
        }
        if !waiting.changed() {
            return Ok(());
        }
        let (args, session) = match open_session(self.args, self.device, &self.waker)? {
            Ok(opened) => opened,
            Err(OpenError::Project { diagnostics, texts }) => {
                if waiting.found(&diagnostics, &texts) {
                    self.console.diagnostics(&diagnostics, &texts, To::Stderr);
                    if let Some(control) = &mut self.control {
                        control.broken(&diagnostics, &texts);
                    }
                }
                return Ok(());
            }
            Err(error) => return Err(open_failure(error, self.console)),
        };
        // What was opened between two steps of a save is not what the manifest says.
        if !waiting.manifest_holds() {
            return Ok(());
        }
        let Stage::ErrorWindow(waiting) = std::mem::replace(&mut self.stage, Stage::Ended(None)) else { return Ok(()) };
        // The surface of the old device goes before the new one makes its own for the same window.
        let window = waiting.into_window();
        if let Some(control) = &mut self.control {
            control.opened();
        }
        let mut viewer = Viewer::new(args, self.console, session, self.control.take())?;
        if let Some(window) = window {
            viewer.show_in(&window)?;
        }
        self.stage = Stage::Viewing(Box::new(viewer));
        Ok(())
    }
}

/// Opens what the command line names, and for what it leaves open, what the project's manifest says at the moment. Gives both together.
fn open_session(
    args: &Args,
    device: &DeviceOptions,
    waker: &Waker,
) -> Result<std::result::Result<(Args, Session), OpenError>> {
    let (what, manifest) = match args.what.as_the_manifest_says() {
        Ok(said) => said,
        Err(error) => return Ok(Err(error)),
    };
    let size = args.size.or(manifest.size.map(Size));
    let args = Args { what, size, scale: args.scale.or(manifest.scale), ..args.clone() };
    let mut options = args.what.options(device)?;
    options.size = args.first_size();
    options.scale = args.scale.unwrap_or(options.scale);
    options.step = None;
    if args.control {
        // A program may read anything.
        options.observe = Observe::Everything;
    }
    options.watch = true;
    options.unused = Severity::Warning;
    options.saves = Saves::Write;
    options.poll = args.poll;
    options.waker = Some(waker.clone());
    Ok(Session::open(options).map(|session| (args, session)))
}

impl ApplicationHandler<Wake> for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        match &mut self.stage {
            Stage::Viewing(viewer) => viewer.resumed(event_loop),
            Stage::ErrorWindow(waiting) if waiting.open.is_none() => {
                let Args { present_with, no_vsync, .. } = self.args;
                let opened = new_window(event_loop, self.args, "mistakes — raxel".to_owned()).and_then(|window| {
                    Open::on(waiting.device(), present_with.as_ref(), &window, !no_vsync, self.console)
                });
                match opened {
                    Ok(open) => waiting.open = Some(open),
                    Err(failure) => {
                        self.stage = Stage::Ended(Some(failure));
                        event_loop.exit();
                    }
                }
            }
            Stage::ErrorWindow(_) | Stage::Ended(_) => {}
        }
    }

    fn suspended(&mut self, event_loop: &ActiveEventLoop) {
        match &mut self.stage {
            Stage::Viewing(viewer) => viewer.suspended(event_loop),
            Stage::ErrorWindow(waiting) => waiting.open = None,
            Stage::Ended(_) => {}
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, wake: Wake) {
        if let Stage::Viewing(viewer) = &mut self.stage {
            viewer.user_event(event_loop, wake);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        let open = match &mut self.stage {
            Stage::Viewing(viewer) => return viewer.window_event(event_loop, id, event),
            Stage::ErrorWindow(waiting) => &mut waiting.open,
            Stage::Ended(_) => return,
        };
        if let Some(Open { window, presenter, overlay, .. }) = open {
            overlay.take(window, &event);
            if let WindowEvent::Resized(size) = &event {
                presenter.resize([size.width, size.height]);
            }
        }
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::KeyboardInput { event, .. }
                if event.state == ElementState::Pressed && event.logical_key == Key::Named(NamedKey::Escape) =>
            {
                event_loop.exit();
            }
            WindowEvent::RedrawRequested => self.wait(event_loop),
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        match &mut self.stage {
            Stage::Viewing(viewer) => viewer.about_to_wait(event_loop),
            Stage::ErrorWindow(waiting) => {
                if let ControlFlow::WaitUntil(time) = event_loop.control_flow()
                    && Instant::now() < time
                {
                    return;
                }
                event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + LOOK));
                if let Some(open) = &waiting.open {
                    open.window.request_redraw();
                }
            }
            Stage::Ended(_) => {}
        }
    }
}

//! A window of your own: winit makes it, a session makes the pictures, a presenter shows them. Edits of the project's files show at once.
//!
//! `cargo run --release --example window`, in a folder with a project.

use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

use raxel::{Options, Presenter, ReloadEvent, Session};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

struct App {
    session: Session,
    window: Option<(Arc<Window>, Presenter)>,
    failure: Option<Box<dyn Error>>,
}

fn main() -> Result<(), Box<dyn Error>> {
    // `step: None` follows the wall clock; `watch` looks for edits.
    let options = Options { size: [960, 540], step: None, watch: true, ..Options::default() };
    let mut app = App { session: Session::open(options)?, window: None, failure: None };
    let event_loop = EventLoop::new()?;
    event_loop.set_control_flow(ControlFlow::Poll);
    event_loop.run_app(&mut app)?;
    app.failure.map_or(Ok(()), Err)
}

impl App {
    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), Box<dyn Error>> {
        let attributes =
            Window::default_attributes().with_title("my renderer").with_inner_size(PhysicalSize::new(960, 540));
        let window = Arc::new(event_loop.create_window(attributes)?);
        let size = window.inner_size();
        let presenter = Presenter::new(self.session.device(), window.clone(), [size.width, size.height], true)?;
        window.request_redraw();
        self.window = Some((window, presenter));
        Ok(())
    }

    fn draw(&mut self) -> Result<(), Box<dyn Error>> {
        for event in self.session.poll_reload() {
            match event {
                ReloadEvent::Reloaded(_) => println!("an edit is running"),
                // The last good picture stays.
                ReloadEvent::Failed(_) => println!("an edit is wrong; `raxel check` says why"),
                _ => {}
            }
        }
        self.session.frame()?;
        let Some((window, presenter)) = &mut self.window else { return Ok(()) };
        // A software driver presents only what is finished.
        self.session.wait_picture(Duration::from_secs(1))?;
        if let Some(picture) = self.session.picture() {
            presenter.present(&picture, None)?;
        }
        window.request_redraw();
        Ok(())
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.window.is_none() {
            self.failure = self.open(event_loop).err();
        }
        if self.failure.is_some() {
            event_loop.exit();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => {
                self.session.resize(size.width, size.height);
                if let Some((_, presenter)) = &mut self.window {
                    presenter.resize([size.width, size.height]);
                }
            }
            WindowEvent::RedrawRequested => {
                if let Err(failure) = self.draw() {
                    self.failure = Some(failure);
                    event_loop.exit();
                }
            }
            _ => {}
        }
    }
}

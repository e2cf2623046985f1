//! Presentation in a real window, under Xvfb: a picture with triangles over it, a window that changes and goes away, images that are
//! released. The window lives in a child, which is this test again with a display.

#![cfg(target_os = "linux")]

mod project;

use std::fs;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use project::{Project, Sessions};
use raxel_execute::Progress;
use raxel_gpu::{Acquire, CommandBuffer, Surface};
use raxel_runtime::Options;
use raxel_runtime::present::{
    OverlayFrame, OverlayMesh, OverlayVertex, PresentError, Presented, Presenter, TexturePatch,
};
use raxel_testing::{Display, Running, eventually};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::platform::pump_events::EventLoopExtPumpEvents;
use winit::platform::x11::EventLoopBuilderExtX11;
use winit::window::{Window, WindowId};

/// Set for the child.
const CHILD: &str = "RAXEL_TEST_WINDOW";

const PATIENCE: Duration = Duration::from_secs(60);

/// The picture is grey; a red rectangle of 20 × 10 points lies over it at (8, 4).
const GREY: [u8; 3] = [128, 128, 128];
const RED: [u8; 3] = [255, 0, 0];

fn expected(width: usize, height: usize) -> Vec<[u8; 3]> {
    let pixel = |x: usize, y: usize| if (8..28).contains(&x) && (4..14).contains(&y) { RED } else { GREY };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
}

#[test]
fn a_window_shows_the_picture_under_its_overlay_and_may_change_and_go() {
    let display = Display::start();
    let folder = tempfile::tempdir().unwrap();
    let log_path = folder.path().join("log");
    let mut child = Running::start(
        Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "the_child_of_the_test_above", "--nocapture"])
            .env(CHILD, "1")
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stdout(fs::File::create(&log_path).unwrap())
            .stderr(Stdio::inherit()),
    );
    let log = || fs::read_to_string(&log_path).unwrap();
    eventually("the picture under the overlay", || display.pixels(160, 90) == expected(160, 90));
    let window = display.xdotool(&["search", "--name", "presenter"]).trim().to_owned();
    display.xdotool(&["windowsize", "--sync", &window, "200", "64"]);
    eventually("the window of another size", || display.pixels(200, 64) == expected(200, 64));
    // Another program takes the window away.
    display.xdotool(&["windowclose", &window]);
    eventually("the loss is told", || log().contains("lost: the surface of the window was lost"));
    assert!(child.finish().success(), "{}", log());
}

/// A window and its events.
#[derive(Default)]
struct App {
    window: Option<Arc<Window>>,
    size: [u32; 2],
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let attributes =
            Window::default_attributes().with_title("presenter").with_inner_size(PhysicalSize::new(160, 90));
        self.window = Some(Arc::new(event_loop.create_window(attributes).unwrap()));
        self.size = [160, 90];
    }

    fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if let WindowEvent::Resized(size) = event {
            self.size = [size.width, size.height];
        }
    }
}

#[test]
fn the_child_of_the_test_above() {
    if std::env::var_os(CHILD).is_none() {
        return;
    }
    let mut event_loop = EventLoop::builder().with_any_thread(true).build().unwrap();
    let mut app = App::default();
    while app.window.is_none() {
        event_loop.pump_app_events(Some(Duration::from_millis(10)), &mut app);
    }
    let window = app.window.clone().unwrap();
    let project = Project::filled();
    project.write("shaders/fill.comp", project::fill("vec4(vec3(0.2158605), 1.0)"));
    let mut session = Project::open_with(Options { size: [160, 90], ..project.options() });
    images_are_given_back(&session, &window);

    let mut presenter = Presenter::new(session.device(), window, [160, 90], true).unwrap();
    let white = TexturePatch { position: None, size: [1, 1], rgba: &[255; 4], linear: false };
    presenter.set_texture(0, &white).unwrap();
    let corner = |x, y| OverlayVertex { position: [x, y], uv: [0.5; 2], color: [255, 0, 0, 255] };
    let vertices = [corner(8.0, 4.0), corner(28.0, 4.0), corner(28.0, 14.0), corner(8.0, 14.0)];
    let meshes =
        [OverlayMesh { clip: [0.0, 0.0, 1e6, 1e6], texture: 0, vertices: &vertices, indices: &[0, 1, 2, 0, 2, 3] }];
    let overlay = OverlayFrame { pixels_per_point: 1.0, meshes: &meshes };

    let end = Instant::now() + PATIENCE * 2;
    let mut shown = 0_u64;
    while Instant::now() < end {
        event_loop.pump_app_events(Some(Duration::from_millis(5)), &mut app);
        session.resize(app.size[0], app.size[1]);
        presenter.resize(app.size);
        session.frame().unwrap();
        assert_eq!(session.wait_picture(PATIENCE).unwrap(), Progress::Done);
        let messages = session.device().log().take();
        // In turns as the device has it, and by way of the host.
        let presented = if shown.is_multiple_of(2) {
            presenter.present(&session.picture().unwrap(), Some(&overlay))
        } else {
            presenter.take(&session.read_presented().unwrap()).unwrap();
            presenter.present_taken([0.0; 3], Some(&overlay))
        };
        match presented {
            Ok(Presented::Shown) => shown += 1,
            Ok(_) => {}
            Err(error @ PresentError::Gpu(raxel_gpu::Error::SurfaceLost)) => {
                println!("lost: {error}");
                assert!(shown > 0);
                return;
            }
            Err(error) => panic!("{error}"),
        }
        // A message of the layer about a window that is gone is the window system's fault.
        assert!(messages.is_empty(), "{messages:#?}");
    }
    panic!("the window was never taken away");
}

/// An image that is acquired and not presented returns to its surface: there are no more than a few, and each can be had again.
fn images_are_given_back(session: &raxel_runtime::Session, window: &Arc<Window>) {
    let device = session.device();
    let mut surface = Surface::new(device, window.clone(), [160, 90], true, PATIENCE).unwrap();
    for round in 0..20 {
        match surface.acquire(Duration::from_secs(5)).unwrap() {
            // It goes back here, as after an error that ends the frame.
            Acquire::Image(_) => {}
            Acquire::NoArea => panic!("round {round}: the window has an area"),
            Acquire::NotReady => panic!("round {round}: no image came back"),
        }
        if round == 10 {
            // The swapchain is replaced while an image is out.
            surface.resize([161, 90]);
        }
    }
    // The image that was released so often can still be presented.
    let mut commands = CommandBuffer::new(device, "present").unwrap();
    for _ in 0..6 {
        device.wait(commands.submitted(), PATIENCE).unwrap();
        let Acquire::Image(image) = surface.acquire(Duration::from_secs(5)).unwrap() else { panic!("no image") };
        image.present(commands.begin().unwrap()).unwrap();
    }
    drop(surface);
    let messages = device.log().take();
    assert!(messages.is_empty(), "{messages:#?}");
}

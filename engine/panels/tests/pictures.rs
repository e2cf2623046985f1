//! Each panel as a picture: what egui draws, painted by the window's own painter into an image, and held against `tests/pictures`.
//! A picture is written only by
//!
//! ```sh
//! RAXEL_WRITE_PANELS=1 cargo test --profile checked -p raxel-panels --test pictures
//! ```
//!
//! and then looked at. One that differs is left beside its reference as NAME.new.png.
//!
//! Drivers round colours and edges differently, so a few pixels of each tile may be quite another colour, and all may be another by a
//! little. A letter that is another, or stands a pixel further on, is more than that.

mod window;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use egui::{Context, Pos2, RawInput, Rect, Vec2, ViewportId};
use image::RgbImage;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use raxel_gpu::{
    Backing, Barrier, ClearColor, CommandBuffer, Device, DeviceOptions, Image, ImageInfo, ImageView, Overlay,
    OverlayFrame, Validation, ViewInfo, download_image, vk,
};
use raxel_overlay::{meshes, patch, texture};
use raxel_panels::view::{
    Compare, CompareMode, ComponentKind, Figures, Lane, Magnified, Param, PassState, Preset, Problem, Resource, Shown,
    Timeline, Track, Use, WorldExtent, WorldStatistics, WrittenTexel,
};
use raxel_panels::{Panel, Samples};
use raxel_picture::Statistics;
use raxel_runtime::present::new_overlay;

use window::{Window, inspected, param};

const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;
const PATIENCE: Duration = Duration::from_secs(600);

/// Pixels along a side of a tile, the number of pixels that may have another colour, and the difference, of 255, that all pixels may have.
const TILE: u32 = 32;
const MOST: usize = 6;
const ROUNDING: u8 = 24;

/// Name of a size, pixels of the window, and pixels for each point.
const SIZES: [(&str, [u32; 2], f32); 2] = [("100", [640, 400], 1.0), ("200", [840, 640], 2.0)];

/// The colour under the panels.
const GROUND: [f32; 4] = [0.35, 0.42, 0.5, 1.0];

/// A device with the window's painter.
struct Painter {
    device: Arc<Device>,
    commands: CommandBuffer,
}

impl Painter {
    fn new() -> Self {
        let options = DeviceOptions { device: None, validation: Validation::Required };
        let device = Device::new(&options).expect("a driver and the validation layer");
        let commands = CommandBuffer::new(&device, "panels").expect("a pool");
        Self { device, commands }
    }

    /// The window once everything has found its place.
    fn picture(&mut self, window: &mut Window, size: [u32; 2], pixels_per_point: f32) -> RgbImage {
        let mut overlay = new_overlay(&self.device, FORMAT).expect("the shaders compile");
        let context = Context::default();
        let points = Vec2::new(size[0] as f32, size[1] as f32) / pixels_per_point;
        let mut painted = Vec::new();
        for frame in 0..30 {
            let mut input = RawInput {
                screen_rect: Some(Rect::from_min_size(Pos2::ZERO, points)),
                time: Some(f64::from(frame) / 30.0),
                ..RawInput::default()
            };
            input.viewports.entry(ViewportId::ROOT).or_default().native_pixels_per_point = Some(pixels_per_point);
            let output = context.run(input, |context| window.draw(context));
            for (id, delta) in &output.textures_delta.set {
                overlay.set_texture(texture(*id), &patch(delta)).expect("it fits");
            }
            painted = context.tessellate(output.shapes, output.pixels_per_point);
        }
        let picture = self.paint(&mut overlay, size, &OverlayFrame { pixels_per_point, meshes: &meshes(&painted) });
        let messages = self.device.log().take();
        assert!(messages.is_empty(), "{messages:#?}");
        picture
    }

    fn paint(&mut self, overlay: &mut Overlay, size: [u32; 2], content: &OverlayFrame<'_>) -> RgbImage {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let extent = [size[0], size[1], 1];
        let info = ImageInfo { format: FORMAT, volume: false, extent, mips: 1, layers: 1, usage };
        let image = Arc::new(Image::new(&self.device, "panels", &info, Backing::Own).expect("it fits"));
        let view = ImageView::new(&self.device, &image, &ViewInfo::FLAT).expect("a view");
        self.device.wait(self.commands.submitted(), PATIENCE).expect("it ends");
        let mut recording = self.commands.begin().expect("it has ended");
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let any = vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE;
        recording.barrier(&Barrier::default().activate(&image, (all, any), (all, any)));
        recording.clear_image(&image, ClearColor::Float(GROUND));
        overlay.draw_into(&mut recording, &view, 0, content).expect("it is drawn");
        recording.submit().expect("it runs");
        let bytes = download_image(&self.device, &image, 4, 0, 0, PATIENCE).expect("it is read");
        let rgb = bytes.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        RgbImage::from_raw(size[0], size[1], rgb).expect("all of it")
    }
}

/// A window with one panel, full of what a real graph has: long names, many rows, large numbers.
fn full(panel: Panel) -> Window {
    let mut window = Window::new(&[panel]);
    window.gpu = Samples::default();
    (0..240).for_each(|frame| window.gpu.push(1.2 + f64::from(frame * 37 % 11) * 0.04));
    window.passes = vec![
        ("reproject_reservoirs", PassState::Ran, Some(0)),
        ("trace_primary_visibility", PassState::Ran, Some(1)),
        ("sky_tables", PassState::Skipped, Some(2)),
        ("refresh_probes", PassState::NotDue, Some(2)),
        ("spin", PassState::Off, Some(3)),
        ("fog", PassState::Condition, None),
        ("tone", PassState::Unused, None),
    ];
    let uses = |marks: &str| {
        let used = |mark| Use { reads: matches!(mark, 'r' | 'b'), writes: matches!(mark, 'w' | 'b'), ..Use::default() };
        marks.chars().map(used).collect()
    };
    let resource = |name: &str, about: &str, bytes, memory: &str, marks| Resource {
        name: name.to_owned(),
        about: about.to_owned(),
        bytes,
        memory: memory.to_owned(),
        uses: uses(marks),
        ..Resource::default()
    };
    window.resources = vec![
        resource(
            "reservoirs",
            "buffer, 2073600 × 32 bytes",
            132_710_400,
            "own memory, kept from frame to frame",
            "b......",
        ),
        resource("visibility", "rg32ui 1920 × 1080", 16_588_800, "in block 0 at 0", "rw..r.."),
        resource("sky", "rgba16f 256 × 128, 6 mips", 349_504, "own memory", "..wbr.."),
        resource("color", "rgba16f 1920 × 1080, history 1", 33_177_600, "in block 1 at 4096", ".r..w.r"),
    ];
    let grouped = |param: Param, group: &str| Param { group: Some(group.to_owned()), ..param };
    window.params = vec![
        grouped(Param { unit: Some("EV".to_owned()), ..param("exposure", vec![2.5], vec![1.0]) }, "Camera"),
        grouped(
            Param {
                kind: ComponentKind::Uint,
                choices: ["Reinhard", "AgX", "ACES"].map(str::to_owned).to_vec(),
                range: Some([0.0, 2.0]),
                ..param("tone curve", vec![1.0], vec![1.0])
            },
            "Camera",
        ),
        grouped(Param { kind: ComponentKind::Bool, range: None, ..param("fog", vec![1.0], vec![0.0]) }, "Air"),
        grouped(Param { color: true, ..param("colour of the ground", vec![0.5, 0.25, 0.1], vec![0.5; 3]) }, "Air"),
        grouped(Param { driven: true, ..param("height of the sun", vec![0.8], vec![0.8]) }, "Air"),
        Param { kind: ComponentKind::Int, range: None, ..param("offset", vec![-3.0, 12.0, 40.0], vec![0.0; 3]) },
    ];
    let preset = |name: &str, differing: &[&str]| Preset {
        name: name.to_owned(),
        differing: differing.iter().map(|line| (*line).to_owned()).collect(),
    };
    window.presets = vec![preset("dusk", &["exposure: 2.5, then 0.5"]), preset("noon", &[])];
    window.world = WorldStatistics {
        extent: WorldExtent::Whole { chunks: 4096, voxels: 123_456_789, lamps: 10_000 },
        sources: vec![("world.tree64".to_owned(), 91 << 20), ("world.lights".to_owned(), 2 << 20)],
        edits: [12, 3],
    };
    window.problems = vec![
        Problem {
            error: true,
            place: Some("graphs/a.toml:7:12".to_owned()),
            title: "RX0100: there is no target `colour`".to_owned(),
            text: "error[RX0100]: there is no target `colour`\n --> graphs/a.toml:7:12\n  |\n7 | bind = { outColor = \"colour\" }\n  |                     ^^^^^^^^ did you mean `color`?".to_owned(),
        },
        Problem {
            place: Some("shaders/shade.comp:120:5".to_owned()),
            title: "RX0231: `unused` is never read".to_owned(),
            text: "warning[RX0231]: `unused` is never read".to_owned(),
            ..Problem::default()
        },
    ];
    if panel == Panel::Problems {
        (window.status.generation, window.status.failed) = (16, Some(17));
    }
    let mut what = inspected();
    "rgba16f 1920 × 1080".clone_into(&mut what.about);
    what.shown = Shown::after("color", Some("trace_primary_visibility".to_owned()));
    let bell = |n: u16| (f32::from(n) / 500.0 - 1.0).powi(3) + f32::from(n % 7) * 0.01;
    what.statistics = Statistics::of((0..1000).map(bell).chain([f32::NAN]));
    window.inspected = Some(what);
    window.compare = Compare {
        kept: Some("color,after=trace_primary_visibility, generation 12, 1920 × 1080".to_owned()),
        mode: CompareMode::Difference,
        gain: 4.0,
        figures: Figures::Found {
            of: "color, generation 14".to_owned(),
            flip: 0.012_345,
            rmse: 0.25,
            max: 3.5,
            differing: [12_345, 2_073_600],
        },
        ..Compare::default()
    };
    window.steps = [12, 3];
    let lasting = vec![3.0, 2.5];
    let tracks = vec![
        Track::new(Lane::Camera, "camera", vec![0.0, 2.0, 5.0, 9.5]),
        Track::new(Lane::Param("exposure".to_owned()), "exposure", vec![0.0, 4.0]),
        Track { lasting, ..Track::new(Lane::Captions, "captions", vec![1.0, 6.0]) },
        Track::new(Lane::Checks, "checks", vec![8.0]),
    ];
    window.timeline = Some(Timeline {
        name: "valley".to_owned(),
        duration: 10.0,
        time: 2.5,
        drives: true,
        tracks,
        ..Timeline::default()
    });
    window
}

/// The tiles in which two pictures of one size differ too much: their places, and the number of pixels.
fn differing(reference: &RgbImage, other: &RgbImage) -> Vec<([u32; 2], usize)> {
    let mut tiles = BTreeMap::new();
    for (x, y, pixel) in reference.enumerate_pixels() {
        if pixel.0.iter().zip(&other.get_pixel(x, y).0).any(|(a, b)| a.abs_diff(*b) > ROUNDING) {
            *tiles.entry([x / TILE * TILE, y / TILE * TILE]).or_default() += 1;
        }
    }
    tiles.into_iter().filter(|(_, count)| *count > MOST).collect()
}

/// Writes a picture as a small file.
fn write(path: &Path, picture: &RgbImage) {
    let file = BufWriter::new(File::create(path).unwrap());
    let encoder = PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::Adaptive);
    picture.write_with_encoder(encoder).unwrap();
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pictures")
}

#[test]
fn each_panel_looks_as_it_did() {
    let mut painter = Painter::new();
    let mut wrong = Vec::new();
    let each = Panel::ALL.into_iter().flat_map(|panel| {
        SIZES.map(|(scale, size, pixels_per_point)| {
            (format!("{}-{scale}", panel.title().to_lowercase()), full(panel), size, pixels_per_point)
        })
    });
    let mut whole = full(Panel::Timeline);
    whole.panels.layout.open(Panel::Resources);
    whole.panels.layout.open(Panel::Inspect);
    // A magnified picture of eight by five texels, and the edge of a wipe over it.
    let mut magnified = Window::new(&[]);
    let lines = |x: u32, y: u32| vec![format!("{x}.{y}00"), "-0.125".to_owned(), "NaN".to_owned()];
    let values = (0..40).map(|n| (n % 8, n / 8)).map(|(x, y)| WrittenTexel { at: [x, y], lines: lines(x, y) });
    magnified.magnified = Magnified { origin: [0.25, 0.4], size: 0.5, extent: [8, 5], values: values.collect() };
    magnified.compare = Compare {
        kept: Some("color, generation 1, 8 × 5".to_owned()),
        mode: CompareMode::Wipe,
        edge: 0.4,
        ..Compare::default()
    };
    let others = [("window".to_owned(), whole, [1280, 720], 1.0), ("magnified".to_owned(), magnified, [640, 400], 1.0)];
    for (name, mut window, size, pixels_per_point) in each.chain(others) {
        let picture = painter.picture(&mut window, size, pixels_per_point);
        let path = folder().join(format!("{name}.png"));
        if std::env::var_os("RAXEL_WRITE_PANELS").is_some() {
            std::fs::create_dir_all(folder()).unwrap();
            write(&path, &picture);
            continue;
        }
        let reference = image::open(&path)
            .unwrap_or_else(|error| panic!("{}: {error}; see the head of this file", path.display()))
            .into_rgb8();
        assert_eq!(picture.dimensions(), reference.dimensions(), "{name}");
        let tiles = differing(&reference, &picture);
        if !tiles.is_empty() {
            write(&path.with_extension("new.png"), &picture);
            wrong.push(format!("{name}: {tiles:?}"));
        }
    }
    assert!(wrong.is_empty(), "tiles with more than {MOST} pixels of another colour:\n{}", wrong.join("\n"));
}

#[test]
fn another_letter_and_a_shift_by_a_pixel_are_noticed_and_rounding_is_not() {
    let mut painter = Painter::new();
    let (_, size, scale) = SIZES[0];
    let reference = painter.picture(&mut full(Panel::Passes), size, scale);
    assert!(differing(&reference, &painter.picture(&mut full(Panel::Passes), size, scale)).is_empty());
    let mut other = full(Panel::Passes);
    other.passes[0].0 = "reproject_reservoins";
    assert!(!differing(&reference, &painter.picture(&mut other, size, scale)).is_empty());
    let shifted = RgbImage::from_fn(size[0], size[1], |x, y| *reference.get_pixel(x.saturating_sub(1), y));
    assert!(!differing(&reference, &shifted).is_empty());
    let rounded = RgbImage::from_fn(size[0], size[1], |x, y| {
        let mut pixel = *reference.get_pixel(x, y);
        pixel.0.iter_mut().for_each(|part| *part = part.saturating_add(((x + y) % 3) as u8));
        pixel
    });
    assert!(differing(&reference, &rounded).is_empty());
}

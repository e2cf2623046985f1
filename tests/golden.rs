//! Small pictures against references in tests/golden, by FLIP (Andersson et al., "FLIP: A Difference Evaluator for Alternating
//! Images", 2020). A reference is written only by
//!
//! ```sh
//! RAXEL_WRITE_GOLDEN=1 cargo test --profile checked --test golden
//! ```
//!
//! and then looked at. When a picture differs, it is left beside its reference as NAME.new.png, with NAME.diff.png.

use std::path::{Path, PathBuf};

use image::RgbImage;
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool, flip, magma_lut};
use raxel::layouts::Layout;
use raxel::rivals;
use raxel::{DebugTarget, Options, Session};

/// Mean FLIP error that drivers may differ by. 0 is equal, 1 is black for white.
const TOLERANCE: f32 = 0.01;

const SIZE: [u32; 2] = [160, 90];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

fn render(graph: &str, world: &str, target: &str) -> RgbImage {
    render_in(None, graph, world, target)
}

/// A picture of a world in a layout, or else in the one that the graph asks for.
fn render_in(layout: Option<Layout>, graph: &str, world: &str, target: &str) -> RgbImage {
    let mut session = Session::open(Options {
        project: Some(env!("CARGO_MANIFEST_DIR").into()),
        graph: Some(graph.into()),
        world: Some(world.into()),
        layout,
        debug_target: DebugTarget::resource(target),
        size: SIZE,
        ..Options::default()
    })
    .unwrap();
    session.frame().unwrap();
    let picture = session.read_presented().unwrap();
    let rgb = picture.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    RgbImage::from_raw(picture.width, picture.height, rgb).unwrap()
}

fn flip_image(image: &RgbImage) -> FlipImageRgb8 {
    FlipImageRgb8::with_data(image.width(), image.height(), image)
}

/// Compares one picture with its reference.
fn compare(name: &str, graph: &str, world: &str, target: &str) {
    let picture = render(graph, world, target);
    let path = folder().join(format!("{name}.png"));
    if std::env::var_os("RAXEL_WRITE_GOLDEN").is_some() {
        std::fs::create_dir_all(folder()).unwrap();
        picture.save(&path).unwrap();
        return;
    }
    let reference = image::open(&path)
        .unwrap_or_else(|error| panic!("{}: {error}; see the head of tests/golden.rs", path.display()))
        .into_rgb8();
    assert_eq!(picture.dimensions(), reference.dimensions(), "{name}");
    let error = flip(flip_image(&reference), flip_image(&picture), DEFAULT_PIXELS_PER_DEGREE);
    let mean = FlipPool::from_image(&error).mean();
    if mean > TOLERANCE {
        picture.save(folder().join(format!("{name}.new.png"))).unwrap();
        let shown = error.apply_color_lut(&magma_lut());
        let diff = RgbImage::from_raw(shown.width(), shown.height(), shown.to_vec()).unwrap();
        diff.save(folder().join(format!("{name}.diff.png"))).unwrap();
        panic!("{name} differs from its reference by a mean FLIP error of {mean:.4}; {TOLERANCE} is allowed");
    }
}

#[test]
fn primary_over_the_valley() {
    compare("primary-valley", "graphs/primary.toml", "worlds/valley.toml", "color");
}

#[test]
fn primary_over_the_monument() {
    compare("primary-monument", "graphs/primary.toml", "worlds/monument.toml", "color");
}

#[test]
fn every_layout_gives_the_same_picture() {
    let (primary, monument) = ("graphs/primary.toml", "worlds/monument.toml");
    let trees = render(primary, monument, "color");
    assert!(trees == render("graphs/rivals/primary_chunks.toml", monument, "color"));
    for &layout in rivals::LAYOUTS {
        assert!(trees == render_in(Some(layout), primary, monument, "color"), "{}", layout.name());
    }
}

#[test]
fn what_the_tracer_found_in_the_sponge() {
    for target in ["hit", "depth", "normal", "steps"] {
        compare(&format!("inspect-menger-{target}"), "graphs/inspect.toml", "worlds/menger.toml", target);
    }
}

#[test]
fn naive_over_the_sponge() {
    compare("naive-menger", "graphs/rivals/naive.toml", "worlds/menger.toml", "color");
}

#[test]
fn a_difference_is_noticed() {
    let black = RgbImage::new(16, 16);
    let mut spotted = black.clone();
    for x in 0..8 {
        spotted.put_pixel(x, 8, image::Rgb([255, 255, 255]));
    }
    let error = flip(flip_image(&black), flip_image(&spotted), DEFAULT_PIXELS_PER_DEGREE);
    assert!(FlipPool::from_image(&error).mean() > TOLERANCE);
}

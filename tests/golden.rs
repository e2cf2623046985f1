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
use raxel::{DebugTarget, Options, Session, Value};
use raxel_layouts::Layout;
use raxel_rivals as rivals;

/// Mean FLIP error that drivers may differ by. 0 is equal, 1 is black for white.
const TOLERANCE: f32 = 0.01;

const SIZE: [u32; 2] = [160, 90];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// A picture of a world in a layout, or else in the one that the graph asks for.
fn render(layout: Option<Layout>, graph: &str, world: &str, target: &str) -> RgbImage {
    let shown = DebugTarget::resource(target);
    let mut session = open(Options { layout, debug_target: shown, size: SIZE, ..Options::default() }, graph, world);
    picture_after(&mut session, 1)
}

fn open(options: Options, graph: &str, world: &str) -> Session {
    let project = Some(env!("CARGO_MANIFEST_DIR").into());
    let files = (Some(graph.into()), Some(world.into()));
    Session::open(Options { project, graph: files.0, world: files.1, ..options })
        .unwrap_or_else(|error| panic!("{graph} over {world}: {error}"))
}

/// The picture after some more frames.
fn picture_after(session: &mut Session, frames: u32) -> RgbImage {
    for _ in 0..frames {
        session.frame().unwrap();
    }
    let picture = session.read_presented().unwrap();
    let rgb = picture.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    RgbImage::from_raw(picture.width, picture.height, rgb).unwrap()
}

fn flip_image(image: &RgbImage) -> FlipImageRgb8 {
    FlipImageRgb8::with_data(image.width(), image.height(), image)
}

/// Compares one picture with its reference.
fn compare(name: &str, graph: &str, world: &str, target: &str) {
    judge(name, &render(None, graph, world, target), TOLERANCE);
}

/// Compares a picture with its reference: their mean FLIP error is within a tolerance.
fn judge(name: &str, picture: &RgbImage, tolerance: f32) {
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
    let error = flip(flip_image(&reference), flip_image(picture), DEFAULT_PIXELS_PER_DEGREE);
    let mean = FlipPool::from_image(&error).mean();
    if mean > tolerance {
        picture.save(folder().join(format!("{name}.new.png"))).unwrap();
        let shown = error.apply_color_lut(&magma_lut());
        let diff = RgbImage::from_raw(shown.width(), shown.height(), shown.to_vec()).unwrap();
        diff.save(folder().join(format!("{name}.diff.png"))).unwrap();
        panic!("{name} differs from its reference by a mean FLIP error of {mean:.4}; {tolerance} is allowed");
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
    let trees = render(None, primary, monument, "color");
    assert!(trees == render(None, "graphs/rivals/primary_chunks.toml", monument, "color"));
    for &layout in rivals::LAYOUTS {
        assert!(trees == render(Some(layout), primary, monument, "color"), "{}", layout.name());
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

/// Graph, world, frames that are run, and the mean FLIP error that the picture may have. It is larger where threads race for slots.
const SYSTEMS: [(&str, &str, u32, f32); 5] = [
    ("graphs/rivals/light/views/octree_view.toml", "worlds/menger.toml", 1, 0.001),
    ("graphs/rivals/light/gi_svgf.toml", "worlds/hall.toml", 6, 0.01),
    ("graphs/rivals/light/lum.toml", "worlds/monument.toml", 6, 0.01),
    ("graphs/rivals/light/surface_cache.toml", "worlds/monument.toml", 12, 0.02),
    ("graphs/rivals/light/wavefront.toml", "worlds/hall.toml", 6, 0.02),
];

/// Pictures after several frames: what loops, queues, clocks and history add up to.
#[test]
fn systems_of_many_passes() {
    for (graph, world, frames, tolerance) in SYSTEMS {
        let mut session = open(Options { size: [128, 72], ..Options::default() }, graph, world);
        let name = Path::new(graph).file_stem().unwrap().to_str().unwrap();
        judge(&format!("system-{name}"), &picture_after(&mut session, frames), tolerance);
    }
}

/// Mean of all channels of a picture.
fn mean(picture: &RgbImage) -> f64 {
    let bytes = picture.as_raw();
    bytes.iter().map(|byte| f64::from(*byte)).sum::<f64>() / bytes.len() as f64
}

/// The sum of the differences between neighbours in a row.
fn contrast(picture: &RgbImage) -> f64 {
    let rows = picture.as_raw().chunks_exact(3 * picture.width() as usize);
    rows.flat_map(|row| row.iter().zip(&row[3..]).map(|(a, b)| f64::from(a.abs_diff(*b)))).sum()
}

/// Sixteen times the light is four stops more. The histogram takes three of them back, as `shaders/light/beauty/eye.comp` says, in seconds.
#[test]
fn the_eye_of_beauty_adapts_and_its_bloom_spreads_light() {
    let options = Options { size: [64, 36], step: Some(0.1), pinned: vec!["eye".to_owned()], ..Options::default() };
    let mut session = open(options, "graphs/beauty.toml", "worlds/monument.toml");
    let exposure_after = |session: &mut Session, frames: u32| {
        picture_after(session, frames);
        f32::from_le_bytes(session.read_buffer("eye", 0..4).unwrap().try_into().unwrap())
    };
    let before = exposure_after(&mut session, 40);
    for name in ["sun_strength", "sky_strength"] {
        let Value::F32(strength) = session.param(name).unwrap() else { panic!("{name} is a number") };
        session.set_param(name, Value::F32(16.0 * strength)).unwrap();
    }
    let soon = exposure_after(&mut session, 1);
    let later = exposure_after(&mut session, 60);
    assert!(soon > 0.55 * before && soon < 0.9 * before, "{before}, {soon} after a tenth of a second");
    assert!((0.09..0.18).contains(&(later / before)), "{before}, {later} after six seconds");

    let with_bloom = |session: &mut Session, share: f32| {
        session.set_param("bloom", Value::F32(share)).unwrap();
        picture_after(session, 1)
    };
    // All light taken from the pyramid of mips: the finest of them alone leaves a third of the contrast.
    let [sharp, soft] = [0.0, 1.0].map(|share| with_bloom(&mut session, share));
    assert!(contrast(&soft) < 0.2 * contrast(&sharp), "{} of {}", contrast(&soft), contrast(&sharp));
    assert!((mean(&soft) / mean(&sharp) - 1.0).abs() < 0.2, "{} of {}", mean(&soft), mean(&sharp));
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

//! Whole lighting systems of other voxel renderers as files, in `tests/lighting`: a cache of voxel faces, probes, a wavefront path tracer, reprojection and smoothing,
//! moving models and particles, an edited copy of the world. They hold the graph language to what it is for: no size typed by hand, no pass written twice,
//! no script. Their pictures are those of the same systems written without loops, queues, shared blocks and sizes that follow the world.
//!
//! `RAXEL_WRITE_LIGHTING=1 cargo test --profile checked --test lighting` writes the pictures anew; look at them then.

mod common;

use common::{Project, repository};
use image::RgbImage;
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool, flip};
use raxel::{Options, Session, Validation};

const SIZE: [u32; 2] = [128, 72];

/// Graph, world, frames that are run, and the mean FLIP error that its picture may have: more where threads race for slots and places in queues.
const SYSTEMS: [(&str, &str, u32, f32); 9] = [
    ("tree", "court", 1, 0.001),
    ("tree_octree", "court", 1, 0.001),
    ("pbr", "court", 4, 0.002),
    ("gi", "court", 6, 0.01),
    ("lum", "court", 6, 0.01),
    ("surface", "court", 6, 0.02),
    ("wave", "court", 6, 0.02),
    ("live", "basin", 6, 0.01),
    ("edit", "valley", 2, 0.001),
];

fn project() -> Project {
    let project = Project::copy_of("tests/lighting");
    for file in [
        "graphs/primary.toml",
        "shaders/packet.comp",
        "shaders/packet_rest.comp",
        "shaders/primary.comp",
        "shaders/trace.comp",
        "worlds/valley.toml",
    ] {
        project.write(file, std::fs::read(repository().join(file)).unwrap());
    }
    for model in std::fs::read_dir(repository().join("worlds/models")).unwrap() {
        let model = model.unwrap();
        project.write(&format!("worlds/models/{}", model.file_name().display()), std::fs::read(model.path()).unwrap());
    }
    project
}

#[test]
fn every_system_gives_its_picture() {
    let project = project();
    let mut wrong = Vec::new();
    for (graph, world, frames, tolerance) in SYSTEMS {
        let what = format!("{graph} over {world}");
        let mut session = Session::open(Options {
            project: Some(project.root().into()),
            graph: Some(project.path(&format!("graphs/{graph}.toml"))),
            world: Some(project.path(&format!("worlds/{world}.toml"))),
            size: SIZE,
            validation: Validation::Required,
            ..Options::default()
        })
        .unwrap_or_else(|error| panic!("{what}: {error}"));
        let warnings: Vec<_> = session.warnings().iter().map(|warning| &warning.message).collect();
        assert!(warnings.is_empty(), "{what}: {warnings:?}");
        for _ in 0..frames {
            session.frame().unwrap_or_else(|error| panic!("{what}: {error}"));
        }
        let picture = session.read_presented().unwrap_or_else(|error| panic!("{what}: {error}"));
        let messages = session.device().log().take();
        assert!(messages.is_empty(), "{what}: {messages:#?}");
        let rgb = picture.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        let picture = RgbImage::from_raw(picture.width, picture.height, rgb).unwrap();
        let path = repository().join(format!("tests/lighting/pictures/{graph}.png"));
        if std::env::var_os("RAXEL_WRITE_LIGHTING").is_some() {
            picture.save(&path).unwrap();
            continue;
        }
        let reference = image::open(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).into_rgb8();
        let [reference, mine] =
            [&reference, &picture].map(|image| FlipImageRgb8::with_data(image.width(), image.height(), image));
        let error = FlipPool::from_image(&flip(reference, mine, DEFAULT_PIXELS_PER_DEGREE)).mean();
        if error > tolerance {
            picture.save(path.with_extension("new.png")).unwrap();
            wrong.push(format!("{what}: a mean FLIP error of {error:.4}, where {tolerance} is allowed"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

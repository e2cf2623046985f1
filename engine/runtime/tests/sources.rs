//! Sources in sessions: worlds that are written in part, files, models, copies. On a real device with the validation layer on.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(clippy::float_cmp, reason = "texels are compared with the very values that were written")]

mod project;

use std::fs;
use std::time::Duration;

use project::{Project, Sessions, red, red_after_frame, texel};
use raxel_execute::WriteError;
use raxel_layouts::Layout;
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::{OpenError, Options, Session};

/// 4³ voxels without the four at y = z = 3.
const BOX_WITHOUT_AN_EDGE: &str = include_str!("fixtures/sources/box.toml");

#[test]
fn a_world_that_is_written_in_part_shows_in_the_next_frame() {
    let project = Project::filled();
    project.write("graphs/world.toml", project::WORLD_GRAPH);
    project.write("shaders/world.comp", project::WORLD_SHADER);
    project.write("worlds/box.toml", BOX_WITHOUT_AN_EDGE);
    let mut session = project.open_graph("graphs/world.toml");
    assert_eq!(red_after_frame(&mut session), 60.0);
    assert_eq!(session.frame().unwrap().dispatched, 0);

    // The same box without the opposite edge: its bytes differ in a few places.
    let limits = raxel_runtime::sources::layout_limits(session.device());
    let now = Layout::TREE64.encode(session.world().voxels(), limits).unwrap().words;
    let other = {
        let cells = (4..64).map(|cell| glam::IVec3::new(cell % 4, cell / 4 % 4, cell / 16));
        let materials = session.world().voxels().materials().to_vec();
        let world = raxel_world::World::from_voxels(materials, cells.map(|cell| (cell, 1)));
        Layout::TREE64.encode(&world, limits).unwrap().words
    };
    assert_eq!(now.len(), other.len());
    let version = session.source("world.tree64").unwrap().version();
    let changed: Vec<usize> = (0..now.len()).filter(|at| now[*at] != other[*at]).collect();
    assert!((1..now.len() / 2).contains(&changed.len()), "{changed:?}");
    for at in changed {
        session.write_source("world.tree64", 4 * at as u64, &other[at].to_le_bytes()).unwrap();
    }
    assert_eq!(session.frame().unwrap().dispatched, 1);
    assert_eq!(red(&mut session), 0.0);
    assert_ne!(session.source("world.tree64").unwrap().version(), version);
    assert_eq!(session.frame().unwrap().dispatched, 0);

    // A layout that nothing binds is not there.
    let missing = session.write_source("world.svo", 0, &[0; 4]);
    assert_eq!(missing, Err(WriteError::NotThere { name: "world.svo".to_owned() }));
    project::assert_silent(&session);
}

const FILES_GRAPH: &str = include_str!("fixtures/sources/files.toml");

const HALF: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler2D picture;
layout(rgba32f) uniform writeonly image2D outColor;
void main() {
    imageStore(outColor, ivec2(gl_GlobalInvocationID.xy), vec4(textureLod(picture, vec2(0.5), 1.0).r));
}
";

/// A texel of the file, the mean by its mip, a word of the table, the width of the file.
const FILES: &str = include_str!("fixtures/sources/files.comp");

/// A grey PNG of two rows.
fn png(rows: [&[u8]; 2]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, rows[0].len() as u32, 2);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&rows.concat()).unwrap();
    writer.finish().unwrap();
    file
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn files_project() -> Project {
    let project = Project::filled();
    project.write("graphs/files.toml", FILES_GRAPH);
    project.write("shaders/half.comp", HALF);
    project.write("shaders/files.comp", FILES);
    project.write("textures/a.png", "");
    project.write("data/table.bin", "");
    fs::write(project.path("textures/a.png"), png([&[10, 20], &[30, 40]])).unwrap();
    fs::write(project.path("data/table.bin"), floats(&[1.0, 2.5])).unwrap();
    project
}

#[test]
fn files_are_sources_and_edits_of_them_are_swapped_in() {
    let project = files_project();
    let mut session = project.open_graph("graphs/files.toml");
    session.frame().unwrap();
    assert_eq!(texel(&mut session), [20.0, 25.0, 2.5, 2.0]);
    assert_eq!(session.frame().unwrap().dispatched, 0);

    fs::write(project.path("textures/a.png"), png([&[0, 50, 0, 0], &[0, 50, 0, 0]])).unwrap();
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
    session.frame().unwrap();
    let [red, _, table, width] = texel(&mut session);
    assert_eq!([red, table, width], [50.0, 2.5, 4.0]);

    // A file that is broken stops the edit, names itself and the graph, and what ran runs on.
    fs::write(project.path("textures/a.png"), &png([&[7, 7], &[7, 7]])[..40]).unwrap();
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Failed(failed)] = events.as_slice() else { panic!("{events:#?}") };
    assert_eq!(failed.changed, ["textures/a.png"]);
    let [error] = failed.diagnostics.as_slice() else { panic!("{failed:#?}") };
    assert!(error.message.contains("textures/a.png"), "{error:?}");
    assert_eq!(&*error.labels[0].span.file, "graphs/files.toml");
    session.frame().unwrap();
    assert_eq!(texel(&mut session)[0], 50.0);

    // Mended, and the table is edited with it.
    fs::write(project.path("data/table.bin"), floats(&[0.0, 8.0, 9.0])).unwrap();
    fs::write(project.path("textures/a.png"), png([&[1, 2], &[3, 4]])).unwrap();
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(matches!(events.last(), Some(ReloadEvent::Reloaded(_))), "{events:#?}");
    session.frame().unwrap();
    let [red, _, table, width] = texel(&mut session);
    assert_eq!([red, table, width], [2.0, 8.0, 2.0]);
    project::assert_silent(&session);
}

#[test]
fn files_that_cannot_be_had_are_diagnosed() {
    let project = files_project();
    let refused = |graph: &str| {
        project.write("graphs/refused.toml", graph);
        let options = Options { graph: Some("graphs/refused.toml".into()), ..project.options() };
        match Session::open(options) {
            Err(OpenError::Project { diagnostics, .. }) => {
                diagnostics.iter().flat_map(|d| [&d.message].into_iter().chain(&d.help)).cloned().collect()
            }
            other => vec![format!("{:?}", other.err())],
        }
    };
    let with = |from: &str, to: &str| refused(&FILES_GRAPH.replace(from, to)).join("; ");
    let missing = with("a.png", "b.png");
    assert!(missing.contains("`textures/b.png` does not exist"), "{missing}");
    let meant = with("file.data/table.bin", "file.data/tabel.bin");
    assert!(meant.contains("does not exist; did you mean `data/table.bin`?"), "{meant}");
    let outside = with("file.textures/a.png", "file.../a.png");
    assert!(outside.contains("is not a path inside the project"), "{outside}");
    let kind = with("file.textures/a.png", "file.data/table.bin");
    assert!(kind.contains("is not a picture"), "{kind}");
    let format = with("mips = \"full\"", "format = \"rg8\"");
    assert!(format.contains("1 channel of 8 bits, which `rg8` does not fit"), "{format}");
    let size = with("mips = \"full\"", "size = [2, 2]");
    assert!(size.contains("size"), "{size}");
}

const COPY_GRAPH: &str = include_str!("fixtures/sources/copy.toml");

const DIG: &str = r"#version 460
#define RX_WRITE_world
#include <raxel/world.glsl>
layout(local_size_x = 2, local_size_y = 2, local_size_z = 2) in;
void main() { rx_set(ivec3(gl_LocalInvocationID), 0u); }
";

/// The same over the image of `texture3d`. A pass writes its first mip.
const COPY_IMAGE: [(&str, &str); 3] = [
    (
        "[buffers.mine]\ncopy = \"world.octree\"",
        "[targets.mine]\ncopy = \"world.texture3d\"\n[buffers.world]\nsource = \"world.texture3d\"",
    ),
    ("bind = { world = \"mine\" }", "bind = { world = \"world\", world_texels = { target = \"mine\", mip = 0 } }"),
    ("world = \"mine\", pine", "world = \"world\", world_voxels = \"mine\", pine"),
];

/// Solid voxels in a box of the copy and of the model.
const COUNT_SOLID: &str = include_str!("fixtures/sources/count.comp");

#[test]
fn shaders_dig_into_a_copy_beside_a_model_and_an_edit_of_the_world_fills_it_again() {
    let project = Project::filled();
    project.write("graphs/copy.toml", COPY_GRAPH);
    project.write("shaders/dig.comp", DIG);
    project.write("shaders/count.comp", COUNT_SOLID);
    let model = "\n[models.pine]\nfile = \"pine.vox\"\n";
    project.write("worlds/box.toml", &(project::box_world(6) + model));
    let cells = (0..5).map(|x| (glam::IVec3::new(x, 0, 0), 1));
    let pine = raxel_world::World::from_voxels(vec![raxel_world::Material::air(); 2], cells);
    fs::write(project.path("worlds/pine.vox"), raxel_world::vox::export(&pine).unwrap()).unwrap();
    let mut session = project.open_graph("graphs/copy.toml");
    session.frame().unwrap();
    let dug = [6.0 * 6.0 * 6.0 - 8.0, 5.0];
    assert_eq!(texel(&mut session)[..2], dug);
    assert_eq!(session.frame().unwrap().dispatched, 0);
    // In every layout that has rx_set.
    let image = COPY_IMAGE.iter().fold(COPY_GRAPH.to_owned(), |text, (from, to)| text.replacen(from, to, 1));
    for text in [COPY_GRAPH.replace("octree", "chunks"), COPY_GRAPH.replace("octree", "chunk_table"), image] {
        project.write("graphs/other.toml", &text);
        let mut other = project.open_graph("graphs/other.toml");
        other.frame().unwrap();
        assert_eq!(texel(&mut other)[..2], dug, "{text}");
        project::assert_silent(&other);
    }
    // The world itself is as it was, and a reset fills the copy with it before the pass digs again.
    session.reset();
    session.frame().unwrap();
    assert_eq!(red(&mut session), 208.0);
    project.write("worlds/box.toml", &(project::box_world(3) + model));
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
    // The pass that digs is not due; what it dug is gone with the old world.
    session.frame().unwrap();
    assert_eq!(red(&mut session), 27.0);
    // A model that the world does not have.
    project.write("worlds/box.toml", project::box_world(3));
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Failed(failed)] = events.as_slice() else { panic!("{events:#?}") };
    assert!(failed.diagnostics[0].message.contains("there is no model `pine`"), "{failed:#?}");
    project::assert_silent(&session);
}

//! .vox files: out and in again, as other programs read them, and broken in every way.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod project;

use std::collections::HashMap;

use glam::IVec3;
use project::Project;
use proptest::prelude::*;
use raxel_diagnostics::SourceMap;
use raxel_world::vox::{VoxErrorKind, export, import, import_frame};
use raxel_world::{Material, World};

fn voxels(world: &World) -> HashMap<[i32; 3], String> {
    let name = |material: u16| world.materials()[usize::from(material)].name.clone();
    world.voxels().map(|(cell, material)| (cell.to_array(), name(material))).collect()
}

fn palette() -> Vec<Material> {
    let grey = |name: &str, byte| Material::matt(name, [raxel_world::linear_from_srgb(byte); 3]);
    vec![
        Material::air(),
        grey("plain", 10),
        Material { metallic: 0.75, roughness: 0.125, ..grey("metal", 20) },
        Material { transparency: 0.5, roughness: 0.0, ..grey("glass", 30) },
        Material { emission: 0.3, ..grey("dim", 40) },
        Material { emission: 7.25, roughness: 0.5, ..grey("bright", 50) },
        Material { emission: 1.5, metallic: 0.5, transparency: 0.25, roughness: 0.25, ..grey("all", 60) },
        Material { roughness: 0.4, ..grey("smooth", 70) },
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_goes_out_comes_in(cells in prop::collection::vec((-700..700i32, -300..300i32, -700..700i32, 1..8u16), 1..60)) {
        let world = World::from_voxels(palette(), cells.into_iter().map(|(x, y, z, m)| (IVec3::new(x, y, z), m)));
        let back = import(&export(&world).expect("it is small")).expect("ours");
        prop_assert_eq!(voxels(&world), voxels(&back));
        for material in &back.materials()[1..] {
            prop_assert!(world.materials().contains(material), "{:?}", material);
        }
    }

    #[test]
    fn broken_files_are_errors_not_panics(cuts in 0..2usize, edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12), end in any::<prop::sample::Index>()) {
        let mut bytes = sample();
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if cuts == 1 {
            bytes.truncate(end.index(bytes.len()));
        }
        // Import returns for any bytes, and an accepted file has voxels that can be looked at.
        if let Ok(world) = import(&bytes) {
            prop_assert_eq!(world.voxels().count() as u64, world.solids());
        }
    }
}

/// A file with every kind of chunk, several models and a scene graph.
fn sample() -> Vec<u8> {
    let line = (0..300).map(|x| (IVec3::new(x - 20, x / 9, x % 5), (x % 7 + 1) as u16));
    export(&World::from_voxels(palette(), line)).expect("it is small")
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = sample();
    assert!(import(&bytes).is_ok());
    for end in 0..bytes.len() {
        let error = import(&bytes[..end]).expect_err("cut off");
        assert_eq!(error.kind, VoxErrorKind::Structure, "{end}: {error}");
    }
}

#[test]
fn other_readers_agree() {
    let data = dot_vox::load_bytes(&sample()).expect("a .vox file");
    assert_eq!(data.models.len(), 3, "x = 0 and x = 256 divide it");
    assert_eq!(data.models.iter().map(|model| model.voxels.len()).sum::<usize>(), 300);
    assert!(data.models.iter().all(|model| model.size.x <= 256));
    assert_eq!(data.palette[..2].iter().map(|c| [c.r, c.g, c.b]).collect::<Vec<_>>(), [[10; 3], [20; 3]]);
    assert_eq!((data.materials[4].emission(), data.materials[4].radiant_flux()), (Some(1.0), Some(6.25)));
    assert_eq!(data.scenes.len(), 2 + 2 * 3);
    let places: Vec<_> = (data.scenes.iter())
        .filter_map(|node| match node {
            dot_vox::SceneNode::Transform { frames, .. } => frames[0].position().map(|p| p.x),
            _ => None,
        })
        .collect();
    assert_eq!(places, [-10, 128, 268], "the middles of −20…−1, 0…255 and 256…279");
}

/// Writes a .vox file chunk by chunk.
#[derive(Default)]
struct Vox(Vec<u8>);

impl Vox {
    fn chunk(mut self, id: &str, content: &[u32]) -> Self {
        self.0.extend(id.as_bytes());
        self.0.extend((content.len() as u32 * 4).to_le_bytes());
        self.0.extend(0u32.to_le_bytes());
        self.0.extend(content.iter().flat_map(|word| word.to_le_bytes()));
        self
    }

    fn bytes(mut self, id: &str, content: &[u8]) -> Self {
        self.0.extend(id.as_bytes());
        self.0.extend((content.len() as u32).to_le_bytes());
        self.0.extend(0u32.to_le_bytes());
        self.0.extend(content);
        self
    }

    /// A model with single voxels of palette index 1.
    fn model(self, size: [u32; 3], voxels: &[[u8; 3]]) -> Self {
        let mut content = (voxels.len() as u32).to_le_bytes().to_vec();
        content.extend(voxels.iter().flat_map(|[x, y, z]| [*x, *y, *z, 1]));
        self.chunk("SIZE", &size).bytes("XYZI", &content)
    }

    fn transform(self, id: u32, child: u32, layer: u32, attributes: &[(&str, &str)], frame: &[(&str, &str)]) -> Self {
        let mut content = id.to_le_bytes().to_vec();
        content.extend(dictionary(attributes));
        content.extend([child, u32::MAX, layer, 1].iter().flat_map(|word| word.to_le_bytes()));
        content.extend(dictionary(frame));
        self.bytes("nTRN", &content)
    }

    fn group(self, id: u32, children: &[u32]) -> Self {
        self.chunk("nGRP", &[&[id, 0, children.len() as u32], children].concat())
    }

    fn shape(self, id: u32, model: u32) -> Self {
        self.chunk("nSHP", &[id, 0, 1, model, 0])
    }

    fn finish(self) -> Vec<u8> {
        let mut file = b"VOX \x96\0\0\0MAIN\0\0\0\0".to_vec();
        file.extend((self.0.len() as u32).to_le_bytes());
        file.extend(self.0);
        file
    }

    fn cells(self) -> Vec<[i32; 3]> {
        let mut cells: Vec<_> =
            import(&self.finish()).expect("a good file").voxels().map(|(cell, _)| cell.to_array()).collect();
        cells.sort_unstable();
        cells
    }
}

fn dictionary(entries: &[(&str, &str)]) -> Vec<u8> {
    let mut out = (entries.len() as u32).to_le_bytes().to_vec();
    for text in entries.iter().flat_map(|(key, value)| [key, value]) {
        out.extend((text.len() as u32).to_le_bytes());
        out.extend(text.as_bytes());
    }
    out
}

#[test]
fn models_stand_about_their_middle() {
    // Without a scene graph they stand on the ground; (x, y, z) with Z up is (x, z, −y − 1) with Y up.
    assert_eq!(Vox::default().model([4, 2, 3], &[[0, 0, 0]]).cells(), [[-2, 0, 0]]);
    // With one, half the size (rounded down) is at the translation.
    let placed = |frame: &[(&str, &str)]| {
        Vox::default().model([3, 2, 5], &[[0, 0, 0]]).transform(0, 1, 0, &[], frame).shape(1, 0).cells()
    };
    assert_eq!(placed(&[]), [[-1, -2, 0]]);
    assert_eq!(placed(&[("_t", "10 20 30")]), [[9, 28, -20]]);
    // Row 0 takes −y, row 1 takes x: a quarter turn about Z. Cell (−1, −1, −2) becomes (0, −1, −2).
    assert_eq!(placed(&[("_r", "17")]), [[0, -2, 0]]);
}

#[test]
fn transforms_nest() {
    let cells = Vox::default()
        .model([1, 1, 1], &[[0, 0, 0]])
        .transform(0, 1, 0, &[], &[("_t", "100 0 0"), ("_r", "17")])
        .group(1, &[2, 4])
        .transform(2, 3, 0, &[], &[("_t", "5 0 0")])
        .shape(3, 0)
        .transform(4, 5, 0, &[], &[("_t", "0 7 0")])
        .shape(5, 0)
        .cells();
    // (5, 0, 0) turns to (0, 5, 0), (0, 7, 0) to (−7, 0, 0); a mirrored cell lies one lower.
    assert_eq!(cells, [[92, 0, -1], [99, 0, -6]]);
}

fn cells_of(world: &World) -> Vec<[i32; 3]> {
    world.voxels().map(|(cell, _)| cell.to_array()).collect()
}

#[test]
fn models_without_a_scene_are_frames() {
    let file = Vox::default()
        .chunk("PACK", &[3])
        .model([1, 1, 1], &[[0, 0, 0]])
        .model([1, 1, 2], &[[0, 0, 1]])
        .model([1, 1, 3], &[[0, 0, 2]])
        .finish();
    assert_eq!(cells_of(&import(&file).expect("the first frame")), [[0, 0, -1]]);
    for (frame, cell) in (0..).zip([[0, 0, -1], [0, 1, -1], [0, 2, -1]]) {
        assert_eq!(cells_of(&import_frame(&file, frame).expect("a frame")), [cell], "{frame}");
    }
    let error = import_frame(&file, 3).expect_err("the fourth of three");
    assert_eq!(error.kind, VoxErrorKind::Frame);
    assert!(error.to_string().starts_with("there is no frame 3: the file has 3 frames, 0 to 2"), "{error}");
    let error = import_frame(&Vox::default().model([1, 1, 1], &[[0, 0, 0]]).finish(), 1).expect_err("one model");
    assert!(error.to_string().contains("one frame, 0"), "{error}");
}

#[test]
fn a_key_counts_until_the_next() {
    // A transform with keys at 2 and 5, and a shape that shows model 1 from frame 4 on.
    let mut transform = [0u32.to_le_bytes(), 0u32.to_le_bytes()].concat();
    transform.extend([1, u32::MAX, 0, 2].iter().flat_map(|word| word.to_le_bytes()));
    transform.extend(dictionary(&[("_t", "10 0 0"), ("_f", "2")]));
    transform.extend(dictionary(&[("_t", "20 0 0"), ("_f", "5")]));
    let mut shape = [1u32, 0, 2, 0].iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    shape.extend(dictionary(&[("_f", "0")]));
    shape.extend(1u32.to_le_bytes());
    shape.extend(dictionary(&[("_f", "4")]));
    let file = Vox::default()
        .model([1, 1, 1], &[[0, 0, 0]])
        .model([1, 1, 2], &[[0, 0, 1]])
        .bytes("nTRN", &transform)
        .bytes("nSHP", &shape)
        .finish();
    for (frame, x, y) in [(0, 10, 0), (2, 10, 0), (3, 10, 0), (4, 10, 0), (5, 20, 0)] {
        let found = cells_of(&import_frame(&file, frame).expect("a frame"));
        assert_eq!(found, [[x, y, -1]], "frame {frame}");
    }
    assert_eq!(import_frame(&file, 6).expect_err("after the last key").kind, VoxErrorKind::Frame);
}

#[test]
fn a_world_chooses_frames_of_its_models() {
    let file = Vox::default().model([1, 1, 1], &[[0, 0, 0]]).model([1, 2, 1], &[[0, 0, 0], [0, 1, 0]]).finish();
    let mut project = Project::default();
    project.0.insert("worlds/a.vox".to_owned(), file);
    let mut load = |frame: &str| {
        let text = format!(
            r#"[models.first]
file = "a.vox"
[models.other]
file = "a.vox"
{frame}
[[build]]
op = "model"
model = "first"
[[build]]
op = "model"
model = "other"
origin = [9, 0, 0]
"#
        );
        project.0.insert("worlds/w.toml".to_owned(), text.into_bytes());
        raxel_worldfile::load("worlds/w.toml", &project, &mut SourceMap::default())
    };
    assert_eq!(load("").expect("the first frame").0.world.solids(), 2);
    let (loaded, _) = load("frame = 1").expect("the second frame");
    assert_eq!(loaded.world.solids(), 3);
    assert_eq!(loaded.files, ["worlds/w.toml", "worlds/a.vox"]);
    let found = load("frame = 2").expect_err("the third of two");
    assert_eq!(found[0].code.as_str(), "RX0324");
    assert_eq!(found.len(), 1);
    assert!(found[0].message.ends_with("there is no frame 2: the file has 2 frames, 0 to 1"), "{}", found[0].message);
    assert!(load("frame = -1").is_err());
}

/// The largest model that MagicaVoxel writes: 64 MiB of voxels, and a few bytes around them.
#[test]
fn a_full_model_is_not_too_large() {
    let mut voxels = Vec::with_capacity(4 + (4 << 24));
    voxels.extend((1u32 << 24).to_le_bytes());
    for z in 0..=255u8 {
        for y in 0..=255u8 {
            voxels.extend((0..=255u8).flat_map(|x| [x, y, z, 7]));
        }
    }
    let file = Vox::default().chunk("SIZE", &[256; 3]).bytes("XYZI", &voxels).finish();
    assert!(file.len() > 64 << 20);
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("full.vox"), &file).expect("room");
    let files = raxel_diagnostics::DiskFiles::new(folder.path()).expect("a folder");
    let (loaded, _) =
        raxel_worldfile::load("full.vox", &files, &mut SourceMap::default()).expect("it is not too large");
    assert_eq!(loaded.world.solids(), 1 << 24);
}

#[test]
fn hidden_layers_and_nodes_are_not_there() {
    let scene = |attributes: &[(&str, &str)]| {
        let mut layer = 1u32.to_le_bytes().to_vec();
        layer.extend(dictionary(&[("_hidden", "1")]));
        layer.extend(u32::MAX.to_le_bytes());
        Vox::default()
            .model([1, 1, 1], &[[0, 0, 0]])
            .transform(0, 1, u32::MAX, &[], &[])
            .group(1, &[2, 4, 6])
            .transform(2, 3, 1, &[], &[])
            .shape(3, 0)
            .transform(4, 5, 0, attributes, &[("_t", "5 0 0")])
            .shape(5, 0)
            .transform(6, 7, 0, &[], &[("_t", "9 0 0")])
            .shape(7, 0)
            .bytes("LAYR", &layer)
            .cells()
            .len()
    };
    assert_eq!(scene(&[]), 2);
    assert_eq!(scene(&[("_hidden", "1")]), 1);
}

#[test]
fn mistakes_say_what_and_where() {
    let one = || Vox::default().model([1, 1, 1], &[[0, 0, 0]]);
    let placed = |frame: &[(&str, &str)]| one().transform(0, 1, 0, &[], frame).shape(1, 0).finish();
    let mut doubling = one();
    for id in 0..40 {
        doubling = doubling.group(id, &[id + 1, id + 1]);
    }
    let mut ladder = one();
    for id in 0..400 {
        ladder = ladder.transform(id, id + 1, 0, &[], &[]);
    }
    let cases = [
        ("empty", Vec::new()),
        ("another file", b"\x89PNG\r\n\x1a\n".to_vec()),
        ("no main", b"VOX \x96\0\0\0PACK\0\0\0\0\0\0\0\0".to_vec()),
        ("count", Vox::default().chunk("SIZE", &[1, 1, 1]).chunk("XYZI", &[0x4000_0000, 0]).finish()),
        ("size", Vox::default().chunk("SIZE", &[0, 1, 1]).finish()),
        ("no size", Vox::default().chunk("XYZI", &[0]).finish()),
        ("outside", Vox::default().model([2, 2, 2], &[[1, 1, 1], [0, 2, 0]]).finish()),
        ("palette", one().bytes("RGBA", &[0; 1020]).finish()),
        ("attributes", one().chunk("nGRP", &[0, u32::MAX]).finish()),
        ("rotation", placed(&[("_r", "5")])),
        ("rotation word", placed(&[("_r", "north")])),
        ("translation", placed(&[("_t", "1 2")])),
        ("translation size", placed(&[("_t", "99999999999 0 0")])),
        (
            "far",
            one()
                .transform(0, 1, 0, &[], &[("_t", "2147483647 0 0")])
                .transform(1, 2, 0, &[], &[("_t", "2147483647 0 0")])
                .shape(2, 0)
                .finish(),
        ),
        ("model id", one().transform(0, 1, 0, &[], &[]).shape(1, 7).finish()),
        ("node id", one().transform(0, 9, 0, &[], &[]).finish()),
        ("two nodes", one().group(0, &[]).group(0, &[]).finish()),
        ("itself", one().group(0, &[0]).finish()),
        ("cycle", one().transform(0, 1, 0, &[], &[]).group(1, &[2]).transform(2, 1, 0, &[], &[]).finish()),
        ("doubling", doubling.group(40, &[]).finish()),
        ("ladder", ladder.shape(400, 0).finish()),
        ("material", one().chunk("MATL", &[700, 0]).finish()),
    ];
    let found: Vec<String> = (cases.into_iter())
        .map(|(name, bytes)| {
            let error = import(&bytes).expect_err(name);
            format!("{name}: {:?}: {error}", error.kind)
        })
        .collect();
    insta::assert_snapshot!(found.join("\n"));
}

#[test]
fn real_scenes_have_the_voxels_their_makers_say() {
    // The project's own scene stands in for those of others, which are not part of it.
    let own = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../worlds/models/monument.vox")).expect("shipped");
    assert_eq!(import(&own).expect("ours").solids(), 114_424);
    let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/scenes");
    for (name, solids) in [("scene_church1.vox", 181_774), ("scene_store8.vox", 441_118)] {
        if let Ok(bytes) = std::fs::read(format!("{scenes}/{name}")) {
            let world = import(&bytes).expect(name);
            assert_eq!(world.solids(), solids, "{name}");
            let back = import(&export(&world).expect(name)).expect(name);
            assert_eq!(voxels(&world), voxels(&back), "{name}");
        }
    }
}

#[test]
fn too_many_materials_cannot_go_out() {
    let materials = (0..=256).map(|i| Material::matt(format!("m{i}"), [0.5; 3])).collect();
    let world = World::from_voxels(materials, (1..=256).map(|i| (IVec3::new(i, 0, 0), i as u16)));
    assert_eq!(
        export(&world).expect_err("256 materials").to_string(),
        "the world uses 256 materials; a .vox file has at most 255"
    );
}

#[test]
fn a_scene_is_a_world() {
    let mut project = Project::default();
    project.0.insert("scene.VOX".to_owned(), sample());
    let (loaded, warnings) = raxel_worldfile::load("scene.VOX", &project, &mut SourceMap::default())
        .expect("a scene loads without a world file");
    assert_eq!((loaded.world.solids(), loaded.name.as_str(), warnings.len()), (300, "scene", 0));
    project.0.insert("scene.VOX".to_owned(), b"VOX ".to_vec());
    let found = raxel_worldfile::load("scene.VOX", &project, &mut SourceMap::default()).expect_err("cut off");
    assert_eq!(found[0].code.as_str(), "RX0320");
}

//! Worlds without end: a tile is the same for every caller, at any time, and in any order.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod project;

use glam::IVec3;
use project::{MATERIALS, Project};
use proptest::prelude::*;
use raxel_world::{ChunkPos, ChunkProvider, Content, DenseChunk, World, reduce};
use raxel_worldfile::Loaded;

const LAND: &str = r#"
op = "terrain"
base = 20
amplitude = 70
frequency = 0.01
octaves = 4
floor = -60
river = { bed = 25, width = 5, banks = 40, frequency = 0.004 }
water = { material = "c", level = 34 }
layers = [{ material = "a", depth = 2 }, { material = "b" }]
bands = [{ material = "c", slope = 3 }, { material = "b", above = 70, depth = 5 }]
caves = { width = 0.2, frequency = 0.03, octaves = 2, cover = 1, above = -40 }
"#;

const MODELS: &str = r#"
op = "scatter"
model = "arrow"
cell = 11
chance = 0.5
min_spacing = 3
on = ["a", "b"]
sink = 1
"#;

const MORE: &str = r#"
[[build]]
op = "sphere"
center = [70, 90, 60]
radius = 80
material = "c"
[[build]]
op = "box"
mode = "subtract"
min = [-64, 10, -64]
max = [0, 74, 64]
[[build]]
op = "box"
mode = "paint"
material = "a"
min = [-300, 0, 40]
max = [300, 60, 50]
"#;

fn world(head: &str, area: &str) -> Loaded {
    let text = format!("{MATERIALS}{head}\n[[build]]\n{LAND}{area}\n[[build]]\n{MODELS}{area}\n{MORE}");
    Project::with_world(&text).load().unwrap_or_else(|found| panic!("{found:?}")).0
}

fn endless() -> std::sync::Arc<dyn ChunkProvider> {
    world("[stream]", "").stream.expect("it has [stream]").generator
}

/// The chunks of a box of chunks, `min` inside and `max` not, as a world of their own.
fn cut(source: &dyn ChunkProvider, min: ChunkPos, max: ChunkPos) -> World {
    let mut chunks = Vec::new();
    for y in min.y..max.y {
        for z in min.z..max.z {
            for x in min.x..max.x {
                let pos = ChunkPos::new(x, y, z);
                chunks.extend(source.try_chunk(0, pos).unwrap().to_chunk().map(|chunk| (pos, chunk)));
            }
        }
    }
    World::new(source.materials().to_vec(), chunks)
}

fn positions() -> Vec<ChunkPos> {
    let mut all = Vec::new();
    for y in -2..3 {
        for z in -3..3 {
            all.extend((-3..3).map(|x| ChunkPos::new(x, y, z)));
        }
    }
    all
}

fn is(world: &World, pos: ChunkPos, content: &Content) -> bool {
    content.to_chunk().as_deref() == world.chunk(pos).map(|chunk| &**chunk)
}

#[test]
fn a_bounded_world_is_a_part_of_the_endless_one() {
    // Models stand as far out as they like; only what the bounds cut off is missing.
    let bounded = world("", "min = [-320, -320]\nmax = [320, 320]");
    let generator = endless();
    let mut mixed = 0;
    for pos in positions() {
        let content = generator.try_chunk(0, pos).unwrap();
        assert!(is(&bounded.world, pos, &content), "{pos:?}: {content:?} and {:?}", bounded.world.chunk(pos));
        mixed += usize::from(matches!(content, Content::Chunk(_)));
    }
    assert!(mixed > 30, "{mixed} chunks are neither empty nor full");
    let cut = cut(&*generator, ChunkPos::new(-3, -2, -3), ChunkPos::new(3, 3, 3));
    assert!(cut.counts()[1..].iter().all(|count| *count > 0), "all materials are there: {:?}", cut.counts());
}

#[test]
fn threads_and_order_make_no_difference() {
    let expected: Vec<Content> = positions().into_iter().map(|pos| endless().try_chunk(0, pos).unwrap()).collect();
    let generator = endless();
    std::thread::scope(|scope| {
        for turn in 0..4 {
            let (generator, expected) = (&generator, &expected);
            scope.spawn(move || {
                let mut order: Vec<usize> = (0..expected.len()).collect();
                order.rotate_left(turn * 37);
                if turn % 2 == 1 {
                    order.reverse();
                }
                for i in order {
                    assert_eq!(generator.try_chunk(0, positions()[i]).unwrap(), expected[i]);
                }
            });
        }
    });
}

/// The centre of a coarse cell may lie outside of a shape that has a material for each place.
#[test]
fn coarse_cells_at_the_edge_of_a_shape_have_a_material() {
    for level in 1..=4 {
        let sponge = "op = \"menger\"\nmaterial = [\"a\", \"b\"]";
        let text = format!("{MATERIALS}\n[stream]\n[[build]]\n{sponge}\nlevel = {level}\norigin = [8, 8, 0]\n");
        let generator = Project::with_world(&text).load().expect("it is right").0.stream.unwrap().generator;
        for of_detail in 0..=raxel_world::MAX_LEVEL {
            assert!(
                generator.try_chunk(of_detail, ChunkPos::new(0, 0, 0)).unwrap().to_chunk().is_some(),
                "level {of_detail}"
            );
        }
    }
}

#[test]
fn caves_take_land_alone_and_leave_their_cover() {
    let text = |caves: &str| {
        let land = LAND.lines().filter(|line| !line.starts_with("caves")).collect::<Vec<_>>().join("\n");
        format!("{MATERIALS}\n[stream]\n[[build]]\n{land}\n{caves}")
    };
    let load = |caves: &str| Project::with_world(&text(caves)).load().expect("it is right").0.stream.unwrap().generator;
    let (whole, hollow) =
        (load(""), load("caves = { width = 0.25, frequency = 0.04, cover = 3, above = -10, below = 40 }"));
    let mut taken = 0;
    for pos in positions() {
        let [a, b] = [&whole, &hollow].map(|generator| generator.try_chunk(0, pos).unwrap());
        let mut dense = [DenseChunk::default(), DenseChunk::default()];
        a.unpack(&mut dense[0]);
        b.unpack(&mut dense[1]);
        for block in 0..4096 {
            let (before, after) = (dense[0].masks()[block], dense[1].masks()[block]);
            assert_eq!(after & !before, 0, "nothing is added");
            for bit in (0..64).filter(|bit| before >> bit & 1 == 1) {
                let (before, now) = (dense[0].block(block)[bit], after >> bit & 1 == 1);
                let [_, y, _] = raxel_world::block_cell(block);
                let y = i64::from(pos.y) * 64 + i64::from(y) * 4 + (bit as i64 >> 4);
                if now {
                    assert_eq!(dense[1].block(block)[bit], before);
                } else {
                    taken += 1;
                    assert!((-10..40).contains(&y), "hollow at {y}");
                }
            }
        }
    }
    assert!(taken > 10_000, "{taken} voxels are hollow");
}

/// A coarse cell is land if most of it is land. A cell with a solid lower part may be empty, but not below another solid cell.
#[test]
fn coarse_land_has_no_holes() {
    let text = format!("{MATERIALS}\n[stream]\n[[build]]\n{}", LAND.replace("caves", "#"));
    let generator = Project::with_world(&text).load().expect("it is right").0.stream.unwrap().generator;
    let (mut solids, mut missing, mut holes, mut extra) = (0u64, 0u64, 0u64, 0u64);
    let is_solid = |dense: &DenseChunk, [x, y, z]: [u32; 3]| {
        let (block, bit) = raxel_world::voxel_index(x, y, z);
        dense.masks()[block] >> bit & 1 == 1
    };
    for y in -1..1 {
        let pos = ChunkPos::new(0, y, -1);
        let mut exact = DenseChunk::default();
        for child in 0..64 {
            let [x, cy, z] = raxel_world::child_cell(child);
            let fine = ChunkPos::new(x as i32, 4 * y + cy as i32, z as i32 - 4);
            reduce(&generator.try_chunk(0, fine).unwrap(), [x, cy, z], &mut exact);
        }
        let mut coarse = DenseChunk::default();
        generator.try_chunk(1, pos).unwrap().unpack(&mut coarse);
        for n in 0..64 * 64 * 64 {
            let at = [n & 63, n >> 6 & 63, n >> 12];
            let (exact_is, coarse_is) = (is_solid(&exact, at), is_solid(&coarse, at));
            solids += u64::from(exact_is);
            extra += u64::from(coarse_is && !exact_is);
            if exact_is && !coarse_is {
                missing += 1;
                holes += u64::from(at[1] < 63 && is_solid(&exact, [at[0], at[1] + 1, at[2]]));
            }
        }
    }
    // Heights between the corners of a cell may be higher than all four.
    assert!(
        missing > 0 && holes * 200 < solids && extra * 50 < solids,
        "{missing} missing, {holes} holes and {extra} extra of {solids}"
    );
}

#[test]
fn far_land_has_the_colour_of_models_that_are_many_and_seen() {
    let load = |models: &str| {
        let text = format!("{MATERIALS}\n[stream]\n[[build]]\n{LAND}\n{models}");
        Project::with_world(&text).load().expect("it is right").0.stream.unwrap().generator
    };
    let models = |from: &str, to: &str| format!("[[build]]\n{}", MODELS.replace(from, to));
    let (land, many) = (load(""), load(&models("", "")));
    let (few, buried) = (load(&models("cell = 11", "cell = 40")), load(&models("sink = 1", "sink = 40")));
    let differ = |level: u32, other: &std::sync::Arc<dyn ChunkProvider>| {
        let other = |pos: &&ChunkPos| other.try_chunk(level, **pos).unwrap() != land.try_chunk(level, **pos).unwrap();
        positions().iter().filter(other).count()
    };
    assert!(differ(1, &many) > 10, "{}", differ(1, &many));
    assert_eq!([differ(1, &few), differ(1, &buried), differ(2, &few), differ(2, &buried)], [0; 4]);
    assert!(differ(0, &few) > 10 && differ(0, &buried) > 10, "they are there, near the camera");
}

/// A wall one voxel thick is seen from afar wherever it fills a cell from side to side; a pole is not.
#[test]
fn far_models_are_there_where_they_stop_most_rays() {
    let wall = (0..24 * 12).map(|i| (IVec3::new(i % 24, i / 24, 0), 1));
    let pole = (0..12).map(|y| (IVec3::new(12, y, 9), 1));
    let red = raxel_world::Material::matt("red", [1.0, 0.0, 0.0]);
    let model = World::from_voxels(vec![raxel_world::Material::air(), red], wall.chain(pole));
    // The land is flat, and ends where a cell does.
    let land = r#"[[build]]
op = "terrain"
base = 32
amplitude = 0.5
frequency = 0.01
layers = [{ material = "a" }]
floor = 0
"#;
    let scatter = "[[build]]\nop = \"scatter\"\nmodel = \"arrow\"\ncell = 64\nchance = 1.0\nmin_spacing = 20\n";
    let mut project = Project::with_world(&format!("{MATERIALS}\n[stream]\n{land}{scatter}"));
    project.0.insert("worlds/models/arrow.vox".to_owned(), raxel_world::vox::export(&model).unwrap());
    let generator = project.load().expect("it is right").0.stream.unwrap().generator;
    let fine = cut(&*generator, ChunkPos::new(-4, 0, -4), ChunkPos::new(4, 1, 4));
    let mut counts = [0; 2];
    for (x, z) in [(-1, -1), (-1, 0), (0, -1), (0, 0)] {
        let coarse = generator.try_chunk(1, ChunkPos::new(x, 0, z)).unwrap().to_chunk().expect("there is land");
        for n in 0..64 * 64 * 8 {
            let [cx, cy, cz] = [n & 63, 8 + n / 4096, n >> 6 & 63];
            let voxel =
                |i: i32| IVec3::new(256 * x + 4 * cx + (i & 3), 4 * cy + (i >> 2 & 3), 256 * z + 4 * cz + (i >> 4));
            let solids = (0..64).filter(|i| fine.voxel(voxel(*i)) != 0).count();
            let is_there = coarse.voxel(cx as u32, cy as u32, cz as u32) != 0;
            assert_eq!(is_there, solids >= 16, "{solids} voxels in cell {cx} {cy} {cz} of tile {x} {z}");
            if solids > 0 {
                counts[usize::from(is_there)] += 1;
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 300), "{counts:?}");
}

#[test]
fn empty_and_solid_tiles_are_known_without_their_voxels() {
    let generator = endless();
    assert_eq!(generator.try_chunk(0, ChunkPos::new(50, 40, 50)).unwrap(), Content::Empty);
    assert_eq!(generator.try_chunk(0, ChunkPos::new(50, -40, 50)).unwrap(), Content::Empty, "below the floor");
    // Above the floor there is rock with caves in it.
    let solids = generator.try_chunk(0, ChunkPos::new(9, -1, 9)).unwrap().to_chunk().unwrap().solids();
    assert!((64 * 64 * 30..=64 * 64 * 60).contains(&solids), "{solids}");
    let deep = LAND.replace("floor = -60", "floor = -6000");
    assert_ne!(deep, LAND);
    let deep = Project::with_world(&format!("{MATERIALS}\n[stream]\n[[build]]\n{deep}")).load().unwrap().0;
    assert_eq!(deep.stream.unwrap().generator.try_chunk(0, ChunkPos::new(9, -20, 9)).unwrap(), Content::Full(2));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn far_tiles_are_the_same_from_a_new_generator(x in -(1 << 24)..(1 << 24), z in -(1 << 24)..(1 << 24), y in -1..3, level in 0..4u32) {
        let pos = ChunkPos::new(x >> (2 * level), y, z >> (2 * level));
        prop_assert_eq!(endless().try_chunk(level, pos).unwrap(), endless().try_chunk(level, pos).unwrap());
    }
}

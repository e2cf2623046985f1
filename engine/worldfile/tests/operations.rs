//! Every operation against the plainest way to say the same for one voxel.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod project;

use std::collections::{HashMap, HashSet};

use glam::IVec3;
use project::{arrow, build, every_cell};
use proptest::prelude::*;
use raxel_generate::{Ball, BuildError, BuildLimits, Operation, Solid, build_within};
use raxel_world::{Material, Mode, World};

/// Builds and compares every voxel, also the empty ones around.
fn assert_is(operations: &str, expected: impl Fn([i64; 3]) -> u16) -> World {
    let world = build(operations);
    let mut solids = 0;
    every_cell(&world, |cell, material| {
        assert_eq!(material, expected(cell), "at {cell:?} of {operations}");
        solids += u64::from(material != 0);
    });
    assert_eq!(solids, world.solids());
    world
}

fn in_box(c: [i64; 3], min: [i64; 3], max: [i64; 3]) -> bool {
    (0..3).all(|i| c[i] >= min[i] && c[i] < max[i])
}

#[test]
fn boxes_by_any_two_of_their_keys() {
    let expected = |c| u16::from(in_box(c, [-3, 60, -70], [5, 67, -60]));
    for extent in [
        "min = [-3, 60, -70]\nmax = [5, 67, -60]",
        "min = [-3, 60, -70]\nsize = [8, 7, 10]",
        "center = [1, 63, -65]\nsize = [8, 7, 10]",
    ] {
        assert_is(&format!("[[build]]\nop = \"box\"\nmaterial = \"a\"\n{extent}"), expected);
    }
}

#[test]
fn a_shell_is_a_box_without_its_inside() {
    assert_is("[[build]]\nop = \"box\"\nmaterial = \"b\"\nmin = [-70, 0, 0]\nsize = [90, 30, 20]\nshell = 2", |c| {
        let outer = in_box(c, [-70, 0, 0], [20, 30, 20]);
        2 * u16::from(outer && !in_box(c, [-68, 2, 2], [18, 28, 18]))
    });
}

#[test]
fn later_operations_see_earlier_ones() {
    let operations = r#"
        [[build]]
        op = "box"
        material = "a"
        min = [0, 0, 0]
        max = [40, 40, 40]
        [[build]]
        op = "box"
        mode = "subtract"
        min = [10, 10, 10]
        max = [50, 30, 30]
        [[build]]
        op = "box"
        mode = "paint"
        material = "b"
        min = [-10, 20, -10]
        max = [60, 34, 60]
    "#;
    assert_is(operations, |c| {
        let solid = in_box(c, [0; 3], [40; 3]) && !in_box(c, [10; 3], [50, 30, 30]);
        if solid { 1 + u16::from((20..34).contains(&c[1])) } else { 0 }
    });
}

fn in_ball(c: [i64; 3], centre: [f64; 3], radius: [f64; 3]) -> bool {
    (0..3).map(|i| ((c[i] as f64 + 0.5 - centre[i]) / radius[i]).powi(2)).sum::<f64>() <= 1.0
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn spheres(x in -70.0..70.0f64, y in -9.0..9.0f64, rx in 0.9..14.0f64, ry in 0.9..14.0f64, rz in 0.9..14.0f64, shell in 1.0..6.0f64) {
        let text = format!("[[build]]\nop = \"sphere\"\nmaterial = \"a\"\ncenter = [{x:?}, {y:?}, 3.5]\nradius = [{rx:?}, {ry:?}, {rz:?}]\nshell = {shell:?}");
        assert_is(&text, |c| {
            let inner = [rx, ry, rz].map(|r| r - shell);
            let hollow = inner.iter().all(|r| *r > 0.0) && in_ball(c, [x, y, 3.5], inner);
            u16::from(in_ball(c, [x, y, 3.5], [rx, ry, rz]) && !hollow)
        });
    }

    #[test]
    fn cylinders_and_cones(axis in 0..3usize, x in -70.0..70.0f64, foot in -5..70i64, r in 1.0..12.0f64, top in 0.0..12.0f64, height in 1..30i64) {
        let mut base = [x, 0.25, 1.5];
        base[axis] = foot as f64;
        let name = ["x", "y", "z"][axis];
        let text = format!(r#"[[build]]
op = "cylinder"
material = "c"
axis = "{name}"
base = {base:?}
radius = {r:?}
top_radius = {top:?}
height = {height}"#);
        assert_is(&text, |c| {
            let above = c[axis] - foot;
            if !(0..height).contains(&above) {
                return 0;
            }
            let radius = r + (top - r) * ((above as f64 + 0.5) / height as f64);
            let distance2: f64 = (0..3).filter(|i| *i != axis).map(|i| (c[i] as f64 + 0.5 - base[i]).powi(2)).sum();
            3 * u16::from(distance2 <= radius.powi(2))
        });
    }
}

#[test]
fn menger_sponges() {
    // By division: the central third of any two axes at the same scale is a hole; the scale of the first central third is the material.
    fn at(c: [i64; 3], edge: i64, level: usize) -> u16 {
        if edge == 1 {
            return 3;
        }
        let third = edge / 3;
        let middles = c.iter().filter(|c| *c / third == 1).count();
        match middles {
            0 if level == 2 => 3,
            0 => at(c.map(|c| c % third), third, level + 1),
            1 if solid(c.map(|c| c % third), third) => level as u16 + 1,
            _ => 0,
        }
    }
    fn solid(c: [i64; 3], edge: i64) -> bool {
        let third = edge / 3;
        edge == 1 || (c.iter().filter(|c| *c / third == 1).count() < 2 && solid(c.map(|c| c % third), third))
    }
    let text = "[[build]]\nop = \"menger\"\nlevel = 3\norigin = [-13, 50, 60]\nmaterial = [\"a\", \"b\", \"c\"]";
    let world = assert_is(text, |c| {
        let local = [c[0] + 13, c[1] - 50, c[2] - 60];
        if local.iter().all(|l| (0..27).contains(l)) { at(local, 27, 0) } else { 0 }
    });
    assert_eq!(world.solids(), 20u64.pow(3));
}

#[test]
fn mazes_have_one_way_between_any_two_cells() {
    let text = r#"[[build]]
op = "maze"
material = "a"
cells = [9, 7]
cell = 3
wall = 2
height = 5
origin = [-20, 62, 3]
seed = 4"#;
    let world = build(text);
    let [width, height, depth] = world.bounds().expect("walls").size();
    assert_eq!([width, height, depth], [9 * 5 + 2, 5, 7 * 5 + 2]);
    let wall = |x: i32, y: i32, z: i32| world.voxel(IVec3::new(x - 20, y + 62, z + 3)) != 0;
    for y in 1..5 {
        for (x, z) in (0..depth as i32).flat_map(|z| (0..width as i32).map(move |x| (x, z))) {
            assert_eq!(wall(x, y, z), wall(x, 0, z), "walls are upright");
        }
    }
    // Cells joined by open squares make a tree: all are reached, and there is one passage less than cells.
    let mut passages = 0;
    let mut seen = HashSet::from([(0, 0)]);
    let mut queue = vec![(0, 0)];
    while let Some((x, z)) = queue.pop() {
        for (dx, dz) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let (at_x, at_z) = (x * 5 + 3 + dx * 2, z * 5 + 3 + dz * 2);
            if !wall(at_x, 0, at_z) {
                passages += 1;
                if seen.insert((x + dx, z + dz)) {
                    queue.push((x + dx, z + dz));
                }
            }
        }
    }
    assert_eq!(seen.len(), 63);
    assert_eq!(passages, 2 * 62, "each passage is seen from both of its ends");
    assert_eq!(world, build(text), "the same seed, the same maze");
    assert_ne!(world, build(&text.replace("seed = 4", "seed = 5")));
}

/// Height of the surface over every column of a terrain of one material.
fn heights(terrain: &str) -> HashMap<(i64, i64), i64> {
    let mut heights = HashMap::new();
    every_cell(&build(&format!("{terrain}\nlayers = [{{ material = \"a\" }}]")), |[x, y, z], material| {
        if material != 0 {
            let height = heights.entry((x, z)).or_insert(y + 1);
            *height = (*height).max(y + 1);
        }
    });
    heights
}

const TERRAIN: &str = r#"[[build]]
op = "terrain"
min = [-30, 40]
max = [45, 90]
base = -4.0
amplitude = 44.0
frequency = 0.03
floor = -20"#;

#[test]
fn terrain_has_layers_bands_and_water() {
    let heights = heights(TERRAIN);
    assert_eq!(heights.len(), 75 * 50);
    let range = heights.values().max().expect("land") - heights.values().min().expect("land");
    assert!(range > 20, "hills of {range} voxels");
    let text = format!(
        r#"{TERRAIN}
layers = [{{ material = "a", depth = 2 }}, {{ material = "b", depth = 3 }}, {{ material = "c" }}]
bands = [{{ material = "c", above = 24, depth = 3 }}, {{ material = "b", below = 20, slope = 2 }}]
water = {{ material = "b", level = 15 }}"#
    );
    // Bands look at neighbours beyond the edge, which the reference does not know.
    let inside = |x: i64, z: i64| (-29..44).contains(&x) && (41..89).contains(&z);
    every_cell(&build(&text), |[x, y, z], material| {
        let Some(&height) = heights.get(&(x, z)) else {
            assert_eq!(material, 0);
            return;
        };
        if !inside(x, z) {
            return;
        }
        let steps = [(1, 0), (-1, 0), (0, 1), (0, -1)].map(|(dx, dz)| (heights[&(x + dx, z + dz)] - height).abs());
        let steep = steps.into_iter().max() >= Some(2);
        let depth = height - 1 - y;
        let expected = match depth {
            _ if y < -20 => 0,
            ..=-1 => 2 * u16::from(y < 15),
            0..=2 if height >= 24 => 3,
            0..=1 if height < 20 && steep => 2,
            0..=1 => 1,
            _ if depth < 5 => 2,
            _ => 3,
        };
        assert_eq!(material, expected, "at {x} {y} {z}, height {height}");
    });
}

#[test]
fn a_terrain_shell_shows_the_same_surface() {
    let layers = "layers = [{ material = \"a\" }]";
    let whole = build(&format!("{TERRAIN}\n{layers}"));
    let shell = build(&format!("{TERRAIN}\nshell = 2\n{layers}"));
    assert!(shell.solids() < whole.solids() / 2);
    let [whole_at, shell_at] = [&whole, &shell]
        .map(|world| move |x: i64, y: i64, z: i64| world.voxel(IVec3::new(x as i32, y as i32, z as i32)) != 0);
    every_cell(&whole, |[x, y, z], material| {
        // Not the sides and the floor: they are cut, not surface.
        if material == 0 || !(-29..44).contains(&x) || !(41..89).contains(&z) {
            return;
        }
        let bare = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1)];
        if bare.iter().any(|(dx, dy, dz)| !whole_at(x + dx, y + dy, z + dz)) {
            assert!(shell_at(x, y, z), "a hole at {x} {y} {z}");
        }
    });
    every_cell(&shell, |[x, y, z], material| assert!(material == 0 || whole_at(x, y, z)));
}

#[test]
fn rivers_cut_down_to_their_bed() {
    let heights = heights(&format!(
        "{}\nriver = {{ bed = -12, width = 4, banks = 20, frequency = 0.02 }}",
        TERRAIN.replace("base = -4.0", "base = 10.0")
    ));
    assert_eq!(heights.values().min(), Some(&-12));
    assert!(heights.values().filter(|h| **h == -12).count() > 50);
    assert!(heights.values().filter(|h| **h > 8).count() > 50);
}

#[test]
fn terrain_is_as_good_at_the_end_of_the_world() {
    let far = TERRAIN
        .replace("min = [-30, 40]\nmax = [45, 90]", "min = [2147483600, -2147483648]\nsize = [48, 40]")
        .replace("0.03", "0.02");
    let heights = heights(&far);
    assert_eq!(heights.len(), 48 * 40);
    let steepest = heights.iter().filter_map(|((x, z), h)| Some((heights.get(&(x + 1, *z))? - h).abs())).max();
    assert!(steepest < Some(6), "noise of too few digits has cliffs: {steepest:?}");
    assert!(heights.values().max().expect("land") - heights.values().min().expect("land") > 8);
}

#[test]
fn models_turn_about_their_anchor() {
    let arrow = arrow();
    let voxels: Vec<_> =
        arrow.voxels().map(|(cell, material)| (cell.to_array().map(i64::from), material + 3)).collect();
    let anchors = [("base", [6, 0, 2]), ("corner", [3, 0, 1]), ("origin", [0, 0, 0])];
    for (name, anchor) in anchors {
        for turns in 0..4 {
            let text = format!(
                "[[build]]\nop = \"model\"\nmodel = \"arrow\"\norigin = [63, -2, -64]\nrotation = {}\nanchor = \"{name}\"",
                turns * 90
            );
            // Sizes are whole numbers of voxels: turning about the centre of the anchor's cell is turning offsets of cells.
            let expected: HashMap<[i64; 3], u16> = (voxels.iter())
                .map(|(cell, material)| {
                    let mut offset: [i64; 3] = std::array::from_fn(|i| cell[i] - anchor[i]);
                    for _ in 0..turns {
                        offset = [offset[2], offset[1], -offset[0]];
                    }
                    ([63 + offset[0], -2 + offset[1], -64 + offset[2]], *material)
                })
                .collect();
            assert_is(&text, |c| expected.get(&c).copied().unwrap_or(0));
        }
    }
}

#[test]
fn scattered_models_stand_on_their_ground_and_apart() {
    let ground = r#"[[build]]
op = "box"
material = "a"
min = [-100, 0, -100]
max = [100, 4, 100]
[[build]]
op = "box"
mode = "paint"
material = "b"
min = [0, 0, -100]
max = [100, 4, 100]
"#;
    let scatter = r#"[[build]]
op = "scatter"
model = "arrow"
min = [-90, -90]
max = [90, 90]
count = 40
on = "b"
min_spacing = 14
rotate = false
anchor = "origin""#;
    let world = build(&format!("{ground}{scatter}"));
    let plain = build(ground);
    let whole = |world: &World| world.voxels().map(|(cell, m)| (cell.to_array(), m)).collect::<HashMap<_, _>>();
    let mut added = whole(&world);
    for (cell, material) in whole(&plain) {
        assert_eq!(added.remove(&cell), Some(material));
    }
    assert_eq!(added.len() as u64, 40 * arrow().solids(), "models that far apart do not overlap");
    // The lit voxel five high is the only one of its height.
    let places: Vec<_> = added.keys().filter(|[_, y, _]| *y == 4 + 5).map(|[x, _, z]| [x - 3, z - 1]).collect();
    assert_eq!(places.len(), 40);
    for (i, [x, z]) in places.iter().enumerate() {
        assert!((0..90).contains(x) && (-90..90).contains(z), "on `b`, in the area");
        for [ox, oz] in &places[..i] {
            assert!((x - ox).pow(2) + (z - oz).pow(2) >= 14 * 14);
        }
    }
}

#[test]
fn the_corners_of_the_world_can_be_built_on() {
    for (min, cell) in [(-(1i64 << 31), i32::MIN), ((1 << 31) - 5, i32::MAX)] {
        let text = format!("[[build]]\nop = \"box\"\nmaterial = \"a\"\nmin = {:?}\nsize = [5, 5, 5]", [min; 3]);
        let world = assert_is(&text, |c| u16::from(in_box(c, [min; 3], [min + 5; 3])));
        assert_eq!(world.voxel(IVec3::splat(cell)), 1);
        assert_eq!(world.mask4(IVec3::splat(cell >> 2)), u64::MAX);
        let ball =
            format!("[[build]]\nop = \"sphere\"\nmaterial = \"a\"\ncenter = {:?}\nradius = 2.5", [min as f64 + 2.5; 3]);
        assert_is(&ball, |c| u16::from(in_ball(c, [min as f64 + 2.5; 3], [2.5; 3])));
    }
}

#[test]
fn threads_make_no_difference() {
    let terrain = TERRAIN.replace("min = [-30, 40]\nmax = [45, 90]", "min = [-150, -150]\nsize = [300, 300]");
    let text = format!(
        r#"{terrain}
layers = [{{ material = "a", depth = 2 }}, {{ material = "b" }}]
[[build]]
op = "scatter"
model = "arrow"
center = [0, 0]
size = [280, 280]
density = 0.002
[[build]]
op = "sphere"
mode = "subtract"
center = [0.0, 10.0, 0.0]
radius = 60.0
[[build]]
op = "scatter"
model = "arrow"
center = [0, 0]
size = [280, 280]
count = 20
on = ["a", "b"]"#
    );
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| build(&text))
    };
    let alone = with(1);
    assert_eq!(alone, with(2));
    assert_eq!(alone, with(7));
}

#[test]
fn equal_chunks_are_one() {
    let world = build("[[build]]\nop = \"box\"\nmaterial = \"a\"\nmin = [-128, -128, -128]\nmax = [128, 128, 128]");
    let info = world.info();
    assert_eq!((info.chunks, info.unique_chunks, info.solids), (64, 1, 1 << 24));
    assert!(info.bytes < 100_000);
}

#[test]
fn memory_is_limited_while_building() {
    let shape = Ball { centre: [0.0; 3], radius: [200.0; 3], shell: None };
    let ball = Operation::Solid(Solid { shape: Box::new(shape), mode: Mode::Add, materials: vec![1] });
    let materials = || vec![Material::air(), Material::matt("a", [1.0; 3])];
    let limits = BuildLimits { chunks: 512, bytes: 1 << 20 };
    let error = build_within(materials(), &[ball], &limits).expect_err("hundreds of different chunks");
    assert_eq!(error, BuildError::TooManyBytes { limit: 1 << 20 });
}

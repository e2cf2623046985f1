//! Lamps of streamed worlds.

use std::collections::BTreeMap;

use raxel::{Session, Value};

use super::common::Project;
use super::{open, project, silent};

/// Land under a sky, by the graph with everything, and the same land where some of it gives off light.
#[test]
fn graphs_with_lamps_show_streamed_worlds() {
    let project = project();
    let colours = |most: f32| {
        let mut session = open(&project, "beauty", &[]);
        for _ in 0..2 {
            session.frame().unwrap_or_else(|error| panic!("{error}"));
        }
        let rgba = session.read_presented().unwrap().rgba;
        let colours: std::collections::BTreeSet<&[u8]> = rgba.chunks(4).collect();
        assert!(colours.len() > 500, "land under a sky: {} colours", colours.len());
        silent(&session);
        let stats = session.stream().expect("it is bound").stats();
        assert!(stats.lights as f32 >= most && (most > 0.0 || stats.lights == 0) && stats.unlisted == 0, "{stats:?}");
    };
    colours(100.0);
    for model in ["vein", "mushroom", "hut"] {
        project.edit("worlds/frontier.toml", &format!("models/{model}.vox"), "models/tree.vox");
    }
    colours(0.0);
    project.edit("worlds/frontier.toml", "snow   = { albedo", "snow   = { emission = 1.0, albedo");
    project.edit("worlds/frontier.toml", "water  = { albedo", "water  = { emission = 0.5, albedo");
    project.edit("worlds/frontier.toml", "lamp_memory = \"16 MiB\"", "lamp_memory = \"64 MiB\"");
    colours(1000.0);
    // A picture without some of the lamps is none.
    project.edit("worlds/frontier.toml", "\"64 MiB\"", "\"64 KiB\"");
    let mut session = open(&project, "beauty", &[]);
    let message = session.frame().expect_err("there is no room").to_string();
    assert!(message.starts_with("[RX0490]"), "{message}");
}

/// Lamps in a room without an end: one by itself, one across the border of two chunks, and one far away, in cells of 4 voxels. The last
/// one lies in the lattice of these cells.
const LAMPS: &str = include_str!("../fixtures/streaming/lamps/lamps.toml");

const DRAWN: u32 = 1 << 16;

/// Lamps that are drawn: corner and face, then the probability by area, the length of the sides and the place on the face.
const DRAWS: &str = include_str!("../fixtures/streaming/lamps/draws.comp");

fn lamps(project: &Project, stream: &str, graph: &str) -> Session {
    project.write("worlds/frontier.toml", LAMPS.replace("# STREAM", stream));
    open(project, graph, &[])
}

#[test]
fn lamps_of_a_streamed_world_are_drawn_by_their_power() {
    let project = project();
    project
        .write("shaders/draws.comp", DRAWS)
        .write("graphs/draws.toml", include_str!("../fixtures/streaming/lamps/draws.toml"));
    let drawn = |stream: &str| {
        let mut session = lamps(&project, stream, "draws");
        session.frame().unwrap_or_else(|error| panic!("{error}"));
        silent(&session);
        let bytes = session.read_buffer("results", 0..32 * u64::from(DRAWN)).unwrap();
        let words: Vec<u32> = bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
        let mut found: BTreeMap<([i32; 3], u32, u32), (f64, f64)> = BTreeMap::new();
        let mut places = [[0; 16]; 2];
        for draw in words.chunks_exact(8) {
            let number = |word: usize| f64::from(f32::from_bits(draw[word]));
            let (edge, probability) = (number(5), number(4) * number(5) * number(5));
            let key = ([0, 1, 2].map(|i| draw[i].cast_signed()), draw[3], edge as u32);
            found.entry(key).or_insert((0.0, probability)).0 += 1.0 / f64::from(DRAWN);
            (0..2).for_each(|axis| places[axis][(number(6 + axis) * 16.0) as usize] += 1);
        }
        // Places on faces are even.
        let even = f64::from(DRAWN / 16);
        assert!(
            places.iter().flatten().all(|count| (f64::from(*count) - even).abs() < 5.0 * even.sqrt()),
            "{places:?}"
        );
        for (lamp, (share, probability)) in &found {
            let chance = (probability / f64::from(DRAWN)).sqrt();
            assert!((share - probability).abs() < 5.0 * chance, "{lamp:?}: {share} for {probability}");
        }
        found
    };
    let whole = drawn("");
    let streamed = drawn(
        r#"[stream]
near = 64
far = 256
gpu_memory = "8 MiB"
lamp_memory = "64 KiB""#,
    );
    assert!(whole.keys().all(|(_, _, edge)| *edge == 1));
    // One by one as in the whole world, with the same probabilities.
    let near = |found: &BTreeMap<([i32; 3], u32, u32), (f64, f64)>| -> Vec<(([i32; 3], u32), i64)> {
        let near = found.iter().filter(|((voxel, ..), _)| voxel[0] < 128);
        near.map(|((voxel, face, _), (_, probability))| ((*voxel, *face), (probability * 1e9).round() as i64)).collect()
    };
    let (expected, found) = (near(&whole), near(&streamed));
    assert_eq!(expected.len(), 22 + 40, "bare faces of both");
    for (expected, found) in expected.iter().zip(&found) {
        assert!(
            expected.0 == found.0 && (expected.1 - found.1).abs() <= 1 + expected.1 / 100_000,
            "{expected:?} {found:?}"
        );
    }
    assert_eq!(expected.len(), found.len());
    // Far away, sixteen times as large: 4 by 12 by 8 cells.
    let far: Vec<u32> = streamed.keys().filter(|(voxel, ..)| voxel[0] >= 128).map(|(_, _, edge)| *edge).collect();
    assert!(far.len() == 352 && far.iter().all(|edge| *edge == 4), "{}", far.len());
}

/// Lamps of a chunk depend on the chunks around it. raxel does not make these again for the lamps, even if the file keeps nothing on the host.
#[test]
fn chunks_beside_lamps_are_made_once() {
    let project = project();
    let stream = "[stream]\nnear = 128\ngpu_memory = \"8 MiB\"\ncpu_memory = 0";
    let lit = LAMPS.replace("material = \"floor\"", "material = \"dim\"").replace("# STREAM", stream);
    project.write("worlds/frontier.toml", lit);
    let mut session = open(&project, "bench/first_hit", &[]);
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    let (stats, kept) = (session.stream().expect("it is bound").stats(), session.world().kept().unwrap());
    let made = kept.misses;
    assert!(stats.lights > 10_000, "{stats:?}");
    // Tiles beyond the wanted ones are asked for, too.
    assert!(made < 2 * stats.made, "{made} were made for {} tiles", stats.made);
}

/// The path tracer finds the same light, however the lamps are drawn.
#[test]
fn a_streamed_world_is_lit_as_the_same_world_with_bounds() {
    let project = project();
    let radiance = |stream: &str| {
        let mut session = lamps(&project, stream, "light/reference");
        session.pin("radiance").unwrap();
        session.set_debug_target(raxel::DebugTarget::resource("radiance")).unwrap();
        for name in ["sun_strength", "sky_strength"] {
            session.set_param(name, Value::F32(0.0)).unwrap();
        }
        for _ in 0..64 {
            session.frame().unwrap_or_else(|error| panic!("{error}"));
        }
        silent(&session);
        session.read_target("radiance").unwrap().floats()
    };
    let whole = radiance("");
    let streamed = radiance(
        r#"[stream]
near = 64
far = 256
gpu_memory = "8 MiB"
lamp_memory = "64 KiB""#,
    );
    let sum = |pixel: &[f32; 4]| pixel[..3].iter().map(|c| f64::from(*c)).sum::<f64>();
    // Pixels that look at the floor: their means differ by chance alone.
    let pairs = whole.iter().zip(&streamed).map(|(a, b)| (sum(a), sum(b))).filter(|(a, _)| *a > 0.0 && *a < 1.0);
    let pairs: Vec<(f64, f64)> = pairs.collect();
    let n = pairs.len() as f64;
    let light = pairs.iter().map(|(a, _)| a).sum::<f64>() / n;
    let mean = pairs.iter().map(|(a, b)| a - b).sum::<f64>() / n;
    let error = (pairs.iter().map(|(a, b)| (a - b - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt();
    assert!(n > 1000.0 && light > 0.01, "{n} pixels of {light}");
    assert!(error < 0.01 * light && mean.abs() < 5.0 * error, "{mean} ± {error} of {light}");
}

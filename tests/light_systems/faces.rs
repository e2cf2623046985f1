//! The face cache: where faces are, how often they are lit, and how they share.

use std::collections::{BTreeMap, BTreeSet};

use raxel::world::{World, vox};
use raxel::{Session, Value};
use raxel_measure::light::{Bench, Effort, Scene};

use crate::common::{Project, RunRaxel, repository};
use crate::scenes::{DARK, cuboid, effort, frames, open, scene, world};
use crate::{luminance, room};

/// Slats over a dark floor, under the sun alone. A camera that has come past the slats sees the same as a still one in its first frame. Half
/// shadows have less noise than one ray a pixel leaves.
#[test]
fn shadows_keep_their_edges_while_the_camera_moves() {
    let project = Project::shipped();
    let slats = (-8..12).map(|i| cuboid("floor", [5 * i, 4, -20], [5 * i + 2, 6, 20], ""));
    let build: Vec<String> = std::iter::once(cuboid("floor", [-60, -1, -40], [80, 0, 40], "")).chain(slats).collect();
    world(&project, "floor = { albedo = [0.1, 0.1, 0.1] }", &build, [10.5, 26.0, 34.5], [10.0, 0.0, 4.0], 50.0);
    let scene = Scene { params: vec![("sky_strength".to_owned(), 0.0)], ..scene() };
    let mut bench = Bench::new(Effort { pan: 8, ..effort(&project, [96, 54], 1, 32) });
    let references = bench.references(&scene).unwrap();
    let brute = bench.system("graphs/light/reference_centre.toml", &scene, &references).unwrap();
    let outcome = bench.system("graphs/rivals/light/sun_history.toml", &scene, &references).unwrap();
    assert_eq!(bench.complaints(), &[] as &[String]);
    let (still, moving) = (outcome.still[0].judged, outcome.pan.unwrap().judged);
    assert!(moving.error < 1.5 * still.error, "{moving:?} {still:?}");
    assert!(still.noise < 0.5 * brute.still[0].judged.noise, "{still:?} {:?}", brute.still[0]);
}

/// While lamps change a little in each frame, old samples count less, so faces get twice as many new ones.
#[test]
fn faces_get_more_samples_while_light_changes() {
    let project = Project::shipped();
    room(&project);
    let mut session = open(&project, "graphs/light/face_cache.toml", [64, 36], &DARK);
    session.set_param("paths", Value::F32(0.1)).unwrap();
    session.pin("queue").unwrap();
    let mut listed = |change: f32| {
        let mut sum = 0;
        for frame in 0..24_u8 {
            session.set_param("lamp_strength", Value::F32(1.0 + change * f32::from(frame))).unwrap();
            frames(&mut session, 1);
            let bytes = session.read_buffer("queue", 0..4).unwrap();
            // The number of faces in sight is known from the second frame on.
            sum += if frame < 8 { 0 } else { u32::from_le_bytes(bytes.try_into().unwrap()) };
        }
        sum
    };
    let [changing, still] = [listed(0.02), listed(0.0)];
    assert!(changing > 3 * still / 2, "{changing} and {still}");
}

#[test]
fn faces_that_know_their_light_take_their_turn_less_often() {
    let project = Project::shipped();
    room(&project);
    let mut session = open(&project, "graphs/light/face_cache.toml", [64, 36], &DARK);
    session.pin("queue").unwrap();
    // Samples that are listed, and those that all faces in sight would have, by their width.
    let listed = |session: &mut Session, count: u32| {
        frames(session, count);
        let bytes = session.read_buffer("queue", 0..12).unwrap();
        [0, 8].map(|at| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()))
    };
    let [first, all] = listed(&mut session, 1);
    assert!(first >= all && all > 100, "{first} of {all}");
    let seen = u32::from_le_bytes(session.read_buffer("queue", 12..16).unwrap().try_into().unwrap());
    assert!(all > 3 * seen / 2, "{seen} faces, most of them wide, would have {all} samples");
    let [later, all] = listed(&mut session, 47);
    assert!(later > 0 && later < all / 2, "{later} of {all}");
    // Their cached light is stale.
    session.set_param("lamp_strength", Value::F32(0.25)).unwrap();
    let [changed, all] = listed(&mut session, 1);
    assert!(changed >= all, "{changed} of {all}");
}

/// The light that sunny faces send on changes fast near a shadow that moves. So old samples of faces there hardly count, and those of all others do.
#[test]
fn faces_near_a_moving_shadow_forget_sooner() {
    let project = Project::shipped();
    let build = [cuboid("wall", [-60, 0, -60], [60, 3, 60], ""), cuboid("wall", [0, 3, 0], [2, 12, 2], "")];
    world(&project, "wall = { albedo = [0.7, 0.6, 0.5] }", &build, [1.5, 20.5, 30.5], [0.0, 3.0, 0.0], 60.0);
    let mut session = open(&project, "graphs/light/face_cache.toml", [64, 36], &[("sun_elevation", 30.0)]);
    session.pin("queue").unwrap();
    // Entries of the list, and those of faces that are late.
    let late = |session: &mut Session, degrees: f32| {
        for step in 0..12u8 {
            session.set_param("sun_azimuth", Value::F32(200.0 + degrees * f32::from(step))).unwrap();
            frames(session, 1);
        }
        let mut words = |from: u64, count: u64| {
            let bytes = session.read_buffer("queue", from..from + 4 * count).unwrap();
            bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect::<Vec<_>>()
        };
        let count = words(0, 1)[0];
        let entries = words(60, u64::from(count));
        (entries.len(), entries.iter().filter(|entry| *entry >> 28 & 1 != 0).count())
    };
    let (entries, still) = late(&mut session, 0.0);
    assert!(entries > 0 && still == 0, "{still} of {entries} under a sun that stands still");
    let (entries, moving) = late(&mut session, 0.5);
    assert!(moving > 0 && moving < entries / 2, "{moving} of {entries} under a sun that moves");
}

/// Faces of one plane share their noise: less of it in a few frames, and in the end the light that each has found itself.
#[test]
fn faces_of_a_plane_share_noise_and_not_light() {
    let project = Project::shipped();
    room(&project);
    let bench = |frames: u32| {
        let mut bench = Bench::new(effort(&project, [64, 36], frames, 512));
        let scene = scene();
        let references = bench.references(&scene).unwrap();
        let shared = bench.system("graphs/light/face_cache.toml", &scene, &references).unwrap();
        let own = "shaders/light/face_cache/soften.comp";
        project.edit(own, "soft[slot] = soft_pack(result);", "soft[slot] = soft_pack(own.rgb);");
        let alone = bench.system("graphs/light/face_cache.toml", &scene, &references).unwrap();
        project.edit(own, "soft[slot] = soft_pack(own.rgb);", "soft[slot] = soft_pack(result);");
        assert_eq!(bench.complaints(), &[] as &[String]);
        [shared, alone].map(|outcome| outcome.still.last().unwrap().judged)
    };
    let [shared, alone] = bench(4);
    assert!(shared.noise < 0.6 * alone.noise, "{shared:?} {alone:?}");
    let [shared, alone] = bench(256);
    assert!(shared.noise < alone.noise && shared.error < 1.25 * alone.error, "{shared:?} {alone:?}");
}

/// A face is kept in quarters from a width in pixels on that grows with the noise of samples, and as a whole below it.
#[test]
fn wide_faces_are_kept_in_quarters_where_there_is_little_noise() {
    const SIZE: [u32; 2] = [96, 54];
    const QUARTERS: f32 = 4.0;
    let project = Project::shipped();
    // The noise of samples, and the numbers of faces wider than the param: kept as a whole, and in quarters.
    let kept = |camera: [f64; 3], params: &[(&str, f32)]| {
        let mut session = open(&project, "graphs/light/face_cache.toml", SIZE, params);
        for name in ["queue", "hit", "place", "slot"] {
            session.pin(name).unwrap();
        }
        session.set_param("quarters", Value::F32(QUARTERS)).unwrap();
        frames(&mut session, 40);
        let noise = f32::from_le_bytes(session.read_buffer("queue", 40..44).unwrap().try_into().unwrap());
        let threshold = f64::from(QUARTERS * (16.0 * noise).max(1.0));
        let hits = session.read_target("hit").unwrap().integers().unwrap();
        let slots = session.read_target("slot").unwrap().integers().unwrap();
        let places = session.read_target("place").unwrap().floats();
        let mut faces = BTreeMap::new();
        for ((hit, slot), place) in hits.iter().zip(&slots).zip(&places) {
            let face = hit[3] >> 16 & 7;
            if hit[3] == u32::MAX || slot[0] == u32::MAX {
                continue;
            }
            let quarter = usize::from(place[0] >= 0.5) + 2 * usize::from(place[1] >= 0.5);
            let voxel = [hit[0] as i32, hit[1] as i32, hit[2] as i32];
            let slots: &mut [BTreeSet<u32>; 4] = faces.entry((voxel, face)).or_default();
            slots[quarter].insert(slot[0]);
        }
        let mut wide = [0, 0];
        for ((voxel, face), slots) in &faces {
            let axis = (face >> 1) as usize;
            let along = |i: usize| {
                let middle = if i == axis { f64::from(face & 1) } else { 0.5 };
                f64::from(voxel[i]) + middle - camera[i]
            };
            let square: f64 = (0..3).map(|i| along(i).powi(2)).sum();
            let width = 0.5 * f64::from(SIZE[1]) / (30_f64.to_radians().tan() * square.sqrt());
            // Widths so close to the limit that the shader's floats may decide otherwise.
            if (width / threshold - 1.0).abs() < 1e-3 {
                continue;
            }
            let all: BTreeSet<_> = slots.iter().flatten().collect();
            let parts = slots.iter().filter(|slots| !slots.is_empty()).count();
            assert!(slots.iter().all(|slots| slots.len() <= 1), "a part of {voxel:?} {face} has {slots:?}");
            let quartered = width >= threshold;
            assert_eq!(
                all.len(),
                if quartered { parts } else { 1 },
                "{voxel:?} {face}: {width} px of {threshold}, {slots:?}"
            );
            if width >= f64::from(QUARTERS) && parts > 1 {
                wide[usize::from(quartered)] += 1;
            }
        }
        (noise, wide)
    };
    let wall = "wall = { albedo = [0.7, 0.6, 0.5] }";
    let camera = [16.5, 4.5, 30.5];
    world(&project, wall, &[cuboid("wall", [0, 0, 0], [32, 1, 32], "")], camera, [16.0, 0.0, 16.0], 60.0);
    let (noise, [whole, quarters]) = kept(camera, &[("sun_strength", 0.0), ("sky_strength", 1.0)]);
    assert!(noise > 0.0 && noise < 1.0 / 16.0, "{noise}");
    assert!(whole == 0 && quarters > 50, "{whole} whole, {quarters} in quarters");
    room(&project);
    let (noise, [whole, _]) = kept([1.5, 4.5, 11.5], &DARK);
    assert!(noise > 1.0 / 16.0 && whole > 50, "{noise}, {whole} whole");
}

/// The world of docs/light/beauty.md around a model that raxel does not ship. raxel names the missing file, and any model of its size
/// becomes a hall with windows and lamps.
#[test]
fn a_solid_model_is_hollowed_out_and_lit_from_inside() {
    let project = Project::shipped();
    let page = std::fs::read_to_string(repository().join("docs/light/church.toml")).unwrap();
    project.write("worlds/test.toml", page);
    let missing = project.raxel(&["check", "worlds/test.toml"]).exits(3).stdout;
    assert!(missing.contains("error[RX0001]: `worlds/church.vox` does not exist"), "{missing}");

    // Up to where the street begins.
    let block = (0..124 * 24 * 64).map(|i| (glam::IVec3::new(i % 124, i / 124 % 24, i / (124 * 24)), 1));
    let block = World::from_voxels(raxel_oracle::scenes::materials(), block);
    project.write("worlds/church.vox", vox::export(&block).unwrap());
    let only = |param: &str, value: f32| {
        let mut params = vec![("sun_strength", 0.0), ("sky_strength", 0.0), ("lamp_strength", 0.0)];
        params.extend([("sun_azimuth", 165.0), ("sun_elevation", 42.0)]);
        params.retain(|(name, _)| *name != param);
        params.push((param, value));
        let texels = frames(&mut open(&project, "graphs/light/reference.toml", [32, 18], &params), 64);
        let lit = texels.iter().filter(|texel| texel[1] > 0.0).count();
        (lit * 100 / texels.len(), luminance(&texels))
    };
    // Of a solid block, the camera would see nothing at all.
    for (source, strength) in [("sun_strength", 14.0), ("sky_strength", 1.0), ("lamp_strength", 1.0)] {
        let (percent, light) = only(source, strength);
        assert!(percent > 50 && light > 1e-3, "{source}: {light} in {percent} % of the pixels");
    }
}

/// If a world is larger than the box of all keys on an axis, the box lies around the camera on that axis.
#[test]
fn faces_of_a_wide_or_high_world_keep_light_wherever_the_camera_is() {
    let project = Project::shipped();
    let wall = "wall = { albedo = [0.7, 0.6, 0.5] }";
    let sky = [("sun_strength", 0.0), ("sky_strength", 1.0)];
    let light = |graph: &str, build: &[String], [x, y]: [i32; 2]| {
        let [x, y] = [x, y].map(f64::from);
        world(&project, wall, build, [x + 8.0, y + 9.5, 20.5], [x + 8.0, y, 8.0], 60.0);
        luminance(&frames(&mut open(&project, graph, [48, 27], &sky), 32))
    };
    let floor = |[x, y]: [i32; 2]| cuboid("wall", [x, y, 0], [x + 16, y + 1, 16], "");
    let (wide, high) = ([[-70_001, 0], [0, 0], [70_000, 0]], [[0, -3_000], [0, 0], [0, 5_000]]);
    for graph in ["graphs/light/face_cache.toml", "graphs/rivals/light/surface_f32.toml"] {
        let alone = light(graph, &[floor([0, 0])], [0, 0]);
        for places in [wide, high] {
            for at in places {
                let among = light(graph, &places.map(floor), at);
                assert!((among / alone - 1.0).abs() < 0.01, "{graph}: {among} at {at:?}, {alone} in a small world");
            }
        }
    }
}

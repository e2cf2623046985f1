//! Caches of light have the room that they say, and lose no light where it runs out.

use raxel::{Session, Value};
use raxel_graph::plan::{Lifetime, ResourceDesc};

use crate::common::{LIGHT, Project, graph_in};
use crate::scenes::{DARK, cuboid, frames, open, world};
use crate::{luminance, room};

/// Without slots, paths go on as if there were no cache: the light is the same.
/// Their buffers, pictures not counted: samples of as many items as there are pixels are small here. Of those of `hash_cache`, 32 MiB are samples of one frame.
#[test]
fn caches_of_light_take_the_memory_that_is_said() {
    let project = Project::shipped();
    room(&project);
    for (system, most) in [("face_cache", 59.5), ("hash_cache", 68.5), ("surface_cache", 50.5), ("surface_f32", 64.6)] {
        let session = open(&project, &graph_in(LIGHT, system), [16, 9], &[]);
        // All can be read here, those of passes for other worlds included, which this room does not count.
        let plan = session.plan().unwrap();
        let used = |id| plan.passes.iter().any(|p| plan.graph.pass(p.pass).accesses.iter().any(|a| a.resource == id));
        let kept = plan.resources.iter().filter(|resource| {
            let persistent = resource.lifetime == Lifetime::Persistent && used(resource.resource);
            matches!(resource.desc, ResourceDesc::Buffer(_)) && persistent
        });
        let mib = kept.map(|resource| resource.memory.size).sum::<u64>() as f64 / f64::from(1 << 20);
        assert!(mib > 0.9 * most && mib <= most, "{system}: {mib} MiB");
    }
}

#[test]
fn a_hash_cache_without_room_loses_no_light() {
    let project = Project::shipped();
    room(&project);
    let light = || {
        let mut session = open(&project, "graphs/rivals/light/hash_cache.toml", [48, 27], &DARK);
        session.set_param("tile", Value::I32(1)).unwrap();
        luminance(&frames(&mut session, 48))
    };
    let roomy = light();
    let slots = "RX_FACE_LOG2_SLOTS = 20u";
    project.edit("shaders/include/raxel/light/face_slots.glsl", slots, "RX_FACE_LOG2_SLOTS = 5u");
    let full = light();
    // Two bounces are a third of the light here.
    assert!((full / roomy - 1.0).abs() < 0.05, "{full} with 32 slots, {roomy} with 2^20");
}

/// The statistics of `face_cache`: slots that are taken, pixels without one, faces and cells in sight.
fn table(session: &mut Session) -> [u32; 3] {
    let mut word = |buffer: &str, at: u64| {
        u32::from_le_bytes(session.read_buffer(buffer, at..at + 4).unwrap().try_into().unwrap())
    };
    [word("cache", 44), word("queue", 48), word("queue", 12)]
}

/// Hills of steps that are narrower than a pixel, with room in the table for a part of what the picture sees.
fn steps(project: &Project, room: u32) {
    let build: Vec<String> =
        (0..48).map(|i| cuboid("wall", [0, -1, 4 * i], [192, (i * 5 % 9) + i / 4, 4 * i + 2], "")).collect();
    world(project, "wall = { albedo = [0.7, 0.6, 0.5] }", &build, [96.5, 60.5, 260.5], [96.0, 0.0, 60.0], 60.0);
    project.edit(
        "shaders/light/face_cache/fit.glsl",
        "#define FIT_ROOM (RX_FACE_SLOTS / 32u * 9u)",
        &format!("#define FIT_ROOM {room}u"),
    );
}

const SKY: [(&str, f32); 2] = [("sun_strength", 0.0), ("sky_strength", 1.0)];

/// Far faces share slots as far as they must, and the light is the same.
#[test]
fn a_view_of_more_faces_than_there_is_room_for_is_kept_in_cells() {
    const SIZE: [u32; 2] = [128, 72];
    let project = Project::shipped();
    let light = |room: u32| {
        steps(&project, room);
        let mut session = open(&project, "graphs/light/face_cache.toml", SIZE, &SKY);
        for name in ["queue", "cache"] {
            session.pin(name).unwrap();
        }
        // Whole faces, however narrow, unless there is no room.
        session.set_param("grain", Value::F32(0.0)).unwrap();
        frames(&mut session, 1);
        let first = table(&mut session);
        let mean = luminance(&frames(&mut session, 63));
        let last = table(&mut session);
        project.edit(
            "shaders/light/face_cache/fit.glsl",
            &format!("#define FIT_ROOM {room}u"),
            "#define FIT_ROOM (RX_FACE_SLOTS / 32u * 9u)",
        );
        (mean, first, last)
    };
    let (exact, [_, _, faces], _) = light(1 << 20);
    assert!(faces > 3000, "{faces} faces in sight");
    let (shared, first, last) = light(1500);
    for [used, lost, seen] in [first, last] {
        assert!(lost == 0 && seen > 200 && seen < 2250 && used < 3000, "{used} slots, {seen} in sight, {lost} lost");
    }
    assert!((shared / exact - 1.0).abs() < 0.02, "{shared} in cells, {exact} on faces");
}

/// A camera that jumps between views takes the slots of the faces that it has left.
#[test]
fn faces_that_have_left_the_picture_give_their_slots_to_others() {
    const ROOM: u32 = 600;
    let project = Project::shipped();
    steps(&project, ROOM);
    let mut session = open(&project, "graphs/light/face_cache.toml", [128, 72], &SKY);
    for name in ["queue", "cache"] {
        session.pin(name).unwrap();
    }
    let mut most = 0;
    let mut all = 0;
    for i in 0..12 {
        let camera = *session.camera();
        // To and fro along the hills, by more than the picture shows.
        let cell = camera.cell + glam::IVec3::new(if i % 4 < 2 { 400 } else { -400 }, 0, 0) / 4;
        session.set_camera(raxel::Camera { cell, ..camera });
        for _ in 0..2 {
            frames(&mut session, 1);
            let [used, lost, seen] = table(&mut session);
            assert_eq!(lost, 0, "jump {i}");
            most = most.max(used);
            all += seen;
        }
    }
    assert!(all > 8 * ROOM, "{all}");
    assert!(most <= 2 * ROOM, "{most} slots are taken");
    // The number is that of the words in the table.
    let keys = session.read_buffer("cache", 656..656 + (4 << 20)).unwrap();
    let taken = keys.chunks_exact(4).filter(|word| word[3] >> 2 != 0).count();
    assert_eq!(taken as u32, table(&mut session)[0]);
}

/// Texels keep the same light as whole faces: of a lamp in a closed room, and of a sun and a sky over it.
#[test]
fn texels_of_floats_have_the_light_of_whole_faces() {
    let project = Project::shipped();
    let light = |graph: &str, params: &[(&str, f32)], texels_from: Option<f32>| {
        let mut session = open(&project, graph, [48, 27], params);
        if let Some(pixels) = texels_from {
            session.set_param("texels_from", Value::F32(pixels)).unwrap();
        }
        let mean = luminance(&frames(&mut session, 128));
        let given = texels_from.map(|_| {
            let bytes =
                session.read_buffer("unwrapped", 4 * (1_048_576 + 65_536)..4 * (1_048_576 + 65_536 + 1)).unwrap();
            u32::from_le_bytes(bytes[..4].try_into().unwrap())
        });
        (mean, given)
    };
    let open_land = [("sun_strength", 2.0), ("sky_strength", 0.5), ("sun_elevation", 50.0)];
    for (lit_by, params) in [("a lamp", &DARK[..]), ("sun and sky", &open_land)] {
        if lit_by == "a lamp" {
            room(&project);
        } else {
            let build = [cuboid("wall", [0, 0, 0], [16, 1, 16], ""), cuboid("wall", [5, 1, 5], [8, 6, 8], "")];
            world(&project, "wall = { albedo = [0.7, 0.6, 0.5] }", &build, [14.5, 9.5, 18.5], [7.0, 1.0, 6.0], 50.0);
        }
        let (whole, _) = light("graphs/light/face_cache.toml", params, None);
        let (texels, given) = light("graphs/rivals/light/surface_f32.toml", params, Some(1.0));
        assert!(given.unwrap() > 20, "{lit_by}: only {given:?} faces have texels");
        assert!((texels / whole - 1.0).abs() < 0.04, "{lit_by}: {texels} in texels, {whole} on whole faces");
        let (far, given) = light("graphs/rivals/light/surface_f32.toml", params, Some(1000.0));
        assert_eq!(given, Some(0), "{lit_by}: no face is a thousand pixels wide");
        assert!((far / whole - 1.0).abs() < 0.04, "{lit_by}: {far} without texels, {whole} on whole faces");
    }
}

/// Without slots, faces show only their sunlight and their own emission. This room has neither, and nothing goes wrong.
#[test]
fn a_face_cache_without_room_shows_no_light_that_it_does_not_know() {
    let project = Project::shipped();
    room(&project);
    project.edit("shaders/include/raxel/light/face_table.glsl", "RX_FACE_PROBES = 63u", "RX_FACE_PROBES = 0u");
    let full = frames(&mut open(&project, "graphs/light/face_cache.toml", [48, 27], &DARK), 24);
    assert!(full.iter().all(|texel| texel[..3] == [0.0; 3]), "{full:?}");
}

/// The messages of a session about full tables by its last frame, which has ended.
fn full(session: &mut Session, count: u32) -> Vec<String> {
    frames(session, count);
    session.wait().unwrap();
    session.take_messages().into_iter().map(|said| format!("{}: {}", said.code, said.message)).collect()
}

/// Tables of 2^20 slots are large enough for a room. In a table without a place for any key, a message has the number of pixels whose face
/// has no slot, or of samples that were dropped.
#[test]
fn full_tables_are_said_with_what_they_lack() {
    let project = Project::shipped();
    room(&project);
    let systems = [
        ("face_cache", "pixels show only sunlight and emission, for their faces found no slot in the table: "),
        ("surface_cache", "pixels show only emission, for their faces found no slot in the table: "),
        ("surface_f32", "pixels show only sunlight and emission, for their faces found no slot in the table: "),
        ("hash_cache", "samples of light were not kept, for their cells found no slot in the table: "),
    ];
    let said = |system: &str| {
        let mut session = open(&project, &graph_in(LIGHT, system), [48, 27], &DARK);
        let said = full(&mut session, 6);
        (said, session.counted().len())
    };
    for (system, _) in systems {
        assert_eq!(said(system), (Vec::new(), 0), "{system}");
    }
    // No slot may hold a key.
    project.edit("shaders/include/raxel/light/face_table.glsl", "RX_FACE_PROBES = 63u", "RX_FACE_PROBES = 0u");
    for (system, says) in systems {
        let (said, now) = said(system);
        let [said] = &said[..] else { panic!("{system}: {said:?}") };
        let count = said.strip_prefix("RX0411: ").and_then(|said| said.strip_prefix(says));
        let count: u32 = count.and_then(|count| count.parse().ok()).unwrap_or_else(|| panic!("{system}: {said}"));
        // All 1,296 pixels of the picture, which all see faces.
        let expected = if system == "hash_cache" { 1..=4 * 1296 } else { 600..=1296 };
        assert!(expected.contains(&count) && now == 1, "{system}: {count}, {now} now");
    }
}

/// With two blocks of texels, faces that are seen take them from each other.
#[test]
fn texels_that_faces_in_sight_take_from_each_other_are_said() {
    let project = Project::shipped();
    room(&project);
    let said = || {
        let mut session = open(&project, "graphs/rivals/light/surface_f32.toml", [48, 27], &DARK);
        session.set_param("texels_from", Value::F32(1.0)).unwrap();
        full(&mut session, 6)
    };
    assert!(said().is_empty());
    project.edit("shaders/light/unwrapped.glsl", "const uint BLOCKS = 65536u;", "const uint BLOCKS = 2u;");
    let said = said();
    let says = "RX0411: faces in sight lost their texels to others in sight, and begin anew: ";
    assert!(matches!(&said[..], [one] if one.starts_with(says)), "{said:?}");
}

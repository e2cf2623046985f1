//! What a viewer sees: dark rooms, water, panes, averages.

use raxel::Value;

use crate::common::{LIGHT, Project, graph_in};
use crate::luminance;
use crate::scenes::{DARK, cuboid, frames, open, world};

/// A cell may hold faces of both sides of a thin wall: what pixels see alone counts.
#[test]
fn cells_of_a_dark_room_keep_no_light_of_outside() {
    let project = Project::shipped();
    let build = [
        cuboid("wall", [0, 0, 0], [12, 8, 12], "shell = 1"),
        // Ledges outside, of all directions, in the cells of the walls.
        cuboid("wall", [12, 0, 3], [14, 6, 5], ""),
        cuboid("wall", [-2, 3, 3], [0, 4, 9], ""),
        cuboid("wall", [2, 8, 2], [6, 10, 6], ""),
    ];
    world(&project, "wall = { albedo = [0.7, 0.6, 0.5] }", &build, [1.5, 4.5, 10.5], [8.0, 1.0, 4.0], 60.0);
    let bright = [("sun_strength", 1000.0), ("sky_strength", 1000.0)];
    let mut session = open(&project, "graphs/light/face_cache.toml", [48, 27], &bright);
    session.set_param("grain", Value::F32(64.0)).unwrap();
    let texels = frames(&mut session, 16);
    assert!(texels.iter().all(|texel| texel[..3] == [0.0; 3]), "{:?}", texels.iter().find(|texel| texel[0] > 0.0));
}

/// Averages go on until they show their goal, from above and from below: within a thousandth, where averages of few bits stop at
/// hundredths. The sky has one radiance, so there is no noise.
#[test]
fn averages_reach_what_they_are_to_show() {
    let project = Project::shipped();
    let sky = "return strength * rx_sky(dir, sun);";
    project.edit("shaders/include/raxel/light/environment.glsl", sky, "return vec3(strength);");
    let floor = cuboid("floor", [-40, 0, -40], [40, 1, 40], "");
    world(&project, "floor = { albedo = [0.5, 0.5, 0.5] }", &[floor], [0.5, 9.5, 0.5], [0.6, 0.0, 0.4], 50.0);
    for system in ["face_cache", "surface_f32", "gi_svgf", "hash_cache"] {
        let params = [("sun_strength", 0.0), ("sky_strength", 0.2)];
        let mut session = open(&project, &graph_in(LIGHT, system), [12, 7], &params);
        // Without noise, faces would take their turn seldom.
        if system == "face_cache" {
            session.set_param("rarely", Value::I32(1)).unwrap();
        }
        for before in [0.25, 0.16] {
            session.set_param("sky_strength", Value::F32(before)).unwrap();
            frames(&mut session, 32);
            session.set_param("sky_strength", Value::F32(0.2)).unwrap();
            for texel in frames(&mut session, 480) {
                let away = texel[..3].iter().map(|channel| (channel / 0.1 - 1.0).abs()).fold(0.0, f32::max);
                assert!(away < 1e-3, "{system}, from {before}: {texel:?} is {away} away from 0.1");
            }
        }
    }
}

/// Air in a closed room gets no light from outside, and a polished face mirrors none.
#[test]
fn a_closed_room_without_a_lamp_is_black() {
    let project = Project::shipped();
    let materials = "wall = { albedo = [0.7, 0.6, 0.5] }\npolished = { albedo = [0.7, 0.6, 0.5], roughness = 0.1 }";
    let build = [cuboid("wall", [-1, -1, -1], [13, 9, 13], "shell = 1"), cuboid("polished", [3, 0, 3], [5, 4, 5], "")];
    world(&project, materials, &build, [1.5, 4.5, 11.5], [8.0, 0.0, 4.0], 60.0);
    for graph in ["graphs/beauty.toml", "graphs/beauty_glass.toml"] {
        let mut session = open(&project, graph, [48, 27], &[]);
        session.pin("seen").unwrap();
        frames(&mut session, 3);
        let seen = session.read_target("seen").unwrap().floats();
        let lit = seen.iter().filter(|texel| texel[..3] != [0.0; 3]).count();
        assert_eq!(lit, 0, "{graph}: pixels with light");
    }
}

/// A camera in water sees a lit ceiling through the surface; beyond Snell's window the surface mirrors the dark ground.
#[test]
fn a_camera_in_water_sees_through_the_surface_within_snells_window() {
    let project = Project::shipped();
    let materials = "water = { albedo = [0.3, 0.6, 0.7], transparency = 0.9, roughness = 0.05 }
mud = { albedo = [0.05, 0.05, 0.05] }
lamp = { albedo = [1.0, 1.0, 1.0], emission = 1.0 }";
    let build = [
        cuboid("mud", [-40, -1, -40], [40, 0, 40], ""),
        cuboid("water", [-40, 0, -40], [40, 10, 40], ""),
        cuboid("lamp", [-40, 20, -40], [40, 21, 40], ""),
    ];
    let light = |look_at: [f64; 3]| {
        world(&project, materials, &build, [0.5, 5.5, 0.5], look_at, 10.0);
        let mut session = open(&project, "graphs/beauty.toml", [48, 27], &DARK);
        session.pin("seen").unwrap();
        frames(&mut session, 2);
        luminance(&session.read_target("seen").unwrap().floats())
    };
    let (within, beyond) = (light([0.5, 30.5, 2.5]), light([30.5, 15.5, 2.5]));
    assert!(within > 0.4 && within < 1.0 && beyond > 0.0, "{within} within, {beyond} beyond");
    assert!(within > 2.0 * beyond, "{within} within, {beyond} beyond");
}

/// A slanted ray crosses many cells of a thick pane: sunlight still comes through.
#[test]
fn a_low_sun_shines_through_a_pane_of_five_voxels() {
    let project = Project::shipped();
    let materials = "floor = { albedo = [0.7, 0.6, 0.5] }\nglass = { albedo = [0.9, 0.4, 0.3], transparency = 0.9 }";
    let build = [cuboid("floor", [-60, -1, -60], [60, 0, 60], ""), cuboid("glass", [-60, 8, -60], [60, 13, 60], "")];
    world(&project, materials, &build, [0.5, 6.5, 0.5], [4.5, 0.0, 4.5], 60.0);
    let mut session = open(&project, "graphs/beauty_glass.toml", [48, 27], &[("sun_elevation", 25.0)]);
    session.pin("stained").unwrap();
    frames(&mut session, 2);
    let lit = session.read_target("stained").unwrap().floats().iter().filter(|texel| texel[0] > 0.0).count();
    assert!(lit > 48 * 27 * 9 / 10, "{lit} pixels have sunlight");
}

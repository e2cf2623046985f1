//! The ground around finite worlds, the clouds and the night.

use raxel::{Session, Value};

use crate::common::Project;
use crate::scenes::{cuboid, open, world};
use crate::{BEAUTY, MATERIALS, SIZE, after, at, lawn, luminance, mean};

fn ground_none(session: &mut Session) {
    session.set_param("ground", Value::U32(0)).unwrap();
}

/// The ground goes on where a lawn ends, with its level, its colour and its light; without ground, the void is another.
#[test]
fn ground_goes_on_at_the_level_and_in_the_colour_of_the_border() {
    let project = Project::shipped();
    lawn(&project, &[]);
    let mut session = open(&project, BEAUTY, SIZE, &[("clouds", 0.0), ("air", 0.0), ("mist", 0.0)]);
    let land = after(&mut session, "land", 1);
    let near = |a: f32, b: f32| (a - b).abs() < 1e-3;
    assert!(
        near(land[0][0], 0.2) && near(land[0][1], 0.5) && near(land[0][2], 0.1) && near(land[0][3], 3.0),
        "{land:?}"
    );
    session.pin("hit").unwrap();
    let seen = after(&mut session, "seen", 16);
    let hits = session.read_target("hit").unwrap().floats();
    let edge = (0..SIZE[1]).find(|y| at(&hits, 24, *y)[3] >= 0.0).unwrap();
    assert!(edge > 2 && edge < SIZE[1] - 3, "the lawn begins in row {edge}");
    // Beside the border, on both sides of it. The ground has patches of a tenth and more.
    let [ground, grass] = [edge - 2, edge + 2].map(|y| luminance(&at(&seen, 24, y)));
    assert!((ground / grass - 1.0).abs() < 0.2, "ground {ground}, lawn {grass}");
    ground_none(&mut session);
    let green = |texels: &[[f32; 4]]| at(texels, 24, edge - 2)[1] / at(texels, 24, edge - 2)[0];
    let (ground, void) = (green(&seen), green(&after(&mut session, "seen", 4)));
    assert!(ground > 1.5 && void < 1.3, "green of red: ground {ground}, void {void}");
}

/// A world that shows walls at its border stands on a plane at its lowest level, and a streamed one has no land around it.
#[test]
fn a_cube_stands_on_plain_ground_and_a_streamed_world_has_none() {
    let project = Project::shipped();
    world(
        &project,
        MATERIALS,
        &[cuboid("stone", [0, 5, 0], [20, 30, 20], "")],
        [60.5, 20.5, 60.5],
        [10.0, 15.0, 10.0],
        60.0,
    );
    let land = after(&mut open(&project, BEAUTY, SIZE, &[]), "land", 1);
    assert!(land[0][3] == 5.0 && land[1][0] == 1.0, "{land:?}");
    project.write("worlds/test.toml", std::fs::read_to_string(project.path("worlds/frontier.toml")).unwrap());
    let land = after(&mut open(&project, BEAUTY, SIZE, &[]), "land", 1);
    assert_eq!(land[1][0], 0.0, "{land:?}");
}

/// A wall at the edge of the lawn throws its shadow over the ground, and a mirror shows the ground.
#[test]
fn the_world_shades_the_ground_and_mirrors_show_it() {
    let project = Project::shipped();
    let fog = [("clouds", 0.0), ("air", 0.0), ("mist", 0.0)];
    let shade = |wall: bool| {
        let wall = if wall { vec![cuboid("stone", [-40, 3, -40], [40, 40, -39], "")] } else { Vec::new() };
        lawn(&project, &wall);
        // From beyond the wall, whose shadow falls towards -z: the sun stands in the south.
        project.edit("worlds/test.toml", "position = [0.5, 20.5, 0.5]", "position = [0.5, 20.5, -60.5]");
        project.edit("worlds/test.toml", "look_at = [0.5, 6.0, -40.0]", "look_at = [0.5, 0.0, -75.0]");
        let sun = [("sun_azimuth", 180.0), ("sun_elevation", 30.0)];
        let seen = after(&mut open(&project, BEAUTY, SIZE, &[&fog[..], &sun].concat()), "seen", 4);
        luminance(&at(&seen, 24, 20))
    };
    let (open_ground, shaded) = (shade(false), shade(true));
    assert!(shaded > 0.0 && shaded < 0.5 * open_ground, "{shaded} in the shadow, {open_ground} without it");

    let mirror = cuboid("polished", [-40, 3, -40], [40, 60, -39], "");
    lawn(&project, &[mirror]);
    project.edit("worlds/test.toml", "position = [0.5, 20.5, 0.5]", "position = [0.5, 40.5, 30.5]");
    project.edit("worlds/test.toml", "look_at = [0.5, 6.0, -40.0]", "look_at = [0.5, 32.0, -39.0]");
    let mut session = open(&project, BEAUTY, SIZE, &fog);
    let green = |texel: [f32; 4]| f64::from(texel[1] / texel[2]);
    let with = green(at(&after(&mut session, "gloss", 2), 24, 13));
    ground_none(&mut session);
    let without = green(at(&after(&mut session, "gloss", 2), 24, 13));
    assert!(with > 1.5 * without, "green of blue: {with} with ground, {without} without");
}

/// Without clouds their other params change no bit, and under a whole sky of them the land gets less sun. The share that a march towards
/// the sun lets through is the share that comes through to the place.
#[test]
fn clouds_dim_the_sun_as_much_as_they_hide_it() {
    let project = Project::shipped();
    let build = [cuboid("stone", [-40, 0, -40], [40, 1, 40], "")];
    world(&project, MATERIALS, &build, [0.5, 30.5, 0.5], [0.5, 0.0, 1.0], 60.0);
    let light = |params: &[(&str, f32)]| after(&mut open(&project, BEAUTY, SIZE, params), "radiance", 2);
    let clear = light(&[("clouds", 0.0)]);
    assert_eq!(clear, light(&[("clouds", 0.0), ("cloud_height", 90.0)]));
    let dim = light(&[("clouds", 1.0)]);
    assert!(mean(&dim) < 0.7 * mean(&clear), "{} of {}", mean(&dim), mean(&clear));

    // Mist before black stone.
    let black = [cuboid("black", [-40, 0, -40], [40, 1, 40], "")];
    world(&project, MATERIALS, &black, [0.5, 30.5, 0.5], [0.5, 0.0, 1.0], 60.0);
    let mist = |clouds: f32| {
        let params = [("clouds", clouds), ("mist", 40.0), ("sky_strength", 0.0)];
        mean(&after(&mut open(&project, BEAUTY, SIZE, &params), "seen", 2))
    };
    let (dim, clear) = (mist(1.0), mist(0.0));
    assert!(clear > 0.0 && dim < 0.7 * clear, "mist {dim} of {clear}");

    // Straight up at the sun, from many places under the clouds: the first has another cloud above it than the next.
    let sky = [("sun_elevation", 90.0), ("clouds", 0.75), ("sky_strength", 0.0), ("ground_drop", 0.0)];
    let (mut seen, mut falls) = (Vec::new(), Vec::new());
    for place in [0, 300, 700, 1100, 1500, 1900] {
        let slab = [cuboid("stone", [place - 4, 0, -4], [place + 5, 1, 5], "")];
        let x = f64::from(place) + 0.5;
        world(&project, MATERIALS, &slab, [x, 30.5, 0.5], [x, 480.0, 0.6], 10.0);
        let clouds = after(&mut open(&project, BEAUTY, SIZE, &sky), "clouds", 1);
        seen.push(f64::from(clouds[clouds.len() / 2 + 12][3]));
        world(&project, MATERIALS, &slab, [x, 30.5, 0.5], [x, 0.0, 0.6], 10.0);
        let bright = |clouds: f32| {
            let sky = [("sun_elevation", 90.0), ("clouds", clouds), ("sky_strength", 0.0)];
            luminance(&at(&after(&mut open(&project, BEAUTY, SIZE, &sky), "radiance", 1), 24, 13))
        };
        falls.push(bright(0.75) / bright(0.0));
    }
    assert!(
        seen.iter().copied().fold(1.0, f64::min) < 0.5 && seen.iter().copied().fold(0.0, f64::max) > 0.7,
        "{seen:?}"
    );
    for (seen, falls) in seen.iter().zip(&falls) {
        assert!((seen - falls).abs() < 0.25, "{seen} is seen through the clouds, {falls} comes through");
    }
}

/// By day the moon and its phase change no bit. By night it lights the land, from its own side, and stars are in the sky.
#[test]
fn by_night_the_moon_lights_the_land_and_stars_shine() {
    let project = Project::shipped();
    let build = [cuboid("stone", [-40, 0, -40], [40, 1, 40], ""), cuboid("stone", [-1, 1, -8], [2, 12, -7], "")];
    world(&project, MATERIALS, &build, [0.5, 30.5, 14.5], [0.5, 0.0, -8.0], 60.0);
    let light = |params: &[(&str, f32)]| after(&mut open(&project, BEAUTY, SIZE, params), "radiance", 2);
    let day = light(&[]);
    assert_eq!(day, light(&[("moon_phase", 0.0), ("moon_azimuth", 10.0)]));
    let night = |more: &[(&str, f32)]| light(&[&[("sun_elevation", -9.0), ("clouds", 0.0)], more].concat());
    let (full, new) = (night(&[("moon_phase", 1.0)]), night(&[("moon_phase", 0.0)]));
    assert!(
        mean(&new) > 0.0 && mean(&full) > 4.0 * mean(&new),
        "{} by a full moon, {} by none",
        mean(&full),
        mean(&new)
    );
    assert!(mean(&full) < 0.1 * mean(&day), "{} by night, {} by day", mean(&full), mean(&day));
    // The post's shadow falls to the other side.
    let (east, west) = (night(&[("moon_azimuth", 90.0)]), night(&[("moon_azimuth", 270.0)]));
    let side = |texels: &[[f32; 4]], left: bool| {
        let columns = if left { 14..23 } else { 26..35 };
        columns.map(|x| luminance(&at(texels, x, 13))).sum::<f64>()
    };
    assert!(side(&east, true) < 0.9 * side(&east, false), "{} {}", side(&east, true), side(&east, false));
    assert!(side(&west, false) < 0.9 * side(&west, true), "{} {}", side(&west, true), side(&west, false));

    world(&project, MATERIALS, &build, [0.5, 30.5, 14.5], [0.5, 90.0, -15.0], 60.0);
    let sky = |elevation: f32| {
        let seen =
            after(&mut open(&project, BEAUTY, SIZE, &[("clouds", 0.0), ("sun_elevation", elevation)]), "seen", 1);
        let mut light: Vec<f64> = seen.iter().map(luminance).collect();
        light.sort_by(f64::total_cmp);
        light[light.len() - 4] / light[light.len() / 2]
    };
    assert!(sky(-9.0) > 4.0 && sky(40.0) < 2.0, "{} by night, {} by day", sky(-9.0), sky(40.0));
}
